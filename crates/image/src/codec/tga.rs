//! Truevision TGA [Truevision 1991]: palette (1), colour (2), grey (3), and the same run-length coded (9, 10, 11); 8,
//! 15, 16, 24 or 32 bits, from any corner. Read only. The format has no mark at its start, so files go by their name.

use crate::bytes::Bytes;
use crate::codec::image;
use crate::colour::Encoding;
use crate::error::ErrorKind;
use crate::format::Format;
use crate::image::Picture;
use crate::limits;

fn broken(what: impl Into<String>) -> ErrorKind {
    ErrorKind::Corrupt(Format::Tga, what.into())
}

/// Whether the first bytes can be a TGA header.
pub(crate) fn plausible(bytes: &[u8]) -> bool {
    bytes.len() >= 18 && bytes[1] <= 1 && matches!(bytes[2], 1..=3 | 9..=11) && matches!(bytes[16], 8 | 15 | 16 | 24 | 32)
}

/// Reads a picture.
pub(crate) fn decode(bytes: &[u8]) -> Result<Picture, ErrorKind> {
    let mut rest = Bytes(bytes);
    let h: [u8; 18] = rest.array().map_err(broken)?;
    let word = |i: usize| u16::from_le_bytes([h[i], h[i + 1]]);
    let (kind, bits, alpha_bits) = (h[2], h[16], h[17] & 15);
    let (width, height) = (usize::from(word(12)), usize::from(word(14)));
    rest.take(usize::from(h[0])).map_err(broken)?;
    let palette = if h[1] == 1 { read_palette(&mut rest, usize::from(word(3)), usize::from(word(5)), h[7])? } else { None };
    let (colour_bits, size) = match (kind & 7, &palette) {
        (1, Some(p)) if bits == 8 || bits == 16 => (p.bits, usize::from(bits / 8)),
        (1, _) => return Err(broken("a picture of palette colours needs a palette and 8 or 16 bits")),
        (3, _) if bits == 8 || bits == 16 => (bits, usize::from(bits / 8)),
        (2, _) if bits > 8 => (bits, usize::from(bits).div_ceil(8)),
        _ => return Err(ErrorKind::Unsupported(Format::Tga, format!("type {kind} and {bits} bits a pixel"))),
    };
    let grey = kind & 7 == 3;
    // Many writers leave the count of alpha bits at 0 in pictures whose fourth byte is no alpha either.
    let channels = match (grey, colour_bits, alpha_bits) {
        (true, 8, _) => 1,
        (true, ..) => 2,
        (false, 32, 1..) => 4,
        _ => 3,
    };
    let n = limits::samples(width as u64, height as u64, channels as u64)? / channels;
    if n as u64 > rest.0.len() as u64 * 128 {
        return Err(broken("the file ends too soon"));
    }
    let mut data = limits::zeros(width, height, channels)?;
    let pixels = if kind >= 9 { run_lengths(&mut rest, n, size)? } else { rest.take(n * size).map_err(broken)?.to_vec() };
    for (i, source) in pixels.chunks_exact(size).enumerate() {
        let source = match &palette {
            Some(p) if kind & 7 == 1 => p.colour(source).ok_or_else(|| broken("the palette is too short"))?,
            _ => source,
        };
        // Bit 4 of the last header byte: from the right. Bit 5: from the top.
        let (x, y) = (i % width, i / width);
        let x = if h[17] & 0x10 == 0 { x } else { width - 1 - x };
        let y = if h[17] & 0x20 == 0 { height - 1 - y } else { y };
        write_colour(&mut data[(y * width + x) * channels..][..channels], source, grey);
    }
    Ok(image(width, height, channels, data, Encoding::SRGB)?.into())
}

/// The colours of a palette, `size` bytes each, from place `first` on.
struct Palette<'a> {
    first: usize,
    bits: u8,
    bytes: &'a [u8],
}

