//! A tree over the lights of the scene: one is chosen with about the probability that its light deserves, at a cost that grows with the
//! logarithm of their number [Conty Estevez, Kulla 2018].
//!
//! ```text
//! P(light | x) = Π over its ancestors:  w(child) / Σ w(children)
//! w = I cosθ'ₗ cosθ'ₓ / (d² + r²)
//! θ'ₗ = max(0, θ - θo - θb), w = 0 where θ'ₗ ≥ θe;    θ'ₓ = max(0, θx - θb)
//! ```
//!
//! | symbol | meaning |
//! | --- | --- |
//! | d, r | distance to the middle of the node's lights, and the radius of the sphere around them |
//! | θ | angle between the lights' axis and the way to x |
//! | θx | angle between x's normal and the way to the lights |
//! | θb | half the angle that the sphere fills, sinθb = r/d |
//!
//! Nodes have four children, whose weights are worked out side by side; up to four lights are one node. 1/(d² + r²) is what a disk
//! light of radius r gives on its axis; unlike 1/d² it stays sensible nearby. w is zero only where no light can arrive, so every light
//! that matters has its chance.

use super::extent::LightBounds;
use super::record::LightReference;
use etendue_numerics::math::safe_sqrt;
use etendue_numerics::{Vec3, Vec4};

/// Bins along an axis when a set of lights is split.
const BINS: usize = 12;
/// Splits in a row after which lights are halved by count, so that no arrangement makes a deep tree.
const MAX_UNEVEN_DEPTH: u32 = 24;
/// Marks a child that is a light.
const LEAF: u32 = 1 << 31;
/// Marks the absence of a child, a parent or a light.
const NONE: u32 = u32::MAX;

/// Four children, side by side.
#[derive(Clone, Copy, Debug)]
struct Node {
    center: [Vec4; 3],
    r2: Vec4,
    axis: [Vec4; 3],
    cos_o: Vec4,
    sin_o: Vec4,
    cos_e: Vec4,
    intensity: Vec4,
    /// A node, or a light and [`LEAF`], or [`NONE`].
    child: [u32; 4],
}

/// The tree.
#[derive(Clone, Debug, Default)]
pub(super) struct LightTree {
    nodes: Vec<Node>,
    /// For each node its place in its parent, 4 · parent + child; [`NONE`] for the root.
    parent: Vec<u32>,
    /// For each light the place that holds it; [`NONE`] for lights that are dark.
    place: Vec<u32>,
}

impl LightTree {
    /// The tree of the lights `bounds`; those of no intensity are never chosen.
    pub fn new(bounds: &[LightBounds]) -> Self {
        let lit = |b: &LightBounds| b.intensity > 0.0 && b.intensity.is_finite();
        let mut items: Vec<Item> =
            bounds.iter().enumerate().filter(|(_, b)| lit(b)).map(|(i, b)| Item::new(i as u32, *b)).collect();
        let mut tree = Self { nodes: Vec::new(), parent: Vec::new(), place: vec![NONE; bounds.len()] };
        if !items.is_empty() {
            tree.add(&mut items, NONE, 0);
        }
        tree
    }

    /// Whether no light can be chosen.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The probability of [`LightTree::sample`] choosing light `i` at `from`.
    pub fn probability(&self, from: &LightReference, i: usize) -> f32 {
        let mut place = self.place.get(i).copied().unwrap_or(NONE);
        let mut probability = if place == NONE { 0.0 } else { 1.0 };
        while place != NONE {
            let w = self.nodes[place as usize / 4].weights(from);
            let total = sum(w);
            let share = w[place as usize % 4] / total;
            probability *= if total > 0.0 { share } else { 0.0 };
            place = self.parent[place as usize / 4];
        }
        probability
    }

