//! Spheres.
//!
//! ```text
//! |p - c| = r,    u = φ/2π,  v = θ/π, in pbrt's coordinates 1 - θ/π      (φ, θ) of the point in object coordinates, z up
//! ```
//!
//! Seen from outside, points are drawn uniformly in the cone of directions that the sphere fills; the density is 1/(2π(1 - cosθmax)),
//! sinθmax = r/d [Shirley, Wang, Zimmerman 1996]. Seen from within, uniformly by area.

use super::sample::{pdf_direction_by_area, sample_direction_by_area};
use super::{Geometry, SurfacePoint, quadratic::nearest_root};
use crate::interaction::Interaction;
use etendue_accel::{CustomHit, Hit};
use etendue_numerics::math::{PI, TAU, atan2, gamma, sin_cos};
use etendue_numerics::warp::square_to_sphere;
use etendue_numerics::{Bounds3, Frame, Ray, Vec2, Vec3};
use glam::{DAffine3, DMat3, DVec3};

/// A full sphere.
#[derive(Clone, Debug)]
pub struct Sphere {
    center: DVec3,
    radius: f64,
    /// Object coordinates to world: turns and scales; its inverse gives the texture coordinates.
    to_world: DMat3,
    to_object: DMat3,
    /// +1 where normals point outwards, -1 where inwards.
    outward: f32,
    /// Whether v counts from the pole at -z, as pbrt has it.
    pbrt_uv: bool,
}

impl Sphere {
    /// The image of the unit sphere under `to_world` about `center`: its radius is the length of the first column. Normals point
    /// outwards, inwards where exactly one of `flip_normals` and a change of handedness holds. `None` where the map is degenerate.
    pub fn new(center: DVec3, to_world: DMat3, flip_normals: bool) -> Option<Self> {
        let radius = to_world.x_axis.length();
        let inverse = to_world.inverse();
        if !center.is_finite() || radius == 0.0 || !(radius as f32).is_finite() || !inverse.is_finite() {
            return None;
        }
        let outward = if flip_normals == (to_world.determinant() < 0.0) { 1.0 } else { -1.0 };
        Some(Self { center, radius, to_world, to_object: inverse, outward, pbrt_uv: false })
    }

    /// The same with pbrt's texture coordinates, if `pbrt` holds.
    #[must_use]
    pub fn with_pbrt_uv(self, pbrt: bool) -> Self {
        Self { pbrt_uv: pbrt, ..self }
    }

    /// Turns and scales the unit sphere about the origin, and moves it into its place.
    pub fn to_world(&self) -> DAffine3 {
        DAffine3 { matrix3: self.to_world, translation: self.center }
    }

    /// +1 where normals point outwards, -1 where inwards.
    pub fn outward(&self) -> f64 {
        self.outward.into()
    }

    /// Radius in m.
    pub fn radius(&self) -> f32 {
        self.radius as f32
    }

    /// The centre.
    pub fn center(&self) -> Vec3 {
        self.center.as_vec3()
    }

    /// The point in the unit direction `d` from the centre.
    fn point(&self, d: DVec3) -> SurfacePoint {
        let p = (self.center + d * self.radius).as_vec3();
        let n = d.as_vec3().normalize() * self.outward;
        let (phi, theta) = self.angles((self.to_object * d).as_vec3());
        let uv = Vec2::new(phi / TAU, if self.pbrt_uv { 1.0 - theta / PI } else { theta / PI });
        SurfacePoint { p, p_error: p.abs() * gamma(2), n, ns: n, uv, primitive: 0, bary: Vec2::ZERO, pdf_a: 1.0 / self.area_of(0) }
    }

    /// φ in [0, 2π] and θ in [0, π] of a direction in object coordinates.
    fn angles(&self, v: Vec3) -> (f32, f32) {
        let phi = atan2(v.y, v.x);
        (if phi < 0.0 { phi + TAU } else { phi }, atan2(v.truncate().length(), v.z))
    }

    /// 1 - cosθmax of the cone that the sphere fills, and sinθmax; `None` from within. With normals that point inwards only those within see
    /// the front, whichever side of the surface rounding puts them on.
    fn cone(&self, from: Vec3) -> Option<(f64, f64)> {
        let distance_squared = (self.center - from.as_dvec3()).length_squared();
        let sin2 = self.radius * self.radius / distance_squared;
        // A point on the sphere itself may lie a rounding error outside: there the cone is the whole hemisphere.
        (sin2 < 1.0 && self.outward > 0.0).then(|| (sin2 / (1.0 + (1.0 - sin2).sqrt()), sin2.sqrt()))
    }
}

