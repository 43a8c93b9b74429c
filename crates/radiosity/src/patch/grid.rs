//! How a chart is cut into cells near a target size h.
//!
//! ```text
//! quad       n x m cells, n = round(longer of two opposite sides / h)
//! triangle   n² triangles, n = round(√(2 A) / h)
//! sphere     bands of equal angle, round(π r / h) of them, each of about 2π r sinθ / h cells, at least 3
//! cylinder   round(height / h) x round(2π r / h) cells, at least 3 around
//! disk       rings of equal width, round(r / h) of them, each of about 2π ρ / h cells, at least 3
//! ```
//!
//! The bands of a sphere and the rings of a disk have b 2^k cells, one b (3, 4 or 5) for all: sides of neighbours are wholes or halves of each other.
//! Two charts that share a whole side of one length cut it alike. Round shapes no larger than h stay whole.

use super::chart::Chart;
use super::round::Round;
use super::span::Span;
use glam::DVec2;
use std::f64::consts::{PI, TAU};

/// The most cells along one side: what is asked beyond that is a mistake, and is told as too many patches.
const MOST: f64 = 65_535.0;

/// Cells of a chart, numbered row by row.
#[derive(Clone, Debug)]
pub enum Grid {
    /// n along the side of a triangle: in row j, n - j of them upright and n - j - 1 on their heads, in turns.
    Triangle(u32),
    /// Columns and rows of a square.
    Square([u32; 2]),
    /// Rows of their own height and number of cells.
    Rows(Box<[Row]>),
}

/// Cells side by side in t0 ≤ t ≤ t1.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    t0: f64,
    t1: f64,
    cells: u32,
    /// The number of the first cell.
    first: u32,
}

impl Grid {
    /// The cells of `chart`, near `h` metres in size; infinity leaves it whole.
    pub fn new(chart: &Chart, h: f64) -> Self {
        let steps = |length: f64, least: f64| (length / h).round().clamp(least, MOST) as u32;
        match chart {
            Chart::Triangle { .. } => Self::Triangle(steps(chart.stretch(DVec2::ZERO).sqrt(), 1.0)),
            Chart::Quad { corners: [a, b, c, d], .. } => {
                let longer = |x: f64, y: f64| steps(x.max(y), 1.0);
                Self::Square([longer(a.distance(*b), d.distance(*c)), longer(a.distance(*d), b.distance(*c))])
            }
            Chart::Round { .. } if chart.area(&Span::WHOLE) <= h * h => Self::Square([1, 1]),
            Chart::Round { shape, to_world, .. } => {
                let m = to_world.matrix3;
                let r = (0.5 * (m.x_axis.length_squared() + m.y_axis.length_squared())).sqrt();
                match shape {
                    Round::Sphere => {
                        let n = steps(PI * r.max(m.z_axis.length()), 2.0);
                        let angle = |k: u32| PI * f64::from(k) / f64::from(n);
                        let around = |k: u32| TAU * r * (angle(k) + 0.5 * angle(1)).sin() / h;
                        rows(n, |k| 0.5 * (1.0 - angle(k).cos()), around, TAU * r / h)
                    }
                    Round::Cylinder => Self::Square([steps(TAU * r, 3.0), steps(m.z_axis.length(), 1.0)]),
                    Round::Disk => {
                        let n = steps(r, 1.0);
                        let radius = |k: u32| f64::from(k) / f64::from(n);
                        rows(n, |k| radius(k).powi(2), |k| TAU * r * (radius(k) + 0.5 * radius(1)) / h, TAU * r / h)
                    }
                }
            }
        }
    }

    /// How many cells.
    pub fn count(&self) -> usize {
        match self {
            Self::Triangle(n) => *n as usize * *n as usize,
            Self::Square([n, m]) => *n as usize * *m as usize,
            Self::Rows(rows) => rows.last().map_or(0, |r| (r.first + r.cells) as usize),
        }
    }

    /// All cells, in order.
    pub fn cells(&self) -> Vec<Span> {
        let mut cells = Vec::with_capacity(self.count());
        match self {
            Self::Triangle(n) => {
                let h = 1.0 / f64::from(*n);
                for j in 0..*n {
                    for i in 0..n - j {
                        let at = |i: u32, j: u32| DVec2::new(i.into(), j.into()) * h;
                        cells.push(Span { at: at(i, j), size: DVec2::splat(h) });
                        if i + 1 < n - j {
                            cells.push(Span { at: at(i + 1, j + 1), size: DVec2::splat(-h) });
                        }
                    }
                }
            }
            Self::Square([n, m]) => {
                let size = DVec2::new(1.0 / f64::from(*n), 1.0 / f64::from(*m));
                for j in 0..*m {
                    cells.extend((0..*n).map(|i| Span { at: DVec2::new(i.into(), j.into()) * size, size }));
                }
            }
            Self::Rows(rows) => {
                for row in rows {
                    let size = DVec2::new(1.0 / f64::from(row.cells), row.t1 - row.t0);
                    cells.extend((0..row.cells).map(|i| Span { at: DVec2::new(f64::from(i) * size.x, row.t0), size }));
                }
            }
        }
        cells
    }

