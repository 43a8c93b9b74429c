//! Disks.
//!
//! ```text
//! p = c + x a + y b,  x² + y² ≤ 1,    u = √(x² + y²),  v = φ/2π;    in pbrt's coordinates  u = φ/2π,  v = 1 - √(x² + y²)
//! ```
//!
//! The axes a and b are the images of x and y; where they differ in length the disk is an ellipse.

use super::{Geometry, SurfacePoint};
use crate::interaction::Interaction;
use etendue_accel::{CustomHit, Hit};
use etendue_numerics::math::{TAU, atan2, gamma};
use etendue_numerics::warp::square_to_disk;
use etendue_numerics::{Bounds3, Ray, Transform, Vec2, Vec3};
use glam::{DAffine3, DVec2, DVec3};

/// A flat disk or ellipse.
#[derive(Clone, Debug)]
pub struct Disk {
    to_world: DAffine3,
    to_object: DAffine3,
    n: Vec3,
    area: f32,
    /// Whether u goes around and v inwards, as pbrt has it.
    pbrt_uv: bool,
}

impl Disk {
    /// The image of the unit disk in the plane z = 0, with normal +z, under `to_world`. `None` where the map is degenerate.
    pub fn new(to_world: &Transform, flip_normals: bool) -> Option<Self> {
        let to_world = DAffine3::from_mat4(to_world.matrix());
        let to_object = to_world.inverse();
        let cross = to_world.matrix3.x_axis.cross(to_world.matrix3.y_axis);
        let area = (std::f64::consts::PI * cross.length()) as f32;
        // The normal is a covector: it keeps the side that z is on, whatever the handedness.
        let n = to_object.matrix3.row(2).try_normalize()?;
        let sane = to_object.is_finite() && area.is_finite() && area > 0.0;
        sane.then(|| Self { to_world, to_object, n: if flip_normals { -n } else { n }.as_vec3(), area, pbrt_uv: false })
    }

    /// The same with pbrt's texture coordinates, if `pbrt` holds.
    #[must_use]
    pub fn with_pbrt_uv(self, pbrt: bool) -> Self {
        Self { pbrt_uv: pbrt, ..self }
    }

    /// Object coordinates to world.
    pub fn to_world(&self) -> DAffine3 {
        self.to_world
    }

    /// The unit normal: the disk's front.
    pub fn normal(&self) -> Vec3 {
        self.n
    }

    fn point(&self, local: DVec2) -> SurfacePoint {
        let p = self.to_world.transform_point3(local.extend(0.0)).as_vec3();
        let phi = atan2(local.y as f32, local.x as f32);
        let (radius, around) = (local.length() as f32, if phi < 0.0 { phi + TAU } else { phi } / TAU);
        let uv = if self.pbrt_uv { Vec2::new(around, 1.0 - radius) } else { Vec2::new(radius, around) };
        SurfacePoint {
            p,
            p_error: p.abs() * gamma(2),
            n: self.n,
            ns: self.n,
            uv,
            primitive: 0,
            bary: local.as_vec2(),
            pdf_a: 1.0 / self.area,
        }
    }
}

impl Geometry for Disk {
    fn bounds(&self) -> Bounds3 {
        // Half the extent along each axis of the ellipse c + x a + y b.
        let m = &self.to_world.matrix3;
        let half = DVec3::from_array(std::array::from_fn(|i| m.x_axis[i].hypot(m.y_axis[i])));
        let c = self.to_world.translation;
        let margin = (c.abs() + half).as_vec3() * gamma(3);
        Bounds3 { min: (c - half).as_vec3() - margin, max: (c + half).as_vec3() + margin }
    }

    fn area_of(&self, _: u32) -> f32 {
        self.area
    }

    #[inline]
    fn intersect(&self, ray: &Ray) -> Option<CustomHit> {
        let o = self.to_object.transform_point3(ray.o.as_dvec3());
        let d = self.to_object.transform_vector3(ray.d.as_dvec3());
        let t = -o.z / d.z;
        let local = (o + d * t).truncate();
        let hit = t as f32 > 0.0 && (t as f32) < ray.t_max && local.length_squared() <= 1.0;
        hit.then_some(CustomHit { t: t as f32, u: local.x as f32, v: local.y as f32, primitive: 0 })
    }

    fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
        let local = DVec2::new(hit.u.into(), hit.v.into());
        let point = self.point(local);
        // Along the radius and around the centre; at the centre itself u alone has a direction.
        let radial = local.normalize_or(DVec2::X);
        let along = self.to_world.transform_vector3(radial.extend(0.0));
        let around = self.to_world.transform_vector3(local.perp().extend(0.0)) * f64::from(TAU);
        let (dp_du, dp_dv) = if self.pbrt_uv { (around, -along) } else { (along, around) };
        Interaction::at(&point, ray, hit, dp_du.as_vec3(), dp_dv.as_vec3())
    }

    fn sample_area(&self, _: u32, u: Vec2) -> SurfacePoint {
        self.point(square_to_disk(u).as_dvec2())
    }
}
