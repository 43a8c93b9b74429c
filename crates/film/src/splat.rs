//! Contributions of light paths, which may fall anywhere.
//!
//! ```text
//! pixel_j = 1/N · Σ_i w_j(q_i) I_i / ∫_film w_j d²q,    w_j(q) = k(p_j - q) / Σ_l k(p_l - q)
//! ```
//!
//! N particles were started; I_i is the contribution of one that reached the film at q_i. A kernel's pixels around q sum to nearly, not exactly,
//! its integral: divided by their own sum they lose no energy. At the film's border the sum runs over the pixels that would be there, and the
//! integral makes up for what never falls beyond: the same mean as Σ k L / Σ k of the samples of pixels has.

use crate::fixed::{Channels, Terms};
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

/// The first and the last pixel that the kernel around `q` reaches: pixel j has its centre at j + 1/2, and |j + 1/2 - q| < radius.
#[inline(always)]
fn reached(kernel: &KernelTable, q: f32) -> (i32, i32) {
    if kernel.border() == 0 {
        return (q.floor() as i32, q.floor() as i32);
    }
    let radius = kernel.radius.min(0.5 * REACH as f32 - 1.0);
    ((q - 0.5 - radius).ceil() as i32, (q - 0.5 + radius).floor() as i32)
}

/// Pixels of a row whose weights are made together.
const BLOCK: usize = 4;

/// Weights of the pixels around a position, in one direction.
struct Weights {
    first: i32,
    count: usize,
    w: [f32; REACH + BLOCK],
}

impl Weights {
    const NONE: Self = Self { first: 0, count: 0, w: [0.0; REACH + BLOCK] };

    /// Becomes w_j around `q`, summing to 1.
    #[inline(always)]
    fn set(&mut self, kernel: &KernelTable, q: f32) {
        (self.first, self.count, self.w[0]) = (q.floor() as i32, 1, 1.0);
        if kernel.border() == 0 {
            return;
        }
        let (first, last) = reached(kernel, q);
        let count = (last - first + 1).clamp(1, REACH as i32) as usize;
        let mut total = 0.0;
        for j in 0..count {
            self.w[j] = kernel.eval((first + j as i32) as f32 + 0.5 - q);
            total += self.w[j];
        }
        if total > 0.0 {
            for j in 0..count {
                self.w[j] /= total;
            }
            (self.first, self.count) = (first, count);
        } else {
            self.w[0] = 1.0;
        }
    }

    /// The pixels within a range.
    #[inline(always)]
    fn within(&self, start: i32, end: i32) -> Range<i32> {
        let start = self.first.max(start);
        start..(self.first + self.count as i32).min(end).max(start)
    }

    /// w_j, of one of the pixels reached.
    #[inline(always)]
    fn at(&self, j: i32) -> f32 {
        self.w[(j - self.first) as usize]
    }

    /// w_j of some pixels from j on, each times `scale` and rounded; what lies beyond those reached is anything.
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "iterators of pairs are not inlined into wide loops")]
    fn block(&self, j: i32, scale: f32) -> [i32; BLOCK] {
        let first = (j - self.first) as usize;
        let mut rounded = [0; BLOCK];
        for k in 0..BLOCK {
            let weight = self.w[first + k] * scale;
            rounded[k] = (weight + 0.5f32.copysign(weight)) as i32;
        }
        rounded
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
            for j in weights.within(0, count as i32).filter(|j| near_border(*j as usize)) {
                shares[j as usize] += f64::from(weights.at(j)) / POINTS as f64;
            }
        }
    }
    // A kernel with negative lobes has a share somewhat above or below what its area has; none is near zero.
    shares.iter_mut().for_each(|s| *s = s.max(0.05));
    shares
}

/// A splat without its number.
#[derive(Clone, Copy, Default)]
pub(crate) struct Landed {
    position: [f32; 2],
    value: [f32; 4],
}

/// Columns of a piece of a band, whose sums a core's caches hold.
const PIECE: usize = 64;

/// Splats in order of the bands of `rows` rows that they reach, within a band from piece to piece: those of band b stand in the b-th range. Who reaches
/// two bands stands in both.
pub(crate) fn by_band(
    splats: &[Splat],
    kernel: &KernelTable,
    width: usize,
    rows: usize,
    bands: usize,
) -> (Vec<Landed>, Vec<Range<usize>>) {
    let (pieces, border) = (width.div_ceil(PIECE), kernel.border() as usize);
    let touched = |s: &Splat| {
        let [x, y] = [s.position.x as usize, s.position.y as usize];
        let (first, last) = (y.saturating_sub(border) / rows, ((y + border) / rows).min(bands - 1));
        (first..=last).map(move |band| band * pieces + x / PIECE)
    };
    let mut ends = vec![0; bands * pieces + 1];
    splats.iter().flat_map(touched).for_each(|i| ends[i + 1] += 1);
    for i in 1..ends.len() {
        ends[i] += ends[i - 1];
    }
    let bands =
        ends.iter().step_by(pieces).zip(ends.iter().skip(pieces).step_by(pieces)).map(|(start, end)| *start..*end).collect();
    let mut sorted = vec![Landed::default(); ends[ends.len() - 1]];
    for splat in splats {
        for i in touched(splat) {
            sorted[ends[i]] = Landed { position: splat.position.into(), value: splat.value.0.into() };
            ends[i] += 1;
        }
    }
    (sorted, bands)
}

/// Adds splats to the pixels of some rows.
pub(crate) struct Stamps<'a> {
    pub splats: &'a [Landed],
    pub kernel: &'a KernelTable,
    pub pixels: &'a mut [Channels],
    pub width: i32,
    pub rows: Range<i32>,
}

impl wide::Job for Stamps<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let [mut x, mut y] = [Weights::NONE; 2];
        for i in 0..self.splats.len() {
            if let Some(next) = self.splats.get(i + AHEAD) {
                self.fetch(next);
            }
            let splat = &self.splats[i];
            x.set(self.kernel, splat.position[0]);
            y.set(self.kernel, splat.position[1]);
            let terms = Terms::new(splat.value);
            let (columns, lines) = (x.within(0, self.width), y.within(self.rows.start, self.rows.end));
            for line in lines.start..lines.end {
                let row = y.at(line) * (1 << Terms::WEIGHT_BITS) as f32;
                let first = (line - self.rows.start) * self.width;
                let pixels = &mut self.pixels[(first + columns.start) as usize..(first + columns.end) as usize];
                let mut column = columns.start;
                for some in pixels.chunks_mut(BLOCK) {
                    let weights = x.block(column, row);
                    for j in 0..some.len() {
                        terms.add_to(&mut some[j], weights[j]);
                    }
                    column += BLOCK as i32;
                }
            }
        }
    }
}

impl Stamps<'_> {
    /// Asks for the memory of a splat's pixels: splats fall anywhere, and each would be waited for.
    #[inline(always)]
    fn fetch(&self, splat: &Landed) {
        let of = |q: f32, within: &Range<i32>| {
            let (first, last) = reached(self.kernel, q);
            first.max(within.start)..(last + 1).min(within.end)
        };
        let columns = of(splat.position[0], &(0..self.width));
        for line in of(splat.position[1], &self.rows) {
            let first = (line - self.rows.start) * self.width;
            self.pixels[(first + columns.start) as usize..(first + columns.end) as usize].iter().for_each(wide::fetch);
        }
    }
}
