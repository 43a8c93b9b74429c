//! The books of light: what becomes of all that was emitted.
//!
//! ```text
//! emitted = absorbed + escaped + cut + residual
//! ```
//!
//! All are fluxes in W, by channel. A particle of flux Φ that scatters with weight w leaves Φ (1 - w) behind: *absorbed*. Weights may exceed 1, and
//! adjoint shading normals conserve energy only on the whole surface, so a single entry may be negative; the sums are estimates of the energies.
//! *Escaped* is what meets nothing any more; *cut* is what roulette took less what it gave to the survivors (zero on average), and what was left at
//! the depth limit. The residual is rounding.

use crate::transport::Entries;
use etendue_film::Fixed;
use serde::{Deserialize, Serialize};

/// Sums of the entries, exact whatever their order: the state of a particle solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Books {
    emitted: [Fixed; 3],
    absorbed: [Fixed; 3],
    escaped: [Fixed; 3],
    cut: [Fixed; 3],
    particles: u64,
}

/// Fluxes by channel, W: the sums per particle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Balance {
    /// All that was emitted.
    pub emitted: [f64; 3],
    /// Left at surfaces.
    pub absorbed: [f64; 3],
    /// Met nothing any more.
    pub escaped: [f64; 3],
    /// Given up by roulette and the depth limit.
    pub cut: [f64; 3],
    /// emitted - absorbed - escaped - cut.
    pub residual: [f64; 3],
}

impl Balance {
    /// The books of two lights together.
    pub fn plus(&self, other: &Self) -> Self {
        let add = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|c| a[c] + b[c]);
        Self {
            emitted: add(self.emitted, other.emitted),
            absorbed: add(self.absorbed, other.absorbed),
            escaped: add(self.escaped, other.escaped),
            cut: add(self.cut, other.cut),
            residual: add(self.residual, other.residual),
        }
    }
}

impl Books {
    /// Adds the entries of so many particles.
    pub fn add(&mut self, entries: &Entries, particles: u64) {
        let add = |sum: &mut [Fixed; 3], entry: [f64; 3]| sum.iter_mut().zip(entry).for_each(|(s, e)| *s += Fixed::from_f64(e));
        add(&mut self.emitted, entries.emitted);
        add(&mut self.absorbed, entries.absorbed);
        add(&mut self.escaped, entries.escaped);
        add(&mut self.cut, entries.cut);
        self.particles += particles;
    }

    /// These and other books in one.
    pub fn merged(mut self, other: &Self) -> Self {
        let add = |sum: &mut [Fixed; 3], entry: &[Fixed; 3]| sum.iter_mut().zip(entry).for_each(|(s, e)| *s += *e);
        add(&mut self.emitted, &other.emitted);
        add(&mut self.absorbed, &other.absorbed);
        add(&mut self.escaped, &other.escaped);
        add(&mut self.cut, &other.cut);
        self.particles += other.particles;
        self
    }

    /// The books closed.
    pub fn balance(&self) -> Balance {
        let per_particle = |sum: [Fixed; 3]| sum.map(|s| s.to_f64() / self.particles.max(1) as f64);
        let mut balance = Balance {
            emitted: per_particle(self.emitted),
            absorbed: per_particle(self.absorbed),
            escaped: per_particle(self.escaped),
            cut: per_particle(self.cut),
            residual: [0.0; 3],
        };
        for (c, residual) in balance.residual.iter_mut().enumerate() {
            *residual = balance.emitted[c] - balance.absorbed[c] - balance.escaped[c] - balance.cut[c];
        }
        balance
    }
}
