//! Errors and warnings with their places, told all in one go.

use crate::source::{Sources, Span};
use std::fmt::Write as _;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing; the picture is what the file asks for.
    Note,
    /// The picture may differ from what the file asks for.
    Warning,
    /// No picture.
    Error,
}

/// One message.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong, in one line, naming the word at fault.
    pub message: String,
    /// Where.
    pub span: Option<Span>,
    /// What to do about it: the nearest known name, the range allowed.
    pub help: Vec<String>,
}

/// The messages so far.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
}

impl Diagnostics {
    /// Adds an error; more can be said about it by the reference that is returned.
    pub fn error(&mut self, span: impl Into<Option<Span>>, message: impl Into<String>) -> &mut Diagnostic {
        self.push(Severity::Error, span.into(), message.into())
    }

    /// Adds a warning.
    pub fn warning(&mut self, span: impl Into<Option<Span>>, message: impl Into<String>) -> &mut Diagnostic {
        self.push(Severity::Warning, span.into(), message.into())
    }

    /// Adds a note.
    pub fn note(&mut self, span: impl Into<Option<Span>>, message: impl Into<String>) -> &mut Diagnostic {
        self.push(Severity::Note, span.into(), message.into())
    }

    fn push(&mut self, severity: Severity, span: Option<Span>, message: String) -> &mut Diagnostic {
        self.list.push(Diagnostic { severity, message, span, help: Vec::new() });
        let last = self.list.len() - 1;
        &mut self.list[last]
    }

    /// Whether any error was told.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|d| d.severity == Severity::Error)
    }

    /// All messages, in the order in which they were found.
    pub fn iter(&self) -> impl Iterator<Item = &Diagnostic> {
        self.list.iter()
    }

    /// Appends the messages of another list.
    pub fn append(&mut self, mut other: Self) {
        self.list.append(&mut other.list);
    }

    /// Whether nothing was told.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Plain text, a message each as `file:line:col: error: message`.
    pub fn render(&self, sources: &Sources) -> String {
        let mut out = String::new();
        for d in &self.list {
            let kind = match d.severity {
                Severity::Note => "note",
                Severity::Warning => "warning",
                Severity::Error => "error",
            };
            if let Some(span) = d.span {
                let (line, column) = sources.line_column(span.source, span.start);
                let _ = write!(out, "{}:{line}:{column}: ", sources.path(span.source).display());
            }
            let _ = writeln!(out, "{kind}: {}", d.message);
            for help in &d.help {
                let _ = writeln!(out, "  help: {help}");
            }
        }
        out
    }
}

impl Diagnostic {
    /// Says what to do about it.
    pub fn help(&mut self, text: impl Into<String>) -> &mut Self {
        self.help.push(text.into());
        self
    }

    /// Names the known word that is nearest to `word`, if one is near.
    pub fn suggest<'a>(&mut self, word: &str, known: impl IntoIterator<Item = &'a str>) -> &mut Self {
        if let Some(near) = nearest(word, known) {
            self.help.push(format!("did you mean `{near}`?"));
        }
        self
    }
}

/// The known word nearest to `word` by edit distance, if it is near enough to be what was meant.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = word.to_lowercase();
    known
        .into_iter()
        .map(|k| (strsim::damerau_levenshtein(&lower, &k.to_lowercase()), k))
        .filter(|(distance, k)| *distance <= 1 + k.chars().count().max(word.chars().count()) / 3)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, k)| k)
}
