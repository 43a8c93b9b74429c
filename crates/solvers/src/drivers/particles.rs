//! Passes over particles: as many as the film has pixels, chunk by chunk, each chunk one thread's work.
//!
//! ```text
//! I_j = 1/N Σ_i splats of particle i at pixel j,    N = passes · width · height
//! ```
//!
//! Particles are numbered through all passes, and the numbers of particle i are point i of one sequence: a pass is an aligned part of a net, so
//! that lights, places and directions are stratified within a pass and over all of them. Splats are collected by chunk and added to the film's
//! exact sums.

use super::Work;
use super::books::Books;
use super::pixels::SamplePlan;
use crate::run::Run;
use crate::solver::Needs;
use crate::transport::{Context, LightContext, Tally};
use etendue_numerics::{Sampler, SequenceKind};
use etendue_scene::Scene;
use rayon::prelude::*;
use std::sync::atomic::Ordering;
use std::sync::{Mutex, PoisonError};

/// Particles of a unit of work.
pub(crate) const CHUNK: u64 = 1024;

/// A solver that follows particles.
pub trait ParticleSolver: Sync {
    /// What a scene must have.
    fn needs(&self) -> Needs {
        Needs::default()
    }

    /// Follows one particle and adds to `tally` what reaches the sensor.
    fn shoot(&self, c: &LightContext<'_>, u: &Sampler, tally: &mut Tally);

    /// The most edges that a walk of this solver may have and still be of use, where paths have at most so many.
    fn reach(&self, max_edges: u32) -> u32 {
        max_edges
    }
}

/// Makes a [`ParticleSolver`] a [`crate::Solver`]. (An implementation for all of them would overlap that for all [`super::PixelSolver`]s.)
#[macro_export]
macro_rules! solve_by_particles {
    ($solver:ty) => {
        impl $crate::Solver for $solver {
            type State = $crate::drivers::Books;

            fn needs(&self) -> $crate::solver::Needs {
                $crate::drivers::ParticleSolver::needs(self)
            }

            fn splats(&self) -> bool {
                true
            }

            fn units(&self, size: [u32; 2]) -> usize {
                $crate::drivers::particles::units(size)
            }

            fn prepare(&self, _: &etendue_scene::Scene, _: &$crate::Run<'_>) -> Self::State {
                Self::State::default()
            }

            fn pass(
                &self,
                scene: &etendue_scene::Scene,
                run: &$crate::Run<'_>,
                books: &mut Self::State,
                k: u32,
                work: &$crate::Work<'_>,
            ) -> Result<(), $crate::solver::CannotGoOn> {
                $crate::drivers::particles::pass(self, scene, run, books, k, work);
                Ok(())
            }

            fn books(&self, books: &Self::State) -> Option<$crate::Balance> {
                Some(books.balance())
            }
        }
    };
}

/// Units of a pass.
pub fn units(size: [u32; 2]) -> usize {
    (u64::from(size[0]) * u64::from(size[1])).div_ceil(CHUNK) as usize
}

/// Pass k: a particle for each pixel. In noise mode passes belong to replicates in turn, each with a scramble of its own.
pub fn pass(solver: &impl ParticleSolver, scene: &Scene, run: &Run<'_>, books: &mut Books, k: u32, work: &Work<'_>) {
    let view = &scene.views[run.view];
    let [width, height] = view.film.crop_size;
    let path = Context { scene, rules: run.rules };
    let c = LightContext { path, view, reach: solver.reach(run.rules.max_edges) };
    let numbers = Numbers::new(run, k, u64::from(width) * u64::from(height));

    let books = Mutex::new(books);
    (0..work.units.len()).into_par_iter().for_each_init(
        || Tally::new(&view.film),
        |tally, unit| {
            if work.units.is_done(unit) || (work.stop_now)() {
                return;
            }
            tally.clear();
            let first = unit as u64 * CHUNK;
            let count = CHUNK.min(numbers.per_pass - first);
            for i in first..first + count {
                tally.begin(u64::from(k) * numbers.per_pass + i);
                solver.shoot(&c, &numbers.of(i), tally);
            }
            work.film.add_splats(tally.splats());
            work.film.start_particles(count);
            books.lock().unwrap_or_else(PoisonError::into_inner).add(tally.entries(), count);
            numbers.track(tally, work);
            work.units.done(unit);
            work.progress.tiles.fetch_add(1, Ordering::Relaxed);
            work.progress.rays.fetch_add(tally.rays, Ordering::Relaxed);
            work.progress.paths.fetch_add(count, Ordering::Relaxed);
        },
    );
}

/// The numbers of a pass.
pub(crate) struct Numbers<'a> {
    plan: SamplePlan,
    run: &'a Run<'a>,
    per_pass: u64,
}

impl<'a> Numbers<'a> {
    /// Those of pass k of so many particles each.
    pub(crate) fn new(run: &'a Run<'a>, k: u32, per_pass: u64) -> Self {
        Self { plan: SamplePlan::new(run, k), run, per_pass }
    }

    /// Those of the pass's particle i.
    #[inline]
    pub(crate) fn of(&self, i: u64) -> Sampler {
        let plan = &self.plan;
        // Strata are laid out for a pass, nets for all of them.
        if self.run.sequence == SequenceKind::Stratified {
            return Sampler::new(self.run.sequence, plan.seed, u64::from(plan.sample) << 32, i as u32, self.per_pass as u32);
        }
        // Passes begin at multiples of a power of two; what has no room in 32 bits goes on in another sequence.
        let number = u64::from(plan.sample) * self.per_pass.next_power_of_two() + i;
        Sampler::new(self.run.sequence, plan.seed, number >> 32, number as u32, u32::MAX)
    }

    /// Notes a chunk's splats by pixel, in noise mode.
    fn track(&self, tally: &Tally, work: &Work<'_>) {
        let Some(replicates) = work.replicates else { return };
        let mut sums = replicates.lock().unwrap_or_else(PoisonError::into_inner);
        for splat in tally.splats() {
            let pixel = [splat.position.x as u32, splat.position.y as u32];
            if let Some(slot) = sums.slot(pixel) {
                let value = splat.value / self.per_pass as f32;
                sums.add(self.plan.replicate, slot, value.to_rgb());
            }
        }
    }
}
