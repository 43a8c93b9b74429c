//! PLY, the Stanford triangle format: ascii, and binary of either byte order.
//!
//! Element `vertex` has `x y z`, maybe normals `nx ny nz` and texture coordinates `u v`, `s t` or `texture_u texture_v`; element `face` has the
//! list `vertex_indices` or `vertex_index`, whose polygons become fans of triangles. Either may have named attributes, see `attributes`.
//! Other elements are skipped.
//!
//! Source: Greg Turk, The PLY Polygon File Format, 1994.

mod data;
mod header;

use super::attributes::{Named, find, named};
use super::{FileError, Loaded, finish::finish};
use data::{Ascii, Binary, Numbers, column};
use etendue_description::{Attribute, AttributeKind, MeshData};
use glam::{Vec2, Vec3};
use header::{Element, Encoding, Header};

/// Reads a mesh; `flip_v` turns v into 1 - v.
pub fn read(bytes: &[u8], flip_v: bool) -> Result<Loaded, Vec<FileError>> {
    one(bytes, flip_v).map_err(|error| vec![error])
}

fn one(bytes: &[u8], flip_v: bool) -> Result<Loaded, FileError> {
    let header = header::parse(bytes)?;
    let vertices = header.elements.iter().find(|e| e.name == "vertex");
    let vertices = vertices.ok_or_else(|| FileError::file("the header names no element `vertex`"))?;
    if !header.elements.iter().any(|e| e.name == "face") {
        return Err(FileError::file("the header names no element `face`; point clouds and triangle strips are not read"));
    }
    let mut reader = Reader { vertex_count: vertices.count, mesh: MeshData::default(), flip_v };
    let rest = match header.encoding {
        Encoding::Ascii => reader.elements(&header, Ascii { bytes, at: header.end, last: 0..0 }, None)?,
        encoding => {
            let big = encoding == Encoding::BigEndian;
            reader.elements(&header, Binary { bytes, at: header.end, last: header.end, big }, Some(bytes))?
        }
    };
    let mut loaded = finish(reader.mesh, 0);
    if rest > 0 {
        loaded.warnings.push(format!("{rest} bytes behind the last element are left aside"));
    }
    Ok(loaded)
}

struct Reader {
    vertex_count: usize,
    mesh: MeshData,
    flip_v: bool,
}

impl Reader {
    /// All elements; the answer is the number of bytes behind them.
    fn elements<N: Numbers>(&mut self, header: &Header, mut numbers: N, binary: Option<&[u8]>) -> Result<usize, FileError> {
        for element in &header.elements {
            let (name, count) = (&element.name, element.count);
            let least = element.least(header.encoding) as u128 * count as u128;
            // The last number of a text needs no blank behind it.
            let slack = u128::from(header.encoding == Encoding::Ascii);
            if least > numbers.rest() as u128 + slack || count > u32::MAX as usize {
                let rest = numbers.rest();
                let text =
                    format!("the header promises {count} of element `{name}`, at least {least} bytes, and {rest} bytes follow");
                return Err(numbers.mistake_ahead(text));
            }
            match name.as_str() {
                "vertex" if self.mesh.positions.is_empty() => self.vertices(element, header.encoding, &mut numbers, binary)?,
                "face" if self.mesh.indices.is_empty() => self.faces(element, &mut numbers)?,
                _ => rows(element, &mut numbers, |_, _, _| Ok(()), |_, _, _| Ok(()))?,
            }
        }
        Ok(numbers.left_over())
    }

    fn vertices<N: Numbers>(
        &mut self,
        element: &Element,
        encoding: Encoding,
        numbers: &mut N,
        binary: Option<&[u8]>,
    ) -> Result<(), FileError> {
        let names: Vec<&str> = element.properties.iter().map(|p| if p.list.is_some() { "" } else { p.name.as_str() }).collect();
        let position = find(&names, &[["x", "y", "z"]]);
        let position = position.ok_or_else(|| FileError::file("element `vertex` has no properties x, y, z"))?;
        let normal = find(&names, &[["nx", "ny", "nz"]]);
        let uv = find(&names, &[["u", "v"], ["s", "t"], ["texture_u", "texture_v"]]);
        let taken: Vec<usize> = position.into_iter().chain(normal.into_iter().flatten()).chain(uv.into_iter().flatten()).collect();
        let attributes = named("vertex", &names, &taken);
        let wanted = |p: usize| taken.contains(&p) || attributes.iter().any(|a| a.properties.contains(&p));

        let start = numbers.at();
        let columns: Vec<Vec<f32>> = match (element.stride(), binary) {
            (Some(stride), Some(bytes)) => {
                // `elements` has seen that the rows are there.
                let table = &bytes[start..start + stride * element.count];
                numbers.skip(table.len());
                let mut offset = 0;
                let mut columns = Vec::new();
                for (p, property) in element.properties.iter().enumerate() {
                    let cells = if wanted(p) { column(table, stride, offset, property.scalar, encoding) } else { Vec::new() };
                    columns.push(cells);
                    offset += property.scalar.size();
                }
                columns
            }
            _ => {
                let mut columns = vec![Vec::new(); element.properties.len()];
                let wanted: Vec<bool> = (0..columns.len()).map(wanted).collect();
                let position = &position;
                rows(
                    element,
                    numbers,
                    |p, x, numbers: &mut N| {
                        if !x.is_finite() && position.contains(&p) {
                            return Err(numbers.mistake(format!("this vertex is not finite: {x}")));
                        }
                        if wanted[p] {
                            columns[p].push(x);
                        }
                        Ok(())
                    },
                    |_, _, _| Ok(()),
                )?;
                columns
            }
        };

        self.mesh.positions = vectors(&columns, position);
        if let Some(i) = self.mesh.positions.iter().position(|p| !p.is_finite()) {
            let at = start + element.stride().unwrap_or(0) * i;
            return Err(FileError::byte(at, format!("vertex {i} is not finite: {}", self.mesh.positions[i])));
        }
        self.mesh.normals = normal.map(|n| vectors(&columns, n)).unwrap_or_default();
        if let Some([u, v]) = uv {
            let flip = |v: f32| if self.flip_v { 1.0 - v } else { v };
            self.mesh.uvs = (0..element.count).map(|i| Vec2::new(columns[u][i], flip(columns[v][i]))).collect();
        }
        for Named { name, properties } in attributes {
            let columns = &columns;
            let data = (0..element.count).flat_map(|i| properties.iter().map(move |&p| columns[p][i])).collect();
            let channels = properties.len();
            self.mesh.attributes.push(Attribute { name, kind: AttributeKind::Vertex, channels, data });
        }
        Ok(())
    }

