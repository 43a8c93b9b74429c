//! The one place that prints.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "the program's voice")]

use etendue::LoadError;
use etendue_description::{Description, Diagnostics};
use std::io::IsTerminal;

/// A result, on standard output.
pub fn result(text: &str) {
    println!("{text}");
}

/// A message, on standard error.
pub fn message(text: &str) {
    eprintln!("{text}");
}

/// An error in words, on standard error. Words that name a place come with their own `error:`.
pub fn error(words: &str) {
    if words.contains("error: ") || words.contains("error[") {
        eprintln!("{}", words.trim_end());
    } else {
        eprintln!("error: {}", words.trim_end());
    }
}

/// Warnings and notes of a scene that loads, on standard error.
pub fn diagnostics(diagnostics: &Diagnostics, description: &Description) {
    if !diagnostics.is_empty() {
        eprint!("{}", rendered(diagnostics, description));
    }
}

/// The words of a scene that does not load.
pub fn load_error(error: &LoadError) -> String {
    match error {
        LoadError::NoSuchScene(words) => words.clone(),
        LoadError::Scene(description, diagnostics) => rendered(diagnostics, description),
    }
}

fn rendered(diagnostics: &Diagnostics, description: &Description) -> String {
    let coloured = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    let sources = &description.sources;
    if coloured { diagnostics.render_coloured(sources) } else { diagnostics.render(sources) }
}
