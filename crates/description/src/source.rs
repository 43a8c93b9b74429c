//! Where a word stands: files, byte ranges, lines and columns.

use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A file among the [`Sources`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SourceId(pub u32);

/// A byte range of one file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Span {
    /// The file.
    pub source: SourceId,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

/// A value and the place where it was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// Its place.
    pub span: Span,
}

impl<T> Spanned<T> {
    /// `value`, written at `span`.
    pub fn new(value: T, span: Span) -> Self {
        Self { value, span }
    }
}

/// Every text that a description was read from.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    files: Vec<Source>,
}

/// One text, or a piece of one.
#[derive(Clone, Debug)]
struct Source {
    path: PathBuf,
    text: Arc<str>,
    /// The number of the text's first line in its file, from 1.
    first_line: usize,
    /// Where another file named this one.
    parent: Option<Span>,
}

impl Sources {
    /// Adds a text under the path that messages shall name.
    pub fn add(&mut self, path: impl Into<PathBuf>, text: impl Into<Arc<str>>) -> SourceId {
        self.push(path.into(), text.into(), 1, None)
    }

    /// Adds a text that another one includes at `parent`; messages tell the chain.
    pub fn add_included(&mut self, path: impl Into<PathBuf>, text: impl Into<Arc<str>>, parent: Span) -> SourceId {
        self.push(path.into(), text.into(), 1, Some(parent))
    }

    /// Adds a few lines of a file too large to keep, the first of which is line `first_line` of the file, counted from 1.
    pub fn add_excerpt(&mut self, path: impl Into<PathBuf>, text: impl Into<Arc<str>>, first_line: usize) -> SourceId {
        self.push(path.into(), text.into(), first_line, None)
    }

    fn push(&mut self, path: PathBuf, text: Arc<str>, first_line: usize, parent: Option<Span>) -> SourceId {
        self.files.push(Source { path, text, first_line, parent });
        SourceId(self.files.len() as u32 - 1)
    }

    /// The path of a file.
    pub fn path(&self, id: SourceId) -> &Path {
        &self.files[id.0 as usize].path
    }

    /// The text of a file.
    pub fn text(&self, id: SourceId) -> &str {
        &self.files[id.0 as usize].text
    }

    /// The text of a file, to keep.
    pub fn shared_text(&self, id: SourceId) -> Arc<str> {
        self.files[id.0 as usize].text.clone()
    }

    /// Where another file includes this one.
    pub fn parent(&self, id: SourceId) -> Option<Span> {
        self.files[id.0 as usize].parent
    }

    /// Line and column of a byte, both from 1; the column counts characters.
    pub fn line_column(&self, source: SourceId, byte: u32) -> (usize, usize) {
        let (line, start) = self.line_start(source, byte);
        let text = self.text(source);
        let at = floor_char_boundary(text, byte as usize);
        (line, text[start..at].chars().count() + 1)
    }

    /// The number of the line that holds a byte, from 1, and the line's first byte in [`Sources::text`].
    pub fn line_start(&self, source: SourceId, byte: u32) -> (usize, usize) {
        let text = self.text(source);
        let before = &text.as_bytes()[..floor_char_boundary(text, byte as usize)];
        let start = before.iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
        let line = self.files[source.0 as usize].first_line + before.iter().filter(|&&b| b == b'\n').count();
        (line, start)
    }

    /// `path:line:column` of a place.
    pub fn place(&self, span: Span) -> String {
        let (line, column) = self.line_column(span.source, span.start);
        format!("{}:{line}:{column}", self.path(span.source).display())
    }

    /// The number of files.
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// Whether nothing has been read.
    pub fn is_empty(&self) -> bool {
        self.files.is_empty()
    }
}

/// The last character boundary at or before `at`.
pub(crate) fn floor_char_boundary(text: &str, at: usize) -> usize {
    let mut at = at.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters_and_lines_count_from_the_excerpt() {
        let mut sources = Sources::default();
        let id = sources.add("a.xml", "één\nzwei drei\n");
        assert_eq!(sources.line_column(id, 0), (1, 1));
        assert_eq!(sources.line_column(id, 2), (1, 2));
        assert_eq!(sources.line_column(id, 4), (1, 3));
        assert_eq!(sources.line_column(id, 11), (2, 6));
        assert_eq!(sources.line_column(id, 999), (3, 1));
        let piece = sources.add_excerpt("big.obj", "v 0 0 nan", 4711);
        assert_eq!(sources.place(Span { source: piece, start: 6, end: 9 }), "big.obj:4711:7");
    }
}
