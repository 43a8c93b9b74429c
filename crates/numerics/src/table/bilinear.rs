//! The bilinear interpolant of values on a grid of nodes: what a filtered picture is, and so what an environment map wants to be drawn from.
//!
//! Between four nodes f(x, y) = (1 - y)((1 - x) f₀₀ + x f₁₀) + y ((1 - x) f₀₁ + x f₁₁), with mean (f₀₀ + f₁₀ + f₀₁ + f₁₁)/4. A patch is drawn
//! by its mean, then y by the linear marginal, then x by the linear conditional; the density is positive wherever f is.

use super::{Table2D, place};
use crate::Vec2;
use crate::math::{ONE_MINUS_EPSILON, lerp};

/// A bilinear density over [0, 1)²; node (0, 0) lies at the origin, the last node at (1, 1).
#[derive(Clone, Debug, PartialEq)]
pub struct Bilinear2D {
    nodes: Vec<f32>,
    width: usize,
    patches: Table2D,
}

impl Bilinear2D {
    /// The interpolant of `width` × `height` ≥ 2 × 2 node values, row by row; `None` for fewer nodes or too few values. Negative and non-finite
    /// values count as zero; without any weight the density is uniform.
    pub fn new(f: &[f32], width: usize, height: usize) -> Option<Self> {
        if width < 2 || height < 2 || f.len() < width.checked_mul(height)? {
            return None;
        }
        let clean = |&x: &f32| if x > 0.0 && x.is_finite() { x } else { 0.0 };
        let mut nodes: Vec<f32> = f[..width * height].iter().map(clean).collect();
        if nodes.iter().all(|&x| x == 0.0) {
            nodes.fill(1.0);
        }
        let mean = |x: usize, y: usize| {
            let i = y * width + x;
            0.25 * nodes[i] + 0.25 * nodes[i + 1] + 0.25 * nodes[i + width] + 0.25 * nodes[i + width + 1]
        };
        let means: Vec<f32> = (0..height - 1).flat_map(|y| (0..width - 1).map(move |x| (x, y))).map(|(x, y)| mean(x, y)).collect();
        let patches = Table2D::new(&means, width - 1, height - 1);
        Some(Self { nodes, width, patches })
    }

    /// ∫ f over [0, 1)²; of the uniform density 1 where the values had no weight.
    pub fn integral(&self) -> f64 {
        let (w, h) = self.patches.size();
        self.patches.sum() / (w * h) as f64
    }

    fn corners(&self, column: usize, row: usize) -> [f32; 4] {
        let i = row * self.width + column;
        [self.nodes[i], self.nodes[i + 1], self.nodes[i + self.width], self.nodes[i + self.width + 1]]
    }

    /// The density within a patch of probability `p`, at (x, y) of the patch.
    fn density(&self, [f00, f10, f01, f11]: [f32; 4], p: f32, x: f32, y: f32) -> f32 {
        let (w, h) = self.patches.size();
        let mean = 0.25 * f00 + 0.25 * f10 + 0.25 * f01 + 0.25 * f11;
        if mean > 0.0 { p * (w * h) as f32 * (lerp(y, lerp(x, f00, f10), lerp(x, f01, f11)) / mean) } else { 0.0 }
    }

    /// p(x, y) = f(x, y)/∫f on [0, 1)²; zero elsewhere.
    pub fn pdf(&self, p: Vec2) -> f32 {
        if !((0.0..1.0).contains(&p.x) && (0.0..1.0).contains(&p.y)) {
            return 0.0;
        }
        let (w, h) = self.patches.size();
        let (x, y) = (p.x * w as f32, p.y * h as f32);
        let (column, row) = ((x as usize).min(w - 1), (y as usize).min(h - 1));
        self.density(self.corners(column, row), self.patches.probability(column, row), x - column as f32, y - row as f32)
    }

    /// Draws a point of [0, 1)²: (point, p(point)).
    pub fn sample(&self, u: Vec2) -> (Vec2, f32) {
        let (column, row, p, rest) = self.patches.sample_discrete(u);
        let corners @ [f00, f10, f01, f11] = self.corners(column, row);
        let y = sample_linear(rest.y, f00 + f10, f01 + f11);
        let x = sample_linear(rest.x, lerp(y, f00, f01), lerp(y, f10, f11));
        let (w, h) = self.patches.size();
        (Vec2::new(place(column, x, w), place(row, y, h)), self.density(corners, p, x, y))
    }
}

/// x in [0, 1) with density 2 ((1 - x) a + x b)/(a + b): the root of the quadratic that does not cancel. Uniform for a = b = 0.
#[inline]
pub fn sample_linear(u: f32, a: f32, b: f32) -> f32 {
    // Scaled, so that the squares stay within range.
    let largest = a.max(b);
    if largest <= 0.0 {
        return u;
    }
    let (a, b) = (a / largest, b / largest);
    let denominator = a + lerp(u, a * a, b * b).sqrt();
    if denominator > 0.0 { (u * (a + b) / denominator).min(ONE_MINUS_EPSILON) } else { 0.0 }
}
