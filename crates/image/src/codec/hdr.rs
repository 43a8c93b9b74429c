//! Radiance HDR [Ward 1991; Radiance file formats, 1997]: three bytes with one exponent a pixel,
//!
//! ```text
//! (R, G, B) = (r, g, b) · 2^(e - 136)        e = 0 is black
//! ```
//!
//! in rows that are flat, or run-length coded by the old rule (a pixel 1 1 1 n repeats the last), or by the new one
//! (2 2 width, then each of the four bytes' planes by itself). `EXPOSURE` lines are left alone, as other renderers do: files in
//! circulation are used without. `PRIMARIES` and the XYZ variant are converted.

use crate::bytes::Bytes;
use crate::codec::{image, simple};
use crate::colour::{Depth, Encoding, Primaries, Transfer};
use crate::error::ErrorKind;
use crate::format::Format;
use crate::image::Picture;
use crate::limits;

fn broken(what: impl Into<String>) -> ErrorKind {
    ErrorKind::Corrupt(Format::Hdr, what.into())
}

/// Reads a picture.
pub(crate) fn decode(bytes: &[u8]) -> Result<Picture, ErrorKind> {
    let mut rest = Bytes(bytes);
    let (mut primaries, mut xyz) = (Primaries::REC709, false);
    // The header: lines of NAME=VALUE up to an empty one.
    loop {
        let line = rest.line().map_err(broken)?;
        let line = String::from_utf8_lossy(line);
        match line.trim_end().split_once('=') {
            _ if line.trim_end().is_empty() => break,
            Some(("FORMAT", "32-bit_rle_rgbe")) => {}
            Some(("FORMAT", "32-bit_rle_xyze")) => xyz = true,
            Some(("FORMAT", other)) => return Err(ErrorKind::Unsupported(Format::Hdr, format!("the pixel format {other:?}"))),
            Some(("PRIMARIES", numbers)) => primaries = parse_primaries(numbers).unwrap_or(primaries),
            _ => {}
        }
    }
    let size = rest.line().map_err(broken)?;
    let (width, height, orientation) = resolution(&String::from_utf8_lossy(size))?;
    let samples = limits::samples(width, height, 3)?;
    // A run of the old rule stands for at most 255 pixels in 4 bytes (its shifted counts are held to one row).
    if samples as u64 / 3 > rest.0.len() as u64 * limits::DENSEST {
        return Err(broken("the file ends too soon"));
    }
    let (width, height) = (width as usize, height as usize);
    let mut data = limits::zeros(width, height, 3)?;
    let (length, rows) = if orientation.transposed { (height, width) } else { (width, height) };
    let mut row = vec![[0u8; 4]; length];
    for y in 0..rows {
        read_row(&mut rest, &mut row)?;
        for (x, &rgbe) in row.iter().enumerate() {
            let at = orientation.place(x, y, width, height);
            data[3 * at..3 * at + 3].copy_from_slice(&light(rgbe));
        }
    }
    if xyz {
        xyz_to_rec709(&mut data);
        primaries = Primaries::REC709;
    }
    let encoding = Encoding { transfer: Transfer::Linear, primaries, depth: Depth::Rgbe };
    Ok(image(width, height, 3, data, encoding)?.into())
}

/// XYZ to linear Rec.709.
fn xyz_to_rec709(data: &mut [f32]) {
    // [IEC 61966-2-1:1999, eq. 7]
    let m = [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];
    for p in data.chunks_exact_mut(3) {
        let rgb = crate::colour::apply(&m, [p[0], p[1], p[2]].map(f64::from));
        p.copy_from_slice(&rgb.map(|x| x as f32));
    }
}

/// Eight chromaticities.
fn parse_primaries(numbers: &str) -> Option<Primaries> {
    let n: Vec<f32> = numbers.split_whitespace().map_while(|s| s.parse().ok()).collect();
    let &[rx, ry, gx, gy, bx, by, wx, wy] = n.as_slice() else { return None };
    Some(Primaries { r: [rx, ry], g: [gx, gy], b: [bx, by], w: [wx, wy] })
}

/// Where the file's pixels go.
#[derive(Clone, Copy)]
struct Orientation {
    transposed: bool,
    left: bool,
    up: bool,
}

