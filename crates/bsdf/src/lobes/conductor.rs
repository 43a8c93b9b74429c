//! Polished metal: F(cosθ; η + ik) of the light is mirrored, Dirac; the rest is absorbed.

use crate::{
    BsdfSample, Event, Scatter,
    fresnel::{self, reflect_z},
    local::{clean, dirac, whole_dirac},
};
use etendue_numerics::{Spectrum, Vec2, Vec3};

/// What a [`Conductor`] is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConductorParams {
    /// η, the real part of the index over that of the exterior; default 0.
    pub eta: Spectrum,
    /// k, the imaginary part over the index of the exterior; default 1 (with η = 0 all light is reflected).
    pub k: Spectrum,
    /// A factor on what is reflected, in [0, 1]; 1 is physical and the default.
    pub specular_reflectance: Spectrum,
}

impl Default for ConductorParams {
    fn default() -> Self {
        Self { eta: Spectrum::ZERO, k: Spectrum::ONE, specular_reflectance: Spectrum::ONE }
    }
}

/// A metal mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    eta: Spectrum,
    k: Spectrum,
    reflectance: Spectrum,
}

impl Conductor {
    /// The lobe of these parameters.
    pub fn new(p: ConductorParams) -> Self {
        Self { eta: clean(p.eta), k: clean(p.k), reflectance: clean(p.specular_reflectance) }
    }

    /// The factor times F at cosine `cos` to the (micro)facet.
    #[inline]
    pub(super) fn reflected(&self, cos: f32) -> Spectrum {
        self.reflectance * fresnel::conductor(cos, self.eta, self.k)
    }

    /// The largest lane of the factor on what is reflected.
    #[inline]
    pub(super) fn largest(&self) -> f32 {
        self.reflectance.max_lane()
    }
}

impl Scatter for Conductor {
    fn eval(&self, _wo: Vec3, _wi: Vec3) -> Spectrum {
        Spectrum::ZERO
    }

    fn pdf(&self, _wo: Vec3, _wi: Vec3) -> f32 {
        0.0
    }

    fn sample(&self, wo: Vec3, _u1: f32, _u2: Vec2) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        dirac(reflect_z(wo), self.reflected(wo.z), 1.0, 1.0, Event::REFLECT)
    }

    fn diracs(&self, wo: Vec3, found: &mut dyn FnMut(BsdfSample)) {
        if wo.z > 0.0 {
            whole_dirac(reflect_z(wo), self.reflected(wo.z), 1.0, Event::REFLECT, found);
        }
    }

    fn events(&self) -> Event {
        Event::REFLECT | Event::DELTA
    }

    fn albedo(&self, wo: Vec3) -> Spectrum {
        self.reflected(wo.z.clamp(0.0, 1.0))
    }

    fn roughness(&self) -> f32 {
        0.0
    }

    fn importance(&self) -> f32 {
        self.largest()
    }
}
