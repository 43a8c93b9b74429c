//! Triangle meshes.
//!
//! ```text
//! p = b0 p0 + b1 p1 + b2 p2,    b0 = 1 - b1 - b2;  the same for texture coordinates, normals and attributes
//! ```
//!
//! | | |
//! | --- | --- |
//! | n | (p1 - p0) × (p2 - p0), turned to the side of the shading normal where the mesh has normals |
//! | ∂p/∂u, ∂p/∂v | from p and uv; without texture coordinates (u, v) = (b1, b2), in pbrt's coordinates (b1 + b2, b2) |
//!
//! The accelerator keeps triangles of its own for intersection; this is what shading looks at.

use super::patch::Quad;
use super::{Geometry, SurfacePoint};
use crate::interaction::Interaction;
use etendue_accel::{CustomHit, Hit};
use etendue_description::{Attribute, AttributeKind};
use etendue_numerics::math::gamma;
use etendue_numerics::{Bounds3, Frame, Ray, Vec2, Vec3, wide};
use glam::DVec3;

/// Triangles with what shading wants to know of them.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Unit vertex normals; empty where faces are shaded flat.
    pub normals: Vec<Vec3>,
    /// Texture coordinates; empty where there are none.
    pub uvs: Vec<Vec2>,
    /// Triangles.
    pub indices: Vec<[u32; 3]>,
    /// Named data on vertices or faces.
    pub attributes: Vec<Attribute>,
    /// Both normals are turned round.
    pub flip_normals: bool,
    /// Whether triangles without texture coordinates have (0, 0), (1, 0), (1, 1) at their corners, as in pbrt.
    pub pbrt_uv: bool,
    /// Two triangles side by side in one plane: one primitive to light samplers.
    pub(super) quad: Option<Quad>,
    /// What every hit on a triangle asks for.
    pub(super) faces: Vec<Face>,
}

/// What does not change over a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// Unit geometric normal. Where the triangle is flat it is on the side of the vertex normals, if there are any.
    n: Vec3,
    /// The part of a point's error bound that is the same all over the triangle; below zero where vertex normals bend the surface.
    error: f32,
}

impl Face {
    fn of(mesh: &Mesh, triangle: [u32; 3]) -> Self {
        // The test that a ray leaving the triangle is put to rounds the corners as seen from its origin, and the normal; thin triangles amplify
        // that. The factor is measured: four times the worst of a million.
        let corners = mesh.corners(triangle);
        let twice_area = cross(corners);
        let extent = Bounds3::of(corners).size().max_element();
        let thinness = (extent * extent / twice_area.length() as f32).clamp(1.0, 1e5);
        let error = extent * (gamma(2) + gamma(1) * 0.5 * thinness);

        let n = twice_area.normalize_or(DVec3::Z).as_vec3();
        if mesh.normals.is_empty() {
            return Self { n, error };
        }
        // Vertex normals that are the triangle's own need not be looked up.
        let bend = |side: Vec3| triangle.iter().map(|i| (mesh.normals[*i as usize] - side).length_squared()).fold(0.0, f32::max);
        match (bend(n) < 1e-12, bend(-n) < 1e-12) {
            (true, _) => Self { n, error },
            (_, true) => Self { n: -n, error },
            _ => Self { n, error: -error },
        }
    }
}

impl Mesh {
    /// The same mesh, to be called when its fields are set: two triangles that make a flat quadrilateral become one primitive.
    pub fn finish(mut self) -> Self {
        self.quad = Quad::of(&self);
        self.faces = self.indices.iter().map(|t| Face::of(&self, *t)).collect();
        self
    }

    /// Unit normal of a triangle, and the part of its points' error bound that is the same all over; below zero where vertex normals bend the surface.
    #[inline(always)]
    pub fn face(&self, triangle: u32) -> (Vec3, f32) {
        let Face { n, error } = self.faces[triangle as usize];
        (n, error)
    }

    /// The triangle's number as a primitive: a quadrilateral is one.
    #[inline]
    pub fn primitive(&self, triangle: u32) -> u32 {
        if self.quad.is_some() { 0 } else { triangle }
    }

    /// Asks for the memory of a triangle ahead of its use: of what is known of it, then of its corners, then of what else shading looks at there.
    pub fn fetch(&self, triangle: u32, stage: u32) {
        let index = &self.indices[triangle as usize];
        match stage {
            0 => {
                wide::fetch(index);
                wide::fetch(&self.faces[triangle as usize]);
            }
            1 => index.iter().for_each(|i| wide::fetch(&self.positions[*i as usize])),
            _ => {
                index.iter().filter_map(|i| self.normals.get(*i as usize)).for_each(wide::fetch);
                index.iter().filter_map(|i| self.uvs.get(*i as usize)).for_each(wide::fetch);
            }
        }
    }

    /// The corners of a triangle.
    #[inline]
    pub(super) fn corners(&self, [i, j, k]: [u32; 3]) -> [Vec3; 3] {
        [self.positions[i as usize], self.positions[j as usize], self.positions[k as usize]]
    }

    /// The number of an attribute, to be looked up by [`Mesh::attribute`].
    pub fn attribute_index(&self, name: &str) -> Option<usize> {
        self.attributes.iter().position(|a| a.name == name)
    }

