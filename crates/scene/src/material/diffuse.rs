//! `diffuse`: f = ρ/π on the front. Parameter `reflectance` ρ, default 0.5.

use super::{Single, Site};
use crate::texture::ColorSlot;
use etendue_bsdf::{
    Event, Lobe,
    lobes::{self, DiffuseParams},
};

/// Lambert's surface.
#[derive(Clone, Debug)]
pub struct Diffuse {
    /// ρ, in [0, 1].
    pub reflectance: ColorSlot,
}

impl Single for Diffuse {
    #[inline]
    fn events(&self) -> Event {
        Event::REFLECT.with(Event::DIFFUSE)
    }

    #[inline]
    fn lobe(&self, at: &Site) -> Lobe<'_> {
        lobes::Diffuse::new(DiffuseParams { reflectance: at.color(&self.reflectance) }).into()
    }
}
