//! Asking an element for its attributes; what nobody asked for is a mistake.

use super::text::Text;
use super::{File, Reader};
use crate::xml::{self, ElementId};
use etendue_description::{Span, nearest};

/// The attributes of one element.
pub(super) struct Attributes {
    /// The element's name.
    pub element: String,
    /// The place of that name.
    pub span: Span,
    entries: Vec<Entry>,
    asked: Vec<&'static str>,
    missing: Vec<&'static str>,
}

struct Entry {
    name: String,
    name_span: Span,
    /// `None` where a parameter in it is not known, which has been told.
    text: Option<Text>,
    used: bool,
}

impl Attributes {
    /// The attributes of an element, with parameters put in.
    pub fn new(reader: &mut Reader, file: &File, id: ElementId) -> Self {
        let element = file.document.element(id);
        let mut entries = Vec::new();
        for attribute in file.document.attributes(id) {
            let (value, exact) = attribute.text(&file.text);
            let span = file.span(&attribute.value);
            let mut text = Text { value: value.into_owned(), span, exact, origins: Vec::new() };
            let sound = reader.parameters.substitute(&mut text, &mut reader.diagnostics);
            let name = xml::slice(&file.text, &attribute.name).to_owned();
            entries.push(Entry { name, name_span: file.span(&attribute.name), text: sound.then_some(text), used: false });
        }
        let name = xml::slice(&file.text, &element.name).to_owned();
        Self { element: name, span: file.span(&element.name), entries, asked: Vec::new(), missing: Vec::new() }
    }

    /// Whether the element has the attribute. Does not count as asking.
    pub fn has(&self, name: &str) -> bool {
        self.entries.iter().any(|e| e.name == name)
    }

    /// An attribute that may be missing.
    pub fn optional(&mut self, name: &'static str) -> Option<Text> {
        self.asked.push(name);
        let entry = self.entries.iter_mut().find(|e| e.name == name)?;
        entry.used = true;
        entry.text.clone()
    }

    /// An attribute that must be there.
    pub fn required(&mut self, name: &'static str) -> Option<Text> {
        if !self.has(name) {
            self.missing.push(name);
        }
        self.optional(name)
    }

    /// Ends the questions: tells what is missing and what is unknown.
    pub fn finish(self, reader: &mut Reader) {
        let unknown = || self.entries.iter().filter(|e| !e.used);
        for entry in unknown() {
            let text = format!("unknown attribute `{}` of `<{}>`", entry.name, self.element);
            let error = reader.diagnostics.error(entry.name_span, text);
            match nearest(&entry.name, self.asked.iter().copied()) {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None => error.help(format!("known are: {}", self.asked.join(", "))),
            };
        }
        for name in self.missing {
            // Where it is there and misspelt, one message is enough.
            if !unknown().any(|e| nearest(&e.name, [name]).is_some()) {
                reader.diagnostics.error(self.span, format!("`<{}>` lacks the attribute `{name}`", self.element));
            }
        }
    }
}
