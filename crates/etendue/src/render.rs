//! Renders a loaded scene.

use crate::load::Loaded;
use crate::memory;
use crate::stats::Stats;
use etendue_description::nearest;
use etendue_film::{Film, FilmShape, NonFinite, Replicates};
use etendue_image::{Image, Layer, Picture};
use etendue_numerics::SequenceKind;
use etendue_solvers::aov::{Aov, Quantity};
use etendue_solvers::{AnySolver, CancelToken, Checkpoint, Event, Outcome, PathRules, Progress, Run, SOLVERS, Stop, Stopped};
use std::fmt;
use std::ops::RangeInclusive;
use std::time::Duration;

/// How to render.
#[derive(Clone, Debug, Default)]
pub struct RenderOptions {
    /// Solver name; the scene's own otherwise.
    pub solver: Option<String>,
    /// When to stop; after the scene's sample count otherwise.
    pub stop: Option<Stop>,
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

/// The means to watch a render and to stop it.
#[derive(Default)]
pub struct Watch {
    /// The request to stop.
    pub cancel: CancelToken,
    /// How far it is.
    pub progress: Progress,
    /// Told of passes, noise estimates and checkpoints.
    pub events: Option<Box<dyn Fn(Event<'_>) + Send + Sync>>,
}

/// A finished, or stopped, render.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// The picture with its layers and the words for its header.
    pub picture: Picture,
    /// The numbers.
    pub stats: Stats,
    /// How it ended.
    pub outcome: Outcome,
    /// Why the picture is black, if it is.
    pub black: Vec<String>,
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

/// Solvers that are known by name and not there yet.
const PLANNED: &[&str] =
    &["whitted", "distribution", "light", "light-nee", "bidirectional", "photon-map", "metropolis", "radiosity", "auto"];

/// Renders the first view of a scene.
pub fn render(loaded: &Loaded, options: &RenderOptions, watch: &Watch) -> Result<Rendering, RenderError> {
    let scene = &loaded.scene;
    let view = &scene.views[0];
    let integrator = &scene.integrator;
    let name = options.solver.as_deref().unwrap_or(&integrator.solver);
    let shape = FilmShape { size: view.film.crop_size, kernel: view.film.filter };
    let stop = options.stop.unwrap_or(Stop::Samples(view.sampler.count));
    enough_memory(shape.size, stop, options.aovs.len())?;

    let threads = options.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| RenderError(format!("cannot start {threads} threads: {e}")))?;
    let mut rules = PathRules::of(integrator);
    if let Some(depth) = options.max_depth {
        rules.max_edges = depth.unwrap_or(u32::MAX);
    }
    if let Some(bounces) = &options.bounces {
        rules = rules.with_bounces(bounces.clone());
    }
    let silent = |_: Event<'_>| ();
    let events: &(dyn Fn(Event<'_>) + Sync) = match &watch.events {
        Some(events) => events,
        None => &silent,
    };
    let run = Run {
        view: 0,
        seed: options.seed.unwrap_or(view.sampler.seed),
        sequence: options.sequence.unwrap_or_default(),
        stop,
        rules,
        digest: loaded.digest ^ digest(&rules),
        pool: &pool,
        cancel: &watch.cancel,
        progress: &watch.progress,
        events,
        checkpoint_every: options.checkpoint_every,
    };

    let film = Film::new(shape);
    let (outcome, channels) = match Quantity::from_name(name).filter(|_| name == "depth") {
        Some(quantity) => (aov(quantity, loaded, &run, &film)?, quantity.channels()),
        None => {
            let solver = AnySolver::new(name, integrator).ok_or_else(|| unknown_solver(name))?;
            solver.needs().check(scene).map_err(|refusal| {
                RenderError(format!(
                    "`{name}` cannot render this scene: {}\n  help: try --solver {}",
                    refusal.reason,
                    refusal.instead.join(" or --solver ")
                ))
            })?;
            let outcome = solver.render(scene, &run, &film, options.resume.as_deref()).map_err(|e| RenderError(e.to_string()))?;
            (outcome, 3)
        }
    };

    let pixels = film.develop();
    let mean = mean(&pixels);
    let (nonfinite, first) = film.dropped();
    let layers = layers(loaded, &run, options, shape)?;
    let stats = Stats {
        software: software(),
        scene: loaded.name.clone(),
        solver: name.to_owned(),
        width: shape.size[0],
        height: shape.size[1],
        spp: outcome.passes,
        seed: run.seed,
        threads,
        load_seconds: loaded.read_time.as_secs_f64(),
        build_seconds: loaded.build_time.as_secs_f64(),
        render_seconds: outcome.elapsed.as_secs_f64(),
        paths: watch.progress.paths.load(std::sync::atomic::Ordering::Relaxed),
        rays: watch.progress.rays.load(std::sync::atomic::Ordering::Relaxed),
        peak_memory_bytes: memory::peak(),
        nonfinite_samples: nonfinite,
        nonfinite_first: first.iter().map(|NonFinite { pixel, sample }| [pixel[0], pixel[1], *sample]).collect(),
        triangles: scene.triangles,
        mean,
        stopped: stopped_word(outcome.stopped).to_owned(),
        noise_percent: outcome.noise.map(|n| <[f64; 3]>::from(n.percent())),
    };
    let black = if mean == [0.0; 3] { scene.diagnose() } else { Vec::new() };
    let picture = picture(&pixels, if channels == 3 { view.film.channels as usize } else { channels }, shape.size, layers, &stats)?;
    Ok(Rendering { picture, stats, outcome, black })
}

/// One quantity of the first surfaces, through the same filter as the picture.
fn aov(quantity: Quantity, loaded: &Loaded, run: &Run<'_>, film: &Film) -> Result<Outcome, RenderError> {
    etendue_solvers::render(&Aov(quantity), "aov", &loaded.scene, run, film, None).map_err(|e| RenderError(e.to_string()))
}

/// Samples per pixel of a layer: enough for smooth edges.
const LAYER_SAMPLES: u32 = 16;

fn layers(loaded: &Loaded, run: &Run<'_>, options: &RenderOptions, shape: FilmShape) -> Result<Vec<Layer>, RenderError> {
    let of_file = loaded.scene.integrator.aovs.iter();
    let of_file = of_file.filter_map(|(name, what)| Some((name.clone(), Quantity::from_name(what)?)));
    let asked = options.aovs.iter().map(|q| (q.name().to_owned(), *q));
    let progress = Progress::default();
    let cancel = CancelToken::default();
    let quiet = Run {
        stop: Stop::Samples(LAYER_SAMPLES),
        progress: &progress,
        cancel: &cancel,
        events: &|_| (),
        checkpoint_every: None,
        ..*run
    };
    of_file
        .chain(asked)
        .map(|(name, quantity)| {
            let film = Film::new(shape);
            aov(quantity, loaded, &quiet, &film)?;
            Ok(Layer { name, image: image(&film.develop(), quantity.channels(), shape.size)? })
        })
        .collect()
}

fn picture(
    pixels: &[[f32; 3]],
    channels: usize,
    size: [u32; 2],
    layers: Vec<Layer>,
    stats: &Stats,
) -> Result<Picture, RenderError> {
    let words = [
        ("software", stats.software.clone()),
        ("scene", stats.scene.clone()),
        ("solver", stats.solver.clone()),
        ("samples-per-pixel", stats.spp.to_string()),
        ("seed", stats.seed.to_string()),
        ("render-seconds", format!("{:.3}", stats.render_seconds)),
    ];
    let attributes = words.into_iter().map(|(name, word)| (name.to_owned(), word)).collect();
    Ok(Picture { image: image(pixels, channels, size)?, layers, attributes })
}

/// Three channels, two, or one: for a single channel of light, luminance; of other quantities, the first number.
fn image(pixels: &[[f32; 3]], channels: usize, size: [u32; 2]) -> Result<Image, RenderError> {
    let (width, height) = (size[0] as usize, size[1] as usize);
    let names: &[&str] = match channels {
        1 => &["Y"],
        2 => &["U", "V"],
        _ => &["R", "G", "B"],
    };
    let data = pixels.iter().flat_map(|p| p.iter().take(names.len()).copied()).collect();
    Image::from_data(width, height, names, data).map_err(|e| RenderError(e.to_string()))
}

fn mean(pixels: &[[f32; 3]]) -> [f64; 3] {
    let n = pixels.len().max(1) as f64;
    std::array::from_fn(|c| pixels.iter().map(|p| f64::from(p[c])).sum::<f64>() / n)
}

fn unknown_solver(name: &str) -> RenderError {
    let names = || SOLVERS.iter().map(|s| s.name);
    if PLANNED.contains(&name) {
        let known = names().collect::<Vec<_>>().join(", ");
        return RenderError(format!("the solver `{name}` is not there yet\n  help: solvers that are: {known}"));
    }
    let mut words = format!("no solver is called `{name}`");
    if let Some(near) = nearest(name, names().chain(PLANNED.iter().copied())) {
        words += &format!("\n  help: did you mean `{near}`?");
    }
    RenderError(words + &format!("\n  help: solvers: {}", names().collect::<Vec<_>>().join(", ")))
}

/// Refuses what cannot fit, before anything is begun.
fn enough_memory(size: [u32; 2], stop: Stop, layers: usize) -> Result<(), RenderError> {
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    // Sums, the developed picture, its tone-mapped copy, and the bytes of a file, with as much again for each layer.
    let pictures = 4 * 12 * pixels;
    let replicates = if matches!(stop, Stop::Noise { .. }) { Replicates::TRACKED * 24 * Replicates::K as u64 } else { 0 };
    let needed = (Film::bytes(size) + pictures).saturating_mul(1 + u64::from(layers > 0)) + pictures * layers as u64 + replicates;
    match memory::available() {
        Some(available) if needed > available => Err(RenderError(format!(
            "a picture of {} x {} pixels takes {}, and {} can be had\n  help: make it smaller with --width and --height",
            size[0],
            size[1],
            memory::human(needed),
            memory::human(available)
        ))),
        _ => Ok(()),
    }
}

fn digest(rules: &PathRules) -> u64 {
    let words = [rules.min_edges, rules.max_edges, rules.rr_depth, u32::from(rules.hide_emitters), u32::from(rules.null_counts)];
    words.iter().fold(0, |h, w| etendue_numerics::sequence::mix(h ^ u64::from(*w)))
}

fn stopped_word(stopped: Stopped) -> &'static str {
    match stopped {
        Stopped::Samples => "samples",
        Stopped::Time => "time",
        Stopped::Noise => "noise",
        Stopped::Limit => "limit",
        Stopped::Cancelled => "cancelled",
    }
}

/// Name and version, as pictures and reports carry them.
pub fn software() -> String {
    concat!("etendue ", env!("CARGO_PKG_VERSION")).to_owned()
}
