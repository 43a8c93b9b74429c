//! Text into a [`Document`].

use super::{Attribute, Document, Element, ElementId};
use etendue_description::{Diagnostics, SourceId, Span};
use std::ops::Range;

/// Elements may be nested this deep; scenes need a dozen levels.
pub const MAX_DEPTH: usize = 128;
/// A tag may have this many attributes; scenes need half a dozen.
const MAX_ATTRIBUTES: usize = 64;
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

struct Parser<'t, 'd> {
    source: SourceId,
    text: &'t str,
    bytes: &'t [u8],
    at: usize,
    diagnostics: &'d mut Diagnostics,
    mistakes: usize,
    document: Document,
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

    /// Attributes to the end of the tag: whether the tag closes itself, and whether it made sense.
    fn attributes(&mut self, first: usize) -> (bool, bool) {
        let mut sound = true;
        loop {
            self.skip_blanks();
            if self.document.attributes.len() - first >= MAX_ATTRIBUTES {
                self.error(self.at..self.at + 1, format!("a tag with more than {MAX_ATTRIBUTES} attributes"));
                return (self.skip_tag(), false);
            }
            match self.bytes.get(self.at) {
                Some(b'>') => {
                    self.at += 1;
                    return (false, sound);
                }
                Some(b'/') if self.bytes.get(self.at + 1) == Some(&b'>') => {
                    self.at += 2;
                    return (true, sound);
                }
                None | Some(b'<') => {
                    let last = self.document.attributes[first..].last();
                    let at = last.map_or(self.at, |a| a.value.end as usize + 1);
                    self.error(at - 1..at, "the tag is not closed: `>` or `/>` is missing");
                    return (true, false);
                }
                Some(b'/') => {
                    self.error(self.at..self.at + 1, "`/` must be followed by `>`");
                    self.at += 1;
                    sound = false;
                }
                Some(_) => {
                    if !self.attribute() {
                        return (self.skip_tag(), false);
                    }
                }
            }
        }
    }

    /// One `name="value"`; false if the rest of the tag makes no sense.
    fn attribute(&mut self) -> bool {
        let name = self.name();
        if name.is_empty() {
            let width = self.text[self.at..].chars().next().map_or(0, char::len_utf8);
            self.error(self.at..self.at + width, "an attribute's name must stand here, such as `name=\"...\"`");
            return false;
        }
        self.skip_blanks();
        if self.bytes.get(self.at) != Some(&b'=') {
            let word = self.text[name.clone()].to_owned();
            self.error(name, format!("attribute `{word}` has no value")).help(format!("write {word}=\"...\""));
            return false;
        }
        self.at += 1;
        self.skip_blanks();
        let quote = match self.bytes.get(self.at) {
            Some(&q @ (b'"' | b'\'')) => q,
            _ => {
                let word = self.name();
                let text = self.text[name].to_owned();
                self.error(word, format!("the value of `{text}` must stand in quotes"));
                return false;
            }
        };
        self.at += 1;
        self.value(name, quote)
    }

    /// The value behind an opening quote, and the quote that ends it.
    fn value(&mut self, name: Range<usize>, quote: u8) -> bool {
        let start = self.at;
        let end = self.find(quote).unwrap_or(self.bytes.len());
        let written = &self.text[start..end];
        // A quote that is missing shows by what the value swallows: the next attribute, the tag's end, a tag.
        let after = self.bytes.get(end + 1).copied().unwrap_or(b' ');
        let swallowed_attribute = written.trim_end().ends_with('=') && !matches!(after, b' ' | b'\t' | b'\n' | b'\r' | b'/' | b'>');
        if end == self.bytes.len() || written.contains('<') || swallowed_attribute {
            let word = self.text[name.clone()].to_owned();
            let line = written.lines().next().unwrap_or("");
            let shown = line.find(['=', '>']).map_or(line.len(), |i| line[..i].trim_end_matches(['/', ' ']).len());
            self.error(start - 1..start + shown, format!("the value of `{word}` is missing its closing quote"));
            // The rest of the tag is beyond repair; go on behind its end.
            self.at = start;
            return false;
        }
        self.at = end + 1;
        let decoded = written.contains('&').then(|| self.decode(start, written).into_boxed_str());
        let range = |r: Range<usize>| r.start as u32..r.end as u32;
        self.document.attributes.push(Attribute { name: range(name), value: range(start..end), decoded });
        if !matches!(self.bytes.get(self.at), None | Some(b' ' | b'\t' | b'\n' | b'\r' | b'/' | b'>' | b'<' | b'?')) {
            let width = self.text[self.at..].chars().next().map_or(0, char::len_utf8);
            self.error(self.at..self.at + width, "a blank must stand between a value's closing quote and what follows");
            return false;
        }
        true
    }

