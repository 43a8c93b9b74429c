//! How far the picture still is from the truth, from independent repetitions of the same work.
//!
//! Pass k belongs to replicate k mod K, each with its own scramble of the point set. The picture is the mean of K replicate
//! pictures x_r, so its variance in a pixel is s²/K with s² the sample variance of the x_r: valid for low-discrepancy points, whose
//! own sample variance is no error bar. Over at most [`Replicates::TRACKED`] pixels, spread evenly,
//!
//! ```text
//! relMSE ≈ mean over pixels and channels of (s²/K) / (x̄² + e),    e = 0.01 · (mean x̄)²
//! ```
//!
//! relMSE is quadratic in the picture's values, so each x̄² is taken less its own variance to stay unbiased. The mean x̄ is over all tracked
//! pixels and channels.
//!
//! Where all light comes by tiles, the replicates are pictures through the film's own filter: what they say is true of edges and of numbers that are even across
//! pixels, too. A filtered pixel is a ratio of sums, x = Σ_r A_r / Σ_r W_r with A = Σ k L and W = Σ k, and its variance that of what the replicates differ by
//! [Cochran 1977, eq. 2.39]:
//!
//! ```text
//! s²/K = K/(K - 1) · Σ_r (A_r - x W_r)² / (Σ_r W_r)²
//! ```
//!
//! Splats fall between tiles: solvers that make them have replicates of the pixels before the filter, whose variance is multiplied by what the filter leaves of independent pixels'.

use crate::tile::Tile;
use serde::{Deserialize, Serialize};

/// Sums of K replicates over a subset of the pixels.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Replicates {
    width: u32,
    stride: u64,
    count: usize,
    /// Σ L of the unfiltered pixels in units of 2⁻²⁰, replicate after replicate, tracked pixel after tracked pixel; empty where nobody asks.
    sums: Vec<[i64; 3]>,
    /// Σ k L and Σ k alike, through the filter.
    filtered: Vec<[i64; 4]>,
}

/// An estimated relMSE and its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseEstimate {
    /// The estimate.
    pub rel_mse: f64,
    /// Half the width of its interval.
    pub half_width: f64,
}

impl NoiseEstimate {
    /// √relMSE in per cent, with the interval's ends: what `--noise` compares.
    pub fn percent(&self) -> (f64, f64, f64) {
        let root = |x: f64| 100.0 * x.max(0.0).sqrt();
        (root(self.rel_mse), root(self.rel_mse - self.half_width), root(self.rel_mse + self.half_width))
    }
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// e of a picture of this mean.
pub(crate) fn floor(mean: f64) -> f64 {
    0.01 * mean * mean
}

const UNIT: f64 = 1_048_576.0;

impl Replicates {
    /// Number of replicates.
    pub const K: usize = 16;
    /// All of them, and two halves: the first, and the step to the next.
    pub(crate) const ALL: [usize; 2] = [0, 1];
    pub(crate) const HALVES: [[usize; 2]; 2] = [[0, 2], [1, 2]];
    /// Pixels tracked at most: 96 MiB of sums pixel by pixel, 128 MiB through a filter.
    pub const TRACKED: u64 = 1 << 18;

    /// Bytes of the sums of so many pixels: through the filter, or both ways.
    pub fn bytes(pixels: u64, both: bool) -> u64 {
        pixels.min(Self::TRACKED) * Self::K as u64 * if both { 32 + 24 } else { 32 }
    }

    /// No samples yet, for a picture of this size, pixel by pixel.
    pub fn new(size: [u32; 2]) -> Self {
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        // A stride prime to the width walks over all columns.
        let mut stride = pixels.div_ceil(Self::TRACKED).max(1);
        while gcd(stride, u64::from(size[0])) > 1 {
            stride += 1;
        }
        let count = pixels.div_ceil(stride) as usize;
        Self { width: size[0], stride, count, sums: vec![[0; 3]; count * Self::K], filtered: Vec::new() }
    }

