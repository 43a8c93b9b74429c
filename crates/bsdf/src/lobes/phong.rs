//! The modified Phong model in its reciprocal, normalised form [Lafortune and Willems 1994].
//!
//! f = k_d/π + k_s (n + 2)/(2π) cosⁿα, α the angle between `wi` and the mirror image of `wo`, on the upper side, cosα ≥ 0.
//! With k_d + k_s ≤ 1 no more light leaves than arrives (eq. 7). Sampled by parts: cosθ/π, or (n + 1)/(2π) cosⁿα around the mirror
//! direction, whose part below the horizon is absorbed.

use crate::{
    BsdfSample, Event, Scatter,
    fresnel::reflect_z,
    local::{clean, clean_f32, cosine_pdf, cosine_sample, mean, smooth},
};
use etendue_numerics::{
    Frame, Spectrum, Vec2, Vec3,
    math::{FRAC_1_PI, TAU, powf, safe_sqrt, sin_cos},
};

/// What a [`Phong`] lobe is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongParams {
    /// k_d in [0, 1]; default 0.5.
    pub diffuse_reflectance: Spectrum,
    /// k_s in [0, 1]; default 0.2. Lanes where k_d + k_s exceeds 1 are scaled down to 1.
    pub specular_reflectance: Spectrum,
    /// n in [0, 1e6]; default 30.
    pub exponent: f32,
}

impl Default for PhongParams {
    fn default() -> Self {
        Self { diffuse_reflectance: Spectrum::splat(0.5), specular_reflectance: Spectrum::splat(0.2), exponent: 30.0 }
    }
}

/// The lecture's glossy surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    diffuse: Spectrum,
    specular: Spectrum,
    exponent: f32,
    specular_probability: f32,
}

impl Phong {
    /// The lobe of these parameters.
    pub fn new(p: PhongParams) -> Self {
        let (d, s) = (clean(p.diffuse_reflectance), clean(p.specular_reflectance));
        let total = (d + s).max(1.0);
        let (d, s) = (d / total, s / total);
        let (md, ms) = (mean(d), mean(s));
        let specular_probability = if md + ms > 0.0 { ms / (md + ms) } else { 0.0 };
        Self { diffuse: d, specular: s, exponent: clean_f32(p.exponent, 0.0, 1e6, 30.0), specular_probability }
    }

    /// cosⁿα, zero beyond a right angle.
    #[inline]
    fn lobe(&self, wo: Vec3, wi: Vec3) -> f32 {
        let cos = reflect_z(wo).dot(wi);
        if cos > 0.0 { powf(cos.min(1.0), self.exponent) } else { 0.0 }
    }
}

impl Scatter for Phong {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Spectrum::ZERO;
        }
        self.diffuse * FRAC_1_PI + self.specular * ((self.exponent + 2.0) / TAU * self.lobe(wo, wi))
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        let p = self.specular_probability;
        (1.0 - p) * cosine_pdf(wi) + p * (self.exponent + 1.0) / TAU * self.lobe(wo, wi)
    }

    fn sample(&self, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let (wi, event) = if u1 < self.specular_probability {
            let cos = powf(1.0 - u2.x, 1.0 / (self.exponent + 1.0));
            let sin = safe_sqrt(1.0 - cos * cos);
            let (sin_phi, cos_phi) = sin_cos(TAU * u2.y);
            let around = Vec3::new(sin * cos_phi, sin * sin_phi, cos);
            (Frame::from_normal(reflect_z(wo)).to_world(around), Event::GLOSSY)
        } else {
            (cosine_sample(u2)?, Event::DIFFUSE)
        };
        smooth(wi, self.eval(wo, wi), self.pdf(wo, wi), 1.0, Event::REFLECT | event)
    }

    fn events(&self) -> Event {
        Event::REFLECT | Event::GLOSSY | Event::DIFFUSE
    }

    fn albedo(&self, _wo: Vec3) -> Spectrum {
        self.diffuse + self.specular
    }

    fn diffuse_reflectance(&self) -> Spectrum {
        self.diffuse
    }

    /// The Beckmann roughness of the same width, α = √(2/(n + 2)) [Walter et al. 2007, §5.2].
    fn roughness(&self) -> f32 {
        (2.0 / (self.exponent + 2.0)).sqrt()
    }

    fn importance(&self) -> f32 {
        (self.diffuse + self.specular).max_lane()
    }
}
