//! Rays from patches, and what they meet: the raw matter of links, and of their check.
//!
//! ```text
//! x uniform on i,  w with density cosθ/π:        A_i F_ij ≈ A_i · (rays that meet j) / N
//! ```
//!
//! Rays that start where something stands on a patch do not count. What is known of that from [`crate::cover`] is taken off what was absorbed.

use super::tree::Tree;
use crate::form_factor::{Landing, land};
use crate::patch::{PatchPoint, Patches};
use etendue_numerics::warp::square_to_cosine_hemisphere;
use etendue_numerics::{Frame, Net4, Vec2};
use etendue_scene::Scene;
use rayon::prelude::*;

/// A ray from one leaf to another: their places in the order. Which of the two it came from is forgotten.
pub type Sample = [u32; 2];

/// Casts rays.
pub struct Caster<'a> {
    pub scene: &'a Scene,
    pub patches: &'a Patches,
    /// The part of each patch that is not covered.
    pub open: &'a [f64],
    pub seed: u64,
}

impl Caster<'_> {
    /// Hands over what `n` rays from patch i meet; `set` is a set of rays of its own.
    pub fn cast(&self, i: u32, n: usize, set: u64, mut meets: impl FnMut(Landing)) {
        for (k, [u, v, s, t]) in Net4::new(self.seed ^ set << 40, u64::from(i)).take(n).enumerate() {
            let x = self.point(i, Vec2::new(s, t), k);
            if self.patches.touching_at(i, x.p).is_none() {
                let w = Frame::from_normal(x.n.as_vec3()).to_world(square_to_cosine_hemisphere(Vec2::new(u, v)));
                meets(land(self.scene, self.patches, i, &x, w));
            }
        }
    }

    /// A point of patch i. Where parameters are not in step with area, one of several by their weights [Talbot, Cline, Egbert 2005].
    fn point(&self, i: u32, u: Vec2, k: usize) -> PatchPoint {
        /// Points of which one is taken.
        const CHOICE: u64 = 8;
        let first = self.patches.sample(i, u);
        if first.weight == 1.0 {
            return first;
        }
        let key = etendue_numerics::sequence::mix(u64::from(i) << 32 | k as u64);
        let (mut chosen, mut sum) = (first, first.weight);
        for [u, v, choice, _] in Net4::new(self.seed, key).take(CHOICE as usize - 1) {
            let next = self.patches.sample(i, Vec2::new(u, v));
            sum += next.weight;
            if f64::from(choice) * sum < next.weight {
                chosen = next;
            }
        }
        chosen
    }

    /// What `absorbed` and `escaped` of `n` rays from patch i say of its losses.
    pub fn lost(&self, i: u32, [escaped, absorbed]: [u32; 2], n: usize) -> [f64; 2] {
        let open = self.open[i as usize];
        let part = |count: u32| f64::from(count) / n as f64;
        [part(escaped) / open, (part(absorbed) - (1.0 - open)).max(0.0) / open]
    }
}

/// What rays from all leaves have met.
#[derive(Default)]
pub struct Samples {
    /// Leaf to leaf.
    pub pairs: Vec<Sample>,
    /// Rays a leaf.
    pub rays: usize,
    /// For each leaf, in their order, how many rays escaped and were absorbed.
    pub lost: Vec<[u32; 2]>,
}

impl Samples {
    /// Casts `n` more rays from each leaf. `goes_on` hears of how many leaves are done; `false` leaves all as it was.
    pub fn cast_more(&mut self, caster: &Caster<'_>, tree: &Tree, n: usize, goes_on: &dyn Fn(usize) -> bool) -> bool {
        /// Leaves of a task, and tasks between two looks.
        const LEAVES: usize = 256;
        const TASKS: usize = 256;
        let mut place = vec![u32::MAX; caster.patches.len()];
        tree.order.iter().enumerate().for_each(|(k, i)| place[*i as usize] = k as u32);
        let before = self.pairs.len();
        let mut lost = Vec::with_capacity(tree.order.len());
        let set = 1 + (self.rays / n.max(1)) as u64 + ((n as u64) << 8);
        let tasks: Vec<(usize, &[u32])> = tree.order.chunks(LEAVES).enumerate().collect();
        for batch in tasks.chunks(TASKS) {
            let task = |(task, leaves): &(usize, &[u32])| {
                let mut pairs = Vec::with_capacity(leaves.len() * n);
                let lost: Vec<[u32; 2]> = leaves
                    .iter()
                    .enumerate()
                    .map(|(k, i)| {
                        let from = (task * LEAVES + k) as u32;
                        let mut lost = [0; 2];
                        caster.cast(*i, n, set, |landing| match landing {
                            Landing::Patch(j) if place[j as usize] != u32::MAX => pairs.push([from, place[j as usize]]),
                            Landing::Patch(_) | Landing::Absorbed => lost[1] += 1,
                            Landing::Escaped => lost[0] += 1,
                        });
                        lost
                    })
                    .collect();
                (pairs, lost)
            };
            let found: Vec<_> = batch.par_iter().map(task).collect();
            for (pairs, counts) in found {
                self.pairs.extend(pairs);
                lost.extend(counts);
            }
            if !goes_on(lost.len()) {
                self.pairs.truncate(before);
                return false;
            }
        }
        self.rays += n;
        self.lost.resize(lost.len(), [0; 2]);
        self.lost.iter_mut().zip(lost).for_each(|(sum, l)| *sum = [sum[0] + l[0], sum[1] + l[1]]);
        true
    }
}