fn read_palette<'a>(rest: &mut Bytes<'a>, first: usize, n: usize, bits: u8) -> Result<Option<Palette<'a>>, ErrorKind> {
    if !matches!(bits, 15 | 16 | 24 | 32) {
        return Err(ErrorKind::Unsupported(Format::Tga, format!("a palette of {bits} bits a colour")));
    }
    let bytes = rest.take(n * usize::from(bits).div_ceil(8)).map_err(broken)?;
    Ok(Some(Palette { first, bits, bytes }))
}

impl<'a> Palette<'a> {
    fn colour(&self, place: &[u8]) -> Option<&'a [u8]> {
        let place = place.iter().rev().fold(0usize, |v, &b| v << 8 | usize::from(b));
        let size = usize::from(self.bits).div_ceil(8);
        self.bytes.chunks_exact(size).nth(place.checked_sub(self.first)?)
    }
}

/// Packets of up to 128 pixels: one repeated (high bit set), or as many as there are.
fn run_lengths(rest: &mut Bytes<'_>, n: usize, size: usize) -> Result<Vec<u8>, ErrorKind> {
    let mut out = Vec::with_capacity(n * size);
    while out.len() < n * size {
        let head = rest.u8().map_err(broken)?;
        let count = usize::from(head & 127) + 1;
        if head & 128 == 0 {
            out.extend(rest.take(count * size).map_err(broken)?);
        } else {
            let pixel = rest.take(size).map_err(broken)?;
            (0..count).for_each(|_| out.extend(pixel));
        }
    }
    out.truncate(n * size);
    Ok(out)
}

/// One pixel, blue first in the file.
fn write_colour(pixel: &mut [f32], source: &[u8], grey: bool) {
    let unit = |b: u8| f32::from(b) / 255.0;
    match *source {
        [v] => pixel[0] = unit(v),
        [v, a] if grey => pixel.copy_from_slice(&[unit(v), unit(a)]),
        [low, high] => {
            let v = u16::from_le_bytes([low, high]);
            let five = |shift: u16| f32::from(v >> shift & 31) / 31.0;
            pixel.copy_from_slice(&[five(10), five(5), five(0)]);
        }
        [b, g, r] => pixel.copy_from_slice(&[r, g, b].map(unit)),
        [b, g, r, a] => pixel.copy_from_slice(&[r, g, b, a].map(unit)[..pixel.len()]),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(kind: u8, width: u16, height: u16, bits: u8, descriptor: u8) -> Vec<u8> {
        let mut h = vec![0, u8::from(kind & 7 == 1), kind, 0, 0, 2, 0, 24, 0, 0, 0, 0];
        h.extend([width.to_le_bytes(), height.to_le_bytes()].concat());
        h.extend([bits, descriptor]);
        h
    }

    #[test]
    fn runs_and_corners() {
        let mut file = header(10, 3, 1, 24, 0x20);
        file.extend([0x81, 0, 0, 255, 0x00, 255, 0, 0]);
        assert_eq!(decode(&file).unwrap().image.data(), [1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        let mut file = header(3, 2, 2, 8, 0x10);
        file.extend([255, 0, 0, 0]);
        assert_eq!(decode(&file).unwrap().image.data(), [0.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn palette_and_fifteen_bits() {
        let mut file = header(1, 2, 1, 8, 0x20);
        file.extend([0, 0, 0, 0, 255, 0, 1, 0]);
        assert_eq!(decode(&file).unwrap().image.data(), [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        let mut file = header(2, 1, 1, 16, 0x20);
        file.extend(0x7c00u16.to_le_bytes());
        assert_eq!(decode(&file).unwrap().image.data(), [1.0, 0.0, 0.0]);
        let mut file = header(1, 1, 1, 8, 0x20);
        file.extend([0, 0, 0, 0, 255, 0, 7]);
        assert!(decode(&file).is_err());
    }
}
