//! `orthographic`: parallel rays.
//!
//! ```text
//! q = (1 - (x, y W/H))/2 · (W, H)       x in [-1, 1] and y in [-H/W, H/W] of the camera's coordinates fill the film
//! We = δ(w - d) / A_px,    A_px = a pixel's area across the rays, m²
//! ```
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `to_world` | from the camera's coordinates; its scale sets how much is seen | identity |
//! | `near_clip`, `far_clip` | where rays begin, along +z in the camera's coordinates, and where they end, m | 0.01, 10000 |
//! | `shutter_open`, `shutter_close` | accepted; nothing moves yet | 0 |

use super::{Camera, CameraRay, SensorSample};
use crate::emitter::PositionPdf;
use etendue_numerics::{Pdf, Ray, Transform, Vec2, Vec3};
use glam::Affine3A;

/// A camera of parallel rays.
#[derive(Clone, Debug)]
pub struct Orthographic {
    to_world: Affine3A,
    to_camera: Affine3A,
    /// Unit direction of all rays.
    d: Vec3,
    /// (W, H) in pixels.
    size: Vec2,
    /// Half the film's extent in the camera's coordinates: (1, H/W).
    half: Vec2,
    near: f32,
    /// How long rays are, m.
    length: f32,
    /// A_px, m².
    pixel_area: f32,
}

impl Orthographic {
    /// A camera under the affine map `to_world` with a film of `size` pixels; `clip` holds near and far. `None` where the map is degenerate.
    pub fn new(to_world: Transform, size: Vec2, clip: [f32; 2]) -> Option<Self> {
        let d = to_world.vector(Vec3::Z).try_normalize()?;
        let half = Vec2::new(1.0, size.y / size.x);
        let across = to_world.vector(Vec3::X).cross(to_world.vector(Vec3::Y)).dot(d).abs();
        let pixel_area = across * 4.0 * half.x * half.y / (size.x * size.y);
        let sane = pixel_area > 0.0 && pixel_area.is_finite();
        let (to_world, to_camera) = (affine(&to_world), affine(&to_world.inverse()));
        sane.then(|| Self { to_world, to_camera, d, size, half, near: clip[0], length: clip[1] - clip[0], pixel_area })
    }

    /// The place on the film of a point in the camera's coordinates.
    fn pixel_of(&self, local: Vec3) -> Option<Vec2> {
        let s = 0.5 * (Vec2::ONE - local.truncate() / self.half);
        let on_film = s.cmpge(Vec2::ZERO).all() && s.cmplt(Vec2::ONE).all();
        on_film.then(|| (s * self.size).min(Vec2::new(self.size.x.next_down(), self.size.y.next_down())))
    }
}

fn affine(t: &Transform) -> Affine3A {
    Affine3A::from_mat4(t.matrix().as_mat4())
}

impl Camera for Orthographic {
    fn we(&self, _: Vec3, _: Vec3) -> f32 {
        0.0
    }

    fn pixel(&self, p: Vec3, _: Vec3) -> Option<Vec2> {
        self.pixel_of(self.to_camera.transform_point3(p))
    }

    fn pdf(&self, p: Vec3, w: Vec3) -> (PositionPdf, Pdf) {
        let area = 1.0 / (self.pixel_area * self.size.x * self.size.y);
        (PositionPdf::Area(self.pixel(p, w).map_or(0.0, |_| area)), Pdf::Delta(1.0))
    }

    fn sample_ray(&self, pixel: Vec2, _: Vec2, time: f32) -> CameraRay {
        let xy = (Vec2::ONE - 2.0 * pixel / self.size) * self.half;
        let ray = Ray::new(self.to_world.transform_point3(xy.extend(self.near)), self.d).until(self.length);
        CameraRay { ray: Ray { time, ..ray }, weight: 1.0 }
    }

    fn sample_direction(&self, from: Vec3, _: Vec2) -> Option<SensorSample> {
        let local = self.to_camera.transform_point3(from);
        let pixel = self.pixel_of(local)?;
        let p = self.to_world.transform_point3(local.with_z(self.near));
        let distance = (from - p).dot(self.d);
        let seen = distance >= 0.0 && distance <= self.length;
        seen.then(|| SensorSample { wi: -self.d, p, we: 1.0 / self.pixel_area, pdf: Pdf::Delta(1.0), pixel })
    }
}
