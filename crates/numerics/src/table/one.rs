//! One dimension.

use super::steps::{Steps, append};

/// A piecewise-constant density over [0, 1), and the discrete choice among its cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Table1D {
    cdf: Vec<f32>,
    guide: Vec<u32>,
    /// Σf.
    sum: f64,
}

impl Table1D {
    /// The table of `f`. Negative and non-finite values count as zero; a table without weight (or empty) is uniform, and says so by [`Table1D::sum`] = 0.
    pub fn new(f: &[f32]) -> Self {
        let (mut cdf, mut guide) = (Vec::new(), Vec::new());
        let sum = append(f, f.len().max(1), &mut cdf, &mut guide);
        Self { cdf, guide, sum }
    }

    /// The same table, its values scaled to another Σf.
    pub(super) fn with_sum(self, sum: f64) -> Self {
        Self { sum, ..self }
    }

    #[inline(always)]
    fn steps(&self) -> Steps<'_> {
        Steps::new(&self.cdf, &self.guide)
    }

    /// The number of cells.
    #[inline]
    pub fn len(&self) -> usize {
        self.steps().len()
    }

    /// Never: a table has at least one cell.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Σf over the usable values; 0 where the table had no weight and is uniform instead.
    #[inline]
    pub fn sum(&self) -> f64 {
        self.sum
    }

    /// The probability of the discrete choice i; 0 beyond the table.
    #[inline]
    pub fn probability(&self, i: usize) -> f32 {
        self.steps().probability(i)
    }

    /// Draws a cell: (i, Pᵢ, u stretched over the cell to a fresh uniform number in [0, 1)).
    #[inline]
    pub fn sample_discrete(&self, u: f32) -> (usize, f32, f32) {
        self.steps().sample_discrete(u)
    }

    /// p(x) on [0, 1); zero elsewhere.
    #[inline]
    pub fn pdf(&self, x: f32) -> f32 {
        self.steps().pdf(x)
    }

    /// Draws x in [0, 1): (x, p(x)).
    #[inline]
    pub fn sample(&self, u: f32) -> (f32, f32) {
        self.steps().sample(u)
    }

    /// The u that [`Table1D::sample`] takes to x.
    #[inline]
    pub fn invert(&self, x: f32) -> f32 {
        self.steps().invert(x)
    }
}
