//! Rays in order of direction: rays of one kind go through a tree alike, one soon after the other or side by side.

use super::setup;
use etendue_numerics::Ray;

/// Directions that go together: eight octants × the axis of the largest component.
const KINDS: usize = 24;

/// Hands over the places of the rays, up to `most` of one kind at a time; rays that are not ordinary one by one, without a kind.
pub(super) fn by_kind(rays: &[Ray], most: usize, mut cast: impl FnMut(Option<usize>, &[u32])) {
    let kind = |ray: &Ray| if setup::is_ordinary(ray) { kind(ray) } else { KINDS as u8 };
    let kinds: Vec<u8> = rays.iter().map(kind).collect();
    let mut starts = [0; KINDS + 2];
    kinds.iter().for_each(|k| starts[*k as usize + 1] += 1);
    for k in 0..=KINDS {
        starts[k + 1] += starts[k];
    }
    let (mut order, mut next) = (vec![0; rays.len()], starts);
    for (i, kind) in kinds.iter().enumerate() {
        let place = &mut next[*kind as usize];
        order[*place] = i as u32;
        *place += 1;
    }
    for kind in 0..KINDS {
        order[starts[kind]..starts[kind + 1]].chunks(most).for_each(|these| cast(Some(kind), these));
    }
    order[starts[KINDS]..].chunks(1).for_each(|this| cast(None, this));
}

/// The octant and the largest axis of a direction: that of `setup::largest_axis`.
#[inline(always)]
pub(super) fn kind(ray: &Ray) -> u8 {
    const AXES: [u8; 8] = [2, 2, 2, 0, 1, 2, 1, 0];
    let [x, y, z] = ray.d.to_array();
    let (a, b, c) = (x.abs(), y.abs(), z.abs());
    let axis = AXES[usize::from(a > b) | usize::from(a > c) << 1 | usize::from(b > c) << 2];
    let signs = (x.to_bits() >> 31) | (y.to_bits() >> 31) << 1 | (z.to_bits() >> 31) << 2;
    signs as u8 * 3 + axis
}
