//! A ground under a scattering layer with a dielectric boundary, by random walks [Guo, Hašan, Zhao 2018; Pharr, Jakob, Humphreys 2023, §14.3].
//!
//! ```text
//! f(wo, wi) = f_boundary(wo, wi) + E[walks that enter along wo, meet ground and layer, and leave along wi]/η²
//! ```
//!
//! `eval` is an unbiased estimate, the same for the same bits of `wo` and `wi`: they seed the walk. At each event on the ground or in the layer the walk is
//! joined to a direction that light from `wi` takes behind the boundary; where the boundary is rough, also along the direction that the event
//! sends it to, weighed by the power heuristic [Veach 1997, §9.2.4]. A walk has `max_depth` events at the most.
//!
//! `pdf` is exact for what `sample` does, which does not walk: it reflects at the boundary, at a proxy of the ground (its facets, tilted as
//! refraction shows them), or by the cosine.
//!
//! | symbol | identifier |
//! | --- | --- |
//! | a direction of travel within the layer, z > 0 upwards | `d` |
//! | what a walk still carries | `beta` |
//! | the height above the ground, in optical thickness | `z` |

mod boundary;
mod ground;
mod medium;
mod walk;

use super::rough_conductor::{half_vector, reflected_pdf};
use crate::local::{clean, clean_eta, clean_f32, cosine_pdf, cosine_sample, dirac, smooth, whole_dirac};
use crate::{
    BsdfSample, Event, Microfacets, Scatter,
    fresnel::{self, reflect, reflect_z, refract},
};
use boundary::Boundary;
use etendue_numerics::math::sqr;
use etendue_numerics::{Spectrum, Vec2, Vec3};
use ground::{Base, rough};
use medium::Medium;
use walk::stream;

/// What lies under the layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ground {
    /// Lambert's, of this reflectance.
    Diffuse(Spectrum),
    /// A metal: η, k and the roughness of its facets along x and y, or a mirror.
    Metal(Spectrum, Spectrum, Option<[f32; 2]>),
}

/// What a [`Layered`] is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayeredParams {
    /// The ground; default diffuse 0.5.
    pub ground: Ground,
    /// η, the layer's index over the outside's; default 1.5.
    pub eta: f32,
    /// Roughness of the boundary along x and y, in [1e-4, 1]; `None`, the default, is smooth.
    pub alpha: Option<[f32; 2]>,
    /// Optical thickness of the layer; default 0.01.
    pub thickness: f32,
    /// The share of light that the layer's particles scatter; default 0.
    pub albedo: Spectrum,
    /// Henyey and Greenstein's g of the particles; default 0.
    pub g: f32,
    /// Events of a walk at the most; default 10.
    pub max_depth: u32,
    /// Walks of an estimate; default 1.
    pub samples: u32,
}

impl Default for LayeredParams {
    fn default() -> Self {
        Self {
            ground: Ground::Diffuse(Spectrum::splat(0.5)),
            eta: 1.5,
            alpha: None,
            thickness: 0.01,
            albedo: Spectrum::ZERO,
            g: 0.0,
            max_depth: 10,
            samples: 1,
        }
    }
}

/// Lacquered metal, hazy varnish.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layered {
    boundary: Boundary,
    medium: Medium,
    base: Base,
    /// The ground's facets as they look from outside.
    proxy: Option<Microfacets>,
    max_depth: u32,
    samples: u32,
}

impl Layered {
    /// The lobe of these parameters.
    pub fn new(p: LayeredParams) -> Self {
        let eta = clean_eta(p.eta);
        let eta = if (eta - 1.0).abs() < 1e-4 { 1.0001 } else { eta };
        // A tilt δ of the ground looks like ηδ from outside; a rough boundary blurs twice by (η - 1) of its own tilt.
        let proxy = match p.ground {
            Ground::Diffuse(_) => None,
            Ground::Metal(_, _, alpha) => {
                let [bu, bv] = p.alpha.unwrap_or([0.0; 2]);
                let blur =
                    |ground: f32, boundary: f32| (sqr(eta * ground) + 2.0 * sqr((eta - 1.0) * boundary)).sqrt().clamp(0.01, 1.0);
                let [gu, gv] = alpha.unwrap_or([0.0; 2]);
                Some(rough([blur(gu, bu), blur(gv, bv)]))
            }
        };
        Self {
            boundary: Boundary { facets: p.alpha.map(rough), eta },
            medium: Medium {
                thickness: clean_f32(p.thickness, 1e-6, 1e3, 0.01),
                albedo: clean(p.albedo).clamp(0.0, 1.0),
                g: clean_f32(p.g, -0.99, 0.99, 0.0),
            },
            base: Base::of(p.ground),
            proxy,
            max_depth: p.max_depth.clamp(1, 1000),
            samples: p.samples.clamp(1, 1000),
        }
    }