impl Orientation {
    /// The index of the pixel that stands at `x` in the `y`-th row of the file.
    fn place(self, x: usize, y: usize, width: usize, height: usize) -> usize {
        let (x, y) = if self.transposed { (y, x) } else { (x, y) };
        let x = if self.left { width - 1 - x } else { x };
        let y = if self.up { height - 1 - y } else { y };
        y * width + x
    }
}

/// "-Y height +X width", and the seven other ways to hold a picture.
fn resolution(line: &str) -> Result<(u64, u64, Orientation), ErrorKind> {
    let wrong = || broken(format!("{:?} is no size", line.trim_end()));
    let words: Vec<&str> = line.split_whitespace().collect();
    let &[major, a, minor, b] = words.as_slice() else { return Err(wrong()) };
    let [a, b] = [a, b].map(|n| n.parse::<u64>().map_err(|_| wrong()));
    let (a, b) = (a?, b?);
    match (major, minor) {
        ("-Y" | "+Y", "+X" | "-X") => Ok((b, a, Orientation { transposed: false, left: minor == "-X", up: major == "+Y" })),
        ("-X" | "+X", "+Y" | "-Y") => Ok((a, b, Orientation { transposed: true, left: major == "-X", up: minor == "+Y" })),
        _ => Err(wrong()),
    }
}

/// One row, whatever its coding.
fn read_row(rest: &mut Bytes<'_>, row: &mut [[u8; 4]]) -> Result<(), ErrorKind> {
    let new = matches!(*rest.0, [2, 2, high, low, ..]
        if high < 128 && usize::from(high) << 8 | usize::from(low) == row.len() && row.len() >= 8);
    if new { new_row(rest, row) } else { old_row(rest, row) }
}

/// The new rule: four planes of runs (count above 128) and literals.
fn new_row(rest: &mut Bytes<'_>, row: &mut [[u8; 4]]) -> Result<(), ErrorKind> {
    rest.take(4).map_err(broken)?;
    for plane in 0..4 {
        let mut x = 0;
        while x < row.len() {
            let count = rest.u8().map_err(broken)?;
            let (n, run) = if count > 128 { (usize::from(count - 128), true) } else { (usize::from(count), false) };
            if n == 0 || x + n > row.len() {
                return Err(broken("a run goes over the end of its row"));
            }
            let values = rest.take(if run { 1 } else { n }).map_err(broken)?;
            for (i, pixel) in row[x..x + n].iter_mut().enumerate() {
                pixel[plane] = values[if run { 0 } else { i }];
            }
            x += n;
        }
    }
    Ok(())
}

/// The old rule: pixels, and repeats whose counts follow each other low byte first.
fn old_row(rest: &mut Bytes<'_>, row: &mut [[u8; 4]]) -> Result<(), ErrorKind> {
    let (mut x, mut shift) = (0, 0);
    while x < row.len() {
        let pixel: [u8; 4] = rest.array().map_err(broken)?;
        if pixel[..3] == [1, 1, 1] {
            let n = usize::from(pixel[3]).checked_shl(shift).unwrap_or(usize::MAX);
            if x == 0 || shift > 24 || n > row.len() - x {
                return Err(broken("a repeated pixel goes over the end of its row"));
            }
            let last = row[x - 1];
            row[x..x + n].fill(last);
            x += n;
            shift += 8;
        } else {
            row[x] = pixel;
            x += 1;
            shift = 0;
        }
    }
    Ok(())
}

/// The light of four bytes.
fn light([r, g, b, e]: [u8; 4]) -> [f32; 3] {
    if e == 0 {
        return [0.0; 3];
    }
    // 2^(e - 136) is exact in f32 down to its denormals.
    let scale = (f64::from(e) - 136.0).exp2() as f32;
    [r, g, b].map(|c| f32::from(c) * scale)
}

/// The four bytes nearest to a light. Negative light and what is no number are black; what is too large is clipped.
fn rgbe(rgb: [f32; 3]) -> [u8; 4] {
    let rgb = rgb.map(|c| if c.is_nan() { 0.0 } else { f64::from(c.clamp(0.0, f32::MAX)) });
    let largest = rgb[0].max(rgb[1]).max(rgb[2]);
    if largest < 1e-38 {
        return [0; 4];
    }
    let code = |exponent: i32| rgb.map(|c| (c * f64::from(8 - exponent).exp2()).round());
    // largest = m · 2^exponent with m in [1/2, 1); rounding up to 256 calls for the next exponent.
    let mut exponent = largest.log2().floor() as i32 + 1;
    while code(exponent).iter().any(|&c| c > 255.0) {
        exponent += 1;
    }
    let exponent = exponent.min(127);
    let [r, g, b] = code(exponent).map(|c| c.min(255.0) as u8);
    [r, g, b, (exponent + 128).max(0) as u8]
}

