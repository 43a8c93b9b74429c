//! A smooth interface between two dielectrics: F of the light is mirrored, 1 - F refracted by Snell's law, both Dirac.
//!
//! One of the two is chosen with its own probability, so that weights are the bare `specular_*` factors.

use crate::{
    BsdfSample, Event, Scatter,
    fresnel::{self, reflect_z},
    local::{clean, clean_eta, dirac, whole_dirac},
};
use etendue_numerics::{Spectrum, Vec2, Vec3};

/// What a [`Dielectric`] or [`crate::lobes::RoughDielectric`] interface is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DielectricParams {
    /// η = interior/exterior index of refraction, > 0; the normal points to the exterior; default BK7 in air.
    pub eta: f32,
    /// Whether η is that of one wavelength and others have another; default false.
    pub disperses: bool,
    /// A factor on what is reflected, in [0, 1]; 1 is physical and the default.
    pub specular_reflectance: Spectrum,
    /// A factor on what is transmitted, in [0, 1]; 1 is physical and the default.
    pub specular_transmittance: Spectrum,
}

impl Default for DielectricParams {
    fn default() -> Self {
        Self {
            eta: super::BK7 / super::AIR,
            disperses: false,
            specular_reflectance: Spectrum::ONE,
            specular_transmittance: Spectrum::ONE,
        }
    }
}

/// Polished glass, water: the border of a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    reflectance: Spectrum,
    transmittance: Spectrum,
    eta: f32,
    disperses: bool,
}

impl Dielectric {
    /// The lobe of these parameters.
    pub fn new(p: DielectricParams) -> Self {
        Self {
            reflectance: clean(p.specular_reflectance),
            transmittance: clean(p.specular_transmittance),
            eta: clean_eta(p.eta),
            disperses: p.disperses,
        }
    }
}

impl Scatter for Dielectric {
    fn eval(&self, _wo: Vec3, _wi: Vec3) -> Spectrum {
        Spectrum::ZERO
    }

    fn pdf(&self, _wo: Vec3, _wi: Vec3) -> f32 {
        0.0
    }

    fn sample(&self, wo: Vec3, u1: f32, _u2: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let x = fresnel::dielectric(wo.z, self.eta);
        if u1 < x.f {
            dirac(reflect_z(wo), self.reflectance, x.f, 1.0, Event::REFLECT)
        } else {
            let wi = Vec3::new(-x.eta_ti * wo.x, -x.eta_ti * wo.y, x.cos_t);
            dirac(wi, self.transmittance, 1.0 - x.f, x.eta_it, Event::TRANSMIT)
        }
    }

    fn diracs(&self, wo: Vec3, found: &mut dyn FnMut(BsdfSample)) {
        if wo.z == 0.0 {
            return;
        }
        let x = fresnel::dielectric(wo.z, self.eta);
        whole_dirac(reflect_z(wo), self.reflectance * x.f, 1.0, Event::REFLECT, found);
        let wi = Vec3::new(-x.eta_ti * wo.x, -x.eta_ti * wo.y, x.cos_t);
        whole_dirac(wi, self.transmittance * (1.0 - x.f), x.eta_it, Event::TRANSMIT, found);
    }

    fn events(&self) -> Event {
        let all = Event::REFLECT | Event::TRANSMIT | Event::DELTA;
        if self.disperses { all | Event::DISPERSES } else { all }
    }

    fn albedo(&self, wo: Vec3) -> Spectrum {
        Spectrum::lerp(fresnel::dielectric(wo.z, self.eta).f, self.transmittance, self.reflectance)
    }

    fn roughness(&self) -> f32 {
        0.0
    }

    fn eta(&self) -> f32 {
        self.eta
    }

    fn importance(&self) -> f32 {
        self.reflectance.max_lane().max(self.transmittance.max_lane())
    }
}