    /// Character references: the five names of XML, decimal and hexadecimal numbers.
    fn decode(&mut self, start: usize, written: &str) -> String {
        let mut out = String::with_capacity(written.len());
        let mut rest = written;
        while let Some(i) = rest.find('&') {
            out.push_str(&rest[..i]);
            let at = start + (written.len() - rest.len()) + i;
            rest = &rest[i..];
            let end = rest.find(';').filter(|&e| e <= 10);
            let character = end.and_then(|end| reference(&rest[1..end]));
            match (end, character) {
                (Some(end), Some(c)) => {
                    out.push(c);
                    rest = &rest[end + 1..];
                }
                _ => {
                    let width = end.map_or(1, |e| e + 1);
                    let word = rest[..width].to_owned();
                    self.error(at..at + width, format!("`{word}` is no character reference"))
                        .help("a bare `&` is written `&amp;`; known are &lt; &gt; &amp; &quot; &apos; and &#number;");
                    out.push_str(&word);
                    rest = &rest[width..];
                }
            }
        }
        out.push_str(rest);
        out
    }

    /// An attribute may be given once; the first one stays.
    fn check_doubles(&mut self, first: usize) {
        let mut i = first;
        while i < self.document.attributes.len() {
            let name = self.document.attributes[i].name.clone();
            let word = super::slice(self.text, &name);
            let earlier = self.document.attributes[first..i].iter().find(|a| super::slice(self.text, &a.name) == word);
            let Some(earlier) = earlier.map(|a| a.name.clone()) else {
                i += 1;
                continue;
            };
            let earlier = self.span(earlier.start as usize..earlier.end as usize);
            self.error(name.start as usize..name.end as usize, format!("attribute `{word}` is given twice"))
                .label(earlier, "first given here");
            self.document.attributes.remove(i);
        }
    }

    /// Goes on behind the end of a tag that made no sense: whether it closes itself.
    fn skip_tag(&mut self) -> bool {
        let end = self.bytes[self.at..].iter().position(|&b| b == b'>').map_or(self.bytes.len(), |i| self.at + i);
        let closed = end > 0 && self.bytes[end - 1] == b'/';
        self.at = (end + 1).min(self.bytes.len());
        closed
    }

    fn name(&mut self) -> Range<usize> {
        let start = self.at;
        let ends = |b: u8| matches!(b, b' ' | b'\t' | b'\n' | b'\r' | b'=' | b'/' | b'>' | b'<' | b'"' | b'\'');
        self.at = self.bytes[start..].iter().position(|&b| ends(b)).map_or(self.bytes.len(), |i| start + i);
        start..self.at
    }

    fn skip_blanks(&mut self) {
        while matches!(self.bytes.get(self.at), Some(b' ' | b'\t' | b'\n' | b'\r')) {
            self.at += 1;
        }
    }

    fn find(&self, byte: u8) -> Option<usize> {
        memchr::memchr(byte, &self.bytes[self.at..]).map(|i| self.at + i)
    }

    fn span(&self, range: Range<usize>) -> Span {
        let end = range.end.min(self.bytes.len()) as u32;
        Span { source: self.source, start: range.start as u32, end }
    }

    fn error(&mut self, range: Range<usize>, message: impl Into<String>) -> &mut etendue_description::Diagnostic {
        self.mistakes += 1;
        let span = self.span(range);
        if self.mistakes > MAX_MISTAKES {
            self.unsaid = Diagnostics::default();
            return self.unsaid.error(span, message);
        }
        self.diagnostics.error(span, message)
    }
}

/// The character of a reference's inside.
fn reference(name: &str) -> Option<char> {
    match name {
        "lt" => Some('<'),
        "gt" => Some('>'),
        "amp" => Some('&'),
        "quot" => Some('"'),
        "apos" => Some('\''),
        _ => {
            let number = name.strip_prefix('#')?;
            let code = match number.strip_prefix('x') {
                Some(hex) => u32::from_str_radix(hex, 16).ok()?,
                None => number.parse().ok()?,
            };
            char::from_u32(code).filter(|&c| c != '\0')
        }
    }
}
