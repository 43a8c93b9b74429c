//! Links with what emits light: by rays between points, as direct light is found in every other solver.
//!
//! ```text
//! k = mean of V cosθx cosθy / (π r²) over m² pairs of points of patch i and of cluster S                    1/m²
//! ```
//!
//! Few rays that leave a patch happen to meet a lamp, and what they bring is most of the light. So each patch is linked with the coarsest clusters of lamps
//! that look even from there: r_S / d + turn_S / 2 ≤ [`EVEN`]. Both points of the pairs are stratified by area, and jittered by a hash of the pair: no lamp point is looked
//! at twice, which tells more of half shadows than all pairs of m points of each do. Lamps that could give the patch more than [`LARGE`] of all that lamps could give have twice as many points.
//!
//! Between flat patches near each other K has no bound. There ∬ K is the closed form, times the part of it that rays see.

use super::Link;
use super::tree::{Node, Tree};
use crate::form_factor::{Sight, polygon};
use crate::patch::{PatchPoint, Patches};
use arrayvec::ArrayVec;
use etendue_numerics::Vec2;
use etendue_numerics::sequence::{mix, unit};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// How much K may vary over a cluster of lamps, as seen from a patch.
const EVEN: f32 = 0.25;

/// The part of all light from lamps, if nothing were in the way, above which a lamp is looked at more closely.
const LARGE: f64 = 0.125;

/// Distance over the sum of both radii below which flat patches have the closed form.
const NEAR: f32 = 1.0;

/// The most pairs, and their root.
const MOST: usize = 8;
const PAIRS: usize = MOST * MOST;

/// Looks from patches at lamps.
pub(super) struct Lamps<'a> {
    patches: &'a Patches,
    tree: &'a Tree,
    sight: Sight<'a>,
    /// Areas of the leaves up to each place of the order, m².
    up_to: Vec<f64>,
    /// Light of all clusters, W over channels.
    power: Vec<f64>,
    /// The part of each that is not covered.
    open: Vec<f64>,
    /// The leaf of each patch.
    leaves: Vec<u32>,
    seed: u64,
}

impl<'a> Lamps<'a> {
    pub fn new(patches: &'a Patches, tree: &'a Tree, sight: Sight<'a>, areas: &[f32], power: Vec<f64>, seed: u64) -> Self {
        let mut up_to = vec![0.0];
        up_to.extend(areas.iter().scan(0.0, |sum, a| {
            *sum += f64::from(*a);
            Some(*sum)
        }));
        let own = tree.sums(|i| patches.get(i).area, 0.0);
        let part = |(node, own): (&Node, &f64)| own / (up_to[node.end as usize] - up_to[node.begin as usize]);
        let open = tree.nodes.iter().zip(&own).map(part).collect();
        let mut leaves = vec![0; patches.len()];
        let places = tree.nodes.iter().enumerate().filter(|(_, node)| node.is_leaf());
        places.for_each(|(k, node)| leaves[tree.order[node.begin as usize] as usize] = k as u32);
        Self { patches, tree, sight, up_to, power, open, leaves, seed }
    }

    /// All links between what emits no light and what does, by `m` points of each, or twice as many.
    pub fn links(&self, m: usize) -> Vec<Link> {
        let [Some(dark), Some(bright)] = self.tree.roots else { return Vec::new() };
        /// Nodes of a task.
        const NODES: usize = 1024;
        let nodes: Vec<u32> = (dark..dark + 2 * (self.node(dark).end - self.node(dark).begin) - 1).collect();
        let task = |nodes: &[u32]| {
            let (mut links, mut seen) = (Vec::new(), Vec::new());
            nodes.iter().filter(|k| self.node(**k).is_leaf()).for_each(|k| self.of_patch(*k, bright, m, 0, &mut seen, &mut links));
            links
        };
        nodes.par_chunks(NODES).flat_map_iter(task).collect()
    }

    /// Whether a patch emits light.
    pub fn is_lamp(&self, i: u32) -> bool {
        !self.patches.get(i).be.is_zero()
    }

    /// Irradiance of patch i, if it is no lamp, from lamps of radiosities b, by points that no link has; W/m².
    pub fn irradiance(&self, i: u32, b: &[DVec3]) -> DVec3 {
        let ([Some(_), Some(bright)], false) = (self.tree.roots, self.is_lamp(i)) else { return DVec3::ZERO };
        let mut links = Vec::new();
        self.of_patch(self.leaves[i as usize], bright, MOST, 1, &mut Vec::new(), &mut links);
        let power = |k: u32| -> DVec3 {
            let node = self.node(k);
            let leaves = &self.tree.order[node.begin as usize..node.end as usize];
            leaves.iter().map(|j| b[*j as usize] * self.patches.get(*j).area).sum()
        };
        links.iter().map(|l| power(l.ends[1]) * f64::from(l.k)).sum()
    }

    fn node(&self, k: u32) -> &Node {
        &self.tree.nodes[k as usize]
    }

