//! Windows bitmap [Microsoft, BITMAPINFOHEADER]: 1, 4, 8 bits with a palette (plain or run-length coded), 16 and 32
//! bits with masks, 24 bits. Rows are padded to four bytes and usually run upwards. Read only.

use crate::bytes::Bytes;
use crate::codec::image;
use crate::colour::Encoding;
use crate::error::ErrorKind;
use crate::format::Format;
use crate::image::Picture;
use crate::limits;

fn broken(what: impl Into<String>) -> ErrorKind {
    ErrorKind::Corrupt(Format::Bmp, what.into())
}

fn ended<T>(r: Result<T, crate::bytes::Ended>) -> Result<T, ErrorKind> {
    r.map_err(broken)
}

/// The two headers' fields that matter.
struct Header {
    width: usize,
    height: usize,
    upwards: bool,
    bits: u16,
    compression: u32,
    masks: [u32; 4],
    palette: Vec<[u8; 3]>,
    start: usize,
}

/// Reads a picture.
pub(crate) fn decode(bytes: &[u8]) -> Result<Picture, ErrorKind> {
    let header = read_header(bytes)?;
    let pixels = bytes.get(header.start..).ok_or_else(|| broken("the pixels start after the end of the file"))?;
    let alpha = header.masks[3] != 0;
    let channels = if alpha { 4 } else { 3 };
    limits::samples(header.width as u64, header.height as u64, channels as u64)?;
    let mut data = if header.palette.is_empty() { direct(&header, pixels, channels)? } else { indexed(&header, pixels)? };
    if header.upwards {
        let row = header.width * channels;
        for y in 0..header.height / 2 {
            let (top, bottom) = data.split_at_mut((header.height - 1 - y) * row);
            top[y * row..(y + 1) * row].swap_with_slice(&mut bottom[..row]);
        }
    }
    Ok(image(header.width, header.height, channels, data, Encoding::SRGB)?.into())
}

fn read_header(bytes: &[u8]) -> Result<Header, ErrorKind> {
    let mut rest = Bytes(bytes);
    ended(rest.take(10))?;
    let start = ended(rest.u32())? as usize;
    let size = ended(rest.u32())? as usize;
    if size != 12 && size < 40 {
        return Err(broken(format!("a header of {size} bytes is unknown")));
    }
    let old = size == 12;
    let (width, height) =
        if old { (i32::from(ended(rest.u16())?), i32::from(ended(rest.u16())?)) } else { (ended(rest.i32())?, ended(rest.i32())?) };
    ended(rest.u16())?;
    let bits = ended(rest.u16())?;
    let (mut compression, mut colours) = (0, 0);
    if !old {
        compression = ended(rest.u32())?;
        ended(rest.take(12))?;
        colours = ended(rest.u32())?;
        ended(rest.u32())?;
    }
    if width <= 0 || height == 0 {
        return Err(broken(format!("the size is {width} x {height}")));
    }
    limits::samples(width as u64, u64::from(height.unsigned_abs()), 3)?;
    let after = Bytes(bytes.get(14 + size..).ok_or_else(|| broken("the file ends too soon"))?);
    let masks = masks(bits, compression, size, rest, after)?;
    let palette = if bits <= 8 {
        let entry = if old { 3 } else { 4 };
        let most = 1usize << bits;
        let n = if colours == 0 { most } else { most.min(colours as usize) };
        after.0.chunks_exact(entry).take(n).map(|c| [c[2], c[1], c[0]]).collect()
    } else {
        Vec::new()
    };
    if bits <= 8 && palette.is_empty() {
        return Err(broken("the palette is missing"));
    }
    let (width, rows) = (width as usize, height.unsigned_abs() as usize);
    Ok(Header { width, height: rows, upwards: height > 0, bits, compression, masks, palette, start })
}

/// The bits of red, green, blue and alpha in a pixel of 16, 24 or 32 bits; and which combinations are read at all.
fn masks<'a>(bits: u16, compression: u32, size: usize, mut inside: Bytes<'a>, mut after: Bytes<'a>) -> Result<[u32; 4], ErrorKind> {
    let eight = [0xff_0000, 0xff00, 0xff, 0];
    match (compression, bits) {
        (0, 1 | 4 | 8) | (1, 8) | (2, 4) => Ok([0; 4]),
        (0, 16) => Ok([0x7c00, 0x3e0, 0x1f, 0]),
        (0, 24 | 32) => Ok(eight),
        (3 | 6, 16 | 32) => {
            // From version 2 on the masks are part of the header; before, they follow it.
            let source = if size >= 52 { &mut inside } else { &mut after };
            let mut masks = [0; 4];
            let n = if size >= 56 || compression == 6 { 4 } else { 3 };
            for mask in &mut masks[..n] {
                *mask = ended(source.u32())?;
            }
            Ok(masks)
        }
        _ => Err(ErrorKind::Unsupported(Format::Bmp, format!("{bits} bits a pixel and compression {compression}"))),
    }
}

/// Pixels that hold their colour.
fn direct(header: &Header, pixels: &[u8], channels: usize) -> Result<Vec<f32>, ErrorKind> {
    let size = usize::from(header.bits / 8);
    let stride = (header.width * size).next_multiple_of(4);
    if (pixels.len() as u64) < (stride as u64) * (header.height as u64 - 1) + (header.width * size) as u64 {
        return Err(broken("the file ends too soon"));
    }
    let mut data = limits::zeros(header.width, header.height, channels)?;
    for (row, source) in data.chunks_exact_mut(header.width * channels).zip(pixels.chunks(stride)) {
        for (pixel, b) in row.chunks_exact_mut(channels).zip(source.chunks_exact(size)) {
            let value = b.iter().rev().fold(0u32, |v, &b| v << 8 | u32::from(b));
            for (c, &mask) in pixel.iter_mut().zip(&header.masks) {
                // A mask of n bits holds the fractions of 2ⁿ - 1.
                let shift = mask.trailing_zeros().min(31);
                *c = if mask == 0 { 0.0 } else { ((value & mask) >> shift) as f32 / (mask >> shift) as f32 };
            }
        }
    }
    Ok(data)
}

