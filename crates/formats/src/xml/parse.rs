//! Text into a [`Document`].

use super::{Document, Element, ElementId};
use etendue_description::{Diagnostics, SourceId, Span};
use std::ops::Range;

/// Elements may be nested this deep; scenes need a dozen levels.
pub const MAX_DEPTH: usize = 128;
/// After so many mistakes the file is something else than XML.
const MAX_MISTAKES: usize = 50;

/// Reads the document of a source and tells every mistake.
pub fn parse(source: SourceId, text: &str, diagnostics: &mut Diagnostics) -> Document {
    let mut parser = Parser {
        source,
        text,
        bytes: text.as_bytes(),
        at: 0,
        diagnostics,
        mistakes: 0,
        document: Document::default(),
        open: Vec::new(),
        unsaid: Diagnostics::default(),
    };
    parser.run();
    parser.document
}

pub(super) struct Parser<'t, 'd> {
    source: SourceId,
    pub(super) text: &'t str,
    pub(super) bytes: &'t [u8],
    pub(super) at: usize,
    diagnostics: &'d mut Diagnostics,
    mistakes: usize,
    pub(super) document: Document,
    open: Vec<Open>,
    /// Where messages go once there are too many.
    unsaid: Diagnostics,
}

/// An element whose closing tag has not come yet.
struct Open {
    id: ElementId,
    last_child: Option<ElementId>,
}

/// The parser cannot go on.
struct Stop;

type Step<T> = Result<T, Stop>;

impl Parser<'_, '_> {
    fn run(&mut self) {
        if self.content().is_ok() {
            self.finish();
        }
        let end = self.bytes.len() as u32;
        for open in self.open.drain(..) {
            self.document.elements[open.id.0 as usize].end = end;
        }
    }

    /// Tags, comments and text to the end of the file.
    fn content(&mut self) -> Step<()> {
        while self.at < self.bytes.len() {
            if self.mistakes >= MAX_MISTAKES {
                self.diagnostics.note(self.span(self.at..self.at), "too many mistakes, the rest of the file was not read");
                return Err(Stop);
            }
            match self.bytes[self.at] {
                b'<' => self.markup()?,
                _ => self.characters(),
            }
        }
        Ok(())
    }

    /// Says what is missing at the end of the file.
    fn finish(&mut self) {
        if let Some(open) = self.open.last() {
            let element = &self.document.elements[open.id.0 as usize];
            let (name, tag) = (super::slice(self.text, &element.name).to_owned(), element.tag.clone());
            self.error(tag.start as usize..tag.end as usize, format!("`<{name}>` is never closed"))
                .help(format!("add `</{name}>`, or end the tag with `/>` if nothing belongs inside"));
        } else if self.document.elements.is_empty() && self.mistakes == 0 {
            self.error(0..0, "the file holds no XML element").help("a scene file begins with <scene version=\"3.0.0\">");
        }
    }

    /// Text between tags: blank, or remembered as stray.
    fn characters(&mut self) {
        let start = self.at;
        self.at = self.find(b'<').unwrap_or(self.bytes.len());
        let text = &self.text[start..self.at];
        let word = text.trim_matches(|c: char| c.is_ascii_whitespace() || c == '\u{feff}');
        if word.is_empty() {
            return;
        }
        let from = start + (word.as_ptr() as usize - text.as_ptr() as usize);
        let range = from..from + word.lines().next().unwrap_or("").trim_end().len();
        if let Some(open) = self.open.last() {
            let element = &mut self.document.elements[open.id.0 as usize];
            element.stray_text.get_or_insert(range.start as u32..range.end as u32);
        } else if self.document.elements.is_empty() {
            self.error(range, "this is not XML: a tag such as `<scene version=\"3.0.0\">` must come first");
        } else {
            self.error(range, "text after the end of the outermost element");
        }
    }

    /// Whatever begins with `<`.
    fn markup(&mut self) -> Step<()> {
        let start = self.at;
        let rest = &self.bytes[start..];
        if rest.starts_with(b"<!--") {
            self.skip_past("-->", "comment")
        } else if rest.starts_with(b"<![CDATA[") {
            self.skip_past("]]>", "CDATA section")
        } else if rest.starts_with(b"<?") {
            self.skip_past("?>", "processing instruction")
        } else if rest.starts_with(b"<!") {
            self.doctype()
        } else if rest.starts_with(b"</") {
            self.closing_tag();
            Ok(())
        } else {
            self.opening_tag()
        }
    }

    fn skip_past(&mut self, end: &str, what: &str) -> Step<()> {
        let start = self.at;
        match memchr::memmem::find(&self.bytes[start..], end.as_bytes()) {
            Some(i) => {
                self.at = start + i + end.len();
                Ok(())
            }
            None => {
                self.error(start..start + 4, format!("this {what} never ends")).help(format!("end it with `{end}`"));
                Err(Stop)
            }
        }
    }

    fn doctype(&mut self) -> Step<()> {
        let start = self.at;
        let end = self.find(b'>').unwrap_or(self.bytes.len());
        if self.bytes[start..end].contains(&b'[') {
            self.error(start..start + 2, "document type definitions are not read")
                .help("remove the `<!DOCTYPE ...>`; scene files need no entities of their own");
            return Err(Stop);
        }
        self.at = (end + 1).min(self.bytes.len());
        Ok(())
    }

