//! Rows that sum to one.
//!
//! ```text
//! F_ij = x_i k A_j x_j             within what emits light, and within what does not
//! F_ij = y_i k A_j y_j             across:  y = x of what emits, x^β of what does not
//! x_i ← x_i / √(Σ_j F_ij + x_i losses_i)         until every row is one
//! ```
//!
//! The repair of form factors ([`crate::form_factor::Repair`]), with a product by links in place of one by a matrix. It puts right, patch by patch, what one
//! number for many patches cannot hold: the whole of what each sees. Rows of rays are 5 to 10 % off before. Light from lamps is known ten times better
//! than that, by rays between points; scaled with the rest it would be off as far, and no number of rays would make it right again. So β = [`LAMPS`] is small:
//! what lamps give hardly moves, and what is not known so well makes up the rest of the row. It is not zero, for then a row has no scale that closes it where two
//! groups of patches see each other and lamps alone, and the estimates of both disagree.
//!
//! Losses are measured by the rays of a patch and of its neighbours in the tree, [`NEIGHBOURS`] of them.

use super::carry::{Carried, Rows, carry};
use super::rays::{Caster, Samples};
use super::tree::Tree;
use crate::form_factor::{Repair, balance};

/// β: how far what lamps give is scaled with the rest.
const LAMPS: f64 = 0.125;

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

/// Links: those within what emits light and within what does not, and those across.
#[derive(Clone, Debug)]
pub struct Links {
    pub within: Rows,
    pub across: Rows,
}

/// The scales with which rows close, and what of each is lost then.
#[derive(Clone, Debug)]
pub struct Scales {
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    pub lost: Vec<[f64; 2]>,
}

impl Scales {
    /// F b.
    pub fn carry<T: Carried>(&self, tree: &Tree, links: &Links, areas: &[f64], b: &[T]) -> Vec<T> {
        let mut all = carry(tree, &links.within, areas, &self.x, b);
        let across = carry(tree, &links.across, areas, &self.y, b);
        all.iter_mut().zip(across).for_each(|(all, across)| *all = *all + across);
        all
    }
}

/// Scales with which rows are `near` to one, and what was done, given the `losses` that were measured.
pub fn close(
    tree: &Tree,
    links: &Links,
    areas: &[f64],
    losses: &[[f64; 2]],
    is_lamp: impl Fn(usize) -> bool,
    near: f64,
) -> (Scales, Repair) {
    let n = areas.len();
    let ones = vec![1.0; n];
    let sums = |rows: &Rows, x: &[f64]| carry(tree, rows, areas, x, &ones);
    let [within, across] = [&links.within, &links.across].map(|rows| sums(rows, &ones));
    let lost: Vec<f64> = losses.iter().map(|l| l[0] + l[1]).collect();
    let across_of = |x: &[f64]| -> Vec<f64> { (0..n).map(|i| if is_lamp(i) { x[i] } else { x[i].powf(LAMPS) }).collect() };
    let parts = |x: &[f64]| {
        let both = sums(&links.within, x).into_iter().zip(sums(&links.across, &across_of(x)));
        let row = |(i, (w, a)): (usize, (f64, f64))| if w + a > 0.0 { w + a + x[i] * lost[i] } else { 0.0 };
        both.enumerate().map(row).collect::<Vec<f64>>()
    };
    let (x, sweeps) = balance(parts, areas, near);

    let lost = losses.iter().zip(&x).map(|(l, x)| l.map(|l| x * l)).collect();
    let scales = Scales { y: across_of(&x), x, lost };
    let after = scales.carry(tree, links, areas, &ones);
    let off = |sum: &dyn Fn(usize) -> f64, lost: &[[f64; 2]]| {
        let of = |i: usize| if sum(i) > 0.0 { (1.0 - sum(i) - lost[i][0] - lost[i][1]).abs() } else { 0.0 };
        (0..n).map(of).fold(0.0, f64::max)
    };
    let before = |i: usize| within[i] + across[i];
    let moved: f64 = (0..n).map(|i| (after[i] - before(i)).abs() * areas[i]).sum();
    let repair = Repair {
        closed: losses.iter().all(|l| *l == [0.0; 2]),
        closure_before: off(&before, losses),
        closure_after: off(&|i| after[i], &scales.lost),
        moved_by_scaling: moved / areas.iter().sum::<f64>(),
        largest_scale: scales.x.iter().map(|x| (x - 1.0).abs()).fold(0.0, f64::max),
        sweeps,
        ..Repair::default()
    };
    (scales, repair)
}
