//! Shapes: meshes as they are, quadrics whole or as meshes, curves and subdivision surfaces as meshes.
//!
//! Normals: pbrt's front is (p1 - p0) × (p2 - p0) in the object's coordinates, or the side of the vertex normals; `ReverseOrientation` turns
//! it round. Faces without vertex normals are flat.

use super::values::List;
use super::{Reader, child, curves, param, quadrics, subdivision};
use crate::assets::Format;
use crate::mesh::finish::finish;
use etendue_description::{Kind, MeshData, NodeId, Param, Span, Spanned, Value};
use etendue_numerics::Transform;
use glam::{DMat3, DMat4, DVec3, Vec2, Vec3};

const SHAPES: [&str; 8] = ["bilinearmesh", "curve", "cylinder", "disk", "loopsubdiv", "plymesh", "sphere", "trianglemesh"];

const REFUSED: [(&str, &str); 5] = [
    ("cone", "pbrt-v4 has no such shape"),
    ("paraboloid", "pbrt-v4 has no such shape"),
    ("hyperboloid", "pbrt-v4 has no such shape"),
    ("nurbs", "pbrt-v4 has no such shape"),
    ("heightfield", "pbrt-v4 has no such shape"),
];

/// How much of a shape is there, by its `alpha`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Opacity {
    /// All of it.
    Full,
    /// More here, less there.
    Partial,
    /// Nothing: a light shines unseen.
    None,
}

impl Opacity {
    fn of(alpha: Option<&Spanned<Value>>) -> Self {
        match alpha.map(|a| &a.value) {
            None => Self::Full,
            Some(Value::Float(x)) if *x >= 1.0 => Self::Full,
            Some(Value::Float(x)) if *x <= 0.0 => Self::None,
            Some(_) => Self::Partial,
        }
    }
}

