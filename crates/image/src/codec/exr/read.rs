//! Reads OpenEXR: any compression, scan lines or tiles (the largest level), parts, halves, floats and integers.
//!
//! Channel names tell the layers: `albedo.R` is channel `R` of layer `albedo`; in a file of several parts the part's name
//! comes first. The main picture is the layer without a name, else the first that holds colours. Luminance and chroma
//! become colours by
//!
//! ```text
//! R = (RY + 1) Y        B = (BY + 1) Y        G = (Y - w_R R - w_B B) / w_G
//! ```
//!
//! with the weights w of the file's primaries in its luminance.

use std::io::Cursor;

use exr::block::chunk::CompressedBlock;
use exr::compression::Compression;
use exr::image::{AnyChannels, FlatSamples, Layer as Part};
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{AttributeValue, ReadChannels, ReadLayers};

use crate::codec::exr::{broken, subsampled};
use crate::colour::{Depth, Encoding, Primaries, Transfer};
use crate::error::ErrorKind;
use crate::format::Format;
use crate::image::{Image, Layer, Picture};
use crate::limits;

/// Reads a picture with its layers and its string attributes.
pub(crate) fn decode(bytes: &[u8]) -> Result<Picture, ErrorKind> {
    if let Some((image, primaries)) = subsampled::decode(bytes)? {
        let encoding = Encoding { transfer: Transfer::Linear, primaries, depth: Depth::Half };
        return Ok(colours(image, primaries).with_encoding(encoding).into());
    }
    check_size(bytes)?;
    let file = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(refuse)?;

    let primaries = file.attributes.chromaticities.map_or(Primaries::REC709, |c| {
        let point = |v: exr::math::Vec2<f32>| [v.x(), v.y()];
        Primaries { r: point(c.red), g: point(c.green), b: point(c.blue), w: point(c.white) }
    });
    let mut layers = Vec::new();
    for part in &file.layer_data {
        let prefix = part.attributes.layer_name.as_ref().filter(|_| file.layer_data.len() > 1).map(ToString::to_string);
        layers.extend(layers_of(part, prefix.as_deref().unwrap_or(""), primaries)?);
    }
    if layers.is_empty() {
        return Err(ErrorKind::Unsupported(Format::Exr, "no channels, or with deep data".to_owned()));
    }
    let colours = |l: &Layer| l.image.channel("R").is_some() && l.image.channel("B").is_some();
    let main = layers.iter().position(|l| l.name.is_empty() && (colours(l) || l.image.channel("Y").is_some()));
    let main = main.or_else(|| layers.iter().position(colours)).or_else(|| layers.iter().position(|l| l.name.is_empty()));
    let image = layers.remove(main.unwrap_or(0)).image;
    // Layers lie beside the picture pixel by pixel; parts of another size do not.
    layers.retain(|l| (l.image.width(), l.image.height()) == (image.width(), image.height()));
    Ok(Picture { image, layers, attributes: words(&file) })
}

/// The library's error as ours.
fn refuse(e: exr::error::Error) -> ErrorKind {
    match e {
        exr::error::Error::NotSupported(what) => ErrorKind::Unsupported(Format::Exr, what.into_owned()),
        exr::error::Error::Io(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => broken("the file ends too soon"),
        other => broken(other),
    }
}

/// Refuses what the header asks for in excess of the limits, or of what so short a file can hold.
fn check_size(bytes: &[u8]) -> Result<(), ErrorKind> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(refuse)?;
    let mut total = 0u64;
    for header in &meta.headers {
        let (w, h) = (header.layer_size.width() as u64, header.layer_size.height() as u64);
        total = total.saturating_add(limits::samples(w, h, header.channels.list.len() as u64)? as u64);
    }
    if total > limits::MAX_SAMPLES {
        return Err(ErrorKind::Unsupported(Format::Exr, format!("parts of {total} numbers in all")));
    }
    if total > bytes.len() as u64 * limits::DENSEST {
        return Err(broken("the file ends too soon"));
    }
    let dwa = |h: &Header| matches!(h.compression, Compression::DWAA(_) | Compression::DWAB(_));
    if meta.headers.iter().any(dwa) { check_dwa(bytes) } else { Ok(()) }
}

