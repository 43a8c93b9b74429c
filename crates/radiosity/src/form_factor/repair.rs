//! Form factors that obey physics: reciprocity and closure, restored in double precision.
//!
//! ```text
//! S_ij = (N_i F_ij + N_j F_ji) / (N_i/A_i + N_j/A_j)   A_i F_ij and A_j F_ji, each weighted by the inverse of its variance under N_i and N_j rays
//! x_i ← x_i √(A_i / (x_i (S x)_i + x_i s_i))          until every row closes;  s_i = A_i · (what patch i loses)
//! F'_ij = x_i S_ij x_j / A_i
//! ```
//!
//! The first step makes the exchange symmetric, the second scales it symmetrically, so it stays so. In a closed scene s = 0 and Σ_j F'_ij = 1.
//!
//! An open scene is made reciprocal only ([`Open::Reciprocal`]): the exchange is symmetric, scaled down where a row exceeds one, and what a row lacks is
//! what escapes, or is absorbed by what is no patch, in the proportion that its rays found. Patches that rays were cast from may have what they lose
//! counted as one more exchange instead, that is not scaled on its other end ([`Open::WithLosses`]): rows and losses then sum to one as before. That
//! is what pictures want: by symmetry alone rows are as far off as the rays of all others are noisy, 1.3 % of `cornell-box` at 1024 rays.
//!
//! The scaling is sped up by Anderson's acceleration of log x over the last [`DEPTH`] sweeps [Anderson 1965]: a third of the sweeps.

use super::{FormFactors, Matrix, Rows};
use crate::choices::choices;
use rayon::prelude::*;
use std::collections::VecDeque;

/// How near to one every row gets.
pub const CLOSED: f64 = 1e-13;

/// Rows that are farther off could not be closed.
const UNCLOSED: f64 = 1e-9;

/// Sweeps of scaling at most.
const SWEEPS: usize = 4000;

/// Sweeps without a tenth of gain after which no more are made.
const PATIENCE: usize = 200;

/// Largest |ln x|: where rows cannot be closed it would grow without end.
const FARTHEST: f64 = 10.0;

/// Sweeps that the acceleration looks back on.
const DEPTH: usize = 4;

choices! {
    /// What an open scene's rows are brought to.
    Open {
        #[default]
        WithLosses = "losses", "One, together with what rays found lost; reciprocity alone where none were cast.";
        Reciprocal = "reciprocal", "Reciprocity, and no row above one: what a row lacks is lost.";
    }
}

/// What the repair found and did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Repair {
    /// Whether no light is lost: all rows are to sum to one.
    pub closed: bool,
    /// What the rows were brought to if light is lost.
    pub open: Open,
    /// Largest |1 - Σ_j F_ij - losses| before.
    pub closure_before: f64,
    /// The same after: more than rounding where too few rays found too little to close a row to. What it lacks counts as absorbed.
    pub closure_after: f64,
    /// Σ |A_i F_ij - A_j F_ji| / Σ A before; the same after is zero.
    pub reciprocity_before: f64,
    /// Σ A_i |F'_ij - F_ij| / Σ A: the part of all light that went elsewhere when the exchange was made symmetric.
    pub moved_by_symmetry: f64,
    /// What of that the noise of the estimates is expected to move; zero where it is not known.
    pub moved_by_noise: f64,
    /// The same as `moved_by_symmetry` by scaling.
    pub moved_by_scaling: f64,
    /// Largest |x_i - 1|.
    pub largest_scale: f64,
    /// Sweeps of scaling.
    pub sweeps: usize,
}

impl FormFactors {
    /// Restores reciprocity, and closure where rows have something to be closed to, given the areas of the patches in m².
    pub fn repair(&mut self, areas: &[f64], open: Open) -> Repair {
        self.repair_to(CLOSED, areas, open)
    }

