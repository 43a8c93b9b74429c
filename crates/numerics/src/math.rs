//! Small real functions that everything shares. Transcendentals on the way of a pixel come from here ([`crate::elementary`]), so that every
//! path through the program, and every machine, computes the same bits.

pub use crate::elementary::{atan2, exp, ln, powf, safe_acos, safe_asin, sin_cos, sin_cos_near};

pub use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// The largest f32 below 1: what a uniform number may reach.
pub const ONE_MINUS_EPSILON: f32 = 1.0 - f32::EPSILON / 2.0;

/// x².
#[inline]
pub fn sqr(x: f32) -> f32 {
    x * x
}

/// √max(x, 0): rounding may have carried x below zero.
#[inline]
pub fn safe_sqrt(x: f32) -> f32 {
    x.max(0.0).sqrt()
}

/// (1 - t) a + t b.
#[inline]
pub fn lerp(t: f32, a: f32, b: f32) -> f32 {
    (1.0 - t) * a + t * b
}

/// The bound γ(n) = nε / (1 - nε) on the relative error of n roundings, ε half an ulp [Higham 2002, §3.1].
#[inline]
pub const fn gamma(n: i32) -> f32 {
    let e = n as f32 * (f32::EPSILON * 0.5);
    e / (1.0 - e)
}