    /// A light by the number `u` in [0, 1), and its probability; `None` where no light can reach `from`.
    pub fn sample(&self, from: &LightReference, mut u: f64) -> Option<(usize, f32)> {
        let (mut node, mut probability) = (self.nodes.first()?, 1.0);
        loop {
            let w = node.weights(from).to_array();
            let total = sum(w.into());
            if total <= 0.0 {
                return None;
            }
            let (child, rest) = choose(w, total, u);
            probability *= w[child] / total;
            u = rest;
            match node.child[child] {
                light if light & LEAF != 0 => return Some(((light & !LEAF) as usize, probability)),
                inner => node = &self.nodes[inner as usize],
            }
        }
    }

    /// About the irradiance, W/m², that all lights together could give at `from`.
    pub fn irradiance(&self, from: &LightReference) -> f32 {
        self.nodes.first().map_or(0.0, |root| sum(root.weights(from)))
    }

    /// Adds the node of `items` and all below it; `place` is where it hangs.
    fn add(&mut self, items: &mut [Item], place: u32, depth: u32) -> u32 {
        let id = self.nodes.len() as u32;
        self.parent.push(place);

        // Split in two, then the costlier parts, until there are four.
        let mut parts: Vec<(&mut [Item], LightBounds)> = vec![with_bounds(items)];
        while parts.len() < 4 {
            let cost = |b: &LightBounds| b.cost(b.bounds.size().length());
            let costliest = parts
                .iter()
                .enumerate()
                .filter(|(_, (part, _))| part.len() > 1)
                .max_by(|(_, a), (_, b)| cost(&a.1).total_cmp(&cost(&b.1)));
            let Some((i, _)) = costliest else { break };
            let (part, whole) = parts.remove(i);
            let middle = split(part, &whole, depth);
            let (low, high) = part.split_at_mut(middle);
            parts.insert(i, with_bounds(high));
            parts.insert(i, with_bounds(low));
        }

        let bounds: Vec<LightBounds> = parts.iter().map(|(_, b)| *b).collect();
        self.nodes.push(Node::new(&bounds));
        for (slot, (part, _)) in parts.into_iter().enumerate() {
            let place = 4 * id + slot as u32;
            let child = if let [item] = part {
                self.place[item.light as usize] = place;
                item.light | LEAF
            } else {
                self.add(part, place, depth + 2)
            };
            self.nodes[id as usize].child[slot] = child;
        }
        id
    }
}

/// The child that holds the number `u` when [0, 1) is divided by the weights, and where in its part `u` lies, in [0, 1).
fn choose(w: [f32; 4], total: f32, u: f64) -> (usize, f64) {
    let target = u * f64::from(total);
    let (mut below, mut last) = (0.0, 0);
    for (i, w) in w.into_iter().enumerate() {
        let w = f64::from(w);
        if w > 0.0 {
            last = i;
            if target < below + w {
                return (i, ((target - below) / w).clamp(0.0, 1.0 - f64::EPSILON));
            }
            below += w;
        }
    }
    // `total` was rounded up past the exact sum.
    (last, 1.0 - f64::EPSILON)
}

#[inline]
fn sum(w: Vec4) -> f32 {
    (w.x + w.y) + (w.z + w.w)
}

impl Node {
    fn new(bounds: &[LightBounds]) -> Self {
        let lane =
            |f: &dyn Fn(&LightBounds) -> f32, none: f32| Vec4::from_array(std::array::from_fn(|i| bounds.get(i).map_or(none, f)));
        let middle = |b: &LightBounds| b.bounds.center();
        let vector = |f: &dyn Fn(&LightBounds) -> Vec3| std::array::from_fn(|axis| lane(&|b| f(b)[axis], 0.0));
        Self {
            center: vector(&middle),
            r2: lane(&|b| 0.25 * b.bounds.size().length_squared(), 0.0),
            axis: vector(&|b| b.axis),
            cos_o: lane(&|b| b.cos_o, 1.0),
            sin_o: lane(&|b| safe_sqrt(1.0 - b.cos_o * b.cos_o), 0.0),
            cos_e: lane(&|b| b.cos_e, 1.0),
            intensity: lane(&|b| b.intensity, 0.0),
            child: [NONE; 4],
        }
    }

