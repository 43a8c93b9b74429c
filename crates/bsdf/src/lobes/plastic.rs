//! Smooth plastic: a dielectric varnish over a diffuse base, with all light that bounces between the two.
//!
//! Dirac: F(cosθ_o) of the light is mirrored. Smooth: f = (1 - F_o)(1 - F_i) / (π η²) · ρ/(1 - F_dr ρ'), where F_dr is what the varnish
//! sends back to the base and ρ' = ρ with `nonlinear`, else 1 (which keeps the hue of ρ) [Weidlich and Wilkie 2007, §3 for the idea].

use crate::{
    BsdfSample, Event, Scatter,
    fresnel::{self, diffuse_average, reflect_z},
    local::{clean, clean_eta, cosine_pdf, cosine_sample, dirac, mean, smooth, whole_dirac},
};
use etendue_numerics::{
    Spectrum, Vec2, Vec3,
    math::{FRAC_1_PI, PI},
};

/// What a [`Plastic`] or [`crate::lobes::RoughPlastic`] surface is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlasticParams {
    /// ρ of the base, in [0, 1]; default 0.5.
    pub diffuse_reflectance: Spectrum,
    /// A factor on what the varnish mirrors, in [0, 1]; 1 is physical and the default.
    pub specular_reflectance: Spectrum,
    /// η = interior/exterior index of the varnish; default polypropylene in air.
    pub eta: f32,
    /// Whether ρ is that of the bare base, so that inner bounces deepen its colour; default false.
    pub nonlinear: bool,
}

impl Default for PlasticParams {
    fn default() -> Self {
        Self {
            diffuse_reflectance: Spectrum::splat(0.5),
            specular_reflectance: Spectrum::ONE,
            eta: super::POLYPROPYLENE / super::AIR,
            nonlinear: false,
        }
    }
}

/// Ceramics, varnished wood, billiard balls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plastic {
    base: Base,
}

/// The diffuse base and what both plastics derive from their parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Base {
    /// ρ/(1 - F_dr ρ') / (π η²).
    pub f: Spectrum,
    /// The factor on the mirrored part.
    pub specular: Spectrum,
    /// η.
    pub eta: f32,
    /// The share of the mirrored part among both, before Fresnel.
    specular_share: f32,
    /// F_dr.
    internal: f32,
    nonlinear: bool,
}

impl Base {
    /// `internal` = F_dr(η), the reflectance of the varnish for diffuse light from inside.
    pub fn new(p: &PlasticParams, internal: impl Fn(f32) -> f32) -> Self {
        let eta = clean_eta(p.eta);
        let internal = internal(eta);
        let (reflectance, specular) = (clean(p.diffuse_reflectance), clean(p.specular_reflectance));
        let kept = if p.nonlinear { reflectance } else { Spectrum::ONE };
        let f = reflectance / (Spectrum::ONE - kept * internal).max(1e-4) * (FRAC_1_PI / (eta * eta));
        let (d, s) = (mean(reflectance), mean(specular));
        let specular_share = if d + s > 0.0 { s / (d + s) } else { 0.5 };
        Self { f, specular, eta, specular_share, internal, nonlinear: p.nonlinear }
    }

    /// ρ, by the inverse of what made `f`: it is asked for seldom.
    pub fn reflectance(&self) -> Spectrum {
        let y = self.f * (PI * self.eta * self.eta);
        if self.nonlinear { y / (Spectrum::ONE + y * self.internal) } else { y * (1.0 - self.internal).max(1e-4) }
    }

    /// The probability of the mirrored part where the varnish lets `t` of the light in.
    #[inline]
    pub fn specular_probability(&self, t: f32) -> f32 {
        let (s, d) = ((1.0 - t) * self.specular_share, t * (1.0 - self.specular_share));
        if s + d > 0.0 { s / (s + d) } else { 1.0 }
    }
}

impl Plastic {
    /// The lobe of these parameters.
    pub fn new(p: PlasticParams) -> Self {
        Self { base: Base::new(&p, |eta| diffuse_average(1.0 / eta)) }
    }

    /// 1 - F.
    #[inline]
    fn enters(&self, cos: f32) -> f32 {
        1.0 - fresnel::dielectric(cos, self.base.eta).f
    }
}

impl Scatter for Plastic {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Spectrum::ZERO;
        }
        self.base.f * (self.enters(wo.z) * self.enters(wi.z))
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        (1.0 - self.base.specular_probability(self.enters(wo.z))) * cosine_pdf(wi)
    }

    fn sample(&self, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let t = self.enters(wo.z);
        let p = self.base.specular_probability(t);
        if u1 < p {
            dirac(reflect_z(wo), self.base.specular * ((1.0 - t) / p), p, 1.0, Event::REFLECT)
        } else {
            let wi = cosine_sample(u2)?;
            smooth(wi, self.base.f * (t * self.enters(wi.z)), (1.0 - p) * cosine_pdf(wi), 1.0, Event::REFLECT | Event::DIFFUSE)
        }
    }

    fn diracs(&self, wo: Vec3, found: &mut dyn FnMut(BsdfSample)) {
        if wo.z > 0.0 {
            whole_dirac(reflect_z(wo), self.base.specular * (1.0 - self.enters(wo.z)), 1.0, Event::REFLECT, found);
        }
    }

    fn events(&self) -> Event {
        Event::REFLECT | Event::DELTA | Event::DIFFUSE
    }

    fn albedo(&self, wo: Vec3) -> Spectrum {
        Spectrum::lerp(self.enters(wo.z.max(0.0)), self.base.specular, self.base.reflectance())
    }

    fn diffuse_reflectance(&self) -> Spectrum {
        self.base.reflectance()
    }

    fn roughness(&self) -> f32 {
        0.0
    }

    fn importance(&self) -> f32 {
        self.base.reflectance().max_lane().max(self.base.specular.max_lane())
    }
}
