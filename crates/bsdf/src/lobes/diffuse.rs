//! Lambert's surface: f = ρ/π on the upper side, p = cosθ_i/π [Lambert 1760].

use crate::{
    BsdfSample, Event, Scatter,
    local::{clean, cosine_pdf, cosine_sample, weighted},
};
use etendue_numerics::{Spectrum, Vec2, Vec3, math::FRAC_1_PI};

/// What a [`Diffuse`] lobe is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseParams {
    /// ρ in [0, 1]; default 0.5.
    pub reflectance: Spectrum,
}

impl Default for DiffuseParams {
    fn default() -> Self {
        Self { reflectance: Spectrum::splat(0.5) }
    }
}

/// Light leaves in all directions alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diffuse {
    reflectance: Spectrum,
}

impl Diffuse {
    /// The lobe of these parameters.
    #[inline]
    pub fn new(p: DiffuseParams) -> Self {
        Self { reflectance: clean(p.reflectance) }
    }
}

impl Scatter for Diffuse {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        if wo.z > 0.0 && wi.z > 0.0 { self.reflectance * FRAC_1_PI } else { Spectrum::ZERO }
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z > 0.0 { cosine_pdf(wi) } else { 0.0 }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3, _u1: f32, u2: Vec2) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let wi = cosine_sample(u2)?;
        weighted(wi, self.reflectance, cosine_pdf(wi), 1.0, Self::EVENT)
    }

    #[inline]
    fn events(&self) -> Event {
        Self::EVENT
    }

    fn albedo(&self, _wo: Vec3) -> Spectrum {
        self.reflectance
    }

    #[inline]
    fn diffuse_reflectance(&self) -> Spectrum {
        self.reflectance
    }

    fn roughness(&self) -> f32 {
        1.0
    }

    #[inline]
    fn importance(&self) -> f32 {
        self.reflectance.max_lane()
    }
}

impl Diffuse {
    const EVENT: Event = Event::REFLECT.with(Event::DIFFUSE);
}
