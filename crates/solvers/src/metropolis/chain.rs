//! A Markov chain over paths.

use super::lengths::Length;
use super::mutation::{Mutation, fill, room};
use super::space::{Measured, Point, Scratch, Space};
use crate::transport::slot;
use etendue_film::Splat;
use etendue_numerics::{Dim, Primary, Sampler, SequenceKind, Spectrum, Vec2};
use serde::{Deserialize, Serialize};

/// A chain between two steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chain {
    edges: u32,
    open: bool,
    vertices: u32,
    /// Of the chain's own numbers.
    seed: u64,
    /// Steps so far.
    steps: u32,
    /// Where the numbers come from that the vector has no room for.
    beyond: Origin,
    /// x.
    vector: Vec<[f32; 2]>,
    /// h(x) and f(x).
    measured: Measured,
}

/// The point set from which all numbers of a path were drawn last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Origin {
    /// Path i of n of a bootstrap.
    Bootstrap {
        /// Its seed.
        seed: u64,
        /// i.
        i: u32,
        /// n.
        n: u32,
    },
    /// The chain's large step of that number.
    Step(u32),
}

/// What chains bring to the film.
#[derive(Clone, Debug, Default)]
pub struct Output {
    /// Light.
    pub splats: Vec<Splat>,
}

impl Chain {
    /// A chain about to set out from path i of a bootstrap, which is still to be measured.
    pub fn new((length, vertices): (Length, u32), seed: u64, from: Origin) -> Self {
        let Length { edges, open } = length;
        let mut chain =
            Self { edges, open, vertices, seed, steps: 0, beyond: from, vector: Vec::new(), measured: Measured::default() };
        let mut vector = vec![Vec2::ZERO; room(vertices)];
        fill(&mut vector, vertices, &chain.numbers(from));
        chain.keep(&vector);
        chain
    }

    /// Replays the first path; its f.
    pub fn replay(&mut self, measure: impl FnOnce(&Point<'_>, &mut Measured)) -> f32 {
        let vector = self.vector();
        let u = Primary { vector: &vector, beyond: self.numbers(self.beyond) };
        let mut measured = std::mem::take(&mut self.measured);
        measure(&Point { length: self.length(), u }, &mut measured);
        self.measured = measured;
        self.measured.f
    }

    /// So many steps; `b` is the brightness that all chains share.
    pub fn run<'a>(
        &mut self,
        count: u64,
        space: &Space<'a>,
        mutation: &Mutation,
        b: f64,
        scratch: &mut Scratch<'a>,
        out: &mut Output,
    ) {
        let mut x = self.vector();
        let mut y = vec![Vec2::ZERO; x.len()];
        let mut here = std::mem::take(&mut self.measured);
        let mut there = Measured::default();
        // What x has earned by all steps at which the chain stayed, and shall be given once.
        let mut stayed = 0.0;
        for _ in 0..count {
            self.steps += 1;
            let step = Origin::Step(self.steps);
            let xi = self.numbers(step);
            let jump = xi.u2(Dim::at(0, slot::JUMP));
            let is_large = jump.x < mutation.large_step;
            let u = if is_large {
                Primary { vector: &[], beyond: xi }
            } else {
                mutation.small(&x, &mut y, self.vertices, &xi);
                Primary { vector: &y, beyond: self.numbers(self.beyond) }
            };
            space.measure(&Point { length: self.length(), u }, &mut there, scratch);

            let a = (there.f / here.f).min(1.0);
            stayed += 1.0 - a;
            if jump.y < a {
                out.splat(&here, stayed, b);
                std::mem::swap(&mut here, &mut there);
                stayed = a;
                if is_large {
                    fill(&mut y, self.vertices, &xi);
                    self.beyond = step;
                }
                std::mem::swap(&mut x, &mut y);
            } else {
                out.splat(&there, a, b);
            }
        }
        out.splat(&here, stayed, b);
        out.splats.append(&mut scratch.broken);
        self.measured = here;
        self.keep(&x);
    }

    fn length(&self) -> Length {
        Length { edges: self.edges, open: self.open }
    }

    fn numbers(&self, from: Origin) -> Sampler {
        match from {
            Origin::Bootstrap { seed, i, n } => bootstrap_path(seed, self.length(), i, n),
            Origin::Step(i) => Sampler::new(SequenceKind::Independent, self.seed, 0, i, u32::MAX),
        }
    }

    fn vector(&self) -> Vec<Vec2> {
        self.vector.iter().map(|u| Vec2::from(*u)).collect()
    }

    fn keep(&mut self, vector: &[Vec2]) {
        self.vector.clear();
        self.vector.extend(vector.iter().map(|u| u.to_array()));
    }
}

/// The numbers of path i of n of a class.
pub fn bootstrap_path(seed: u64, length: Length, i: u32, n: u32) -> Sampler {
    Sampler::new(SequenceKind::Sobol, seed, u64::from(length.edges), i, n)
}

impl Output {
    /// What a path of a chain adds that is worth `share` steps.
    fn splat(&mut self, path: &Measured, share: f32, b: f64) {
        if share > 0.0 && path.f > 0.0 {
            let scale = (b * f64::from(share) / f64::from(path.f)) as f32;
            let splat = |(position, [r, g, b]): &([f32; 2], [f32; 3])| Splat {
                position: (*position).into(),
                value: Spectrum::rgb(*r, *g, *b) * scale,
                particle: 0,
            };
            self.splats.extend(path.light.iter().map(splat));
        }
    }
}
