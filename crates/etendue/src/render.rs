//! Renders a loaded scene.

use crate::choice::{Choice, advise, choose};
use crate::digest::Digest;
use crate::guard::guarded;
pub use crate::guard::panic_words;
use crate::load::Loaded;
use crate::memory::{self, Need};
pub use crate::picture::{filter_words, software};
use crate::picture::{mean, picture, words};
use crate::stats::Stats;
use crate::{layers, pool};
use etendue_film::{Film, FilmShape, NoiseEstimate, NonFinite};
use etendue_image::Picture;
use etendue_numerics::SequenceKind;
use etendue_scene::View;
use etendue_solvers::aov::Quantity;
use etendue_solvers::{Balance, CancelToken, Checkpoint, Event, Outcome, PathRules, Progress, Run, Spread, Stop, Stopped};
use std::fmt;
use std::ops::RangeInclusive;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// How to render.
#[derive(Clone, Debug, Default)]
pub struct RenderOptions {
    /// Which of the scene's views, 0 = the first.
    pub view: usize,
    /// Solver name; the scene's own otherwise.
    pub solver: Option<String>,
    /// Why it is that one, where it was chosen by [`advise`].
    pub because: Option<String>,
    /// Parameters of the solver, by name; its defaults otherwise.
    pub parameters: Vec<(String, String)>,
    /// When to stop; after the scene's sample count otherwise.
    pub stop: Option<Stop>,
    /// How the samples of a noise target are spread over the pixels; without a word, where there is noise, if the solver can.
    pub spread: Option<Spread>,
    /// Seed; the scene's own otherwise.
    pub seed: Option<u64>,
    /// Threads; all cores otherwise.
    pub threads: Option<usize>,
    /// Edges between eye and light at most: `Some(None)` is unbounded; the scene's own limit otherwise.
    pub max_depth: Option<Option<u32>>,
    /// Light of exactly these numbers of bounces, 0 = emitters.
    pub bounces: Option<RangeInclusive<u32>>,
    /// Point set; Owen-scrambled Sobol' otherwise.
    pub sequence: Option<SequenceKind>,
    /// Layers beside the picture.
    pub aovs: Vec<Quantity>,
    /// How often a checkpoint is offered.
    pub checkpoint_every: Option<Duration>,
    /// Where to go on from.
    pub resume: Option<Box<Checkpoint>>,
}

/// Somebody who is told what happens.
pub type Listener = Box<dyn Fn(Event<'_>) + Send + Sync>;

/// The means to watch a render and to stop it.
#[derive(Default)]
pub struct Watch {
    /// The request to stop.
    pub cancel: CancelToken,
    /// How far it is.
    pub progress: Progress,
    /// Told of passes, noise estimates and checkpoints.
    pub events: Option<Listener>,
}

/// A finished, or stopped, render.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// The picture with its layers and the words for its header.
    pub picture: Picture,
    /// The numbers.
    pub stats: Stats,
    /// Why it ended.
    pub stopped: Stopped,
    /// Why the picture is black, if it is.
    pub black: Vec<String>,
    /// Why the render ended early, if its solver could not go on or panicked; the picture holds what was rendered before.
    pub failure: Option<String>,
}

impl Rendering {
    /// The picture's mean, linear Rec.709.
    pub fn mean(&self) -> [f64; 3] {
        self.stats.mean
    }
}

/// Why there is no render.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RenderError(pub String);

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for RenderError {}

/// What a render will do, after all that can be refused has been.
struct Plan<'a> {
    view: &'a View,
    choice: Choice,
    because: Option<String>,
    layers: Vec<layers::Plan>,
    shape: FilmShape,
    stop: Stop,
    spread: Spread,
}

impl<'a> Plan<'a> {
    fn new(loaded: &'a Loaded, options: &RenderOptions) -> Result<Self, RenderError> {
        let view = view(loaded, options.view)?;
        let advice = advise(loaded, options)?;
        let solver = advice.as_ref().map(|a| a.solver).or(options.solver.as_deref());
        let choice = choose(solver, &options.parameters, loaded)?;
        let because = advice.map(|a| a.reason).or_else(|| options.because.clone());
        let layers = layers::plan(loaded, &options.aovs)?;
        let shape = FilmShape { size: view.film.crop_size, kernel: view.film.filter };
        let stop = options.stop.unwrap_or(Stop::Samples(view.sampler.count));
        let spread = spread(options, stop, &choice)?;
        let layer_bytes = layers::bytes_per_pixel(&layers);
        let checkpoints = options.checkpoint_every.is_some();
        let solver_bytes = choice.holds(shape.size);
        let resumes = options.resume.is_some();
        Need { size: shape.size, stop, spread, layer_bytes, solver_bytes, checkpoints, resumes }.check()?;
        Ok(Self { view, choice, because, layers, shape, stop, spread })
    }
}

