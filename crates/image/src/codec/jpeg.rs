//! JPEG [ITU-T T.81]: grey, colour, and the four inks of printers; baseline or progressive. Values are sRGB of 8 bits.

use std::io::Cursor;

use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::codec::{displayed, image, simple};
use crate::colour::Encoding;
use crate::error::ErrorKind;
use crate::format::Format;
use crate::image::Picture;
use crate::limits;

fn broken(e: impl std::fmt::Display) -> ErrorKind {
    ErrorKind::Corrupt(Format::Jpeg, e.to_string())
}

/// Reads a picture.
pub(crate) fn decode(bytes: &[u8]) -> Result<Picture, ErrorKind> {
    let options = DecoderOptions::default().set_max_width(1 << 16).set_max_height(1 << 16).set_use_unsafe(false);
    let mut decoder = JpegDecoder::new_with_options(Cursor::new(bytes), options);
    decoder.decode_headers().map_err(broken)?;
    let grey = decoder.input_colorspace() == Some(ColorSpace::Luma);
    let (width, height) = decoder.dimensions().ok_or_else(|| broken("the size is missing"))?;
    let channels = if grey { 1 } else { 3 };
    limits::samples(width as u64, height as u64, channels as u64)?;
    let out = if grey { ColorSpace::Luma } else { ColorSpace::RGB };
    decoder.set_options(options.jpeg_set_out_colorspace(out));
    let raw = decoder.decode().map_err(broken)?;
    let data = raw.iter().map(|&b| f32::from(b) / 255.0).collect();
    Ok(image(width, height, channels, data, Encoding::SRGB)?.into())
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
