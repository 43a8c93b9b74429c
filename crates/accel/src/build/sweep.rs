//! Splits of a few references: every order of centroids, every place in it, by the cost of [`crate::build::split`].

use crate::build::reference::{Box4, Reference, half_areas, least};
use crate::build::split::Extent;
use etendue_numerics::wide::{self, Job};
use glam::Vec4;
use std::ops::Range;

/// The most references that [`sweep_split`] takes.
pub(crate) const SWEEP: usize = 8;

/// The cheapest split of a few references over all orders of centroids; leaves them in that order. Returns how many are in front, and
/// the extents of both sides without their centroids, which so few do not need.
pub(crate) fn sweep_split(references: &mut [Reference]) -> (usize, Extent, Extent) {
    let (fronts, front, back) = wide::widest(Sweep(references));
    let extent = |bounds: Box4| Extent { bounds, centroids: Box4::EMPTY };
    (fronts, extent(front), extent(back))
}

/// The job of [`sweep_split`].
pub(super) struct Sweep<'a>(pub &'a mut [Reference]);

impl Job for Sweep<'_> {
    type Output = (usize, Box4, Box4);

    #[inline(always)]
    fn run(self) -> (usize, Box4, Box4) {
        let references = self.0;
        let n = references.len();
        let mut keys = [[f32::INFINITY; SWEEP]; 3];
        let mut boxes = [Box4::EMPTY; SWEEP];
        for (i, r) in references.iter().enumerate() {
            let c = r.centroid2();
            (keys[0][i], keys[1][i], keys[2][i]) = (c.x, c.y, c.z);
            boxes[i] = r.bounds();
        }
        // each one's rank is how many are below it, or equal and before it
        let orders = keys.map(|keys| {
            let mut ranks = [0_i32; SWEEP];
            for (j, key) in keys.into_iter().enumerate() {
                for i in 0..SWEEP {
                    ranks[i] += i32::from(key < keys[i]) | (i32::from(key == keys[i]) & i32::from(j < i));
                }
            }
            let mut order = [0_u8; SWEEP];
            for (i, rank) in ranks.into_iter().enumerate() {
                order[rank as usize & (SWEEP - 1)] = i as u8;
            }
            order
        });
        let at = |axis: usize, i: usize| boxes[orders[axis][i] as usize & (SWEEP - 1)];

        // always in full, since n cannot be guessed: behind the last one there is nothing left, and no number is its cost
        let mut backs = [Vec4::ZERO; SWEEP];
        let mut side = [Box4::EMPTY; 3];
        for i in (1..SWEEP).rev() {
            for (axis, side) in side.iter_mut().enumerate() {
                *side = side.union(at(axis, i));
            }
            backs[i] = half_areas(&side) * n.saturating_sub(i) as f32;
        }
        let (mut best, mut best_at) = (Vec4::INFINITY, Vec4::splat((n / 2) as f32));
        side = [Box4::EMPTY; 3];
        for (i, back) in backs.into_iter().enumerate().skip(1) {
            for (axis, side) in side.iter_mut().enumerate() {
                *side = side.union(at(axis, i - 1));
            }
            let cost = half_areas(&side) * i as f32 + back;
            let is_less = cost.cmplt(best);
            best = Vec4::select(is_less, cost, best);
            best_at = Vec4::select(is_less, Vec4::splat(i as f32), best_at);
        }
        let axis = least(best);
        let fronts = best_at[axis] as usize;
        let mut sorted = [Reference::NONE; SWEEP];
        for i in 0..n {
            sorted[i] = references[orders[axis][i] as usize & (SWEEP - 1)];
        }
        references.copy_from_slice(&sorted[..n]);
        let all = |places: Range<usize>| places.fold(Box4::EMPTY, |all, i| all.union(at(axis, i)));
        (fronts, all(0..fronts), all(fronts..n))
    }
}
