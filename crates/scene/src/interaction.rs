//! Where a ray meets a surface, in full: made on demand from a hit's ids and barycentrics.

use crate::ids::SurfaceId;
use crate::shape::SurfacePoint;
use etendue_accel::Hit;
use etendue_numerics::{Frame, Ray, Transform, Vec2, Vec3, math::gamma, ray::offset_origin};

/// A point of a surface, seen from direction `wo`. World coordinates, metres.
#[derive(Clone, Copy, Debug)]
pub struct Interaction {
    /// The point x.
    pub p: Vec3,
    /// Bound on the rounding error of `p` in each coordinate.
    pub p_error: Vec3,
    /// Unit geometric normal: the shape's front, on the same side as the shading normal.
    pub n: Vec3,
    /// Shading frame: `shading.n` is the interpolated unit normal, `shading.s` leans towards ∂p/∂u.
    pub shading: Frame,
    /// Texture coordinates.
    pub uv: Vec2,
    /// ∂p/∂u.
    pub dp_du: Vec3,
    /// ∂p/∂v.
    pub dp_dv: Vec3,
    /// Unit direction back along the ray, leaving the surface.
    pub wo: Vec3,
    /// Distance along the ray, in units of its direction.
    pub t: f32,
    /// Time in [0, 1].
    pub time: f32,
    /// The surface.
    pub surface: SurfaceId,
    /// The triangle or face within the surface's shape.
    pub primitive: u32,
    /// Barycentrics (b1, b2) within a triangle, parameters of other shapes.
    pub bary: Vec2,
    /// The instance through which it was seen, or [`crate::NO_INSTANCE`].
    pub instance: u32,
}

impl Interaction {
    /// The surface point that `ray`, of unit direction, met at `hit`; of a ray of another length `wo` is left to the caller.
    #[inline(always)]
    pub(crate) fn at(point: &SurfacePoint, ray: &Ray, hit: &Hit, dp_du: Vec3, dp_dv: Vec3) -> Self {
        Self {
            p: point.p,
            p_error: point.p_error,
            n: point.n,
            shading: Frame::from_normal_and_tangent(point.ns, dp_du),
            uv: point.uv,
            dp_du,
            dp_dv,
            wo: -ray.d,
            t: hit.t,
            time: ray.time,
            surface: SurfaceId(hit.geometry),
            primitive: point.primitive,
            bary: point.bary,
            instance: hit.instance,
        }
    }

    /// The same point of an instance: `self` in the group's coordinates, moved to the world. `wo` is left to the caller.
    #[inline(always)]
    pub(crate) fn moved(self, to_world: &Transform) -> Self {
        let p = to_world.point_f64(self.p.as_dvec3()).as_vec3();
        let ns = to_world.normal(self.shading.n).normalize();
        let n = to_world.normal(self.n).normalize();
        let dp_du = to_world.vector(self.dp_du);
        Self {
            p,
            // Rounded here, and once more where a ray that leaves p is carried back into the group's coordinates.
            p_error: to_world.spread(self.p_error + self.p.abs() * gamma(2)) + p.abs() * gamma(2),
            n: if n.dot(ns) < 0.0 { -n } else { n },
            shading: Frame::from_normal_and_tangent(ns, dp_du),
            dp_du,
            dp_dv: to_world.vector(self.dp_dv),
            ..self
        }
    }

    /// `wo` in the shading frame.
    #[inline]
    pub fn wo_local(&self) -> Vec3 {
        self.shading.to_local(self.wo)
    }

    /// The ray that leaves towards the unit direction `w`, clear of the surface.
    #[inline]
    pub fn spawn(&self, w: Vec3) -> Ray {
        Ray { time: self.time, ..Ray::new(offset_origin(self.p, self.p_error, self.n, w), w) }
    }

    /// The ray that leaves towards the point `q` and ends shortly before it; `None` where the two points coincide. A point of a surface is to be
    /// moved off it before ([`Interaction::spawn_between`] does): rounding may have put it behind.
    #[inline]
    pub fn spawn_to(&self, q: Vec3) -> Option<Ray> {
        let o = offset_origin(self.p, self.p_error, self.n, q - self.p);
        let d = q - o;
        let distance = d.length();
        (distance > 0.0 && distance.is_finite())
            .then(|| Ray { time: self.time, ..Ray::new(o, d / distance).until(distance * (1.0 - SHADOW_EPSILON)) })
    }

    /// The ray between two surface points, clear of both surfaces; `None` where they coincide.
    #[inline]
    pub fn spawn_between(&self, y: &Self) -> Option<Ray> {
        self.spawn_to(offset_origin(y.p, y.p_error, y.n, self.p - y.p))
    }
}

/// How far before its goal a shadow ray ends, relative to its length: a few dozen roundings.
pub const SHADOW_EPSILON: f32 = 1e-5;
