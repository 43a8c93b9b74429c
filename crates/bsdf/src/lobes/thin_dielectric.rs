//! A thin pane: two parallel dielectric interfaces seen as one, with all reflections between them.
//!
//! R' = R + T R T + T R³ T + … = 2R/(1 + R), T' = 1 - R' [Stokes 1862]; what is transmitted goes straight on, so it is a null event.

use super::DielectricParams;
use crate::{
    BsdfSample, Event, Scatter,
    fresnel::{self, reflect_z},
    local::{clean, clean_eta, dirac, whole_dirac},
};
use etendue_numerics::{Spectrum, Vec2, Vec3};

/// What a [`ThinDielectric`] is made of: as a solid's border, `eta` the index of the pane over that of its surroundings.
pub type ThinDielectricParams = DielectricParams;

/// A window pane modelled as one sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinDielectric {
    reflectance: Spectrum,
    transmittance: Spectrum,
    pane: f32,
}

impl ThinDielectric {
    /// The lobe of these parameters.
    pub fn new(p: ThinDielectricParams) -> Self {
        Self { reflectance: clean(p.specular_reflectance), transmittance: clean(p.specular_transmittance), pane: clean_eta(p.eta) }
    }

    /// R'.
    fn reflected(&self, wo: Vec3) -> f32 {
        let r = fresnel::dielectric(wo.z.abs(), self.pane).f;
        2.0 * r / (1.0 + r)
    }
}

impl Scatter for ThinDielectric {
    fn eval(&self, _wo: Vec3, _wi: Vec3) -> Spectrum {
        Spectrum::ZERO
    }

    fn pdf(&self, _wo: Vec3, _wi: Vec3) -> f32 {
        0.0
    }

    fn sample(&self, wo: Vec3, u1: f32, _u2: Vec2) -> Option<BsdfSample> {
        let r = self.reflected(wo);
        if u1 < r {
            dirac(reflect_z(wo), self.reflectance, r, 1.0, Event::REFLECT)
        } else {
            dirac(-wo, self.transmittance, 1.0 - r, 1.0, Event::NULL)
        }
    }

    fn diracs(&self, wo: Vec3, found: &mut dyn FnMut(BsdfSample)) {
        whole_dirac(reflect_z(wo), self.reflectance * self.reflected(wo), 1.0, Event::REFLECT, found);
        whole_dirac(-wo, self.transparency(wo), 1.0, Event::NULL, found);
    }

    fn events(&self) -> Event {
        Event::REFLECT | Event::NULL | Event::DELTA
    }

    fn albedo(&self, wo: Vec3) -> Spectrum {
        Spectrum::lerp(self.reflected(wo), self.transmittance, self.reflectance)
    }

    fn roughness(&self) -> f32 {
        0.0
    }

    fn transparency(&self, wo: Vec3) -> Spectrum {
        self.transmittance * (1.0 - self.reflected(wo))
    }

    fn importance(&self) -> f32 {
        self.reflectance.max_lane().max(self.transmittance.max_lane())
    }
}
