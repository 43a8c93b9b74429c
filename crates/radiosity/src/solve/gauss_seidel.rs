//! Gathering, patch after patch, each from what is newest.
//!
//! ```text
//! B_i ← [Be_i + ρ_i (E_i + Σ_{j≠i} F_ij B_j)] / (1 - ρ_i F_ii)          i = 1, 2, …, n
//! ```
//!
//! It needs about half as many sweeps as the Neumann series [Cohen, Wallace 1993, §5.3]; a sweep is the work of one thread.

use super::{Equation, Solution, Until};
use crate::form_factor::FormFactors;
use glam::DVec3;

/// B by sweeps until the residual is small enough.
pub fn solve(equation: &Equation<'_, FormFactors>, until: &Until<'_>) -> Solution {
    let mut b = equation.be.clone();
    let mut residuals = vec![equation.residual(&b)];
    while until.goes_on(residuals.len() - 1, residuals[residuals.len() - 1]) {
        for i in 0..b.len() {
            let (mut sum, mut own) = (equation.direct[i], 0.0);
            for (j, f) in equation.exchange.row(i) {
                if j == i { own = f } else { sum += b[j] * f }
            }
            let rho = equation.rho[i];
            b[i] = (equation.be[i] + rho * sum) / (DVec3::ONE - rho * own);
        }
        residuals.push(equation.residual(&b));
    }
    Solution { b, residuals }
}