    /// The cell that holds parameters of the chart; the nearest where rounding has put them outside.
    #[inline]
    pub fn find(&self, st: DVec2) -> usize {
        let cell = |x: f64, n: u32| ((x * f64::from(n)) as u32).min(n - 1);
        match self {
            Self::Triangle(1) | Self::Square([1, 1]) => 0,
            Self::Triangle(n) => {
                let j = cell(st.y, *n);
                let i = cell(st.x, *n).min(n - 1 - j);
                // Beyond the diagonal of its square a point is in the triangle that stands on its head.
                let inner = st * f64::from(*n) - DVec2::new(i.into(), j.into());
                let turned = inner.element_sum() > 1.0 && i + 1 < n - j;
                j as usize * (2 * n - j) as usize + 2 * i as usize + usize::from(turned)
            }
            Self::Square([n, m]) => cell(st.y, *m) as usize * *n as usize + cell(st.x, *n) as usize,
            Self::Rows(rows) => {
                let row = &rows[rows.partition_point(|r| r.t1 < st.y).min(rows.len() - 1)];
                (row.first + cell(st.x, row.cells)) as usize
            }
        }
    }
}

/// `n` rows between the heights `t(k)` and `t(k + 1)`, each of about `cells(k)` cells; `most` is about the number in the longest.
fn rows(n: u32, t: impl Fn(u32) -> f64, cells: impl Fn(u32) -> f64, most: f64) -> Grid {
    // The base that comes nearest to `most`, and the doubling of it nearest to each row's number.
    let doublings = |base: f64, cells: f64| (cells / base).log2().round().clamp(0.0, 14.0);
    let off = |base: f64| (base * doublings(base, most).exp2() / most).ln().abs();
    let base = [4.0, 3.0, 5.0].into_iter().min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(4.0);
    let mut first = 0;
    let row = |k: u32| {
        let cells = (base * doublings(base, cells(k)).exp2()) as u32;
        let row = Row { t0: t(k), t1: if k + 1 == n { 1.0 } else { t(k + 1) }, cells, first };
        first += row.cells;
        row
    };
    Grid::Rows((0..n).map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DAffine3, DVec3};

    #[test]
    fn every_cell_is_found_and_they_fill_the_chart() {
        let m = DAffine3::from_scale(DVec3::new(1.0, 1.0, 2.0));
        let round = |shape| Chart::Round { shape, to_world: m, to_object: m.inverse(), outward: 1.0 };
        let charts = [
            Chart::Triangle { corners: [DVec3::ZERO, DVec3::X * 2.0, DVec3::Y], n: DVec3::Z },
            Chart::Quad { corners: [DVec3::ZERO, DVec3::X * 2.0, DVec3::new(1.8, 1.0, 0.0), DVec3::Y], n: DVec3::Z },
            round(Round::Sphere),
            round(Round::Cylinder),
            round(Round::Disk),
        ];
        for chart in charts {
            for h in [f64::INFINITY, 0.9, 0.31, 0.1] {
                let grid = Grid::new(&chart, h);
                let cells = grid.cells();
                assert_eq!(cells.len(), grid.count());
                let whole = chart.area(&Span::WHOLE);
                let sum: f64 = cells.iter().map(|c| chart.area(c)).sum();
                assert!((sum / whole - 1.0).abs() < 1e-6, "{chart:?}, {h}: {sum} of {whole}");
                for (i, cell) in cells.iter().enumerate() {
                    let inside = if chart.is_triangle() { DVec2::splat(0.3) } else { DVec2::new(0.9, 0.1) };
                    assert_eq!(grid.find(cell.global(inside)), i, "{chart:?}");
                }
                if h < 0.2 {
                    // Cells have the size asked for, on the whole.
                    let size = (whole / cells.len() as f64 * if chart.is_triangle() { 2.0 } else { 1.0 }).sqrt();
                    assert!((size / h - 1.0).abs() < 0.35, "{chart:?}: {size}");
                }
            }
        }
    }
}
