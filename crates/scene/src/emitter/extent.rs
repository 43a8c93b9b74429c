//! What the light sampler knows of a light without asking it: where it is, whereto it shines, how strongly.
//!
//! ```text
//! E(x) ≈ I cosθₗ cosθₓ / d²
//! ```
//!
//! A bound is a box, a cone of normals (axis, half angle θo), the angle θe up to which light leaves about each normal, and the radiant
//! intensity I into the brightest direction [Conty Estevez, Kulla 2018, §4]; the part of I that is even does not fall with cosθₗ.

use crate::shape::{Geometry, Shape};
use etendue_numerics::math::{FRAC_PI_2, PI, TAU, safe_acos, safe_sqrt};
use etendue_numerics::{Bounds3, Vec2, Vec3};

/// A light primitive or a distant light, to the light sampler.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// Somewhere in the scene.
    Bounded(LightBounds),
    /// Infinitely far away.
    Distant {
        /// Irradiance E on a surface that faces it, W/m², unshadowed.
        irradiance: f32,
        /// The part of E that light samples look for beside a walk ([`super::LightReference::shared`]).
        excess: f32,
        /// The unit direction towards it, if it has only one.
        from: Option<Vec3>,
    },
    /// Cannot be sampled from a point.
    Unseen,
}

/// Bounds of one or several lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBounds {
    /// Where.
    pub bounds: Bounds3,
    /// About the middle; of a flat light in its plane, so that it tells exactly who is in front. Of several lights, any place among them.
    pub center: Vec3,
    /// The middle of the normals; unit length.
    pub axis: Vec3,
    /// cosθo: how far normals stray from the axis; -1 for all directions.
    pub cos_o: f32,
    /// cosθe: how far from its normal light leaves; 0 for a surface.
    pub cos_e: f32,
    /// I, W/sr.
    pub intensity: f32,
    /// The part of I that is the same in all directions where light goes at all, W/sr.
    pub even: f32,
}

impl LightBounds {
    /// Nothing: the neutral element of [`LightBounds::union`].
    pub const NONE: Self =
        Self { bounds: Bounds3::EMPTY, center: Vec3::ZERO, axis: Vec3::Z, cos_o: 1.0, cos_e: 1.0, intensity: 0.0, even: 0.0 };

    /// A point that shines equally in all directions.
    pub fn of_point(p: Vec3, intensity: f32) -> Self {
        Self { bounds: Bounds3 { min: p, max: p }, center: p, axis: Vec3::Z, cos_o: -1.0, cos_e: 0.0, intensity, even: intensity }
    }

    /// A primitive of a shape that emits `radiance`, W/(m² sr), on its front.
    pub fn of_surface(shape: &Shape, primitive: u32, radiance: f32) -> Self {
        let intensity = radiance * shape.area_of(primitive);
        let around =
            |bounds: Bounds3, intensity| Self { bounds, intensity, even: intensity, ..Self::of_point(bounds.center(), 0.0) };
        let facing = |axis: Vec3, bounds: Bounds3, on_plane: Vec3| {
            let center = bounds.center() - axis * axis.dot(bounds.center() - on_plane);
            Self { center, axis, cos_o: 1.0, even: 0.0, ..around(bounds, intensity) }
        };
        match shape {
            Shape::Mesh(mesh) => {
                let corners = mesh.indices[primitive as usize];
                let whole = mesh.indices.len() as u32 != mesh.primitive_count();
                let bounds = if whole { shape.bounds() } else { Bounds3::of(corners.map(|i| mesh.positions[i as usize])) };
                let n = shape.sample_area(primitive, Vec2::splat(0.5)).n;
                // The front is where the shading normals point; where they disagree about a triangle, either side may emit.
                let [a, b, c] = corners.map(|i| mesh.normals.get(i as usize).map_or(1.0, |ns| ns.dot(n)));
                let agreed = whole || (a > 0.0) == (b > 0.0) && (b > 0.0) == (c > 0.0);
                if agreed { facing(n, bounds, mesh.positions[corners[0] as usize]) } else { around(bounds, intensity) }
            }
            Shape::Disk(_) => {
                let at = shape.sample_area(primitive, Vec2::splat(0.5));
                facing(at.n, shape.bounds(), at.p)
            }
            // Curved shapes shine all around; a closed convex one shows a quarter of its area [Cauchy].
            _ => around(shape.bounds(), 0.25 * intensity),
        }
    }

    /// The same place, shining to all sides.
    pub fn all_around(&self) -> Self {
        Self { cos_o: -1.0, even: self.intensity, ..*self }
    }

    /// The same light, `factor` times as bright.
    pub fn scaled(&self, factor: f32) -> Self {
        Self { intensity: self.intensity * factor, even: self.even * factor, ..*self }
    }

