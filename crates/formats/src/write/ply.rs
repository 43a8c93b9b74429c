//! Meshes as binary PLY of little byte order, with named attributes: what [`crate::mesh::ply`] reads back as the same mesh.

use etendue_description::{Attribute, AttributeKind, MeshData};
use std::fmt::Write as _;

/// The bytes of a mesh's file.
pub(super) fn bytes(mesh: &MeshData) -> Vec<u8> {
    let of = |kind: AttributeKind| -> Vec<&Attribute> { mesh.attributes.iter().filter(|a| a.kind == kind).collect() };
    let (on_vertices, on_faces) = (of(AttributeKind::Vertex), of(AttributeKind::Face));
    let mut header = String::from("ply\nformat binary_little_endian 1.0\ncomment written by etendue\n");
    let _ = writeln!(header, "element vertex {}", mesh.positions.len());
    let mut property = |names: &[String]| names.iter().for_each(|name| header.push_str(&format!("property float {name}\n")));
    let plain = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
    property(&plain(&["x", "y", "z"]));
    if !mesh.normals.is_empty() {
        property(&plain(&["nx", "ny", "nz"]));
    }
    if !mesh.uvs.is_empty() {
        property(&plain(&["u", "v"]));
    }
    on_vertices.iter().for_each(|a| property(&names(a, "vertex_")));
    let _ = writeln!(header, "element face {}\nproperty list uchar int vertex_indices", mesh.indices.len());
    for attribute in &on_faces {
        names(attribute, "face_").iter().for_each(|name| header.push_str(&format!("property float {name}\n")));
    }
    header.push_str("end_header\n");

    let mut out = header.into_bytes();
    let floats = |out: &mut Vec<u8>, list: &[f32]| list.iter().for_each(|x| out.extend_from_slice(&x.to_le_bytes()));
    for i in 0..mesh.positions.len() {
        floats(&mut out, &mesh.positions[i].to_array());
        if let Some(n) = mesh.normals.get(i) {
            floats(&mut out, &n.to_array());
        }
        if let Some(uv) = mesh.uvs.get(i) {
            floats(&mut out, &uv.to_array());
        }
        on_vertices.iter().for_each(|a| floats(&mut out, row(a, i)));
    }
    for (i, triangle) in mesh.indices.iter().enumerate() {
        out.push(3);
        triangle.iter().for_each(|k| out.extend_from_slice(&k.to_le_bytes()));
        on_faces.iter().for_each(|a| floats(&mut out, row(a, i)));
    }
    out
}

fn row(attribute: &Attribute, i: usize) -> &[f32] {
    &attribute.data[i * attribute.channels..][..attribute.channels]
}

/// The properties of an attribute, by the rule that `mesh::attributes` reads them by.
fn names(attribute: &Attribute, prefix: &str) -> Vec<String> {
    let name = attribute.name.strip_prefix(prefix).unwrap_or(&attribute.name);
    let letters = |stem: &str, letters: &[&str]| letters.iter().map(|l| format!("{stem}{l}")).collect();
    match (name, attribute.channels) {
        ("color", 3) => letters("", &["r", "g", "b"]),
        (_, 3) => match name.strip_suffix("_color") {
            Some(stem) => letters(&format!("{stem}_"), &["r", "g", "b"]),
            None => letters(&format!("{name}_"), &["x", "y", "z"]),
        },
        _ => letters(&format!("{name}_"), &["x"]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};

    #[test]
    fn a_mesh_comes_back_as_it_was() {
        let attribute = |name: &str, kind, channels, n| Attribute {
            name: name.to_owned(),
            kind,
            channels,
            data: (0..channels * n).map(|i| 0.1 * i as f32).collect(),
        };
        let normals =
            [Vec3::new(0.6, 0.8, 0.0), Vec3::new(1.0, 2.0, 3.0).normalize(), Vec3::Z, Vec3::new(-0.3, 0.1, 7.0).normalize()];
        let mesh = MeshData {
            positions: vec![Vec3::new(0.1, 0.2, 1.0 / 3.0), Vec3::X, Vec3::Y, Vec3::new(-1e-20, 1e20, 5.0)],
            normals: normals.to_vec(),
            uvs: (0..4).map(|i| Vec2::new(i as f32 / 3.0, 0.7)).collect(),
            indices: vec![[0, 1, 2], [2, 1, 3]],
            attributes: vec![
                attribute("vertex_color", AttributeKind::Vertex, 3, 4),
                attribute("vertex_heat", AttributeKind::Vertex, 1, 4),
                attribute("vertex_flow", AttributeKind::Vertex, 3, 4),
                attribute("face_tint_color", AttributeKind::Face, 3, 2),
                attribute("face_id", AttributeKind::Face, 1, 2),
            ],
            ..MeshData::default()
        };
        for mesh in [mesh.clone(), MeshData { normals: Vec::new(), uvs: Vec::new(), attributes: Vec::new(), ..mesh }] {
            let read = crate::mesh::ply::read(&bytes(&mesh), false).unwrap();
            assert_eq!(read.warnings, Vec::<String>::new());
            assert_eq!(read.mesh, mesh);
        }
    }
}
