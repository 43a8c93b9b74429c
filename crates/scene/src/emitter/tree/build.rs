//! How the tree over the lights is built: top down, each set of lights in two where that is cheapest [Conty Estevez, Kulla 2018, §4.4], again and
//! again for nodes of eight.
//!
//! ```text
//! cost of a split = s Σ over both parts of I M_Ω M_A,   s = longest side of the box / its side along the split
//! ```
//!
//! Once on the way down, where few enough lights are left, those of different tint are told apart. Places and normals are gathered in two rounds, first the mean, then how far they stray from it, in the order in which the lights come: the
//! same lights give the same tree.

use super::node::{Cones, Lane, Node, SPREAD};
use super::{LEAF, LightTree, NONE, TINTED, WIDTH};
use crate::emitter::extent::LightBounds;
use etendue_numerics::math::safe_sqrt;
use etendue_numerics::{DVec3, Vec3};

/// Bins along an axis when a set of lights is split.
const BINS: usize = 12;
/// Splits in a row after which lights are halved by count, so that no arrangement makes a deep tree.
const MAX_UNEVEN_DEPTH: u32 = 24;
/// So many lights are divided by tint: few enough to be close together, enough for several of each.
const TO_TINT: std::ops::RangeInclusive<usize> = 4 * WIDTH..=32 * WIDTH;
/// Tints that differ by less are one.
const SAME_TINT: f32 = 0.02;

impl LightTree {
    /// The tree of the lights `bounds`; those of no intensity are never chosen. `tints` are numbers for their colours, the less apart the more
    /// alike they are.
    pub(in crate::emitter) fn new(bounds: &[LightBounds], tints: &[f32]) -> Self {
        let lit = |b: &LightBounds| b.intensity > 0.0 && b.intensity.is_finite();
        let mut items: Vec<Item> =
            bounds.iter().enumerate().filter(|(_, b)| lit(b)).map(|(i, b)| Item::new(i as u32, *b, tints[i])).collect();
        let mut tree = Self { place: vec![NONE; bounds.len()], ..Self::default() };
        if !items.is_empty() {
            tree.root = tree.add(&mut items, NONE, 0, true);
        }
        if items.iter().all(|i| i.bounds.cos_e <= 0.0) {
            tree.cones.clear();
        }
        tree
    }

    /// Adds the node of `items` and all below it; `place` is where it hangs. `many_tints` where tints were not told apart above.
    fn add(&mut self, items: &mut [Item], place: u32, depth: u32, many_tints: bool) -> u32 {
        let id = self.nodes.len() as u32;
        self.parent.push(place);
        let tinted = many_tints && TO_TINT.contains(&items.len()) && sort_by_tint(items);

        // Split in two, then the costlier parts, until there are enough.
        let mut parts: Vec<(&mut [Item], Part)> = if items.len() <= WIDTH {
            items.chunks_mut(1).map(|item| (Part::of(item), item)).map(|(part, item)| (item, part)).collect()
        } else if tinted {
            tints(items).into_iter().map(|items| (Part::of(items), items)).map(|(part, items)| (items, part)).collect()
        } else {
            let whole = Part::of(items);
            vec![(items, whole)]
        };
        while parts.len() < WIDTH && !tinted {
            let cost = |part: &Part| part.bounds.cost(part.bounds.bounds.size().length());
            let divisible = parts.iter().enumerate().filter(|(_, (_, part))| part.count > 1);
            let Some((i, _)) = divisible.max_by(|(_, a), (_, b)| cost(&a.1).total_cmp(&cost(&b.1))) else { break };
            let (items, part) = parts.remove(i);
            let middle = split(items, &part.bounds, depth);
            let (low, high) = items.split_at_mut(middle);
            let halves = (Part::of(low), Part::of(high));
            parts.insert(i, (high, halves.1));
            parts.insert(i, (low, halves.0));
        }

        let known: Vec<Part> = parts.iter().map(|(_, part)| *part).collect();
        self.nodes.push(Node::new(&known));
        self.cones.push(Cones::new(&known));
        for (slot, (items, _)) in parts.into_iter().enumerate() {
            let place = WIDTH as u32 * id + slot as u32;
            let child = if let [item] = items {
                self.place[item.light as usize] = place;
                item.light | LEAF
            } else {
                self.add(items, place, depth + WIDTH.ilog2(), many_tints && !tinted)
            };
            self.nodes[id as usize].child[slot] = child;
        }
        if tinted { id | TINTED } else { id }
    }
}

/// Puts lights in the order of their tints; whether there is more than one.
fn sort_by_tint(items: &mut [Item]) -> bool {
    items.sort_by(|a, b| a.tint.total_cmp(&b.tint));
    items.windows(2).any(|pair| differ(&pair[0], &pair[1]))
}

fn differ(a: &Item, b: &Item) -> bool {
    (a.tint - b.tint).abs() >= SAME_TINT
}

