//! What is computed once for a ray.

use etendue_numerics::Ray;
use glam::Vec3;

/// Numbers up to this size are squared in f32 without a thought; larger ones take the careful path.
pub(crate) const ORDINARY: f32 = 1e18;

/// The relative error that boxes must forgive, in each of entry and exit: three roundings of their own (difference, reciprocal, product),
/// four of the triangle test (two differences, the shear and its product) and one for the slack itself.
pub(super) const SLACK: f32 = 8.0 * (f32::EPSILON / 2.0);

/// Whether the numbers of the ray are ordinary: no overflow can happen in f32.
#[inline(always)]
pub(super) fn is_ordinary(ray: &Ray) -> bool {
    // Sizes as integers compare like the numbers, and a NaN is larger than all: no branches.
    let size = |x: f32| x.to_bits() & !(1 << 31);
    let largest = |v: Vec3| size(v.x).max(size(v.y)).max(size(v.z));
    let (o, d) = (largest(ray.o), largest(ray.d));
    (o.max(d) <= ORDINARY.to_bits()) & (d >= (1.0 / ORDINARY).to_bits())
}

/// Whether the ray is one at all: finite, and it goes somewhere.
#[cold]
pub(super) fn is_sound(ray: &Ray) -> bool {
    ray.o.is_finite() && ray.d.is_finite() && ray.d != Vec3::ZERO
}

/// The axis of the component of greatest size.
#[inline(always)]
pub(super) fn largest_axis(d: [f32; 3]) -> usize {
    let size = [d[0].abs(), d[1].abs(), d[2].abs()];
    if size[0] > size[1] {
        if size[0] > size[2] { 0 } else { 2 }
    } else if size[1] > size[2] {
        1
    } else {
        2
    }
}

/// A prepared ray, in scalars.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setup {
    pub o: [f32; 3],
    /// 1 / d, a little smaller in size: entries are not late.
    pub near: [f32; 3],
    /// 1 / d, a little larger in size: exits are not early.
    pub far: [f32; 3],
    /// The row of a node's entry plane for each axis; the exit plane is the row's neighbour, row ^ 1.
    pub rows: [usize; 3],
    /// The axis of the largest component of d last, the other two before it.
    pub axes: [usize; 3],
    /// d[axes] / d[axes[2]] for the first two, and 1 / d[axes[2]].
    pub shear: [f32; 3],
}

impl Setup {
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let (o, d) = (ray.o.to_array(), ray.d.to_array());
        // Along an axis where d is 0 this is ±∞: planes are met at ±∞, and one that holds the origin at 0 · ∞, which is no number. The
        // kernels' minima and maxima pass over that (or drop a neighbour with it): who runs along a box's side meets the box.
        let inverse = [1.0 / d[0], 1.0 / d[1], 1.0 / d[2]];
        let z = largest_axis(d);
        let (x, y) = ([1, 2, 0][z], [2, 0, 1][z]);
        let row = |a: usize| 2 * a + usize::from(inverse[a] < 0.0);
        Self {
            o,
            near: [inverse[0] * (1.0 - SLACK), inverse[1] * (1.0 - SLACK), inverse[2] * (1.0 - SLACK)],
            far: [inverse[0] * (1.0 + SLACK), inverse[1] * (1.0 + SLACK), inverse[2] * (1.0 + SLACK)],
            rows: [row(0), row(1), row(2)],
            axes: [x, y, z],
            shear: [d[x] * inverse[z], d[y] * inverse[z], inverse[z]],
        }
    }
}
