//! Areas of shapes in their places, for lights that are told by their power.

use super::look::{float, get, matrix, vector};
use etendue_description::{Description, MeshData, NodeId, Value};
use glam::{DMat4, DVec3};
use std::f64::consts::PI;

/// The area of a shape and how many pieces share the light's power: of a mesh each triangle has it.
pub(super) fn area(d: &Description, shape: NodeId) -> Option<(f64, usize)> {
    let node = d.node(shape);
    let m = matrix(node, "to_world");
    let radius = float(node, "radius").unwrap_or(1.0).abs();
    let scale = m.x_axis.truncate().length();
    match node.model.value.as_str() {
        "sphere" => Some((4.0 * PI * (radius * scale).powi(2), 1)),
        "disk" => Some((PI * m.x_axis.truncate().cross(m.y_axis.truncate()).length(), 1)),
        "cylinder" => {
            let ends = [("p0", DVec3::ZERO), ("p1", DVec3::Z)].map(|(name, p)| vector(node, name).unwrap_or(p));
            Some((2.0 * PI * radius * scale * (ends[1] - ends[0]).length() * scale, 1))
        }
        "rectangle" => Some((of_mesh(&MeshData::rectangle(), m), 2)),
        "cube" => Some((of_mesh(&MeshData::cube(), m), 12)),
        _ => match get(node, "filename") {
            Some(Value::Mesh(i)) => {
                let mesh = &d.assets.meshes[*i as usize];
                Some((of_mesh(mesh, m), mesh.indices.len().max(1)))
            }
            _ => None,
        },
    }
}

fn of_mesh(mesh: &MeshData, m: DMat4) -> f64 {
    let at = |i: u32| m.transform_point3(mesh.positions[i as usize].as_dvec3());
    mesh.indices.iter().map(|[a, b, c]| 0.5 * (at(*b) - at(*a)).cross(at(*c) - at(*a)).length()).sum()
}