/// Refuses a chunk of DWA compression whose head asks for more memory than its pixels can need: the library would try.
fn check_dwa(bytes: &[u8]) -> Result<(), ErrorKind> {
    let reader = exr::block::read(Cursor::new(bytes), false).map_err(refuse)?;
    let headers = reader.headers().to_vec();
    for chunk in reader.all_chunks(false).map_err(refuse)? {
        let chunk = chunk.map_err(refuse)?;
        let header = headers.get(chunk.layer_index).ok_or_else(|| broken("a chunk of no part"))?;
        let data = match &chunk.compressed_block {
            CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
            CompressedBlock::Tile(block) => &block.compressed_pixels_le,
            _ => continue,
        };
        let place = header.get_block_data_indices(&chunk.compressed_block).map_err(refuse)?;
        let pixels = header.get_absolute_block_pixel_coordinates(place).map_err(refuse)?.size.area();
        let size = pixels * header.channels.bytes_per_pixel;
        if data.len() == size {
            continue; // stored as it is
        }
        // Version, nine sizes and counts, and the kind of entropy coder; 8 bytes each.
        let sizes = data.chunks_exact(8).skip(1).take(9).map(|b| b.iter().rev().fold(0, |v, &b| v << 8 | u64::from(b)));
        // Blocks are padded to 8 pixels a side, and the tables beside them are small.
        if sizes.into_iter().any(|s| s > 64 * (size as u64 + 4096)) {
            return Err(broken("a DWA block contradicts its size"));
        }
    }
    Ok(())
}

/// The string attributes of the file and of its first part, by name: the library keeps them in no order.
fn words(file: &exr::image::Image<exr::image::Layers<AnyChannels<FlatSamples>>>) -> Vec<(String, String)> {
    let parts = file.layer_data.first().into_iter().flat_map(|p| &p.attributes.other);
    let text = |v: &AttributeValue| if let AttributeValue::Text(t) = v { Some(utf8(t.bytes())) } else { None };
    let mut words: Vec<_> =
        file.attributes.other.iter().chain(parts).filter_map(|(k, v)| Some((utf8(k.bytes()), text(v)?))).collect();
    if let Some(part) = file.layer_data.first() {
        let known = [
            ("software", &part.attributes.software_name),
            ("comments", &part.attributes.comments),
            ("owner", &part.attributes.owner),
        ];
        words.extend(known.into_iter().filter_map(|(k, v)| Some((k.to_owned(), utf8(v.as_ref()?.bytes())))));
    }
    words.sort();
    words
}

