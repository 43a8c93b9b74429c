//! Spans: the part of a chart's parameters that a cell takes.

use super::chart::Chart;
use super::round::Round;
use glam::DVec2;

/// A part of a chart's parameters: [at, at + size] of a square, or the triangle at, at + (size.x, 0), at + (0, size.y), which stands on its
/// head where the size is below zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// The first corner.
    pub at: DVec2,
    /// The extent along s and t.
    pub size: DVec2,
}

impl Span {
    /// All of the parameters.
    pub const WHOLE: Self = Self { at: DVec2::ZERO, size: DVec2::ONE };

    /// The corners of a rectangle, around.
    pub fn corners(&self) -> [DVec2; 4] {
        let (a, b) = (self.at, self.at + self.size);
        [a, DVec2::new(b.x, a.y), b, DVec2::new(a.x, b.y)]
    }

    /// The corners of a triangle.
    pub fn triangle(&self) -> [DVec2; 3] {
        let [a, b, _, c] = self.corners();
        [a, b, c]
    }

    /// Coordinates within, [0, 1]² or barycentrics (b1, b2), of parameters of the chart.
    #[inline]
    pub fn local(&self, st: DVec2) -> DVec2 {
        (st - self.at) / self.size
    }

    /// The inverse of [`Span::local`].
    #[inline]
    pub fn global(&self, local: DVec2) -> DVec2 {
        self.at + local * self.size
    }

    /// Its four quarters.
    pub fn quarters(&self, triangle: bool) -> [Self; 4] {
        let half = 0.5 * self.size;
        let [x, y] = [DVec2::new(half.x, 0.0), DVec2::new(0.0, half.y)];
        let last = if triangle { -half } else { half };
        [(DVec2::ZERO, half), (x, half), (y, half), (half, last)].map(|(offset, size)| Self { at: self.at + offset, size })
    }

    /// The quarter that holds a local point.
    pub fn quarter_of(local: DVec2, triangle: bool) -> usize {
        let (x, y) = (local.x >= 0.5, local.y >= 0.5);
        match (triangle, x, y) {
            (false, ..) => usize::from(x) + 2 * usize::from(y),
            (true, true, _) => 1,
            (true, _, true) => 2,
            (true, ..) if local.element_sum() <= 0.5 => 0,
            (true, ..) => 3,
        }
    }

    /// ∫ f ds dt over a rectangle: Gauss-Legendre, 8 x 8 points for each 32nd of a turn and quarter of the height.
    pub fn integrate(&self, f: impl Fn(DVec2) -> f64) -> f64 {
        let pieces = (self.size.abs() * DVec2::new(32.0, 4.0)).ceil().max(DVec2::ONE);
        let piece = self.size / pieces;
        let mut sum = 0.0;
        for i in 0..pieces.x as u32 {
            for j in 0..pieces.y as u32 {
                let at = self.at + DVec2::new(i.into(), j.into()) * piece;
                for (x, wx) in crate::quadrature::gauss(8) {
                    for (y, wy) in crate::quadrature::gauss(8) {
                        sum += wx * wy * f(at + DVec2::new(*x, *y) * piece);
                    }
                }
            }
        }
        sum * piece.x * piece.y
    }

    /// The point in the midst by area: exact for flat cells, the middle of the parameters otherwise.
    pub fn middle(&self, chart: &Chart) -> DVec2 {
        match chart {
            Chart::Triangle { .. } => self.global(DVec2::splat(1.0 / 3.0)),
            Chart::Quad { .. } if chart.is_even() => self.global(DVec2::splat(0.5)),
            Chart::Quad { .. } => {
                let [a, b, c, d] = self.corners().map(|st| chart.point(st));
                let (left, right) = ((b - a).cross(c - a).length(), (c - a).cross(d - a).length());
                let middle = ((a + b + c) * left + (a + c + d) * right) / (3.0 * (left + right));
                chart.locate(middle)
            }
            Chart::Round { shape: Round::Disk, .. } if self.size.x > 0.5 => self.at,
            Chart::Round { .. } => self.global(DVec2::splat(0.5)),
        }
    }
}
