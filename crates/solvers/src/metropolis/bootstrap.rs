//! How chains begin: many paths of each length measure the brightness, and the first paths of the chains are drawn from them in proportion to f.
//!
//! ```text
//! b = 1/n Σ_{lengths} Σ_i f_i        chain c begins with the path at which the running sum of f passes (c + ξ)/C of the whole
//! ```
//!
//! Every path is then drawn C f_i / Σ f times on average, and chains are spread evenly over lengths and paths. A path of a chain is a function of the numbers
//! that the chain keeps, and of nothing else: replayed, it must give the same f to the bit.

use super::chain::{Chain, Origin, bootstrap_path};
use super::lengths::Length;
use super::space::{Measured, Point, Scratch};
use etendue_numerics::sequence::mix;
use etendue_numerics::{Dim, Primary, Sampler, SequenceKind};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

/// Chains that began together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Chains {
    /// They are the n-th of their replicate; 0 before the first.
    pub age: u32,
    /// b.
    pub brightness: f64,
    /// The chains; none where no path carries light.
    pub chains: Vec<Chain>,
}

/// How to begin.
pub struct Launch {
    /// The classes of paths, each with its number of vertices.
    pub lengths: Vec<(Length, u32)>,
    /// Seed.
    pub seed: u64,
    /// n: paths of each class.
    pub paths: u32,
    /// C.
    pub chains: u32,
}

/// A path that was another when it was replayed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReplayDiffers {
    /// Its edges.
    pub edges: u32,
    /// Its number among the paths of its class.
    pub path: u32,
    /// f when it was drawn.
    pub drawn: f32,
    /// f when it was replayed.
    pub replayed: f32,
}

impl fmt::Display for ReplayDiffers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { edges, path, drawn, replayed } = self;
        write!(
            f,
            "metropolis cannot go on: bootstrap path {path} of {edges} edges carried {drawn} when it was drawn and {replayed} when it was replayed with \
             the same numbers; its chain would explore something else than light"
        )
    }
}

impl std::error::Error for ReplayDiffers {}

