//! Progressive refinement: the patch with the most unshot light shoots it at all others [Cohen, Chen, Wallace, Greenberg 1988].
//!
//! ```text
//! ΔB = Be + ρ E at first.  Again and again, for the i of the largest A_i ΔB_i:
//! ΔB_j += ρ_j F_ji ΔB_i,   B_j += the same,   ΔB_i = its own share
//!
//! ambient:   b = R Σ A ΔB / Σ A,   R = 1 / (1 - ρ̄),   ρ̄ = Σ A ρ / Σ A            B_j + ρ_j b  is shown on the way
//! ```
//!
//! ΔB of what has been shot is the residual of it, so nothing has to be measured. Rows of F are needed as columns: they are kept apart, for a matrix
//! that was not repaired is not symmetric.

use super::{Equation, Solution, Until};
use crate::form_factor::FormFactors;
use glam::DVec3;

/// The columns of F: for each i its (j, F_ji).
struct Columns {
    begins: Vec<usize>,
    entries: Vec<(u32, f64)>,
}

impl Columns {
    fn of(f: &FormFactors) -> Self {
        let n = f.len();
        let mut begins = vec![0; n + 1];
        (0..n).for_each(|i| f.row(i).for_each(|(j, _)| begins[j + 1] += 1));
        (0..n).for_each(|j| begins[j + 1] += begins[j]);
        let mut next = begins.clone();
        let mut entries = vec![(0, 0.0); begins[n]];
        for i in 0..n {
            for (j, f) in f.row(i) {
                entries[next[j]] = (i as u32, f);
                next[j] += 1;
            }
        }
        Self { begins, entries }
    }
}

/// B by shooting until what is unshot is small enough. What is stopped before ends with the ambient estimate added.
pub fn solve(equation: &Equation<'_, FormFactors>, until: &Until<'_>) -> Solution {
    let (n, scale) = (equation.len(), equation.scale());
    let columns = Columns::of(equation.exchange);
    let mut unshot: Vec<DVec3> = (0..n).map(|i| equation.be[i] + equation.rho[i] * equation.direct[i]).collect();
    let mut b = unshot.clone();
    let mut residuals = vec![equation.norm(&unshot) / scale];
    while until.goes_on(residuals.len() - 1, residuals[residuals.len() - 1]) {
        for _ in 0..n {
            let flux = |i: usize| unshot[i].abs().element_sum() * equation.areas[i];
            let brightest = (0..n).fold((0, 0.0), |most, i| if flux(i) > most.1 { (i, flux(i)) } else { most });
            if brightest.1 == 0.0 {
                break;
            }
            let i = brightest.0;
            let shot = std::mem::take(&mut unshot[i]);
            for (j, f) in &columns.entries[columns.begins[i]..columns.begins[i + 1]] {
                let arrives = equation.rho[*j as usize] * shot * *f;
                unshot[*j as usize] += arrives;
                b[*j as usize] += arrives;
            }
        }
        residuals.push(equation.norm(&unshot) / scale);
    }
    if residuals[residuals.len() - 1] > until.residual {
        let ambient = ambient(equation, &unshot);
        b.iter_mut().zip(&equation.rho).for_each(|(b, rho)| *b += *rho * ambient);
    }
    Solution { b, residuals }
}

/// The irradiance, alike everywhere, that what is unshot will come to: an estimate that takes the scene for the inside of a ball.
pub fn ambient(equation: &Equation<'_, FormFactors>, unshot: &[DVec3]) -> DVec3 {
    let area: f64 = equation.areas.iter().sum();
    let mean = |x: &[DVec3]| x.iter().zip(&equation.areas).map(|(x, a)| *x * *a).sum::<DVec3>() / area;
    let least = DVec3::splat(1e-3);
    mean(unshot) / (DVec3::ONE - mean(&equation.rho)).max(least)
}
