//! Rows that sum to one.
//!
//! ```text
//! F_ij = x_i k A_j x_j        x_i ← x_i √(A_i / (x_i (S x)_i + x_i s_i)),   S_ij = A_i k A_j        until Σ_j F_ij + losses = 1
//! ```
//!
//! The repair of form factors ([`crate::form_factor::Repair`]), with a product by links in place of one by a matrix. It puts right, patch by patch, what one
//! number for many patches cannot hold: the whole of what each sees. Losses s are measured by the rays of a patch and of its
//! neighbours in the tree, [`NEIGHBOURS`] of them.

use super::carry::{Rows, carry};
use super::rays::{Caster, Samples};
use super::tree::Tree;
use crate::form_factor::{Repair, balance};

/// Patches whose rays tell of the losses of each, at most.
const NEIGHBOURS: u32 = 16;

/// The parts of the light of each patch that escape, and that are absorbed by what is no patch.
pub fn losses(tree: &Tree, samples: &Samples, caster: &Caster<'_>) -> Vec<[f64; 2]> {
    let mut lost = vec![[0.0; 2]; caster.patches.len()];
    let mut k = 0;
    while k < tree.nodes.len() {
        let node = &tree.nodes[k];
        let leaves = node.end - node.begin;
        if leaves > NEIGHBOURS {
            k += 1;
            continue;
        }
        let range = node.begin as usize..node.end as usize;
        let each = range.clone().map(|at| (tree.order[at], caster.lost(tree.order[at], samples.lost[at], samples.rays)));
        let (sum, area) = each.fold(([0.0; 2], 0.0), |([e, a], area), (i, [x, y])| {
            let own = caster.patches.get(i).area;
            ([e + x * own, a + y * own], area + own)
        });
        tree.order[range].iter().for_each(|i| lost[*i as usize] = sum.map(|s| s / area));
        k += 2 * leaves as usize - 1;
    }
    lost
}

/// x, with which rows are `near` to one, and what was done; `lost` is scaled with the rows.
pub fn close(tree: &Tree, rows: &Rows, areas: &[f64], lost: &mut [[f64; 2]], near: f64) -> (Vec<f64>, Repair) {
    let ones = vec![1.0; areas.len()];
    let product = |x: &[f64]| {
        let weights: Vec<f64> = areas.iter().zip(x).map(|(a, x)| a * x).collect();
        let h = carry(tree, rows, &weights, &ones, &ones);
        h.iter().zip(areas).map(|(h, a)| h * a).collect::<Vec<f64>>()
    };
    let sums = |x: &[f64]| -> Vec<f64> { product(x).iter().zip(x).zip(areas).map(|((s, x), a)| s * x / a).collect() };
    let off = |sums: &[f64], lost: &[[f64; 2]]| {
        let of = |(s, l): (&f64, &[f64; 2])| if *s > 0.0 { (1.0 - s - l[0] - l[1]).abs() } else { 0.0 };
        sums.iter().zip(lost).map(of).fold(0.0, f64::max)
    };
    let closed = lost.iter().all(|l| *l == [0.0; 2]);
    let before = sums(&ones);
    let closure_before = off(&before, lost);
    let sinks: Vec<f64> = lost.iter().zip(areas).map(|(l, a)| (l[0] + l[1]) * a).collect();
    let (x, sweeps) = balance(product, areas, &sinks, near);
    lost.iter_mut().zip(&x).for_each(|(l, x)| *l = l.map(|l| l * x));
    let after = sums(&x);
    let moved: f64 = before.iter().zip(&after).zip(areas).map(|((b, a), area)| (a - b).abs() * area).sum();
    let repair = Repair {
        closed,
        closure_before,
        closure_after: off(&after, lost),
        moved_by_scaling: moved / areas.iter().sum::<f64>(),
        largest_scale: x.iter().map(|x| (x - 1.0).abs()).fold(0.0, f64::max),
        sweeps,
        ..Repair::default()
    };
    (x, repair)
}
