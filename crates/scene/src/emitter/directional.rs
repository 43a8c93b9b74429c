//! `directional`: parallel light from infinitely far away.
//!
//! ```text
//! E⊥ = E on every surface that faces it,    Φ = π R² E through the scene's sphere of radius R
//! ```
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `irradiance` | E on a surface that faces the light, W/m² | 1 |
//! | `direction`, or `to_world` (its +z) | where the light travels | +z |

use super::{EmissionPdf, EmissionSample, Extent, Light, LightId, LightReference, LightSample, PositionPdf, scalar};
use crate::scene::Scene;
use crate::texture::Color;
use etendue_numerics::math::PI;
use etendue_numerics::warp::square_to_disk;
use etendue_numerics::{Frame, Pdf, Ray, Spectrum, Vec2, Vec3, Wavelengths};

/// Light of one direction.
#[derive(Clone, Debug)]
pub struct Directional {
    /// Unit direction in which the light travels.
    pub direction: Vec3,
    /// E, W/m².
    pub irradiance: Color,
}

/// A ray towards the unit direction `d` that sets out uniformly from a disk before the scene's sphere, with its density 1/(πR²);
/// `None` for a scene without extent.
pub(super) fn from_infinity(scene: &Scene, d: Vec3, u: Vec2) -> Option<(Ray, f32)> {
    let pdf_a = disk_density(scene);
    let (center, radius) = scene_sphere(scene);
    let (frame, q) = (Frame::from_normal(d), square_to_disk(u) * radius);
    (pdf_a > 0.0).then(|| (Ray::new(center + frame.s * q.x + frame.t * q.y - d * radius, d), pdf_a))
}

/// Centre and radius R of a sphere around the scene, a little larger than its box needs, so that rays set out from outside.
pub(super) fn scene_sphere(scene: &Scene) -> (Vec3, f32) {
    let (center, radius) = scene.bounds.bounding_sphere();
    (center, radius * (1.0 + 1e-4))
}

/// 1/(πR²) for the scene's sphere of radius R, 1/m²; zero for a scene without extent.
pub(super) fn disk_density(scene: &Scene) -> f32 {
    let (_, radius) = scene_sphere(scene);
    let density = 1.0 / (PI * radius * radius);
    if density.is_finite() { density } else { 0.0 }
}

/// A point safely outside the scene, seen from `from` in the unit direction `wi`.
pub(super) fn outside(scene: &Scene, from: Vec3, wi: Vec3) -> Vec3 {
    let (center, radius) = scene_sphere(scene);
    from + wi * (2.0 * radius + (from - center).length())
}

impl Light for Directional {
    fn sample(&self, scene: &Scene, from: &LightReference, id: LightId, _: Vec2, wl: &Wavelengths) -> Option<LightSample> {
        let wi = -self.direction;
        let p = outside(scene, from.p, wi);
        let le = self.irradiance.at(wl);
        Some(LightSample {
            wi,
            p,
            distance: f32::INFINITY,
            le,
            pdf: Pdf::Delta(1.0),
            emitter: id.emitter,
            primitive: 0,
            n: Vec3::ZERO,
        })
    }

    fn pdf_emission_discrete(&self, scene: &Scene, _: Vec3) -> EmissionPdf {
        EmissionPdf { position: PositionPdf::Area(disk_density(scene)), direction: Pdf::Delta(1.0) }
    }

    fn sample_emission(&self, scene: &Scene, id: LightId, u: Vec2, _: Vec2, wl: &Wavelengths) -> Option<EmissionSample> {
        let (ray, pdf_a) = from_infinity(scene, self.direction, u)?;
        Some(EmissionSample {
            ray,
            n: self.direction,
            pdf: EmissionPdf { position: PositionPdf::Area(pdf_a), direction: Pdf::Delta(1.0) },
            weight: self.irradiance.at(wl) / pdf_a,
            emitter: id.emitter,
            primitive: id.primitive,
        })
    }

    fn power_of(&self, scene: &Scene, _: u32) -> Spectrum {
        let (_, radius) = scene_sphere(scene);
        self.irradiance.mean(scene) * (PI * radius * radius)
    }

    fn extent(&self, scene: &Scene, _: u32) -> Extent {
        let irradiance = scalar(self.irradiance.mean(scene));
        Extent::Distant { irradiance, excess: irradiance, from: Some(-self.direction) }
    }
}
