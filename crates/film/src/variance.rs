//! How noisy each pixel is, from the replicates of a render: what samples are allotted by.
//!
//! ```text
//! v = mean over channels of  s² (ΣM)² / A  / (r² + e),      A = Σ_rounds M²/n,      Var x_r = σ² A / (ΣM)²
//! ```
//!
//! is the variance of one sample relative to what relMSE divides by, r the filtered picture (rounds, M and n: [`crate::Allocation`]).
//!
//! A pixel's own v may be little known: where rare bright samples are most of it, it is large where one was met. It is therefore a blend of means over windows of growing width k
//! around the pixel, from wide to narrow, each of which counts by the number N of events that it rests on: as many as the replicates' parts v_r in v tell of there, and no
//! more than the next wider window k' lets expect in so many pixels n_k:
//!
//! ```text
//! v_k ← t · mean_k + (1 - t) · v_wider,      t = N / (N + 6),      N = min(N_k, N_k' n_k / n_k'),      N_k = (Σ_k v)² / Σ_k Σ_r v_r²,      k = 31, 15, 7, 3, 1
//! ```
//!
//! so that a single firefly (N = 1) buys hardly any samples, a quiet place among fireflies is not trusted to be quiet, and an edge between steady noise (N = 16/3 in each pixel) and
//! none stays sharp.
//!
//! **What is alike nearby** is not the same everywhere. Steady noise is, relative to the light: its v. Fireflies are as bright wherever they fall, and do not know how bright the picture is there:
//! their s² is. So there are three ways, of which γ = 1 is the former and γ = 0 would be the latter, r̃ the mean of r over 3 x 3 pixels,
//!
//! ```text
//! v = blend(s² / (r² + e)^γ) / (r̃² + e)^(1 - γ),      γ = 1, 1/2, 1/4
//! ```
//!
//! and that one is taken which serves best where it has not learnt: samples allotted by half of the replicates must leave least of the noise that the other half shows, and vice versa.
//!
//! By these v noise falls to (mean √v)² / mean v of that of even samples. Where that is no less than 0.85, with γ = 1, nothing is asked for: uneven samples are less well stratified, and cost more.

use crate::allocation::RANGE;
use crate::replicates::{Replicates, floor};

/// Half widths of the windows.
const REACHES: [usize; 5] = [15, 7, 3, 1, 0];
/// Events that a window must rest on to count as much as all wider ones.
const ENOUGH: f64 = 6.0;
/// The noise that must remain, by what is known, of that of a uniform round at most.
const WORTH: f64 = 0.85;
/// The ways, γ = 2^-way.
const WAYS: std::ops::Range<u32> = 0..3;

/// What is known of a picture's noise by some of its replicates.
struct Knowledge<'a> {
    replicates: &'a Replicates,
    passes: u32,
    some: [usize; 2],
    /// Of each pixel the variance of one sample in units of that of the mean.
    one: &'a [f64],
    width: usize,
    e: f64,
    /// r, and r̃² + e.
    picture: Vec<[f64; 3]>,
    nearby: Vec<f64>,
    /// s² of the pixels that are looked at, mean over channels.
    squares: Vec<(usize, f64)>,
}

/// √v of each pixel of a `picture`, after `passes` passes of each replicate, if uneven samples are worth it; `one` is the variance of one sample in units of that of the mean of all.
pub(crate) fn wishes(replicates: &Replicates, passes: u32, one: &[f64], width: usize, picture: &[[f32; 3]]) -> Option<Vec<f64>> {
    let e = floor(picture.iter().flatten().map(|r| f64::from(*r)).sum::<f64>() / (3 * picture.len()).max(1) as f64);
    if e <= 0.0 {
        return None;
    }
    let by = |some| Knowledge::new(replicates, passes, some, one, width, e);
    let all = by(Replicates::ALL).of(picture);
    let roots = |way: u32| all.blend(way).into_iter().map(f64::sqrt).collect::<Vec<_>>();
    let steady = roots(0);
    let (sum, squares) = steady.iter().fold((0.0, 0.0), |(s, q), root| (s + root, q + root * root));
    if sum * sum >= WORTH * squares * steady.len() as f64 {
        return None;
    }
    let [a, b] = Replicates::HALVES.map(by);
    let remains = |way: u32| a.remains(way, &b) + b.remains(way, &a);
    let best = WAYS.map(|way| (way, remains(way))).min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(way, _)| way);
    Some(if best == 0 { steady } else { roots(best) })
}

/// x^γ.
fn power(x: f64, way: u32) -> f64 {
    (0..way).fold(x, |x, _| x.sqrt())
}

impl<'a> Knowledge<'a> {
    fn new(replicates: &'a Replicates, passes: u32, some: [usize; 2], one: &'a [f64], width: usize, e: f64) -> Self {
        let (mut picture, mut seen, mut squares) = (vec![[0.0; 3]; one.len()], vec![[0.0; 3]; one.len()], Vec::new());
        for (i, means, [square, _]) in replicates.variances(passes, some, |_| [1.0; 3]) {
            picture[i] = means;
            seen[i] = [means.iter().sum::<f64>() / 3.0, 1.0, 0.0];
            squares.push((i, one[i] * square));
        }
        Self { replicates, passes, some, one, width, e, picture, nearby: nearby(&seen, width, e), squares }
    }

