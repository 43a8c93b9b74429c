//! A tree over the lights of the scene: one is chosen with about the probability that its light deserves, at a cost that grows with the
//! logarithm of their number [Conty Estevez, Kulla 2018].
//!
//! ```text
//! P(light | x) = Π over its ancestors:  w(child) / Σ w(children)
//! w = (I_even + I_n E⁺(n̄·d, σₙ²)) · E⁺(n·d, σₓ²) / √(d² + σₓ²) / (d² + 2σ²)
//! E⁺(c, σ²) = (c + √(c² + 2σ²/π)) / 2  ≈  E[max(X, 0)]  for X of mean c and variance σ²
//! w = 0  where θ - θo - θb ≥ θe, or where all of it lies below x's horizon
//! ```
//!
//! | symbol | meaning |
//! | --- | --- |
//! | d | from x to the mean place of the node's lights, by intensity |
//! | σ², σₓ² | variance of their places, in all and along x's normal n |
//! | n̄, σₙ² | mean of their normals, and (1 - \|n̄\|²)/3, about its variance in any direction |
//! | I_even, I_n | intensity that is the same in all directions, and that falls with the cosine |
//! | θ, θo, θe | angle between the lights' axis and the way to x; of the cone of normals; up to which light leaves a normal |
//! | θb | half the angle that the sphere around them fills |
//!
//! Bounds alone, as in the paper, hold every node for as bright as its best light could be; the expectations say what it gives on the whole, and the
//! bounds are left to say where nothing can arrive. They alone make w zero, so every light that matters has its chance. E⁺ is exact for
//! far and for single flat lights, and 1/(d² + 2σ²) for a disk seen along its axis. Nodes have four children, whose weights are
//! worked out side by side; up to four lights are one node.

mod build;
#[cfg(test)]
mod tests;

use super::record::LightReference;
use etendue_numerics::{Vec3, Vec4};

/// Marks a child that is a light.
const LEAF: u32 = 1 << 31;
/// Marks the absence of a child, a parent or a light.
const NONE: u32 = u32::MAX;

/// Four children, side by side.
#[derive(Clone, Copy, Debug)]
struct Node {
    mean: [Vec4; 3],
    variance: [Vec4; 3],
    /// Squared radius of the sphere around them, about the mean.
    r2: Vec4,
    axis: [Vec4; 3],
    /// |n̄| and 2σₙ²/π.
    normal: Vec4,
    normal_spread: Vec4,
    cos_o: Vec4,
    sin_o: Vec4,
    cos_e: Vec4,
    even: Vec4,
    facing: Vec4,
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
    /// w of the four children, W/m².
    #[inline]
    fn weights(&self, from: &LightReference) -> Vec4 {
        let (zero, one) = (Vec4::ZERO, Vec4::ONE);
        let tiny = Vec4::splat(1e-30);

        // From the lights to x: distance and direction.
        let d = [from.p.x - self.mean[0], from.p.y - self.mean[1], from.p.z - self.mean[2]];
        let d2 = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).max(tiny);
        let inverse = d2.sqrt().recip();
        let cos = (d[0] * self.axis[0] + d[1] * self.axis[1] + d[2] * self.axis[2]) * inverse;

        // The angle that the sphere around the lights fills; the full circle from within.
        let sin2_b = self.r2 / d2;
        let inside = sin2_b.cmpge(one);
        let cos_b = Vec4::select(inside, -one, root(one - sin2_b));
        let sin_b = Vec4::select(inside, zero, sin2_b.min(one).sqrt());

        // Can light arrive? θ - θo, then - θb, each not below zero, against θe.
        let (cos_near, sin_near) = minus((cos, root(one - cos * cos)), (self.cos_o, self.sin_o));
        let (cos_least, _) = minus((cos_near, sin_near), (cos_b, sin_b));
        let mut arrives = cos_least.cmpgt(self.cos_e);

        // The mean of cosθₗ.
        let emitted = self.even + self.facing * positive_part(self.normal * cos, self.normal_spread);

        // The mean of cosθₓ.
        let received = if from.n == Vec3::ZERO {
            one
        } else {
            let n = [from.n.x, from.n.y, from.n.z];
            let height = -(n[0] * d[0] + n[1] * d[1] + n[2] * d[2]);
            let variance = n[0] * n[0] * self.variance[0] + n[1] * n[1] * self.variance[1] + n[2] * n[2] * self.variance[2];
            let mean = if from.one_sided {
                arrives &= height.cmpge(zero) | (height * height).cmplt(self.r2);
                positive_part(height, SPREAD * variance)
            } else {
                (height * height + SPREAD * variance).sqrt()
            };
            mean * (d2 + variance).sqrt().recip()
        };

        let spread = self.variance[0] + self.variance[1] + self.variance[2];
        let w = emitted * received / (d2 + 2.0 * spread);
        Vec4::select(arrives, w.min(Vec4::splat(1e30)), zero)
    }
}

/// 2/π: (2/π) σ² is the square of twice the mean of max(X, 0) for a normal X about 0.
const SPREAD: f32 = std::f32::consts::FRAC_2_PI;

/// E⁺: about the mean of max(X, 0), X of mean `c`; `t` = 2σ²/π. Above zero wherever t is.
#[inline]
fn positive_part(c: Vec4, t: Vec4) -> Vec4 {
    let s = (c * c + t).sqrt();
    // Without cancellation below zero.
    let above = 0.5 * (c + s);
    let below = 0.5 * t / (s - c).max(Vec4::splat(1e-30));
    Vec4::select(c.cmpge(Vec4::ZERO), above, below)
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