    /// w of the four children, W/m².
    #[inline]
    fn weights(&self, from: &LightReference) -> Vec4 {
        let (zero, one) = (Vec4::ZERO, Vec4::ONE);
        let tiny = Vec4::splat(1e-30);

        // From the lights to x: distance and direction.
        let d = [from.p.x - self.center[0], from.p.y - self.center[1], from.p.z - self.center[2]];
        let d2 = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).max(tiny);
        let inverse = d2.sqrt().recip();
        let dot = |v: [Vec4; 3]| (d[0] * v[0] + d[1] * v[1] + d[2] * v[2]) * inverse;

        // The angle that the sphere around the lights fills; the full circle from within.
        let sin2_b = self.r2 / d2;
        let inside = sin2_b.cmpge(one);
        let cos_b = Vec4::select(inside, -one, root(one - sin2_b));
        let sin_b = Vec4::select(inside, zero, sin2_b.min(one).sqrt());

        // θ - θo, then - θb, each not below zero.
        let cos = dot(self.axis);
        let (cos, sin) = minus((cos, root(one - cos * cos)), (self.cos_o, self.sin_o));
        let (cos_l, _) = minus((cos, sin), (cos_b, sin_b));

        // The same at x.
        let cos_x = if from.n == Vec3::ZERO {
            one
        } else {
            let cos = -dot([Vec4::splat(from.n.x), Vec4::splat(from.n.y), Vec4::splat(from.n.z)]);
            let cos = if from.one_sided { cos } else { cos.abs() };
            minus((cos, root(one - cos * cos)), (cos_b, sin_b)).0
        };

        let w = self.intensity * cos_l.max(zero) * cos_x.max(zero) / (d2 + self.r2);
        Vec4::select(cos_l.cmpgt(self.cos_e), w.min(Vec4::splat(1e30)), zero)
    }
}

/// √max(x, 0).
#[inline]
fn root(x: Vec4) -> Vec4 {
    x.max(Vec4::ZERO).sqrt()
}

/// Cosine and sine of max(0, a - b) for angles in [0, π] given by theirs.
#[inline]
fn minus(a: (Vec4, Vec4), b: (Vec4, Vec4)) -> (Vec4, Vec4) {
    let smaller = a.0.cmpge(b.0);
    let cos = a.0 * b.0 + a.1 * b.1;
    let sin = a.1 * b.0 - a.0 * b.1;
    (Vec4::select(smaller, Vec4::ONE, cos), Vec4::select(smaller, Vec4::ZERO, sin))
}

/// A light while the tree is built.
#[derive(Clone, Copy, Debug)]
struct Item {
    light: u32,
    bounds: LightBounds,
    center: Vec3,
}

impl Item {
    fn new(light: u32, bounds: LightBounds) -> Self {
        Self { light, bounds, center: bounds.bounds.center() }
    }
}

/// Bounds of lights being gathered in two rounds: first the middle of the normals, then how far they stray from it.
#[derive(Clone, Copy)]
struct Gathered {
    count: usize,
    bounds: LightBounds,
    axis_sum: Vec3,
}

impl Gathered {
    const NONE: Self = Self { count: 0, bounds: LightBounds::NONE, axis_sum: Vec3::ZERO };

    fn first(&mut self, b: &LightBounds) {
        self.count += 1;
        self.axis_sum += b.axis * b.intensity;
        self.bounds.bounds = self.bounds.bounds.union(b.bounds);
        self.bounds.cos_e = self.bounds.cos_e.min(b.cos_e);
        self.bounds.intensity += b.intensity;
    }

    fn settle(&mut self) {
        self.bounds.axis = self.axis_sum.normalize_or(Vec3::Z);
    }

    fn second(&mut self, b: &LightBounds) {
        let cos = self.bounds.axis.dot(b.axis).clamp(-1.0, 1.0);
        // cos(θ + θo), and -1 where the sum passes π; a little wider, for rounding.
        let reach = if b.cos_o == 1.0 {
            cos - 1e-6
        } else if cos <= -b.cos_o {
            -1.0
        } else {
            cos * b.cos_o - safe_sqrt(1.0 - cos * cos) * safe_sqrt(1.0 - b.cos_o * b.cos_o) - 1e-6
        };
        self.bounds.cos_o = self.bounds.cos_o.min(reach.max(-1.0));
    }
}