/// Pixels that hold places in a palette.
fn indexed(header: &Header, pixels: &[u8]) -> Result<Vec<f32>, ErrorKind> {
    let Header { width, height, bits, .. } = *header;
    let bits = usize::from(bits);
    let indices = if header.compression == 0 {
        let stride = (width * bits).div_ceil(8).next_multiple_of(4);
        if (pixels.len() as u64) < (stride as u64) * (height as u64 - 1) + (width * bits).div_ceil(8) as u64 {
            return Err(broken("the file ends too soon"));
        }
        let at = |row: &[u8], x: usize| row[x * bits / 8] >> (8 - bits - x * bits % 8) & (0xff >> (8 - bits)) as u8;
        pixels.chunks(stride).take(height).flat_map(|row| (0..width).map(move |x| at(row, x))).collect()
    } else {
        run_lengths(Bytes(pixels), width, height, bits == 4)?
    };
    let mut data = limits::zeros(width, height, 3)?;
    for (pixel, &i) in data.chunks_exact_mut(3).zip(&indices) {
        let colour = header.palette.get(usize::from(i)).ok_or_else(|| broken(format!("the palette has no colour {i}")))?;
        pixel.copy_from_slice(&colour.map(|c| f32::from(c) / 255.0));
    }
    Ok(data)
}

/// RLE8 and RLE4: (count, value) pairs, and escapes after a 0.
fn run_lengths(mut rest: Bytes<'_>, width: usize, height: usize, four: bool) -> Result<Vec<u8>, ErrorKind> {
    let mut out = vec![0u8; width * height];
    let (mut x, mut y) = (0usize, 0usize);
    let mut put = |x: usize, y: usize, v: u8| {
        // Runs may be padded over the end of their row.
        if x < width && y < height {
            out[y * width + x] = v;
        }
    };
    let nibble = |byte: u8, i: usize| {
        if !four {
            byte
        } else if i.is_multiple_of(2) {
            byte >> 4
        } else {
            byte & 15
        }
    };
    while y < height {
        match (ended(rest.u8())?, ended(rest.u8())?) {
            (0, 0) => (x, y) = (0, y + 1),
            (0, 1) => break,
            (0, 2) => {
                x += usize::from(ended(rest.u8())?);
                y += usize::from(ended(rest.u8())?);
            }
            (0, n) => {
                let n = usize::from(n);
                let bytes = if four { n.div_ceil(2) } else { n };
                let values = ended(rest.take(bytes))?;
                (0..n).for_each(|i| put(x + i, y, nibble(values[if four { i / 2 } else { i }], i)));
                ended(rest.take(bytes % 2))?;
                x += n;
            }
            (n, value) => {
                (0..usize::from(n)).for_each(|i| put(x + i, y, nibble(value, i)));
                x += usize::from(n);
            }
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(width: i32, height: i32, bits: u16, compression: u32, tail: &[u8], start: u32) -> Vec<u8> {
        let mut f = b"BM\0\0\0\0\0\0\0\0".to_vec();
        f.extend(start.to_le_bytes());
        f.extend(40u32.to_le_bytes());
        f.extend([width.to_le_bytes(), height.to_le_bytes()].concat());
        f.extend([1, 0]);
        f.extend(bits.to_le_bytes());
        f.extend(compression.to_le_bytes());
        f.extend([0; 20]);
        f.extend(tail);
        f
    }

    #[test]
    fn true_colour_runs_upwards() {
        let rows = [0, 0, 255, 0, 255, 0, 0, 0, 255, 0, 0, 255, 255, 255, 0, 0];
        let image = decode(&file(2, 2, 24, 0, &rows, 54)).unwrap().image;
        assert_eq!(image.data(), [0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let down = decode(&file(2, -2, 24, 0, &rows, 54)).unwrap().image;
        assert_eq!(down.pixel(0, 0), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn palettes_and_runs() {
        let mut tail = vec![0, 0, 0, 0, 255, 0, 0, 0];
        tail.resize(64, 0);
        // Two rows of five: three of colour 1, end of line; a literal 0 1 0 (padded), end.
        let mut rle = tail.clone();
        rle.resize(1024, 0);
        rle.extend([3, 1, 0, 0, 0, 3, 0, 1, 0, 0, 0, 1]);
        let image = decode(&file(5, 2, 8, 1, &rle, 54 + 1024)).unwrap().image;
        let blue: Vec<f32> = image.pixels().map(|p| p[2]).collect();
        assert_eq!(blue, [0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
        let mut bits = vec![0, 0, 0, 0, 255, 255, 255, 0];
        bits.extend([0b1010_0000, 0, 0, 0]);
        let image = decode(&file(3, 1, 1, 0, &bits, 62)).unwrap().image;
        assert_eq!(image.pixels().map(|p| p[0]).collect::<Vec<_>>(), [1.0, 0.0, 1.0]);
    }

    #[test]
    fn five_six_five() {
        let mut tail = [0xf800u32, 0x07e0, 0x001f].iter().flat_map(|m| m.to_le_bytes()).collect::<Vec<_>>();
        tail.extend([0x00, 0xf8, 0xe0, 0x07]);
        let image = decode(&file(2, 1, 16, 3, &tail, 66)).unwrap().image;
        assert_eq!(image.data(), [1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    }
}
