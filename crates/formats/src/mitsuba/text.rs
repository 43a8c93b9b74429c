//! The text of an attribute, its words and numbers, each with its place.

use etendue_description::{Diagnostic, Diagnostics, Span};
use std::ops::Range;

/// An attribute's value with its parameters put in.
#[derive(Clone, Debug)]
pub(super) struct Text {
    /// The value.
    pub value: String,
    /// Where it is written.
    pub span: Span,
    /// Whether it is what the file says, byte for byte, so that its words have places of their own.
    pub exact: bool,
    /// What stands behind the parameters in it, for messages.
    pub origins: Vec<String>,
}

impl Text {
    /// The place of some bytes of the value.
    pub fn place(&self, range: Range<usize>) -> Span {
        if !self.exact {
            return self.span;
        }
        let start = self.span.start + range.start as u32;
        Span { start, end: self.span.start + range.end as u32, ..self.span }
    }

    /// A mistake at some bytes of the value.
    pub fn error<'d>(&self, diagnostics: &'d mut Diagnostics, range: Range<usize>, message: String) -> &'d mut Diagnostic {
        let diagnostic = diagnostics.error(self.place(range), message);
        for origin in &self.origins {
            diagnostic.help(origin.clone());
        }
        diagnostic
    }

    /// A mistake of the value as a whole.
    pub fn mistake<'d>(&self, diagnostics: &'d mut Diagnostics, message: String) -> &'d mut Diagnostic {
        self.error(diagnostics, 0..self.value.len(), message)
    }

    /// The value without blanks around it, and its place.
    pub fn trimmed(&self) -> (&str, Range<usize>) {
        let word = self.value.trim();
        let start = word.as_ptr() as usize - self.value.as_ptr() as usize;
        (word, start..start + word.len())
    }

    /// The words, parted by blanks and commas.
    pub fn words(&self) -> impl Iterator<Item = (&str, Range<usize>)> {
        let base = self.value.as_ptr() as usize;
        self.value.split(|c: char| c == ',' || c.is_ascii_whitespace()).filter(|word| !word.is_empty()).map(move |word| {
            let start = word.as_ptr() as usize - base;
            (word, start..start + word.len())
        })
    }

    /// One number; infinite ones only where `finite` is false.
    pub fn float(&self, diagnostics: &mut Diagnostics, finite: bool) -> Option<f64> {
        let (word, range) = self.trimmed();
        if word.contains(',') && self.words().count() == 2 {
            self.error(diagnostics, range, format!("`{word}` is no number")).help("numbers are written with a point: 0.5");
            return None;
        }
        self.number(diagnostics, word, range, finite)
    }

    /// A list of finite numbers.
    pub fn floats(&self, diagnostics: &mut Diagnostics) -> Option<Vec<f64>> {
        let mut out = Vec::new();
        let mut sound = true;
        for (word, range) in self.words() {
            match self.number(diagnostics, word, range, true) {
                Some(x) => out.push(x),
                None => sound = false,
            }
        }
        sound.then_some(out)
    }

    /// A list of one or three numbers.
    pub fn one_or_three(&self, diagnostics: &mut Diagnostics) -> Option<[f64; 3]> {
        let numbers = self.floats(diagnostics)?;
        match numbers[..] {
            [x] => Some([x; 3]),
            [x, y, z] => Some([x, y, z]),
            _ => {
                self.mistake(diagnostics, format!("expected one number or three, found {}", numbers.len()));
                None
            }
        }
    }

    /// A number that stands at some bytes of the value.
    pub fn number(&self, diagnostics: &mut Diagnostics, word: &str, range: Range<usize>, finite: bool) -> Option<f64> {
        if word.is_empty() {
            self.mistake(diagnostics, "a number must stand here".to_owned());
            return None;
        }
        match word.parse::<f64>() {
            Ok(x) if x.is_nan() || (finite && x.is_infinite()) => {
                self.error(diagnostics, range, format!("`{word}` is not finite"));
                None
            }
            Ok(x) => Some(x),
            Err(_) => {
                self.error(diagnostics, range, format!("`{}` is no number", shortened(word)));
                None
            }
        }
    }

    /// A whole number.
    pub fn integer(&self, diagnostics: &mut Diagnostics) -> Option<i64> {
        let (word, range) = self.trimmed();
        match word.parse() {
            Ok(i) => Some(i),
            Err(_) => {
                self.error(diagnostics, range, format!("`{}` is no whole number", shortened(word)));
                None
            }
        }
    }

    /// `true` or `false`.
    pub fn boolean(&self, diagnostics: &mut Diagnostics) -> Option<bool> {
        let (word, range) = self.trimmed();
        match word.to_ascii_lowercase().as_str() {
            "true" => Some(true),
            "false" => Some(false),
            _ => {
                self.error(diagnostics, range, format!("`{}` is no truth value, expected true or false", shortened(word)));
                None
            }
        }
    }
}

/// A word short enough for a message.
pub(crate) fn shortened(word: &str) -> String {
    const LONGEST: usize = 60;
    if word.chars().count() <= LONGEST {
        return word.to_owned();
    }
    word.chars().take(LONGEST).chain("...".chars()).collect()
}
