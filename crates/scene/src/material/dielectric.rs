//! `dielectric`, `thindielectric`, `roughdielectric`: interfaces that reflect and refract.
//!
//! Parameters: `int_ior` (default `bk7`), `ext_ior` (default `air`), each a name, a number above 0 or a spectrum; glasses named `glass-…` and spectra
//! disperse walks that carry wavelengths, but not in a pane; `specular_reflectance` and
//! `specular_transmittance` (default 1, the physical value); the rough one also those of [`Roughness`].

use super::{Roughness, Single, Site};
use crate::texture::ColorSlot;
use etendue_bsdf::{
    Event, Lobe,
    lobes::{self, DielectricParams, RoughDielectricParams},
};
use etendue_numerics::Wavelengths;
use etendue_numerics::spectrum::Curve;

const BOTH: Event = Event::REFLECT.with(Event::TRANSMIT);

/// A smooth interface.
#[derive(Clone, Debug)]
pub struct Dielectric {
    /// η, interior over exterior; of glass that disperses at 588 nm.
    pub eta: f32,
    /// η at each wavelength, where it is not the same.
    pub dispersion: Option<Curve>,
    /// Factor on what is reflected.
    pub specular_reflectance: ColorSlot,
    /// Factor on what is transmitted.
    pub specular_transmittance: ColorSlot,
}

impl Dielectric {
    fn params(&self, at: &Site) -> DielectricParams {
        let (eta, disperses) = match (&self.dispersion, at.wl) {
            (Some(curve), Wavelengths::Hero(hero)) => (curve.at(hero)[0], true),
            _ => (self.eta, false),
        };
        DielectricParams {
            eta,
            disperses,
            specular_reflectance: at.color(&self.specular_reflectance),
            specular_transmittance: at.color(&self.specular_transmittance),
        }
    }
}

impl Single for Dielectric {
    fn events(&self) -> Event {
        BOTH.with(Event::DELTA)
    }

    fn lobe(&self, at: &Site) -> Lobe<'_> {
        lobes::Dielectric::new(self.params(at)).into()
    }
}

/// Two smooth interfaces with nothing between: a pane.
#[derive(Clone, Debug)]
pub struct ThinDielectric(pub Dielectric);

impl Single for ThinDielectric {
    fn events(&self) -> Event {
        Event::REFLECT.with(Event::NULL).with(Event::DELTA)
    }

    fn lobe(&self, at: &Site) -> Lobe<'_> {
        lobes::ThinDielectric::new(self.0.params(at)).into()
    }
}

/// A rough interface.
#[derive(Clone, Debug)]
pub struct RoughDielectric {
    /// The interface.
    pub interface: Dielectric,
    /// Its microfacets.
    pub roughness: Roughness,
}

impl Single for RoughDielectric {
    fn events(&self) -> Event {
        BOTH.with(Event::GLOSSY)
    }

    fn lobe(&self, at: &Site) -> Lobe<'_> {
        let r = &self.roughness;
        let [alpha_u, alpha_v] = r.at(at);
        let dielectric = self.interface.params(at);
        let sample_visible = r.sample_visible;
        lobes::RoughDielectric::new(RoughDielectricParams { dielectric, ndf: r.ndf, alpha_u, alpha_v, sample_visible }).into()
    }
}
