//! Finished pixels: pictures, codecs, tone mapping, error metrics.
//!
//! The film hands over an [`Image`]; this crate writes it, reads it back, shows it on a display and says how far it is
//! from another. Texture loaders come here too.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | L, a pixel of a render | [`Image`] with [`Transfer::Linear`] | W/(m² sr), linear Rec.709 |
//! | sRGB code value | [`Image`] with [`Transfer::Srgb`] | 1, in \[0, 1\] |
//! | E, exposure | [`ToneMap::exposure`] | EV: the light is scaled by 2ᴱ |
//! | relMSE, FLIP, … | [`Comparison`] | 1 |
//!
//! A reader keeps what the file says: [`load`] gives raw values together with their [`Encoding`], and
//! [`Image::to_linear`] turns those into linear Rec.709 where a colour is meant. Pixels run from the top row to the
//! bottom row, in each row from left to right, channels interleaved.
//!
//! ```
//! use etendue_image::{Curve, Image, Picture, SaveOptions, ToneMap};
//! # let folder = tempfile::tempdir().unwrap();
//! # let path = |name: &str| folder.path().join(name);
//! let grey = Image::rgb(2, 1, vec![0.18, 0.18, 0.18, 4.0, 4.0, 4.0])?;
//! etendue_image::save(&path("grey.exr"), &Picture::from(grey.clone()), &SaveOptions::default())?;
//! let shown = ToneMap { exposure: 0.0, curve: Curve::Agx }.image(&grey);
//! etendue_image::save(&path("grey.png"), &shown.into(), &SaveOptions::default())?;
//! assert_eq!(etendue_image::load(&path("grey.exr"))?.data(), grey.data());
//! # Ok::<(), etendue_image::ImageError>(())
//! ```

pub mod atomic;
mod bytes;
mod codec;
pub mod colour;
pub mod error;
pub mod flip;
pub mod format;
pub mod image;
pub mod limits;
pub mod metrics;
pub mod tone;

pub use atomic::write_atomically;
pub use colour::{Depth, Encoding, Primaries, Transfer, linear_to_srgb, luminance, srgb_to_linear};
pub use error::{ErrorKind, ImageError};
pub use format::{ExrSamples, Format, PngDepth, SaveOptions, decode, encode, load, load_picture, save};
pub use image::{Image, Layer, Picture};
pub use metrics::{Comparison, compare};
pub use tone::{Curve, ToneMap};