/// Writes a picture by the new rule; alpha is left out.
pub(crate) fn encode(picture: &Picture) -> Result<Vec<u8>, ErrorKind> {
    let image = simple(&picture.image, Format::Hdr, false)?.to_rgb().into_linear();
    let (width, height) = (image.width(), image.height());
    let mut out = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    for row in image.data().chunks_exact(3 * width) {
        let pixels: Vec<[u8; 4]> = row.chunks_exact(3).map(|p| rgbe([p[0], p[1], p[2]])).collect();
        // The new rule is defined for these widths only.
        if !(8..=0x7fff).contains(&width) {
            out.extend(pixels.into_iter().flatten());
            continue;
        }
        out.extend([2, 2, (width >> 8) as u8, width as u8]);
        for plane in 0..4 {
            let values: Vec<u8> = pixels.iter().map(|p| p[plane]).collect();
            write_runs(&mut out, &values);
        }
    }
    Ok(out)
}

/// Runs of four or more equal bytes by their length, the rest as they are.
fn write_runs(out: &mut Vec<u8>, values: &[u8]) {
    let mut literal = 0;
    let mut x = 0;
    let flush = |out: &mut Vec<u8>, bytes: &[u8]| {
        for piece in bytes.chunks(128) {
            out.push(piece.len() as u8);
            out.extend(piece);
        }
    };
    while x < values.len() {
        let run = values[x..].iter().take(127).take_while(|&&v| v == values[x]).count();
        if run >= 4 {
            flush(out, &values[literal..x]);
            out.extend([128 + run as u8, values[x]]);
            literal = x + run;
        }
        x += run;
    }
    flush(out, &values[literal..]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rgbe_is_within_half_a_step() {
        for i in 0..2000 {
            let x = 1.013f32.powi(i - 1000);
            let back = light(rgbe([x, x * 0.3, 0.0]));
            let step = x / 128.0;
            assert!((back[0] - x).abs() <= 0.5001 * step && (back[1] - x * 0.3).abs() <= 0.5001 * step, "{x} {back:?}");
        }
        assert_eq!(light(rgbe([1.0, 0.5, 0.25])), [1.0, 0.5, 0.25]);
        assert_eq!(rgbe([f32::NAN, -1.0, 0.0]), [0; 4]);
        assert!(light(rgbe([f32::INFINITY, 0.0, 0.0]))[0] > 1e38);
    }

    #[test]
    fn all_orientations_are_turned_upright() {
        // A picture of 2 x 3 whose pixel (x, y) has the red value 1 + x + 2y.
        let pixel = |x: usize, y: usize| [1 + x as u8 + 2 * y as u8, 0, 0, 136];
        for (line, order) in [
            ("-Y 3 +X 2", [(0, 0), (1, 0), (0, 1), (1, 1), (0, 2), (1, 2)]),
            ("+Y 3 -X 2", [(1, 2), (0, 2), (1, 1), (0, 1), (1, 0), (0, 0)]),
            ("+X 2 -Y 3", [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)]),
            ("-X 2 +Y 3", [(1, 2), (1, 1), (1, 0), (0, 2), (0, 1), (0, 0)]),
        ] {
            let mut file = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{line}\n").into_bytes();
            file.extend(order.iter().flat_map(|&(x, y)| pixel(x, y)));
            let image = decode(&file).unwrap().image;
            let red: Vec<f32> = image.pixels().map(|p| p[0]).collect();
            assert_eq!(red, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "{line}");
        }
    }

    #[test]
    fn old_runs_repeat_the_last_pixel() {
        let mut file = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 300\n".to_vec();
        file.extend([128, 0, 0, 129, 1, 1, 1, 43, 1, 1, 1, 1]);
        assert!(decode(&file).unwrap().image.pixels().all(|p| p == [1.0, 0.0, 0.0]));
    }
}
