//! `principled`, `principledthin`: artist's parameters [Burley 2012, 2015].
//!
//! Both: `base_color` (default 0.5), `roughness` (0.5), `anisotropic`, `spec_trans`, `spec_tint`, `sheen`, `sheen_tint`, `flatness` (0),
//! each in [0, 1] and texturable. Solids: `metallic`, `clearcoat`, `clearcoat_gloss` (0), and `eta` or `specular` (0.5). Sheets: `eta` (1.5)
//! and `diff_trans` in [0, 2] (0). Numbers `…_sampling_rate` (1) say how often each part is drawn.

use super::{Single, Site};
use crate::texture::{ColorSlot, ScalarSlot};
use etendue_bsdf::{
    Event, Lobe,
    lobes::{self, PrincipledParams, PrincipledThinParams},
};
use etendue_numerics::Wavelengths;

/// What solids and sheets have in common.
#[derive(Clone, Debug)]
pub struct PrincipledCommon {
    /// The colour.
    pub base_color: ColorSlot,
    /// √α of the specular lobes.
    pub roughness: ScalarSlot,
    /// Stretch of highlights.
    pub anisotropic: ScalarSlot,
    /// Share that goes through specularly.
    pub spec_trans: ScalarSlot,
    /// Tint of the reflection.
    pub spec_tint: ScalarSlot,
    /// Grazing sheen.
    pub sheen: ScalarSlot,
    /// Its tint.
    pub sheen_tint: ScalarSlot,
    /// From diffuse to fake subsurface.
    pub flatness: ScalarSlot,
    /// Interior over exterior index.
    pub eta: f32,
}

/// A solid.
#[derive(Clone, Debug)]
pub struct Principled {
    /// What sheets have too.
    pub common: PrincipledCommon,
    /// 0 dielectric, 1 metal.
    pub metallic: ScalarSlot,
    /// A coat on top.
    pub clearcoat: ScalarSlot,
    /// Its gloss.
    pub clearcoat_gloss: ScalarSlot,
    /// How often the diffuse, the main specular and the coat's part are drawn.
    pub rates: [f32; 3],
}

/// Whether a parameter is 0 everywhere.
fn vanishes(slot: &ScalarSlot) -> bool {
    matches!(slot, ScalarSlot::Constant(v) if *v <= 0.0)
}

impl Single for Principled {
    fn events(&self) -> Event {
        let reflects = Event::REFLECT.with(Event::GLOSSY).with(Event::DIFFUSE);
        if vanishes(&self.common.spec_trans) { reflects } else { reflects.with(Event::TRANSMIT) }
    }

    fn lobe(&self, at: &Site) -> Lobe<'_> {
        let c = &self.common;
        lobes::Principled::new(PrincipledParams {
            base_color: at.color(&c.base_color),
            luminance: c.luminance(at),
            roughness: at.scalar(&c.roughness),
            anisotropic: at.scalar(&c.anisotropic),
            metallic: at.scalar(&self.metallic),
            spec_trans: at.scalar(&c.spec_trans),
            eta: c.eta,
            spec_tint: at.scalar(&c.spec_tint),
            sheen: at.scalar(&c.sheen),
            sheen_tint: at.scalar(&c.sheen_tint),
            flatness: at.scalar(&c.flatness),
            clearcoat: at.scalar(&self.clearcoat),
            clearcoat_gloss: at.scalar(&self.clearcoat_gloss),
            diffuse_reflectance_sampling_rate: self.rates[0],
            main_specular_sampling_rate: self.rates[1],
            clearcoat_sampling_rate: self.rates[2],
        })
        .into()
    }
}

impl PrincipledCommon {
    /// Luminance of the base colour, where a walk's lanes do not tell.
    fn luminance(&self, at: &Site) -> Option<f32> {
        (!at.wl.is_rgb()).then(|| self.base_color.eval(&at.textures, &Wavelengths::Rgb).luminance())
    }
}

/// A sheet.
#[derive(Clone, Debug)]
pub struct PrincipledThin {
    /// What solids have too.
    pub common: PrincipledCommon,
    /// How much of the diffuse light goes through: 0 none, 2 all.
    pub diff_trans: ScalarSlot,
    /// How often diffuse reflection, specular reflection, specular and diffuse transmission are drawn.
    pub rates: [f32; 4],
}

impl Single for PrincipledThin {
    fn events(&self) -> Event {
        let reflects = Event::REFLECT.with(Event::GLOSSY).with(Event::DIFFUSE);
        let opaque = vanishes(&self.common.spec_trans) && vanishes(&self.diff_trans);
        if opaque { reflects } else { reflects.with(Event::TRANSMIT) }
    }

    fn lobe(&self, at: &Site) -> Lobe<'_> {
        let c = &self.common;
        lobes::PrincipledThin::new(PrincipledThinParams {
            base_color: at.color(&c.base_color),
            luminance: c.luminance(at),
            roughness: at.scalar(&c.roughness),
            anisotropic: at.scalar(&c.anisotropic),
            spec_trans: at.scalar(&c.spec_trans),
            eta: c.eta,
            spec_tint: at.scalar(&c.spec_tint),
            sheen: at.scalar(&c.sheen),
            sheen_tint: at.scalar(&c.sheen_tint),
            flatness: at.scalar(&c.flatness),
            diff_trans: at.scalar(&self.diff_trans),
            diffuse_reflectance_sampling_rate: self.rates[0],
            specular_reflectance_sampling_rate: self.rates[1],
            specular_transmittance_sampling_rate: self.rates[2],
            diffuse_transmittance_sampling_rate: self.rates[3],
        })
        .into()
    }
}
