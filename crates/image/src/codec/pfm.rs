//! Portable float map [Debevec, netpbm's pfm(5)]: `PF` (colour) or `Pf` (grey), width, height, a scale whose sign tells
//! the byte order (negative: low byte first) and whose size multiplies the values; then rows of f32, the lowest first.

use crate::bytes::Bytes;
use crate::codec::{image, simple};
use crate::colour::Encoding;
use crate::error::ErrorKind;
use crate::format::Format;
use crate::image::Picture;
use crate::limits;

fn broken(what: impl Into<String>) -> ErrorKind {
    ErrorKind::Corrupt(Format::Pfm, what.into())
}

/// Reads a picture.
pub(crate) fn decode(bytes: &[u8]) -> Result<Picture, ErrorKind> {
    let mut rest = Bytes(bytes);
    let mark = word(&mut rest)?;
    let channels = match mark {
        "PF" => 3,
        "Pf" => 1,
        _ => return Err(broken(format!("it begins with {mark:?} in place of PF or Pf"))),
    };
    let [width, height] = [word(&mut rest)?, word(&mut rest)?];
    let side = |s: &str| s.parse::<u64>().map_err(|_| broken(format!("{s:?} is no size")));
    let (width, height) = (side(width)?, side(height)?);
    let scale_word = word(&mut rest)?;
    let scale: f32 = scale_word.parse().map_err(|_| broken(format!("{scale_word:?} is no scale")))?;
    if scale == 0.0 || !scale.is_finite() {
        return Err(broken(format!("the scale is {scale}")));
    }
    let n = limits::samples(width, height, channels as u64)?;
    if rest.0.len() < 4 * n {
        return Err(broken(format!("{width} x {height} pixels need {} bytes, {} follow the header", 4 * n, rest.0.len())));
    }
    let (width, height) = (width as usize, height as usize);
    let mut data = limits::zeros(width, height, channels)?;
    let row_length = width * channels;
    for (row, source) in data.chunks_exact_mut(row_length).rev().zip(rest.0.chunks_exact(4 * row_length)) {
        for (v, b) in row.iter_mut().zip(source.chunks_exact(4)) {
            let b = [b[0], b[1], b[2], b[3]];
            *v = scale.abs() * if scale < 0.0 { f32::from_le_bytes(b) } else { f32::from_be_bytes(b) };
        }
    }
    Ok(image(width, height, channels, data, Encoding::LINEAR)?.into())
}

/// The next word of the header; one white space after it is eaten.
fn word<'a>(rest: &mut Bytes<'a>) -> Result<&'a str, ErrorKind> {
    let start = rest.0.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(0);
    let length =
        rest.0[start..].iter().take(64).position(u8::is_ascii_whitespace).ok_or_else(|| broken("the header ends too soon"))?;
    let word = &rest.0[start..start + length];
    rest.0 = &rest.0[start + length + 1..];
    std::str::from_utf8(word).map_err(|_| broken("the header is no text"))
}

/// Writes a picture: colour or grey, low byte first, alpha left out.
pub(crate) fn encode(picture: &Picture) -> Result<Vec<u8>, ErrorKind> {
    let image = simple(&picture.image, Format::Pfm, false)?.into_linear();
    let mark = if image.channel_count() == 3 { "PF" } else { "Pf" };
    let mut out = format!("{mark}\n{} {}\n-1.0\n", image.width(), image.height()).into_bytes();
    for row in image.data().chunks_exact(image.width() * image.channel_count()).rev() {
        out.extend(row.iter().flat_map(|v| v.to_le_bytes()));
    }
    Ok(out)
}
