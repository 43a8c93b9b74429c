//! A tree over the lights of the scene: one is chosen with about the probability that its light deserves, at a cost that grows with the
//! logarithm of their number [Conty Estevez, Kulla 2018].
//!
//! ```text
//! P(light | x) = Π over its ancestors:  w(child) / Σ w(children)
//! w = (I_even + I_n E⁺(n̄·d/|d|, σₙ²)) · E⁺(n·d, σ²/3) / √(d² + σ²/3) / (d² + 2σ²)
//! E⁺(c, σ²) = (c + √(c² + 2σ²/π)) / 2  ≈  E[max(X, 0)]  for X of mean c and variance σ²
//! w = 0  where all of it lies below x's horizon, or, of spots, where θ - θo - θb ≥ θe
//! ```
//!
//! | symbol | meaning |
//! | --- | --- |
//! | d | from x to the mean place of the node's lights, by intensity |
//! | σ² | variance of their places, a third of it along x's normal n |
//! | n̄, σₙ² | mean of their normals, and (1 - \|n̄\|²)/3, about its variance in any direction |
//! | I_even, I_n | intensity that is the same in all directions, and that falls with the cosine |
//! | θ, θo, θe | angle between the lights' axis and the way to x; of the cone of normals; up to which light leaves a normal |
//! | θb | half the angle that the sphere around them fills |
//!
//! Bounds alone, as in the paper, hold every node for as bright as its best light could be; the expectations say what it gives on the whole, and
//! bounds are left to say where nothing can arrive. They alone make w zero, so every light that matters has its chance. E⁺ is exact for
//! far and for single flat lights, and 1/(d² + 2σ²) for a disk seen along its axis. Up to eight lights are one node.
//!
//! Where lights of several colours mingle, neighbours in the tree are no neighbours in colour, and stratified numbers are no help against
//! coloured noise. So some dozens of lights that are close together are first divided by their tint, with a number of its own: over the samples
//! of a pixel each colour then gets its share.
//!
//! A walk down the tree waits for one node after the other: few levels of wide nodes, and few bytes a child, are what makes it fast.

mod build;
#[cfg(test)]
mod tests;

use super::record::LightReference;
use etendue_numerics::math::ONE_MINUS_EPSILON;
use etendue_numerics::{Vec3, Vec4};

/// Marks a child that is a light.
const LEAF: u32 = 1 << 31;
/// Marks a child that is a node whose children differ in tint.
const TINTED: u32 = 1 << 30;
/// Marks the absence of a child, a parent or a light.
const NONE: u32 = u32::MAX;

/// Children of a node.
const WIDTH: usize = 4 * BLOCKS;
/// Children are kept by fours.
const BLOCKS: usize = 2;

/// Four children, side by side.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Block {
    mean: [Vec4; 3],
    /// σ².
    spread: Vec4,
    /// Squared radius of the sphere around them, about the mean.
    r2: Vec4,
    /// n̄ and 2σₙ²/π.
    normal: [Vec4; 3],
    normal_spread: Vec4,
    even: Vec4,
    facing: Vec4,
    /// A node, perhaps with [`TINTED`], or a light and [`LEAF`], or [`NONE`].
    child: [u32; 4],
}

/// Of four children the cone around their axes and how far from an axis light goes.
#[derive(Clone, Copy, Debug)]
struct Cones {
    axis: [Vec4; 3],
    cos_o: Vec4,
    sin_o: Vec4,
    cos_e: Vec4,
}

/// The tree.
#[derive(Clone, Debug, Default)]
pub(super) struct LightTree {
    /// The root as if it were a child.
    root: u32,
    nodes: Vec<[Block; BLOCKS]>,
    /// For each node, if there are spots at all: of other lights the cosine is bound enough.
    cones: Vec<[Cones; BLOCKS]>,
    /// For each node its place in its parent, [`WIDTH`] · parent + child; [`NONE`] for the root.
    parent: Vec<u32>,
    /// For each light the place that holds it; [`NONE`] for lights that are dark.
    place: Vec<u32>,
}

impl LightTree {
    /// Whether no light can be chosen.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The probability of [`LightTree::sample`] choosing light `i` at `from`.
    pub fn probability(&self, from: &LightReference, i: usize) -> f32 {
        let mut place = self.place.get(i).copied().unwrap_or(NONE);
        let mut probability = if place == NONE { 0.0 } else { 1.0 };
        while place != NONE {
            let (node, child) = (place as usize / WIDTH, place as usize % WIDTH);
            let w = self.weights(node, from);
            let total = sum(&w);
            let share = w[child / 4][child % 4] / total;
            probability *= if total > 0.0 { share } else { 0.0 };
            place = self.parent[node];
        }
        probability
    }

    /// A light by the number `u` in [0, 1), and its probability; `None` where no light can reach `from`. `tint` in [0, 1) decides between
    /// colours; what is left of it is uniform again.
    pub fn sample(&self, from: &LightReference, mut u: f64, tint: &mut f32) -> Option<(usize, f32)> {
        if self.nodes.is_empty() {
            return None;
        }
        let (mut link, mut probability) = (self.root, 1.0);
        while link & LEAF == 0 {
            let node = (link & !TINTED) as usize;
            let w = self.weights(node, from);
            let total = sum(&w);
            if total <= 0.0 {
                return None;
            }
            let child = if link & TINTED == 0 {
                let (child, rest) = choose(&w, total, u);
                u = rest;
                child
            } else {
                let (child, rest) = choose(&w, total, f64::from(*tint));
                *tint = (rest as f32).min(ONE_MINUS_EPSILON);
                child
            };
            probability *= w[child / 4][child % 4] / total;
            link = self.nodes[node][child / 4].child[child % 4];
        }
        Some(((link & !LEAF) as usize, probability))
    }

