//! `conductor`, `roughconductor`: metals.
//!
//! Parameters: `material` (a metal's name; default `none`, η = 0 and k = 1, which reflects all) or `eta` and `k` over the exterior's index;
//! or `reflectance` r at normal incidence, which stands for η = 1 and k = 2 √(r/(1 - r));
//! `specular_reflectance` (default 1, the physical value); the rough one also those of [`Roughness`].

use super::{Roughness, Single, Site};
use crate::texture::ColorSlot;
use etendue_bsdf::{
    Event, Lobe,
    lobes::{self, ConductorParams, RoughConductorParams},
};
use etendue_numerics::Spectrum;

/// A polished metal.
#[derive(Clone, Debug)]
pub struct Conductor {
    /// η, real part of the index.
    pub eta: ColorSlot,
    /// k, imaginary part of the index.
    pub k: ColorSlot,
    /// r in place of both.
    pub reflectance: Option<ColorSlot>,
    /// Factor on what is reflected.
    pub specular_reflectance: ColorSlot,
}

impl Conductor {
    pub(super) fn params(&self, at: &Site) -> ConductorParams {
        let (eta, k) = match &self.reflectance {
            Some(r) => (Spectrum::ONE, extinction(at.color(r))),
            None => (at.color(&self.eta), at.color(&self.k)),
        };
        ConductorParams { eta, k, specular_reflectance: at.color(&self.specular_reflectance) }
    }
}

/// k of a metal with η = 1 that reflects `r` at normal incidence: r = k²/(4 + k²).
fn extinction(r: Spectrum) -> Spectrum {
    let r = r.clamp(0.0, 0.9999);
    2.0 * (r / (Spectrum::ONE - r)).sqrt()
}

impl Single for Conductor {
    fn events(&self) -> Event {
        Event::REFLECT.with(Event::DELTA)
    }

    fn lobe(&self, at: &Site) -> Lobe<'_> {
        lobes::Conductor::new(self.params(at)).into()
    }
}

/// A rough metal.
#[derive(Clone, Debug)]
pub struct RoughConductor {
    /// The metal.
    pub metal: Conductor,
    /// Its microfacets.
    pub roughness: Roughness,
}

impl Single for RoughConductor {
    fn events(&self) -> Event {
        Event::REFLECT.with(Event::GLOSSY)
    }

    fn lobe(&self, at: &Site) -> Lobe<'_> {
        let r = &self.roughness;
        let [alpha_u, alpha_v] = r.at(at);
        let conductor = self.metal.params(at);
        let sample_visible = r.sample_visible;
        lobes::RoughConductor::new(RoughConductorParams { conductor, ndf: r.ndf, alpha_u, alpha_v, sample_visible }).into()
    }
}