fn with_bounds(items: &mut [Item]) -> (&mut [Item], LightBounds) {
    if let [item] = items {
        let bounds = item.bounds;
        return (items, bounds);
    }
    let mut all = Gathered::NONE;
    items.iter().for_each(|i| all.first(&i.bounds));
    all.settle();
    items.iter().for_each(|i| all.second(&i.bounds));
    (items, all.bounds)
}

/// Reorders the lights into two parts of little cost [Conty Estevez, Kulla 2018, §4.4]: how many go into the first, at least one and not all.
fn split(items: &mut [Item], whole: &LightBounds, depth: u32) -> usize {
    let mut centers = items[0].center.extend(0.0).truncate();
    let mut range = (centers, centers);
    for item in items.iter() {
        centers = item.center;
        range = (range.0.min(centers), range.1.max(centers));
    }
    let size = range.1 - range.0;
    let best = if depth > MAX_UNEVEN_DEPTH || size.max_element() <= 0.0 { None } else { best_plane(items, whole, range.0, size) };
    let Some((axis, plane)) = best else {
        // By count, along the longest axis; lights at one place stay in their order.
        let axis = size.max_position();
        let middle = items.len() / 2;
        if size.max_element() > 0.0 {
            items.select_nth_unstable_by(middle, |a, b| a.center[axis].total_cmp(&b.center[axis]).then(a.light.cmp(&b.light)));
        }
        return middle;
    };
    partition(items, |item| bin(item.center[axis], range.0[axis], size[axis]) <= plane)
}

/// Moves the items for which `low` holds to the front, keeping the order among each kind; returns how many.
fn partition(items: &mut [Item], low: impl Fn(&Item) -> bool) -> usize {
    let (front, back): (Vec<Item>, Vec<Item>) = items.iter().partition(|item| low(item));
    let middle = front.len();
    items[..middle].copy_from_slice(&front);
    items[middle..].copy_from_slice(&back);
    middle
}

fn bin(x: f32, low: f32, size: f32) -> usize {
    ((BINS as f32 * ((x - low) / size)) as usize).min(BINS - 1)
}

/// The axis and the last bin of the first part of the cheapest split; `None` where no plane divides the lights.
fn best_plane(items: &[Item], whole: &LightBounds, low: Vec3, size: Vec3) -> Option<(usize, usize)> {
    let diagonal = whole.bounds.size();
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in (0..3).filter(|a| size[*a] > 0.0) {
        let mut bins = [Gathered::NONE; BINS];
        items.iter().for_each(|i| bins[bin(i.center[axis], low[axis], size[axis])].first(&i.bounds));
        bins.iter_mut().for_each(Gathered::settle);
        items.iter().for_each(|i| bins[bin(i.center[axis], low[axis], size[axis])].second(&i.bounds));

        // Long thin nodes are split across.
        let stretch = diagonal.max_element() / diagonal[axis].max(1e-6 * diagonal.max_element());
        let mut above = [(LightBounds::NONE, 0); BINS];
        for i in (0..BINS - 1).rev() {
            above[i] = (above[i + 1].0.union(&bins[i + 1].bounds), above[i + 1].1 + bins[i + 1].count);
        }
        let (mut below, mut count) = (LightBounds::NONE, 0);
        for (i, (rest, rest_count)) in above.iter().enumerate().take(BINS - 1) {
            below = below.union(&bins[i].bounds);
            count += bins[i].count;
            if count == 0 || *rest_count == 0 {
                continue;
            }
            let size = diagonal.length();
            let cost = stretch * (below.cost(size) + rest.cost(size));
            if best.is_none_or(|(least, _, _)| cost < least) {
                best = Some((cost, axis, i));
            }
        }
    }
    best.map(|(_, axis, plane)| (axis, plane))
}

#[cfg(test)]
#[path = "tree_tests.rs"]
mod tests;
