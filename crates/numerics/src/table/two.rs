//! Two dimensions, row by row.

use super::steps::{Steps, append, sizes};
use super::{Table1D, place};
use crate::Vec2;

/// A piecewise-constant density over [0, 1)², from a table in rows (x fastest).
#[derive(Clone, Debug, PartialEq)]
pub struct Table2D {
    /// Steps and guides of all rows, one row after the other.
    cdf: Vec<f32>,
    guide: Vec<u32>,
    /// So many of each a row.
    sizes: [usize; 2],
    width: usize,
    marginal: Table1D,
}

/// Cells that were drawn, side by side, as [`Table2D::sample_discrete`] tells of one.
#[derive(Clone, Debug)]
pub struct Cells<const N: usize> {
    /// Their columns.
    pub column: [u32; N],
    /// Their rows.
    pub row: [u32; N],
    /// Their probabilities.
    pub probability: [f32; N],
    /// Where in them, x and y.
    pub rest: [[f32; N]; 2],
}

impl<const N: usize> Default for Cells<N> {
    fn default() -> Self {
        Self { column: [0; N], row: [0; N], probability: [0.0; N], rest: [[0.0; N]; 2] }
    }
}

impl Table2D {
    /// The table of `width` × `height` values, row by row; missing values count as zero.
    pub fn new(f: &[f32], width: usize, height: usize) -> Self {
        let (width, height) = (width.max(1), height.max(1));
        let sizes = sizes(width);
        let (mut cdf, mut guide) = (Vec::with_capacity(height * sizes[0]), Vec::with_capacity(height * sizes[1]));
        let mut row = |y: usize| {
            let rest = f.get(y * width..).unwrap_or(&[]);
            append(&rest[..width.min(rest.len())], width, &mut cdf, &mut guide)
        };
        let sums: Vec<f64> = (0..height).map(&mut row).collect();
        // The largest row is one, lest the f32 marginal overflow.
        let largest = sums.iter().copied().fold(0.0, f64::max).max(f64::MIN_POSITIVE);
        let shares: Vec<f32> = sums.iter().map(|s| (s / largest) as f32).collect();
        let marginal = Table1D::new(&shares).with_sum(sums.iter().sum());
        Self { cdf, guide, sizes, width, marginal }
    }

    /// The steps of a row of the table.
    #[inline(always)]
    fn row(&self, y: usize) -> Steps<'_> {
        let [steps, guides] = self.sizes;
        Steps::new(&self.cdf[y * steps..][..steps], &self.guide[y * guides..][..guides])
    }

    /// Σf over all usable values; 0 where the table had no weight and is uniform instead.
    #[inline]
    pub fn sum(&self) -> f64 {
        self.marginal.sum()
    }

    /// Width and height of the table.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.marginal.len())
    }

    /// p(x, y) on [0, 1)²; zero elsewhere.
    #[inline]
    pub fn pdf(&self, p: Vec2) -> f32 {
        let y = self.marginal.pdf(p.y);
        if y == 0.0 {
            return 0.0;
        }
        let n = self.marginal.len();
        self.row(((p.y * n as f32) as usize).min(n - 1)).pdf(p.x) * y
    }

    /// Draws a point of [0, 1)²: (point, p(point)).
    #[inline]
    pub fn sample(&self, u: Vec2) -> (Vec2, f32) {
        let (row, p, rest) = self.marginal.sample_discrete(u.y);
        let n = self.marginal.len();
        let (x, px) = self.row(row).sample(u.x);
        (Vec2::new(x, place(row, rest, n)), px * (p * n as f32))
    }

    /// Draws a cell: (column, row, its probability, u stretched over the cell to a fresh uniform point of [0, 1)²).
    #[inline]
    pub fn sample_discrete(&self, u: Vec2) -> (usize, usize, f32, Vec2) {
        let (row, p, uy) = self.marginal.sample_discrete(u.y);
        let (column, px, ux) = self.row(row).sample_discrete(u.x);
        (column, row, px * p, Vec2::new(ux, uy))
    }

    /// [`Table2D::sample_discrete`] of the first `count` of many u, the same cells: what it looks up is asked for ahead, so that nobody waits for memory alone.
    pub fn sample_discrete_each<const N: usize>(&self, count: usize, [ux, uy]: &[[f32; N]; 2], cells: &mut Cells<N>) {
        for (i, (x, y)) in ux.iter().zip(uy).enumerate().take(count) {
            let (row, p, rest) = self.marginal.sample_discrete(*y);
            self.row(row).fetch_guide(*x);
            (cells.row[i], cells.probability[i], cells.rest[1][i]) = (row as u32, p, rest);
        }
        cells.row.iter().zip(ux).take(count).for_each(|(row, x)| self.row(*row as usize).fetch_cells(*x));
        for (i, x) in ux.iter().enumerate().take(count) {
            let (column, p, rest) = self.row(cells.row[i] as usize).sample_discrete(*x);
            (cells.column[i], cells.rest[0][i]) = (column as u32, rest);
            cells.probability[i] *= p;
        }
    }

    /// Asks for the memory that [`Table2D::probability`] looks at.
    #[inline]
    pub fn fetch(&self, column: usize, row: usize) {
        if row < self.marginal.len() {
            self.row(row).fetch(column);
        }
    }

    /// The probability of the cell in `column` and `row`; 0 beyond the table.
    #[inline]
    pub fn probability(&self, column: usize, row: usize) -> f32 {
        if row < self.marginal.len() { self.row(row).probability(column) * self.marginal.probability(row) } else { 0.0 }
    }

    /// The u that [`Table2D::sample`] takes to the point.
    #[inline]
    pub fn invert(&self, p: Vec2) -> Vec2 {
        let n = self.marginal.len();
        let row = ((p.y.max(0.0) * n as f32) as usize).min(n - 1);
        Vec2::new(self.row(row).invert(p.x), self.marginal.invert(p.y))
    }
}
