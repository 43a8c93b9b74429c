//! Errors and warnings with their places, told all in one go.

use crate::source::{Sources, Span};

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

impl Severity {
    /// The word before a message.
    pub fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
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
    /// Other places that matter, each with a few words: where a thing was first given, where a file was named.
    pub labels: Vec<(Span, String)>,
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
        self.list.push(Diagnostic { severity, message, span, labels: Vec::new(), help: Vec::new() });
        let last = self.list.len() - 1;
        &mut self.list[last]
    }

    /// Whether any error was told.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|d| d.severity == Severity::Error)
    }

    /// The number of messages of a severity.
    pub fn count(&self, severity: Severity) -> usize {
        self.list.iter().filter(|d| d.severity == severity).count()
    }

    /// All messages, in the order in which they were found.
    pub fn iter(&self) -> impl Iterator<Item = &Diagnostic> {
        self.list.iter()
    }

    /// Appends the messages of another list.
    pub fn append(&mut self, mut other: Self) {
        self.list.append(&mut other.list);
    }

    /// Appends those messages of another list that this one does not hold.
    pub fn append_new(&mut self, other: Self) {
        for d in other.list {
            if !self.list.contains(&d) {
                self.list.push(d);
            }
        }
    }

    /// Whether nothing was told.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Plain text: a message each as `file:line:col: error: message`, the source line with the word marked, and help.
    pub fn render(&self, sources: &Sources) -> String {
        crate::render::render(self.iter(), sources, false)
    }

    /// As [`Diagnostics::render`], with the colours of a terminal.
    pub fn render_coloured(&self, sources: &Sources) -> String {
        crate::render::render(self.iter(), sources, true)
    }
}

impl Diagnostic {
    /// Says what to do about it.
    pub fn help(&mut self, text: impl Into<String>) -> &mut Self {
        self.help.push(text.into());
        self
    }

    /// Shows another place that matters.
    pub fn label(&mut self, span: Span, text: impl Into<String>) -> &mut Self {
        self.labels.push((span, text.into()));
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
    // A word longer than any name cannot be near one, and the distance costs the product of the lengths.
    const LONGEST: usize = 200;
    if word.len() > LONGEST {
        return None;
    }
    let lower = word.to_lowercase();
    known
        .into_iter()
        .filter(|k| k.len() <= LONGEST)
        .map(|k| (strsim::damerau_levenshtein(&lower, &k.to_lowercase()), k))
        .filter(|(distance, k)| *distance <= 1 + k.chars().count().max(word.chars().count()) / 3)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, k)| k)
}
