//! A dense factorisation. For small scenes, and as the judge of the others.
//!
//! ```text
//! (I - ρ F) B = Be + ρ E        I - ρ F = L U
//! ```
//!
//! Rows of ρ F sum to less than one: the matrix is diagonally dominant, and its LU needs no pivoting [Golub, Van Loan 2013, §4.1.1]. It goes by
//! blocks, so that nearly all of the work is products of matrices.

use super::{Equation, Solution};
use crate::form_factor::FormFactors;
use glam::DVec3;
use ndarray::linalg::general_mat_mul;
use ndarray::{Array2, Axis, s};
use std::fmt;

/// The most patches that it takes: 2 n² numbers of 8 bytes are 1 GiB, and n³ operations a minute.
pub const MOST: usize = 8192;

/// There are too many patches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLarge {
    /// How many there are.
    pub patches: usize,
}

impl fmt::Display for TooLarge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let gib = (self.patches as f64).powi(2) * 16.0 / f64::from(1 << 30);
        write!(
            f,
            "`direct` takes {MOST} patches at most, and there are {} (a dense matrix and its factors would take {gib:.1} GiB); \
             `neumann` and `gauss-seidel` fit, and for many more form factors by `hierarchical`",
            self.patches
        )
    }
}

/// B, to rounding.
pub fn solve(equation: &Equation<'_, FormFactors>) -> Result<Solution, TooLarge> {
    let n = equation.len();
    if n > MOST {
        return Err(TooLarge { patches: n });
    }
    let mut b = vec![DVec3::ZERO; n];
    let mut done = [false; 3];
    for c in 0..3 {
        if done[c] {
            continue;
        }
        // Channels that reflect alike share the factors.
        let same: Vec<usize> = (c..3).filter(|k| equation.rho.iter().all(|rho| rho[*k] == rho[c])).collect();
        let mut m = Array2::<f64>::eye(n);
        for i in 0..n {
            for (j, f) in equation.exchange.row(i) {
                m[[i, j]] -= equation.rho[i][c] * f;
            }
        }
        factor(&mut m);
        for channel in same {
            let mut x: Vec<f64> = (0..n).map(|i| (equation.be[i] + equation.rho[i] * equation.direct[i])[channel]).collect();
            substitute(&m, &mut x);
            done[channel] = true;
            b.iter_mut().zip(x).for_each(|(b, x)| b[channel] = x);
        }
    }
    let residual = equation.residual(&b);
    Ok(Solution { b, residuals: vec![residual] })
}

/// Columns of a block.
const BLOCK: usize = 64;

/// L below the diagonal, which is one, and U on and above it, in place.
fn factor(m: &mut Array2<f64>) {
    let n = m.nrows();
    for begin in (0..n).step_by(BLOCK) {
        let end = (begin + BLOCK).min(n);
        // The block's columns of L, and its own corner of U.
        for k in begin..end {
            let (top, mut below) = m.view_mut().split_at(Axis(0), k + 1);
            let pivot = top[[k, k]];
            let pivots = top.slice(s![k, k + 1..end]);
            for mut row in below.rows_mut() {
                row[k] /= pivot;
                let l = row[k];
                row.slice_mut(s![k + 1..end]).scaled_add(-l, &pivots);
            }
        }
        // Its rows of U.
        for k in begin..end {
            let (top, mut below) = m.view_mut().split_at(Axis(0), k + 1);
            let pivots = top.slice(s![k, end..]);
            for mut row in below.rows_mut().into_iter().take(end - k - 1) {
                let l = row[k];
                row.slice_mut(s![end..]).scaled_add(-l, &pivots);
            }
        }
        // What is left: minus L times U.
        let (top, below) = m.view_mut().split_at(Axis(0), end);
        let (left, mut rest) = below.split_at(Axis(1), end);
        general_mat_mul(-1.0, &left.slice(s![.., begin..end]), &top.slice(s![begin..end, end..]), 1.0, &mut rest);
    }
}

/// x ← U⁻¹ L⁻¹ x.
fn substitute(m: &Array2<f64>, x: &mut [f64]) {
    let n = x.len();
    for i in 0..n {
        let known: f64 = (0..i).map(|j| m[[i, j]] * x[j]).sum();
        x[i] -= known;
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| m[[i, j]] * x[j]).sum();
        x[i] = (x[i] - known) / m[[i, i]];
    }
}
