//! Contributions of light paths, which may fall anywhere.
//!
//! ```text
//! pixel_j = 1/N · Σ_i w_j(q_i) I_i / ∫_film w_j d²q,    w_j(q) = k(p_j - q) / Σ_l k(p_l - q)
//! ```
//!
//! N particles were started; I_i is the contribution of one that reached the film at q_i. A kernel's pixels around q sum to nearly, not exactly,
//! its integral: divided by their own sum they lose no energy. At the film's border the sum runs over the pixels that would be there, and the
//! integral makes up for what never falls beyond: the same mean as Σ k L / Σ k of the samples of pixels has.

use crate::fixed::{Fixed, Term};
use crate::tile::KernelTable;
use etendue_numerics::{Spectrum, Vec2, wide};
use std::ops::Range;

/// We·L/p of a light path at a position of the film. Its pixel's value is the sum of its splats over the particles started.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat {
    /// Pixels from the film's corner.
    pub position: Vec2,
    /// The contribution.
    pub value: Spectrum,
    /// Which particle, counted through all passes: what the record of dropped ones says.
    pub particle: u64,
}

/// So many splats ahead memory is asked for.
const AHEAD: usize = 2;

/// Pixels that one kernel reaches in a direction at most; wider ones are cut.
const REACH: usize = 32;

/// Weights of the pixels around a position, in one direction.
struct Weights {
    first: i32,
    count: usize,
    w: [f32; REACH],
}

impl Weights {
    const NONE: Self = Self { first: 0, count: 0, w: [0.0; REACH] };

    /// Becomes w_j around `q`, summing to 1.
    #[inline(always)]
    fn set(&mut self, kernel: &KernelTable, q: f32) {
        (self.first, self.count, self.w[0]) = (q.floor() as i32, 1, 1.0);
        if kernel.border() == 0 {
            return;
        }
        // Pixel j has its centre at j + 1/2; those with |j + 1/2 - q| < radius are reached.
        let radius = kernel.radius.min(0.5 * REACH as f32 - 1.0);
        let first = (q - 0.5 - radius).ceil() as i32;
        let last = (q - 0.5 + radius).floor() as i32;
        let count = (last - first + 1).clamp(1, REACH as i32) as usize;
        let mut total = 0.0;
        for (j, w) in self.w[..count].iter_mut().enumerate() {
            *w = kernel.eval((first + j as i32) as f32 + 0.5 - q);
            total += *w;
        }
        if total > 0.0 {
            self.w[..count].iter_mut().for_each(|w| *w /= total);
            (self.first, self.count) = (first, count);
        } else {
            self.w[0] = 1.0;
        }
    }

    /// The pixels within a range, and their weights.
    #[inline(always)]
    fn within(&self, range: &Range<i32>) -> (Range<i32>, &[f32]) {
        let (start, end) = (self.first.max(range.start), (self.first + self.count as i32).min(range.end));
        if start >= end {
            return (start..start, &[]);
        }
        (start..end, &self.w[(start - self.first) as usize..(end - self.first) as usize])
    }
}

/// ∫_film w_j dq for each of `count` columns or rows: 1 but near the border.
pub(crate) fn shares(kernel: &KernelTable, count: usize) -> Vec<f64> {
    const POINTS: usize = 64;
    let mut shares = vec![1.0; count];
    if kernel.border() == 0 {
        return shares;
    }
    let reach = (kernel.border() as usize + 1).min(REACH);
    let mut weights = Weights::NONE;
    let near_border = |j: usize| j < reach || j + reach >= count;
    shares.iter_mut().enumerate().filter(|(j, _)| near_border(*j)).for_each(|(_, s)| *s = 0.0);
    for pixel in (0..count).filter(|j| *j < 2 * reach || j + 2 * reach >= count) {
        for i in 0..POINTS {
            weights.set(kernel, pixel as f32 + (i as f32 + 0.5) / POINTS as f32);
            let (columns, of_columns) = weights.within(&(0..count as i32));
            for (j, w) in columns.zip(of_columns).filter(|(j, _)| near_border(*j as usize)) {
                shares[j as usize] += f64::from(*w) / POINTS as f64;
            }
        }
    }
    // A kernel with negative lobes has a share somewhat above or below what its area has; none is near zero.
    shares.iter_mut().for_each(|s| *s = s.max(0.05));
    shares
}

/// Adds splats to the pixels of some rows.
pub(crate) struct Stamps<'a> {
    pub splats: &'a [Splat],
    pub kernel: &'a KernelTable,
    pub pixels: &'a mut [[Fixed; 3]],
    pub width: i32,
    pub rows: Range<i32>,
}

impl wide::Job for Stamps<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let [mut x, mut y] = [Weights::NONE; 2];
        for (i, splat) in self.splats.iter().enumerate() {
            if let Some(next) = self.splats.get(i + AHEAD) {
                self.fetch(next);
            }
            x.set(self.kernel, splat.position.x);
            y.set(self.kernel, splat.position.y);
            let [r, g, b] = splat.value.to_rgb().map(Term::new);
            let ((columns, of_columns), (lines, of_lines)) = (x.within(&(0..self.width)), y.within(&self.rows));
            for (line, row) in lines.zip(of_lines) {
                let first = (line - self.rows.start) * self.width;
                let pixels = &mut self.pixels[(first + columns.start) as usize..(first + columns.end) as usize];
                for ([to_r, to_g, to_b], column) in pixels.iter_mut().zip(of_columns) {
                    let weight = row * column * (1 << Term::WEIGHT_BITS) as f32;
                    let weight = (weight + 0.5f32.copysign(weight)) as i32;
                    r.add_to(to_r, weight);
                    g.add_to(to_g, weight);
                    b.add_to(to_b, weight);
                }
            }
        }
    }
}

impl Stamps<'_> {
    /// Asks for the memory of a splat's pixels: splats fall anywhere, and each would be waited for.
    #[inline(always)]
    fn fetch(&self, splat: &Splat) {
        let (x, y, border) = (splat.position.x as i32, splat.position.y as i32, self.kernel.border());
        let columns = (x - border).max(0)..(x + border + 1).min(self.width);
        for line in (y - border).max(self.rows.start)..(y + border + 1).min(self.rows.end) {
            let first = (line - self.rows.start) * self.width;
            self.pixels[(first + columns.start) as usize..(first + columns.end) as usize].iter().for_each(wide::fetch);
        }
    }
}
