//! Scenes in a word, and what is said about them in a line each.
#![allow(dead_code)]

use etendue_description::{Description, Diagnostics};
use etendue_formats::{ReadOptions, read_str};

/// Options with files on no disk.
pub fn with_files(files: &[(&str, &[u8])]) -> ReadOptions {
    let mut options = ReadOptions::default();
    for (path, bytes) in files {
        options.files.insert(path.into(), (*bytes).into());
    }
    options
}

/// A scene of version 3 around `body`, which begins in line 1.
pub fn scene(body: &str) -> String {
    format!("<scene version=\"3.0.0\">{body}</scene>")
}

/// Every message as `path:line:column severity: message | help | help`.
pub fn lines((description, diagnostics): &(Description, Diagnostics)) -> Vec<String> {
    let line = |d: &etendue_description::Diagnostic| {
        let place = d.span.map(|span| format!("{} ", description.sources.place(span))).unwrap_or_default();
        let help: String = d.help.iter().map(|h| format!(" | {h}")).collect();
        format!("{place}{}: {}{help}", d.severity.name(), d.message)
    };
    // Rendering must work for every message.
    assert_eq!(diagnostics.is_empty(), diagnostics.render(&description.sources).is_empty());
    diagnostics.iter().map(line).collect()
}

/// What is said about a text read as `s.xml`.
pub fn said(text: &str) -> Vec<String> {
    lines(&read_str("s.xml", text, &ReadOptions::default()))
}

/// The word that the first message points at.
pub fn word((description, diagnostics): &(Description, Diagnostics)) -> String {
    let span = diagnostics.iter().next().and_then(|d| d.span).expect("a message with a place");
    description.sources.text(span.source)[span.start as usize..span.end as usize].to_owned()
}

/// Reads a scene that must have no mistakes.
pub fn good(text: &str, options: &ReadOptions) -> Description {
    let result = read_str("s.xml", text, options);
    assert_eq!(lines(&result), Vec::<String>::new());
    result.0
}