    /// The links of one patch; `look` is a set of points of its own.
    fn of_patch(&self, leaf: u32, root: u32, m: usize, look: u64, seen: &mut Vec<(u32, f64)>, links: &mut Vec<Link>) {
        let x = self.node(leaf);
        seen.clear();
        let mut stack = vec![root];
        while let Some(k) = stack.pop() {
            let s = self.node(k);
            if x.is_blind_to(s) || s.is_blind_to(x) {
                continue;
            }
            let d = s.middle() - x.middle();
            let d2 = d.length_squared();
            if !s.is_leaf() && s.radius() > (EVEN - 0.5 * s.spread).max(0.0) * d2.sqrt() {
                let [first, second] = self.tree.children(k);
                stack.extend([second, first]);
                continue;
            }
            let give = x.axis.dot(d).max(0.0) * -s.axis.dot(d).min(0.0) / (d2 * d2);
            seen.push((k, self.power[k as usize] * f64::from(give)));
        }
        let all: f64 = seen.iter().map(|(_, give)| give).sum();
        for (k, give) in seen {
            let m = if *give > LARGE * all { 2 * m } else { m };
            let link = self.link([leaf, *k], m.min(MOST), look);
            if link.k > 0.0 {
                links.push(link);
            }
        }
    }

    /// The link between a patch and a cluster, by `m`² pairs of points.
    fn link(&self, ends: [u32; 2], m: usize, look: u64) -> Link {
        let [r, s] = ends.map(|k| self.node(k));
        let key = mix(self.seed ^ mix(u64::from(ends[0]) << 32 | u64::from(ends[1])) ^ m as u64 ^ look << 8);
        let (xs, ys) = (self.points(r, m * m, key), self.points(s, m * m, mix(key)));
        let (mut clear, mut seen) = (0.0, 0.0);
        for (k, x) in xs.iter().enumerate() {
            // Both digits of k to base m in turn: each m-th of the one meets each of the other.
            let y = &ys[k % m * m + k / m];
            let d = y.1.p - x.1.p;
            let r2 = d.length_squared();
            let (cos_x, cos_y) = (d.dot(x.1.n), -d.dot(y.1.n));
            if cos_x > 0.0 && cos_y > 0.0 {
                let k = cos_x * cos_y / (PI * r2 * r2) * x.1.weight * y.1.weight;
                clear += k;
                seen += if self.sight.sees((x.0, &x.1), (y.0, &y.1)) { k } else { 0.0 };
            }
        }
        let all = match if s.is_leaf() { self.closed(r, s) } else { None } {
            Some(exact) if clear > 0.0 => exact * seen / clear,
            _ => seen / (m * m) as f64,
        };
        // No exchange is more than all the light of the smaller.
        let most = 1.0 / self.area(r).max(self.area(s));
        // What is covered sees nothing, and takes no part: the rest has all of it.
        let parts = ends.map(|k| self.open[k as usize]);
        Link { ends, k: (all.min(most) / (parts[0] * parts[1])) as f32 }
    }

    /// Mean K between flat patches that are near each other, nothing in between.
    fn closed(&self, r: &Node, s: &Node) -> Option<f64> {
        if r.distance(s) > NEAR * (r.radius() + s.radius()) {
            return None;
        }
        let [i, j] = [r, s].map(|node| self.tree.order[node.begin as usize]);
        let (a, b) = (self.patches.polygon(i)?, self.patches.polygon(j)?);
        let exchange = polygon::exchange(&a, self.patches.get(i).n, &b, self.patches.get(j).n);
        Some(exchange / (self.area(r) * self.area(s)))
    }

    /// Area of a node with what is covered, m².
    fn area(&self, node: &Node) -> f64 {
        self.up_to[node.end as usize] - self.up_to[node.begin as usize]
    }

    /// `m` points of a cluster, one in each of as many equal parts of its area.
    fn points(&self, node: &Node, m: usize, key: u64) -> ArrayVec<(u32, PatchPoint), PAIRS> {
        let (begin, end) = (node.begin as usize, node.end as usize);
        let (from, area) = (self.up_to[begin], self.area(node));
        let at = |k: usize| {
            let bits = mix(key.wrapping_add(k as u64 + 1));
            let (u, v) = (unit(bits as u32), unit((bits >> 32) as u32));
            let along = (k as f32 + u) / m as f32;
            if node.is_leaf() {
                // Strata of both parameters: the net of van der Corput.
                let across = unit((k as u32).reverse_bits()) + v / m as f32;
                let i = self.tree.order[begin];
                return (i, self.patches.sample(i, Vec2::new(along, across.min(1.0 - f32::EPSILON))));
            }
            let goal = from + f64::from(along) * area;
            let leaf = begin + self.up_to[begin + 1..end].partition_point(|sum| *sum <= goal);
            let i = self.tree.order[leaf];
            let more = mix(bits);
            (i, self.patches.sample(i, Vec2::new(unit(more as u32), unit((more >> 32) as u32))))
        };
        let by_area = |(i, x): (u32, PatchPoint)| {
            // The patch's own area is what is not covered, that of the cluster all of it.
            let (span, chart) = self.patches.geometry(i);
            let part = if x.weight == 1.0 { 1.0 } else { self.patches.get(i).area / chart.area(span) };
            (i, PatchPoint { weight: x.weight * part, ..x })
        };
        (0..m).map(|k| by_area(at(k))).collect()
    }
}
