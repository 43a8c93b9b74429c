//! A thin sheet that scatters diffusely to both sides: f = ρ/π on the side of `wo`, τ/π on the other.
//!
//! p: cosine/π on either side, chosen in proportion to the largest lanes of ρ and τ.

use crate::{
    BsdfSample, Event, Scatter,
    local::{clean, cosine_pdf, cosine_sample, same_side, weighted},
};
use etendue_numerics::{Spectrum, Vec2, Vec3, math::FRAC_1_PI};

/// What a [`DiffuseTransmission`] is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseTransmissionParams {
    /// ρ; default 0.25.
    pub reflectance: Spectrum,
    /// τ; default 0.25. ρ + τ should not exceed 1.
    pub transmittance: Spectrum,
}

impl Default for DiffuseTransmissionParams {
    fn default() -> Self {
        Self { reflectance: Spectrum::splat(0.25), transmittance: Spectrum::splat(0.25) }
    }
}

/// Paper, leaves, lampshades.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseTransmission {
    reflectance: Spectrum,
    transmittance: Spectrum,
}

impl DiffuseTransmission {
    /// The lobe of these parameters.
    pub fn new(p: DiffuseTransmissionParams) -> Self {
        Self { reflectance: clean(p.reflectance), transmittance: clean(p.transmittance) }
    }

    /// How often light is reflected; `None` where none is scattered.
    #[inline]
    fn share(&self) -> Option<f32> {
        let (r, t) = (self.reflectance.max_lane(), self.transmittance.max_lane());
        (r + t > 0.0).then(|| r / (r + t))
    }
}

impl Scatter for DiffuseTransmission {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        if wo.z * wi.z == 0.0 {
            return Spectrum::ZERO;
        }
        if same_side(wo, wi) { self.reflectance * FRAC_1_PI } else { self.transmittance * FRAC_1_PI }
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let Some(q) = self.share().filter(|_| wo.z * wi.z != 0.0) else { return 0.0 };
        let cosine = cosine_pdf(Vec3::new(wi.x, wi.y, wi.z.abs()));
        cosine * if same_side(wo, wi) { q } else { 1.0 - q }
    }

    fn sample(&self, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample> {
        let q = self.share().filter(|_| wo.z != 0.0)?;
        let local = cosine_sample(u2)?;
        let cosine = cosine_pdf(local);
        let up = wo.z > 0.0;
        let (albedo, p, above, event) =
            if u1 < q { (self.reflectance, q, up, Event::REFLECT) } else { (self.transmittance, 1.0 - q, !up, Event::TRANSMIT) };
        let wi = if above { local } else { Vec3::new(local.x, local.y, -local.z) };
        weighted(wi, albedo / p, cosine * p, 1.0, event | Event::DIFFUSE)
    }

    fn events(&self) -> Event {
        Event::REFLECT | Event::TRANSMIT | Event::DIFFUSE
    }

    fn albedo(&self, _wo: Vec3) -> Spectrum {
        self.reflectance + self.transmittance
    }

    fn diffuse_reflectance(&self) -> Spectrum {
        self.reflectance
    }

    fn roughness(&self) -> f32 {
        1.0
    }

    fn importance(&self) -> f32 {
        self.reflectance.max_lane() + self.transmittance.max_lane()
    }
}
