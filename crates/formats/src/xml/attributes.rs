//! The attributes of a tag, and what goes wrong with their quotes.

use super::Attribute;
use super::parse::Parser;
use std::ops::Range;

/// A tag may have this many attributes; scenes need half a dozen.
const MAX_ATTRIBUTES: usize = 64;

impl Parser<'_, '_> {
    /// Attributes to the end of the tag: whether the tag closes itself, and whether it made sense.
    pub(super) fn attributes(&mut self, first: usize) -> (bool, bool) {
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
    pub(super) fn check_doubles(&mut self, first: usize) {
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
