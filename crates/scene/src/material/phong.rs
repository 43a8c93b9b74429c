//! `phong`: f = k_d/π + k_s (n + 2)/(2π) cosⁿα, étendue's own addition to Mitsuba's list.
//!
//! Parameters: `diffuse_reflectance` k_d (default 0.5), `specular_reflectance` k_s (default 0.2), `exponent` n (default 30). Where
//! k_d + k_s exceeds 1 both are scaled down.

use super::{Single, Site};
use crate::texture::{ColorSlot, ScalarSlot};
use etendue_bsdf::{
    Event, Lobe,
    lobes::{self, PhongParams},
};

/// A glossy surface by Phong.
#[derive(Clone, Debug)]
pub struct Phong {
    /// k_d.
    pub diffuse_reflectance: ColorSlot,
    /// k_s.
    pub specular_reflectance: ColorSlot,
    /// n.
    pub exponent: ScalarSlot,
}

impl Single for Phong {
    fn events(&self) -> Event {
        Event::REFLECT.with(Event::GLOSSY).with(Event::DIFFUSE)
    }

    fn lobe(&self, at: &Site) -> Lobe<'_> {
        lobes::Phong::new(PhongParams {
            diffuse_reflectance: at.color(&self.diffuse_reflectance),
            specular_reflectance: at.color(&self.specular_reflectance),
            exponent: at.scalar(&self.exponent),
        })
        .into()
    }
}
