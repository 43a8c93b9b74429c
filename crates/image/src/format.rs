//! Which codec a file is for: known by its first bytes when read, by its name's ending when written.

use std::path::Path;

use crate::codec::{bmp, exr, hdr, jpeg, pfm, png, tga};
use crate::error::{ErrorKind, ImageError};
use crate::image::{Image, Picture};
use crate::write_atomically;

/// The picture formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR: half or float, any channels, layers.
    Exr,
    /// PNG of 8 or 16 bits.
    Png,
    /// JPEG.
    Jpeg,
    /// Radiance HDR.
    Hdr,
    /// Portable float map.
    Pfm,
    /// Windows bitmap; read only.
    Bmp,
    /// Truevision TGA; read only.
    Tga,
}

impl Format {
    /// All of them.
    pub const ALL: [Format; 7] = [Format::Exr, Format::Png, Format::Jpeg, Format::Hdr, Format::Pfm, Format::Bmp, Format::Tga];

    /// The name in words.
    pub fn name(self) -> &'static str {
        match self {
            Format::Exr => "OpenEXR",
            Format::Png => "PNG",
            Format::Jpeg => "JPEG",
            Format::Hdr => "Radiance HDR",
            Format::Pfm => "PFM",
            Format::Bmp => "BMP",
            Format::Tga => "TGA",
        }
    }

    /// The endings of file names, the usual one first.
    pub fn endings(self) -> &'static [&'static str] {
        match self {
            Format::Exr => &["exr"],
            Format::Png => &["png"],
            Format::Jpeg => &["jpg", "jpeg"],
            Format::Hdr => &["hdr", "rgbe"],
            Format::Pfm => &["pfm"],
            Format::Bmp => &["bmp", "dib"],
            Format::Tga => &["tga"],
        }
    }

    /// Whether [`save`] writes it.
    pub fn can_write(self) -> bool {
        !matches!(self, Format::Bmp | Format::Tga)
    }

    /// Whether it keeps linear light as it is, rather than what a display shows.
    pub fn is_linear(self) -> bool {
        matches!(self, Format::Exr | Format::Hdr | Format::Pfm)
    }

    /// The format that a name's ending stands for.
    pub fn of_path(path: &Path) -> Option<Format> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        Format::ALL.into_iter().find(|f| f.endings().contains(&ending.as_str()))
    }

    /// The format that a file's first bytes tell. TGA has no such mark.
    pub fn of_bytes(bytes: &[u8]) -> Option<Format> {
        let marks: [(&[u8], Format); 8] = [
            (&[0x76, 0x2f, 0x31, 0x01], Format::Exr),
            (&[0x89, b'P', b'N', b'G'], Format::Png),
            (&[0xff, 0xd8, 0xff], Format::Jpeg),
            (b"#?", Format::Hdr),
            (b"PF\n", Format::Pfm),
            (b"PF\r", Format::Pfm),
            (b"Pf", Format::Pfm),
            (b"BM", Format::Bmp),
        ];
        marks.iter().find(|(mark, _)| bytes.starts_with(mark)).map(|m| m.1)
    }

    /// "exr, png, …" of the formats that pass.
    pub(crate) fn list(pass: impl Fn(Format) -> bool) -> String {
        let endings: Vec<&str> = Format::ALL.into_iter().filter(|&f| pass(f)).flat_map(Format::endings).copied().collect();
        endings.join(", ")
    }
}

/// Formats that people try and that are not read, by their first bytes at an offset.
const FOREIGN: [(usize, &[u8], &str); 13] = [
    (8, b"WEBP", "WebP"),
    (0, b"GIF8", "GIF"),
    (0, b"II*\0", "TIFF"),
    (0, b"MM\0*", "TIFF"),
    (0, b"8BPS", "Photoshop"),
    (0, b"DDS ", "DDS"),
    (4, b"ftypavif", "AVIF"),
    (4, b"ftyphei", "HEIF"),
    (0, b"\xabKTX", "KTX"),
    (0, b"\0\0\0\x0cjP", "JPEG 2000"),
    (0, b"\xff\x0a", "JPEG XL"),
    (0, b"qoif", "QOI"),
    (0, b"version https://git-lfs", "Git LFS pointer"),
];

