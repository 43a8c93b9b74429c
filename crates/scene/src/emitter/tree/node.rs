//! A node of the light tree: what it knows of its children, and how likely each of them is. Plain loops over the children, which are side by side:
//! inlined into a [`wide::Job`] they are one vector each.

use super::WIDTH;
use crate::emitter::record::LightReference;
use etendue_numerics::{Vec3, wide};

/// A number of each child.
pub(super) type Lane<T = f32> = [T; WIDTH];

/// Children, side by side.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Node {
    pub mean: [Lane; 3],
    /// σ².
    pub spread: Lane,
    /// 1/r, of the sphere around them, about the mean.
    pub inverse_r: Lane,
    /// n̄ and 2σₙ²/π.
    pub normal: [Lane; 3],
    pub normal_spread: Lane,
    pub even: Lane,
    pub facing: Lane,
    /// A node, perhaps with [`super::TINTED`], or a light and [`super::LEAF`], or [`super::NONE`].
    pub child: Lane<u32>,
}

/// Of the children the cone around their axes and how far from an axis light goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cones {
    pub axis: [Lane; 3],
    pub cos_o: Lane,
    pub sin_o: Lane,
    pub cos_e: Lane,
    /// r².
    pub r2: Lane,
}

/// 2/π: (2/π) σ² is the square of twice the mean of max(X, 0) for a normal X about 0.
pub(super) const SPREAD: f32 = std::f32::consts::FRAC_2_PI;

impl Node {
    /// Asks for its memory, a cache line after the other.
    #[inline(always)]
    pub fn fetch(&self) {
        for lane in [&self.mean[0], &self.mean[2], &self.inverse_r, &self.normal[1], &self.normal_spread, &self.facing] {
            wide::fetch(lane);
        }
    }

    /// w of the children, W/m², as if there were no spots.
    #[inline(always)]
    pub fn weights(&self, from: &LightReference) -> Lane {
        // Vectors from the lights to x: their squares, and along the normals.
        let [mut d2, mut cos, mut height] = [[0.0; WIDTH]; 3];
        for i in 0..WIDTH {
            let [x, y, z] = self.way_from_mean(from, i);
            d2[i] = larger(x * x + y * y + z * z, 1e-18);
            cos[i] = x * self.normal[0][i] + y * self.normal[1][i] + z * self.normal[2][i];
            height[i] = x * -from.n.x - y * from.n.y - z * from.n.z;
        }

        // d cosθₓ, its mean.
        let mut received = [0.0; WIDTH];
        if from.n == Vec3::ZERO {
            for i in 0..WIDTH {
                received[i] = (d2[i] + self.spread[i] * (1.0 / 3.0)).sqrt();
            }
        } else if from.one_sided {
            for i in 0..WIDTH {
                let (t, h) = (self.spread[i] * (SPREAD / 3.0), height[i]);
                let above = (h >= 0.0) | (h.abs() * self.inverse_r[i] < 1.0);
                let mean = larger(0.5 * (h + (h * h + t).sqrt()), LEAST * t * self.inverse_r[i]);
                received[i] = if above { mean } else { 0.0 };
            }
        } else {
            for i in 0..WIDTH {
                received[i] = (height[i] * height[i] + self.spread[i] * (SPREAD / 3.0)).sqrt();
            }
        }

        let mut w = [0.0; WIDTH];
        for i in 0..WIDTH {
            let d2_mean = d2[i] + self.spread[i] * (1.0 / 3.0);
            let (d, t, c) = (d2_mean.sqrt(), self.normal_spread[i], cos[i]);
            // I cosθₗ d, its mean.
            let facing = larger(0.5 * (c + (c * c + t * d2_mean).sqrt()), LEAST * t * d);
            let emitted = self.even[i] * d + self.facing[i] * facing;
            w[i] = smaller(emitted * received[i] / (d2_mean * (d2[i] + 2.0 * self.spread[i])), 1e30);
        }
        w
    }

    #[inline(always)]
    fn way_from_mean(&self, from: &LightReference, i: usize) -> [f32; 3] {
        [from.p.x - self.mean[0][i], from.p.y - self.mean[1][i], from.p.z - self.mean[2][i]]
    }
}

impl Cones {
    /// The weights `w` of `node`'s children, zero where no light arrives: θ - θo, then - θb, each not below zero, against θe.
    #[inline(always)]
    pub fn reached(&self, mut w: Lane, node: &Node, from: &LightReference) -> Lane {
        for (i, w) in w.iter_mut().enumerate() {
            let [x, y, z] = node.way_from_mean(from, i);
            let d2 = larger(x * x + y * y + z * z, 1e-30);
            let cos = (x * self.axis[0][i] + y * self.axis[1][i] + z * self.axis[2][i]) / d2.sqrt();

            // The angle that the sphere around the lights fills; the full circle from within.
            let sin2_b = self.r2[i] / d2;
            let inside = sin2_b >= 1.0;
            let cos_b = if inside { -1.0 } else { root(1.0 - sin2_b) };
            let sin_b = if inside { 0.0 } else { root(sin2_b) };

            let near = minus((cos, root(1.0 - cos * cos)), (self.cos_o[i], self.sin_o[i]));
            let (cos_least, _) = minus(near, (cos_b, sin_b));
            *w = if cos_least > self.cos_e[i] { *w } else { 0.0 };
        }
        w
    }
}

/// E⁺ = t/2 / (|c| + √(c² + t)) below zero, where the sum cancels, is more than this part of t / |c|.
const LEAST: f32 = 0.2;

/// The larger number, b if there is none: one instruction.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// √max(x, 0).
#[inline(always)]
fn root(x: f32) -> f32 {
    larger(x, 0.0).sqrt()
}

/// Cosine and sine of max(0, a - b) for angles in [0, π] given by theirs.
#[inline(always)]
fn minus(a: (f32, f32), b: (f32, f32)) -> (f32, f32) {
    let (cos, sin) = (a.0 * b.0 + a.1 * b.1, a.1 * b.0 - a.0 * b.1);
    let less = a.0 >= b.0;
    (if less { 1.0 } else { cos }, if less { 0.0 } else { sin })
}
