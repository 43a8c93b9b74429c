//! `coateddiffuse`: Lambert's ground under a layer with a dielectric boundary.
//!
//! Parameters: `reflectance` of the ground (default 0.5); `int_ior` (default 1.5) and `ext_ior` of the layer; `alpha_u`, `alpha_v` of its
//! boundary (default 0; below 0.001 it is smooth); `thickness` (default 0.01): light is weakened by e^(-thickness/cosθ) on each way through; `max_depth`
//! (default 10): how often light meets ground and boundary at the most.

use super::{Single, Site};
use crate::texture::ColorSlot;
use etendue_bsdf::{
    Event, Lobe,
    lobes::{self, CoatedDiffuseParams},
    microfacet::transmittance::RoughTransmittance,
};
use etendue_numerics::Spectrum;

/// A varnished ground.
#[derive(Clone, Debug)]
pub struct CoatedDiffuse {
    reflectance: ColorSlot,
    params: CoatedDiffuseParams,
    coat: RoughTransmittance,
}

impl CoatedDiffuse {
    /// Takes some milliseconds: how much the layer lets through is integrated here. `params.reflectance` is not looked at.
    pub fn new(reflectance: ColorSlot, params: CoatedDiffuseParams) -> Self {
        Self { reflectance, params, coat: params.coat() }
    }
}

impl Single for CoatedDiffuse {
    fn events(&self) -> Event {
        let boundary = if self.params.alpha.is_some() { Event::GLOSSY } else { Event::DELTA };
        Event::REFLECT.with(Event::DIFFUSE).with(boundary)
    }

    fn lobe(&self, at: &Site) -> Lobe {
        let reflectance: Spectrum = at.color(&self.reflectance);
        lobes::CoatedDiffuse::new(CoatedDiffuseParams { reflectance, ..self.params }, &self.coat).into()
    }
}
