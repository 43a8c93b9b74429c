//! Form factors that obey physics: reciprocity and closure, restored in double precision.
//!
//! ```text
//! S_ij = A_i A_j (F_ij + F_ji) / (A_i + A_j)          A_i F_ij and A_j F_ji, each weighted by the inverse of its variance under equal rays
//! x_i ← x_i √(A_i / (x_i (S x)_i + x_i s_i))          until every row closes;  s_i = A_i · (what patch i loses)
//! F'_ij = x_i S_ij x_j / A_i
//! ```
//!
//! The first step makes the exchange symmetric, the second scales it symmetrically, so it stays so. In a closed scene s = 0 and Σ_j F'_ij = 1. In
//! an open one what a row loses (escaped, absorbed by what is no patch) counts as one more exchange that is not scaled on its other end:
//! every row and its loss then sum to one, and the loss moves a little with the rest. Where losses are known only as what rows lack (`analytic`,
//! `area`), rows of an open scene have nothing to be closed to: there the exchange is made symmetric, and scaled down where a row exceeds one.

use super::{FormFactors, Matrix, Rows};
use rayon::prelude::*;

/// How near to one every row gets.
pub const CLOSED: f64 = 1e-13;

/// Sweeps of scaling at most.
const SWEEPS: usize = 4000;

/// What the repair found and did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Repair {
    /// Whether no light is lost: all rows are to sum to one.
    pub closed: bool,
    /// Largest |1 - Σ_j F_ij - losses| before.
    pub closure_before: f64,
    /// The same after.
    pub closure_after: f64,
    /// Σ |A_i F_ij - A_j F_ji| / Σ A before; the same after is zero.
    pub reciprocity_before: f64,
    /// Σ A_i |F'_ij - F_ij| / Σ A: the part of all light that went elsewhere when the exchange was made symmetric.
    pub moved_by_symmetry: f64,
    /// The same by scaling.
    pub moved_by_scaling: f64,
    /// Largest |x_i - 1|.
    pub largest_scale: f64,
    /// Sweeps of scaling.
    pub sweeps: usize,
}

impl FormFactors {
    /// Restores reciprocity, and closure where rows have something to be closed to, given the areas of the patches in m².
    pub fn repair(&mut self, areas: &[f64]) -> Repair {
        let total: f64 = areas.iter().sum();
        let losses: Vec<f64> = (0..self.len()).map(|i| self.escaped[i] + self.absorbed[i]).collect();
        let closed = losses.iter().all(|l| *l == 0.0);
        let measured = closed || self.losses_are_measured;
        let closure_before = largest((0..self.len()).into_par_iter().map(|i| (1.0 - self.row_sum(i) - losses[i]).abs()));

        let (matrix, off) = symmetric(self, areas);
        self.matrix = matrix;
        let sinks: Vec<f64> = losses.iter().zip(areas).map(|(l, a)| if measured { l * a } else { 0.0 }).collect();
        let (x, sweeps) = if measured { close(&self.matrix.rows, areas, &sinks) } else { lower(&self.matrix.rows, areas) };

        let scaled = |i: usize| {
            self.matrix
                .rows
                .outer_view(i)
                .map_or(0.0, |row| row.iter().map(|(j, s)| f64::from(*s) * (x[i] * x[j] - 1.0).abs()).sum())
        };
        let moved: Vec<f64> = (0..self.len()).into_par_iter().map(scaled).collect();
        self.left = x.iter().zip(areas).map(|(x, a)| x / a).collect();
        self.escaped.iter_mut().zip(&x).for_each(|(lost, x)| *lost *= x);
        self.absorbed.iter_mut().zip(&x).for_each(|(lost, x)| *lost *= x);
        self.right = x;
        if !measured {
            for i in 0..self.len() {
                self.escaped[i] = (1.0 - self.row_sum(i)).max(0.0);
            }
        }
        let lost = |i: usize| self.escaped[i] + self.absorbed[i];
        Repair {
            closed,
            closure_before,
            closure_after: largest((0..self.len()).into_par_iter().map(|i| (1.0 - self.row_sum(i) - lost(i)).abs())),
            reciprocity_before: off / total,
            // Each pair of entries meets between the two.
            moved_by_symmetry: 0.5 * off / total,
            moved_by_scaling: moved.iter().sum::<f64>() / total,
            largest_scale: self.right.iter().map(|x| (x - 1.0).abs()).fold(0.0, f64::max),
            sweeps,
        }
    }
}

fn largest(values: impl ParallelIterator<Item = f64>) -> f64 {
    values.reduce(|| 0.0, f64::max)
}

