//! `plastic`, `roughplastic`: a varnish over a diffuse base.
//!
//! Parameters: `int_ior` (default `polypropylene`), `ext_ior` (default `air`), `diffuse_reflectance` (default 0.5),
//! `specular_reflectance` (default 1), `nonlinear` (default false); the rough one also `distribution` (default `beckmann`), `alpha` (a
//! number, default 0.1) and `sample_visible`.

use super::{Single, Site};
use crate::texture::ColorSlot;
use etendue_bsdf::{
    Event, Lobe, Ndf,
    lobes::{self, PlasticParams, RoughPlasticParams},
    microfacet::transmittance::RoughTransmittance,
};

/// Smooth plastic.
#[derive(Clone, Debug)]
pub struct Plastic {
    /// ρ of the base.
    pub diffuse_reflectance: ColorSlot,
    /// Factor on what the varnish mirrors.
    pub specular_reflectance: ColorSlot,
    /// η of the varnish, interior over exterior.
    pub eta: f32,
    /// Whether inner bounces deepen the base's colour.
    pub nonlinear: bool,
}

impl Plastic {
    fn params(&self, at: &Site) -> PlasticParams {
        PlasticParams {
            diffuse_reflectance: at.color(&self.diffuse_reflectance),
            specular_reflectance: at.color(&self.specular_reflectance),
            eta: self.eta,
            nonlinear: self.nonlinear,
        }
    }
}

impl Single for Plastic {
    fn events(&self) -> Event {
        Event::REFLECT.with(Event::DELTA).with(Event::DIFFUSE)
    }

    fn lobe(&self, at: &Site) -> Lobe<'_> {
        lobes::Plastic::new(self.params(at)).into()
    }
}

/// Rough plastic.
#[derive(Clone, Debug)]
pub struct RoughPlastic {
    plastic: Plastic,
    ndf: Ndf,
    alpha: f32,
    sample_visible: bool,
    /// Transmittance of the varnish, made once.
    boundary: RoughTransmittance,
}

impl RoughPlastic {
    /// Takes some milliseconds: how much the varnish lets through is integrated here.
    pub fn new(plastic: Plastic, ndf: Ndf, alpha: f32, sample_visible: bool) -> Self {
        let boundary = RoughTransmittance::new(ndf, alpha, plastic.eta);
        Self { plastic, ndf, alpha, sample_visible, boundary }
    }
}

impl Single for RoughPlastic {
    fn events(&self) -> Event {
        Event::REFLECT.with(Event::GLOSSY).with(Event::DIFFUSE)
    }

    fn lobe(&self, at: &Site) -> Lobe<'_> {
        let &Self { ndf, alpha, sample_visible, .. } = self;
        let plastic = self.plastic.params(at);
        lobes::RoughPlastic::new(RoughPlasticParams { plastic, ndf, alpha, sample_visible }, &self.boundary).into()
    }
}