fn utf8(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The layers in a part.
fn layers_of(part: &Part<AnyChannels<FlatSamples>>, prefix: &str, primaries: Primaries) -> Result<Vec<Layer>, ErrorKind> {
    let (width, height) = (part.size.width(), part.size.height());
    // (layer, channel, numbers), sorted so that a layer's channels are neighbours in their usual order.
    let mut channels = Vec::new();
    for channel in &part.channel_data.list {
        let full = utf8(channel.name.bytes());
        let (layer, name) = full.rsplit_once('.').unwrap_or(("", &full));
        let layer = [prefix, layer].into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join(".");
        if channel.sample_data.len() != width * height {
            return Err(broken(format!("channel {full} has {} numbers", channel.sample_data.len())));
        }
        channels.push((layer, rank(name), name.to_owned(), &channel.sample_data));
    }
    channels.sort_by(|a, b| (&a.0, a.1, &a.2).cmp(&(&b.0, b.1, &b.2)));
    channels.chunk_by(|a, b| a.0 == b.0).map(|group| layer_of(group, width, height, primaries)).collect()
}

/// Colours before others.
fn rank(name: &str) -> usize {
    ["R", "G", "B", "X", "Y", "RY", "BY", "A"].iter().position(|&n| n == name).unwrap_or(8)
}

fn layer_of(
    group: &[(String, usize, String, &FlatSamples)],
    width: usize,
    height: usize,
    primaries: Primaries,
) -> Result<Layer, ErrorKind> {
    let n = group.len();
    let mut data = limits::zeros(width, height, n)?;
    for (c, (_, _, _, samples)) in group.iter().enumerate() {
        let places = data.iter_mut().skip(c).step_by(n);
        match samples {
            FlatSamples::F16(v) => places.zip(v).for_each(|(p, v)| *p = v.to_f32()),
            FlatSamples::F32(v) => places.zip(v).for_each(|(p, v)| *p = *v),
            FlatSamples::U32(v) => places.zip(v).for_each(|(p, v)| *p = *v as f32),
        }
    }
    let depth = match group[0].3 {
        FlatSamples::F16(_) => Depth::Half,
        FlatSamples::F32(_) => Depth::Float,
        FlatSamples::U32(_) => Depth::Uint32,
    };
    let names: Vec<&str> = group.iter().map(|g| g.2.as_str()).collect();
    let image = Image::from_data(width, height, &names, data).map_err(broken)?;
    let image = colours(image, primaries).with_encoding(Encoding { transfer: Transfer::Linear, primaries, depth });
    Ok(Layer { name: group[0].0.clone(), image })
}

/// Luminance and chroma to colours; other pictures as they are.
fn colours(image: Image, primaries: Primaries) -> Image {
    let (Some(y), Some(ry), Some(by)) = (image.channel("Y"), image.channel("RY"), image.channel("BY")) else { return image };
    let weights = primaries.luminance_weights().or_else(|| Primaries::REC709.luminance_weights());
    let [wr, wg, wb] = weights.unwrap_or([0.2126, 0.7152, 0.0722]).map(|w| w as f32);
    let mut rgb =
        image.pick(&[(ry, "R"), (y, "G"), (by, "B")].into_iter().chain(image.channel("A").map(|a| (a, "A"))).collect::<Vec<_>>());
    let n = rgb.channel_count();
    for p in rgb.data_mut().chunks_exact_mut(n) {
        let (y, r, b) = (p[1], (p[0] + 1.0) * p[1], (p[2] + 1.0) * p[1]);
        (p[0], p[1], p[2]) = (r, (y - wr * r - wb * b) / wg, b);
    }
    rgb
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{Encoding as Packing, LayerAttributes, SpecificChannels, WritableImage};

    /// A damaged DWA block once asked for 128 GiB and took the process down.
    #[test]
    fn dwa_blocks_may_not_ask_for_more_than_they_hold() {
        let pixels = SpecificChannels::rgb(|p: exr::math::Vec2<usize>| (p.x() as f32, p.y() as f32, 0.5f32));
        let packing = Packing { compression: Compression::DWAA(None), ..Packing::FAST_LOSSLESS };
        let layer = Part::new((64, 64), LayerAttributes::default(), packing, pixels);
        let mut file = Cursor::new(Vec::new());
        exr::image::Image::from_layer(layer).write().to_buffered(&mut file).unwrap();
        let mut bytes = file.into_inner();
        assert_eq!(decode(&bytes).unwrap().image.width(), 64);

        // Ten small numbers of 8 bytes follow the block's place and length: raise the first size.
        let small = |b: &[u8]| b[0] == 2 && b[1..8].iter().all(|&b| b == 0);
        let head = (0..bytes.len() - 88)
            .rev()
            .find(|&i| small(&bytes[i..]) && bytes[i..i + 88].chunks(8).all(|b| b[5..] == [0; 3]))
            .unwrap();
        bytes[head + 8 + 4] = 32;
        let e = decode(&bytes).unwrap_err();
        assert!(matches!(&e, ErrorKind::Corrupt(_, what) if what.contains("DWA")), "{e:?}");
    }
}
