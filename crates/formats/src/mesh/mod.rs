//! Triangle meshes and voxel grids out of files: one file a format.
//!
//! Readers take bytes and give a [`Loaded`] or say what is wrong and where: line and column in texts, a byte in binary files. No
//! number of a header is trusted before the data that it promises have been seen to be there.

mod attributes;
pub mod finish;
pub mod obj;
pub mod ply;
pub mod serialized;
pub mod vol;

use etendue_description::MeshData;
use std::ops::Range;

/// A mesh, and what should be said about it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Loaded {
    /// The mesh; its path is empty.
    pub mesh: MeshData,
    /// What the file has that a picture may show, or that was left out.
    pub warnings: Vec<String>,
}

/// What is wrong with a file.
#[derive(Clone, Debug, PartialEq)]
pub struct FileError {
    /// What, in one line.
    pub message: String,
    /// Where.
    pub place: Place,
}

/// A place in a file that is too large to keep.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A byte of a binary file, from 0.
    Byte(u64),
    /// A word of a text.
    Line {
        /// The line, from 1.
        number: usize,
        /// What stands there, without the line's end.
        text: String,
        /// The bytes of the word within `text`.
        word: Range<usize>,
    },
}

impl FileError {
    /// A mistake of the file as a whole.
    pub fn file(message: impl Into<String>) -> Self {
        Self { message: message.into(), place: Place::File }
    }

    /// A mistake at a byte of a binary file.
    pub fn byte(at: usize, message: impl Into<String>) -> Self {
        Self { message: message.into(), place: Place::Byte(at as u64) }
    }

    /// A mistake at bytes of a text.
    pub fn text(bytes: &[u8], word: Range<usize>, message: impl Into<String>) -> Self {
        let start = memchr::memrchr(b'\n', &bytes[..word.start]).map_or(0, |i| i + 1);
        let number = memchr::memchr_iter(b'\n', &bytes[..start]).count() + 1;
        let end = memchr::memchr(b'\n', &bytes[word.start..]).map_or(bytes.len(), |i| word.start + i);
        let line = bytes[start..end].strip_suffix(b"\r").unwrap_or(&bytes[start..end]);
        // Lossy text moves bytes about, so the three parts are turned one by one.
        const LONGEST: usize = 500;
        let cut = |part: &[u8]| String::from_utf8_lossy(&part[..part.len().min(LONGEST)]).into_owned();
        let (from, to) = ((word.start - start).min(line.len()), (word.end - start).min(line.len()));
        let before = cut(&line[..from]);
        let within = cut(&line[from..to.max(from)]);
        let range = before.len()..before.len() + within.len();
        Self {
            message: message.into(),
            place: Place::Line { number, text: before + &within + &cut(&line[to.max(from)..]), word: range },
        }
    }
}

/// The longest list of mistakes told of one file.
pub(crate) const MAX_MISTAKES: usize = 20;
