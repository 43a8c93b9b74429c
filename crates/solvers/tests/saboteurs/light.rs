//! A light tracer with one deliberate fault at a time.

use etendue_bsdf::Scatter;
use etendue_numerics::{Sampler, Spectrum, Vec3};
use etendue_scene::Scene;
use etendue_solvers::drivers::{Books, ParticleSolver, particles};
use etendue_solvers::solver::{CannotGoOn, Needs};
use etendue_solvers::transport::{LightContext, Particle, SensorQuery, Tally, Vertex, emitter_to_sensor, to_sensor};
use etendue_solvers::{Run, Solver, Work};

faults! {
    /// The density of emission halved: its flux doubled.
    HalvedPdf,
    /// One of n lights chosen, without division by the probability of the choice.
    LightWithoutItsProbability,
    /// Connections to the lens without the cosine at the surface.
    LostCosine,
    /// The flux of a refracted particle is divided by η², as if it were radiance.
    CompressedFlux,
    /// Connections to the lens are not tested for what stands between.
    NoShadows,
    /// Splats are divided by twice the particles started.
    SplatsNotNormalised,
    /// Bent normals scatter particles as they scatter radiance.
    NormalsNotAdjoint,
    /// The light that the lens sees directly is missing.
    EmittersUnseen,
}

/// light-nee, with a fault.
pub struct Saboteur(pub Fault);

impl Saboteur {
    fn is(&self, fault: Fault) -> bool {
        self.0 == fault
    }

    fn spoil(&self, query: &mut SensorQuery, vertex: &Vertex) {
        let to_lens = query.shadow.ray.d.normalize();
        if self.is(LostCosine) {
            query.shadow.contribution *= 1.0 / vertex.x.shading.to_local(to_lens).z.abs().max(0.05);
        }
        if self.is(NoShadows) {
            query.shadow.ray.t_max = 1e-6;
        }
        if self.is(NormalsNotAdjoint) {
            // [Veach 1997, eq. 5.19], undone.
            let (n, ns, from) = (vertex.x.n, vertex.x.shading.n, vertex.x.wo);
            let factor = (from.dot(ns) * to_lens.dot(n)) / (from.dot(n) * to_lens.dot(ns));
            query.shadow.contribution *= 1.0 / factor.abs().clamp(0.05, 20.0);
        }
    }
}

impl ParticleSolver for Saboteur {
    fn shoot(&self, c: &LightContext<'_>, u: &Sampler, tally: &mut Tally) {
        tally.surroundings(c, u);
        let Some((mut particle, light)) = Particle::emit(c.path.scene, u) else { return };
        tally.emitted(particle.carried());
        if let Some(query) = emitter_to_sensor(c, &particle, &light, u).filter(|_| !self.is(EmittersUnseen)) {
            tally.connect(c, &query, &particle);
        }
        let factor = match self.0 {
            HalvedPdf => 2.0,
            LightWithoutItsProbability => 1.0 / c.path.scene.emitters.len() as f32,
            _ => 1.0,
        };
        particle.beta.scatter(Spectrum::splat(factor));
        while let Some(x) = particle.meet(c, tally) {
            let mut vertex = Vertex::at(x);
            vertex.evaluate(c.path.scene, &particle.wl);
            if let Some(mut query) = to_sensor(c, &particle, &vertex, u) {
                self.spoil(&mut query, &vertex);
                tally.connect(c, &query, &particle);
            }
            let side = |w: Vec3| x.n.dot(w) > 0.0;
            if !particle.turn(c, &vertex, u, tally) {
                break;
            }
            if self.is(CompressedFlux) && side(x.wo) != side(particle.ray.d) && vertex.bsdf.eta() != 1.0 {
                let eta = if side(x.wo) { vertex.bsdf.eta() } else { 1.0 / vertex.bsdf.eta() };
                particle.beta.scatter(Spectrum::splat(1.0 / (eta * eta)));
            }
        }
    }

    fn reach(&self, max_edges: u32) -> u32 {
        max_edges.saturating_sub(1)
    }
}

impl Solver for Saboteur {
    type State = Books;

    fn needs(&self) -> Needs {
        Needs { no_mirrors_in_view: true, ..Needs::default() }
    }

    fn units(&self, size: [u32; 2]) -> usize {
        particles::units(size)
    }

    fn splats(&self) -> bool {
        true
    }

    fn prepare(&self, _: &Scene, _: &Run<'_>) -> Books {
        Books::default()
    }

    fn pass(&self, scene: &Scene, run: &Run<'_>, books: &mut Books, k: u32, work: &Work<'_>) -> Result<(), CannotGoOn> {
        particles::pass(self, scene, run, books, k, work);
        if self.is(SplatsNotNormalised) {
            let [width, height] = work.film.shape().size;
            work.film.start_particles(u64::from(width) * u64::from(height));
        }
        Ok(())
    }
}
