//! A triangle by value: what a mesh knows of it, gathered, so that many hits can be worked on side by side.
//!
//! [`Triangle::surface`] is `Mesh::interaction` without branches, the same bits: a loop over it can be made of vectors.

use super::Mesh;
use etendue_numerics::math::gamma;
use etendue_numerics::{Frame, Vec2, Vec3};

/// What shading wants to know of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Its corners.
    pub corners: [Vec3; 3],
    /// Their normals; not looked at where `error` is not negative.
    pub normals: [Vec3; 3],
    /// Their texture coordinates; not looked at without `has_uv`.
    pub uvs: [Vec2; 3],
    /// Unit normal of the face.
    pub n: Vec3,
    /// The part of the points' error bound that is the same all over; below zero where vertex normals bend the surface.
    pub error: f32,
    /// Whether the mesh has texture coordinates.
    pub has_uv: bool,
    /// Whether normals are turned round.
    pub flipped: bool,
}

/// A point of a surface, as far as scattering of light on it goes; see `Interaction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceFrame {
    /// The point.
    pub p: Vec3,
    /// Bound on its rounding error.
    pub p_error: Vec3,
    /// Unit geometric normal.
    pub n: Vec3,
    /// Shading frame.
    pub shading: Frame,
}

impl Mesh {
    /// A triangle by value.
    #[inline(always)]
    pub fn triangle(&self, i: u32) -> Triangle {
        let index = self.indices[i as usize];
        let (n, error) = self.face(i);
        Triangle {
            corners: self.corners(index),
            normals: if error < 0.0 { index.map(|i| self.normals[i as usize]) } else { [n; 3] },
            uvs: if self.uvs.is_empty() { [Vec2::ZERO; 3] } else { index.map(|i| self.uvs[i as usize]) },
            n,
            error,
            has_uv: !self.uvs.is_empty(),
            flipped: self.flip_normals,
        }
    }
}

/// b0 x0 + b1 x1 + b2 x2.
#[inline(always)]
fn interpolate<T: Copy + std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>>(x: &[T; 3], b: [f32; 3]) -> T {
    x[0] * b[0] + x[1] * b[1] + x[2] * b[2]
}

/// `v` of unit length; `otherwise` where it has none.
#[inline(always)]
fn unit_or(v: Vec3, otherwise: Vec3) -> Vec3 {
    let scale = v.length_recip();
    if scale.is_finite() & (scale > 0.0) { v * scale } else { otherwise }
}

impl Triangle {
    /// The point at barycentrics (b1, b2).
    #[inline(always)]
    pub fn surface(&self, bary: Vec2) -> SurfaceFrame {
        let b = [1.0 - bary.x - bary.y, bary.x, bary.y];
        let [q0, q1, q2] = [self.corners[0] * b[0], self.corners[1] * b[1], self.corners[2] * b[2]];
        let p = q0 + q1 + q2;
        let p_error = (q0.abs() + q1.abs() + q2.abs()) * gamma(7) + Vec3::splat(self.error.abs());

        // The shading normal, and the geometric one on its side.
        let bent = unit_or(interpolate(&self.normals, b), self.n);
        let ns = if self.error < 0.0 { bent } else { self.n };
        let n = if self.error < 0.0 && self.n.dot(ns) < 0.0 { -self.n } else { self.n };
        let (n, ns) = if self.flipped { (-n, -ns) } else { (n, ns) };

        // The tangent ∂p/∂u.
        let (e1, e2) = (self.corners[1] - self.corners[0], self.corners[2] - self.corners[0]);
        let (d1, d2) = (self.uvs[1] - self.uvs[0], self.uvs[2] - self.uvs[0]);
        let scale = d1.perp_dot(d2).recip();
        let (along_u, along_v) = ((e1 * d2.y - e2 * d1.y) * scale, (e2 * d1.x - e1 * d2.x) * scale);
        let spans = finite(along_u) & finite(along_v);
        let dp_du = if !self.has_uv {
            e1
        } else if spans {
            along_u
        } else {
            Frame::from_normal(self.n).s
        };

        // Gram-Schmidt, or any frame.
        let s = dp_du - ns * ns.dot(dp_du);
        let any = Frame::from_normal(ns);
        let scale = s.length_recip();
        let some = scale.is_finite() & (scale > 0.0);
        let s = s * scale;
        let shading = Frame { s: if some { s } else { any.s }, t: if some { ns.cross(s) } else { any.t }, n: ns };
        SurfaceFrame { p, p_error, n, shading }
    }
}

#[inline(always)]
fn finite(v: Vec3) -> bool {
    v.x.is_finite() & v.y.is_finite() & v.z.is_finite()
}