/// Whether [`render`] would begin: an unknown view or solver, a scene that the solver cannot do and a picture too large for
/// memory are refused here.
pub fn check(loaded: &Loaded, options: &RenderOptions) -> Result<(), RenderError> {
    Plan::new(loaded, options).map(drop)
}

/// Renders a view of a scene.
pub fn render(loaded: &Loaded, options: &RenderOptions, watch: &Watch) -> Result<Rendering, RenderError> {
    let scene = &loaded.scene;
    let Plan { view, choice, because, layers: plans, shape, stop, spread } = Plan::new(loaded, options)?;
    let pool = pool::pool(options.threads)?;
    let rules = rules(loaded, options);
    let sequence = options.sequence.unwrap_or_default();
    let resumable = options.checkpoint_every.is_some() || options.resume.is_some();
    let silent = |_: Event<'_>| ();
    let events: &(dyn Fn(Event<'_>) + Sync) = match &watch.events {
        Some(events) => events,
        None => &silent,
    };
    let run = Run {
        view: options.view,
        seed: options.seed.unwrap_or(view.sampler.seed),
        sequence,
        stop,
        spread,
        rules,
        digest: if resumable { digest(loaded, options.view, &rules, sequence, &choice.parameters()) } else { 0 },
        pool: &pool,
        cancel: &watch.cancel,
        progress: &watch.progress,
        events,
        checkpoint_every: options.checkpoint_every,
    };

    let film = Film::new(shape);
    let resume = options.resume.as_deref();
    let begun = Instant::now();
    let (name, attempt) = match &choice {
        Choice::Solver(solver) => (solver.name(), guarded(|| solver.render(scene, &run, &film, resume))),
        Choice::Quantity(aov) => (aov.0.name(), guarded(|| etendue_solvers::render(aov, "aov", scene, &run, &film, resume))),
    };
    let (end, failure) = match attempt {
        Ok(outcome) => {
            let outcome = outcome.map_err(|e| RenderError(e.to_string()))?;
            let failure = if let Stopped::Failed(why) = outcome.stopped { Some(why.to_string()) } else { None };
            (End::of(outcome), failure)
        }
        Err(words) => {
            let passes = watch.progress.passes.load(Ordering::Relaxed) as u32;
            let elapsed = begun.elapsed();
            (End { stopped: Stopped::Cancelled, passes, noise: None, samples: None, elapsed, books: None }, Some(words))
        }
    };

    let pixels = film.develop();
    let (nonfinite, first) = film.dropped();
    drop(film);
    let mean = mean(&pixels);
    let layers = if failure.is_some() {
        Vec::new()
    } else {
        layers::render(&plans, end.passes, end.samples.as_deref(), loaded, &run, shape)?
    };
    let black = if mean == [0.0; 3] { why_black(loaded, &rules) } else { Vec::new() };
    let picture = picture(pixels, view.film.channels, shape.size, layers, words(loaded, name, end.passes, &run, view))?;
    let stats = Stats {
        software: software(),
        scene: loaded.name.clone(),
        solver: name.to_owned(),
        because,
        width: shape.size[0],
        height: shape.size[1],
        spp: end.passes,
        seed: run.seed,
        threads: pool.current_num_threads(),
        load_seconds: loaded.read_time.as_secs_f64(),
        build_seconds: loaded.build_time.as_secs_f64(),
        render_seconds: end.elapsed.as_secs_f64(),
        paths: watch.progress.paths.load(Ordering::Relaxed),
        rays: watch.progress.rays.load(Ordering::Relaxed),
        peak_memory_bytes: memory::peak(),
        nonfinite_samples: nonfinite,
        nonfinite_first: first.iter().map(|NonFinite { pixel, sample }| [pixel[0], pixel[1], *sample]).collect(),
        triangles: scene.triangles,
        mean,
        stopped: if failure.is_some() { FAILED } else { stopped_word(end.stopped) }.to_owned(),
        samples: end.samples.as_ref().and_then(|s| Some([*s.iter().min()?, *s.iter().max()?])),
        noise_percent: end.noise.map(|n| <[f64; 3]>::from(n.percent())),
        lights: Vec::new(),
        books: end.books,
    };
    Ok(Rendering { picture, stats, stopped: end.stopped, black, failure })
}

/// How a render ended, of itself or by a panic.
struct End {
    stopped: Stopped,
    passes: u32,
    noise: Option<NoiseEstimate>,
    samples: Option<Vec<u32>>,
    elapsed: Duration,
    books: Option<Balance>,
}

impl End {
    fn of(outcome: Outcome) -> Self {
        Self {
            stopped: outcome.stopped,
            passes: outcome.passes,
            noise: outcome.noise,
            samples: outcome.samples,
            elapsed: outcome.elapsed,
            books: outcome.books,
        }
    }
}

pub(crate) fn view(loaded: &Loaded, index: usize) -> Result<&View, RenderError> {
    let count = loaded.scene.views.len();
    loaded.scene.views.get(index).ok_or_else(|| {
        let s = if count == 1 { "" } else { "s" };
        RenderError(format!("there is no view {index}: the scene has {count} sensor{s}, counted from 0"))
    })
}

/// How samples are spread: where there is noise unless told otherwise, if they can be; what would change nothing is refused.
fn spread(options: &RenderOptions, stop: Stop, choice: &Choice) -> Result<Spread, RenderError> {
    match options.spread {
        _ if !matches!(stop, Stop::Noise { .. }) => Ok(Spread::Uniform),
        Some(Spread::Adaptive) if choice.shares() => Err(RenderError(
            "walks of neighbouring pixels share what they find where all take as many samples: `block` and an adaptive spread exclude each other\n  \
            help: give one of the two up: --param block=1, or --spread uniform"
                .to_owned(),
        )),
        Some(Spread::Adaptive) if !choice.adapts() => Err(RenderError(
            "this solver spreads its samples uniformly: what it finds from the lights, or all over the picture at once, falls into any pixel\n  \
            help: solvers that take more samples where there is noise: path-mis, path-guided, path-nee, path, direct, whitted, distribution"
                .to_owned(),
        )),
        None if choice.adapts() && !choice.shares() => Ok(Spread::Adaptive),
        spread => Ok(spread.unwrap_or_default()),
    }
}

pub(crate) fn rules(loaded: &Loaded, options: &RenderOptions) -> PathRules {
    let mut rules = PathRules::of(&loaded.scene.integrator);
    if let Some(depth) = options.max_depth {
        rules.max_edges = depth.unwrap_or(u32::MAX);
    }
    match &options.bounces {
        Some(bounces) => rules.with_bounces(bounces.clone()),
        None => rules,
    }
}

fn why_black(loaded: &Loaded, rules: &PathRules) -> Vec<String> {
    let mut reasons = loaded.scene.diagnose();
    if reasons.is_empty() && (rules.min_edges > 1 || rules.max_edges < u32::MAX) {
        let most = if rules.max_edges == u32::MAX { "any number".to_owned() } else { rules.max_edges.to_string() };
        reasons.push(format!(
            "only paths of {} to {most} edges between eye and light count: 1 shows emitters, 2 adds direct light (--max-depth, --bounces)",
            rules.min_edges
        ));
    }
    reasons
}

/// All that decides the bits besides solver, seed and sample count, which a checkpoint tells in words.
fn digest(loaded: &Loaded, view: usize, rules: &PathRules, sequence: SequenceKind, parameters: &str) -> u64 {
    let mut digest = Digest::new();
    digest.word(loaded.digest());
    digest.bytes(format!("{view} {rules:?} {sequence:?} {parameters}").as_bytes());
    digest.finish()
}

/// How [`Stats`] call the end of a render that could not go on.
const FAILED: &str = "failed";

fn stopped_word(stopped: Stopped) -> &'static str {
    match stopped {
        Stopped::Samples => "samples",
        Stopped::Time => "time",
        Stopped::Noise => "noise",
        Stopped::Limit => "limit",
        Stopped::Cancelled => "cancelled",
        Stopped::Failed(_) => FAILED,
    }
}