    /// `</name>`.
    fn closing_tag(&mut self) {
        let start = self.at;
        self.at += 2;
        let name = self.name();
        let end = self.find(b'>').unwrap_or(self.bytes.len());
        let closes_here = self.text[name.end..end].trim().is_empty();
        self.at = if closes_here { (end + 1).min(self.bytes.len()) } else { name.end };
        let word = &self.text[name.clone()];
        if !closes_here || end == self.bytes.len() {
            self.error(start..name.end, format!("`>` is missing after `</{word}`"));
        }

        let opened = |open: &Open| &self.document.elements[open.id.0 as usize].name;
        match self.open.iter().rposition(|open| super::slice(self.text, opened(open)) == word) {
            None => {
                let nearest = self.open.last().map(|open| super::slice(self.text, opened(open)).to_owned());
                let message = format!("`</{word}>` closes nothing: no `<{word}>` is open here");
                let diagnostic = self.error(start..name.end, message);
                if let Some(nearest) = nearest {
                    diagnostic.help(format!("the innermost open element is `<{nearest}>`"));
                }
            }
            Some(i) => {
                // Whatever was opened inside and not closed is what is wrong; the innermost is enough to tell.
                if let Some(inner) = self.open.get(i + 1..).and_then(|inside| inside.last()) {
                    let element = &self.document.elements[inner.id.0 as usize];
                    let (inner_name, tag) = (super::slice(self.text, &element.name).to_owned(), element.tag.clone());
                    let close = self.span(start..name.end);
                    self.error(tag.start as usize..tag.end as usize, format!("`<{inner_name}>` is never closed"))
                        .label(close, format!("`</{word}>` comes first"))
                        .help(format!("end the tag with `/>`, or add `</{inner_name}>`"));
                }
                for open in self.open.drain(i..) {
                    self.document.elements[open.id.0 as usize].end = self.at as u32;
                }
            }
        }
    }

    /// `<name attribute="value" ...>` or the same with `/>`.
    fn opening_tag(&mut self) -> Step<()> {
        let start = self.at;
        self.at += 1;
        let name = self.name();
        if name.is_empty() {
            self.error(start..start + 1, "a tag's name must follow `<`").help("a bare `<` is written `&lt;`");
            return Ok(());
        }
        let first = self.document.attributes.len();
        let (closed, sound) = self.attributes(first);
        let tag = start as u32..self.at as u32;
        if sound {
            self.check_doubles(first);
        } else {
            self.document.attributes.truncate(first);
        }

        if self.open.is_empty() && !self.document.elements.is_empty() {
            self.error(name.clone(), "a second outermost element; a file holds one");
        }
        let id = ElementId(self.document.elements.len() as u32);
        self.document.elements.push(Element {
            name: name.start as u32..name.end as u32,
            end: tag.end,
            tag,
            attributes: first as u32..self.document.attributes.len() as u32,
            first_child: None,
            next_sibling: None,
            stray_text: None,
        });
        // Half a tag stays outside of the tree: it would only earn further messages about what it lacks.
        if sound {
            self.link(id);
        }
        if !closed {
            if self.open.len() >= MAX_DEPTH {
                self.error(start..name.end, format!("elements are nested more than {MAX_DEPTH} deep"));
                return Err(Stop);
            }
            self.open.push(Open { id, last_child: None });
        }
        Ok(())
    }

    /// Hangs an element into the tree behind its elder sibling.
    fn link(&mut self, id: ElementId) {
        let elder = match self.open.last_mut() {
            Some(parent) => {
                let elder = parent.last_child.replace(id);
                if elder.is_none() {
                    self.document.elements[parent.id.0 as usize].first_child = Some(id);
                }
                elder
            }
            None => {
                self.document.root.get_or_insert(id);
                None
            }
        };
        if let Some(elder) = elder {
            self.document.elements[elder.0 as usize].next_sibling = Some(id);
        }
    }

    pub(super) fn name(&mut self) -> Range<usize> {
        let start = self.at;
        let ends = |b: u8| matches!(b, b' ' | b'\t' | b'\n' | b'\r' | b'=' | b'/' | b'>' | b'<' | b'"' | b'\'');
        self.at = self.bytes[start..].iter().position(|&b| ends(b)).map_or(self.bytes.len(), |i| start + i);
        start..self.at
    }

    pub(super) fn skip_blanks(&mut self) {
        while matches!(self.bytes.get(self.at), Some(b' ' | b'\t' | b'\n' | b'\r')) {
            self.at += 1;
        }
    }

    pub(super) fn find(&self, byte: u8) -> Option<usize> {
        memchr::memchr(byte, &self.bytes[self.at..]).map(|i| self.at + i)
    }

    pub(super) fn span(&self, range: Range<usize>) -> Span {
        let end = range.end.min(self.bytes.len()) as u32;
        Span { source: self.source, start: range.start as u32, end }
    }

    pub(super) fn error(&mut self, range: Range<usize>, message: impl Into<String>) -> &mut etendue_description::Diagnostic {
        self.mistakes += 1;
        let span = self.span(range);
        if self.mistakes > MAX_MISTAKES {
            self.unsaid = Diagnostics::default();
            return self.unsaid.error(span, message);
        }
        self.diagnostics.error(span, message)
    }
}