    /// Bounds of both.
    pub fn union(&self, other: &Self) -> Self {
        if self.intensity == 0.0 || other.intensity == 0.0 {
            return if self.intensity == 0.0 { *other } else { *self };
        }
        let (axis, cos_o) = cone_union((self.axis, self.cos_o), (other.axis, other.cos_o));
        Self {
            bounds: self.bounds.union(other.bounds),
            center: self.center,
            axis,
            cos_o,
            cos_e: self.cos_e.min(other.cos_e),
            intensity: self.intensity + other.intensity,
            even: self.even + other.even,
        }
    }

    /// What a node with these bounds is held to cost when nodes are split: I · M_Ω · M_A [Conty Estevez, Kulla 2018, §4.4]. `size` is the
    /// diagonal of the node that is split: boxes without area are weighed by a sliver of it.
    pub fn cost(&self, size: f32) -> f32 {
        if self.intensity == 0.0 {
            return 0.0;
        }
        let (theta_o, theta_e) = (safe_acos(self.cos_o), safe_acos(self.cos_e));
        let theta_w = (theta_o + theta_e).min(PI);
        let sin_o = safe_sqrt(1.0 - self.cos_o * self.cos_o);
        // The solid angle of the cone, and the integral of the cosine beyond it up to θw.
        let directions = TAU * (1.0 - self.cos_o)
            + FRAC_PI_2 * (2.0 * theta_w * sin_o - (theta_o - 2.0 * theta_w).cos() - 2.0 * theta_o * sin_o + self.cos_o);
        let area = self.bounds.half_area() + 1e-3 * size * self.bounds.size().length();
        self.intensity * directions.max(1e-3) * area
    }
}

/// The smallest cone around two cones (axis, cosine of the half angle).
fn cone_union(a: (Vec3, f32), b: (Vec3, f32)) -> (Vec3, f32) {
    let (theta_a, theta_b) = (safe_acos(a.1), safe_acos(b.1));
    let between = a.0.angle_between(b.0);
    if (between + theta_b).min(PI) <= theta_a {
        return a;
    }
    if (between + theta_a).min(PI) <= theta_b {
        return b;
    }
    let theta = 0.5 * (theta_a + between + theta_b);
    let turn = a.0.cross(b.0);
    let Some(turn) = turn.try_normalize() else { return (a.0, -1.0) };
    if theta >= PI {
        return (a.0, -1.0);
    }
    // Turn a towards b; a little wider, lest rounding leaves anything out.
    let (sin, cos) = (theta - theta_a).sin_cos();
    let axis = a.0 * cos + turn.cross(a.0) * sin;
    (axis.normalize(), (theta + 1e-5).min(PI).cos())
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_check::rng;

    fn direction(u: Vec2) -> Vec3 {
        etendue_numerics::warp::square_to_sphere(u)
    }

    #[test]
    fn the_union_of_cones_holds_both() {
        let mut r = rng(5);
        for _ in 0..20_000 {
            let mut cone = || (direction(r.u2()), (PI * r.u1() * r.u1()).cos());
            let (a, b) = (cone(), cone());
            let (axis, cos) = cone_union(a, b);
            assert!((axis.length() - 1.0).abs() < 1e-5);
            for (x, cos_x) in [a, b] {
                // The far edge of x as seen from the new axis.
                let reach = axis.angle_between(x) + safe_acos(cos_x);
                assert!(cos <= -0.9999 || reach.min(PI) <= safe_acos(cos) + 1e-3, "{a:?} {b:?} → {axis} {cos}");
            }
        }
    }

    #[test]
    fn nothing_is_neutral_and_power_adds_up() {
        let a = LightBounds::of_point(Vec3::X, 2.0);
        let b = LightBounds { axis: Vec3::X, cos_o: 1.0, ..LightBounds::of_point(Vec3::Y, 3.0) };
        assert_eq!(a.union(&LightBounds::NONE), a);
        assert_eq!(LightBounds::NONE.union(&b), b);
        let both = a.union(&b);
        assert_eq!(both.intensity, 5.0);
        assert_eq!(both.bounds, Bounds3::new(Vec3::X, Vec3::Y));
        assert_eq!(both.cos_o, -1.0);
    }

    #[test]
    fn flat_clusters_are_cheaper_than_scattered_ones() {
        let lamp = |p: Vec3, axis: Vec3| LightBounds { axis, cos_o: 1.0, ..LightBounds::of_point(p, 1.0) };
        let size = 2.0;
        let same = lamp(Vec3::ZERO, Vec3::Z).union(&lamp(Vec3::X, Vec3::Z));
        let opposite = lamp(Vec3::ZERO, Vec3::Z).union(&lamp(Vec3::X, Vec3::NEG_Z));
        assert!(same.cost(size) < opposite.cost(size));
        let far = lamp(Vec3::ZERO, Vec3::Z).union(&lamp(2.0 * Vec3::X, Vec3::Z));
        assert!(same.cost(size) < far.cost(size));
    }
}
