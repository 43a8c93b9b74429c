//! `directionalarea`: parallel light along a surface's normals, as of a laser.
//!
//! ```text
//! M(x) = L(x) towards n alone,    Φ = ∫ M dA
//! ```
//!
//! Only light that sets out from it can find what it lights: no point sees it by chance, and a scattered ray never meets its one
//! direction. Solvers that start at the eye show such lights as dark.
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `radiance` | M, the flux that leaves per area, W/m²; constant or textured | 1 |

use super::area::{mean_radiance, texture_context};
use super::{EmissionPdf, EmissionSample, Extent, Light, LightId, LightReference, LightSample, PositionPdf};
use crate::ids::SurfaceId;
use crate::interaction::Interaction;
use crate::scene::Scene;
use crate::shape::Geometry;
use crate::texture::ColorSlot;
use etendue_numerics::ray::offset_origin;
use etendue_numerics::{Pdf, Ray, Spectrum, Vec2, Wavelengths};

/// A surface that emits along its normals.
#[derive(Clone, Debug)]
pub struct DirectionalArea {
    /// The surface.
    pub surface: SurfaceId,
    /// M, W/m².
    pub radiance: ColorSlot,
}

impl Light for DirectionalArea {
    fn sample(&self, _: &Scene, _: &LightReference, _: LightId, _: Vec2, _: &Wavelengths) -> Option<LightSample> {
        None
    }

    fn pdf_emission(&self, scene: &Scene, id: LightId, _: &Interaction) -> EmissionPdf {
        let area = scene.surface(self.surface).shape.area_of(id.primitive);
        EmissionPdf { position: PositionPdf::Area(1.0 / area), direction: Pdf::Delta(1.0) }
    }

    fn sample_emission(&self, scene: &Scene, id: LightId, u: Vec2, _: Vec2, wl: &Wavelengths) -> Option<EmissionSample> {
        let at = scene.surface(self.surface).shape.sample_area(id.primitive, u);
        Some(EmissionSample {
            ray: Ray::new(offset_origin(at.p, at.p_error, at.n, at.n), at.n),
            n: at.n,
            pdf: EmissionPdf { position: PositionPdf::Area(at.pdf_a), direction: Pdf::Delta(1.0) },
            weight: self.radiance.eval(&texture_context(scene, self.surface, &at), wl) / at.pdf_a,
            emitter: id.emitter,
            primitive: id.primitive,
        })
    }

    fn power_of(&self, scene: &Scene, primitive: u32) -> Spectrum {
        let area = scene.surface(self.surface).shape.area_of(primitive);
        mean_radiance(scene, self.surface, &self.radiance, primitive) * area
    }

    fn primitive_count(&self, scene: &Scene) -> u32 {
        scene.surface(self.surface).shape.primitive_count()
    }

    fn extent(&self, _: &Scene, _: u32) -> Extent {
        Extent::Unseen
    }
}
