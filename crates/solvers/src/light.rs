//! Light tracing without next event estimation: a particle counts only when it happens to pass through the lens.
//!
//! ```text
//! I_j = E[ Σ Φ We(x, -w) h_j ]    over the passages (x, w) of the walk through the lens, from its front
//! ```
//!
//! The dual of `path`. Each segment of the walk, the emitted one included, is tested against the lens before the next surface, and the particle
//! goes on: the lens casts no shadow. Particles pass in proportion to |cosθ| dA dw, so that factor of the measurement needs no density. A pinhole
//! is never hit, nor the single direction of an orthographic camera: both are refused.

use crate::drivers::ParticleSolver;
use crate::solver::Needs;
use crate::transport::{LightContext, Particle, Tally, through_lens};
use etendue_numerics::Sampler;

/// The solver `light`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Light;

impl ParticleSolver for Light {
    fn needs(&self) -> Needs {
        Needs { finite_lens: true, both_ways: true, ..Needs::default() }
    }

    fn shoot(&self, c: &LightContext<'_>, u: &Sampler, tally: &mut Tally) {
        tally.surroundings(c, u);
        let Some((mut particle, _)) = Particle::emit(c.path.scene, u) else { return };
        tally.emitted(particle.weighed());
        let mut from = None;
        loop {
            let next = particle.meet(c, tally);
            let t_next = next.map_or(f32::INFINITY, |x| x.t);
            if let Some((pixel, value)) = through_lens(c, &particle, t_next, from) {
                tally.splat(pixel, value);
            }
            let Some(x) = next else { break };
            let vertex = particle.vertex(c.path.scene, x);
            from = Some(x.surface);
            if !particle.turn(c, &vertex, u, tally) {
                break;
            }
        }
    }
}

crate::solve_by_particles!(Light);