    /// The same, with every row as near to one as `near`.
    pub fn repair_to(&mut self, near: f64, areas: &[f64], open: Open) -> Repair {
        let total: f64 = areas.iter().sum();
        let losses: Vec<f64> = (0..self.len()).map(|i| self.escaped[i] + self.absorbed[i]).collect();
        let closed = losses.iter().all(|l| *l == 0.0);
        let open = if self.losses_are_measured { open } else { Open::Reciprocal };
        let closes = closed || open == Open::WithLosses;
        let closure_before = largest((0..self.len()).into_par_iter().map(|i| (1.0 - self.row_sum(i) - losses[i]).abs()));

        let (matrix, [off, noise]) = symmetric(self, areas);
        self.matrix = matrix;
        let sinks: Vec<f64> = losses.iter().zip(areas).map(|(l, a)| if closes { l * a } else { 0.0 }).collect();
        let rows = |x: &[f64]| product(&self.matrix.rows, x);
        let sums = |x: &[f64]| rows(x).iter().zip(&sinks).map(|(sx, sink)| sx + sink).collect::<Vec<_>>();
        let parts = |x: &[f64]| -> Vec<f64> { sums(x).iter().zip(x).zip(areas).map(|((s, x), a)| x * s / a).collect() };
        let (mut x, sweeps) = if closes { balance(parts, areas, near) } else { lower(rows, areas, near) };
        if closes && parts(&x).iter().any(|part| *part > 1.0 + near) {
            // Rows that cannot be closed give no more than they have.
            let by = |z: &[f64]| {
                let scaled: Vec<f64> = x.iter().zip(z).map(|(x, z)| x * z).collect();
                sums(&scaled).iter().zip(&x).map(|(s, x)| s * x).collect()
            };
            let (z, _) = lower(by, areas, near);
            x.iter_mut().zip(z).for_each(|(x, z)| *x *= z);
        }

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
        if !closes {
            for (i, lost) in losses.iter().enumerate() {
                let lacks = (1.0 - self.row_sum(i)).max(0.0);
                let absorbed = if *lost > 0.0 { self.absorbed[i] / (self.absorbed[i] + self.escaped[i]) } else { 0.0 };
                (self.escaped[i], self.absorbed[i]) = (lacks * (1.0 - absorbed), lacks * absorbed);
            }
        }
        let lacks = |f: &Self, i: usize| 1.0 - f.row_sum(i) - f.escaped[i] - f.absorbed[i];
        let closure_after = largest((0..self.len()).into_par_iter().map(|i| lacks(self, i).abs()));
        if closure_after > UNCLOSED {
            for i in 0..self.len() {
                self.absorbed[i] += lacks(self, i).max(0.0);
            }
        }
        Repair {
            closed,
            open,
            closure_before,
            closure_after,
            reciprocity_before: off / total,
            // Each pair of entries meets between the two.
            moved_by_symmetry: 0.5 * off / total,
            moved_by_noise: 0.5 * noise / total,
            moved_by_scaling: moved.iter().sum::<f64>() / total,
            largest_scale: self.right.iter().map(|x| (x - 1.0).abs()).fold(0.0, f64::max),
            sweeps,
        }
    }
}

fn largest(values: impl ParallelIterator<Item = f64>) -> f64 {
    values.reduce(|| 0.0, f64::max)
}

/// S with its standard errors (N_i = 1 where no rays were cast), Σ |A_i F_ij - A_j F_ji|, and what of that to expect: E|z| = √(2/π) standard errors, where rays are many.
fn symmetric(f: &FormFactors, areas: &[f64]) -> (Matrix, [f64; 2]) {
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
    let off: Vec<[f64; 2]> = each
        .zip(of_errors)
        .enumerate()
        .map(|(i, ((columns, values), errors))| {
            let (mut k, mut off, mut noise) = (0, 0.0, 0.0);
            union(i, &mut |j, at, of| {
                let number = |data: &[f32], place: Option<usize>| place.map_or(0.0, |p| f64::from(data[p]));
                let (f_ij, f_ji) = (number(f.matrix.rows.data(), at), number(transposed.rows.data(), of));
                let (a, b) = (areas[i], areas[j as usize]);
                let [n, m] = [i, j as usize].map(|i| f.rays.get(i).copied().unwrap_or(1.0));
                let weights = n / a + m / b;
                columns[k] = j;
                values[k] = ((n * f_ij + m * f_ji) / weights) as f32;
                let mut variance = if f.rays.is_empty() {
                    0.0
                } else {
                    (a * a * f_ij / n + b * b * f_ji / m) * coarse(n * f_ij + m * f_ji).powi(2)
                };
                if with_errors {
                    let (e, g) = (number(&f.matrix.errors, at), number(&transposed.errors, of));
                    variance = (a * e).powi(2) + (b * g).powi(2);
                    errors[k] = ((n * e).hypot(m * g) / weights) as f32;
                }
                off += (a * f_ij - b * f_ji).abs();
                noise += (2.0 / std::f64::consts::PI * variance).sqrt();
                k += 1;
            });
            [off, noise]
        })
        .collect();
    let off = off.iter().fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    (Matrix { rows: Rows::new((n, n), begins, columns, values), errors }, off)
}

