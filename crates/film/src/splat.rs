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
use etendue_numerics::{Spectrum, Vec2};
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

/// Pixels that one kernel reaches in a direction at most; wider ones are cut.
const REACH: usize = 32;

/// Weights of the pixels around a position, in one direction.
#[derive(Clone, Copy)]
struct Weights {
    first: i32,
    count: usize,
    w: [f32; REACH],
}

impl Weights {
    /// w_j around `q`, summing to 1.
    #[inline]
    fn new(kernel: &KernelTable, q: f32) -> Self {
        let mut new = Self { first: q.floor() as i32, count: 1, w: [0.0; REACH] };
        if kernel.border() == 0 {
            new.w[0] = 1.0;
            return new;
        }
        // Pixel j has its centre at j + 1/2; those with |j + 1/2 - q| < radius are reached.
        let radius = kernel.radius.min(0.5 * REACH as f32 - 1.0);
        let first = (q - 0.5 - radius).ceil() as i32;
        let last = (q - 0.5 + radius).floor() as i32;
        let count = (last - first + 1).clamp(1, REACH as i32) as usize;
        for (j, w) in new.w[..count].iter_mut().enumerate() {
            *w = kernel.eval((first + j as i32) as f32 + 0.5 - q);
        }
        let total: f32 = new.w[..count].iter().sum();
        if total > 0.0 {
            new.w[..count].iter_mut().for_each(|w| *w /= total);
            (new.first, new.count) = (first, count);
        } else {
            new.w[0] = 1.0;
        }
        new
    }

    /// The pixels within a range, each with its weight.
    #[inline]
    fn within(&self, range: &Range<i32>) -> impl Iterator<Item = (i32, f32)> {
        (self.first..).zip(self.w[..self.count].iter().copied()).filter(|(j, _)| range.contains(j))
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
    let near_border = |j: usize| j < reach || j + reach >= count;
    shares.iter_mut().enumerate().filter(|(j, _)| near_border(*j)).for_each(|(_, s)| *s = 0.0);
    for pixel in (0..count).filter(|j| *j < 2 * reach || j + 2 * reach >= count) {
        for i in 0..POINTS {
            let weights = Weights::new(kernel, pixel as f32 + (i as f32 + 0.5) / POINTS as f32);
            for (j, w) in weights.within(&(0..count as i32)).filter(|(j, _)| near_border(*j as usize)) {
                shares[j as usize] += f64::from(w) / POINTS as f64;
            }
        }
    }
    // A kernel with negative lobes has a share somewhat above or below what its area has; none is near zero.
    shares.iter_mut().for_each(|s| *s = s.max(0.05));
    shares
}

/// A splat over the pixels that it reaches.
pub(crate) struct Stamp {
    x: Weights,
    y: Weights,
    value: [Term; 3],
}

impl Stamp {
    #[inline]
    pub(crate) fn new(splat: &Splat, kernel: &KernelTable) -> Self {
        let q = splat.position;
        Self { x: Weights::new(kernel, q.x), y: Weights::new(kernel, q.y), value: splat.value.to_rgb().map(Term::new) }
    }

    /// Adds its part within some rows to their pixels.
    #[inline]
    pub(crate) fn add(&self, pixels: &mut [[Fixed; 3]], width: i32, rows: Range<i32>) {
        for (y, row) in self.y.within(&rows) {
            for (x, column) in self.x.within(&(0..width)) {
                let pixel = &mut pixels[((y - rows.start) * width + x) as usize];
                let weight = row * column * (1 << Term::WEIGHT_BITS) as f32;
                let weight = (weight + 0.5f32.copysign(weight)) as i32;
                for (sum, v) in pixel.iter_mut().zip(self.value) {
                    *sum += v.times(weight);
                }
            }
        }
    }
}
