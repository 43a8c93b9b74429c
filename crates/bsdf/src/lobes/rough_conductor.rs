//! Rough metal: f = F(wo·m) D(m) G1(wo) G1(wi) / (4 cosθ_o cosθ_i), m the half vector [Cook and Torrance 1982; Walter et al. 2007,
//! eq. 20]. Single scattering: what meets a second facet is lost, so rough white metal absorbs (at α = 1 up to half the light).
//!
//! p(wi) = p(m) / (4 wi·m), p(m) that of the normals drawn [Walter et al. 2007, eq. 38].

use super::faceted::{self, Faceted, Turn};
use super::{Conductor, ConductorParams};
use crate::microfacet::facet::Facet;
use crate::{BsdfSample, Event, Microfacets, Ndf, Scatter, fresnel::reflect};
use etendue_numerics::{Spectrum, Vec2, Vec3};

/// What a [`RoughConductor`] is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughConductorParams {
    /// The metal.
    pub conductor: ConductorParams,
    /// Its distribution of normals; default Beckmann.
    pub ndf: Ndf,
    /// Roughness along local x, in [1e-4, 1]; default 0.1.
    pub alpha_u: f32,
    /// Roughness along local y, in [1e-4, 1]; default 0.1.
    pub alpha_v: f32,
    /// Draw visible normals only; default true.
    pub sample_visible: bool,
}

impl Default for RoughConductorParams {
    fn default() -> Self {
        Self { conductor: ConductorParams::default(), ndf: Ndf::Beckmann, alpha_u: 0.1, alpha_v: 0.1, sample_visible: true }
    }
}

/// Brushed, sand-blasted or cast metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughConductor {
    metal: Conductor,
    facets: Microfacets,
}

impl RoughConductor {
    const EVENT: Event = Event::REFLECT.with(Event::GLOSSY);

    /// The lobe of these parameters.
    pub fn new(p: RoughConductorParams) -> Self {
        Self { metal: Conductor::new(p.conductor), facets: Microfacets::new(p.ndf, p.alpha_u, p.alpha_v, p.sample_visible) }
    }
}

impl Faceted for RoughConductor {
    #[inline]
    fn facets(&self) -> (&Microfacets, f32) {
        (&self.facets, 1.0)
    }

    #[inline]
    fn at(&self, wo: Vec3, _: f32, wi: Vec3, facet: Option<&Facet>) -> (Spectrum, f32) {
        match facet {
            Some(x) if wo.z > 0.0 && wi.z > 0.0 => (self.metal.reflected(x.cos_o.min(1.0)) * (0.25 * x.dg), 0.25 * x.pdf),
            _ => (Spectrum::ZERO, 0.0),
        }
    }

    #[inline]
    fn turn(&self, wo: Vec3, _: f32, _: f32, _: Vec2, m: impl FnOnce() -> Vec3) -> Option<Turn> {
        if wo.z <= 0.0 {
            return None;
        }
        let m = m();
        Some(Turn { wi: reflect(wo, m), m: Some(m), eta: 1.0, event: Self::EVENT })
    }
}

/// The density of mirror images of `wo` at the facets drawn: p(m) / (4 wo·m).
#[inline]
pub(super) fn reflected_pdf(facets: &Microfacets, wo: Vec3, m: Vec3) -> f32 {
    let cos = wo.dot(m);
    if cos > 0.0 { facets.pdf(wo, m) / (4.0 * cos) } else { 0.0 }
}

/// The half vector of two directions of the upper hemisphere, where both see it from the front.
#[inline]
pub(super) fn half_vector(wo: Vec3, wi: Vec3) -> Option<Vec3> {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return None;
    }
    (wo + wi).try_normalize()
}

impl Scatter for RoughConductor {
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
        Self::EVENT
    }

    fn albedo(&self, wo: Vec3) -> Spectrum {
        self.metal.albedo(wo)
    }

    fn roughness(&self) -> f32 {
        self.facets.min_alpha()
    }

    fn importance(&self) -> f32 {
        self.metal.largest()
    }
}
