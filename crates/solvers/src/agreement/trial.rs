//! Renders replicates: the same work with other seeds.

use super::{Grid, Sample};
use crate::drivers::{CannotResume, Outcome};
use crate::run::{CancelToken, Progress, Run, Spread, Stop, Stopped};
use crate::solver::{CannotGoOn, Solver};
use crate::transport::PathRules;
use etendue_film::{Film, FilmShape};
use etendue_numerics::SequenceKind;
use etendue_numerics::sequence::mix;
use etendue_scene::Scene;
use std::time::Duration;

/// Renders with one solver onto a blank film: [`crate::AnySolver::render`] or [`crate::render`], all but run and film given.
pub type Renderer<'a> = dyn Fn(&Run<'_>, &Film) -> Result<Outcome, CannotResume> + Sync + 'a;

/// What every replicate shares.
#[derive(Clone, Copy)]
pub struct Trial<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Which of its views.
    pub view: usize,
    /// Which paths count.
    pub rules: PathRules,
    /// Seed of all replicates; other seeds are other, independent trials.
    pub seed: u64,
    /// Point set.
    pub sequence: SequenceKind,
    /// Blocks across and down that are compared, at most.
    pub blocks: u32,
    /// Threads.
    pub pool: &'a rayon::ThreadPool,
    /// The request to stop.
    pub cancel: &'a CancelToken,
}

/// Why there is no picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoPicture {
    /// It was asked to stop.
    Cancelled,
    /// The solver could not go on.
    Failed(CannotGoOn),
}

/// One picture.
#[derive(Clone, Debug)]
pub struct Shot {
    /// Linear Rec.709, rows from the top.
    pub pixels: Vec<[f32; 3]>,
    /// From the first ray to the last.
    pub elapsed: Duration,
    /// Rays cast.
    pub rays: u64,
    /// Samples that were not finite, and dropped.
    pub dropped: u64,
}

impl<'a> Trial<'a> {
    /// All light in the first view of a scene.
    pub fn new(scene: &'a Scene, pool: &'a rayon::ThreadPool, cancel: &'a CancelToken) -> Self {
        let rules = PathRules::of(&scene.integrator);
        Self { scene, view: 0, rules, seed: 0, sequence: SequenceKind::Sobol, blocks: Grid::BLOCKS, pool, cancel }
    }

    /// Size and filter of the picture.
    pub fn shape(&self) -> FilmShape {
        let film = &self.scene.views[self.view].film;
        FilmShape { size: film.crop_size, kernel: film.filter }
    }

    /// The areas that are compared: the blocks, fewer of a small picture.
    pub fn grid(&self) -> Grid {
        Grid::new(self.shape().size, self.blocks)
    }

    /// The renderer of a solver.
    pub fn renderer<S: Solver>(&self, solver: &'a S) -> Box<Renderer<'a>> {
        let scene = self.scene;
        Box::new(move |run, film| crate::drivers::render(solver, "trial", scene, run, film, None))
    }

    /// The seed of replicate `r` of a stream (one for each solver and purpose): all are independent of each other.
    pub fn seed_of(&self, stream: u64, r: u32) -> u64 {
        mix(self.seed ^ mix(stream ^ mix(u64::from(r) + 1)))
    }

    /// A picture; `watch` is told of every pass, with the film as it is then.
    pub fn shoot(
        &self,
        render: &Renderer<'_>,
        stop: Stop,
        seed: u64,
        watch: &(dyn Fn(u32, &Film) + Sync),
    ) -> Result<Shot, NoPicture> {
        let film = Film::new(self.shape());
        let progress = Progress::default();
        let events = |event: crate::run::Event<'_>| {
            if let crate::run::Event::Pass(k) = event {
                watch(k, &film);
            }
        };
        let run = Run {
            view: self.view,
            seed,
            sequence: self.sequence,
            stop,
            spread: Spread::Uniform,
            rules: self.rules,
            digest: 0,
            pool: self.pool,
            cancel: self.cancel,
            progress: &progress,
            events: &events,
            checkpoint_every: None,
        };
        // A run that resumes nothing cannot fail to.
        let outcome = render(&run, &film).map_err(|_| NoPicture::Cancelled)?;
        match outcome.stopped {
            Stopped::Cancelled => Err(NoPicture::Cancelled),
            Stopped::Failed(why) => Err(NoPicture::Failed(why)),
            Stopped::Samples | Stopped::Time | Stopped::Noise | Stopped::Limit => Ok(Shot {
                pixels: film.develop(),
                elapsed: outcome.elapsed,
                rays: progress.rays.load(std::sync::atomic::Ordering::Relaxed),
                dropped: film.dropped().0,
            }),
        }
    }

    /// Replicate `r` of `spp` samples per pixel.
    pub fn replicate(&self, render: &Renderer<'_>, spp: u32, stream: u64, r: u32) -> Result<Shot, NoPicture> {
        self.shoot(render, Stop::Samples(spp), self.seed_of(stream, r), &|_, _| ())
    }

    /// `k` replicates of `spp` samples per pixel.
    pub fn sample(&self, render: &Renderer<'_>, spp: u32, k: u32, stream: u64) -> Result<Sample, NoPicture> {
        let mut sample = Sample::new(self.grid());
        for r in 0..k {
            sample.add(&self.replicate(render, spp, stream, r)?.pixels);
        }
        Ok(sample)
    }

    /// Samples per pixel, a power of two, of which `k` replicates take about `time`: from a few short pictures, which are thrown away.
    pub fn samples_in(&self, render: &Renderer<'_>, time: Duration, k: u32) -> Result<u32, NoPicture> {
        let slice = time.as_secs_f64() / f64::from(k.max(1));
        let mut spp = 1u32;
        loop {
            let took = self.shoot(render, Stop::Samples(spp), self.seed_of(u64::MAX, spp), &|_, _| ())?.elapsed.as_secs_f64();
            if took >= 0.25 * slice || spp >= 1 << 15 {
                let times = (slice / took.max(1e-9)).log2().round().clamp(-16.0, 4.0);
                return Ok((f64::from(spp) * times.exp2()).max(1.0) as u32);
            }
            spp *= if took < 0.05 * slice { 4 } else { 2 };
        }
    }
}
