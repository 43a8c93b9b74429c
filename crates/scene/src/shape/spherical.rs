//! Triangles on the sphere of directions around a point: their solid angle, and directions uniform in it.
//!
//! ```text
//! tan(ω/2) = |det(v0, v1, v2)| / (1 + v0·v1 + v1·v2 + v2·v0)                        [Van Oosterom, Strackee 1983, eq. 8]
//! ```
//!
//! A direction is drawn in two steps [Arvo 1995]. First a vertex v2' on the arc v0 v2 such that (v0, v1, v2') has solid angle u₀ω: with
//! v2' the mirror image of v0 in h = α v0 + β v2, the equation above becomes linear in (α, β),
//!
//! ```text
//! α = cos(u₀ω/2) G0 - sin(u₀ω/2) G1,    β = sin(u₀ω/2) G2,
//! G0 = |det(v0, v1, v2)|,    G1 = v0·v2 + v1·v2,    G2 = 1 + v0·v1.
//! ```
//!
//! Then a point on the arc v1 v2' whose cosine with v1 is 1 - u₁(1 - v1·v2').

use etendue_numerics::math::{atan2, sin_cos};
use etendue_numerics::{Vec2, Vec3};
use glam::DVec3;

/// A triangle as seen from a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SphericalTriangle {
    /// The corners relative to the point.
    corners: [DVec3; 3],
    /// Their directions.
    v: [DVec3; 3],
    g: [f64; 3],
    /// ω in sr; zero where the point lies in the triangle's plane or on a corner.
    pub solid_angle: f32,
}

impl SphericalTriangle {
    /// The triangle `p` as seen from `from`.
    pub fn new(from: Vec3, p: [Vec3; 3]) -> Self {
        let corners = p.map(|p| p.as_dvec3() - from.as_dvec3());
        let v = corners.map(|c| c.normalize_or_zero());
        let det = v[0].dot(v[1].cross(v[2])).abs();
        let g = [det, v[0].dot(v[2]) + v[1].dot(v[2]), 1.0 + v[0].dot(v[1])];
        let seen = v.iter().all(|v| *v != DVec3::ZERO);
        let solid_angle = if seen { 2.0 * atan2(g[0] as f32, (g[1] + g[2]) as f32) } else { 0.0 };
        Self { corners, v, g, solid_angle }
    }

    /// Barycentrics (b1, b2) of the point of the triangle in a direction that is uniform in its solid angle.
    pub fn sample(&self, u: Vec2) -> Vec2 {
        let [v0, v1, v2] = self.v;

        // The vertex that cuts off the fraction u.x of the solid angle.
        let (sin, cos) = sin_cos(0.5 * u.x * self.solid_angle);
        let (sin, cos) = (f64::from(sin), f64::from(cos));
        let h = (cos * self.g[0] - sin * self.g[1]) * v0 + sin * self.g[2] * v2;
        let v2 = if h == DVec3::ZERO { v0 } else { h * (2.0 * v0.dot(h) / h.length_squared()) - v0 };

        // A point on the arc from v1 to it.
        let versine = f64::from(u.y) * (1.0 - v1.dot(v2)).max(0.0);
        let side = (v2 - v1 * v1.dot(v2)).normalize_or_zero();
        self.barycentrics(v1 * (1.0 - versine) + side * (versine * (2.0 - versine)).max(0.0).sqrt())
    }

    /// Barycentrics (b1, b2) of the point in direction `w`, moved into the triangle where rounding left it.
    fn barycentrics(&self, w: DVec3) -> Vec2 {
        let [a, b, c] = self.corners;
        let weights = [w.dot(b.cross(c)), w.dot(c.cross(a)), w.dot(a.cross(b))];
        let orientation = a.dot(b.cross(c)).signum();
        let [b0, b1, b2] = weights.map(|x| (x * orientation).max(0.0));
        let sum = b0 + b1 + b2;
        if sum > 0.0 { Vec2::new((b1 / sum) as f32, (b2 / sum) as f32) } else { Vec2::splat(1.0 / 3.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    #[test]
    fn octants_and_small_triangles_have_their_solid_angle() {
        let octant = SphericalTriangle::new(Vec3::ZERO, [Vec3::X, Vec3::Y, Vec3::Z]);
        assert!((octant.solid_angle - PI / 2.0).abs() < 1e-6);
        let from = Vec3::new(100.0, -30.0, 7.0);
        let h = 1e-3;
        let small = SphericalTriangle::new(from, [from + Vec3::Z, from + Vec3::new(h, 0.0, 1.0), from + Vec3::new(0.0, h, 1.0)]);
        // Coordinates near 100 are known to 4e-6 only: a few parts in a hundred of h.
        assert!((small.solid_angle - 0.5 * h * h).abs() < 0.02 * h * h, "{}", small.solid_angle);
        assert_eq!(SphericalTriangle::new(Vec3::X, [Vec3::X, Vec3::Y, Vec3::Z]).solid_angle, 0.0);
    }

    #[test]
    fn the_cut_vertex_cuts_the_stated_fraction() {
        let t =
            SphericalTriangle::new(Vec3::ZERO, [Vec3::new(1.0, 0.2, 0.1), Vec3::new(-0.1, 2.0, 0.3), Vec3::new(0.3, -0.2, 0.9)]);
        for fraction in [0.1f32, 0.5, 0.9] {
            // u.y = 1 gives the cut vertex itself: a point of edge p0 p2, that is b1 = 0.
            let b = t.sample(Vec2::new(fraction, 1.0));
            assert!(b.x.abs() < 1e-6, "{b}");
            let at = t.corners[0] * f64::from(1.0 - b.y) + t.corners[2] * f64::from(b.y);
            let cut = SphericalTriangle::new(Vec3::ZERO, [t.corners[0].as_vec3(), t.corners[1].as_vec3(), at.as_vec3()]);
            assert!((cut.solid_angle - fraction * t.solid_angle).abs() < 1e-5);
        }
    }
}
