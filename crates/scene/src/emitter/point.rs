//! `point`: a point that radiates equally in all directions.
//!
//! ```text
//! E = I / r²,    Φ = 4π I
//! ```
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `intensity` | radiant intensity I, W/sr | 1 |
//! | `position`, or `to_world` | where, m | the origin |

use super::{EmissionPdf, EmissionSample, Extent, Light, LightBounds, LightId, LightReference, LightSample, PositionPdf, scalar};
use crate::scene::Scene;
use crate::texture::Color;
use etendue_numerics::math::PI;
use etendue_numerics::warp::{sphere_pdf, square_to_sphere};
use etendue_numerics::{Pdf, Ray, Spectrum, Vec2, Vec3, Wavelengths};

/// An isotropic point light.
#[derive(Clone, Debug)]
pub struct Point {
    /// Where, m.
    pub p: Vec3,
    /// I, W/sr.
    pub intensity: Color,
}

/// The only way from `from` to the point `p`: unit direction, distance and 1/r²; `None` where they coincide.
#[inline]
pub(super) fn towards(from: Vec3, p: Vec3) -> Option<(Vec3, f32, f32)> {
    let d = p - from;
    let r2 = d.length_squared();
    let r = r2.sqrt();
    (r2 > 0.0 && r2.is_finite()).then(|| (d / r, r, 1.0 / r2))
}

impl Light for Point {
    fn sample(&self, _: &Scene, from: &LightReference, id: LightId, _: Vec2, wl: &Wavelengths) -> Option<LightSample> {
        let (wi, distance, inverse_r2) = towards(from.p, self.p)?;
        let le = self.intensity.at(wl) * inverse_r2;
        Some(LightSample { wi, p: self.p, distance, le, pdf: Pdf::Delta(1.0), emitter: id.emitter, primitive: 0, n: Vec3::ZERO })
    }

    fn pdf_emission_discrete(&self, _: &Scene, _: Vec3) -> EmissionPdf {
        EmissionPdf { position: PositionPdf::Delta(1.0), direction: Pdf::SolidAngle(sphere_pdf()) }
    }

    fn sample_emission(&self, _: &Scene, id: LightId, _: Vec2, u_direction: Vec2, wl: &Wavelengths) -> Option<EmissionSample> {
        Some(EmissionSample {
            ray: Ray::new(self.p, square_to_sphere(u_direction)),
            n: Vec3::ZERO,
            pdf: EmissionPdf { position: PositionPdf::Delta(1.0), direction: Pdf::SolidAngle(sphere_pdf()) },
            weight: self.intensity.at(wl) / sphere_pdf(),
            emitter: id.emitter,
            primitive: id.primitive,
        })
    }

    fn power_of(&self, scene: &Scene, _: u32) -> Spectrum {
        self.intensity.mean(scene) * (4.0 * PI)
    }

    fn extent(&self, scene: &Scene, _: u32) -> Extent {
        Extent::Bounded(LightBounds::of_point(self.p, scalar(self.intensity.mean(scene))))
    }
}