/// S with its standard errors, and Σ |A_i F_ij - A_j F_ji|.
fn symmetric(f: &FormFactors, areas: &[f64]) -> (Matrix, f64) {
    let n = f.len();
    let with_errors = !f.matrix.errors.is_empty();
    let transposed = transpose(&f.matrix);
    let rows = |m: &Matrix, i: usize| {
        let range = m.rows.indptr().outer_inds_sz(i);
        (range.start, range.end)
    };

    // Union of the columns of row i of both, handed over with their entries' places.
    let union = |i: usize, visit: &mut dyn FnMut(u32, Option<usize>, Option<usize>)| {
        let ((mut a, a_end), (mut b, b_end)) = (rows(&f.matrix, i), rows(&transposed, i));
        let (ca, cb) = (f.matrix.rows.indices(), transposed.rows.indices());
        while a < a_end || b < b_end {
            let (ja, jb) = (if a < a_end { ca[a] } else { u32::MAX }, if b < b_end { cb[b] } else { u32::MAX });
            let j = ja.min(jb);
            let (at, of) = ((ja == j).then_some(a), (jb == j).then_some(b));
            visit(j, at, of);
            a += usize::from(at.is_some());
            b += usize::from(of.is_some());
        }
    };
    let lengths: Vec<usize> = (0..n)
        .into_par_iter()
        .map(|i| {
            let mut length = 0;
            union(i, &mut |_, _, _| length += 1);
            length
        })
        .collect();
    let mut begins = vec![0];
    begins.extend(lengths.iter().scan(0, |end, l| {
        *end += l;
        Some(*end)
    }));
    let entries = begins[n];
    let (mut columns, mut values) = (vec![0u32; entries], vec![0f32; entries]);
    let mut errors = vec![0f32; if with_errors { entries } else { 0 }];

    let each = strips(&mut columns, &lengths).into_par_iter().zip(strips(&mut values, &lengths));
    let of_errors = if with_errors { strips(&mut errors, &lengths) } else { (0..n).map(|_| &mut [][..]).collect() };
    let off: Vec<f64> = each
        .zip(of_errors)
        .enumerate()
        .map(|(i, ((columns, values), errors))| {
            let (mut k, mut off) = (0, 0.0);
            union(i, &mut |j, at, of| {
                let number = |data: &[f32], place: Option<usize>| place.map_or(0.0, |p| f64::from(data[p]));
                let (f_ij, f_ji) = (number(f.matrix.rows.data(), at), number(transposed.rows.data(), of));
                let (a, b) = (areas[i], areas[j as usize]);
                let weight = a * b / (a + b);
                columns[k] = j;
                values[k] = (weight * (f_ij + f_ji)) as f32;
                if with_errors {
                    let (e, g) = (number(&f.matrix.errors, at), number(&transposed.errors, of));
                    errors[k] = (weight * (e * e + g * g).sqrt()) as f32;
                }
                off += (a * f_ij - b * f_ji).abs();
                k += 1;
            });
            off
        })
        .collect();
    (Matrix { rows: Rows::new((n, n), begins, columns, values), errors }, off.iter().sum())
}

/// Pieces of the given lengths, one after the other.
fn strips<'a, T>(mut all: &'a mut [T], lengths: &[usize]) -> Vec<&'a mut [T]> {
    lengths
        .iter()
        .map(|l| {
            let (piece, rest) = std::mem::take(&mut all).split_at_mut(*l);
            all = rest;
            piece
        })
        .collect()
}

/// The transposed matrix, rows again, columns in order.
fn transpose(m: &Matrix) -> Matrix {
    let n = m.rows.cols();
    let mut begins = vec![0usize; n + 1];
    m.rows.indices().iter().for_each(|j| begins[*j as usize + 1] += 1);
    (0..n).for_each(|j| begins[j + 1] += begins[j]);
    let mut next = begins.clone();
    let (mut columns, mut values) = (vec![0u32; m.rows.nnz()], vec![0f32; m.rows.nnz()]);
    let mut errors = vec![0f32; m.errors.len()];
    for i in 0..m.rows.rows() {
        for k in m.rows.indptr().outer_inds_sz(i) {
            let place = &mut next[m.rows.indices()[k] as usize];
            (columns[*place], values[*place]) = (i as u32, m.rows.data()[k]);
            if let Some(e) = m.errors.get(k) {
                errors[*place] = *e;
            }
            *place += 1;
        }
    }
    Matrix { rows: Rows::new((n, m.rows.rows()), begins, columns, values), errors }
}

/// (S x)_i of all rows.
fn product(s: &Rows, x: &[f64]) -> Vec<f64> {
    let row = |i: usize| {
        let range = s.indptr().outer_inds_sz(i);
        s.indices()[range.clone()].iter().zip(&s.data()[range]).map(|(j, s)| f64::from(*s) * x[*j as usize]).sum()
    };
    (0..x.len()).into_par_iter().with_min_len(64).map(row).collect()
}

/// x with x_i ((S x)_i + s_i) = A_i, and how many sweeps that took. Rows without entries are left alone.
fn close(s: &Rows, areas: &[f64], sinks: &[f64]) -> (Vec<f64>, usize) {
    let mut x = vec![1.0; areas.len()];
    for sweep in 0..SWEEPS {
        let sx = product(s, &x);
        let row = |i: usize| x[i] * (sx[i] + sinks[i]) / areas[i];
        let off = (0..x.len()).map(row).filter(|r| *r > 0.0).map(|r| (r - 1.0).abs()).fold(0.0, f64::max);
        if off <= CLOSED {
            return (x, sweep);
        }
        for i in 0..x.len() {
            let r = x[i] * (sx[i] + sinks[i]) / areas[i];
            if r > 0.0 {
                x[i] /= r.sqrt();
            }
        }
    }
    (x, SWEEPS)
}

/// x ≤ 1 with x_i (S x)_i ≤ A_i.
fn lower(s: &Rows, areas: &[f64]) -> (Vec<f64>, usize) {
    let mut x = vec![1.0; areas.len()];
    for sweep in 0..SWEEPS {
        let sx = product(s, &x);
        let off = (0..x.len()).map(|i| x[i] * sx[i] / areas[i] - 1.0).fold(0.0, f64::max);
        if off <= CLOSED {
            return (x, sweep);
        }
        for i in 0..x.len() {
            let r = x[i] * sx[i] / areas[i];
            if r > 1.0 {
                x[i] /= r.sqrt();
            }
        }
    }
    (x, SWEEPS)
}
