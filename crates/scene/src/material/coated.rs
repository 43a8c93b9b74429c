//! `coateddiffuse`: Lambert's ground under a layer with a dielectric boundary.
//!
//! Parameters: `reflectance` of the ground (default 0.5); `int_ior` (default 1.5) and `ext_ior` of the layer; `alpha_u`, `alpha_v` of its
//! boundary (default 0; below 0.001 it is smooth); `thickness` (default 0.01): light is weakened by e^(-thickness/cosθ) on each way through; `max_depth`
//! (default 10): how often light meets ground and boundary at the most; `albedo` (default 0) and `g` (default 0) of particles in the layer, `samples`
//! (default 1), `remap_roughness`. All but the indices and both numbers may be textured. A clear layer, even all over, is summed exactly; else walks estimate what it does.
//!
//! `coatedconductor`: a metal under such a layer, whose index it is seen from. The metal as of `conductor`, with `base_alpha_u`, `base_alpha_v`, `base_remap_roughness`.

use super::{Conductor, Single, Site};
use crate::texture::{ColorSlot, ScalarSlot};
use etendue_bsdf::{
    Event, Lobe,
    lobes::{self, CoatedDiffuseParams, Ground, LayeredParams},
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

    fn lobe(&self, at: &Site) -> Lobe<'_> {
        let reflectance: Spectrum = at.color(&self.reflectance);
        lobes::CoatedDiffuse::new(CoatedDiffuseParams { reflectance, ..self.params }, &self.coat).into()
    }
}

/// α of two directions, as files write it.
#[derive(Clone, Debug)]
pub struct LayerRoughness {
    /// Along s and t.
    pub alpha: [ScalarSlot; 2],
    /// α is the square root of it.
    pub remap: bool,
}

impl LayerRoughness {
    /// α at a site; none where the surface is smooth.
    fn at(&self, at: &Site) -> Option<[f32; 2]> {
        let alpha = self.alpha.each_ref().map(|a| at.scalar(a).max(0.0));
        let alpha = if self.remap { alpha.map(f32::sqrt) } else { alpha };
        (alpha[0].max(alpha[1]) >= 1e-3).then(|| alpha.map(|a| a.max(1e-4)))
    }

    /// Whether it may be smooth anywhere.
    fn may_be_smooth(&self) -> bool {
        match self.alpha {
            [ScalarSlot::Constant(u), ScalarSlot::Constant(v)] => u.max(v) < if self.remap { 1e-6 } else { 1e-3 },
            _ => true,
        }
    }
}

/// What lies under a layer.
#[derive(Clone, Debug)]
pub enum LayerGround {
    /// Lambert's ground.
    Diffuse(ColorSlot),
    /// A metal.
    Metal(Box<Conductor>, LayerRoughness),
}

/// Any ground under any layer, by walks.
#[derive(Clone, Debug)]
pub struct Layered {
    /// The ground.
    pub ground: LayerGround,
    /// The boundary.
    pub boundary: LayerRoughness,
    /// Optical thickness of the layer.
    pub thickness: ScalarSlot,
    /// Of the particles in the layer.
    pub albedo: ColorSlot,
    /// Of them as well, Henyey and Greenstein's.
    pub g: ScalarSlot,
    /// Everything that is the same all over; nothing else of it is looked at.
    pub params: LayeredParams,
}

impl Single for Layered {
    fn events(&self) -> Event {
        let mut events = Event::REFLECT.with(Event::DIFFUSE).with(Event::GLOSSY);
        if self.boundary.may_be_smooth() {
            events |= Event::DELTA;
        }
        events
    }

    fn lobe(&self, at: &Site) -> Lobe<'_> {
        let ground = match &self.ground {
            LayerGround::Diffuse(rho) => Ground::Diffuse(at.color(rho)),
            LayerGround::Metal(metal, roughness) => {
                // Its index over the layer's.
                let p = metal.params(at);
                let per_layer = 1.0 / self.params.eta;
                Ground::Metal(p.eta * per_layer, p.k * per_layer, roughness.at(at))
            }
        };
        let (thickness, albedo, g) = (at.scalar(&self.thickness), at.color(&self.albedo), at.scalar(&self.g));
        lobes::Layered::new(LayeredParams { ground, alpha: self.boundary.at(at), thickness, albedo, g, ..self.params }).into()
    }
}
