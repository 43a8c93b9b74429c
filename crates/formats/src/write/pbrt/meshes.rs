//! Meshes: as lists of numbers where they are small, else as PLY.
//!
//! | étendue | pbrt |
//! | --- | --- |
//! | no vertex normals, of Mitsuba | `N` made from the faces around, as étendue makes them |
//! | `face_normals` | no `N` |
//! | flat faces under a map that mirrors space: the front is that of the winding in the world | in the object: `ReverseOrientation` |

use super::Writer;
use super::list::List;
use crate::mesh::finish::finish;
use crate::write::beside::Beside;
use crate::write::look::{flag, get, matrix};
use etendue_description::{Dialect, MeshData, NodeId, Value};
use glam::{DMat3, DMat4, Vec3};
use std::sync::Arc;

/// Larger meshes become files.
const MOST_INLINE: usize = 64;

/// A shape in pbrt's words.
pub(super) struct Geometry {
    pub model: &'static str,
    pub list: List,
    /// Its place.
    pub place: DMat4,
    /// Whether its normals are turned round.
    pub reverse: bool,
}

impl Writer<'_, '_> {
    /// A shape that holds a mesh.
    pub(super) fn mesh(&mut self, id: NodeId) -> Option<Geometry> {
        let node = self.d.node(id);
        let Some(Value::Mesh(index)) = get(node, "filename") else { return None };
        let data = self.d.assets.meshes[*index as usize].clone();
        let place = matrix(node, "to_world");
        let mut reverse = flag(node, "flip_normals", false);
        let (mut mesh, mut variant) = (data.clone(), String::new());
        if self.d.dialect == Dialect::Mitsuba {
            let flat = flag(node, "face_normals", false);
            reverse ^= flat && DMat3::from_mat4(place).determinant() < 0.0;
            if flat && !data.normals.is_empty() {
                (mesh, variant) = (Arc::new(MeshData { normals: Vec::new(), ..(*data).clone() }), "flat".to_owned());
            } else if !flat && data.normals.is_empty() {
                (mesh, variant) = (Arc::new(smooth(&data, place)), format!("smooth {}", id.0));
            }
        }
        let mut list = List::default();
        let is_ply = node.model.value == "ply" && variant.is_empty() && !flag(node, "flip_tex_coords", false);
        let model = if is_ply && Beside::is_on_disk(&data.path) {
            list.string("filename", &self.beside.refer(self.d, &data.path));
            "plymesh"
        } else if mesh.indices.len() <= MOST_INLINE {
            inline(&mut list, &mesh);
            "trianglemesh"
        } else {
            list.string("filename", &self.beside.mesh(*index, &variant, &mesh));
            "plymesh"
        };
        Some(Geometry { model, list, place, reverse })
    }
}

/// A mesh as lists of numbers.
pub(super) fn inline(list: &mut List, mesh: &MeshData) {
    list.integers("indices", mesh.indices.iter().flatten().map(|i| i64::from(*i)));
    list.points("point3", "P", &mesh.positions);
    if !mesh.normals.is_empty() {
        list.points("normal", "N", &mesh.normals);
    }
    if !mesh.uvs.is_empty() {
        list.points2("uv", &mesh.uvs);
    }
}

/// The mesh with normals that are those of the faces around each vertex, as they lie in the world.
fn smooth(mesh: &MeshData, place: DMat4) -> MeshData {
    let mut world = mesh.clone();
    world.attributes.clear();
    world.positions.iter_mut().for_each(|p| *p = place.transform_point3(p.as_dvec3()).as_vec3());
    world.normals = vec![Vec3::ZERO; mesh.positions.len()];
    let back = DMat3::from_mat4(place).transpose();
    let normals = finish(world, 0).mesh.normals;
    let normals = normals.into_iter().map(|n| (back * n.as_dvec3()).normalize_or_zero().as_vec3()).collect();
    MeshData { normals, ..mesh.clone() }
}
