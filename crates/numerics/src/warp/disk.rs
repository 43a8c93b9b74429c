//! The unit disk by concentric squares [Shirley, Chiu 1997]: p = 1/π.

use super::unit;
use crate::Vec2;
use crate::math::{FRAC_1_PI, FRAC_PI_4, atan2, sin_cos_near};

/// The density of [`square_to_disk`], 1/π per unit of area.
#[inline]
pub fn disk_pdf() -> f32 {
    FRAC_1_PI
}

/// A uniform point of the unit disk: rings of the square [-1, 1]² become circles, r = max(|x|, |y|).
#[inline(always)]
pub fn square_to_disk(u: Vec2) -> Vec2 {
    let p = 2.0 * u - Vec2::ONE;
    // Within a quarter the polar angle is π/4 times the ratio of the smaller to the larger coordinate.
    let steep = p.y.abs() > p.x.abs();
    let (r, small) = if steep { (p.y, p.x) } else { (p.x, p.y) };
    let (sin, cos) = sin_cos_near(FRAC_PI_4 * (small / r));
    if r == 0.0 {
        Vec2::ZERO
    } else if steep {
        Vec2::new(r * sin, r * cos)
    } else {
        Vec2::new(r * cos, r * sin)
    }
}

/// The u that [`square_to_disk`] takes to `p`.
#[inline]
pub fn disk_to_square(p: Vec2) -> Vec2 {
    let steep = p.y.abs() > p.x.abs();
    let (large, small) = if steep { (p.y, p.x) } else { (p.x, p.y) };
    if large == 0.0 {
        return Vec2::splat(0.5);
    }
    let r = p.length().copysign(large);
    let other = r * atan2(small / large, 1.0) / FRAC_PI_4;
    let square = if steep { Vec2::new(other, r) } else { Vec2::new(r, other) };
    Vec2::new(unit(0.5 * (square.x + 1.0)), unit(0.5 * (square.y + 1.0)))
}
