//! Small helpers that every lobe shares: cleaned parameters, the cosine hemisphere, assembled samples.

use crate::{BsdfSample, Event};
use etendue_numerics::{
    Pdf, Spectrum, Vec2, Vec3, Vec4,
    math::{FRAC_1_PI, ONE_MINUS_EPSILON},
    warp,
};

/// Whether the two directions lie strictly on the same side.
#[inline]
pub fn same_side(a: Vec3, b: Vec3) -> bool {
    a.z * b.z > 0.0
}

/// A parameter from outside: lanes that are NaN or negative give 0, and none exceeds a million.
#[inline]
pub fn clean(s: Spectrum) -> Spectrum {
    Spectrum(Vec4::select(s.0.cmpge(Vec4::ZERO), s.0, Vec4::ZERO).min(Vec4::splat(1e6)))
}

/// `x` within [low, high]; `otherwise` where it is NaN.
#[inline]
pub fn clean_f32(x: f32, low: f32, high: f32, otherwise: f32) -> f32 {
    if x.is_nan() { otherwise } else { x.clamp(low, high) }
}

/// A relative index of refraction from outside, in [0.01, 100]; NaN gives 1.
#[inline]
pub fn clean_eta(eta: f32) -> f32 {
    clean_f32(eta, 0.01, 100.0, 1.0)
}

/// The mean of the lanes in use (RGB mode leaves the fourth at zero).
#[inline]
pub fn mean(s: Spectrum) -> f32 {
    s.0.element_sum() * if s.0.w == 0.0 { 1.0 / 3.0 } else { 0.25 }
}

/// `u` in [from, from + width) stretched to [0, 1).
#[inline]
pub fn stretch(u: f32, from: f32, width: f32) -> f32 {
    ((u - from) / width).clamp(0.0, ONE_MINUS_EPSILON)
}

/// cosθ/π on the upper hemisphere.
#[inline]
pub fn cosine_pdf(w: Vec3) -> f32 {
    w.z.max(0.0) * FRAC_1_PI
}

/// A direction of the upper hemisphere with density cosθ/π; `None` exactly at the horizon.
#[inline]
pub fn cosine_sample(u: Vec2) -> Option<Vec3> {
    let w = warp::square_to_cosine_hemisphere(u);
    (w.z > 0.0).then_some(w)
}

/// A smooth sample of weight f |cosθ_i| / p; `None` where the density is not a positive number.
#[inline]
pub fn smooth(wi: Vec3, f: Spectrum, pdf: f32, eta: f32, event: Event) -> Option<BsdfSample> {
    weighted(wi, f * (wi.z.abs() / pdf), pdf, eta, event)
}

/// A smooth sample whose weight is known; `None` where the density is not a positive number.
#[inline]
pub fn weighted(wi: Vec3, weight: Spectrum, pdf: f32, eta: f32, event: Event) -> Option<BsdfSample> {
    (pdf > 0.0 && pdf.is_finite() && weight.is_finite()).then_some(BsdfSample { wi, weight, pdf: Pdf::SolidAngle(pdf), eta, event })
}

/// Hands over a Dirac direction and all that it carries, if that is anything.
#[inline]
pub fn whole_dirac(wi: Vec3, weight: Spectrum, eta: f32, event: Event, found: &mut dyn FnMut(BsdfSample)) {
    if !weight.is_zero() {
        dirac(wi, weight, 1.0, eta, event).into_iter().for_each(found);
    }
}

/// A Dirac sample chosen with probability `p`.
#[inline]
pub fn dirac(wi: Vec3, weight: Spectrum, p: f32, eta: f32, event: Event) -> Option<BsdfSample> {
    (p > 0.0).then_some(BsdfSample { wi, weight, pdf: Pdf::Delta(p), eta, event: event | Event::DELTA })
}