    /// About the irradiance, W/m², that all lights together could give at `from`.
    pub fn irradiance(&self, from: &LightReference) -> f32 {
        if self.nodes.is_empty() { 0.0 } else { sum(&self.weights(0, from)) }
    }

    /// w of a node's children, W/m².
    #[inline]
    fn weights(&self, node: usize, from: &LightReference) -> [Vec4; BLOCKS] {
        let mut w = [Vec4::ZERO; BLOCKS];
        for (w, block) in w.iter_mut().zip(&self.nodes[node]) {
            *w = block.weights(from);
        }
        if let Some(cones) = self.cones.get(node) {
            for ((w, block), cones) in w.iter_mut().zip(&self.nodes[node]).zip(cones) {
                *w = cones.reached(*w, block, from);
            }
        }
        w
    }
}

/// The child that holds the number `u` when [0, 1) is divided by the weights, and where in its part `u` lies, in [0, 1).
#[inline]
fn choose(w: &[Vec4; BLOCKS], total: f32, u: f64) -> (usize, f64) {
    let target = u * f64::from(total);
    let (mut below, mut last) = (0.0, 0);
    for i in 0..WIDTH {
        let w = f64::from(w[i / 4][i % 4]);
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
fn sum(w: &[Vec4; BLOCKS]) -> f32 {
    let mut all = w[0];
    w[1..].iter().for_each(|w| all += *w);
    (all.x + all.y) + (all.z + all.w)
}

impl Block {
    /// w of the four children, W/m², as if there were no spots.
    #[inline(always)]
    fn weights(&self, from: &LightReference) -> Vec4 {
        // From the lights to x.
        let d = self.way_from_mean(from);
        let d2 = dot(&d, &d).max(Vec4::splat(1e-30));

        // The mean of cosθₗ.
        let cos = dot(&d, &self.normal) / d2.sqrt();
        let emitted = self.even + self.facing * positive_part(cos, self.normal_spread);

        // The mean of cosθₓ.
        let own = self.spread * (1.0 / 3.0);
        let received = if from.n == Vec3::ZERO {
            Vec4::ONE
        } else {
            let height = d[0] * -from.n.x - d[1] * from.n.y - d[2] * from.n.z;
            let mean = if from.one_sided {
                let above = height.cmpge(Vec4::ZERO) | (height * height).cmplt(self.r2);
                Vec4::select(above, positive_part(height, SPREAD * own), Vec4::ZERO)
            } else {
                (height * height + SPREAD * own).sqrt()
            };
            mean / (d2 + own).sqrt()
        };
        (emitted * received / (d2 + 2.0 * self.spread)).min(Vec4::splat(1e30))
    }

    #[inline(always)]
    fn way_from_mean(&self, from: &LightReference) -> [Vec4; 3] {
        [from.p.x - self.mean[0], from.p.y - self.mean[1], from.p.z - self.mean[2]]
    }
}

impl Cones {
    /// The weights `w` of `block`, zero where no light arrives: θ - θo, then - θb, each not below zero, against θe.
    fn reached(&self, w: Vec4, block: &Block, from: &LightReference) -> Vec4 {
        let d = block.way_from_mean(from);
        let d2 = dot(&d, &d).max(Vec4::splat(1e-30));
        let cos = dot(&d, &self.axis) / d2.sqrt();

        // The angle that the sphere around the lights fills; the full circle from within.
        let sin2_b = block.r2 / d2;
        let inside = sin2_b.cmpge(Vec4::ONE);
        let cos_b = Vec4::select(inside, -Vec4::ONE, root(1.0 - sin2_b));
        let sin_b = Vec4::select(inside, Vec4::ZERO, sin2_b.min(Vec4::ONE).sqrt());

        let near = minus((cos, root(1.0 - cos * cos)), (self.cos_o, self.sin_o));
        let (cos_least, _) = minus(near, (cos_b, sin_b));
        Vec4::select(cos_least.cmpgt(self.cos_e), w, Vec4::ZERO)
    }
}

/// 2/π: (2/π) σ² is the square of twice the mean of max(X, 0) for a normal X about 0.
const SPREAD: f32 = std::f32::consts::FRAC_2_PI;

/// E⁺: about the mean of max(X, 0), X of mean `c`; `t` = 2σ²/π. Above zero wherever t is.
#[inline(always)]
fn positive_part(c: Vec4, t: Vec4) -> Vec4 {
    // Without cancellation below zero.
    let s = c.abs() + (c * c + t).sqrt();
    Vec4::select(c.cmpge(Vec4::ZERO), 0.5 * s, 0.5 * t / s.max(Vec4::splat(1e-30)))
}

#[inline(always)]
fn dot(a: &[Vec4; 3], b: &[Vec4; 3]) -> Vec4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
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