/// A shape's model and parameters.
pub(super) type Geometry = (&'static str, Vec<Param>);

impl Reader<'_> {
    pub(super) fn shape(&mut self, name: &str, mut list: List) {
        let span = list.span;
        let list = &mut list;
        let to_world = self.still(span, "this shape");
        let to_world = to_world.unwrap_or_default();
        // A file is tied to its node, which comes later.
        let mut file = None;
        let geometry = match name {
            "trianglemesh" => self.triangle_mesh(list),
            "plymesh" => {
                file = self.ply_mesh(list);
                file.is_some().then(|| ("ply", Vec::new()))
            }
            "bilinearmesh" => self.bilinear_mesh(list),
            "sphere" => quadrics::sphere(self, list, &to_world),
            "disk" => quadrics::disk(self, list),
            "cylinder" => quadrics::cylinder(self, list, &to_world),
            "curve" => curves::curve(self, list),
            "loopsubdiv" => subdivision::subdivided(self, list),
            _ => {
                self.unknown_model(list, "shape", name, &SHAPES, &REFUSED);
                return;
            }
        };
        let alpha = self.number(list, "alpha").map(|alpha| Spanned { value: self.constant_folded(alpha.value), ..alpha });
        list.finish(&mut self.diagnostics);
        let Some((model, mut params)) = geometry else { return };

        let placed = params.iter().position(|p| p.name.value == "to_world");
        let place = match placed.map(|i| params.swap_remove(i).value.value) {
            Some(Value::Transform(inner)) => inner.then(&to_world),
            _ => to_world,
        };
        params.push(param("to_world", Value::Transform(Box::new(place)), span));
        if self.state.reverse_orientation && !params.iter().any(|p| p.name.value == "flip_normals") {
            params.push(param("flip_normals", Value::Bool(true), span));
        }
        if let Some((_, at)) = &file {
            params.push(param("filename", Value::String(String::new()), *at));
        }

        let material = match self.state.material {
            Some(material) => material,
            None => self.default_material(span),
        };
        let bare = self.description.node(material).model.value == "null";
        let opacity = Opacity::of(alpha.as_ref());
        // Nobody looks at the material of a light that is not there.
        let emits = self.state.area_light.is_some() && self.object.is_none() && !bare;
        let material = if emits && opacity == Opacity::None { material } else { self.with_holes(material, alpha) };
        params.push(child(material, span));
        if self.state.area_light.is_some() {
            if self.object.is_some() {
                self.once(span, "shapes of an object cannot emit: the area light is left out");
            } else if bare {
                self.once(span, "a shape of material `interface` cannot emit: the area light is left out");
            } else if let Some(light) = self.area_light(opacity) {
                params.push(child(light, span));
            }
        }
        params.extend(self.shape_media());

        let node = match self.object {
            Some(group) => {
                let node = self.node(Kind::Shape, model, span, params);
                self.description.nodes[group.0 as usize].params.push(child(node, span));
                node
            }
            None => self.top(Kind::Shape, model, span, params),
        };
        if let Some((path, at)) = file {
            self.wanted.note(path, Format::Ply { flip_v: false }, node, at);
        }
    }

    /// A texture that is the same everywhere as its number.
    fn constant_folded(&self, value: Value) -> Value {
        let Value::Node(id) = value else { return value };
        let node = self.description.node(id);
        let constant = node.params.iter().find(|p| node.model.value == "constant" && p.name.value == "value");
        match constant.map(|p| &p.value.value) {
            Some(Value::Float(x)) => Value::Float(*x),
            _ => value,
        }
    }

    /// The material, seen through where `alpha` is below 1.
    fn with_holes(&mut self, material: NodeId, alpha: Option<Spanned<Value>>) -> NodeId {
        let Some(alpha) = alpha else { return material };
        let key = match &alpha.value {
            Value::Float(x) if *x >= 1.0 => return material,
            Value::Float(x) => x.to_bits(),
            Value::Node(id) => u64::from(id.0) | 0x7FF8 << 48,
            _ => return material,
        };
        if let Some(known) = self.masks.get(&(material, key)) {
            return *known;
        }
        let params = vec![param("opacity", alpha.value, alpha.span), child(material, alpha.span)];
        let mask = self.node(Kind::Bsdf, "mask", alpha.span, params);
        self.masks.insert((material, key), mask);
        mask
    }

    fn ply_mesh(&mut self, list: &mut List) -> Option<(std::path::PathBuf, Span)> {
        if list.has("displacement") {
            self.diagnostics.warning(list.span_of("displacement"), "`displacement` of a mesh is not applied: it stays as it is");
        }
        let _ = self.number(list, "displacement");
        list.ignore(&["edgelength"]);
        let Some((name, span)) = list.text_opt(&mut self.diagnostics, "filename") else {
            if !list.has("filename") {
                self.diagnostics.error(list.span, "`plymesh` needs a `filename`");
            }
            return None;
        };
        Some((self.find(&name, span)?, span))
    }

    /// Triples of indices, each within `count`.
    pub(super) fn triangles(&mut self, list: &mut List, count: usize, group: usize) -> Option<Vec<i32>> {
        let span = list.span_of("indices");
        let indices = match list.integers(&mut self.diagnostics, "indices") {
            Some(indices) => indices,
            // One face needs no indices.
            None if !list.has("indices") && count == group => (0..group as i32).collect(),
            None => {
                if !list.has("indices") {
                    self.diagnostics.error(list.span, format!("{} needs `indices`", list.owner));
                }
                return None;
            }
        };
        if !indices.len().is_multiple_of(group) {
            let text = format!("{} indices are no faces: expected a multiple of {group}", indices.len());
            self.diagnostics.error(span, text);
            return None;
        }
        if let Some(wrong) = indices.iter().find(|i| **i < 0 || **i as usize >= count) {
            let text = format!("the index {wrong} names no vertex: there are {count}, counted from 0");
            self.diagnostics.error(span, text);
            return None;
        }
        Some(indices)
    }

    /// `P`, which must be there.
    pub(super) fn positions(&mut self, list: &mut List) -> Option<Vec<Vec3>> {
        if !list.has("P") {
            self.diagnostics.error(list.span, format!("{} needs vertex positions `P`", list.owner));
        }
        list.points(&mut self.diagnostics, "P").filter(|p| !p.is_empty())
    }

    /// A list of as many elements as there are vertices, or none.
    fn per_vertex<T>(&mut self, list: &List, name: &str, values: Option<Vec<T>>, count: usize) -> Vec<T> {
        let values = values.unwrap_or_default();
        if values.is_empty() || values.len() == count {
            return values;
        }
        let text = format!("`{name}` has {} elements for {count} vertices", values.len());
        self.diagnostics.error(list.span_of(name), text);
        Vec::new()
    }

    fn triangle_mesh(&mut self, list: &mut List) -> Option<Geometry> {
        let positions = self.positions(list)?;
        let normals = list.points(&mut self.diagnostics, "N");
        let normals = self.per_vertex(list, "N", normals, positions.len());
        let uvs = list.points2(&mut self.diagnostics, "uv");
        let uvs = self.per_vertex(list, "uv", uvs, positions.len());
        // Tangents turn what is anisotropic; here ∂p/∂u does.
        let _ = list.points(&mut self.diagnostics, "S");
        let _ = list.integers(&mut self.diagnostics, "faceIndices");
        let indices = self.triangles(list, positions.len(), 3)?;
        let indices = indices.as_chunks::<3>().0.iter().map(|t| t.map(|i| i as u32)).collect();
        self.finished(list.span, MeshData { positions, normals, uvs, indices, ..MeshData::default() })
    }

    /// A mesh that is complete, as a shape.
    pub(super) fn finished(&mut self, span: Span, mesh: MeshData) -> Option<Geometry> {
        let loaded = finish(mesh, 0);
        for warning in loaded.warnings {
            self.diagnostics.warning(span, warning);
        }
        let mesh = self.mesh(loaded.mesh);
        Some(("trianglemesh", vec![param("filename", mesh, span)]))
    }

    fn bilinear_mesh(&mut self, list: &mut List) -> Option<Geometry> {
        let positions = self.positions(list)?;
        let normals = list.points(&mut self.diagnostics, "N");
        let normals = self.per_vertex(list, "N", normals, positions.len());
        let uvs = list.points2(&mut self.diagnostics, "uv");
        let uvs = self.per_vertex(list, "uv", uvs, positions.len());
        let _ = list.integers(&mut self.diagnostics, "faceIndices");
        if list.text_opt(&mut self.diagnostics, "emissionfilename").is_some() {
            let at = list.span_of("emissionfilename");
            self.diagnostics.warning(at, "`emissionfilename` is not applied: the patch shines evenly");
        }
        let patches = self.triangles(list, positions.len(), 4)?;
        let mut mesh = MeshData::default();
        for patch in patches.as_chunks::<4>().0 {
            let at = patch.map(|i| i as usize);
            let p = at.map(|i| positions[i].as_dvec3());
            // A flat patch is two triangles; a bent one is as many as its bend asks for.
            let bend = (p[0] - p[1] - p[2] + p[3]).length();
            let size = (p[3] - p[0]).length().max((p[2] - p[1]).length());
            let n = if bend <= 1e-5 * size { 1 } else { ((bend / size * 400.0).sqrt().ceil() as u32).clamp(4, 32) };
            let first = mesh.positions.len() as u32;
            for j in 0..=n {
                for i in 0..=n {
                    let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                    let w = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
                    let point: DVec3 = (0..4).map(|k| p[k] * w[k]).sum();
                    let (du, dv) = ((p[1] - p[0]) * (1.0 - v) + (p[3] - p[2]) * v, (p[2] - p[0]) * (1.0 - u) + (p[3] - p[1]) * u);
                    mesh.positions.push(point.as_vec3());
                    let normal = if normals.is_empty() {
                        du.cross(dv).as_vec3()
                    } else {
                        (0..4).map(|k| normals[at[k]] * w[k] as f32).sum()
                    };
                    mesh.normals.push(normal.normalize_or_zero());
                    let corners = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE];
                    let uv = (0..4).map(|k| if uvs.is_empty() { corners[k] } else { uvs[at[k]] } * w[k] as f32).sum();
                    mesh.uvs.push(uv);
                }
            }
            mesh.indices.extend(grid(n, n).map(|t| t.map(|i| first + i)));
        }
        self.finished(list.span, mesh)
    }
}

/// The triangles of a grid of `columns` by `rows` cells whose vertices stand row by row.
pub(super) fn grid(columns: u32, rows: u32) -> impl Iterator<Item = [u32; 3]> {
    (0..rows).flat_map(move |j| {
        (0..columns).flat_map(move |i| {
            let a = j * (columns + 1) + i;
            let (b, c, d) = (a + 1, a + columns + 1, a + columns + 2);
            [[a, b, d], [a, d, c]]
        })
    })
}

/// Whether a map keeps spheres round.
pub(super) fn keeps_round(to_world: &Transform) -> bool {
    let m = DMat3::from_mat4(to_world.matrix());
    let first = m.x_axis.length_squared();
    let round = (m.transpose() * m - DMat3::from_diagonal(DVec3::splat(first))).abs();
    round.to_cols_array().iter().all(|x| *x <= 2e-5 * first)
}

/// A translation along z and a scale.
pub(super) fn raised(scale: DVec3, z: f64) -> Option<Transform> {
    Transform::new(DMat4::from_translation(DVec3::Z * z) * DMat4::from_scale(scale))
}