impl Launch {
    /// New chains by paths that `measure` evaluates.
    pub fn run<'a>(
        &self,
        age: u32,
        measure: &(impl Fn(&Point<'_>, &mut Measured, &mut Scratch<'a>) + Sync),
        rays: &AtomicU64,
    ) -> Result<Chains, ReplayDiffers> {
        let n = self.paths as usize;
        let draw = |(out, scratch): &mut (Measured, Scratch<'a>), place: usize| {
            let (length, _) = self.lengths[place / n];
            let u = Primary { vector: &[], beyond: bootstrap_path(self.seed, length, (place % n) as u32, self.paths) };
            measure(&Point { length, u }, out, scratch);
            rays.fetch_add(scratch.take_rays(), Ordering::Relaxed);
            out.f
        };
        let drawn: Vec<f32> = (0..self.lengths.len() * n).into_par_iter().map_init(Default::default, draw).collect();

        let sum: f64 = drawn.iter().map(|f| f64::from(*f)).sum();
        let begin = |(c, place): (usize, usize)| {
            let (class, path) = (self.lengths[place / n], (place % n) as u32);
            let from = Origin::Bootstrap { seed: self.seed, i: path, n: self.paths };
            let mut chain = Chain::new(class, mix(self.seed ^ mix(c as u64 + 1)), from);
            let replayed = chain.replay(|at, out| measure(at, out, &mut Scratch::default()));
            if replayed.to_bits() != drawn[place].to_bits() {
                return Err(ReplayDiffers { edges: class.0.edges, path, drawn: drawn[place], replayed });
            }
            Ok(chain)
        };
        let chains = self.places(&drawn, sum).into_par_iter().enumerate().map(begin).collect::<Vec<_>>();
        let chains = chains.into_iter().collect::<Result<Vec<_>, _>>()?;
        Ok(Chains { age, brightness: sum / n as f64, chains })
    }

    /// Where the chains begin: systematic resampling.
    fn places(&self, f: &[f32], sum: f64) -> Vec<usize> {
        if sum <= 0.0 {
            return Vec::new();
        }
        let offset = f64::from(Sampler::new(SequenceKind::Independent, self.seed, u64::MAX, 0, 1).u1(Dim(0)));
        let step = sum / f64::from(self.chains);
        let mut places = Vec::with_capacity(self.chains as usize);
        let (mut reached, mut next) = (0.0, offset * step);
        for (place, f) in f.iter().enumerate() {
            reached += f64::from(*f);
            while next < reached && places.len() < self.chains as usize {
                places.push(place);
                next = (places.len() as f64 + offset) * step;
            }
        }
        // The last one may be lost to rounding.
        if let Some(last) = f.iter().rposition(|f| *f > 0.0) {
            places.resize(self.chains as usize, last);
        }
        places
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::slot;
    use etendue_numerics::Numbers;

    fn launch() -> Launch {
        let lengths = (2..5).map(|edges| (Length { edges, open: false }, edges + 1)).collect();
        Launch { lengths, seed: 7, paths: 1000, chains: 64 }
    }

    fn measured(f: f32, out: &mut Measured) {
        out.light = vec![([0.0; 2], [f; 3])];
        out.f = f;
    }

    /// f = edges · u: the brightness is (2 + 3 + 4)/2, chains are spread over lengths by 2 : 3 : 4, and begin where f is large.
    #[test]
    fn chains_begin_in_proportion_to_what_they_carry() {
        let f = |at: &Point<'_>, out: &mut Measured, _: &mut Scratch| {
            measured(at.length.edges as f32 * at.u.u2(Dim::at(0, slot::PIXEL)).x, out);
        };
        let began = launch().run(3, &f, &AtomicU64::new(0)).expect("the same numbers");
        assert!((began.brightness - 4.5).abs() < 0.01, "{}", began.brightness);
        assert_eq!((began.age, began.chains.len()), (3, 64));
        let drawn: Vec<f32> = (0..3000).map(|i| 1.0 + (i / 1000) as f32).collect();
        let places = launch().places(&drawn, 6000.0);
        for (k, share) in [(0, 64.0 / 6.0), (1, 64.0 / 3.0), (2, 32.0)] {
            let count = places.iter().filter(|p| **p / 1000 == k).count() as f64;
            assert!((count - share).abs() < 1.0, "{k}: {count}");
        }
        assert_eq!(launch().places(&[0.0, 2.0, 0.0], 2.0), [1; 64]);
    }

    /// Saboteurs: a path that depends on how often it was asked for, and one that looks at another number the second time.
    #[test]
    fn a_path_that_is_another_when_replayed_is_refused() {
        let count = AtomicU64::new(0);
        let forgetful =
            |_: &Point<'_>, out: &mut Measured, _: &mut Scratch| measured(1.0 + count.fetch_add(1, Ordering::Relaxed) as f32, out);
        let peeking = |at: &Point<'_>, out: &mut Measured, _: &mut Scratch| {
            let where_from = if at.u.vector.is_empty() { slot::PIXEL } else { slot::LENS };
            measured(0.5 + at.u.u2(Dim::at(0, where_from)).x, out);
        };
        let refusal = launch().run(1, &forgetful, &AtomicU64::new(0)).expect_err("not the same");
        assert_ne!(refusal.drawn, refusal.replayed);
        let refusal = launch().run(1, &peeking, &AtomicU64::new(0)).expect_err("not the same");
        assert!(refusal.to_string().contains("cannot go on"), "{refusal}");
    }

    #[test]
    fn without_light_there_are_no_chains() {
        let dark = |_: &Point<'_>, out: &mut Measured, _: &mut Scratch| *out = Measured::default();
        let began = launch().run(1, &dark, &AtomicU64::new(0)).expect("the same nothing");
        assert!(began.chains.is_empty() && began.brightness == 0.0);
    }
}