    fn faces<N: Numbers>(&mut self, element: &Element, numbers: &mut N) -> Result<(), FileError> {
        let is_corners = |name: &str| matches!(name, "vertex_indices" | "vertex_index");
        let corners = element.properties.iter().position(|p| p.list.is_some() && is_corners(&p.name));
        let corners = corners.ok_or_else(|| FileError::file("element `face` has no list `vertex_indices` or `vertex_index`"))?;
        let names: Vec<&str> = element.properties.iter().map(|p| if p.list.is_some() { "" } else { p.name.as_str() }).collect();
        let attributes = named("face", &names, &[]);
        let wanted: Vec<bool> = (0..names.len()).map(|p| attributes.iter().any(|a| a.properties.contains(&p))).collect();

        // Triangles of each face, needed where faces have attributes; attributes of each face.
        let mut fans: Vec<u32> = Vec::new();
        let mut columns = vec![Vec::new(); names.len()];
        let indices = &mut self.mesh.indices;
        indices.reserve(element.count);
        let (vertex_count, any) = (self.vertex_count as i64, !attributes.is_empty());
        rows(
            element,
            numbers,
            |p, x, _| {
                if wanted[p] {
                    columns[p].push(x);
                }
                Ok(())
            },
            |p, list, numbers: &mut N| {
                if p != corners {
                    return Ok(());
                }
                if let Some(bad) = list.iter().find(|&&i| i < 0 || i >= vertex_count) {
                    return Err(numbers.mistake(format!("vertex {bad} does not exist, there are {vertex_count}, counted from 0")));
                }
                let before = indices.len();
                indices.extend((2..list.len()).map(|i| [list[0] as u32, list[i - 1] as u32, list[i] as u32]));
                if any {
                    fans.push((indices.len() - before) as u32);
                }
                Ok(())
            },
        )?;

        for Named { name, properties } in attributes {
            let of_face = |i: usize| properties.iter().map(|&p| columns[p][i]).collect::<Vec<f32>>();
            let data = fans.iter().enumerate().flat_map(|(i, &n)| of_face(i).repeat(n as usize)).collect();
            let channels = properties.len();
            self.mesh.attributes.push(Attribute { name, kind: AttributeKind::Face, channels, data });
        }
        Ok(())
    }
}

/// The vectors of three columns.
fn vectors(columns: &[Vec<f32>], [x, y, z]: [usize; 3]) -> Vec<Vec3> {
    let pairs = columns[x].iter().zip(&columns[y]).zip(&columns[z]);
    pairs.map(|((&x, &y), &z)| Vec3::new(x, y, z)).collect()
}

/// All rows of an element: `scalar` gets each number with the number of its property, `list` each list of whole numbers.
fn rows<N: Numbers>(
    element: &Element,
    numbers: &mut N,
    mut scalar: impl FnMut(usize, f32, &mut N) -> Result<(), FileError>,
    mut list: impl FnMut(usize, &[i64], &mut N) -> Result<(), FileError>,
) -> Result<(), FileError> {
    if element.properties.is_empty() {
        return Ok(());
    }
    let row = |error: FileError, i: usize| FileError {
        message: format!("{} ({} {i} of {}, counted from 0)", error.message, element.name, element.count),
        ..error
    };
    let mut items = Vec::new();
    for i in 0..element.count {
        for (p, property) in element.properties.iter().enumerate() {
            match property.list {
                None => {
                    let x = numbers.float(property.scalar).map_err(|e| row(e, i))?;
                    scalar(p, x, numbers).map_err(|e| row(e, i))?;
                }
                Some(count) => {
                    let length = numbers.integer(count).map_err(|e| row(e, i))?;
                    if length < 0 || length as u64 > numbers.rest() as u64 {
                        let text = format!("a list of {length} does not fit into the file");
                        return Err(row(numbers.mistake(text), i));
                    }
                    items.clear();
                    for _ in 0..length {
                        items.push(numbers.integer(property.scalar).map_err(|e| row(e, i))?);
                    }
                    list(p, &items, numbers).map_err(|e| row(e, i))?;
                }
            }
        }
    }
    Ok(())
}
