//! A tree of clusters over the patches: near each other, and facing alike.
//!
//! ```text
//! leaf = one patch        node = the patches order[begin .. end]        A = Σ A_i
//! ```
//!
//! A node is cut in the middle of its longest extent, of six: three of the places and three of the normals. A turn of one radian counts as
//! [`TURN`] diameters of the scene: large clusters are kept together by where they are, small ones face one way, so that one number can tell how they see
//! each other [Walter et al. 2005, §4.1 cut lights' trees so]. Objects are no boundary: a cluster may hold parts of many.
//!
//! What emits light has a tree of its own, for it is looked at in another way. Nodes stand in preorder: the first child follows its parent, sums go up in one loop backwards and down in one forwards.

use crate::patch::{Chart, NONE, Patches, Side};
use glam::{DVec2, Vec3};
use rayon::prelude::*;

/// What a difference of normals of length one weighs, in diameters of the scene.
const TURN: f32 = 0.25;

/// Clusters smaller than this are cut by the thread at hand.
const ALONE: usize = 4096;

/// A cluster.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// The first of its patches in [`Tree::order`].
    pub begin: u32,
    /// One past the last.
    pub end: u32,
    /// The second child; the first stands next to the node itself.
    pub second: u32,
    /// The box around it, m.
    pub low: Vec3,
    /// Its other corner.
    pub high: Vec3,
    /// The mean normal, unit.
    pub axis: Vec3,
    /// Largest |n - axis|.
    pub spread: f32,
    /// Least and largest axis · p of its points, m.
    pub slab: [f32; 2],
    /// The side of a plane or of a ball, from outside, that holds it all: no two of its points see each other.
    pub convex: u32,
}

impl Node {
    const NONE: Self = Self {
        begin: 0,
        end: 0,
        second: 0,
        low: Vec3::ZERO,
        high: Vec3::ZERO,
        axis: Vec3::ZERO,
        spread: 2.0,
        slab: [0.0; 2],
        convex: NONE,
    };

    /// Whether it is a patch.
    #[inline]
    pub fn is_leaf(&self) -> bool {
        self.end - self.begin == 1
    }

    /// Half the diagonal of the box, m.
    #[inline]
    pub fn radius(&self) -> f32 {
        0.5 * (self.high - self.low).length()
    }

    /// The middle of the box.
    #[inline]
    pub fn middle(&self) -> Vec3 {
        0.5 * (self.low + self.high)
    }

    /// How far the boxes are apart at least, m.
    #[inline]
    pub fn distance(&self, other: &Self) -> f32 {
        (other.low - self.high).max(self.low - other.high).max(Vec3::ZERO).length()
    }

    /// Whether surely no point of `other` is above the horizon of any point here.
    #[inline]
    pub fn is_blind_to(&self, other: &Self) -> bool {
        if self.convex != NONE && self.convex == other.convex {
            return true;
        }
        let half = 0.5 * (other.high - other.low);
        let highest = self.axis.dot(other.middle()) + self.axis.abs().dot(half);
        let reach = (other.middle() - self.middle()).length() + other.radius() + self.radius();
        // Points on one plane do not see each other, whatever their rounding.
        highest - self.slab[0] + self.spread * reach <= 1e-6 * (reach + self.middle().abs().max_element())
    }
}

/// A patch on its way into the tree.
#[derive(Clone, Copy)]
struct Item {
    patch: u32,
    p: Vec3,
    low: Vec3,
    high: Vec3,
    n: Vec3,
    spread: f32,
    convex: u32,
}

/// The trees: that of what emits no light, and that of what does.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    /// Each tree in preorder, one after the other.
    pub nodes: Vec<Node>,
    /// Patches in the order of leaves.
    pub order: Vec<u32>,
    /// The roots.
    pub roots: [Option<u32>; 2],
}

impl Tree {
    /// Of the patches that `takes_part` holds of.
    pub fn new(patches: &Patches, takes_part: impl Fn(u32) -> bool + Sync) -> Self {
        let mut tree = Self::default();
        for emits in [false, true] {
            let chosen = |i: &u32| takes_part(*i) && patches.get(*i).be.is_zero() != emits;
            let mut items: Vec<Item> = (0..patches.len() as u32).into_par_iter().filter(chosen).map(|i| item(patches, i)).collect();
            if items.is_empty() {
                continue;
            }
            let (low, high) = items.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), i| (l.min(i.low), h.max(i.high)));
            let root = tree.nodes.len();
            tree.roots[usize::from(emits)] = Some(root as u32);
            tree.nodes.resize(root + 2 * items.len() - 1, Node::NONE);
            cut(&mut items, tree.order.len() as u32, &mut tree.nodes[root..], root as u32, TURN * (high - low).length());
            tree.order.extend(items.iter().map(|i| i.patch));
        }
        tree
    }

    /// The children of a node that is no leaf.
    #[inline]
    pub fn children(&self, k: u32) -> [u32; 2] {
        [k + 1, self.nodes[k as usize].second]
    }

    /// Sums of what leaves hold, for all nodes.
    pub fn sums<T: Copy + std::ops::Add<Output = T>>(&self, leaf: impl Fn(u32) -> T, zero: T) -> Vec<T> {
        let mut sums = vec![zero; self.nodes.len()];
        for (k, node) in self.nodes.iter().enumerate().rev() {
            sums[k] = if node.is_leaf() { leaf(self.order[node.begin as usize]) } else { sums[k + 1] + sums[node.second as usize] };
        }
        sums
    }

    /// To each leaf what stands at it and at all nodes above.
    pub fn hand_down<T: Copy + std::ops::Add<Output = T>>(&self, mut at: Vec<T>, mut leaf: impl FnMut(u32, T)) {
        for (k, node) in self.nodes.iter().enumerate() {
            if node.is_leaf() {
                leaf(self.order[node.begin as usize], at[k]);
            } else {
                at[k + 1] = at[k + 1] + at[k];
                at[node.second as usize] = at[node.second as usize] + at[k];
            }
        }
    }
}

