//! One dimension.

use super::place;
use crate::math::ONE_MINUS_EPSILON;
use crate::wide;

/// Cells for each entry of the guide table: memory against a step or two of the search.
const CELLS_PER_GUIDE: usize = 4;

/// A piecewise-constant density over [0, 1), and the discrete choice among its cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Table1D {
    /// n + 1 steps from 0 to 1.
    cdf: Vec<f32>,
    /// For each k/m (k = 0 to m) the cell that u = k/m falls into.
    guide: Vec<u32>,
    /// Σf.
    sum: f64,
}

impl Table1D {
    /// The table of `f`. Negative and non-finite values count as zero; a table without weight (or empty) is uniform, and says so by [`Table1D::sum`] = 0.
    pub fn new(f: &[f32]) -> Self {
        let n = f.len().max(1);
        let weight = |x: f32| if x > 0.0 && x.is_finite() { f64::from(x) } else { 0.0 };
        let sum: f64 = f.iter().map(|&x| weight(x)).sum();
        let mut cdf = Vec::with_capacity(n + 1);
        let mut below = 0.0;
        cdf.push(0.0);
        let uniform = std::iter::repeat_n(1.0 / n as f64, if sum > 0.0 { 0 } else { n });
        let shares = f.iter().filter(|_| sum > 0.0).map(|&x| weight(x) / sum).chain(uniform);
        cdf.extend(shares.map(|share| {
            below += share;
            below.min(1.0) as f32
        }));
        // The last step that has weight ends at one, and so do those without weight after it.
        let top = cdf[n];
        cdf.iter_mut().rev().take_while(|c| **c == top).for_each(|c| *c = 1.0);

        let m = n.div_ceil(CELLS_PER_GUIDE);
        let mut cell = 0;
        let mut guided = |k: usize| {
            while cell + 1 < n && cdf[cell + 1] <= k as f32 / m as f32 {
                cell += 1;
            }
            cell as u32
        };
        let guide = (0..=m).map(&mut guided).collect();
        Self { cdf, guide, sum }
    }

    /// The same table, its values scaled to another Σf.
    pub(super) fn with_sum(self, sum: f64) -> Self {
        Self { sum, ..self }
    }

    /// The number of cells.
    #[inline]
    pub fn len(&self) -> usize {
        self.cdf.len().saturating_sub(1)
    }

    /// Never: a table has at least one cell.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.cdf.len() < 2
    }

    /// Σf over the usable values; 0 where the table had no weight and is uniform instead.
    #[inline]
    pub fn sum(&self) -> f64 {
        self.sum
    }

    /// The probability of the discrete choice i; 0 beyond the table.
    #[inline]
    pub fn probability(&self, i: usize) -> f32 {
        if i < self.len() { self.cdf[i + 1] - self.cdf[i] } else { 0.0 }
    }

    /// Asks for the memory that [`Table1D::probability`] looks at.
    #[inline]
    pub(super) fn fetch(&self, i: usize) {
        if let Some(step) = self.cdf.get(i) {
            wide::fetch(step);
        }
    }

    /// Asks for the memory that [`Table1D::sample_discrete`] looks at first.
    #[inline]
    pub(super) fn fetch_guide(&self, u: f32) {
        let m = self.guide.len() - 1;
        wide::fetch(&self.guide[((u * m as f32) as usize).min(m - 1)]);
    }

    /// Asks for the memory that it looks at next.
    #[inline]
    pub(super) fn fetch_cells(&self, u: f32) {
        let m = self.guide.len() - 1;
        let k = ((u * m as f32) as usize).min(m - 1);
        wide::fetch(&self.cdf[(self.guide[k] as usize + self.guide[k + 1] as usize) / 2]);
    }

    /// Draws a cell: (i, Pᵢ, u stretched over the cell to a fresh uniform number in [0, 1)).
    #[inline]
    pub fn sample_discrete(&self, u: f32) -> (usize, f32, f32) {
        // The last cell that begins at or below u lies between two guides.
        let (n, m) = (self.len(), self.guide.len() - 1);
        let k = ((u * m as f32) as usize).min(m - 1);
        let (low, high) = (self.guide[k] as usize, self.guide[k + 1] as usize);
        let mut i = low + self.cdf[low + 1..=high].partition_point(|&c| c <= u);
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
        (place(i, rest, self.len()), p * self.len() as f32)
    }

    /// The u that [`Table1D::sample`] takes to x.
    #[inline]
    pub fn invert(&self, x: f32) -> f32 {
        let n = self.len();
        let at = x.clamp(0.0, 1.0) * n as f32;
        let i = (at as usize).min(n - 1);
        let u = self.cdf[i] + (at - i as f32) * (self.cdf[i + 1] - self.cdf[i]);
        u.clamp(0.0, ONE_MINUS_EPSILON)
    }
}
