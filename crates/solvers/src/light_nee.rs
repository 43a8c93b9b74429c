//! Light tracing with next event estimation: particles leave the lights, and every surface that they meet is connected to the lens.
//!
//! ```text
//! I_j = E[ Σ_k Φ_k f*(x_k → lens) |cosθ| We(lens → x_k) V(x_k, lens) h_j / p(lens) ]
//! ```
//!
//! The dual of `path-nee`: the emitting point is connected, too, for emitters that the eye sees. Caustics are its strength. What a mirror or smooth
//! glass shows the eye no connection can find, so scenes with such surfaces in view are refused.

use crate::drivers::ParticleSolver;
use crate::solver::Needs;
use crate::transport::{LightContext, Particle, Tally, emitter_to_sensor, to_sensor};
use etendue_numerics::Sampler;

/// The solver `light-nee`.
#[derive(Clone, Copy, Debug, Default)]
pub struct LightNee;

impl ParticleSolver for LightNee {
    fn needs(&self) -> Needs {
        Needs { no_mirrors_in_view: true, both_ways: true, ..Needs::default() }
    }

    fn shoot(&self, c: &LightContext<'_>, u: &Sampler, tally: &mut Tally) {
        tally.surroundings(c, u);
        let Some((mut particle, light)) = Particle::emit(c.path.scene, u) else { return };
        tally.emitted(particle.weighed());
        if let Some(query) = emitter_to_sensor(c, &particle, &light, u) {
            tally.connect(c, &query, &particle);
        }
        while let Some(x) = particle.meet(c, tally) {
            let vertex = particle.vertex(c.path.scene, x);
            if let Some(query) = to_sensor(c, &particle, &vertex, u) {
                tally.connect(c, &query, &particle);
            }
            if !particle.turn(c, &vertex, u, tally) {
                break;
            }
        }
    }

    /// The connection is an edge.
    fn reach(&self, max_edges: u32) -> u32 {
        max_edges.saturating_sub(1)
    }
}

crate::solve_by_particles!(LightNee);
