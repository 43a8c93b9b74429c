//! `diffuse`: f = ρ/π on the front. Parameter `reflectance` ρ, default 0.5.

use super::{Single, Site};
use crate::texture::{ColorSlot, TextureContext};
use etendue_bsdf::{
    Event, Lobe, Scatter,
    lobes::{self, DiffuseParams},
};
use etendue_numerics::{Spectrum, Wavelengths};

/// Lambert's surface.
#[derive(Clone, Debug)]
pub struct Diffuse {
    /// ρ, in [0, 1].
    pub reflectance: ColorSlot,
}

impl Diffuse {
    /// ρ at a place, as the lobe has it.
    #[inline]
    pub(super) fn reflectance_at(&self, x: &TextureContext, wl: &Wavelengths) -> Spectrum {
        lobes::Diffuse::new(DiffuseParams { reflectance: self.reflectance.eval(x, wl) }).diffuse_reflectance()
    }
}

impl Single for Diffuse {
    #[inline]
    fn events(&self) -> Event {
        Event::REFLECT.with(Event::DIFFUSE)
    }

    #[inline]
    fn lobe(&self, at: &Site) -> Lobe {
        lobes::Diffuse::new(DiffuseParams { reflectance: at.color(&self.reflectance) }).into()
    }
}
