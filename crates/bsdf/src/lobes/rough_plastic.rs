//! Rough plastic: a rough dielectric varnish over a diffuse base, with all light that bounces between the two.
//!
//! f = F(wo·m) D(m) G / (4 cosθ_o cosθ_i) + T(cosθ_o) T(cosθ_i) / (π η²) · ρ/(1 - R ρ'): [`RoughTransmittance`] holds T and the internal
//! reflectance R of the varnish; ρ' = ρ with `nonlinear`, else 1.

use super::{
    PlasticParams,
    faceted::{self, Faceted, Turn},
    plastic::Base,
};
use crate::{
    BsdfSample, Event, Microfacets, Ndf, Scatter,
    fresnel::reflect,
    local::{cosine_pdf, cosine_sample},
    microfacet::{facet::Facet, transmittance::RoughTransmittance},
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
}

impl Faceted for RoughPlastic {
    #[inline]
    fn facets(&self) -> (&Microfacets, f32) {
        (&self.facets, self.base.eta)
    }

    /// T(cosθ_o).
    #[inline]
    fn towards(&self, wo: Vec3) -> f32 {
        self.boundary.at(wo.z)
    }

    #[inline]
    fn at(&self, wo: Vec3, t: f32, wi: Vec3, facet: Option<&Facet>) -> (Spectrum, f32) {
        let Some(x) = facet.filter(|_| wo.z > 0.0 && wi.z > 0.0) else { return (Spectrum::ZERO, 0.0) };
        let f = self.base.specular * (0.25 * x.f * x.dg) + self.base.f * (t * self.boundary.at(wi.z));
        let p = self.base.specular_probability(t);
        (f, p * (0.25 * x.pdf) + (1.0 - p) * cosine_pdf(wi))
    }

    #[inline]
    fn turn(&self, wo: Vec3, t: f32, u1: f32, u2: Vec2, m: impl FnOnce() -> Vec3) -> Option<Turn> {
        if wo.z <= 0.0 {
            return None;
        }
        if u1 < self.base.specular_probability(t) {
            let m = m();
            return Some(Turn { wi: reflect(wo, m), m: Some(m), eta: 1.0, event: Event::REFLECT | Event::GLOSSY });
        }
        Some(Turn { wi: cosine_sample(u2)?, m: None, eta: 1.0, event: Event::REFLECT | Event::DIFFUSE })
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
        faceted::sample(self, wo, u1, u2)
    }

    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        faceted::eval_pdf(self, wo, wi)
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
