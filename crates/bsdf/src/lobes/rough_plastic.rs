//! Rough plastic: a rough dielectric varnish over a diffuse base, with all light that bounces between the two.
//!
//! f = F(wo·m) D(m) G / (4 cosθ_o cosθ_i) + T(cosθ_o) T(cosθ_i) / (π η²) · ρ/(1 - R ρ'): [`RoughTransmittance`] holds T and the internal
//! reflectance R of the varnish; ρ' = ρ with `nonlinear`, else 1.

use super::{PlasticParams, plastic::Base, rough_conductor::half_vector};
use crate::{
    BsdfSample, Event, Microfacets, Ndf, Scatter,
    fresnel::{self, reflect},
    local::{cosine_pdf, cosine_sample, smooth},
    microfacet::transmittance::RoughTransmittance,
};
use etendue_numerics::{Spectrum, Vec2, Vec3};

/// What a [`RoughPlastic`] is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughPlasticParams {
    /// Base and varnish.
    pub plastic: PlasticParams,
    /// The varnish's distribution of normals; default Beckmann.
    pub ndf: Ndf,
    /// Its roughness, in [1e-4, 1]; default 0.1.
    pub alpha: f32,
    /// Draw visible normals only; default true.
    pub sample_visible: bool,
}

impl Default for RoughPlasticParams {
    fn default() -> Self {
        Self { plastic: PlasticParams::default(), ndf: Ndf::Beckmann, alpha: 0.1, sample_visible: true }
    }
}

impl RoughPlasticParams {
    /// What depends on the boundary alone (`ndf`, `alpha`, `plastic.eta`); make it once per material, it takes milliseconds.
    pub fn transmittance(&self) -> RoughTransmittance {
        RoughTransmittance::new(self.ndf, self.alpha, self.plastic.eta)
    }
}

/// Matte plastic, eggshell paint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughPlastic {
    base: Base,
    boundary: RoughTransmittance,
    facets: Microfacets,
}

impl RoughPlastic {
    /// The lobe of these parameters; `boundary` is their [`RoughPlasticParams::transmittance`].
    pub fn new(p: RoughPlasticParams, boundary: &RoughTransmittance) -> Self {
        let base = Base::new(&p.plastic, |_| boundary.internal_reflectance());
        Self { base, boundary: *boundary, facets: Microfacets::new(p.ndf, p.alpha, p.alpha, p.sample_visible) }
    }

    /// f and p; `t` = T(cosθ_o).
    #[inline]
    fn at(&self, wo: Vec3, wi: Vec3, t: f32) -> (Spectrum, f32) {
        let Some(m) = half_vector(wo, wi) else { return (Spectrum::ZERO, 0.0) };
        let (dg, pdf) = self.facets.dg_pdf(wo, wi, m);
        let varnish = 0.25 * fresnel::dielectric(wo.dot(m), self.base.eta).f * dg;
        let f = self.base.specular * varnish + self.base.f * (t * self.boundary.at(wi.z));
        let p = self.base.specular_probability(t);
        (f, p * (0.25 * pdf) + (1.0 - p) * cosine_pdf(wi))
    }
}

impl Scatter for RoughPlastic {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        self.eval_pdf(wo, wi).0
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.eval_pdf(wo, wi).1
    }

    fn sample(&self, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let t = self.boundary.at(wo.z);
        let p = self.base.specular_probability(t);
        let (wi, event) =
            if u1 < p { (reflect(wo, self.facets.sample(wo, u2)), Event::GLOSSY) } else { (cosine_sample(u2)?, Event::DIFFUSE) };
        let (f, pdf) = self.at(wo, wi, t);
        smooth(wi, f, pdf, 1.0, Event::REFLECT | event)
    }

    #[inline]
    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        self.at(wo, wi, self.boundary.at(wo.z))
    }

    fn events(&self) -> Event {
        Event::REFLECT | Event::GLOSSY | Event::DIFFUSE
    }

    fn albedo(&self, wo: Vec3) -> Spectrum {
        Spectrum::lerp(self.boundary.at(wo.z), self.base.specular, self.base.reflectance())
    }

    fn diffuse_reflectance(&self) -> Spectrum {
        self.base.reflectance()
    }

    fn roughness(&self) -> f32 {
        self.facets.min_alpha()
    }

    fn importance(&self) -> f32 {
        self.base.reflectance().max_lane().max(self.base.specular.max_lane())
    }
}
