//! OpenEXR [Kainz, Bogart 2020, the file layout]. [`decode`] and [`encode`] are the two halves.

mod read;
mod write;

pub(crate) use read::decode;
pub(crate) use write::encode;

use crate::error::ErrorKind;
use crate::format::Format;

fn broken(e: impl std::fmt::Display) -> ErrorKind {
    ErrorKind::Corrupt(Format::Exr, e.to_string())
}
