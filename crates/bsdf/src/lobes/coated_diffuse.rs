//! Lambert's ground under a layer with a dielectric boundary, all light that bounces between the two in it.
//!
//! ```text
//! f = F(wo·m) D(m) G/(4 cosθ_o cosθ_i) + ρ T(cosθ_o) T(cosθ_i)/(π η²) Σ_k (ρ R)^k,    k < K
//! ```
//!
//! T and R are those of [`coat`]. The ground forgets where light came from, so that the sum over bounces is exact; K
//! bounds it, as walks of bounded length do. A smooth boundary's first term is a Dirac.
//!
//! p: the boundary's reflection with a probability near its share, else the cosine.

use super::rough_conductor::{half_vector, reflected_pdf};
use crate::{
    BsdfSample, Event, Microfacets, Ndf, Scatter,
    fresnel::{self, reflect, reflect_z},
    local::{clean, clean_eta, clean_f32, cosine_pdf, cosine_sample, dirac, smooth, whole_dirac},
    microfacet::{coat::coat, transmittance::RoughTransmittance},
};
use etendue_numerics::{Spectrum, Vec2, Vec3, math::FRAC_1_PI};

/// What a [`CoatedDiffuse`] is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoatedDiffuseParams {
    /// ρ in [0, 1]; default 0.5.
    pub reflectance: Spectrum,
    /// η, the layer's index over the outside's; default 1.5.
    pub eta: f32,
    /// Roughness of the boundary, in [1e-4, 1]; `None`, the default, is smooth.
    pub alpha: Option<f32>,
    /// Optical thickness of the layer; default 0.01.
    pub thickness: f32,
    /// K: how often light is scattered by the ground at the most; default 5.
    pub bounces: u32,
}

impl Default for CoatedDiffuseParams {
    fn default() -> Self {
        Self { reflectance: Spectrum::splat(0.5), eta: 1.5, alpha: None, thickness: 0.01, bounces: 5 }
    }
}

impl CoatedDiffuseParams {
    /// What does not depend on ρ and K; make it once per material, it takes milliseconds.
    pub fn coat(&self) -> RoughTransmittance {
        coat(self.alpha, self.eta, self.thickness)
    }
}

/// Varnished wood, glazed tiles, plastic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoatedDiffuse {
    /// ρ Σ (ρ R)^k / (π η²).
    base: Spectrum,
    /// What of the light leaves again by the ground, at most: ρ Σ (ρ R)^k (1 - R).
    reflectance: Spectrum,
    coat: RoughTransmittance,
    facets: Option<Microfacets>,
    eta: f32,
}

impl CoatedDiffuse {
    /// The lobe of these parameters; `coat` is their [`CoatedDiffuseParams::coat`].
    pub fn new(p: CoatedDiffuseParams, coat: &RoughTransmittance) -> Self {
        let eta = clean_eta(p.eta);
        let rho = clean(p.reflectance).clamp(0.0, 1.0);
        let r = coat.internal_reflectance().clamp(0.0, 1.0);
        let (mut sum, mut power) = (Spectrum::ZERO, rho);
        for _ in 0..p.bounces.clamp(1, 1000) {
            sum += power;
            power *= rho * r;
            if power.max_lane() < 1e-7 {
                break;
            }
        }
        Self {
            base: sum * (FRAC_1_PI / (eta * eta)),
            reflectance: (sum * (1.0 - r)).clamp(0.0, 1.0),
            coat: *coat,
            facets: p.alpha.map(|alpha| Microfacets::new(Ndf::GgxCorrelated, alpha, alpha, true)),
            eta,
        }
    }

    /// How often the boundary is sampled, seen from cosine `mu`; `t` = T(mu).
    #[inline]
    fn boundary_share(&self, t: f32, mu: f32) -> f32 {
        let specular = match self.facets {
            Some(_) => (1.0 - t).max(0.02),
            None => fresnel::dielectric(mu, self.eta).f,
        };
        let diffuse = self.reflectance.max_lane() * t;
        clean_f32(specular / (specular + diffuse), 0.0, 1.0, 1.0)
    }

    /// f of the rough boundary.
    #[inline]
    fn glossy(&self, wo: Vec3, wi: Vec3, m: Vec3) -> f32 {
        self.facets.map_or(0.0, |facets| 0.25 * fresnel::dielectric(wo.dot(m), self.eta).f * facets.dg(wo, wi, m))
    }
}

impl Scatter for CoatedDiffuse {
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
        let q = self.boundary_share(self.coat.at(wo.z), wo.z);
        let (wi, event) = match self.facets {
            _ if u1 >= q => (cosine_sample(u2)?, Event::DIFFUSE),
            Some(facets) => (reflect(wo, facets.sample(wo, u2)), Event::GLOSSY),
            None => {
                let f = fresnel::dielectric(wo.z, self.eta).f;
                return dirac(reflect_z(wo), Spectrum::splat(f / q), q, 1.0, Event::REFLECT);
            }
        };
        let (f, pdf) = self.eval_pdf(wo, wi);
        smooth(wi, f, pdf, 1.0, Event::REFLECT | event)
    }

    fn diracs(&self, wo: Vec3, found: &mut dyn FnMut(BsdfSample)) {
        if self.facets.is_none() && wo.z > 0.0 {
            whole_dirac(reflect_z(wo), Spectrum::splat(fresnel::dielectric(wo.z, self.eta).f), 1.0, Event::REFLECT, found);
        }
    }

    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        let Some(m) = half_vector(wo, wi) else { return (Spectrum::ZERO, 0.0) };
        let t = self.coat.at(wo.z);
        let q = self.boundary_share(t, wo.z);
        let f = self.base * (t * self.coat.at(wi.z)) + Spectrum::splat(self.glossy(wo, wi, m));
        let glossy = self.facets.map_or(0.0, |facets| q * reflected_pdf(&facets, wo, m));
        (f, glossy + (1.0 - q) * cosine_pdf(wi))
    }

    fn events(&self) -> Event {
        let boundary = if self.facets.is_some() { Event::GLOSSY } else { Event::DELTA };
        Event::REFLECT | Event::DIFFUSE | boundary
    }

    fn albedo(&self, wo: Vec3) -> Spectrum {
        Spectrum::lerp(self.coat.at(wo.z.max(0.0)), Spectrum::ONE, self.reflectance)
    }

    fn diffuse_reflectance(&self) -> Spectrum {
        self.reflectance
    }

    fn roughness(&self) -> f32 {
        self.facets.map_or(0.0, |facets| facets.min_alpha())
    }

    fn importance(&self) -> f32 {
        self.reflectance.max_lane().max(0.1)
    }
}
