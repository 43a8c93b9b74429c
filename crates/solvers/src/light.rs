//! Light tracing without next event estimation: a particle counts only when it happens to pass through the lens.
//!
//! ```text
//! I_j = E[ Σ Φ We(x, -w) h_j ]    over the passages (x, w) of the walk through the lens, from its front
//! ```
//!
//! The dual of `path`. Each segment of the walk, the emitted one included, is tested against the lens before the next surface, and the particle
//! goes on: the lens casts no shadow. Particles pass in proportion to |cosθ| dA dw, so that factor of the measurement needs no density. A pinhole
//! is never hit, nor the single direction of an orthographic camera: both are refused.

use crate::drivers::{Balance, Books, ParticleSolver, Work, particles};
use crate::run::Run;
use crate::solver::{Needs, Solver};
use crate::transport::{LightContext, Particle, Tally, Vertex, through_lens};
use etendue_numerics::Sampler;
use etendue_scene::Scene;

/// The solver `light`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Light;

impl ParticleSolver for Light {
    fn shoot(&self, c: &LightContext<'_>, u: &Sampler, tally: &mut Tally) {
        tally.surroundings(c, u);
        let Some((mut particle, _)) = Particle::emit(c.path.scene, u) else { return };
        tally.emitted(particle.carried());
        let mut from = None;
        loop {
            let next = particle.meet(c, tally);
            let t_next = next.map_or(f32::INFINITY, |x| x.t);
            if let Some((pixel, value)) = through_lens(c, &particle, t_next, from) {
                tally.splat(pixel, value);
            }
            let Some(x) = next else { break };
            let mut vertex = Vertex::at(x);
            vertex.evaluate(c.path.scene, &particle.wl);
            from = Some(x.surface);
            if !particle.turn(c, &vertex, u, tally) {
                break;
            }
        }
    }
}

impl Solver for Light {
    type State = Books;

    fn needs(&self) -> Needs {
        Needs { finite_lens: true, ..Needs::default() }
    }

    fn units(&self, size: [u32; 2]) -> usize {
        particles::units(size)
    }

    fn prepare(&self, _: &Scene, _: &Run<'_>) -> Books {
        Books::default()
    }

    fn pass(&self, scene: &Scene, run: &Run<'_>, books: &mut Books, k: u32, work: &Work<'_>) {
        particles::pass(self, scene, run, books, k, work);
    }

    fn books(&self, books: &Books) -> Option<Balance> {
        Some(books.balance())
    }
}
