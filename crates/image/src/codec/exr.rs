//! OpenEXR [Kainz, Bogart 2020, the file layout]. [`decode`] and [`encode`] are the two halves.

mod read;
mod subsampled;
mod write;

pub(crate) use write::encode;

use crate::error::ErrorKind;
use crate::format::Format;
use crate::image::Picture;

fn broken(e: impl std::fmt::Display) -> ErrorKind {
    ErrorKind::Corrupt(Format::Exr, e.to_string())
}

/// Reads a picture with its layers and its string attributes.
///
/// The library's decoders of B44 and of mip-map tiles assert what a damaged file need not hold, so a panic of theirs
/// is caught here and told as what it is, a broken file.
pub(crate) fn decode(bytes: &[u8]) -> Result<Picture, ErrorKind> {
    std::panic::catch_unwind(|| read::decode(bytes)).unwrap_or_else(|_| Err(broken("its blocks contradict its header")))
}