impl Geometry for Sphere {
    fn bounds(&self) -> Bounds3 {
        let (low, high) = ((self.center - self.radius).as_vec3(), (self.center + self.radius).as_vec3());
        let margin = (self.center().abs() + self.radius()) * gamma(3);
        Bounds3 { min: low - margin, max: high + margin }
    }

    fn area_of(&self, _: u32) -> f32 {
        (4.0 * std::f64::consts::PI * self.radius * self.radius) as f32
    }

    #[inline]
    fn intersect(&self, ray: &Ray) -> Option<CustomHit> {
        // Relative to the centre: |o + t d|² = r², with the discriminant from the distance between line and centre, which does not
        // cancel from afar.
        let (o, d) = (ray.o.as_dvec3() - self.center, ray.d.as_dvec3());
        let a = d.length_squared();
        let b = -o.dot(d);
        let miss = o + d * (b / a);
        let c = o.length_squared() - self.radius * self.radius;
        let discriminant = self.radius * self.radius - miss.length_squared();
        let t = nearest_root(a, b, c, a * discriminant, ray.t_max, |_| true)?;
        Some(CustomHit { t, u: 0.0, v: 0.0, primitive: 0 })
    }

    fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
        let p = ray.o.as_dvec3() + ray.d.as_dvec3() * f64::from(hit.t);
        let d = (p - self.center).normalize_or(DVec3::Z);
        let point = self.point(d);

        // ∂p/∂u = 2π (-y, x, 0), ∂p/∂v = π (z cosφ, z sinφ, -sinθ) in object coordinates.
        let local = self.to_object * (d * self.radius);
        let r = local.truncate().length();
        let (cos_phi, sin_phi) = if r > 0.0 { (local.x / r, local.y / r) } else { (1.0, 0.0) };
        let dp_du = self.to_world * DVec3::new(-local.y, local.x, 0.0) * f64::from(TAU);
        let dv = if self.pbrt_uv { -PI } else { PI };
        let dp_dv = self.to_world * DVec3::new(local.z * cos_phi, local.z * sin_phi, -r) * f64::from(dv);
        Interaction::at(&point, ray, hit, dp_du.as_vec3(), dp_dv.as_vec3())
    }

    fn sample_area(&self, _: u32, u: Vec2) -> SurfacePoint {
        self.point(square_to_sphere(u).as_dvec3().normalize())
    }

    fn pdf_direction(&self, primitive: u32, from: Vec3, at: &Interaction) -> f32 {
        let Some((versine, _)) = self.cone(from) else { return pdf_direction_by_area(self.area_of(primitive), from, at) };
        // The far side is hidden by the near one and never drawn.
        let seen = (at.p - self.center()).dot(from - at.p) > 0.0;
        if seen { (1.0 / (f64::from(TAU) * versine)) as f32 } else { 0.0 }
    }

    fn sample_direction(&self, primitive: u32, from: Vec3, u: Vec2) -> Option<(SurfacePoint, f32)> {
        let Some((max_versine, sin_max)) = self.cone(from) else {
            return sample_direction_by_area(self.sample_area(primitive, u), from);
        };

        // A direction in the cone: 1 - cosθ uniform up to its maximum.
        let versine = f64::from(u.x) * max_versine;
        let (sin2, cos) = (versine * (2.0 - versine), 1.0 - versine);

        // The angle α at the centre between the axis and the point where that direction meets the sphere.
        let cos_alpha = sin2 / sin_max + cos * (1.0 - sin2 / (sin_max * sin_max)).max(0.0).sqrt();
        let sin_alpha = (1.0 - cos_alpha * cos_alpha).max(0.0).sqrt();
        let (sin_phi, cos_phi) = sin_cos(TAU * u.y);
        let axis = (from.as_dvec3() - self.center).normalize();
        let frame = Frame::from_normal(axis.as_vec3());
        let side = frame.s * cos_phi + frame.t * sin_phi;
        let d = (axis * cos_alpha + side.as_dvec3() * sin_alpha).normalize();
        Some((self.point(d), (1.0 / (f64::from(TAU) * max_versine)) as f32))
    }
}
