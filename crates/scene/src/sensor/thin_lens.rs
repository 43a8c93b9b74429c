//! `thinlens`: a lens with depth of field.
//!
//! ```text
//! Every ray of a place q on the film passes the point z_f (X, Y, 1) of the focal plane; the lens is a disk of radius r_l in z = 0.
//! We(x, w) = 1 / (A_px A_lens cos⁴θ),    A_lens = π r_l²       (see projection: from any point of the lens the focal plane is a film)
//! ```
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `aperture_radius` | r_l, m | needed |
//! | `focus_distance` | z_f along the axis, m | the far plane |
//! | all others | as of `perspective` | |

use super::{Camera, CameraRay, Passage, Projection, SensorSample};
use crate::emitter::PositionPdf;
use etendue_numerics::math::PI;
use etendue_numerics::warp::square_to_disk;
use etendue_numerics::{Pdf, Ray, Vec2, Vec3};

/// A camera with a lens.
#[derive(Clone, Debug)]
pub struct ThinLens {
    /// Place and field of view.
    pub projection: Projection,
    /// r_l > 0, m.
    pub aperture_radius: f32,
    /// z_f > 0, m.
    pub focus_distance: f32,
}

impl ThinLens {
    fn lens_area(&self) -> f32 {
        PI * self.aperture_radius * self.aperture_radius
    }

    /// A point of the lens in the camera's coordinates.
    fn lens_point(&self, lens: Vec2) -> Vec3 {
        (square_to_disk(lens) * self.aperture_radius).extend(0.0)
    }

    /// The place on the film of the ray from a lens point, both in the camera's coordinates.
    fn pixel_of(&self, lens: Vec3, w: Vec3) -> Option<Vec2> {
        let focus = lens + w * (self.focus_distance / w.z);
        if w.z > 0.0 { self.projection.pixel(focus.truncate() / self.focus_distance) } else { None }
    }
}

impl Camera for ThinLens {
    fn we(&self, p: Vec3, w: Vec3) -> f32 {
        let cos = self.projection.axes.n.dot(w);
        self.pixel(p, w).map_or(0.0, |_| self.projection.we(cos) / self.lens_area())
    }

    fn pixel(&self, p: Vec3, w: Vec3) -> Option<Vec2> {
        let axes = &self.projection.axes;
        self.pixel_of(axes.to_local(p - self.projection.p), axes.to_local(w))
    }

    fn pdf(&self, p: Vec3, w: Vec3) -> (PositionPdf, Pdf) {
        let cos = self.projection.axes.n.dot(w);
        let direction = self.pixel(p, w).map_or(0.0, |_| self.projection.pdf_w(cos));
        (PositionPdf::Area(1.0 / self.lens_area()), Pdf::SolidAngle(direction))
    }

    fn sample_ray(&self, pixel: Vec2, lens: Vec2, time: f32) -> CameraRay {
        let lens = self.lens_point(lens);
        let w = (self.projection.direction(pixel) * self.focus_distance - lens).normalize();
        CameraRay { ray: self.projection.ray(lens, w, time), weight: 1.0 }
    }

    fn sample_direction(&self, from: Vec3, lens: Vec2) -> Option<SensorSample> {
        let local = self.projection.place(from)?;
        let lens = self.lens_point(lens);
        let d = local - lens;
        let r2 = d.length_squared();
        let w = d / r2.sqrt();
        let pixel = self.pixel_of(lens, w)?;
        let ray = self.projection.ray(lens, w, 0.0);
        Some(SensorSample {
            wi: -ray.d,
            p: ray.o,
            we: self.projection.we(w.z) / self.lens_area(),
            pdf: Pdf::SolidAngle(r2 / (w.z * self.lens_area())),
            pixel,
        })
    }

    fn has_lens(&self) -> bool {
        true
    }

    fn passage(&self, ray: &Ray) -> Option<Passage> {
        let axes = &self.projection.axes;
        let (o, d) = (self.projection.place(ray.o)?, axes.to_local(ray.d));
        let lens = o - d * (o.z / d.z);
        if d.z >= 0.0 || lens.truncate().length_squared() > self.aperture_radius * self.aperture_radius {
            return None;
        }
        let pixel = self.pixel_of(lens.with_z(0.0), -d)?;
        let t = (self.projection.clip[0] - o.z) / d.z;
        Some(Passage { t, we: self.projection.we(-d.z) / self.lens_area(), pixel })
    }
}
