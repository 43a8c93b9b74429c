//! The codecs, a file each: `decode(bytes) → Picture`, `encode(&Picture, …) → bytes`. Files are none of their business.

pub(crate) mod bmp;
pub(crate) mod exr;
pub(crate) mod hdr;
pub(crate) mod jpeg;
pub(crate) mod pfm;
pub(crate) mod png;
pub(crate) mod tga;

use crate::colour::{Encoding, Transfer, linear_to_srgb};
use crate::error::ErrorKind;
use crate::format::Format;
use crate::image::Image;

/// The picture as sRGB code values, for the codecs that hold what a display shows: linear light is encoded, anything
/// outside of [0, 1] clipped, what is no number black.
pub(crate) fn displayed(image: &Image) -> Image {
    let srgb = image.encoding().transfer == Transfer::Srgb;
    let mut shown = if srgb { image.clone() } else { image.to_linear() };
    let (n, alpha) = (shown.channel_count(), shown.channel("A"));
    for (i, v) in shown.data_mut().iter_mut().enumerate() {
        let code = if srgb || Some(i % n) == alpha { *v } else { linear_to_srgb(*v) };
        *v = if code.is_nan() { 0.0 } else { code.clamp(0.0, 1.0) };
    }
    shown.with_encoding(Encoding::SRGB)
}

/// The colour or grey channels and alpha, in the order of the simple formats: RGB, RGBA, Y or YA.
pub(crate) fn simple(image: &Image, format: Format, alpha: bool) -> Result<Image, ErrorKind> {
    let name = |c: &'static str| image.channel(c).map(|i| (i, c));
    let mut places = match (name("R"), name("G"), name("B"), name("Y")) {
        (Some(r), Some(g), Some(b), _) => vec![r, g, b],
        (_, _, _, Some(y)) => vec![y],
        _ if image.channel_count() == 1 => vec![(0, "Y")],
        _ => {
            let names = image.channels().join(", ");
            return Err(ErrorKind::CannotHold(format, format!("channels {names}: it takes R, G, B or Y")));
        }
    };
    places.extend(name("A").filter(|_| alpha));
    let as_is =
        places.len() == image.channel_count() && places.iter().enumerate().all(|(i, p)| p.0 == i && image.channels()[i] == p.1);
    Ok(if as_is { image.clone() } else { image.pick(&places) })
}

/// The usual names of `n` interleaved channels.
pub(crate) fn names(n: usize) -> &'static [&'static str] {
    match n {
        1 => &["Y"],
        2 => &["Y", "A"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    }
}

/// A finished image, or the word that says why not.
pub(crate) fn image(width: usize, height: usize, channels: usize, data: Vec<f32>, encoding: Encoding) -> Result<Image, ErrorKind> {
    let image = Image::from_data(width, height, names(channels), data).map_err(|e| ErrorKind::Mismatch(e.to_string()))?;
    Ok(image.with_encoding(encoding))
}
