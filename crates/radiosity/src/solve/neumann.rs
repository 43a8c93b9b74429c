//! Successive approximation: the Neumann series, bounce by bounce.
//!
//! ```text
//! B_0 = Be        B_k = Be + ρ (E + F B_{k-1})                    B_k holds light of 0 to k bounces
//! b_0 = Be        b_1 = ρ (E + F b_0)        b_k = ρ F b_{k-1}    light of exactly k;  B_k = Σ b_m,  r of B_k is b_{k+1}
//! ```
//!
//! In a closed box where all emit Be and reflect ρ, B_k = Be (1 - ρ^(k+1)) / (1 - ρ).

use super::{Equation, Exchange, Solution, Until};
use glam::DVec3;

/// b_0, b_1, b_2, …, without an end.
#[derive(Clone, Debug)]
pub struct Bounces<'a, F> {
    equation: &'a Equation<'a, F>,
    last: Option<Vec<DVec3>>,
    is_first: bool,
}

impl<'a, F: Exchange> Bounces<'a, F> {
    /// Those of an equation.
    pub fn new(equation: &'a Equation<'a, F>) -> Self {
        Self { equation, last: None, is_first: false }
    }
}

impl<F: Exchange> Iterator for Bounces<'_, F> {
    type Item = Vec<DVec3>;

    fn next(&mut self) -> Option<Vec<DVec3>> {
        let equation = self.equation;
        let next = match &self.last {
            None => {
                self.is_first = true;
                equation.be.clone()
            }
            Some(last) => {
                let mut b = if self.is_first { equation.irradiance(last) } else { equation.exchange.multiply(last) };
                self.is_first = false;
                b.iter_mut().zip(&equation.rho).for_each(|(b, rho)| *b *= *rho);
                b
            }
        };
        self.last = Some(next.clone());
        Some(next)
    }
}

/// B by summing bounces until what the next would add is small enough.
pub fn solve<F: Exchange>(equation: &Equation<'_, F>, until: &Until<'_>) -> Solution {
    let scale = equation.scale();
    let mut bounces = Bounces::new(equation);
    let mut next = || bounces.next().unwrap_or_default();
    let mut b = next();
    let mut more = next();
    let mut residuals = vec![equation.norm(&more) / scale];
    while until.goes_on(residuals.len() - 1, residuals[residuals.len() - 1]) {
        b.iter_mut().zip(&more).for_each(|(b, more)| *b += *more);
        more = next();
        residuals.push(equation.norm(&more) / scale);
    }
    Solution { b, residuals }
}

/// B by further sweeps from b, whatever it is: B_k = Be + ρ (E + F B_{k-1}).
pub fn go_on<F: Exchange>(equation: &Equation<'_, F>, mut b: Vec<DVec3>, until: &Until<'_>) -> Solution {
    let scale = equation.scale();
    let lacks = |b: &[DVec3]| -> Vec<DVec3> {
        let h = equation.irradiance(b);
        (0..b.len()).map(|i| equation.be[i] + equation.rho[i] * h[i] - b[i]).collect()
    };
    let mut r = lacks(&b);
    let mut residuals = vec![equation.norm(&r) / scale];
    while until.goes_on(residuals.len() - 1, residuals[residuals.len() - 1]) {
        b.iter_mut().zip(&r).for_each(|(b, r)| *b += *r);
        r = lacks(&b);
        residuals.push(equation.norm(&r) / scale);
    }
    Solution { b, residuals }
}
