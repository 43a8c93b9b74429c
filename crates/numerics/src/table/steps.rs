//! The steps of a cumulative distribution, and the search among them.

use crate::math::ONE_MINUS_EPSILON;
use crate::wide;

/// Cells for each entry of the guide: memory against a step or two of the search.
const CELLS_PER_GUIDE: usize = 4;

/// So many steps are looked at together, without a branch; as many that are never reached stand behind the last.
const NEAR: usize = 8;

/// The steps of a table of n cells and the guide to them, wherever they are kept.
#[derive(Clone, Copy)]
pub(super) struct Steps<'a> {
    /// n + 1 steps from 0 to 1, then `NEAR` that no u reaches.
    cdf: &'a [f32],
    /// For each k/m (k = 0 to m) the cell that u = k/m falls into.
    guide: &'a [u32],
}

/// Steps and entries of the guide of a table of `n` cells.
pub(super) fn sizes(n: usize) -> [usize; 2] {
    [n + 1 + NEAR, n.div_ceil(CELLS_PER_GUIDE) + 1]
}

/// Appends the steps of `n` values, those that `f` lacks being zero, and the guide. Returns Σf: zero of a table without weight, whose steps are even.
pub(super) fn append(f: &[f32], n: usize, to: &mut Vec<f32>, guide: &mut Vec<u32>) -> f64 {
    let weight = |x: f32| if x > 0.0 && x.is_finite() { f64::from(x) } else { 0.0 };
    let sum: f64 = f.iter().map(|&x| weight(x)).sum();
    let first = to.len();
    let mut below = 0.0;
    to.push(0.0);
    for i in 0..n {
        below += if sum > 0.0 { weight(f.get(i).copied().unwrap_or(0.0)) / sum } else { 1.0 / n as f64 };
        to.push(below.min(1.0) as f32);
    }
    let cdf = &mut to[first..];
    // The last step that has weight ends at one, and so do those without weight after it.
    let top = cdf[n];
    cdf.iter_mut().rev().take_while(|c| **c == top).for_each(|c| *c = 1.0);

    let m = n.div_ceil(CELLS_PER_GUIDE);
    let mut cell = 0;
    guide.extend((0..=m).map(|k| {
        while cell + 1 < n && cdf[cell + 1] <= k as f32 / m as f32 {
            cell += 1;
        }
        cell as u32
    }));
    to.extend([f32::INFINITY; NEAR]);
    sum
}

impl<'a> Steps<'a> {
    #[inline(always)]
    pub fn new(cdf: &'a [f32], guide: &'a [u32]) -> Self {
        Self { cdf, guide }
    }

    /// n.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.cdf.len() - 1 - NEAR
    }

    /// Pᵢ; 0 beyond the table.
    #[inline(always)]
    pub fn probability(&self, i: usize) -> f32 {
        if i < self.len() { self.cdf[i + 1] - self.cdf[i] } else { 0.0 }
    }

    /// Asks for the memory that [`Steps::probability`] looks at.
    #[inline(always)]
    pub fn fetch(&self, i: usize) {
        if let Some(step) = self.cdf.get(i) {
            wide::fetch(step);
        }
    }

    /// Which entry of the guide.
    #[inline(always)]
    fn guided(&self, u: f32) -> usize {
        let m = self.guide.len() - 1;
        ((u * m as f32) as usize).min(m - 1)
    }

    /// Asks for the memory that [`Steps::sample_discrete`] looks at first.
    #[inline(always)]
    pub fn fetch_guide(&self, u: f32) {
        wide::fetch(&self.guide[self.guided(u)]);
    }

    /// Asks for the memory that it looks at next.
    #[inline(always)]
    pub fn fetch_cells(&self, u: f32) {
        let low = self.guide[self.guided(u)] as usize;
        wide::fetch(&self.cdf[low]);
        wide::fetch(&self.cdf[low + NEAR]);
    }

    /// Draws a cell: (i, Pᵢ, u stretched over the cell to a fresh uniform number in [0, 1)).
    #[inline(always)]
    pub fn sample_discrete(&self, u: f32) -> (usize, f32, f32) {
        // The last cell that begins at or below u lies between two guides, most often near the first.
        let (n, k) = (self.len(), self.guided(u));
        let low = self.guide[k] as usize;
        let near: u32 = self.cdf[low + 1..][..NEAR].iter().map(|&c| u32::from(c <= u)).sum();
        let mut i = low + near as usize;
        if near == NEAR as u32 {
            let high = self.guide[k + 1] as usize;
            i += self.cdf[i + 1..=high.max(i)].partition_point(|&c| c <= u);
        }
        i = i.min(n - 1);
        // The product u m may have rounded past the guide.
        while i > 0 && self.cdf[i] > u {
            i -= 1;
        }
        while i + 1 < n && self.cdf[i + 1] <= u {
            i += 1;
        }
        let p = self.cdf[i + 1] - self.cdf[i];
        (i, p, ((u - self.cdf[i]) / p).clamp(0.0, ONE_MINUS_EPSILON))
    }

    /// The u that leads to x in [0, 1), cells being even there.
    #[inline]
    pub fn invert(&self, x: f32) -> f32 {
        let n = self.len();
        let at = x.clamp(0.0, 1.0) * n as f32;
        let i = (at as usize).min(n - 1);
        let u = self.cdf[i] + (at - i as f32) * (self.cdf[i + 1] - self.cdf[i]);
        u.clamp(0.0, ONE_MINUS_EPSILON)
    }

    /// p(x) on [0, 1); zero elsewhere.
    #[inline]
    pub fn pdf(&self, x: f32) -> f32 {
        let n = self.len();
        if !(0.0..1.0).contains(&x) {
            return 0.0;
        }
        self.probability(((x * n as f32) as usize).min(n - 1)) * n as f32
    }

    /// Draws x in [0, 1): (x, p(x)).
    #[inline]
    pub fn sample(&self, u: f32) -> (f32, f32) {
        let (i, p, rest) = self.sample_discrete(u);
        (super::place(i, rest, self.len()), p * self.len() as f32)
    }
}
