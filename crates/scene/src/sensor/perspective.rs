//! `perspective`: a pinhole.
//!
//! ```text
//! We(w) = 1 / (A_px cos⁴θ),    We cosθ dw = d²q       (see projection)
//! seen from y at distance r:   we = We cosθ / r²,  discrete
//! ```
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `fov`, `fov_axis` | field of view in degrees along `x`, `y`, `diagonal`, the `smaller` or `larger` side | see `focal_length`; `x` |
//! | `focal_length` | of a camera with 36 × 24 mm film, across the diagonal | `50mm` |
//! | `near_clip`, `far_clip` | planes across the axis between which things are seen, m | 0.01, 10000 |
//! | `principal_point_offset_x`, `_y` | shift of the picture's middle, in film sizes | 0 |
//! | `to_world` | from the camera's coordinates, without scales | identity |
//! | `shutter_open`, `shutter_close` | accepted; nothing moves yet | 0 |

use super::{Camera, CameraRay, Projection, SensorSample};
use crate::emitter::PositionPdf;
use etendue_numerics::{Pdf, Vec2, Vec3};

/// A pinhole camera.
#[derive(Clone, Debug)]
pub struct Perspective {
    /// Place and field of view.
    pub projection: Projection,
}

impl Camera for Perspective {
    fn we(&self, p: Vec3, w: Vec3) -> f32 {
        let cos = self.projection.axes.n.dot(w);
        self.pixel(p, w).map_or(0.0, |_| self.projection.we(cos))
    }

    fn pixel(&self, _: Vec3, w: Vec3) -> Option<Vec2> {
        let local = self.projection.axes.to_local(w);
        if local.z > 0.0 { self.projection.pixel(local.truncate() / local.z) } else { None }
    }

    fn pdf(&self, p: Vec3, w: Vec3) -> (PositionPdf, Pdf) {
        let cos = self.projection.axes.n.dot(w);
        (PositionPdf::Delta(1.0), Pdf::SolidAngle(self.pixel(p, w).map_or(0.0, |_| self.projection.pdf_w(cos))))
    }

    #[inline(always)]
    fn sample_ray(&self, pixel: Vec2, _: Vec2, time: f32) -> CameraRay {
        let w = self.projection.direction(pixel).normalize();
        CameraRay { ray: self.projection.ray(Vec3::ZERO, w, time), weight: 1.0 }
    }

    fn sample_direction(&self, from: Vec3, _: Vec2) -> Option<SensorSample> {
        let (sample, is_seen) = self.seen_from(from);
        is_seen.then_some(sample)
    }
}

impl Perspective {
    /// The pinhole as `from` sees it, and whether it sees it, without branches: for loops over lanes.
    #[inline(always)]
    pub fn seen_from(&self, from: Vec3) -> (SensorSample, bool) {
        let local = self.projection.local(from);
        let (pixel, on_film) = self.projection.locate(local.truncate() / local.z);
        let r2 = local.length_squared();
        let w = local / r2.sqrt();
        let ray = self.projection.ray(Vec3::ZERO, w, 0.0);
        let we = self.projection.we(w.z) * w.z / r2;
        (SensorSample { wi: -ray.d, p: ray.o, we, pdf: Pdf::Delta(1.0), pixel }, on_film & self.projection.is_between(local))
    }
}
