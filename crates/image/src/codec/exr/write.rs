//! Writes OpenEXR: one part of scan lines, ZIP-compressed in blocks of 16 rows, channels in alphabetical order.
//!
//! A block is compressed so: the bytes at even places first, then those at odd places; each replaced by its difference
//! from the one before plus 128; then deflate. What does not shrink is stored as it is.
//!
//! Written here rather than by a library, so that the same picture gives the same bytes: attributes keep their order.

use half::f16;
use miniz_oxide::deflate::compress_to_vec_zlib;

use crate::colour::Primaries;
use crate::error::ErrorKind;
use crate::format::{ExrSamples, Format};
use crate::image::{Image, Picture};

/// Rows a block.
const BLOCK: usize = 16;
/// Deflate's effort, of 10. More gains little on floats.
const EFFORT: u8 = 4;

/// A channel of the file, and where its numbers come from.
struct Channel<'a> {
    name: String,
    image: &'a Image,
    place: usize,
    half: bool,
}

/// Writes a picture with its layers and attributes.
///
/// With [`ExrSamples::Half`], colours, grey and alpha are rounded to half, saturating at 65504; all other
/// channels (depths, normals, ids) stay f32.
pub(crate) fn encode(picture: &Picture, samples: ExrSamples) -> Result<Vec<u8>, ErrorKind> {
    let linear = picture.image.to_linear();
    let (width, height) = (linear.width(), linear.height());
    let mut channels = channels_of(&linear, "", samples);
    for layer in &picture.layers {
        let size = (layer.image.width(), layer.image.height());
        if size != (width, height) {
            let text = format!("the layer {:?} of {} x {} beside a picture of {width} x {height}", layer.name, size.0, size.1);
            return Err(ErrorKind::CannotHold(Format::Exr, text));
        }
        channels.extend(channels_of(&layer.image, &format!("{}.", layer.name), samples));
    }
    channels.sort_by(|a, b| a.name.cmp(&b.name));
    if let Some(pair) = channels.windows(2).find(|p| p[0].name == p[1].name) {
        return Err(ErrorKind::CannotHold(Format::Exr, format!("two channels {:?}", pair[0].name)));
    }

    let mut out = header(width, height, &channels, &picture.attributes)?;
    let table = out.len();
    let blocks = height.div_ceil(BLOCK);
    out.resize(table + 8 * blocks, 0);
    for block in 0..blocks {
        let offset = out.len() as u64;
        out[table + 8 * block..][..8].copy_from_slice(&offset.to_le_bytes());
        let first = block * BLOCK;
        let raw = rows(&channels, first..height.min(first + BLOCK));
        let packed = compress_to_vec_zlib(&predicted(&raw), EFFORT);
        let bytes = if packed.len() < raw.len() { packed } else { raw };
        out.extend((first as i32).to_le_bytes());
        out.extend((bytes.len() as u32).to_le_bytes());
        out.extend(bytes);
    }
    Ok(out)
}

fn channels_of<'a>(image: &'a Image, prefix: &str, samples: ExrSamples) -> Vec<Channel<'a>> {
    let colour = image.channel("R").is_some() || image.channel("Y").is_some() && image.channel("X").is_none();
    let half = |name: &str| samples == ExrSamples::Half && colour && ["R", "G", "B", "Y", "A"].contains(&name);
    let names = image.channels().iter().enumerate();
    names.map(|(place, name)| Channel { name: format!("{prefix}{name}"), image, place, half: half(name) }).collect()
}