/// The numbers in an EXR's picture and colour layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExrSamples {
    /// 16 bits: 11 bits of precision, up to 65504.
    Half,
    /// 32 bits: what the film holds.
    Float,
}

/// The bits of a PNG's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PngDepth {
    /// 8 bits.
    Eight,
    /// 16 bits.
    Sixteen,
}

/// What the writer may choose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SaveOptions {
    /// EXR: half or float (the default).
    pub exr: ExrSamples,
    /// PNG: 8 (the default) or 16 bits.
    pub png: PngDepth,
    /// JPEG: quality, 1 to 100, 95 by default.
    pub jpeg_quality: u8,
}

impl Default for SaveOptions {
    fn default() -> Self {
        SaveOptions { exr: ExrSamples::Float, png: PngDepth::Eight, jpeg_quality: 95 }
    }
}

/// The image in a file: of an EXR with several layers, the main one. Values are raw; see [`Image::to_linear`].
pub fn load(path: &Path) -> Result<Image, ImageError> {
    load_picture(path).map(|p| p.image)
}

/// All that a file holds: image, layers, attributes.
pub fn load_picture(path: &Path) -> Result<Picture, ImageError> {
    let read = || {
        let bytes = std::fs::read(path).map_err(ErrorKind::Read)?;
        decode_as(&bytes, Format::of_path(path))
    };
    read().map_err(|kind| ImageError::from(kind).at(path))
}

/// A picture from a file's bytes. `hint` is the format that its name promises; the bytes know better.
pub fn decode(bytes: &[u8], hint: Option<Format>) -> Result<Picture, ImageError> {
    Ok(decode_as(bytes, hint)?)
}

fn decode_as(bytes: &[u8], hint: Option<Format>) -> Result<Picture, ErrorKind> {
    let format = Format::of_bytes(bytes).or_else(|| (hint == Some(Format::Tga) && tga::plausible(bytes)).then_some(Format::Tga));
    match format {
        Some(Format::Exr) => exr::decode(bytes),
        Some(Format::Png) => png::decode(bytes),
        Some(Format::Jpeg) => jpeg::decode(bytes),
        Some(Format::Hdr) => hdr::decode(bytes),
        Some(Format::Pfm) => pfm::decode(bytes),
        Some(Format::Bmp) => bmp::decode(bytes),
        Some(Format::Tga) => tga::decode(bytes),
        None => {
            let is = |(at, mark, _): &&(usize, &[u8], &str)| bytes.get(*at..).is_some_and(|b| b.starts_with(mark));
            let foreign = FOREIGN.iter().find(is).map(|f| f.2);
            Err(ErrorKind::NotAPicture { first: bytes[..bytes.len().min(16)].to_vec(), foreign })
        }
    }
}

/// Writes a picture, in the format that the name's ending stands for, whole or not at all.
///
/// EXR, HDR and PFM take linear light: a picture encoded otherwise is decoded first. PNG and JPEG take sRGB: linear
/// light is encoded and clipped, so bring a render through [`ToneMap`](crate::ToneMap) before. Layers are kept by EXR alone.
pub fn save(path: &Path, picture: &Picture, options: &SaveOptions) -> Result<(), ImageError> {
    let write = || {
        let format = Format::of_path(path).filter(|f| f.can_write()).ok_or(ErrorKind::UnknownEnding)?;
        let bytes = encode_as(picture, format, options)?;
        write_atomically(path, &bytes).map_err(ErrorKind::Write)
    };
    write().map_err(|kind| ImageError::from(kind).at(path))
}

/// The bytes of a file that holds the picture.
pub fn encode(picture: &Picture, format: Format, options: &SaveOptions) -> Result<Vec<u8>, ImageError> {
    Ok(encode_as(picture, format, options)?)
}

fn encode_as(picture: &Picture, format: Format, options: &SaveOptions) -> Result<Vec<u8>, ErrorKind> {
    match format {
        Format::Exr => exr::encode(picture, options.exr),
        Format::Png => png::encode(picture, options.png),
        Format::Jpeg => jpeg::encode(picture, options.jpeg_quality),
        Format::Hdr => hdr::encode(picture),
        Format::Pfm => pfm::encode(picture),
        Format::Bmp | Format::Tga => Err(ErrorKind::CannotHold(format, "what is written here; it is only read".to_owned())),
    }
}