    /// An attribute at barycentrics `bary` = (b1, b2) of a triangle; one number is given three times.
    pub fn attribute(&self, index: usize, triangle: u32, bary: Vec2) -> [f32; 3] {
        let a = &self.attributes[index];
        let at = |i: u32, c: usize| a.data[i as usize * a.channels + c.min(a.channels - 1)];
        std::array::from_fn(|c| match a.kind {
            AttributeKind::Face => at(triangle, c),
            AttributeKind::Vertex => {
                let [i, j, k] = self.indices[triangle as usize];
                at(i, c) * (1.0 - bary.x - bary.y) + at(j, c) * bary.x + at(k, c) * bary.y
            }
        })
    }

    /// The point at barycentrics of a triangle.
    #[inline(always)] // as a return value it would go through memory
    pub(super) fn point(&self, triangle: u32, bary: Vec2) -> SurfacePoint {
        // Corners one by one, here and below: an array that moves is stored in pieces, and waited for.
        let index = &self.indices[triangle as usize];
        let b = [1.0 - bary.x - bary.y, bary.x, bary.y];
        let q = |i: usize| self.positions[index[i] as usize] * b[i];
        let (q0, q1, q2) = (q(0), q(1), q(2));
        let p = q0 + q1 + q2;

        // Rounding of the sum [Pharr, Jakob, Humphreys 2023, §6.8.5], and what the triangle adds.
        let Face { mut n, error } = self.faces[triangle as usize];
        let p_error = (q0.abs() + q1.abs() + q2.abs()) * gamma(7) + Vec3::splat(error.abs());

        let mut ns = n;
        if error < 0.0 {
            ns = interpolate(&self.normals, index, b).try_normalize().unwrap_or(n);
            if n.dot(ns) < 0.0 {
                n = -n;
            }
        }
        if self.flip_normals {
            (n, ns) = (-n, -ns);
        }
        let uv = self.uv(triangle, bary);
        SurfacePoint { p, p_error, n, ns, uv, primitive: self.primitive(triangle), bary, pdf_a: 0.0 }
    }

    /// Texture coordinates at barycentrics of a triangle.
    #[inline(always)]
    pub fn uv(&self, triangle: u32, bary: Vec2) -> Vec2 {
        if self.uvs.is_empty() {
            return if self.pbrt_uv { Vec2::new(bary.x + bary.y, bary.y) } else { bary };
        }
        interpolate(&self.uvs, &self.indices[triangle as usize], [1.0 - bary.x - bary.y, bary.x, bary.y])
    }

    /// ∂p/∂u and ∂p/∂v of a triangle; any tangents where its texture coordinates do not span the plane.
    #[inline(always)]
    fn tangents(&self, triangle: u32) -> (Vec3, Vec3) {
        let index = &self.indices[triangle as usize];
        let (p, t) = (|i: usize| self.positions[index[i] as usize], |i: usize| self.uvs[index[i] as usize]);
        let (e1, e2) = (p(1) - p(0), p(2) - p(0));
        if self.uvs.is_empty() {
            return (e1, if self.pbrt_uv { e2 - e1 } else { e2 });
        }
        let (d1, d2) = (t(1) - t(0), t(2) - t(0));
        let determinant = d1.perp_dot(d2);
        let scale = determinant.recip();
        let (dp_du, dp_dv) = ((e1 * d2.y - e2 * d1.y) * scale, (e2 * d1.x - e1 * d2.x) * scale);
        if dp_du.is_finite() && dp_dv.is_finite() {
            return (dp_du, dp_dv);
        }
        let frame = Frame::from_normal(self.faces[triangle as usize].n);
        (frame.s, frame.t)
    }
}

/// (p1 - p0) × (p2 - p0), exact but for f64's rounding: thin triangles keep their normals.
pub(super) fn cross([p0, p1, p2]: [Vec3; 3]) -> DVec3 {
    let p0 = p0.as_dvec3();
    (p1.as_dvec3() - p0).cross(p2.as_dvec3() - p0)
}

/// b0 x0 + b1 x1 + b2 x2.
#[inline(always)]
fn interpolate<T: Copy + std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>>(x: &[T], index: &[u32; 3], b: [f32; 3]) -> T {
    let [i, j, k] = index;
    x[*i as usize] * b[0] + x[*j as usize] * b[1] + x[*k as usize] * b[2]
}

impl Geometry for Mesh {
    fn bounds(&self) -> Bounds3 {
        // Only what a triangle uses: files may hold stray vertices.
        Bounds3::of(self.indices.iter().flatten().map(|i| self.positions[*i as usize]))
    }

    fn primitive_count(&self) -> u32 {
        if self.quad.is_some() { 1 } else { self.indices.len() as u32 }
    }

    fn area_of(&self, primitive: u32) -> f32 {
        self.patch_area(primitive)
    }

    /// Meshes are met by the accelerator.
    fn intersect(&self, _: &Ray) -> Option<CustomHit> {
        None
    }

    #[inline(always)]
    fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
        let point = self.point(hit.primitive, Vec2::new(hit.u, hit.v));
        let (dp_du, dp_dv) = self.tangents(hit.primitive);
        Interaction::at(&point, ray, hit, dp_du, dp_dv)
    }

    #[inline]
    fn sample_area(&self, primitive: u32, u: Vec2) -> SurfacePoint {
        self.patch_by_area(primitive, u)
    }

    #[inline]
    fn pdf_direction(&self, primitive: u32, from: Vec3, at: &Interaction) -> f32 {
        self.patch_pdf(primitive, from, at)
    }

    #[inline]
    fn sample_direction(&self, primitive: u32, from: Vec3, u: Vec2) -> Option<(SurfacePoint, f32)> {
        self.patch_by_direction(primitive, from, u)
    }
}