/// Lights in the order of their tints, divided where these differ, or evenly where that makes too many parts.
fn tints(mut items: &mut [Item]) -> Vec<&mut [Item]> {
    let steps: Vec<usize> = (1..items.len()).filter(|i| differ(&items[i - 1], &items[*i])).collect();
    let even = (1..WIDTH).map(|i| i * items.len() / WIDTH).collect();
    let cuts = if steps.len() < WIDTH { steps } else { even };
    let mut parts = Vec::new();
    for cut in cuts.into_iter().rev() {
        let (low, high) = items.split_at_mut(cut);
        parts.push(high);
        items = low;
    }
    parts.push(items);
    parts.reverse();
    parts
}

/// One number of each part; `none` where there are fewer than may be.
fn lane(parts: &[Part], none: f32, of: impl Fn(&Part) -> f32) -> Lane {
    std::array::from_fn(|i| parts.get(i).map_or(none, &of))
}

/// One vector of each part.
fn lanes(parts: &[Part], of: impl Fn(&Part) -> Vec3) -> [Lane; 3] {
    std::array::from_fn(|axis| lane(parts, 0.0, |p| of(p)[axis]))
}

impl Node {
    fn new(parts: &[Part]) -> Self {
        Self {
            mean: lanes(parts, |p| p.mean),
            spread: lane(parts, 0.0, |p| p.variance),
            inverse_r: lane(parts, 0.0, |p| p.radius_squared().sqrt().recip().min(MAX_INVERSE)),
            normal: lanes(parts, |p| p.normal),
            normal_spread: lane(parts, 0.0, |p| SPREAD * p.normal_variance()),
            even: lane(parts, 0.0, |p| p.bounds.even),
            facing: lane(parts, 0.0, |p| p.bounds.intensity - p.bounds.even),
            child: [NONE; WIDTH],
        }
    }
}

/// 1/r of points.
const MAX_INVERSE: f32 = 1e18;

impl Cones {
    fn new(parts: &[Part]) -> Self {
        Self {
            axis: lanes(parts, |p| p.bounds.axis),
            cos_o: lane(parts, 1.0, |p| p.bounds.cos_o),
            sin_o: lane(parts, 0.0, |p| safe_sqrt(1.0 - p.bounds.cos_o * p.bounds.cos_o)),
            cos_e: lane(parts, 1.0, |p| p.bounds.cos_e),
            r2: lane(parts, 0.0, Part::radius_squared),
        }
    }
}

/// A light while the tree is built.
#[derive(Clone, Copy, Debug)]
struct Item {
    light: u32,
    bounds: LightBounds,
    center: Vec3,
    tint: f32,
}

impl Item {
    fn new(light: u32, bounds: LightBounds, tint: f32) -> Self {
        Self { light, bounds, center: bounds.center, tint }
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
        self.bounds.even += b.even;
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

/// A set of lights and what is known of it as a whole.
#[derive(Clone, Copy)]
struct Part {
    count: usize,
    bounds: LightBounds,
    /// Mean place, by intensity.
    mean: Vec3,
    /// Variance of places, in all.
    variance: f32,
    /// Mean normal of the light that follows the cosine.
    normal: Vec3,
}

impl Part {
    fn of(items: &[Item]) -> Self {
        // Of a single light: spread evenly over its box.
        let own_variance = |b: &LightBounds| b.bounds.size().length_squared() / 12.0;
        if let [item] = items {
            let b = item.bounds;
            return Self { count: 1, bounds: b, mean: item.center, variance: own_variance(&b), normal: b.axis };
        }
        let mut all = Gathered::NONE;
        let (mut mean, mut weight, mut facing) = (DVec3::ZERO, 0.0, DVec3::ZERO);
        for item in items {
            let b = &item.bounds;
            all.first(b);
            mean += item.center.as_dvec3() * f64::from(b.intensity);
            facing += b.axis.as_dvec3() * f64::from(b.intensity - b.even);
            weight += f64::from(b.intensity);
        }
        all.settle();
        let mean = (mean / weight).as_vec3();
        let mut variance = 0.0;
        for item in items {
            let b = &item.bounds;
            all.second(b);
            variance += f64::from((item.center - mean).length_squared() + own_variance(b)) * f64::from(b.intensity);
        }
        let bounds = all.bounds;
        let normal = (facing / f64::from((bounds.intensity - bounds.even).max(1e-30))).as_vec3().clamp_length_max(1.0);
        // Faint lights far from the mean count for little; they must not count for nothing.
        let least = 1e-3 * bounds.bounds.size().length_squared();
        Self { count: items.len(), bounds, mean, variance: ((variance / weight) as f32).max(least), normal }
    }

    /// σₙ², not down to zero: a few of many normals may differ.
    fn normal_variance(&self) -> f32 {
        if self.count == 1 { 0.0 } else { ((1.0 - self.normal.length_squared()) / 3.0).max(1e-4) }
    }

    /// Squared radius of the sphere about the mean that holds the box.
    fn radius_squared(&self) -> f32 {
        let b = &self.bounds.bounds;
        let reach = (self.mean - b.min).max(b.max - self.mean);
        reach.length_squared() * (1.0 + 1e-5)
    }
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
