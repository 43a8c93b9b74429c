//! Tabulated densities in one and two dimensions: piecewise constant, bilinear, bilinear with parameters, and discrete choice.
//!
//! | symbol | meaning |
//! | --- | --- |
//! | fᵢ ≥ 0 | the table, n values |
//! | p(x) = n fᵢ / Σf | density over [0, 1), cell i = ⌊n x⌋ |
//! | Pᵢ = fᵢ / Σf | probability of the discrete choice i |
//! | F⁻¹(u) | the inverse of the cumulative distribution, which sampling evaluates |
//! | p(x, y) = p(x \| y) p(y) | in two dimensions: the row first, then the place within it |
//!
//! Prefix sums are formed in f64 and kept as f32 steps of the cumulative distribution; the probability of a cell is *defined* as the step that
//! sampling uses, so that density and frequency agree however lopsided the table is, and a value of zero is never drawn. A guide table
//! [Chen, Asau 1974] starts the search where u points, so that a draw costs the same in a table of ten and of ten thousand values. Monotone in u:
//! stratified u give stratified draws.

mod bilinear;
mod one;
mod sheets;
mod steps;
mod two;

pub use bilinear::{Bilinear2D, sample_linear};
pub use one::Table1D;
pub use sheets::{Around, Sheets, Warp};
pub use two::{Cells, Table2D};

use crate::math::ONE_MINUS_EPSILON;
use std::cmp::Ordering;

/// (i + rest)/n, moved by an ulp or two where rounding would carry it into a neighbour of cell i = ⌊n x⌋.
#[inline]
fn place(i: usize, rest: f32, n: usize) -> f32 {
    let mut x = ((i as f32 + rest) / n as f32).min(ONE_MINUS_EPSILON);
    for _ in 0..2 {
        match ((x * n as f32) as usize).min(n - 1).cmp(&i) {
            Ordering::Less => x = x.next_up(),
            Ordering::Equal => break,
            Ordering::Greater => x = x.next_down(),
        }
    }
    x
}
