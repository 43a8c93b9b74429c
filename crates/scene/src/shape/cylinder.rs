//! Cylinders without caps.
//!
//! ```text
//! x² + y² = 1,  0 ≤ z ≤ 1  in object coordinates,    u = φ/2π,  v = z
//! ```
//!
//! The normal points away from the axis. Points are drawn uniformly in (φ, z): by area where the cross section is a circle, with the density
//! 1/(2π |∂p/∂φ × ∂p/∂z|) per m² where the map to the world makes it an ellipse or shears it.

use super::sample::pdf_direction_by_area;
use super::{Geometry, SurfacePoint, quadratic::nearest_root};
use crate::interaction::Interaction;
use etendue_accel::{CustomHit, Hit};
use etendue_numerics::math::{TAU, atan2, gamma, sin_cos};
use etendue_numerics::{Bounds3, Ray, Vec2, Vec3};
use glam::{DAffine3, DVec2, DVec3};

/// An open cylinder; elliptic where the map says so.
#[derive(Clone, Debug)]
pub struct Cylinder {
    to_world: DAffine3,
    to_object: DAffine3,
    outward: f64,
    area: f32,
}

impl Cylinder {
    /// The image under `to_world` of the unit cylinder about z from z = 0 to 1. `None` where the map is degenerate.
    pub fn new(to_world: DAffine3, flip_normals: bool) -> Option<Self> {
        let to_object = to_world.inverse();
        if !to_world.is_finite() || !to_object.is_finite() {
            return None;
        }
        let mut cylinder = Self { to_world, to_object, outward: if flip_normals { -1.0 } else { 1.0 }, area: 0.0 };
        // The trapezoidal rule around a period converges faster than any power of the step.
        const STEPS: u32 = 256;
        let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(STEPS);
        let sum: f64 = (0..STEPS).map(|i| cylinder.stretch(DVec2::from_angle(angle(i)))).sum();
        cylinder.area = (sum * std::f64::consts::TAU / f64::from(STEPS)) as f32;
        (cylinder.area.is_finite() && cylinder.area > 0.0).then_some(cylinder)
    }

    /// Object coordinates to world.
    pub fn to_world(&self) -> DAffine3 {
        self.to_world
    }

    /// +1 where normals point away from the axis, -1 where towards it.
    pub fn outward(&self) -> f64 {
        self.outward
    }

    /// |∂p/∂φ × ∂p/∂z| at the direction `c` of the cross section, m² per radian.
    fn stretch(&self, c: DVec2) -> f64 {
        let around = self.to_world.transform_vector3(c.perp().extend(0.0));
        around.cross(self.to_world.matrix3.z_axis).length()
    }

    /// The point over the unit direction `c` at height `z`.
    fn point(&self, c: DVec2, z: f64) -> SurfacePoint {
        let p = self.to_world.transform_point3(c.extend(z)).as_vec3();
        // A covector: the transposed inverse carries it.
        let n = (self.to_object.matrix3.transpose() * (c * self.outward).extend(0.0)).normalize().as_vec3();
        let phi = atan2(c.y as f32, c.x as f32);
        let uv = Vec2::new(if phi < 0.0 { phi + TAU } else { phi } / TAU, z as f32);
        let pdf_a = (1.0 / (f64::from(TAU) * self.stretch(c))) as f32;
        SurfacePoint { p, p_error: p.abs() * gamma(2), n, ns: n, uv, primitive: 0, bary: Vec2::ZERO, pdf_a }
    }
}

impl Geometry for Cylinder {
    fn bounds(&self) -> Bounds3 {
        let m = &self.to_world.matrix3;
        let half = DVec3::from_array(std::array::from_fn(|i| m.x_axis[i].hypot(m.y_axis[i])));
        let (foot, head) = (self.to_world.translation, self.to_world.translation + m.z_axis);
        let margin = (foot.abs().max(head.abs()) + half).as_vec3() * gamma(3);
        Bounds3 { min: (foot.min(head) - half).as_vec3() - margin, max: (foot.max(head) + half).as_vec3() + margin }
    }

    fn area_of(&self, _: u32) -> f32 {
        self.area
    }

    #[inline]
    fn intersect(&self, ray: &Ray) -> Option<CustomHit> {
        let o = self.to_object.transform_point3(ray.o.as_dvec3());
        let d = self.to_object.transform_vector3(ray.d.as_dvec3());
        // In the plane of the cross section: where the line comes nearest to the axis, and how far within the circle.
        let (o2, d2) = (o.truncate(), d.truncate());
        let a = d2.length_squared();
        let b = -o2.dot(d2);
        let discriminant = 1.0 - (o2 + d2 * (b / a)).length_squared();
        let within = |t: f64| (0.0..=1.0).contains(&(o.z + t * d.z));
        let t = nearest_root(a, b, o2.length_squared() - 1.0, a * discriminant, ray.t_max, within)?;
        Some(CustomHit { t, u: 0.0, v: 0.0, primitive: 0 })
    }

    fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
        let p = ray.o.as_dvec3() + ray.d.as_dvec3() * f64::from(hit.t);
        let local = self.to_object.transform_point3(p);
        let c = local.truncate().normalize_or(DVec2::X);
        let point = self.point(c, local.z.clamp(0.0, 1.0));
        let dp_du = self.to_world.transform_vector3(c.perp().extend(0.0)) * f64::from(TAU);
        Interaction::at(&point, ray, hit, dp_du.as_vec3(), self.to_world.matrix3.z_axis.as_vec3())
    }

    fn sample_area(&self, _: u32, u: Vec2) -> SurfacePoint {
        let (sin, cos) = sin_cos(TAU * u.x);
        self.point(Vec2::new(cos, sin).as_dvec2().normalize(), u.y.into())
    }

    fn pdf_direction(&self, _: u32, from: Vec3, at: &Interaction) -> f32 {
        let c = self.to_object.transform_point3(at.p.as_dvec3()).truncate().normalize_or(DVec2::X);
        pdf_direction_by_area((f64::from(TAU) * self.stretch(c)) as f32, from, at)
    }
}
