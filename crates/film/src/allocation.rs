//! How many samples each pixel gets in the next round: more where the picture is noisy, without bias.
//!
//! A *round* is the passes between two tests of the noise: M passes of each of the K [`Replicates`]. Within it a pixel takes n samples of each replicate,
//! frozen when the round begins, M on average over the pixels. Every sample weighs M/n, so that a round counts in every pixel by its passes, whatever n is:
//!
//! ```text
//! x = Σ_rounds (M / Σ M) · m,     m = 1/n Σ samples of the round,     E[m | all earlier rounds] = μ   ⇒   E[x] = μ
//! ```
//!
//! That holds however n depends on earlier rounds, on the pixel's own samples too, since the weights M/ΣM do not. (A mean of all samples alike has weights n/Σn: those who began
//! dark by chance and were therefore left alone stay too dark.) Noise is least for n ∝ √v [Neyman 1934], v the variance of one sample relative to what relMSE divides by, in the
//! filtered picture r; how it is known is told in [`crate::variance`]. At least M/10 samples, and one, are taken everywhere, at most 16 M: what was not met yet may still be there.
//! Where little can be won, all pixels take M.

use crate::replicates::Replicates;
use crate::variance::wishes;
use etendue_numerics::sequence::mix;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Samples in a pixel, in units of those of a uniform round: at least and at most.
pub(crate) const RANGE: [f64; 2] = [0.1, Allocation::MOST as f64];

/// Samples per pixel of a round, and what earlier ones took.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Allocation {
    width: u32,
    /// Passes of each replicate before this round, and in it: ΣM of the past, M.
    before: u32,
    passes: u32,
    /// n.
    counts: Vec<u32>,
    /// Samples of each replicate before this round.
    taken: Vec<u32>,
    /// A of all rounds before this one.
    spread: Vec<f32>,
}

impl Allocation {
    /// Bytes that a pixel takes, while the next round is planned.
    pub const BYTES: u64 = 3 * 4 + 40 * 8 + 3 * 4;

    /// Samples that a pixel takes at most, in units of those of a uniform round.
    pub const MOST: u32 = 16;

    /// The first round: one sample of each replicate in every pixel.
    pub fn new(size: [u32; 2]) -> Self {
        let pixels = size[0] as usize * size[1] as usize;
        Self { width: size[0], before: 0, passes: 1, counts: vec![1; pixels], taken: vec![0; pixels], spread: vec![0.0; pixels] }
    }

    /// Whether this is an allocation for a picture of this size.
    pub fn fits(&self, size: [u32; 2]) -> bool {
        let pixels = size[0] as usize * size[1] as usize;
        self.width == size[0]
            && self.passes.is_power_of_two()
            && [self.counts.len(), self.taken.len(), self.spread.len()] == [pixels; 3]
            && self.counts.iter().all(|n| *n > 0)
    }

    /// Of a pixel, which samples of replicate `r` are taken in its pass number `pass`, counted from the first round.
    #[inline]
    pub fn samples(&self, pixel: [u32; 2], r: usize, pass: u32) -> Range<u32> {
        let i = pixel[1] as usize * self.width as usize + pixel[0] as usize;
        let (from, to) = (self.up_to(i, r, pass), self.up_to(i, r, pass + 1));
        self.taken[i] + from..self.taken[i] + to
    }

    /// What each of the pixel's samples weighs in this round: M/n.
    #[inline]
    pub fn weight(&self, pixel: [u32; 2]) -> f32 {
        let i = pixel[1] as usize * self.width as usize + pixel[0] as usize;
        self.passes as f32 / self.counts[i] as f32
    }

    /// Samples of a replicate that a pixel has taken in this round before a pass: n samples, spread over M passes as evenly as can be. Replicates and
    /// pixels begin at places of their own, so that no pass is crowded.
    #[inline]
    fn up_to(&self, i: usize, r: usize, pass: u32) -> u32 {
        let m = u64::from(self.passes);
        let done = u64::from(pass.saturating_sub(self.before)).min(m);
        let begins = mix(i as u64).wrapping_add(r as u64 * m / Replicates::K as u64) & (m - 1);
        ((u64::from(self.counts[i]) * done + begins) >> m.trailing_zeros()) as u32
    }

    /// Samples per pixel after `passes` passes over all replicates, rows from the top.
    pub fn taken(&self, passes: u32) -> Vec<u32> {
        let k = Replicates::K as u32;
        let of = |i: usize| {
            let round = (0..Replicates::K).map(|r| self.up_to(i, r, passes / k + u32::from((r as u32) < passes % k)));
            self.taken[i] * k + round.sum::<u32>()
        };
        (0..self.counts.len()).map(of).collect()
    }

    /// Whether all pixels take one sample a pass, in this round as in all before.
    pub fn is_even(&self) -> bool {
        self.counts.iter().zip(&self.taken).all(|(n, taken)| *n == self.passes && *taken == self.before)
    }

    /// Goes on to the next round, as long as all before it together: `replicates` are what those have found, `picture` is what became of it.
    pub fn advance(&mut self, replicates: &Replicates, picture: &[[f32; 3]]) {
        let m = self.passes as f32;
        for ((taken, spread), n) in self.taken.iter_mut().zip(&mut self.spread).zip(&self.counts) {
            *taken = taken.saturating_add(*n);
            *spread += m * m / *n as f32;
        }
        self.before += self.passes;
        self.passes = self.before;
        let total = f64::from(self.before);
        let one: Vec<f64> = self.spread.iter().map(|a| total * total / f64::from(*a)).collect();
        let m = f64::from(self.passes);
        let Some(wishes) = wishes(replicates, self.before, &one, self.width as usize, picture) else {
            self.allot(|_| m);
            return;
        };
        let scale = scale(&wishes, m);
        self.allot(|i| clamped(scale * wishes[i], m));
    }

    /// Gives each pixel as many samples as it wants, at least 1, rounded at random so that parts of samples are not lost.
    fn allot(&mut self, wants: impl Fn(usize) -> f64) {
        for (i, n) in self.counts.iter_mut().enumerate() {
            let u = (mix(mix(i as u64) ^ u64::from(self.before)) >> 32) as f64 / 4_294_967_296.0;
            *n = (wants(i) + u).floor() as u32;
        }
    }
}

/// What a wish becomes: a number of samples within bounds.
fn clamped(wish: f64, m: f64) -> f64 {
    wish.clamp((RANGE[0] * m).max(1.0), (RANGE[1] * m).max(1.0))
}

/// The factor that makes wishes M samples on average, or as many as the bounds allow.
fn scale(wishes: &[f64], m: f64) -> f64 {
    let mean = |factor: f64| wishes.iter().map(|w| clamped(factor * w, m)).sum::<f64>() / wishes.len().max(1) as f64;
    // With this factor even the least of them wishes for more than it may have.
    let least = wishes.iter().copied().filter(|w| *w > 0.0).fold(f64::INFINITY, f64::min);
    let (mut low, mut high) = (0.0, RANGE[1] * m / least);
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if mean(middle) < m { low = middle } else { high = middle }
    }
    low
}
