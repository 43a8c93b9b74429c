//! What can go wrong with a picture, said so that its owner can mend it: which file, what was expected, what was found.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use crate::format::Format;

/// An error with the path of the file it is about, where there is one.
#[derive(Debug)]
pub struct ImageError {
    path: Option<PathBuf>,
    kind: ErrorKind,
}

/// The causes of an [`ImageError`].
#[derive(Debug)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The file could not be read.
    Read(io::Error),
    /// The file could not be written.
    Write(io::Error),
    /// The name's ending stands for no picture format that is written here.
    UnknownEnding,
    /// The bytes are of no known picture format; the first of them are kept, and the name of the format where it is
    /// one that is known but not read.
    NotAPicture {
        /// The first bytes, at most 16.
        first: Vec<u8>,
        /// A foreign format that begins so.
        foreign: Option<&'static str>,
    },
    /// The file breaks its format's rules or ends too soon.
    Corrupt(Format, String),
    /// The file follows its format, in a variant that is not read here.
    Unsupported(Format, String),
    /// More samples than [`limits`](crate::limits) lets pass.
    TooLarge {
        /// Columns.
        width: u64,
        /// Rows.
        height: u64,
        /// Numbers a pixel.
        channels: u64,
    },
    /// The format cannot hold a picture of this kind.
    CannotHold(Format, String),
    /// The pieces do not fit together: a data length, channel names, the sizes of two pictures.
    Mismatch(String),
}

impl ImageError {
    /// The cause.
    pub fn kind(&self) -> &ErrorKind {
        &self.kind
    }

    /// The file concerned.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// The same error, naming the file.
    #[must_use]
    pub fn at(mut self, path: &Path) -> Self {
        self.path = Some(path.to_owned());
        self
    }
}

impl From<ErrorKind> for ImageError {
    fn from(kind: ErrorKind) -> Self {
        ImageError { path: None, kind }
    }
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(path) = &self.path {
            write!(f, "{}: ", path.display())?;
        }
        match &self.kind {
            ErrorKind::Read(e) => write!(f, "cannot be read: {e}"),
            ErrorKind::Write(e) => write!(f, "cannot be written: {e}"),
            ErrorKind::UnknownEnding => {
                let path = self.path.as_deref().unwrap_or(Path::new(""));
                match path.extension() {
                    Some(ending) => write!(f, "`.{}` is no picture format written here", ending.to_string_lossy())?,
                    None => write!(f, "the name has no ending to tell the picture format by")?,
                }
                write!(f, "; known endings: {}", Format::list(Format::can_write))
            }
            ErrorKind::NotAPicture { first, foreign } => {
                let expected = Format::list(|_| true);
                match foreign {
                    Some(name) => write!(f, "is {name}, which is not read here; expected one of {expected}"),
                    None if first.is_empty() => write!(f, "is empty; expected a picture: {expected}"),
                    None => write!(f, "is no picture: it begins with {}; expected one of {expected}", Glimpse(first)),
                }
            }
            ErrorKind::Corrupt(format, what) => write!(f, "is a broken {} file: {what}", format.name()),
            ErrorKind::Unsupported(format, what) => write!(f, "is {} with {what}, which is not read here", format.name()),
            ErrorKind::TooLarge { width, height, channels } => write!(
                f,
                "a picture of {width} x {height} pixels with {channels} channels needs {} of memory; the limit is {} a side and {}",
                Amount(width.saturating_mul(*height).saturating_mul(*channels).saturating_mul(4)),
                crate::limits::MAX_SIDE,
                Amount(crate::limits::MAX_SAMPLES * 4),
            ),
            ErrorKind::CannotHold(format, what) => write!(f, "{} cannot hold {what}", format.name()),
            ErrorKind::Mismatch(what) => f.write_str(what),
        }
    }
}

impl std::error::Error for ImageError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match &self.kind {
            ErrorKind::Read(e) | ErrorKind::Write(e) => Some(e),
            _ => None,
        }
    }
}

/// The first bytes of a file: as text where they are text, else in hexadecimal.
struct Glimpse<'a>(&'a [u8]);

impl fmt::Display for Glimpse<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = |b: &u8| b.is_ascii_graphic() || b.is_ascii_whitespace();
        if self.0.iter().all(text) {
            return write!(f, "{:?}", String::from_utf8_lossy(self.0));
        }
        f.write_str("the bytes")?;
        self.0.iter().try_for_each(|b| write!(f, " {b:02x}"))
    }
}

/// A number of bytes for people.
struct Amount(u64);

impl fmt::Display for Amount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let units = ["bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"];
        let step = (self.0.max(1).ilog2() / 10).min(6) as usize;
        match step {
            0 => write!(f, "{} bytes", self.0),
            _ => write!(f, "{:.1} {}", self.0 as f64 / 1024f64.powi(step as i32), units[step]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_the_file_and_the_figure() {
        let e = ImageError::from(ErrorKind::TooLarge { width: 2_147_483_300, height: 4, channels: 3 });
        let text = e.at(Path::new("ein Bild.exr")).to_string();
        assert!(text.starts_with("ein Bild.exr: "), "{text}");
        assert!(text.contains("2147483300 x 4") && text.contains("96.0 GiB"), "{text}");
        let e = ImageError::from(ErrorKind::UnknownEnding).at(Path::new("a.gif")).to_string();
        assert!(e.contains("`.gif`") && e.contains("exr") && e.contains("png"), "{e}");
        let first = b"<scene ".to_vec();
        let e = ImageError::from(ErrorKind::NotAPicture { first, foreign: None }).to_string();
        assert!(e.contains("\"<scene \""), "{e}");
    }
}
