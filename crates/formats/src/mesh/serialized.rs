//! Mitsuba's `.serialized`: compressed meshes one behind the other, and a table of their offsets at the end.
//!
//! Little endian. Each mesh: u16 0x041C, u16 version (3 or 4), then a zlib stream of u32 flags, a name ended by a zero byte (version 4),
//! u64 vertices, u64 triangles, positions, normals (flag 0x1), texture coordinates (0x2), colours (0x8), each as f32 (0x1000) or
//! f64 (0x2000), and the triangles' u32 indices. Flag 0x10 asks for flat faces, which Mitsuba 3
//! leaves to the scene's `face_normals`, and so does this reader. The table: an offset for each mesh (u64 in version 4, u32 in
//! version 3) and their number (u32).
//!
//! Source: Mitsuba documentation, "Serialized mesh loader".

use super::{FileError, Loaded, finish::finish};
use etendue_description::{Attribute, AttributeKind, MeshData};
use flate2::read::ZlibDecoder;
use glam::{Vec2, Vec3};
use std::io::Read;

const NORMALS: u32 = 0x1;
const UVS: u32 = 0x2;
const COLOURS: u32 = 0x8;
const DOUBLE: u32 = 0x2000;

/// Deflate cannot shrink data by more than this factor.
const MAX_RATIO: u128 = 1032;

/// Reads the mesh of an index, counted from 0.
pub fn read(bytes: &[u8], index: usize) -> Result<Loaded, Vec<FileError>> {
    one(bytes, index).map_err(|error| vec![error])
}

fn one(bytes: &[u8], index: usize) -> Result<Loaded, FileError> {
    let start = offset(bytes, index)?;
    let version = head(bytes, start)?;
    let compressed = bytes.len() - start - 4;
    let mut stream = Stream { inner: ZlibDecoder::new(&bytes[start + 4..]), start, compressed };

    let flags = u32::from_le_bytes(stream.array("the flags")?);
    if version == 4 {
        stream.skip_name()?;
    }
    let vertices = stream.count("vertices")?;
    let triangles = stream.count("triangles")?;
    let double = flags & DOUBLE != 0;
    let positions = stream.floats(vertices, 3, double, "the positions")?;
    let normals = if flags & NORMALS != 0 { stream.floats(vertices, 3, double, "the normals")? } else { Vec::new() };
    let uvs = if flags & UVS != 0 { stream.floats(vertices, 2, double, "the texture coordinates")? } else { Vec::new() };
    let colours = if flags & COLOURS != 0 { stream.floats(vertices, 3, double, "the colours")? } else { Vec::new() };
    let indices = stream.bytes(triangles, 12, "the triangles")?;

    let vec3 = |x: &[f32]| -> Vec<Vec3> { x.chunks_exact(3).map(Vec3::from_slice).collect() };
    let mut mesh = MeshData { positions: vec3(&positions), normals: vec3(&normals), ..MeshData::default() };
    if let Some(i) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return Err(FileError::byte(
            start,
            format!("vertex {i} of the mesh that begins here is not finite: {}", mesh.positions[i]),
        ));
    }
    mesh.uvs = uvs.chunks_exact(2).map(Vec2::from_slice).collect();
    if !colours.is_empty() {
        mesh.attributes.push(Attribute { name: "vertex_color".into(), kind: AttributeKind::Vertex, channels: 3, data: colours });
    }
    let index_of = |b: &[u8]| u32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    mesh.indices = indices.chunks_exact(12).map(|t| [index_of(&t[0..]), index_of(&t[4..]), index_of(&t[8..])]).collect();
    if let Some((i, bad)) =
        mesh.indices.iter().enumerate().find_map(|(i, t)| t.iter().find(|&&v| v as usize >= vertices).map(|v| (i, *v)))
    {
        let text = format!("triangle {i} of the mesh that begins here names vertex {bad}, there are {vertices}, counted from 0");
        return Err(FileError::byte(start, text));
    }
    Ok(finish(mesh, 0))
}

