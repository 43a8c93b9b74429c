//! A tree over the lights of the scene: one is chosen with about the probability that its light deserves, at a cost that grows with the
//! logarithm of their number [Conty Estevez, Kulla 2018].
//!
//! ```text
//! P(light | x) = Π over its ancestors:  w(child) / Σ w(children)
//! w = (I_even + I_n E⁺(n̄·d/D, σₙ²)) · E⁺(n·d, σ²/3)/D / (d² + 2σ²),    D² = d² + σ²/3
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
//! A walk down the tree waits for one node after the other: few levels of wide nodes are what makes it fast. Many walks go down together, a
//! level at a time, and ask for the memory of their next nodes ahead ([`LightTree::descend`]).

mod build;
mod node;
#[cfg(test)]
mod tests;

use super::record::LightReference;
use etendue_numerics::math::ONE_MINUS_EPSILON;
use etendue_numerics::wide::{self, Width};
use node::{Cones, Lane, Node};

/// Marks a child that is a light.
const LEAF: u32 = 1 << 31;
/// Marks a child that is a node whose children differ in tint.
const TINTED: u32 = 1 << 30;
/// Marks the absence of a child, a parent or a light.
const NONE: u32 = u32::MAX;
/// Marks a descent that never was one.
const ELSEWHERE: u32 = u32::MAX - 1;

/// Children of a node.
const WIDTH: usize = 8;

/// The tree.
#[derive(Clone, Debug, Default)]
pub(super) struct LightTree {
    /// The root as if it were a child.
    root: u32,
    nodes: Vec<Node>,
    /// For each node, if there are spots at all: of other lights the cosine is bound enough.
    cones: Vec<Cones>,
    /// For each node its place in its parent, [`WIDTH`] · parent + child; [`NONE`] for the root.
    parent: Vec<u32>,
    /// For each light the place that holds it; [`NONE`] for lights that are dark.
    place: Vec<u32>,
}

/// A walk down the tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Descent<'a> {
    /// Where light is asked for.
    pub from: &'a LightReference,
    /// The number in [0, 1) that decides; what is left of it.
    pub u: f64,
    /// The number in [0, 1) that decides between colours; what is left of it is uniform again.
    pub tint: f32,
    /// That it came here, times what it started with.
    pub probability: f32,
    /// Where it is: a node, or a light with [`LEAF`]; [`NONE`] where no light can reach `from`, or [`ELSEWHERE`].
    link: u32,
}

impl<'a> Descent<'a> {
    /// None: the choice fell on what is not in the tree, with the probability `probability`.
    pub fn elsewhere(from: &'a LightReference, u: f64, probability: f32) -> Self {
        Self { from, u, tint: 0.0, probability, link: ELSEWHERE }
    }

    /// Whether the choice fell on what is not in the tree.
    pub fn is_elsewhere(&self) -> bool {
        self.link == ELSEWHERE
    }

    /// The light that it found.
    pub fn light(&self) -> Option<usize> {
        (self.link < ELSEWHERE).then_some((self.link & !LEAF) as usize)
    }
}

