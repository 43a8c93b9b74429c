//! XML as scene files use it: elements with attributes, and the byte range of every word.
//!
//! The tree is kept flat, so that a file of any depth costs no stack, and every name and value knows its exact place in the file.
//! The parser goes on after a mistake where it can (a missing quote, a tag that is never closed, a stray closing tag), so that
//! all mistakes of a file are told in one go; whatever it could not make sense of is left out of the tree. Document type
//! definitions are refused: scene files have none, and entities that expand to entities can fill any memory.
//!
//! Source: Extensible Markup Language (XML) 1.0, fifth edition, W3C 2008.

mod attributes;
mod parse;

pub use parse::{MAX_DEPTH, parse};

use std::borrow::Cow;
use std::ops::Range;

/// A document: its elements in document order, the root first.
#[derive(Debug, Default)]
pub struct Document {
    root: Option<ElementId>,
    elements: Vec<Element>,
    attributes: Vec<Attribute>,
}

/// An element among the [`Document`]'s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ElementId(u32);

/// A start tag, its attributes, and its place in the tree.
#[derive(Debug)]
pub struct Element {
    /// Bytes of the name.
    pub name: Range<u32>,
    /// Bytes of the start tag, from `<` to `>`.
    pub tag: Range<u32>,
    /// One past the element's last byte.
    pub end: u32,
    attributes: Range<u32>,
    first_child: Option<ElementId>,
    next_sibling: Option<ElementId>,
    /// Bytes of the first text that is not blank among the children.
    pub stray_text: Option<Range<u32>>,
}

/// `name="value"`.
#[derive(Debug)]
pub struct Attribute {
    /// Bytes of the name.
    pub name: Range<u32>,
    /// Bytes of the value as it is written, without the quotes.
    pub value: Range<u32>,
    /// The value with its character references resolved, where it has any.
    decoded: Option<Box<str>>,
}

impl Attribute {
    /// The value; the second word tells whether it is, byte for byte, what the file says.
    pub fn text<'t>(&'t self, source: &'t str) -> (Cow<'t, str>, bool) {
        match &self.decoded {
            Some(text) => (Cow::Borrowed(text), false),
            None => (Cow::Borrowed(slice(source, &self.value)), true),
        }
    }
}

impl Document {
    /// The outermost element.
    pub fn root(&self) -> Option<ElementId> {
        self.root
    }

    /// An element.
    pub fn element(&self, id: ElementId) -> &Element {
        &self.elements[id.0 as usize]
    }

    /// The attributes of an element, in file order.
    pub fn attributes(&self, id: ElementId) -> &[Attribute] {
        let range = &self.element(id).attributes;
        &self.attributes[range.start as usize..range.end as usize]
    }

    /// The elements directly inside an element, in file order.
    pub fn children(&self, id: ElementId) -> impl Iterator<Item = ElementId> {
        std::iter::successors(self.element(id).first_child, |child| self.element(*child).next_sibling)
    }
}

/// The text of a byte range.
pub fn slice<'t>(source: &'t str, range: &Range<u32>) -> &'t str {
    &source[range.start as usize..range.end as usize]
}
