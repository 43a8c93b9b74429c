//! Bilinear tables that depend on parameters: a sheet of nodes for each value of each parameter, linear in between.
//!
//! ```text
//! f(x, y; a) = Σ_k w_k(a) f_k(x, y)        2^N sheets around a, each the bilinear interpolant of its nodes; Σ w_k = 1
//! p(x, y; a) = Σ_k w_k(a) p_k(x, y)        the same of sheets that integrate to one
//! ```
//!
//! Cumulative sums are linear in the nodes as well, so that a mixture of sheets is drawn exactly, by the mixture of their sums: the row by the
//! marginal, then the place within it [Dupuy, Jakob 2018, §4.2].
//!
//! Parameters beyond the ends of their axis count as at its ends.

use super::sample_linear;
use crate::Vec2;
use crate::math::{ONE_MINUS_EPSILON, lerp};

/// Sheets of `width` × `height` nodes over [0, 1]², for N ≤ 3 parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheets<const N: usize> {
    /// Columns and rows, at least two of each.
    size: [usize; 2],
    /// Rising values of each parameter, at least one.
    axes: [Vec<f32>; N],
    /// Sheet behind sheet, the last parameter fastest; each row by row.
    nodes: Vec<f32>,
}

/// The sheets around some parameters: where each begins, and its weight.
#[derive(Clone, Copy, Debug)]
pub struct Around {
    sheets: [(usize, f32); 8],
    len: usize,
}

impl Around {
    /// Σ_k w_k of `table`'s entries at `i` within each sheet's `stride` of them.
    #[inline]
    fn mix(&self, table: &[f32], stride: usize, i: usize) -> f32 {
        self.sheets[..self.len].iter().map(|&(sheet, w)| w * table[sheet * stride + i]).sum()
    }
}

/// A place within a cell of nodes.
#[derive(Clone, Copy, Debug)]
struct Cell {
    column: usize,
    row: usize,
    x: f32,
    y: f32,
}

impl<const N: usize> Sheets<N> {
    /// The table of these nodes; `None` where their number is not that of the axes and the size, an axis is empty or does not rise, or a sheet has fewer than
    /// 2 × 2 nodes.
    pub fn new(size: [usize; 2], axes: [Vec<f32>; N], nodes: Vec<f32>) -> Option<Self> {
        let rises = |axis: &Vec<f32>| !axis.is_empty() && axis.windows(2).all(|w| w[0] < w[1]);
        let count = axes.iter().try_fold(size[0].checked_mul(size[1])?, |n, axis| n.checked_mul(axis.len()))?;
        (N <= 3 && size[0] >= 2 && size[1] >= 2 && axes.iter().all(rises) && nodes.len() == count).then_some(Self {
            size,
            axes,
            nodes,
        })
    }

    /// The values of a parameter for which there are sheets.
    pub fn axis(&self, parameter: usize) -> &[f32] {
        &self.axes[parameter]
    }

    /// The sheets around parameters.
    #[inline]
    pub fn around(&self, parameters: [f32; N]) -> Around {
        let mut around = Around { sheets: [(0, 1.0); 8], len: 1 };
        for (axis, a) in self.axes.iter().zip(parameters) {
            let last = axis.len() - 1;
            let i = axis[..last].partition_point(|v| *v <= a).saturating_sub(1);
            let t = if last == 0 { 0.0 } else { ((a - axis[i]) / (axis[i + 1] - axis[i])).clamp(0.0, 1.0) };
            let before = around.len;
            for k in 0..before {
                let (sheet, w) = around.sheets[k];
                let first = sheet * axis.len() + i;
                around.sheets[k] = (first, w * (1.0 - t));
                if t > 0.0 {
                    around.sheets[around.len] = (first + 1, w * t);
                    around.len += 1;
                }
            }
        }
        around
    }

    /// f(x, y; a).
    #[inline]
    pub fn eval(&self, p: Vec2, around: &Around) -> f32 {
        let cell = self.cell(p);
        self.value(&cell, self.corners(&cell, around))
    }

    fn cell(&self, p: Vec2) -> Cell {
        let [w, h] = self.size;
        let place = |x: f32, n: usize| {
            let x = x.clamp(0.0, 1.0) * (n - 1) as f32;
            let i = (x as usize).min(n - 2);
            (i, x - i as f32)
        };
        let ((column, x), (row, y)) = (place(p.x, w), place(p.y, h));
        Cell { column, row, x, y }
    }

    #[inline]
    fn corners(&self, cell: &Cell, around: &Around) -> [f32; 4] {
        let [w, h] = self.size;
        let i = cell.row * w + cell.column;
        [i, i + 1, i + w, i + w + 1].map(|i| around.mix(&self.nodes, w * h, i))
    }

    fn value(&self, cell: &Cell, [f00, f10, f01, f11]: [f32; 4]) -> f32 {
        lerp(cell.y, lerp(cell.x, f00, f10), lerp(cell.x, f01, f11))
    }
}

/// A density over [0, 1)² that depends on parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Warp<const N: usize> {
    sheets: Sheets<N>,
    /// ∫ of each row up to each of its nodes.
    rows: Vec<f32>,
    /// ∫ of each sheet up to each of its rows.
    marginals: Vec<f32>,
}