/// Magic number, version, attributes, and the byte that ends them.
fn header(width: usize, height: usize, channels: &[Channel<'_>], words: &[(String, String)]) -> Result<Vec<u8>, ErrorKind> {
    let mut attributes = Attributes::default();
    attributes.add("channels", "chlist", &channel_list(channels)?);
    let p = Primaries::REC709;
    attributes.add("chromaticities", "chromaticities", &floats(&[p.r, p.g, p.b, p.w].concat()));
    attributes.add("compression", "compression", &[3]);
    let (right, bottom) = (width as i32 - 1, height as i32 - 1);
    let window: Vec<u8> = [0, 0, right, bottom].iter().flat_map(|v| v.to_le_bytes()).collect();
    attributes.add("dataWindow", "box2i", &window);
    attributes.add("displayWindow", "box2i", &window);
    attributes.add("lineOrder", "lineOrder", &[0]);
    attributes.add("pixelAspectRatio", "float", &floats(&[1.0]));
    attributes.add("screenWindowCenter", "v2f", &floats(&[0.0, 0.0]));
    attributes.add("screenWindowWidth", "float", &floats(&[1.0]));
    for (name, text) in words {
        if name.is_empty() || name.len() > 255 || name.contains('\0') {
            return Err(ErrorKind::CannotHold(Format::Exr, format!("an attribute named {name:?}: 1 to 255 bytes are")));
        }
        if attributes.has(name) {
            return Err(ErrorKind::CannotHold(Format::Exr, format!("another attribute named {name:?}")));
        }
        attributes.add(name, "string", text.as_bytes());
    }
    let long = attributes.names.iter().chain(channels.iter().map(|c| &c.name)).any(|n| n.len() > 31);
    let mut out = 20_000_630u32.to_le_bytes().to_vec();
    out.extend((2u32 | if long { 0x400 } else { 0 }).to_le_bytes());
    out.extend(attributes.bytes);
    out.push(0);
    Ok(out)
}

/// Name, type, length, value, one after the other.
#[derive(Default)]
struct Attributes {
    names: Vec<String>,
    bytes: Vec<u8>,
}

impl Attributes {
    fn add(&mut self, name: &str, kind: &str, value: &[u8]) {
        self.names.push(name.to_owned());
        self.bytes.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &(value.len() as u32).to_le_bytes(), value].concat());
    }

    fn has(&self, name: &str) -> bool {
        // These two are read as parts of a file of several parts.
        self.names.iter().any(|n| n == name) || ["name", "type"].contains(&name)
    }
}

/// Name, pixel type (1 half, 2 float), linearity, sampling, for each channel.
fn channel_list(channels: &[Channel<'_>]) -> Result<Vec<u8>, ErrorKind> {
    let mut out = Vec::new();
    for c in channels {
        if c.name.is_empty() || c.name.len() > 255 || c.name.contains('\0') {
            return Err(ErrorKind::CannotHold(Format::Exr, format!("a channel named {:?}: 1 to 255 bytes are", c.name)));
        }
        out.extend(c.name.as_bytes());
        out.push(0);
        out.extend(if c.half { 1u32 } else { 2 }.to_le_bytes());
        out.extend([0; 4]);
        out.extend([1u32.to_le_bytes(), 1u32.to_le_bytes()].concat());
    }
    out.push(0);
    Ok(out)
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// The numbers of some rows: row by row, in each the channels one after the other.
fn rows(channels: &[Channel<'_>], rows: std::ops::Range<usize>) -> Vec<u8> {
    let mut out = Vec::new();
    for y in rows {
        for c in channels {
            let (w, n) = (c.image.width(), c.image.channel_count());
            let row = c.image.data()[y * w * n..(y + 1) * w * n].iter().skip(c.place).step_by(n);
            if c.half {
                out.extend(row.flat_map(|&v| to_half(v).to_le_bytes()));
            } else {
                out.extend(row.flat_map(|v| v.to_le_bytes()));
            }
        }
    }
    out
}

/// Rounded to the nearest half; what is finite stays so.
fn to_half(v: f32) -> f16 {
    f16::from_f32(if v.is_finite() { v.clamp(-65_504.0, 65_504.0) } else { v })
}

/// Even places, odd places; then differences.
fn predicted(raw: &[u8]) -> Vec<u8> {
    let mut out: Vec<u8> = raw.iter().step_by(2).chain(raw.iter().skip(1).step_by(2)).copied().collect();
    let mut last = out.first().copied().unwrap_or(0);
    for b in out.iter_mut().skip(1) {
        let this = *b;
        *b = this.wrapping_sub(last).wrapping_add(128);
        last = this;
    }
    out
}
