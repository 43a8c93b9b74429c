//! The books of energy: what becomes of the light.
//!
//! ```text
//! emitted = absorbed + escaped + residual
//! Σ A (Be + E) = Σ A (1 - ρ) H + Σ A B f_absorbed + Σ A B f_escaped + residual,        W by channel
//! ```
//!
//! Of lights that are no patches what arrives counts as emitted. With reciprocal factors and closed rows the residual is Σ A r, what the last sweep left
//! undone; else it tells what the factors invented or lost.

use super::{Equation, Exchange};
use glam::DVec3;

/// Fluxes, W by channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Emitted by patches.
    pub emitted: DVec3,
    /// Arrived from lights that are no patches.
    pub arrived: DVec3,
    /// Absorbed by patches and by what is no patch.
    pub absorbed: DVec3,
    /// Met nothing any more.
    pub escaped: DVec3,
    /// What is missing.
    pub residual: DVec3,
}

impl<F: Exchange> Equation<'_, F> {
    /// The books of radiosities b.
    pub fn energy(&self, b: &[DVec3]) -> Energy {
        let h = self.irradiance(b);
        let mut energy = Energy::default();
        for i in 0..self.len() {
            let (a, [escaped, absorbed]) = (self.areas[i], self.exchange.lost(i));
            energy.emitted += self.be[i] * a;
            energy.arrived += self.direct[i] * a;
            energy.absorbed += ((DVec3::ONE - self.rho[i]) * h[i] + b[i] * absorbed) * a;
            energy.escaped += b[i] * escaped * a;
        }
        energy.residual = energy.emitted + energy.arrived - energy.absorbed - energy.escaped;
        energy
    }
}
