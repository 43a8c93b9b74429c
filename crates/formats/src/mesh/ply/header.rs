//! The header of a PLY file: its encoding, its elements and their properties.

use crate::mesh::FileError;
use std::ops::Range;

/// How the numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    fn of(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "long" | "int64" => Self::I64,
            "ulong" | "uint64" => Self::U64,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes in a binary file.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

/// One number of an element, or a list of them.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub name: String,
    pub scalar: Scalar,
    /// The type of the count, for a list.
    pub list: Option<Scalar>,
}

/// A table of the file.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

impl Element {
    /// Bytes of a row in a binary file, if all rows are alike.
    pub fn stride(&self) -> Option<usize> {
        self.properties.iter().map(|p| if p.list.is_some() { None } else { Some(p.scalar.size()) }).sum()
    }

    /// The least number of bytes of a row.
    pub fn least(&self, encoding: Encoding) -> usize {
        let binary = |p: &Property| p.list.unwrap_or(p.scalar).size();
        match encoding {
            Encoding::Ascii => self.properties.len() * 2,
            _ => self.properties.iter().map(binary).sum(),
        }
    }
}

#[derive(Debug)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Where the data begin.
    pub end: usize,
}

/// Reads the header.
pub(super) fn parse(bytes: &[u8]) -> Result<Header, FileError> {
    if !bytes.starts_with(b"ply") || !matches!(bytes.get(3), Some(b'\n' | b'\r' | b' ')) {
        return Err(FileError::file("the file does not begin with `ply`"));
    }
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut at = 0;
    loop {
        let Some(length) = memchr::memchr(b'\n', &bytes[at..]) else {
            return Err(FileError::file("the header never ends: `end_header` is missing"));
        };
        let range = at..at + length;
        at = range.end + 1;
        let fail = |message: String| FileError::text(bytes, range.clone(), message);
        let Ok(line) = std::str::from_utf8(&bytes[range.clone()]) else {
            if matches!(bytes[range.start..].first(), Some(b'c' | b'o')) {
                continue; // a comment in another encoding
            }
            return Err(fail("the header is no text".to_owned()));
        };
        let words: Vec<&str> = line.split_ascii_whitespace().take(6).collect();
        match words.as_slice() {
            [] | ["ply"] | ["comment" | "obj_info", ..] => {}
            ["format", word, version] => {
                let known = match *word {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::LittleEndian,
                    "binary_big_endian" => Encoding::BigEndian,
                    _ => {
                        let known = "ascii, binary_little_endian or binary_big_endian";
                        return Err(word_error(bytes, &range, word, format!("`{word}` is no PLY format, expected {known}")));
                    }
                };
                if *version != "1.0" {
                    return Err(word_error(bytes, &range, version, format!("PLY version `{version}` is not known, expected 1.0")));
                }
                encoding = Some(known);
            }
            ["element", name, count] => {
                let Ok(count) = count.parse() else {
                    return Err(word_error(bytes, &range, count, format!("`{count}` is no count")));
                };
                elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new() });
            }
            ["property", "list", count, scalar, name] => {
                let (count, scalar) = (scalar_of(bytes, &range, count)?, scalar_of(bytes, &range, scalar)?);
                push(&mut elements, name, scalar, Some(count)).map_err(&fail)?;
            }
            ["property", scalar, name] => {
                let scalar = scalar_of(bytes, &range, scalar)?;
                push(&mut elements, name, scalar, None).map_err(&fail)?;
            }
            ["end_header"] => break,
            [first, ..] => return Err(fail(format!("`{first}` line not understood in a PLY header"))),
        }
    }
    let encoding = encoding.ok_or_else(|| FileError::file("the header has no `format` line"))?;
    Ok(Header { encoding, elements, end: at })
}

fn push(elements: &mut [Element], name: &str, scalar: Scalar, list: Option<Scalar>) -> Result<(), String> {
    let Some(element) = elements.last_mut() else { return Err("a property must follow an `element` line".to_owned()) };
    if element.properties.iter().any(|p| p.name == name) {
        return Err(format!("element `{}` has property `{name}` twice", element.name));
    }
    if element.properties.len() >= 1000 {
        return Err("an element with more than 1000 properties".to_owned());
    }
    element.properties.push(Property { name: name.to_owned(), scalar, list });
    Ok(())
}

fn scalar_of(bytes: &[u8], line: &Range<usize>, word: &str) -> Result<Scalar, FileError> {
    Scalar::of(word)
        .ok_or_else(|| word_error(bytes, line, word, format!("`{word}` is no PLY type, expected float, int, uchar, ...")))
}

/// A mistake at a word, which is a part of the file's bytes.
fn word_error(bytes: &[u8], line: &Range<usize>, word: &str, message: String) -> FileError {
    let at = (word.as_ptr() as usize).saturating_sub(bytes.as_ptr() as usize).clamp(line.start, line.end);
    FileError::text(bytes, at..at + word.len(), message)
}
