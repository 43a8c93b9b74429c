//! What lights infinitely far away share: they shine through the scene's sphere.
//!
//! ```text
//! center, R   of a sphere that holds the scene
//! p_A = 1/(πR²)           where a ray of direction d crosses the disk before the sphere
//! Φ = π R² ∫ Le dw
//! ```

use super::{EmissionPdf, EmissionSample, LightId, LightReference, LightSample, PositionPdf};
use crate::scene::Scene;
use etendue_numerics::math::PI;
use etendue_numerics::warp::square_to_disk;
use etendue_numerics::{Frame, Pdf, Ray, Spectrum, Vec2, Vec3};

/// Centre and radius R of a sphere around the scene, a little larger than its box needs, so that rays set out from outside.
pub(super) fn scene_sphere(scene: &Scene) -> (Vec3, f32) {
    let (center, radius) = scene.bounds.bounding_sphere();
    (center, radius * (1.0 + 1e-4))
}

/// 1/(πR²), 1/m²; zero for a scene without extent.
fn disk_density(scene: &Scene) -> f32 {
    let (_, radius) = scene_sphere(scene);
    let density = 1.0 / (PI * radius * radius);
    if density.is_finite() { density } else { 0.0 }
}

/// A point safely outside the scene's sphere, seen from `p` in the unit direction `wi`.
#[inline(always)]
pub(super) fn outside((center, radius): (Vec3, f32), p: Vec3, wi: Vec3) -> Vec3 {
    p + wi * (2.0 * radius + (p - center).length())
}

/// Light of radiance `le` (of irradiance, if its direction is discrete) that arrives from the unit direction `wi`, which was drawn with `pdf`.
pub(super) fn light_sample(scene: &Scene, from: &LightReference, id: LightId, wi: Vec3, pdf: Pdf, le: Spectrum) -> LightSample {
    let p = outside(scene_sphere(scene), from.p, wi);
    LightSample { wi, p, distance: f32::INFINITY, le, pdf, emitter: id.emitter, primitive: 0, n: Vec3::ZERO }
}

/// A ray that brings the same light, `u` telling where it crosses the disk; `None` for a scene without extent.
pub(super) fn emission_sample(scene: &Scene, id: LightId, wi: Vec3, u: Vec2, pdf: Pdf, le: Spectrum) -> Option<EmissionSample> {
    let (d, pdf_a) = (-wi, disk_density(scene));
    let (center, radius) = scene_sphere(scene);
    let (frame, q) = (Frame::from_normal(d), square_to_disk(u) * radius);
    (pdf_a > 0.0).then(|| EmissionSample {
        ray: Ray::new(center + frame.s * q.x + frame.t * q.y - d * radius, d),
        n: d,
        pdf: emission_pdf(scene, pdf),
        weight: le / (pdf_a * pdf.value()),
        emitter: id.emitter,
        primitive: id.primitive,
    })
}

/// The densities of such a ray.
pub(super) fn emission_pdf(scene: &Scene, direction: Pdf) -> EmissionPdf {
    EmissionPdf { position: PositionPdf::Area(disk_density(scene)), direction }
}

/// Φ, W, of `integral` = ∫ Le dw, W/m².
pub(super) fn power(scene: &Scene, integral: Spectrum) -> Spectrum {
    let (_, radius) = scene_sphere(scene);
    integral * (PI * radius * radius)
}
