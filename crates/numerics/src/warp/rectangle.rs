//! A rectangle as seen from a point: directions uniform in solid angle [Ureña, Fajardo, King 2013].
//!
//! In the frame (x, y along the edges, z towards the viewer, who sits at the origin) the rectangle is [x₀, x₁] × [y₀, y₁] at z₀ < 0.
//! u₀ cuts off the part [x₀, x] × [y₀, y₁] with solid angle u₀ Ω, and u₁ picks y on the cut so that the arc's height is uniform:
//!
//! ```text
//! f = (cos φ · b₀ - b₁) / sin φ,  φ = u₀ Ω + 2π - g₂ - g₃,   x = -z₀ c / √(1 - c²),  c = sgn f / √(f² + b₀²)
//! h = h₀ + u₁ (h₁ - h₀),   y = h d / √(1 - h²),   d² = x² + z₀²,   hᵢ = yᵢ / √(d² + yᵢ²)
//! ```
//!
//! where b₀, b₁ are the z components of the normals of the planes through the edges y₀ and y₁, and g₂, g₃ the inner angles at the corners
//! (x₀, y₁) and (x₀, y₀). Their sines and cosines are algebraic, and Ω is that of two spherical triangles, so a small Ω is not the difference of large angles.

use crate::math::{atan2, sin_cos};
use crate::{DVec3, Vec2, Vec3};

/// A rectangle prepared for sampling by solid angle from one point.
#[derive(Clone, Copy, Debug)]
pub struct SphericalRectangle {
    x: DVec3,
    y: DVec3,
    z: DVec3,
    x0: f64,
    x1: f64,
    y0: f64,
    y1: f64,
    z0: f64,
    b0: f64,
    b1: f64,
    cos_k: f64,
    sin_k: f64,
    omega: f32,
}

impl SphericalRectangle {
    /// The rectangle with one corner at `corner`, relative to the point that it is seen from, and orthogonal edges `ex` and `ey`; `None` where it
    /// is seen edge-on or has no size.
    pub fn new(corner: Vec3, ex: Vec3, ey: Vec3) -> Option<Self> {
        let (corner, ex, ey) = (corner.as_dvec3(), ex.as_dvec3(), ey.as_dvec3());
        let (x, y) = (ex.try_normalize()?, ey.try_normalize()?);
        let n = x.cross(y).try_normalize()?;
        // z points from the rectangle to the viewer.
        let z = if corner.dot(n) > 0.0 { -n } else { n };
        let (x0, y0, z0) = (corner.dot(x), corner.dot(y), corner.dot(z));
        let (x1, y1) = (x0 + ex.length(), y0 + ey.length());
        if z0.is_nan() || z0 >= 0.0 {
            return None;
        }

        // Ω: the sum over the two triangles at the diagonal from (x₀, y₀) to (x₁, y₁).
        let at = |x: f64, y: f64| DVec3::new(x, y, z0).normalize();
        let (p00, p10, p11, p01) = (at(x0, y0), at(x1, y0), at(x1, y1), at(x0, y1));
        let triangle = |a: DVec3, b: DVec3, c: DVec3| {
            let volume = a.dot((b - a).cross(c - a)).abs();
            2.0 * atan2(volume as f32, (1.0 + a.dot(b) + b.dot(c) + c.dot(a)) as f32)
        };
        let omega = triangle(p00, p10, p11) + triangle(p00, p11, p01);

        // φ starts at k = 2π - g₂ - g₃.
        let depth = |t: f64| (z0 * z0 + t * t).sqrt();
        let inner = |xi: f64, yi: f64, sign: f64| {
            let product = depth(xi) * depth(yi);
            (-z0 * (z0 * z0 + xi * xi + yi * yi).sqrt() / product, sign * xi * yi / product)
        };
        let ((sin_g2, cos_g2), (sin_g3, cos_g3)) = (inner(x0, y1, 1.0), inner(x0, y0, -1.0));
        let cos_k = cos_g2 * cos_g3 - sin_g2 * sin_g3;
        let sin_k = -(sin_g2 * cos_g3 + cos_g2 * sin_g3);
        let (b0, b1) = (-y0 / depth(y0), y1 / depth(y1));
        (omega > 0.0).then_some(Self { x, y, z, x0, x1, y0, y1, z0, b0, b1, cos_k, sin_k, omega })
    }

    /// The solid angle Ω, sr.
    #[inline]
    pub fn solid_angle(&self) -> f32 {
        self.omega
    }

    /// The density of [`SphericalRectangle::sample`], 1/Ω; for directions that meet the rectangle.
    #[inline]
    pub fn pdf(&self) -> f32 {
        1.0 / self.omega
    }

    /// A point of the rectangle, relative to the point that it is seen from, its direction uniform in solid angle.
    #[inline]
    pub fn sample(&self, u: Vec2) -> Vec3 {
        // The cut x.
        let (s, c) = sin_cos(0.5 * self.omega * u.x);
        let (s, c) = (f64::from(s), f64::from(c));
        let (sin_a, one_minus_cos_a) = (2.0 * s * c, 2.0 * s * s);
        let sin_phi = self.sin_k + (sin_a * self.cos_k - one_minus_cos_a * self.sin_k);
        let cos_phi = self.cos_k - (one_minus_cos_a * self.cos_k + sin_a * self.sin_k);
        // x = -z₀ c/√(1 - c²) with c as above: 1 - c² = (f² + b₀² - 1)/(f² + b₀²).
        let f = (cos_phi * self.b0 - self.b1) / sin_phi;
        let rest = f * f + self.b0 * self.b0 - 1.0;
        let x = if rest > 0.0 { (-self.z0 / rest.sqrt()).copysign(f) } else { f64::INFINITY.copysign(f) };
        let x = if x.is_nan() { self.x0 } else { x.clamp(self.x0, self.x1) };

        // y on the cut.
        let d2 = x * x + self.z0 * self.z0;
        let height = |y: f64| y / (d2 + y * y).sqrt();
        let (h0, h1) = (height(self.y0), height(self.y1));
        let h = h0 + f64::from(u.y) * (h1 - h0);
        let y = (h * (d2 / (1.0 - h * h).max(1e-300)).sqrt()).clamp(self.y0, self.y1);
        (self.x * x + self.y * y + self.z * self.z0).as_vec3()
    }
}