    /// What a smooth boundary over a mirror reflects: all bounces between both.
    fn mirrored(&self, wo: Vec3) -> Spectrum {
        let x = fresnel::dielectric(wo.z, self.boundary.eta);
        let d = refract(wo, Vec3::Z, &x);
        let Base::Mirror(n, k) = self.base else { return Spectrum::splat(x.f) };
        let mut sum = Spectrum::splat(x.f);
        let way = self.medium.through(self.medium.thickness, d);
        let round = fresnel::conductor(-d.z, n, k) * (way * way);
        let mut carried = round * sqr(1.0 - x.f);
        for _ in 0..self.max_depth.div_ceil(2) {
            sum += carried;
            carried *= round * x.f;
        }
        sum
    }

    /// How often `sample` takes the boundary, and the proxy of the ground.
    fn shares(&self, cos: f32) -> [f32; 2] {
        let f = fresnel::dielectric(cos, self.boundary.eta).f;
        match self.base {
            Base::Mirror(..) if self.boundary.facets.is_none() => [if self.medium.albedo.is_zero() { 1.0 } else { 0.7 }, 0.0],
            Base::Diffuse(rho) => [f / (f + (1.0 - f) * rho.max_lane().max(0.05)), 0.0],
            _ => [0.8 * f.max(0.1), 0.8 * (1.0 - f.max(0.1))],
        }
    }

    fn is_mirror(&self) -> bool {
        self.boundary.facets.is_none() && matches!(self.base, Base::Mirror(..)) && self.medium.albedo.is_zero()
    }
}

impl Scatter for Layered {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        let Some(m) = half_vector(wo, wi) else { return Spectrum::ZERO };
        if self.is_mirror() {
            return Spectrum::ZERO;
        }
        let boundary = self
            .boundary
            .facets
            .map_or(0.0, |facets| 0.25 * fresnel::dielectric(wo.dot(m), self.boundary.eta).f * facets.dg(wo, wi, m));
        let mut numbers = stream(wo, wi);
        let walks: Spectrum = (0..self.samples).filter_map(|_| self.walk(wo, wi, &mut numbers)).sum();
        let f = Spectrum::splat(boundary) + walks * (1.0 / (sqr(self.boundary.eta) * self.samples as f32));
        if f.is_finite() { f } else { Spectrum::splat(boundary) }
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let Some(m) = half_vector(wo, wi) else { return 0.0 };
        let [boundary, ground] = self.shares(wo.z);
        let reflected = |facets: Option<Microfacets>| facets.map_or(0.0, |facets| reflected_pdf(&facets, wo, m));
        boundary * reflected(self.boundary.facets)
            + ground * reflected(self.proxy)
            + (1.0 - boundary - ground).max(0.0) * cosine_pdf(wi)
    }

    fn sample(&self, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let [boundary, ground] = self.shares(wo.z);
        let (facets, event) = if u1 < boundary {
            (self.boundary.facets, Event::GLOSSY)
        } else if u1 < boundary + ground {
            (self.proxy, Event::GLOSSY)
        } else {
            (None, Event::DIFFUSE)
        };
        let wi = match (facets, event) {
            (Some(facets), _) => reflect(wo, facets.sample(wo, u2)),
            (None, Event::DIFFUSE) => cosine_sample(u2)?,
            (None, _) => return dirac(reflect_z(wo), self.mirrored(wo) / boundary, boundary, 1.0, Event::REFLECT),
        };
        let pdf = self.pdf(wo, wi);
        smooth(wi, self.eval(wo, wi), pdf, 1.0, Event::REFLECT | event)
    }

    fn diracs(&self, wo: Vec3, found: &mut dyn FnMut(BsdfSample)) {
        if self.boundary.facets.is_none() && wo.z > 0.0 {
            whole_dirac(reflect_z(wo), self.mirrored(wo), 1.0, Event::REFLECT, found);
        }
    }

    fn events(&self) -> Event {
        let boundary = if self.boundary.facets.is_some() { Event::GLOSSY } else { Event::DELTA };
        let rest = if self.is_mirror() { Event::NONE } else { Event::DIFFUSE.with(Event::GLOSSY) };
        Event::REFLECT | rest | boundary
    }

    fn albedo(&self, wo: Vec3) -> Spectrum {
        let f = fresnel::dielectric(wo.z, self.boundary.eta).f;
        Spectrum::lerp(f, self.base.reflectance(), Spectrum::ONE)
    }

    fn diffuse_reflectance(&self) -> Spectrum {
        if let Base::Diffuse(rho) = self.base { rho } else { Spectrum::ZERO }
    }

    fn roughness(&self) -> f32 {
        let base = match self.base {
            Base::Diffuse(_) => 1.0,
            Base::Mirror(..) => 0.0,
            Base::Metal(_, _, facets) => facets.min_alpha(),
        };
        self.boundary.facets.map_or(0.0, |facets| facets.min_alpha()).min(base)
    }

    fn importance(&self) -> f32 {
        self.base.reflectance().max_lane().max(0.1)
    }
}
