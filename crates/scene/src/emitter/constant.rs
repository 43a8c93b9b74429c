//! `constant`: the same radiance from all around.
//!
//! ```text
//! Le(w) = L,    Φ = 4π² R² L through the scene's sphere of radius R
//! p_w = |cosθ| / 2π  about a normal,  max(cosθ, 0) / π  where one side matters,  1/4π  where there is no normal
//! ```
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `radiance` | L, W/(m² sr) | 1 |

use super::infinity::{emission_pdf, emission_sample, light_sample, power};
use super::{EmissionPdf, EmissionSample, Extent, Light, LightId, LightReference, LightSample, scalar};
use crate::scene::Scene;
use crate::texture::Color;
use etendue_numerics::math::{FRAC_1_PI, ONE_MINUS_EPSILON, PI};
use etendue_numerics::warp::{sphere_pdf, square_to_cosine_hemisphere, square_to_sphere};
use etendue_numerics::{Frame, Pdf, Spectrum, Vec2, Vec3, Wavelengths};

/// Uniform surroundings.
#[derive(Clone, Debug)]
pub struct Constant {
    /// L, W/(m² sr).
    pub radiance: Color,
}

impl Light for Constant {
    fn le_escaped(&self, _: Vec3, _: Vec3, wl: &Wavelengths) -> Spectrum {
        self.radiance.at(wl)
    }

    fn pdf_escaped(&self, from: &LightReference, wi: Vec3) -> f32 {
        let cos = from.n.dot(wi);
        if from.n == Vec3::ZERO {
            sphere_pdf()
        } else if from.one_sided {
            FRAC_1_PI * cos.max(0.0)
        } else {
            0.5 * FRAC_1_PI * cos.abs()
        }
    }

    fn sample(&self, scene: &Scene, from: &LightReference, id: LightId, u: Vec2, wl: &Wavelengths) -> Option<LightSample> {
        let wi = if from.n == Vec3::ZERO {
            square_to_sphere(u)
        } else if from.one_sided {
            Frame::from_normal(from.n).to_world(square_to_cosine_hemisphere(u))
        } else {
            // The lower half of u.x serves the front, the upper half the back.
            let (side, x) = if u.x < 0.5 { (1.0, 2.0 * u.x) } else { (-1.0, 2.0 * u.x - 1.0) };
            let local = square_to_cosine_hemisphere(Vec2::new(x.min(ONE_MINUS_EPSILON), u.y));
            Frame::from_normal(from.n * side).to_world(local)
        }
        .normalize();
        let pdf_w = self.pdf_escaped(from, wi);
        (pdf_w > 0.0).then(|| light_sample(scene, from, id, wi, Pdf::SolidAngle(pdf_w), self.radiance.at(wl)))
    }

    fn pdf_emission_escaped(&self, scene: &Scene, _: Vec3) -> EmissionPdf {
        emission_pdf(scene, Pdf::SolidAngle(sphere_pdf()))
    }

    fn sample_emission(&self, scene: &Scene, id: LightId, u: Vec2, u_direction: Vec2, wl: &Wavelengths) -> Option<EmissionSample> {
        let wi = square_to_sphere(u_direction).normalize();
        emission_sample(scene, id, wi, u, Pdf::SolidAngle(sphere_pdf()), self.radiance.at(wl))
    }

    fn power_of(&self, scene: &Scene, _: u32) -> Spectrum {
        power(scene, self.radiance.mean(scene) * (4.0 * PI))
    }

    fn extent(&self, scene: &Scene, _: u32) -> Extent {
        let irradiance = PI * scalar(self.radiance.mean(scene));
        Extent::Distant { irradiance, excess: irradiance, from: None }
    }
}