    /// The same for a picture that is made of tiles alone, through its filter; and pixel by pixel as well, if asked.
    pub fn of_tiles(size: [u32; 2], pixels: bool) -> Self {
        let all = Self::new(size);
        let sums = if pixels { all.sums } else { Vec::new() };
        Self { sums, filtered: vec![[0; 4]; all.count * Self::K], ..all }
    }

    /// Whether these are replicates of the same kind, of a picture of the same size.
    pub fn fits(&self, other: &Self) -> bool {
        let shape = |r: &Self| (r.width, r.stride, r.count, r.sums.len(), r.filtered.len());
        shape(self) == shape(other)
    }

    /// The place of a pixel among the tracked ones.
    #[inline]
    pub fn slot(&self, pixel: [u32; 2]) -> Option<usize> {
        let index = u64::from(pixel[1]) * u64::from(self.width) + u64::from(pixel[0]);
        index.is_multiple_of(self.stride).then_some((index / self.stride) as usize)
    }

    /// Whether [`Replicates::add`] is asked for.
    pub fn has_pixels(&self) -> bool {
        !self.sums.is_empty()
    }

    /// Adds a pixel's unfiltered mean of one pass of replicate `r`.
    #[inline]
    pub fn add(&mut self, r: usize, slot: usize, value: [f32; 3]) {
        add(&mut self.sums[r * self.count + slot], value);
    }

    /// Adds a tile of one pass of replicate `r`, where they are kept through the filter.
    pub fn add_tile(&mut self, r: usize, tile: &Tile) {
        if self.filtered.is_empty() {
            return;
        }
        for (pixel, sum) in tile.pixels() {
            if let Some(slot) = self.slot(pixel) {
                add(&mut self.filtered[r * self.count + slot], sum.to_array());
            }
        }
    }

    /// In a channel of a tracked pixel, after `passes` passes of each replicate, by every `step`th of them from `first` on: x̄, and s²/K as the parts that each has in it.
    fn statistics(&self, slot: usize, channel: usize, passes: u32, [first, step]: [usize; 2]) -> (f64, [f64; Self::K]) {
        let scale = 1.0 / (UNIT * f64::from(passes.max(1)));
        let some = || (first..Self::K).step_by(step);
        let k = some().len() as f64;
        let x = |r: usize| self.sums[r * self.count + slot][channel] as f64 * scale;
        let mean = some().map(x).sum::<f64>() / k;
        let mut parts = [0.0; Self::K];
        some().for_each(|r| parts[r] = (x(r) - mean).powi(2) / (k - 1.0) / k);
        (mean, parts)
    }

    /// In a channel of a tracked pixel, through the filter: x and s²/K.
    fn through_filter(&self, slot: usize, channel: usize) -> (f64, f64) {
        let k = Self::K as f64;
        let of = |r: usize| &self.filtered[r * self.count + slot];
        let sum = |c: usize| (0..Self::K).map(|r| of(r)[c] as f64).sum::<f64>();
        let weight = sum(3);
        if weight <= 0.0 {
            return (0.0, 0.0);
        }
        let x = sum(channel) / weight;
        let squares: f64 = (0..Self::K).map(|r| (of(r)[channel] as f64 - x * of(r)[3] as f64).powi(2)).sum();
        (x, k / (k - 1.0) * squares / (weight * weight))
    }

    /// (s²/K) / (x̄² + e) of each tracked pixel, channel by channel.
    fn ratios(&self, passes: u32) -> Vec<[f64; 3]> {
        let total = |(mean, parts): (f64, [f64; Self::K])| (mean, parts.iter().sum::<f64>());
        let channel = |p: usize, c: usize| {
            if self.filtered.is_empty() { total(self.statistics(p, c, passes, Self::ALL)) } else { self.through_filter(p, c) }
        };
        let pixels: Vec<_> = (0..self.count).map(|p| [0, 1, 2].map(|c| channel(p, c))).collect();
        let n = (3 * pixels.len()).max(1) as f64;
        let square = |(mean, variance): (f64, f64)| (mean * mean - variance).max(0.0);
        let e = floor(pixels.iter().flatten().map(|p| p.0).sum::<f64>() / n);
        if e <= 0.0 {
            return vec![[0.0; 3]; self.count];
        }
        pixels.iter().map(|pixel| pixel.map(|p| p.1 / (square(p) + e))).collect()
    }

