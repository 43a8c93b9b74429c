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

use super::infinity::{emission_pdf, emission_sample, light_sample, power};
use super::{EmissionPdf, EmissionSample, Extent, Light, LightId, LightReference, LightSample, scalar};
use crate::scene::Scene;
use crate::texture::Color;
use etendue_numerics::{Pdf, Spectrum, Vec2, Vec3, Wavelengths};

/// Light of one direction.
#[derive(Clone, Debug)]
pub struct Directional {
    /// Unit direction in which the light travels.
    pub direction: Vec3,
    /// E, W/m².
    pub irradiance: Color,
}

impl Light for Directional {
    fn sample(&self, scene: &Scene, from: &LightReference, id: LightId, _: Vec2, wl: &Wavelengths) -> Option<LightSample> {
        Some(light_sample(scene, from, id, -self.direction, Pdf::Delta(1.0), self.irradiance.at(wl)))
    }

    fn pdf_emission_discrete(&self, scene: &Scene, _: Vec3) -> EmissionPdf {
        emission_pdf(scene, Pdf::Delta(1.0))
    }

    fn sample_emission(&self, scene: &Scene, id: LightId, u: Vec2, _: Vec2, wl: &Wavelengths) -> Option<EmissionSample> {
        emission_sample(scene, id, -self.direction, u, Pdf::Delta(1.0), self.irradiance.at(wl))
    }

    fn power_of(&self, scene: &Scene, _: u32) -> Spectrum {
        power(scene, self.irradiance.mean(scene))
    }

    fn extent(&self, scene: &Scene, _: u32) -> Extent {
        let irradiance = scalar(self.irradiance.mean(scene));
        Extent::Distant { irradiance, excess: irradiance, from: Some(-self.direction) }
    }
}
