//! `spherical`: a point that sees all around.
//!
//! ```text
//! equalarea         w = the sphere's point of (q / (W, H)), areas kept                       Ω_px = 4π/(W H)         (see numerics::warp)
//! equirectangular   θ = π q_y/H from the pole, φ = 2π q_x/W                                  Ω_px = 2π²/(W H) sinθ
//! We(w) = 1/Ω_px,   seen from y at distance r: we = We/r², discrete
//! ```
//!
//! The pole is the camera's y; φ = 0 and the square's x are the camera's right. `to_world` as of `perspective`.

use super::{Camera, CameraRay, SensorSample};
use crate::emitter::PositionPdf;
use etendue_numerics::math::{PI, TAU, atan2, safe_acos, safe_sqrt, sin_cos};
use etendue_numerics::warp::{equal_area_sphere_to_square, square_to_equal_area_sphere};
use etendue_numerics::{Frame, Pdf, Ray, Vec2, Vec3};

/// A camera of all directions.
#[derive(Clone, Copy, Debug)]
pub struct Spherical {
    /// Where it stands, m.
    pub p: Vec3,
    /// Its x (to the left), y and z in the world, orthonormal.
    pub axes: Frame,
    /// (W, H): the full film in pixels.
    pub size: Vec2,
    /// By polar angles; else areas are kept.
    pub equirectangular: bool,
}

impl Spherical {
    /// The unit direction of a place on the film, x to the right, z up.
    fn direction(&self, pixel: Vec2) -> Vec3 {
        let s = pixel / self.size;
        if !self.equirectangular {
            return square_to_equal_area_sphere(s).normalize();
        }
        let ((sin, cos), (sin_phi, cos_phi)) = (sin_cos(PI * s.y), sin_cos(TAU * s.x));
        Vec3::new(sin * cos_phi, sin * sin_phi, cos)
    }

    fn world(&self, d: Vec3) -> Vec3 {
        self.axes.to_world(Vec3::new(-d.x, d.z, d.y))
    }

    fn picture(&self, w: Vec3) -> Vec3 {
        let local = self.axes.to_local(w);
        Vec3::new(-local.x, local.z, local.y)
    }

    fn place(&self, d: Vec3) -> Vec2 {
        let s = if self.equirectangular {
            let phi = atan2(d.y, d.x);
            Vec2::new(if phi < 0.0 { phi + TAU } else { phi } / TAU, safe_acos(d.z) / PI)
        } else {
            equal_area_sphere_to_square(d)
        };
        (s * self.size).min(Vec2::new(self.size.x.next_down(), self.size.y.next_down()))
    }

    /// Ω_px around a direction.
    fn solid_angle(&self, d: Vec3) -> f32 {
        let pixels = self.size.x * self.size.y;
        if self.equirectangular { 2.0 * PI * PI / pixels * safe_sqrt(1.0 - d.z * d.z).max(1e-6) } else { 4.0 * PI / pixels }
    }
}

impl Camera for Spherical {
    fn we(&self, _: Vec3, w: Vec3) -> f32 {
        1.0 / self.solid_angle(self.picture(w))
    }

    fn pixel(&self, _: Vec3, w: Vec3) -> Option<Vec2> {
        Some(self.place(self.picture(w)))
    }

    fn pdf(&self, p: Vec3, w: Vec3) -> (PositionPdf, Pdf) {
        (PositionPdf::Delta(1.0), Pdf::SolidAngle(self.we(p, w) / (self.size.x * self.size.y)))
    }

    fn sample_ray(&self, pixel: Vec2, _: Vec2, time: f32) -> CameraRay {
        let w = self.world(self.direction(pixel)).normalize();
        CameraRay { ray: Ray { time, ..Ray::new(self.p, w) }, weight: 1.0 }
    }

    fn sample_direction(&self, from: Vec3, _: Vec2) -> Option<SensorSample> {
        let d = from - self.p;
        let r2 = d.length_squared();
        let w = d.try_normalize()?;
        Some(SensorSample { wi: -w, p: self.p, we: self.we(self.p, w) / r2, pdf: Pdf::Delta(1.0), pixel: self.pixel(self.p, w)? })
    }
}
