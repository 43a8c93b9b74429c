//! A rough interface between two dielectrics [Walter et al. 2007].
//!
//! Reflection: f = F D(m) G / (4 cosθ_o cosθ_i), m = (wo + wi)/|wo + wi| (eq. 20).
//! Transmission: f = (1 - F) D(m) G η² (wo·m)(wi·m) / (cosθ_o cosθ_i (wo·m + η wi·m)²), m along wo + η wi, η = η_t/η_i from the side of
//! `wo` to that of `wi` (eq. 21, importance form). All cosines by magnitude; m is turned to the side of the macroscopic normal.
//!
//! p(wi) = p(m) times the Jacobian 1/(4 wi·m) (eq. 14) or η² (wi·m)/(wo·m + η wi·m)² (eq. 17), times F or 1 - F. Single scattering: what
//! meets a second facet is lost.

use super::DielectricParams;
use super::faceted::{self, Faceted, Turn};
use crate::{
    BsdfSample, Event, Microfacets, Ndf, Scatter,
    fresnel::{self, reflect, refract},
    local::{clean, clean_eta, same_side},
    microfacet::facet::Facet,
};
use etendue_numerics::{Spectrum, Vec2, Vec3};

/// What a [`RoughDielectric`] is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughDielectricParams {
    /// The interface; an index of exactly 1 has no facets to speak of and is taken as 1.0001.
    pub dielectric: DielectricParams,
    /// Its distribution of normals; default Beckmann.
    pub ndf: Ndf,
    /// Roughness along local x, in [1e-4, 1]; default 0.1.
    pub alpha_u: f32,
    /// Roughness along local y, in [1e-4, 1]; default 0.1.
    pub alpha_v: f32,
    /// Draw visible normals only; default true.
    pub sample_visible: bool,
}

impl Default for RoughDielectricParams {
    fn default() -> Self {
        Self { dielectric: DielectricParams::default(), ndf: Ndf::Beckmann, alpha_u: 0.1, alpha_v: 0.1, sample_visible: true }
    }
}

/// Ground or etched glass: the border of a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughDielectric {
    reflectance: Spectrum,
    transmittance: Spectrum,
    facets: Microfacets,
    eta: f32,
    disperses: bool,
}

impl RoughDielectric {
    /// The lobe of these parameters.
    pub fn new(p: RoughDielectricParams) -> Self {
        let d = p.dielectric;
        let eta = clean_eta(d.eta);
        Self {
            reflectance: clean(d.specular_reflectance),
            transmittance: clean(d.specular_transmittance),
            facets: Microfacets::new(p.ndf, p.alpha_u, p.alpha_v, p.sample_visible),
            eta: if (eta - 1.0).abs() < 1e-4 { 1.0001 } else { eta },
            disperses: d.disperses,
        }
    }
}

impl Faceted for RoughDielectric {
    #[inline]
    fn facets(&self) -> (&Microfacets, f32) {
        (&self.facets, self.eta)
    }

    /// Normals that need not be seen are drawn from wider facets.
    #[inline]
    fn drawn(&self, wo: Vec3) -> Microfacets {
        self.facets.widened(wo.z)
    }

    /// D G / (cosθ_o cosθ_i) times F/4, or times (1 - F) |wo·m| and the Jacobian of refraction.
    #[inline]
    fn at(&self, wo: Vec3, _: f32, _wi: Vec3, facet: Option<&Facet>) -> (Spectrum, f32) {
        let Some(x) = facet else { return (Spectrum::ZERO, 0.0) };
        let pdf = if self.facets.samples_visible() { x.pdf } else { self.drawn(wo).d(x.m) * x.m.z / x.cos_o };
        let through = x.cos_o * x.jacobian;
        if x.reflects {
            (self.reflectance * (0.25 * x.f * x.dg), pdf * through * x.f)
        } else {
            (self.transmittance * ((1.0 - x.f) * x.dg * through), pdf * through * (1.0 - x.f))
        }
    }

    #[inline]
    fn turn(&self, wo: Vec3, _: f32, u1: f32, _: Vec2, m: impl FnOnce() -> Vec3) -> Option<Turn> {
        if wo.z == 0.0 {
            return None;
        }
        let m = m();
        let x = fresnel::dielectric(wo.dot(m), self.eta);
        let reflects = u1 < x.f;
        let wi = if reflects { reflect(wo, m) } else { refract(wo, m, &x) };
        if wi.z == 0.0 || same_side(wo, wi) != reflects {
            return None;
        }
        let path = if wo.z > 0.0 { self.eta } else { 1.0 / self.eta };
        let (eta, event) = if reflects { (1.0, Event::REFLECT) } else { (path, Event::TRANSMIT) };
        Some(Turn { wi, m: Some(m), eta, event: event | Event::GLOSSY })
    }
}

impl Scatter for RoughDielectric {
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
        let all = Event::REFLECT | Event::TRANSMIT | Event::GLOSSY;
        if self.disperses { all | Event::DISPERSES } else { all }
    }

    fn albedo(&self, wo: Vec3) -> Spectrum {
        Spectrum::lerp(fresnel::dielectric(wo.z, self.eta).f, self.transmittance, self.reflectance)
    }

    fn roughness(&self) -> f32 {
        self.facets.min_alpha()
    }

    fn eta(&self) -> f32 {
        self.eta
    }

    fn importance(&self) -> f32 {
        self.reflectance.max_lane().max(self.transmittance.max_lane())
    }
}