impl<const N: usize> Warp<N> {
    /// The density whose sheets are those of `sheets`, each scaled to integrate to one. Negative and non-finite nodes count as zero; a sheet without any
    /// weight is uniform.
    pub fn new(mut sheets: Sheets<N>) -> Self {
        let [w, h] = sheets.size;
        let (mut rows, mut marginals) = (Vec::with_capacity(sheets.nodes.len()), Vec::new());
        for sheet in sheets.nodes.chunks_exact_mut(w * h) {
            for x in sheet.iter_mut() {
                *x = if *x > 0.0 && x.is_finite() { *x } else { 0.0 };
            }
            let largest = sheet.iter().fold(0.0f32, |a, b| a.max(*b));
            if largest == 0.0 {
                sheet.fill(1.0);
            }
            // Sums in f64 of the trapezes under each row, then of those under the rows' integrals.
            let prefix = |f: &[f64]| -> Vec<f64> {
                let mut sum = 0.0;
                let step = 1.0 / (f.len() - 1) as f64;
                let steps = f.windows(2).map(|f| {
                    sum += 0.5 * (f[0] + f[1]) * step;
                    sum
                });
                std::iter::once(0.0).chain(steps).collect()
            };
            let along: Vec<Vec<f64>> =
                sheet.chunks_exact(w).map(|row| prefix(&row.iter().map(|x| f64::from(*x)).collect::<Vec<_>>())).collect();
            let marginal = prefix(&along.iter().map(|row| row[w - 1]).collect::<Vec<_>>());
            let whole = marginal[h - 1];
            for x in sheet.iter_mut() {
                *x = (f64::from(*x) / whole) as f32;
            }
            rows.extend(along.iter().flatten().map(|x| (x / whole) as f32));
            marginals.extend(marginal.iter().map(|x| (x / whole) as f32));
        }
        Self { sheets, rows, marginals }
    }

    /// The sheets around parameters.
    #[inline]
    pub fn around(&self, parameters: [f32; N]) -> Around {
        self.sheets.around(parameters)
    }

    /// p(x, y; a) within [0, 1]².
    #[inline]
    pub fn pdf(&self, p: Vec2, around: &Around) -> f32 {
        self.sheets.eval(p, around)
    }

    /// Mixed sums: of the marginal up to row `i`, and of row `row` up to column `i`.
    #[inline]
    fn marginal(&self, around: &Around, i: usize) -> f32 {
        around.mix(&self.marginals, self.sheets.size[1], i)
    }

    #[inline]
    fn along(&self, around: &Around, row: usize, i: usize) -> f32 {
        let [w, h] = self.sheets.size;
        around.mix(&self.rows, w * h, row * w + i)
    }

    /// Draws a point of [0, 1)²: (point, p(point)).
    pub fn sample(&self, u: Vec2, around: &Around) -> (Vec2, f32) {
        let [w, h] = self.sheets.size;
        let (row, rest) = search(h, u.y * self.marginal(around, h - 1), |i| self.marginal(around, i));
        let ends = [self.along(around, row, w - 1), self.along(around, row + 1, w - 1)];
        let y = sample_linear(rest, ends[0], ends[1]);
        let (column, rest) =
            search(w, u.x * lerp(y, ends[0], ends[1]), |i| lerp(y, self.along(around, row, i), self.along(around, row + 1, i)));
        let corners @ [f00, f10, f01, f11] = self.sheets.corners(&Cell { column, row, x: 0.0, y }, around);
        let x = sample_linear(rest, lerp(y, f00, f01), lerp(y, f10, f11));
        let place = |i: usize, t: f32, n: usize| ((i as f32 + t) / (n - 1) as f32).min(ONE_MINUS_EPSILON);
        (Vec2::new(place(column, x, w), place(row, y, h)), self.sheets.value(&Cell { column, row, x, y }, corners))
    }

    /// The u that [`Warp::sample`] takes to the point, and p(point).
    pub fn invert(&self, p: Vec2, around: &Around) -> (Vec2, f32) {
        let [w, h] = self.sheets.size;
        let cell = self.sheets.cell(p);
        let Cell { column, row, x, y } = cell;
        let corners @ [f00, f10, f01, f11] = self.sheets.corners(&cell, around);
        // ∫₀ᵗ of a straight line from a to b, over a cell of n - 1.
        let part = |t: f32, a: f32, b: f32, n: usize| t * (a + 0.5 * t * (b - a)) / (n - 1) as f32;
        let ends = [self.along(around, row, w - 1), self.along(around, row + 1, w - 1)];
        let below = self.marginal(around, row) + part(y, ends[0], ends[1], h);
        let left = lerp(y, self.along(around, row, column), self.along(around, row + 1, column));
        let left = left + part(x, lerp(y, f00, f01), lerp(y, f10, f11), w);
        let share = |part: f32, whole: f32| if whole > 0.0 { (part / whole).clamp(0.0, ONE_MINUS_EPSILON) } else { 0.0 };
        let u = Vec2::new(share(left, lerp(y, ends[0], ends[1])), share(below, self.marginal(around, h - 1)));
        (u, self.sheets.value(&cell, corners))
    }
}

/// The step of the rising `sums`, n of them, that holds `at`, and which part of the step lies below it.
#[inline]
fn search(n: usize, at: f32, sums: impl Fn(usize) -> f32) -> (usize, f32) {
    let (mut low, mut high) = (0, n - 1);
    while high - low > 1 {
        let middle = low.midpoint(high);
        if sums(middle) <= at { low = middle } else { high = middle }
    }
    let (a, b) = (sums(low), sums(low + 1));
    (low, if b > a { ((at - a) / (b - a)).clamp(0.0, ONE_MINUS_EPSILON) } else { 0.0 })
}
