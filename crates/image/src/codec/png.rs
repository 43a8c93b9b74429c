//! PNG [ISO/IEC 15948:2003]: grey, colour or palette, 1 to 16 bits, alpha, interlaced or not.
//!
//! The file's own word on its transfer function holds: an `sRGB` chunk, else `gAMA` (1 is linear, about 1/2.2 is taken for
//! sRGB, as the standard asks of files for displays), else sRGB. `cHRM` gives the primaries where no `sRGB` chunk does.

use std::io::Cursor;

use png::{BitDepth, ColorType, Limits, Transformations};

use crate::codec::{displayed, image, simple};
use crate::colour::{Depth, Encoding, Primaries, Transfer};
use crate::error::ErrorKind;
use crate::format::{Format, PngDepth};
use crate::image::Picture;
use crate::limits;

fn broken(e: impl std::fmt::Display) -> ErrorKind {
    ErrorKind::Corrupt(Format::Png, e.to_string())
}

/// Reads a picture.
pub(crate) fn decode(bytes: &[u8]) -> Result<Picture, ErrorKind> {
    // The codec's own limit counts its buffers only; ours is applied before the pixels are.
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: 1 << 30 });
    decoder.set_transformations(Transformations::EXPAND);
    let (width, height) = decoder.read_header_info().map_err(broken)?.size();
    limits::samples(u64::from(width), u64::from(height), 1)?;
    let mut reader = decoder.read_info().map_err(broken)?;
    let (colour, depth) = reader.output_color_type();
    let samples = limits::samples(u64::from(width), u64::from(height), colour.samples() as u64)?;
    if samples as u64 > 8 * bytes.len() as u64 * limits::DENSEST {
        return Err(broken("the file ends too soon"));
    }
    let mut raw = vec![0; reader.output_buffer_size().ok_or_else(|| broken("the size is out of range"))?];
    let encoding = encoding(reader.info(), depth);
    reader.next_frame(&mut raw).map_err(broken)?;
    let data = match depth {
        BitDepth::Sixteen => raw.chunks_exact(2).map(|b| f32::from(u16::from_be_bytes([b[0], b[1]])) / 65_535.0).collect(),
        _ => raw.iter().map(|&b| f32::from(b) / 255.0).collect(),
    };
    let mut picture = Picture::from(image(width as usize, height as usize, colour.samples(), data, encoding)?);
    let info = reader.info();
    let latin = info.uncompressed_latin1_text.iter().map(|t| (t.keyword.clone(), t.text.clone()));
    let unicode = info.utf8_text.iter().filter_map(|t| Some((t.keyword.clone(), t.get_text().ok()?)));
    picture.attributes = latin.chain(unicode).collect();
    Ok(picture)
}

/// What the chunks before the pixels say.
fn encoding(info: &png::Info<'_>, depth: BitDepth) -> Encoding {
    let depth = if depth == BitDepth::Sixteen { Depth::Unorm16 } else { Depth::Unorm8 };
    let srgb = Encoding { depth, ..Encoding::SRGB };
    if info.srgb.is_some() || info.icc_profile.is_some() {
        return srgb;
    }
    let transfer = match info.gama_chunk.map(|g| g.into_value()) {
        Some(g) if (g - 1.0).abs() < 0.01 => Transfer::Linear,
        Some(g) if g > 0.1 && (g - 1.0 / 2.2).abs() > 0.01 => Transfer::Gamma(1.0 / g),
        _ => Transfer::Srgb,
    };
    let primaries = info.chrm_chunk.map_or(Primaries::REC709, |c| {
        let point = |(x, y): (png::ScaledFloat, png::ScaledFloat)| [x.into_value(), y.into_value()];
        Primaries { r: point(c.red), g: point(c.green), b: point(c.blue), w: point(c.white) }
    });
    Encoding { transfer, primaries, depth }
}

/// Writes a picture as sRGB; see [`displayed`].
pub(crate) fn encode(picture: &Picture, depth: PngDepth) -> Result<Vec<u8>, ErrorKind> {
    let image = displayed(&simple(&picture.image, Format::Png, true)?);
    let cannot = |e: png::EncodingError| ErrorKind::CannotHold(Format::Png, format!("this picture: {e}"));
    let side = |n: usize| u32::try_from(n).map_err(|_| ErrorKind::CannotHold(Format::Png, format!("{n} pixels a side")));
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, side(image.width())?, side(image.height())?);
    encoder.set_color(match image.channel_count() {
        1 => ColorType::Grayscale,
        2 => ColorType::GrayscaleAlpha,
        3 => ColorType::Rgb,
        _ => ColorType::Rgba,
    });
    encoder.set_depth(if depth == PngDepth::Eight { BitDepth::Eight } else { BitDepth::Sixteen });
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    for (name, text) in &picture.attributes {
        // Keywords are Latin-1 of 1 to 79 letters; what is none stays out of the file.
        if (1..80).contains(&name.chars().count()) && name.chars().all(|c| c.is_ascii_graphic() || c == ' ') {
            encoder.add_itxt_chunk(name.clone(), text.clone()).map_err(cannot)?;
        }
    }
    let raw: Vec<u8> = match depth {
        PngDepth::Eight => image.data().iter().map(|v| (v * 255.0).round() as u8).collect(),
        PngDepth::Sixteen => image.data().iter().flat_map(|v| ((v * 65_535.0).round() as u16).to_be_bytes()).collect(),
    };
    let mut writer = encoder.write_header().map_err(cannot)?;
    writer.write_image_data(&raw).map_err(cannot)?;
    writer.finish().map_err(cannot)?;
    Ok(out)
}