/// Fills in the nodes of `items`, of which the first is number `begin` of the order, and sorts them.
fn cut(items: &mut [Item], begin: u32, nodes: &mut [Node], place: u32, turn: f32) {
    let Some((node, below)) = nodes.split_first_mut() else { return };
    let middle = items.len() / 2;
    *node = around(items);
    (node.begin, node.end) = (begin, begin + items.len() as u32);
    if items.len() == 1 {
        return;
    }
    let split = halve(items, turn).unwrap_or(middle);
    let (left, right) = items.split_at_mut(split);
    let (first, second) = below.split_at_mut(2 * split - 1);
    node.second = place + 2 * split as u32;
    let (at, to) = (begin + split as u32, node.second);
    if left.len() + right.len() > ALONE {
        rayon::join(|| cut(left, begin, first, place + 1, turn), || cut(right, at, second, to, turn));
    } else {
        cut(left, begin, first, place + 1, turn);
        cut(right, at, second, to, turn);
    }
}

/// Sorts items to both sides of the middle of their longest extent; how many come first. `None` where all are in one place.
fn halve(items: &mut [Item], turn: f32) -> Option<usize> {
    let range =
        |of: fn(&Item) -> Vec3| items.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), i| (l.min(of(i)), h.max(of(i))));
    let (places, normals) = (range(|i| i.p), range(|i| i.n));
    let extents = [(places.1 - places.0).to_array(), ((normals.1 - normals.0) * turn).to_array()].concat();
    let axis = (0..6).fold(0, |best, k| if extents[k] > extents[best] { k } else { best });
    let middle = (0.5 * if axis < 3 { places.0 + places.1 } else { normals.0 + normals.1 })[axis % 3];
    let is_first = |i: &Item| if axis < 3 { i.p[axis] < middle } else { i.n[axis - 3] < middle };
    let mut split = 0;
    for k in 0..items.len() {
        if is_first(&items[k]) {
            items.swap(split, k);
            split += 1;
        }
    }
    (split > 0 && split < items.len()).then_some(split)
}

/// The bounds of some patches.
fn around(items: &[Item]) -> Node {
    let (mut low, mut high, mut sum) = (Vec3::INFINITY, Vec3::NEG_INFINITY, Vec3::ZERO);
    for i in items {
        (low, high, sum) = (low.min(i.low), high.max(i.high), sum + i.n);
    }
    let axis = sum.try_normalize().unwrap_or(Vec3::Z);
    let spread = items.iter().map(|i| (i.n - axis).length() + i.spread).fold(0.0, f32::max);
    let slab = items.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[least, most], i| {
        let (at, half) = (axis.dot(i.p), axis.abs().dot(0.5 * (i.high - i.low)));
        // The points of a flat patch lie in its plane, nearer to it than to the sides of its box.
        let bend = (i.n - axis).length() + i.spread;
        let half = half.min(bend * (i.high - i.low).length() + 1e-6 * at.abs());
        [least.min(at - half), most.max(at + half)]
    });
    let convex = items.iter().map(|i| i.convex).reduce(|a, b| if a == b { a } else { NONE }).unwrap_or(NONE);
    Node { low, high, axis, convex, spread: if spread < 1e-5 { 0.0 } else { spread.min(2.0) }, slab, ..Node::NONE }
}

/// Patch i with its bounds.
fn item(patches: &Patches, i: u32) -> Item {
    /// Points a side at which a round patch is looked at.
    const LOOKS: usize = 5;
    let patch = patches.get(i);
    let (p, n) = (patch.p.as_vec3(), patch.n.as_vec3());
    let (span, chart) = patches.geometry(i);
    let within = |points: &mut dyn Iterator<Item = Vec3>| points.fold((p, p), |(l, h), p| (l.min(p), h.max(p)));
    let (low, high, spread) = match patches.polygon(i) {
        Some(polygon) => {
            let (low, high) = within(&mut polygon.iter().map(|p| p.as_vec3()));
            (low, high, 0.0)
        }
        None if span.size.max_element() > 0.3 => {
            let (p, r) = patches.ball(i);
            let (p, r) = (p.as_vec3(), Vec3::splat(r as f32));
            (p - r, p + r, if chart.is_flat() { 0.0 } else { 2.0 })
        }
        None => {
            let at = |k: usize| k as f64 / (LOOKS - 1) as f64;
            let grid = || (0..LOOKS * LOOKS).map(|k| span.global(DVec2::new(at(k % LOOKS), at(k / LOOKS))));
            let (low, high) = within(&mut grid().map(|st| chart.point(st).as_vec3()));
            let side = patch.side.sign();
            let turn = |st: DVec2| (chart.normal(st) * side).as_vec3().distance(n);
            let spread = if chart.is_flat() { 0.0 } else { 1.05 * grid().map(turn).fold(0.0, f32::max) };
            // Between the points of the grid the surface bulges by a fraction of what it does over the whole patch.
            let bulge = 0.02 * (high - low).length();
            (low - bulge, high + bulge, spread)
        }
    };
    let chart_number = patches.cells[patch.cell as usize].chart;
    let convex = match chart {
        Chart::Round { outward, .. } if !chart.is_flat() && outward * patch.side.sign() < 0.0 => NONE,
        _ => 2 * chart_number + u32::from(patch.side == Side::Back),
    };
    Item { patch: i, p, low, high, n, spread, convex }
}
