//! Numbers of many directions side by side.

use etendue_numerics::Vec3;

/// Directions that are worked on together.
pub(super) const MANY: usize = 64;

/// A number of each.
pub(super) type Lane<T = f32> = [T; MANY];

/// A vector of each.
pub(super) type Lane3 = [Lane; 3];

#[inline(always)]
pub(super) fn get([x, y, z]: &Lane3, i: usize) -> Vec3 {
    Vec3::new(x[i], y[i], z[i])
}

#[inline(always)]
pub(super) fn set([x, y, z]: &mut Lane3, i: usize, v: Vec3) {
    (x[i], y[i], z[i]) = (v.x, v.y, v.z);
}
