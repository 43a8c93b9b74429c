//! Triangles, flat and spherical.

use super::unit;
use crate::math::{atan2, safe_sqrt, sin_cos};
use crate::{DVec3, Vec2, Vec3};

/// Barycentric coordinates (b₀, b₁, b₂), uniform over the triangle (density 1/area).
///
/// The half of the square on each side of its diagonal is pressed onto a half of the triangle: less distortion than the square-root
/// map, and no root [Heitz 2019].
#[inline]
pub fn square_to_triangle(u: Vec2) -> [f32; 3] {
    let (b0, b1) = if u.x < u.y {
        let b0 = 0.5 * u.x;
        (b0, u.y - b0)
    } else {
        let b1 = 0.5 * u.y;
        (u.x - b1, b1)
    };
    [b0, b1, 1.0 - b0 - b1]
}

/// The u that [`square_to_triangle`] takes to the barycentric coordinates (b₀, b₁).
#[inline]
pub fn triangle_to_square(b0: f32, b1: f32) -> Vec2 {
    let u = if b0 < b1 { Vec2::new(2.0 * b0, b0 + b1) } else { Vec2::new(b0 + b1, 2.0 * b1) };
    Vec2::new(unit(u.x), unit(u.y))
}

/// A triangle as seen from a point: directions uniform in solid angle [Arvo 1995].
///
/// With A, B, C the directions to the corners, α the angle at A and Ω the solid angle:
///
/// ```text
/// tan(Ω/2) = |A·(B × C)| / (1 + A·B + B·C + C·A)                              [Van Oosterom, Strackee 1983]
/// C' on the arc AC so that A B C' has solid angle a = u₀ Ω;   P on the arc BC' with 1 - P·B = u₁ (1 - C'·B)
/// 1 - A·C' = k (2 - κ) / (k - κ sinα sin(a - α)),   k = 1 - cos a,   κ = 1 - A·B
/// ```
///
/// The last line is Arvo's cosine of the arc, subtracted from 1 and simplified: every term keeps its relative precision for small triangles,
/// where the published form loses all of it. Good to a relative 1e-4 down to Ω of about 1e-7 sr (in f32, by tests).
#[derive(Clone, Copy, Debug)]
pub struct SphericalTriangle {
    a: Vec3,
    b: Vec3,
    c: Vec3,
    /// Unit vector orthogonal to A in the plane of A and C.
    towards_c: Vec3,
    kappa: f32,
    sin_alpha: f32,
    cos_alpha: f32,
    omega: f32,
}

impl SphericalTriangle {
    /// The triangle with its corners relative to the point that it is seen from; `None` where it is seen edge-on or has no size.
    pub fn new(a: Vec3, b: Vec3, c: Vec3) -> Option<Self> {
        let unit = |v: Vec3| v.as_dvec3().try_normalize();
        let (a, b, c) = (unit(a)?, unit(b)?, unit(c)?);
        let (ab, ac) = (b - a, c - a);
        let volume = a.dot(ab.cross(ac)).abs();
        let omega = 2.0 * atan2(volume as f32, (1.0 + a.dot(b) + b.dot(c) + c.dot(a)) as f32);

        // α lies between the planes AB and AC: their normals A × B and A × C enclose it.
        let (n, m) = (a.cross(ab), a.cross(ac));
        let lengths = n.length() * m.length();
        let sin_alpha = volume / lengths;
        let along_a: DVec3 = a * a.dot(ac);
        let towards_c = (ac - along_a).try_normalize()?;
        let fine = omega > 0.0 && sin_alpha > 0.0 && sin_alpha.is_finite();
        fine.then_some(Self {
            a: a.as_vec3(),
            b: b.as_vec3(),
            c: c.as_vec3(),
            towards_c: towards_c.as_vec3(),
            kappa: (0.5 * ab.length_squared()) as f32,
            sin_alpha: sin_alpha as f32,
            cos_alpha: (n.dot(m) / lengths) as f32,
            omega,
        })
    }

    /// The solid angle Ω, sr.
    #[inline]
    pub fn solid_angle(&self) -> f32 {
        self.omega
    }

    /// The density of [`SphericalTriangle::sample`], 1/Ω; for directions that meet the triangle.
    #[inline]
    pub fn pdf(&self) -> f32 {
        1.0 / self.omega
    }

    /// A direction towards the triangle, uniform in solid angle.
    #[inline]
    pub fn sample(&self, u: Vec2) -> Vec3 {
        // The corner C' of the part with solid angle a = u₀ Ω.
        let (s, c) = sin_cos(0.5 * self.omega * u.x);
        let (sin_a, k) = (2.0 * s * c, 2.0 * s * s);
        let sin_a_alpha = sin_a * self.cos_alpha - (1.0 - k) * self.sin_alpha;
        let denominator = k - self.kappa * self.sin_alpha * sin_a_alpha;
        let limit = 0.5 * (self.c - self.a).length_squared();
        let h = if denominator > 0.0 { (k * (2.0 - self.kappa) / denominator).clamp(0.0, limit) } else { 0.0 };
        let corner = self.a * (1.0 - h) + self.towards_c * safe_sqrt(h * (2.0 - h));

        // P on the arc from B to C'.
        let chord = corner - self.b;
        let along_b = self.b * self.b.dot(chord);
        let Some(towards_corner) = (chord - along_b).try_normalize() else {
            return self.b;
        };
        let h = 0.5 * u.y * chord.length_squared();
        (self.b * (1.0 - h) + towards_corner * safe_sqrt(h * (2.0 - h))).normalize()
    }
}