/// E|a - b| of n rays that fall to either side by chance, over √(2n/π), which it is of many: 1.25 of a single one.
fn coarse(rays: f64) -> f64 {
    let n = rays.round();
    if !(1.0..64.0).contains(&n) {
        return 1.0;
    }
    // E|a - b| = n C(n-1, k) / 2^(n-1),  k = ⌊(n-1)/2⌋
    let k = ((n - 1.0) / 2.0).floor() as i32;
    let choose = (1..=k).fold(1.0, |c, i| c * (n - f64::from(i)) / f64::from(i));
    choose * n / 2f64.powi(n as i32 - 1) / (2.0 * n / std::f64::consts::PI).sqrt()
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

/// x with which all `rows` are one to a part of `near`, and how many sweeps that took: x_i ← x_i / √(row i). Rows of zero are left alone.
///
/// Not every exchange can be scaled so: of two patches that found nothing but a third, smaller than both, one cannot give all that it has. Where sweeps no
/// longer help it ends with the best x that was seen.
pub(crate) fn balance(rows: impl Fn(&[f64]) -> Vec<f64>, areas: &[f64], near: f64) -> (Vec<f64>, usize) {
    let mut y = vec![0.0f64; areas.len()];
    let mut x = vec![1.0; areas.len()];
    let mut past = Past::default();
    let (mut least, mut best) = (f64::INFINITY, x.clone());
    let (mut hoped, mut until) = (f64::INFINITY, PATIENCE);
    for sweep in 0..SWEEPS {
        let rows = rows(&x);
        let off = rows.iter().filter(|r| **r > 0.0).map(|r| (r - 1.0).abs()).fold(0.0, f64::max);
        if off <= near {
            return (x, sweep);
        }
        // What has led astray is forgotten.
        if off > 2.0 * least {
            past.steps.clear();
        }
        if off < least {
            least = off;
            best.copy_from_slice(&x);
        }
        if least < 0.9 * hoped {
            (hoped, until) = (least, sweep + PATIENCE);
        }
        if sweep >= until {
            return (best, sweep);
        }
        let g: Vec<f64> = rows.iter().map(|r| if *r > 0.0 { -0.5 * r.ln() } else { 0.0 }).collect();
        past.step(&mut y, &g, areas);
        y.iter_mut().for_each(|y| *y = y.clamp(-FARTHEST, FARTHEST));
        x.iter_mut().zip(&y).for_each(|(x, y)| *x = y.exp());
    }
    (best, SWEEPS)
}

/// Anderson's acceleration of y ← y + g(y).
#[derive(Default)]
struct Past {
    /// Changes of y and of g from sweep to sweep.
    steps: VecDeque<[Vec<f64>; 2]>,
    last: Option<[Vec<f64>; 2]>,
}

impl Past {
    /// y ← y + g - Σ_m γ_m (Δy_m + Δg_m) with the γ that make |g - Σ γ_m Δg_m| least.
    fn step(&mut self, y: &mut [f64], g: &[f64], weights: &[f64]) {
        if let Some([before, g_before]) = self.last.replace([y.to_vec(), g.to_vec()]) {
            let less = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
            self.steps.push_back([less(y, &before), less(g, &g_before)]);
            if self.steps.len() > DEPTH {
                self.steps.pop_front();
            }
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).zip(weights).map(|((a, b), w)| a * b * w).sum::<f64>();
        let n = self.steps.len();
        let mut system = [[0.0; DEPTH + 1]; DEPTH];
        for (row, [_, dg]) in system.iter_mut().zip(&self.steps) {
            row.iter_mut().zip(&self.steps).for_each(|(x, [_, other])| *x = dot(dg, other));
            row[DEPTH] = dot(dg, g);
        }
        let gamma = solve(system, n);
        y.iter_mut().zip(g).for_each(|(y, g)| *y += g);
        for ([dy, dg], gamma) in self.steps.iter().zip(gamma) {
            y.iter_mut().zip(dy).zip(dg).for_each(|((y, dy), dg)| *y -= gamma * (dy + dg));
        }
    }
}

/// The first n unknowns of a symmetric system by elimination; zero where it says nothing of one.
fn solve(mut a: [[f64; DEPTH + 1]; DEPTH], n: usize) -> [f64; DEPTH] {
    let sizes: [f64; DEPTH] = std::array::from_fn(|k| a[k][k]);
    let usable = |a: &[[f64; DEPTH + 1]; DEPTH], k: usize| a[k][k] > 1e-10 * sizes[k];
    for k in 0..n {
        if !usable(&a, k) {
            continue;
        }
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            let (above, below) = a.split_at_mut(i);
            below[0][k..].iter_mut().zip(&above[k][k..]).for_each(|(x, y)| *x -= factor * y);
        }
    }
    let mut x = [0.0; DEPTH];
    for k in (0..n).rev().filter(|k| usable(&a, *k)) {
        let rest: f64 = (k + 1..n).map(|j| a[k][j] * x[j]).sum();
        x[k] = (a[k][DEPTH] - rest) / a[k][k];
    }
    x
}

/// x ≤ 1 with x_i (S x)_i ≤ A_i, likewise.
fn lower(product: impl Fn(&[f64]) -> Vec<f64>, areas: &[f64], near: f64) -> (Vec<f64>, usize) {
    let mut x = vec![1.0; areas.len()];
    for sweep in 0..SWEEPS {
        let sx = product(&x);
        let off = (0..x.len()).map(|i| x[i] * sx[i] / areas[i] - 1.0).fold(0.0, f64::max);
        if off <= near {
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