/// The version at the head of a mesh.
fn head(bytes: &[u8], start: usize) -> Result<u16, FileError> {
    let Some(&[a, b, c, d]) = bytes.get(start..).and_then(|rest| rest.first_chunk::<4>()) else {
        return Err(FileError::byte(start, "the file ends before the head of the mesh"));
    };
    if [a, b] != [0x1C, 0x04] {
        return Err(FileError::byte(start, "no serialized mesh begins here (0x041C expected)"));
    }
    match u16::from_le_bytes([c, d]) {
        version @ (3 | 4) => Ok(version),
        version => Err(FileError::byte(start + 2, format!("version {version} is not known, expected 3 or 4"))),
    }
}

/// Where a mesh begins.
fn offset(bytes: &[u8], index: usize) -> Result<usize, FileError> {
    let version = head(bytes, 0)?;
    if index == 0 {
        return Ok(0);
    }
    let table_end = bytes.len() - 4;
    let count = u32::from_le_bytes(bytes[table_end..].try_into().unwrap_or_default()) as usize;
    if index >= count {
        return Err(FileError::file(format!("mesh {index} does not exist, the file has {count}, counted from 0")));
    }
    let width = if version == 4 { 8 } else { 4 };
    let entry = table_end.checked_sub(width * (count - index));
    let entry = entry
        .and_then(|at| bytes.get(at..at + width))
        .ok_or_else(|| FileError::byte(table_end, format!("the table of {count} meshes does not fit into the file")))?;
    let mut wide = [0; 8];
    wide[..width].copy_from_slice(entry);
    let offset = u64::from_le_bytes(wide);
    usize::try_from(offset).ok().filter(|&o| o < table_end).ok_or_else(|| {
        FileError::byte(table_end, format!("the table puts mesh {index} at byte {offset}, behind the end of the file"))
    })
}

struct Stream<'b> {
    inner: ZlibDecoder<&'b [u8]>,
    start: usize,
    compressed: usize,
}

impl Stream<'_> {
    /// `count` records of `width` bytes.
    fn bytes(&mut self, count: usize, width: usize, what: &str) -> Result<Vec<u8>, FileError> {
        let wanted = count as u128 * width as u128;
        if wanted > self.compressed as u128 * MAX_RATIO {
            let text = format!("{what} should take {wanted} bytes, more than {} compressed bytes can hold", self.compressed);
            return Err(FileError::byte(self.start, text));
        }
        let mut out = Vec::new();
        let wanted = wanted as u64;
        if let Err(error) = self.inner.by_ref().take(wanted).read_to_end(&mut out) {
            return Err(FileError::byte(self.start, format!("{what} of the mesh that begins here cannot be unpacked: {error}")));
        }
        if (out.len() as u64) < wanted {
            let text = format!("the mesh that begins here ends within {what}: {} of {wanted} bytes", out.len());
            return Err(FileError::byte(self.start, text));
        }
        Ok(out)
    }

    fn array<const N: usize>(&mut self, what: &str) -> Result<[u8; N], FileError> {
        let bytes = self.bytes(1, N, what)?;
        bytes.try_into().map_err(|_| FileError::byte(self.start, "the mesh ends too early"))
    }

    fn skip_name(&mut self) -> Result<(), FileError> {
        const LONGEST: usize = 1 << 16;
        for _ in 0..LONGEST {
            if self.array::<1>("the name")? == [0] {
                return Ok(());
            }
        }
        Err(FileError::byte(self.start, format!("the name of the mesh that begins here is longer than {LONGEST} bytes")))
    }

    fn count(&mut self, what: &str) -> Result<usize, FileError> {
        let count = u64::from_le_bytes(self.array("the counts")?);
        u32::try_from(count).map(|n| n as usize).map_err(|_| {
            FileError::byte(self.start, format!("the mesh that begins here promises {count} {what}, more than can be numbered"))
        })
    }

    fn floats(&mut self, count: usize, channels: usize, double: bool, what: &str) -> Result<Vec<f32>, FileError> {
        if double {
            let bytes = self.bytes(count, 8 * channels, what)?;
            Ok(bytes.as_chunks().0.iter().map(|&b| f64::from_le_bytes(b) as f32).collect())
        } else {
            let bytes = self.bytes(count, 4 * channels, what)?;
            Ok(bytes.as_chunks().0.iter().map(|&b| f32::from_le_bytes(b)).collect())
        }
    }
}
