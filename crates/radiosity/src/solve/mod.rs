//! The radiosity equation, and the ways to solve it.
//!
//! ```text
//! B = Be + ρ H        H = E + F B        r = Be + ρ (E + F B) - B
//! ```
//!
//! | symbol | identifier | unit |
//! | --- | --- | --- |
//! | Be, ρ, A | [`Equation::be`], [`Equation::rho`], [`Equation::areas`] | W/m², 1, m² |
//! | E: irradiance from lights that are no patches, and what [`lamps`] puts right | [`Equation::direct`] | W/m² |
//! | F | [`Equation::exchange`] | 1 |
//! | B | [`Solution::b`] | W/m² |
//! | ‖r‖ / ‖Be + ρ E‖, ‖x‖ = Σ A \|x\| over patches and channels | [`Solution::residuals`] | 1 |
//!
//! | method | a sweep is | file |
//! | --- | --- | --- |
//! | `neumann` | one more bounce of all light | [`neumann`] |
//! | `gauss-seidel` | each patch gathers once, from what is newest | [`gauss_seidel`] |
//! | `shooting` | as many patches shoot as there are, always the one with most | [`shooting`] |
//! | `direct` | none: a factorisation | [`direct`] |
//!
//! All end at the same B. Sums run in the order of patches, so that the bits do not depend on threads.

pub mod direct;
mod energy;
pub mod gauss_seidel;
pub mod lamps;
pub mod lights;
pub mod neumann;
pub mod shooting;

pub use energy::Energy;
pub use neumann::Bounces;

use crate::form_factor::FormFactors;
use crate::patch::Patches;
use etendue_numerics::Spectrum;
use glam::DVec3;

/// What carries light between patches: F.
pub trait Exchange: Sync {
    /// F b.
    fn multiply(&self, b: &[DVec3]) -> Vec<DVec3>;

    /// The parts of the light of patch i that escape, and that are absorbed by what is no patch.
    fn lost(&self, i: usize) -> [f64; 2];
}

impl Exchange for FormFactors {
    fn multiply(&self, b: &[DVec3]) -> Vec<DVec3> {
        Self::multiply(self, b)
    }

    fn lost(&self, i: usize) -> [f64; 2] {
        [self.escaped[i], self.absorbed[i]]
    }
}

/// The equation of a scene.
#[derive(Clone, Debug)]
pub struct Equation<'a, F> {
    /// F.
    pub exchange: &'a F,
    /// A, m².
    pub areas: Vec<f64>,
    /// ρ.
    pub rho: Vec<DVec3>,
    /// Be, W/m².
    pub be: Vec<DVec3>,
    /// E, W/m².
    pub direct: Vec<DVec3>,
}

impl<'a, F: Exchange> Equation<'a, F> {
    /// Of patches, with light `direct` that comes from elsewhere.
    pub fn new(patches: &Patches, exchange: &'a F, direct: Vec<DVec3>) -> Self {
        let of = |f: fn(&crate::patch::Patch) -> Spectrum| patches.patches.iter().map(|p| rgb(f(p))).collect();
        let areas = patches.patches.iter().map(|p| p.area).collect();
        Self { exchange, areas, rho: of(|p| p.rho), be: of(|p| p.be), direct }
    }

    /// The number of patches.
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// H = E + F b.
    pub fn irradiance(&self, b: &[DVec3]) -> Vec<DVec3> {
        let mut h = self.exchange.multiply(b);
        h.iter_mut().zip(&self.direct).for_each(|(h, e)| *h += *e);
        h
    }

    /// ‖x‖ = Σ A |x|, W.
    pub fn norm(&self, x: &[DVec3]) -> f64 {
        x.iter().zip(&self.areas).map(|(x, a)| x.abs().element_sum() * a).sum()
    }

    /// ‖Be + ρ E‖: what there is before light goes from patch to patch. Of black scenes one, so that it divides.
    pub fn scale(&self) -> f64 {
        let norm: f64 =
            (0..self.len()).map(|i| (self.be[i] + self.rho[i] * self.direct[i]).abs().element_sum() * self.areas[i]).sum();
        if norm > 0.0 { norm } else { 1.0 }
    }

    /// ‖r‖ of b, relative.
    pub fn residual(&self, b: &[DVec3]) -> f64 {
        let h = self.irradiance(b);
        let r: Vec<DVec3> = (0..self.len()).map(|i| self.be[i] + self.rho[i] * h[i] - b[i]).collect();
        self.norm(&r) / self.scale()
    }
}

/// When to stop.
#[derive(Clone, Copy)]
pub struct Until<'a> {
    /// At this relative residual.
    pub residual: f64,
    /// After so many sweeps.
    pub sweeps: usize,
    /// Hears of each sweep its number and the residual; `false` ends with this one.
    pub watch: &'a (dyn Fn(usize, f64) -> bool + Sync),
}

impl Until<'_> {
    /// Whether another sweep is due after `sweeps` that left `residual`.
    fn goes_on(&self, sweeps: usize, residual: f64) -> bool {
        (self.watch)(sweeps, residual) && residual > self.residual && sweeps < self.sweeps
    }
}

/// Radiosities, and how they were come by.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solution {
    /// B, W/m².
    pub b: Vec<DVec3>,
    /// The relative residual before the first sweep and after each.
    pub residuals: Vec<f64>,
}

impl Solution {
    /// The last residual.
    pub fn residual(&self) -> f64 {
        self.residuals.last().copied().unwrap_or(0.0)
    }

    /// How many sweeps there were.
    pub fn sweeps(&self) -> usize {
        self.residuals.len().saturating_sub(1)
    }
}

/// Three channels in double precision.
#[inline]
pub fn rgb(s: Spectrum) -> DVec3 {
    DVec3::from_array(s.to_rgb().map(f64::from))
}
