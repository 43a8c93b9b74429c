//! `hair`: fibres, of whatever shape is at hand [Chiang et al. 2016].
//!
//! Parameters: the pigment as one of `sigma_a` (absorption per radius), `reflectance` (the colour of much of such hair), or the concentrations
//! `eumelanin` (default 1.3 where nothing is said) and `pheomelanin`; `beta_m` and `beta_n` (roughness along and around the fibre, default 0.3), `alpha`
//! (tilt of the scales, degrees, default 2), `int_ior` (default 1.55) and `ext_ior`.
//!
//! A fibre is a tube with u along it: its wall scatters what comes from outside, all the ways through the fibre being done at once, and is not there from
//! within. So light passes one way only, and only walks from the eye may meet it.

use super::{Model, Site};
use crate::texture::{ColorSlot, Role, ScalarSlot};
use etendue_bsdf::{
    Bsdf, Event,
    lobes::{self, HairParams},
};
use etendue_numerics::spectrum::pigment::{EUMELANIN, PHEOMELANIN, absorption_of};
use etendue_numerics::{Spectrum, Wavelengths};

/// What darkens the fibre.
#[derive(Clone, Debug)]
pub enum Pigment {
    /// σ.
    Absorption(ColorSlot),
    /// The colour of much of such hair.
    Reflectance(ColorSlot),
    /// Concentrations of eumelanin, which is brown, and pheomelanin, which is red.
    Melanin([ScalarSlot; 2]),
}

/// Fibres.
#[derive(Clone, Debug)]
pub struct Hair {
    /// The pigment.
    pub pigment: Pigment,
    /// Roughness along and around.
    pub beta: [ScalarSlot; 2],
    /// Tilt of the scales, degrees.
    pub alpha: ScalarSlot,
    /// η.
    pub eta: f32,
}

impl Model for Hair {
    fn events(&self) -> Event {
        Event::REFLECT.with(Event::TRANSMIT).with(Event::GLOSSY).with(Event::NULL).with(Event::DELTA)
    }

    fn lobes(&self) -> usize {
        1
    }

    fn add<'s>(&'s self, at: &Site<'s, '_>, weight: f32, to: &mut Bsdf<'s>) {
        if at.wo.z <= 0.0 {
            to.push(weight, lobes::Null);
            return;
        }
        let [beta_m, beta_n] = [0, 1].map(|i| at.scalar(&self.beta[i]));
        let sigma_a = match &self.pigment {
            Pigment::Absorption(sigma) => at.color(sigma),
            Pigment::Reflectance(colour) => absorption_of(at.color(colour), beta_n),
            Pigment::Melanin([eu, pheo]) => {
                let rgb = EUMELANIN * at.scalar(eu).max(0.0) + PHEOMELANIN * at.scalar(pheo).max(0.0);
                Role::Unbounded.spectrum(rgb, at.wl)
            }
        };
        let lanes = match at.wl {
            Wavelengths::Rgb => Spectrum::rgb(1.0, 1.0, 1.0),
            Wavelengths::Hero(_) => Spectrum::ONE,
        };
        to.push(
            weight,
            lobes::Hair::new(HairParams { sigma_a, lanes, eta: self.eta, beta_m, beta_n, alpha: at.scalar(&self.alpha) }),
        );
    }
}
