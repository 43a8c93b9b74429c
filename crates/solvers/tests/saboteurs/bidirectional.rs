//! Bidirectional path tracing with one deliberate fault at a time.

#[path = "../common/bidirectional.rs"]
mod pass;

use etendue_numerics::Spectrum;
use etendue_scene::Scene;
use etendue_solvers::bidirectional::{Bidirectional, Found, Joint};
use etendue_solvers::solver::{CannotGoOn, Needs};
use etendue_solvers::{Run, Solver, Work};
use pass::one_by_one;

faults! {
    /// The weights leave a place for next event estimation, and nobody takes it.
    NoNextEvent,
    /// The same of connections to the lens.
    NoLens,
    /// The same of lamps that the eye's walk hits.
    NoHits,
    /// What next event estimation finds counts in full.
    MisOffForTheLight,
    /// What connections of inner vertices find counts in full.
    MisOffWithin,
    /// Splats are divided by twice the particles started.
    SplatsNotNormalised,
    /// Inner connections without 1/r².
    LostDistance,
    /// Inner connections without the cosine at the light's side.
    LostCosine,
}

/// bidirectional, with a fault; one thread does a pass.
pub struct Saboteur(pub Fault);

impl Saboteur {
    /// What a path adds to the picture.
    fn share(&self, f: &Found<'_>) -> Spectrum {
        let mut value = f.value * f.weight;
        match (self.0, f.joint) {
            (NoNextEvent, Joint::Light(..)) | (NoLens, Joint::Lens(..)) => return Spectrum::ZERO,
            (NoHits, Joint::Hit(Some(_), _)) => return Spectrum::ZERO,
            (MisOffForTheLight, Joint::Light(..)) | (MisOffWithin, Joint::Inner(..)) => value = f.value,
            (LostDistance, Joint::Inner(y, z)) => value *= (y.vertex.x.p - z.vertex.x.p).length_squared(),
            (LostCosine, Joint::Inner(y, z)) => {
                let w = (y.vertex.x.p - z.vertex.x.p).normalize_or_zero();
                value *= 1.0 / z.vertex.x.n.dot(w).abs().max(0.05);
            }
            _ => (),
        }
        value
    }
}

impl Solver for Saboteur {
    type State = ();

    fn needs(&self) -> Needs {
        Needs::default()
    }

    fn units(&self, _: [u32; 2]) -> usize {
        1
    }

    fn splats(&self) -> bool {
        true
    }

    fn prepare(&self, _: &Scene, _: &Run<'_>) {}

    fn pass(&self, scene: &Scene, run: &Run<'_>, (): &mut (), k: u32, work: &Work<'_>) -> Result<(), CannotGoOn> {
        let started = one_by_one(&Bidirectional::default().strategies(scene, run), run, k, work, |f| self.share(f));
        if self.0 == SplatsNotNormalised {
            work.film.start_particles(started);
        }
        Ok(())
    }
}
