//! The loop around a solver's passes: clock, noise test, cancellation, progress and checkpoints are written here, once.

mod allotted;
mod books;
mod checkpoint;
mod ledger;
pub mod particles;
pub mod pixels;

pub use books::{Balance, Books};
pub use checkpoint::{CannotResume, Checkpoint};
pub use ledger::Ledger;
pub use particles::ParticleSolver;
pub use pixels::PixelSolver;

use crate::run::{Event, Progress, Run, Spread, Stop, Stopped};
use crate::solver::Solver;
use etendue_film::{Allocation, Film, NoiseEstimate, Replicates};
use etendue_scene::Scene;
use std::sync::Mutex;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// What a pass adds to.
pub struct Work<'a> {
    /// The film.
    pub film: &'a Film,
    /// Replicate sums, in noise mode.
    pub replicates: Option<&'a Mutex<Replicates>>,
    /// How many samples each pixel gets, where that differs.
    pub allocation: Option<&'a Allocation>,
    /// Which units of the pass are done; a stopped pass leaves some undone.
    pub units: &'a Ledger,
    /// Whether the pass should stop where it is.
    pub stop_now: &'a (dyn Fn() -> bool + Sync),
    /// Counters.
    pub progress: &'a Progress,
}

/// How a render ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Why.
    pub stopped: Stopped,
    /// Whole passes done.
    pub passes: u32,
    /// The last noise estimate, in noise mode.
    pub noise: Option<NoiseEstimate>,
    /// From the first ray to the last, of this call.
    pub elapsed: Duration,
    /// Samples per pixel, rows from the top, where they differ.
    pub samples: Option<Vec<u32>>,
    /// Where the light went, if the solver follows light.
    pub books: Option<Balance>,
}

/// Runs `solver` until `run.stop`, from the beginning or from a checkpoint, adding to a blank `film`.
///
/// The same scene, solver and run give the same bits on any number of threads, stopped and resumed or not.
pub fn render<S: Solver>(
    solver: &S,
    name: &str,
    scene: &Scene,
    run: &Run<'_>,
    film: &Film,
    resume: Option<&Checkpoint>,
) -> Result<Outcome, CannotResume> {
    let begun = Instant::now();
    let mut state = solver.prepare(scene, run);
    let mut k = 0;
    let ledger = Ledger::new(solver.units(film.shape().size));
    let noise_mode = matches!(run.stop, Stop::Noise { .. });
    let adaptive = noise_mode && run.spread == Spread::Adaptive && solver.adapts();
    let size = film.shape().size;
    let blank = || if solver.splats() { Replicates::new(size) } else { Replicates::of_tiles(size, adaptive) };
    let replicates = noise_mode.then(|| Mutex::new(blank()));
    let mut allocation = adaptive.then(|| Allocation::new(size));
    if let Some(checkpoint) = resume {
        checkpoint.check(name, run, film, adaptive)?;
        state = checkpoint.restore(film, &ledger, replicates.as_ref(), &mut allocation)?;
        k = checkpoint.passes;
    }
    run.progress.passes.store(u64::from(k), Ordering::Relaxed);
    run.progress.tiles_per_pass.store(ledger.len() as u64, Ordering::Relaxed);

    let last_pass = match run.stop {
        Stop::Samples(n) => n,
        Stop::Time(_) => u32::MAX,
        Stop::Noise { limit, .. } => limit,
    };
    let mut saved = Instant::now();
    let mut noise = None;
    let stopped = loop {
        if k >= last_pass {
            break if noise_mode { Stopped::Limit } else { Stopped::Samples };
        }
        // The first pass is finished whatever the clock says: a picture with holes is no picture.
        let time_up = || matches!(run.stop, Stop::Time(limit) if k > 0 && begun.elapsed() >= limit);
        let stop_now = || run.cancel.is_cancelled() || time_up();
        if !stop_now() {
            let (replicates, allocation) = (replicates.as_ref(), allocation.as_ref().filter(|a| !a.is_even()));
            let work = Work { film, replicates, allocation, units: &ledger, stop_now: &stop_now, progress: run.progress };
            if let Err(why) = run.pool.install(|| solver.pass(scene, run, &mut state, k, &work)) {
                break Stopped::Failed(why);
            }
        }
        if stop_now() && !ledger.is_complete() {
            break if run.cancel.is_cancelled() { Stopped::Cancelled } else { Stopped::Time };
        }
        k += 1;
        ledger.clear();
        run.progress.tiles.store(0, Ordering::Relaxed);
        run.progress.passes.store(u64::from(k), Ordering::Relaxed);
        (run.events)(Event::Pass(k));

        if let (Stop::Noise { percent, .. }, Some(replicates)) = (run.stop, &replicates)
            && is_test_point(k)
        {
            let sums = replicates.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            let estimate = sums.estimate(k / Replicates::K as u32, film.shape().kernel.noise_factor());
            noise = Some(estimate);
            (run.events)(Event::Noise(k, estimate));
            if estimate.percent().0 <= percent {
                break Stopped::Noise;
            }
            if let Some(allocation) = &mut allocation {
                allocation.advance(&sums, &film.develop());
            }
        }
        if run.checkpoint_every.is_some_and(|every| saved.elapsed() >= every) && k < last_pass {
            let replicates = replicates.as_ref();
            (run.events)(Event::Checkpoint(&Checkpoint::take(
                name,
                run,
                k,
                &state,
                film,
                &ledger,
                replicates,
                allocation.as_ref(),
            )));
            saved = Instant::now();
        }
    };
    if run.checkpoint_every.is_some() {
        let replicates = replicates.as_ref();
        (run.events)(Event::Checkpoint(&Checkpoint::take(name, run, k, &state, film, &ledger, replicates, allocation.as_ref())));
    }
    let samples = allocation.filter(|a| !a.is_even()).map(|a| a.taken(k));
    Ok(Outcome { stopped, passes: k, noise, samples, elapsed: begun.elapsed(), books: solver.books(&state) })
}

/// Noise is tested after K·2^j passes only: testing at every pass would stop on lucky ones.
fn is_test_point(k: u32) -> bool {
    let rounds = k / Replicates::K as u32;
    k.is_multiple_of(Replicates::K as u32) && rounds.is_power_of_two()
}
