//! From two children a node to eight: the cheapest cut of the binary tree into wide nodes and leaves [Ylitie, Karras, Laine 2017, §3.1].
//!
//! C(n, i) is the least cost of subtree n as at most i children of some wide node:
//!
//! ```text
//! C(n, 1) = min( A_n (leaf + triangle · triangles), A_n NODE + min_k C(left, k) + C(right, 8 - k) )
//! C(n, i) = min( C(n, i - 1), min_k C(left, k) + C(right, i - k) )        i = 2 … 7
//! ```
//!
//! with A_n half the surface of n's box. The prices are measured, in units of one node visited.

/// Visiting a wide node.
const NODE: f32 = 1.0;

/// What leaves cost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prices {
    /// Visiting one, whatever it holds.
    pub leaf: f32,
    /// For each triangle in it.
    pub triangle: f32,
    /// Up to so many triangles are a leaf without a further look: to part them would hardly ever pay.
    pub whole: u32,
}

impl Prices {
    /// A ray meets eight triangles at a time.
    pub const SINGLE: Self = Self { leaf: 0.8, triangle: 0.05, whole: 4 };
    /// Sixteen rays meet a triangle at a time.
    pub const PACKET: Self = Self { leaf: 0.1, triangle: 0.35, whole: 1 };
}

/// A custom shape or an instance: always a leaf of its own.
const OTHER: f32 = 3.0;

/// The most triangles of a leaf.
pub(crate) const LEAF_SIZE: u32 = 8;

/// C(n, 1..=7) of a subtree, and what is in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Costs {
    pub cost: [f32; 7],
    references: u32,
    only_triangles: bool,
}

/// A subtree that is not parted any further: one reference, or [`Prices::whole`] triangles at most.
pub(crate) fn leaf(area: f32, references: u32, only_triangles: bool, prices: Prices) -> Costs {
    let cost = if only_triangles { prices.leaf + prices.triangle * references as f32 } else { OTHER };
    Costs { cost: [area * cost; 7], references, only_triangles }
}

/// A subtree of two, with its decisions: four bits for each i; 0 means "a leaf" (i = 1) or "as with i - 1", k that k children are the left's.
pub(crate) fn inner(area: f32, left: &Costs, right: &Costs, prices: Prices) -> (Costs, u32) {
    let distribute = |slots: usize| {
        let mut best = (f32::INFINITY, 1);
        for k in slots.saturating_sub(7).max(1)..=(slots - 1).min(7) {
            let cost = left.cost[k - 1] + right.cost[slots - k - 1];
            if cost < best.0 {
                best = (cost, k);
            }
        }
        best
    };
    let references = left.references + right.references;
    let only_triangles = left.only_triangles && right.only_triangles;
    let mut cost = [0.0; 7];
    let (children, k) = distribute(8);
    let as_node = area * NODE + children;
    let as_leaf = area * (prices.leaf + prices.triangle * references as f32);
    let is_leaf = only_triangles && references <= LEAF_SIZE && as_leaf <= as_node;
    let mut decisions = if is_leaf { 0 } else { k as u32 };
    cost[0] = if is_leaf { as_leaf } else { as_node };
    for i in 2..=7 {
        let (split, k) = distribute(i);
        cost[i - 1] = split.min(cost[i - 2]);
        if split < cost[i - 2] {
            decisions |= (k as u32) << (4 * (i - 1));
        }
    }
    (Costs { cost, references, only_triangles }, decisions)
}

/// The decision about `slots` children of a subtree.
#[inline]
pub(crate) fn decision(decisions: u32, slots: usize) -> usize {
    (decisions >> (4 * (slots - 1)) & 15) as usize
}