    /// Of each tracked pixel, by `some` of the replicates, its place, rows from the top, x̄, its variance v in units of `below` the place, mean over channels, and the sum
    /// of the squares of the parts that each replicate has in v.
    pub(crate) fn variances<'a>(
        &'a self,
        passes: u32,
        some: [usize; 2],
        below: impl Fn(usize) -> [f64; 3] + 'a,
    ) -> impl Iterator<Item = (usize, [f64; 3], [f64; 2])> + 'a {
        (0..self.count).map(move |slot| {
            let place = slot * self.stride as usize;
            let (mut means, mut parts) = ([0.0; 3], [0.0; Self::K]);
            for (c, below) in below(place).into_iter().enumerate().filter(|(_, below)| *below > 0.0) {
                let (mean, squares) = self.statistics(slot, c, passes, some);
                means[c] = mean;
                parts.iter_mut().zip(squares).for_each(|(part, square)| *part += square / (3.0 * below));
            }
            let (v, squares) = parts.iter().fold((0.0, 0.0), |(v, squares), part| (v + part, squares + part * part));
            (place, means, [v, squares])
        })
    }

    /// The estimate after `passes` passes of each replicate. `noise_factor` is the variance that the reconstruction filter leaves of a
    /// pixel's own (1 for the box).
    pub fn estimate(&self, passes: u32, noise_factor: f64) -> NoiseEstimate {
        let left = if self.filtered.is_empty() { noise_factor } else { 1.0 };
        let ratios: Vec<f64> = self.ratios(passes).into_iter().flatten().map(|r| left * r).collect();
        let n = ratios.len().max(1) as f64;
        let mean = ratios.iter().sum::<f64>() / n;
        // Channels of a pixel are not independent, nor are pixels that the filter mixes: a third of the terms count, and of those as many as it leaves of their noise.
        let spread = ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        let mixed = if self.filtered.is_empty() { 1.0 } else { noise_factor.min(1.0) };
        NoiseEstimate { rel_mse: mean, half_width: 1.96 * (3.0 * spread / (mixed * n)).sqrt() }
    }
}

/// Adds what is finite.
#[inline]
fn add<const N: usize>(sums: &mut [i64; N], values: [f32; N]) {
    for (sum, v) in sums.iter_mut().zip(values) {
        if v.is_finite() {
            *sum = sum.saturating_add((f64::from(v) * UNIT) as i64);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Replicates of known variance: x_r = m ± d gives s²/K = d²·16/15/16. Half of the pixels have m = 1, half m = 3, so e = 0.01 · 2².
    #[test]
    fn the_estimate_is_the_closed_form() {
        let mut replicates = Replicates::new([8, 8]);
        let d = 0.25;
        for r in 0..Replicates::K {
            let d = if r % 2 == 0 { d } else { -d };
            for slot in 0..64 {
                replicates.add(r, slot, [if slot % 2 == 0 { 1.0 + d } else { 3.0 + d }; 3]);
            }
        }
        let variance = f64::from(d * d) / 15.0;
        let of = |m: f64| variance / (m * m - variance + 0.04);
        let want = 0.5 * (of(1.0) + of(3.0));
        assert!((replicates.estimate(1, 1.0).rel_mse / want - 1.0).abs() < 1e-9);
    }

    #[test]
    fn large_pictures_are_tracked_within_bounds() {
        let replicates = Replicates::new([1920, 1080]);
        assert!(replicates.count as u64 <= Replicates::TRACKED);
        let columns: std::collections::BTreeSet<u64> = (0..replicates.count as u64).map(|i| i * replicates.stride % 1920).collect();
        assert!(columns.len() > 1500, "{}", columns.len());
    }
}
