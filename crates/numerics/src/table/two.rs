//! Two dimensions, row by row.

use super::{Table1D, place};
use crate::Vec2;

/// A piecewise-constant density over [0, 1)², from a table in rows (x fastest).
#[derive(Clone, Debug, PartialEq)]
pub struct Table2D {
    rows: Vec<Table1D>,
    marginal: Table1D,
}

impl Table2D {
    /// The table of `width` × `height` values, row by row; missing values count as zero.
    pub fn new(f: &[f32], width: usize, height: usize) -> Self {
        let width = width.max(1);
        let row = |y: usize| Table1D::new(f.get(y * width..).map_or(&[], |rest| &rest[..width.min(rest.len())]));
        let rows: Vec<_> = (0..height.max(1)).map(row).collect();
        // The largest row is one, lest the f32 marginal overflow.
        let largest = rows.iter().map(Table1D::sum).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
        let sums: Vec<f32> = rows.iter().map(|r| (r.sum() / largest) as f32).collect();
        let marginal = Table1D::new(&sums);
        let marginal = marginal.with_sum(rows.iter().map(Table1D::sum).sum());
        Self { rows, marginal }
    }

    /// Σf over all usable values; 0 where the table had no weight and is uniform instead.
    #[inline]
    pub fn sum(&self) -> f64 {
        self.marginal.sum()
    }

    /// Width and height of the table.
    pub fn size(&self) -> (usize, usize) {
        (self.rows.first().map_or(0, Table1D::len), self.rows.len())
    }

    /// p(x, y) on [0, 1)²; zero elsewhere.
    #[inline]
    pub fn pdf(&self, p: Vec2) -> f32 {
        let y = self.marginal.pdf(p.y);
        if y == 0.0 {
            return 0.0;
        }
        let row = ((p.y * self.rows.len() as f32) as usize).min(self.rows.len() - 1);
        self.rows[row].pdf(p.x) * y
    }

    /// Draws a point of [0, 1)²: (point, p(point)).
    #[inline]
    pub fn sample(&self, u: Vec2) -> (Vec2, f32) {
        let (row, p, rest) = self.marginal.sample_discrete(u.y);
        let n = self.rows.len();
        let (x, px) = self.rows[row].sample(u.x);
        (Vec2::new(x, place(row, rest, n)), px * (p * n as f32))
    }

    /// Draws a cell: (column, row, its probability, u stretched over the cell to a fresh uniform point of [0, 1)²).
    #[inline]
    pub fn sample_discrete(&self, u: Vec2) -> (usize, usize, f32, Vec2) {
        let (row, p, uy) = self.marginal.sample_discrete(u.y);
        let (column, px, ux) = self.rows[row].sample_discrete(u.x);
        (column, row, px * p, Vec2::new(ux, uy))
    }

    /// [`Table2D::sample_discrete`] of many u, the same cells: what it looks up is asked for ahead, so that nobody waits for memory alone.
    pub fn sample_discrete_each(&self, u: &[Vec2], cells: &mut Vec<(usize, usize, f32, Vec2)>) {
        cells.clear();
        cells.extend(u.iter().map(|u| {
            let (row, p, uy) = self.marginal.sample_discrete(u.y);
            self.rows[row].fetch_guide(u.x);
            (0, row, p, Vec2::new(0.0, uy))
        }));
        cells.iter().zip(u).for_each(|((_, row, ..), u)| self.rows[*row].fetch_cells(u.x));
        for ((column, row, p, rest), u) in cells.iter_mut().zip(u) {
            let (found, px, ux) = self.rows[*row].sample_discrete(u.x);
            (*column, *p, rest.x) = (found, px * *p, ux);
        }
    }

    /// Asks for the memory that [`Table2D::probability`] looks at.
    #[inline]
    pub fn fetch(&self, column: usize, row: usize) {
        if let Some(row) = self.rows.get(row) {
            row.fetch(column);
        }
    }

    /// The probability of the cell in `column` and `row`; 0 beyond the table.
    #[inline]
    pub fn probability(&self, column: usize, row: usize) -> f32 {
        self.rows.get(row).map_or(0.0, |r| r.probability(column) * self.marginal.probability(row))
    }

    /// The u that [`Table2D::sample`] takes to the point.
    #[inline]
    pub fn invert(&self, p: Vec2) -> Vec2 {
        let row = ((p.y.max(0.0) * self.rows.len() as f32) as usize).min(self.rows.len() - 1);
        Vec2::new(self.rows[row].invert(p.x), self.marginal.invert(p.y))
    }
}
