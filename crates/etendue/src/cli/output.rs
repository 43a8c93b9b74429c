//! The one place that prints.

use etendue::LoadError;
use etendue_description::{Description, Diagnostics};
use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether a progress bar stands in the terminal's last line.
static BAR: AtomicBool = AtomicBool::new(false);

/// Says whether a progress bar stands in the last line, which messages must wipe first.
pub fn bar_is_shown(shown: bool) {
    BAR.store(shown, Ordering::Relaxed);
}

/// A result, on standard output. A reader that has gone away (`| head`) wants no more, and that is no error.
pub fn result(text: &str) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

/// A message, on standard error.
pub fn message(text: &str) {
    let wipe = if BAR.load(Ordering::Relaxed) { "\r\x1b[2K" } else { "" };
    let _ = writeln!(std::io::stderr(), "{wipe}{}", text.trim_end());
}

/// An error in words, on standard error. Words that name a place come with their own `error:`.
pub fn error(words: &str) {
    if words.contains("error: ") || words.contains("error\x1b") {
        message(words);
    } else {
        message(&format!("error: {words}"));
    }
}

/// Warnings and notes of a scene that loads, on standard error.
pub fn diagnostics(diagnostics: &Diagnostics, description: &Description) {
    if !diagnostics.is_empty() {
        message(&rendered(diagnostics, description));
    }
}

/// The words of a scene that does not load.
pub fn load_error(error: &LoadError) -> String {
    match error {
        LoadError::Scene(told) => rendered(&told.1, &told.0),
        other => other.to_string(),
    }
}

fn rendered(diagnostics: &Diagnostics, description: &Description) -> String {
    let coloured = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    let sources = &description.sources;
    if coloured { diagnostics.render_coloured(sources) } else { diagnostics.render(sources) }
}