impl LightTree {
    /// Whether no light can be chosen.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// A descent about to begin, for [`LightTree::descend`].
    pub fn descent<'a>(&self, from: &'a LightReference, u: f64, tint: f32, probability: f32) -> Descent<'a> {
        let link = if self.is_empty() { NONE } else { self.root };
        Descent { from, u, tint, probability, link }
    }

    /// Descents to their ends.
    pub fn descend(&self, descents: &mut [Descent<'_>]) {
        self.descend_at(Width::best(), descents);
    }

    fn descend_at(&self, width: Width, descents: &mut [Descent<'_>]) {
        width.run(Descend { tree: self, descents });
    }

    /// The probability of [`LightTree::descend`] choosing light `i` at `from`.
    pub fn probability(&self, from: &LightReference, i: usize) -> f32 {
        let place = self.place.get(i).copied().unwrap_or(NONE);
        if place == NONE { 0.0 } else { wide::widest(Climb { tree: self, from, place }) }
    }

    /// About the irradiance, W/m², that all lights together could give at `from`.
    pub fn irradiance(&self, from: &LightReference) -> f32 {
        if self.is_empty() { 0.0 } else { wide::widest(Irradiance { tree: self, from }) }
    }

    /// w of a node's children, W/m².
    #[inline(always)]
    fn weights(&self, node: usize, from: &LightReference) -> Lane {
        let w = self.nodes[node].weights(from);
        match self.cones.get(node) {
            Some(cones) => cones.reached(w, &self.nodes[node], from),
            None => w,
        }
    }

    /// One level down.
    #[inline(always)]
    fn step(&self, d: &mut Descent<'_>) {
        let node = (d.link & !TINTED) as usize;
        let is_tinted = d.link & TINTED != 0;
        let w = self.weights(node, d.from);
        let Some((child, share, rest)) = choose(&w, if is_tinted { f64::from(d.tint) } else { d.u }) else {
            d.link = NONE;
            return;
        };
        if is_tinted {
            d.tint = (rest as f32).min(ONE_MINUS_EPSILON);
        } else {
            d.u = rest;
        }
        d.probability *= share;
        d.link = self.nodes[node].child[child];
        if d.link & LEAF == 0 {
            self.nodes[(d.link & !TINTED) as usize].fetch();
        }
    }
}

struct Descend<'t, 'd, 'a> {
    tree: &'t LightTree,
    descents: &'d mut [Descent<'a>],
}

impl wide::Job for Descend<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut some_go_on = true;
        while some_go_on {
            some_go_on = false;
            for d in self.descents.iter_mut().filter(|d| d.link & LEAF == 0) {
                self.tree.step(d);
                some_go_on |= d.link & LEAF == 0;
            }
        }
    }
}

/// From a light's place to the root.
struct Climb<'a> {
    tree: &'a LightTree,
    from: &'a LightReference,
    place: u32,
}

impl wide::Job for Climb<'_> {
    type Output = f32;

    #[inline(always)]
    fn run(mut self) -> f32 {
        let mut probability = 1.0;
        while self.place != NONE {
            let (node, child) = (self.place as usize / WIDTH, self.place as usize % WIDTH);
            let w = self.tree.weights(node, self.from);
            let total = sums(&w)[WIDTH];
            probability *= if total > 0.0 { share(w[child], total) } else { 0.0 };
            self.place = self.tree.parent[node];
        }
        probability
    }
}

struct Irradiance<'a> {
    tree: &'a LightTree,
    from: &'a LightReference,
}

impl wide::Job for Irradiance<'_> {
    type Output = f32;

    #[inline(always)]
    fn run(self) -> f32 {
        sums(&self.tree.weights(0, self.from))[WIDTH] as f32
    }
}

/// The child that holds the number `u` when [0, 1) is divided by the weights, its part, and where in that `u` lies, in [0, 1).
#[inline(always)]
fn choose(w: &Lane, u: f64) -> Option<(usize, f32, f64)> {
    let below = sums(w);
    let total = below[WIDTH];
    if total <= 0.0 {
        return None;
    }
    let target = u * total;
    let mut child = 0;
    for end in &below[1..] {
        child += usize::from(*end <= target);
    }
    if child == WIDTH {
        // The product was rounded up.
        child = (0..WIDTH).rfind(|i| w[*i] > 0.0)?;
    }
    let rest = (target - below[child]) / f64::from(w[child]);
    Some((child, share(w[child], total), rest.clamp(0.0, 1.0 - f64::EPSILON)))
}

#[inline(always)]
fn share(w: f32, total: f64) -> f32 {
    (f64::from(w) / total) as f32
}

/// The sums of the first 0, 1, … weights.
#[inline(always)]
fn sums(w: &Lane) -> [f64; WIDTH + 1] {
    let mut sums = [0.0; WIDTH + 1];
    for i in 0..WIDTH {
        sums[i + 1] = sums[i] + f64::from(w[i]);
    }
    sums
}
