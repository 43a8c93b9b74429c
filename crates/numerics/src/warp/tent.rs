//! The tent 1 - |x| on [-1, 1].

use super::unit;
use crate::math::safe_sqrt;

/// The density of [`sample_tent`], 1 - |x|; zero outside [-1, 1].
#[inline]
pub fn tent_pdf(x: f32) -> f32 {
    (1.0 - x.abs()).max(0.0)
}

/// x in [-1, 1] with density 1 - |x|.
#[inline]
pub fn sample_tent(u: f32) -> f32 {
    if u < 0.5 { safe_sqrt(2.0 * u) - 1.0 } else { 1.0 - safe_sqrt(2.0 - 2.0 * u) }
}

/// The u that [`sample_tent`] takes to `x`.
#[inline]
pub fn invert_tent(x: f32) -> f32 {
    let h = 1.0 - x.abs();
    unit(if x < 0.0 { 0.5 * h * h } else { 1.0 - 0.5 * h * h })
}
