//! OpenEXR scan lines whose chroma is stored for every second pixel of every second row, which the library's own reader
//! refuses: the header and the chunks are read here, and only the blocks are unpacked there.
//!
//! Chroma between the stored samples is interpolated linearly.

use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, IntegerBounds, SampleType, Text};
use exr::meta::header::Header;

use crate::bytes::Bytes;
use crate::codec::exr::broken;
use crate::colour::Primaries;
use crate::error::ErrorKind;
use crate::format::Format;
use crate::image::Image;
use crate::limits;

/// A channel: how it is stored, and its samples so far.
struct Channel {
    name: String,
    sample: SampleType,
    step: usize,
    samples: Vec<f32>,
}

/// What the header says.
struct Layout {
    channels: Vec<Channel>,
    compression: Compression,
    left: i32,
    top: i32,
    width: usize,
    height: usize,
    primaries: Primaries,
}

/// The picture's raw channels, all at full size, and its primaries; `None` where no channel is subsampled.
pub(super) fn decode(bytes: &[u8]) -> Result<Option<(Image, Primaries)>, ErrorKind> {
    let mut rest = Bytes(bytes);
    let version = rest.take(4).and_then(|_| rest.u32()).map_err(broken_end)?;
    // Tiles, deep data and several parts cannot be subsampled.
    if version & 0x1a00 != 0 {
        return Ok(None);
    }
    let Some(mut layout) = header(&mut rest)? else { return Ok(None) };
    let (width, height) = (layout.width, layout.height);
    let n = limits::samples(width as u64, height as u64, layout.channels.len() as u64)?;
    if n as u64 > bytes.len() as u64 * limits::DENSEST {
        return Err(broken("the file ends too soon"));
    }
    for c in &mut layout.channels {
        c.samples = limits::zeros(width / c.step, height / c.step, 1)?;
    }
    let block = layout.compression.scan_lines_per_block();
    for _ in 0..height.div_ceil(block) {
        let at = rest.array().map(u64::from_le_bytes).map_err(broken_end)?;
        let chunk =
            usize::try_from(at).ok().and_then(|at| bytes.get(at..)).ok_or_else(|| broken("a chunk lies outside of the file"))?;
        read_chunk(Bytes(chunk), &mut layout, block)?;
    }
    let names: Vec<String> = layout.channels.iter().map(|c| c.name.clone()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut image = Image::new(width, height, &names).map_err(broken)?;
    let count = names.len();
    for (c, channel) in layout.channels.iter().enumerate() {
        let places = image.data_mut().iter_mut().skip(c).step_by(count);
        places.enumerate().for_each(|(i, v)| *v = channel.at(i % width, i / width, width, height));
    }
    Ok(Some((image, layout.primaries)))
}

fn broken_end(e: crate::bytes::Ended) -> ErrorKind {
    broken(String::from(e))
}

/// The attributes that matter. `None` where no channel is subsampled.
fn header(rest: &mut Bytes<'_>) -> Result<Option<Layout>, ErrorKind> {
    let (mut channels, mut compression, mut window, mut primaries) = (Vec::new(), None, None, Primaries::REC709);
    loop {
        let name = word(rest)?;
        if name.is_empty() {
            break;
        }
        word(rest)?;
        let size = rest.u32().map_err(broken_end)? as usize;
        let mut value = Bytes(rest.take(size).map_err(broken_end)?);
        match name.as_str() {
            "channels" => channels = channel_list(value)?,
            "compression" => compression = Some(value.u8().map_err(broken_end)?),
            "dataWindow" => {
                let mut side = || value.i32().map_err(broken_end);
                window = Some([side()?, side()?, side()?, side()?]);
            }
            "chromaticities" => {
                let mut point = || -> Result<[f32; 2], ErrorKind> {
                    let mut float = || value.u32().map(f32::from_bits).map_err(broken_end);
                    Ok([float()?, float()?])
                };
                primaries = Primaries { r: point()?, g: point()?, b: point()?, w: point()? };
            }
            _ => {}
        }
    }
    if channels.iter().all(|c: &Channel| c.step == 1) {
        return Ok(None);
    }
    let compression = match compression {
        Some(0) => Compression::Uncompressed,
        Some(1) => Compression::RLE,
        Some(2) => Compression::ZIP1,
        Some(3) => Compression::ZIP16,
        Some(4) => Compression::PIZ,
        Some(5) => Compression::PXR24,
        other => {
            let what = format!("subsampled channels of compression {}", other.map_or(-1, i32::from));
            return Err(ErrorKind::Unsupported(Format::Exr, what));
        }
    };
    let [left, top, right, bottom] = window.ok_or_else(|| broken("it has no data window"))?;
    let side =
        |from: i32, to: i32| u64::try_from(i64::from(to) - i64::from(from) + 1).map_err(|_| broken("its data window is empty"));
    let (width, height) = (side(left, right)?, side(top, bottom)?);
    limits::samples(width, height, channels.len() as u64)?;
    // The format asks for windows that begin and end with a stored sample's pixels.
    if [left, top].iter().any(|v| v % 2 != 0) || width % 2 != 0 || height % 2 != 0 {
        return Err(broken("its data window does not fit its sampling"));
    }
    Ok(Some(Layout { channels, compression, left, top, width: width as usize, height: height as usize, primaries }))
}

/// Text up to a zero byte.
fn word(rest: &mut Bytes<'_>) -> Result<String, ErrorKind> {
    let end = rest.0.iter().take(256).position(|&b| b == 0).ok_or_else(|| broken("the file ends too soon"))?;
    let text = rest.take(end).map_err(broken_end)?;
    rest.take(1).map_err(broken_end)?;
    Ok(String::from_utf8_lossy(text).into_owned())
}

fn channel_list(mut value: Bytes<'_>) -> Result<Vec<Channel>, ErrorKind> {
    let mut channels = Vec::new();
    loop {
        let name = word(&mut value)?;
        if name.is_empty() {
            return Ok(channels);
        }
        let sample = match value.u32().map_err(broken_end)? {
            0 => SampleType::U32,
            1 => SampleType::F16,
            2 => SampleType::F32,
            other => return Err(broken(format!("pixel type {other} is unknown"))),
        };
        value.take(4).map_err(broken_end)?;
        let (x, y) = (value.u32().map_err(broken_end)?, value.u32().map_err(broken_end)?);
        if x != y || !(1..=2).contains(&x) {
            return Err(ErrorKind::Unsupported(Format::Exr, format!("channel {name} sampled every {x} by {y} pixels")));
        }
        channels.push(Channel { name, sample, step: x as usize, samples: Vec::new() });
    }
}

/// Unpacks one chunk into the channels.
fn read_chunk(mut chunk: Bytes<'_>, layout: &mut Layout, block: usize) -> Result<(), ErrorKind> {
    let y = chunk.i32().map_err(broken_end)?;
    let size = chunk.u32().map_err(broken_end)? as usize;
    let data = chunk.take(size).map_err(broken_end)?;
    let first = usize::try_from(i64::from(y) - i64::from(layout.top)).ok().filter(|f| *f < layout.height && f % block == 0);
    let first = first.ok_or_else(|| broken(format!("a chunk begins at row {y}")))?;
    let rows = block.min(layout.height - first);

    let stored = |c: &Channel, y: usize| if y.is_multiple_of(c.step) { layout.width / c.step } else { 0 };
    let bytes = |c: &Channel| (first..first + rows).map(|y| stored(c, y)).sum::<usize>() * c.sample.bytes_per_sample();
    let total: usize = layout.channels.iter().map(bytes).sum();
    if !total.is_multiple_of(layout.width * rows) {
        return Err(ErrorKind::Unsupported(Format::Exr, "a single subsampled channel".to_owned()));
    }
    // Blocks of one row hold chroma in every second row only: the library is told of those channels that are there.
    let present = layout.channels.iter().filter(|c| rows > 1 || first % c.step == 0);
    let described = present.map(|c| ChannelDescription {
        name: Text::default(),
        sample_type: c.sample,
        quantize_linearly: false,
        sampling: Vec2(c.step, if rows > 1 { c.step } else { 1 }),
    });
    let mut header = Header::new(Text::default(), (layout.width, layout.height), described.collect());
    header.compression = layout.compression;
    header.blocks = BlockDescription::ScanLines;
    header.channels.bytes_per_pixel = total / (layout.width * rows);
    let section = IntegerBounds::new((layout.left, y), (layout.width, rows));
    let raw = layout.compression.decompress_image_section_from_le(&header, data.into(), section, false).map_err(broken)?;

    let mut raw = raw.as_slice();
    let width = layout.width;
    for y in first..first + rows {
        for c in layout.channels.iter_mut().filter(|c| y % c.step == 0) {
            let (n, size) = (width / c.step, c.sample.bytes_per_sample());
            let (row, after) = raw.split_at_checked(n * size).ok_or_else(|| broken("a chunk is too short"))?;
            raw = after;
            let target = &mut c.samples[y / c.step * n..][..n];
            for (v, b) in target.iter_mut().zip(row.chunks_exact(size)) {
                *v = match c.sample {
                    SampleType::F16 => half::f16::from_ne_bytes([b[0], b[1]]).to_f32(),
                    SampleType::F32 => f32::from_ne_bytes([b[0], b[1], b[2], b[3]]),
                    SampleType::U32 => u32::from_ne_bytes([b[0], b[1], b[2], b[3]]) as f32,
                };
            }
        }
    }
    Ok(())
}

impl Channel {
    /// The value at a pixel: stored, or the mean of the two or four stored ones about it.
    fn at(&self, x: usize, y: usize, width: usize, height: usize) -> f32 {
        if self.step == 1 {
            return self.samples[y * width + x];
        }
        let (w, h) = (width / 2, height / 2);
        let (x0, y0) = (x / 2, y / 2);
        let (x1, y1) = ((x0 + x % 2).min(w - 1), (y0 + y % 2).min(h - 1));
        let s = |x: usize, y: usize| self.samples[y * w + x];
        0.25 * (s(x0, y0) + s(x1, y0) + s(x0, y1) + s(x1, y1))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    /// 4 x 2 pixels, uncompressed floats: Y is 1, RY and BY hold two samples each.
    fn file() -> Vec<u8> {
        let mut out = [0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0].to_vec();
        let mut add = |name: &str, kind: &str, value: &[u8]| {
            out.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &(value.len() as u32).to_le_bytes(), value].concat());
        };
        let mut list = Vec::new();
        for (name, step) in [("BY", 2u32), ("RY", 2), ("Y", 1)] {
            list.extend([name.as_bytes(), &[0, 2, 0, 0, 0, 0, 0, 0, 0], &step.to_le_bytes(), &step.to_le_bytes()].concat());
        }
        list.push(0);
        add("channels", "chlist", &list);
        add("compression", "compression", &[0]);
        add("dataWindow", "box2i", &[0i32, 0, 3, 1].map(i32::to_le_bytes).concat());
        out.push(0);
        let floats = |v: &[f32]| v.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>();
        let first = [floats(&[0.0, 0.0]), floats(&[0.0, 0.5]), floats(&[1.0; 4])].concat();
        let second = floats(&[1.0; 4]);
        let at = out.len() as u64 + 16;
        out.extend([at.to_le_bytes(), (at + 8 + first.len() as u64).to_le_bytes()].concat());
        for (y, data) in [(0u32, first), (1, second)] {
            out.extend([&y.to_le_bytes()[..], &(data.len() as u32).to_le_bytes(), &data].concat());
        }
        out
    }

    #[test]
    fn chroma_is_interpolated() {
        let image = crate::codec::exr::decode(&file()).unwrap().image;
        assert!(image.has_exactly(&["R", "G", "B"]));
        for y in 0..2 {
            let red: Vec<f32> = (0..4).map(|x| image.pixel(x, y)[0]).collect();
            assert_eq!(red, [1.0, 1.25, 1.5, 1.5]);
        }
        assert!((crate::luminance([image.pixel(2, 1)[0], image.pixel(2, 1)[1], image.pixel(2, 1)[2]]) - 1.0).abs() < 1e-4);
    }

    proptest! {
        #[test]
        fn broken_files_do_no_harm(flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6), cut in 0usize..40) {
            let mut bytes = file();
            for (i, x) in flips {
                let i = i.index(bytes.len());
                bytes[i] ^= x;
            }
            bytes.truncate(bytes.len().saturating_sub(cut.saturating_sub(20)));
            let _ = crate::codec::exr::decode(&bytes);
        }
    }
}