    /// The same noise in the picture as it was developed.
    fn of(mut self, picture: &[[f32; 3]]) -> Self {
        self.picture = picture.iter().map(|r| r.map(f64::from)).collect();
        let seen: Vec<_> = self.picture.iter().map(|r| [r.iter().sum::<f64>() / 3.0, 1.0, 0.0]).collect();
        self.nearby = nearby(&seen, self.width, self.e);
        self
    }

    /// v of each pixel, with γ = 2^-way.
    fn blend(&self, way: u32) -> Vec<f64> {
        let mut known = vec![[0.0f64; 3]; self.one.len()]; // v, Σ v_r², 1
        let below = |i: usize| self.picture[i].map(|r| power(r * r + self.e, way));
        for (i, _, [v, squares]) in self.replicates.variances(self.passes, self.some, below) {
            known[i] = [self.one[i] * v, self.one[i].powi(2) * squares, 1.0];
        }
        let mut blend = vec![0.0; known.len()];
        // Events in a pixel of the next wider window.
        let mut density = vec![f64::INFINITY; known.len()];
        for (level, reach) in REACHES.into_iter().enumerate() {
            let windows = window(&known, self.width, reach);
            for ((v, density), [sum, squares, count]) in blend.iter_mut().zip(&mut density).zip(windows) {
                if squares > 0.0 {
                    let events = sum * sum / squares;
                    let rests_on = events.min(*density * count);
                    let t = if level == 0 { 1.0 } else { rests_on / (rests_on + ENOUGH) };
                    *v += t * (sum / count - *v);
                    *density = events / count;
                }
            }
        }
        blend.iter_mut().zip(&self.nearby).for_each(|(v, below)| *v *= power(*below, way) / below);
        blend
    }

    /// How much of the noise that `others` show remains where samples follow this, of that of even samples.
    fn remains(&self, way: u32, others: &Self) -> f64 {
        let v = self.blend(way);
        let wish = |i: usize| v[i].sqrt();
        let mean = self.squares.iter().map(|(i, _)| wish(*i)).sum::<f64>() / self.squares.len().max(1) as f64;
        let (mut samples, mut even, mut uneven) = (0.0, 0.0, 0.0);
        for (i, square) in &others.squares {
            let (n, noise) = (wish(*i).max(RANGE[0] * mean), square / self.nearby[*i]);
            samples += n;
            even += noise;
            uneven += if noise > 0.0 { noise / n } else { 0.0 };
        }
        if even > 0.0 { uneven * samples / (even * others.squares.len() as f64) } else { 1.0 }
    }
}

/// r̃² + e, from (r, 1) of the pixels that are looked at.
fn nearby(seen: &[[f64; 3]], width: usize, e: f64) -> Vec<f64> {
    window(seen, width, 1).into_iter().map(|[sum, count, _]| (sum / count.max(1.0)).powi(2) + e).collect()
}

/// Sums over the square windows of 2·reach + 1 pixels around each pixel, cut off at the border; reach is one less than a power of two.
fn window(values: &[[f64; 3]], width: usize, reach: usize) -> Vec<[f64; 3]> {
    let mut sums = values.to_vec();
    let (mut line, mut spare) = (Vec::new(), Vec::new());
    let mut along = |sums: &mut [[f64; 3]], first: usize, step: usize, count: usize| {
        line.clear();
        line.resize(count + 2 * reach, [0.0; 3]);
        (0..count).for_each(|k| line[reach + k] = sums[first + k * step]);
        widen(&mut line, &mut spare, reach);
        (0..count).for_each(|k| sums[first + k * step] = line[reach + k]);
    };
    let height = values.len() / width.max(1);
    (0..height).for_each(|y| along(&mut sums, y * width, 1, width));
    (0..width).for_each(|x| along(&mut sums, x, width, height));
    sums
}

/// Along a line that has nothing in its first and last `reach` places: S_{2r+1}(x) = S_r(x - r - 1) + S_0(x) + S_r(x + r + 1).
fn widen(line: &mut Vec<[f64; 3]>, spare: &mut Vec<[f64; 3]>, reach: usize) {
    let (own, plus) = (line.clone(), |a: [f64; 3], b: [f64; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
    let at = |sums: &[[f64; 3]], i: usize| sums.get(i).copied().unwrap_or_default();
    let mut r = 0;
    while r < reach {
        spare.clear();
        // Before the first place there is nothing, either: the number wraps.
        spare.extend((0..own.len()).map(|i| plus(plus(at(line, i.wrapping_sub(r + 1)), own[i]), at(line, i + r + 1))));
        std::mem::swap(line, spare);
        r = 2 * r + 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_sums_over_neighbours() {
        let (width, height) = (9, 5);
        let values: Vec<[f64; 3]> = (0..width * height).map(|i| [i as f64, (i * i % 17) as f64, 1.0]).collect();
        for reach in REACHES {
            for (i, got) in window(&values, width, reach).into_iter().enumerate() {
                let near = |j: &usize| (j % width).abs_diff(i % width) <= reach && (j / width).abs_diff(i / width) <= reach;
                let want = (0..values.len()).filter(near).fold([0.0; 3], |s, j| [0, 1, 2].map(|c| s[c] + values[j][c]));
                assert_eq!(got, want, "reach {reach}, pixel {i}");
            }
        }
    }
}
