//! What a render is given: seeds, rules, threads, and the means to watch and to stop it. No globals.

use crate::drivers::Checkpoint;
use crate::solver::CannotGoOn;
use crate::transport::PathRules;
use etendue_film::{Allocation, NoiseEstimate};
use etendue_numerics::SequenceKind;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// When a render is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// After this many samples per pixel.
    Samples(u32),
    /// When the clock says so; the first pass is always finished.
    Time(Duration),
    /// When the estimated √relMSE is at most this many per cent, tested after 16·2^k passes; at the latest after `limit` passes.
    Noise {
        /// Per cent.
        percent: f64,
        /// Passes at most.
        limit: u32,
    },
}

/// How the samples of a noise target are spread over the pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spread {
    /// As many in every pixel.
    #[default]
    Uniform,
    /// More where the picture is noisy ([`etendue_film::Allocation`]), if the solver can.
    Adaptive,
}

/// Why a render ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stopped {
    /// All samples were taken.
    Samples,
    /// The time was up.
    Time,
    /// The noise target was reached.
    Noise,
    /// The pass limit was reached before the noise target.
    Limit,
    /// Somebody asked it to stop.
    Cancelled,
    /// The solver could not go on.
    Failed(CannotGoOn),
}

/// A request to stop, shared between threads.
#[derive(Debug, Default)]
pub struct CancelToken(AtomicBool);

impl CancelToken {
    /// Asks the render to stop soon and keep what is done.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether that was asked.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// How far a render is, to be read at any time from any thread.
#[derive(Debug, Default)]
pub struct Progress {
    /// Whole passes done.
    pub passes: AtomicU64,
    /// Units of work done in the pass that runs: tiles of pixels, chunks of particles.
    pub tiles: AtomicU64,
    /// Units of a pass.
    pub tiles_per_pass: AtomicU64,
    /// Paths started.
    pub paths: AtomicU64,
    /// Rays cast, shadow rays included.
    pub rays: AtomicU64,
}

impl Progress {
    /// Passes done, the fraction of the running one included.
    pub fn fractional_passes(&self) -> f64 {
        let tiles = self.tiles_per_pass.load(Ordering::Relaxed).max(1) as f64;
        self.passes.load(Ordering::Relaxed) as f64 + self.tiles.load(Ordering::Relaxed) as f64 / tiles
    }
}

/// What happens during a render.
#[derive(Clone, Debug)]
pub enum Event<'a> {
    /// A whole pass was finished; so many are done.
    Pass(u32),
    /// The noise was estimated after so many passes.
    Noise(u32, NoiseEstimate),
    /// A state from which the render can be resumed, when one is due.
    Checkpoint(&'a Checkpoint),
}

/// Everything that a render is given besides the scene.
pub struct Run<'a> {
    /// Which of the scene's views.
    pub view: usize,
    /// Seed of all random decisions.
    pub seed: u64,
    /// Point set.
    pub sequence: SequenceKind,
    /// When to stop.
    pub stop: Stop,
    /// How samples are spread over the pixels, where there is a noise target.
    pub spread: Spread,
    /// Which paths count.
    pub rules: PathRules,
    /// What the scene and its settings boil down to: a checkpoint of another digest is refused.
    pub digest: u64,
    /// Threads.
    pub pool: &'a rayon::ThreadPool,
    /// The request to stop early.
    pub cancel: &'a CancelToken,
    /// How far it is.
    pub progress: &'a Progress,
    /// Who is told.
    pub events: &'a (dyn Fn(Event<'_>) + Sync),
    /// How often a checkpoint is due; the last state is always offered where this is set.
    pub checkpoint_every: Option<Duration>,
}

impl Run<'_> {
    /// Samples per pixel that the point set is laid out for.
    pub fn planned_samples(&self) -> u32 {
        match self.stop {
            Stop::Samples(n) => n.max(1),
            Stop::Time(_) => 1 << 16,
            Stop::Noise { limit, .. } => {
                let even = limit.div_ceil(etendue_film::Replicates::K as u32).max(1);
                // Where a pixel takes more than its share, its numbers are still of one set.
                let most = if self.spread == Spread::Adaptive { even.saturating_mul(Allocation::MOST).min(1 << 16) } else { even };
                most.max(even)
            }
        }
    }
}
