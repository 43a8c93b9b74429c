//! JPEG [ITU-T T.81]: grey, colour, and the four inks of printers; baseline or progressive. Values are sRGB of 8 bits.
//!
//! The decoder was chosen for its chroma: it interpolates subsampled chroma with one rounding, so that a texture's mean colour
//! is kept to a tenth of a code value; decoders that round twice shift red and blue by a third of one.

use jpeg_decoder::{Decoder, PixelFormat};

use crate::codec::{displayed, image, simple};
use crate::colour::{Depth, Encoding};
use crate::error::ErrorKind;
use crate::format::Format;
use crate::image::Picture;
use crate::limits;

fn broken(e: impl std::fmt::Display) -> ErrorKind {
    ErrorKind::Corrupt(Format::Jpeg, e.to_string())
}

/// Reads a picture.
pub(crate) fn decode(bytes: &[u8]) -> Result<Picture, ErrorKind> {
    let refuse = |e: jpeg_decoder::Error| match e {
        jpeg_decoder::Error::Unsupported(what) => ErrorKind::Unsupported(Format::Jpeg, format!("{what:?}")),
        e => broken(e),
    };
    let mut decoder = Decoder::new(bytes);
    decoder.read_info().map_err(refuse)?;
    let info = decoder.info().ok_or_else(|| broken("the size is missing"))?;
    let (width, height) = (usize::from(info.width), usize::from(info.height));
    let channels = if matches!(info.pixel_format, PixelFormat::L8 | PixelFormat::L16) { 1 } else { 3 };
    limits::samples(width as u64, height as u64, channels as u64)?;
    decoder.set_max_decoding_buffer_size(4 * limits::MAX_SAMPLES as usize);
    let raw = decoder.decode().map_err(refuse)?;
    let unit = |b: u8| f32::from(b) / 255.0;
    let mut encoding = Encoding::SRGB;
    let data = match info.pixel_format {
        PixelFormat::L8 | PixelFormat::RGB24 => raw.iter().map(|&b| unit(b)).collect(),
        PixelFormat::L16 => {
            encoding.depth = Depth::Unorm16;
            raw.chunks_exact(2).map(|b| f32::from(u16::from_ne_bytes([b[0], b[1]])) / 65_535.0).collect()
        }
        // What an ink and the black let through of the paper's white.
        PixelFormat::CMYK32 => {
            raw.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]].map(|c| unit(255 - c) * unit(255 - p[3]))).collect()
        }
    };
    Ok(image(width, height, channels, data, encoding)?.into())
}

/// Writes a picture as sRGB; see [`displayed`]. Alpha is left out, colours are not subsampled from quality 90 on.
pub(crate) fn encode(picture: &Picture, quality: u8) -> Result<Vec<u8>, ErrorKind> {
    let image = displayed(&simple(&picture.image, Format::Jpeg, false)?);
    let side = |n: usize| {
        u16::try_from(n).map_err(|_| ErrorKind::CannotHold(Format::Jpeg, format!("{n} pixels a side: 65535 is the most")))
    };
    let (width, height) = (side(image.width())?, side(image.height())?);
    let raw: Vec<u8> = image.data().iter().map(|v| (v * 255.0).round() as u8).collect();
    let colour = if image.channel_count() == 1 { jpeg_encoder::ColorType::Luma } else { jpeg_encoder::ColorType::Rgb };
    let mut out = Vec::new();
    let encoder = jpeg_encoder::Encoder::new(&mut out, quality.clamp(1, 100));
    encoder.encode(&raw, width, height, colour).map_err(|e| ErrorKind::CannotHold(Format::Jpeg, format!("this picture: {e}")))?;
    Ok(out)
}
