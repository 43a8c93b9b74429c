//! `etendue render`.

use super::progress::{Display, NoiseCell, clock};
use super::tonemap::ToneArguments;
use super::{Done, define, output};
use clap::Args;
use etendue::{LoadOptions, RenderOptions, Rendering, Stop, Stopped, Watch, load, memory, render};
use etendue_image::{Format, Picture, SaveOptions, save, write_atomically};
use etendue_numerics::SequenceKind;
use etendue_solvers::aov::Quantity;
use etendue_solvers::{Checkpoint, Event};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

/// Renders a scene to pictures.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  etendue render                          the Cornell box, to cornell-box.exr and cornell-box.png\n  \
    etendue render scene.xml --time 60 -o picture.exr -o picture.png\n  \
    etendue render ajar --noise 2 --checkpoint ajar.ckpt"
)]
pub struct RenderArguments {
    /// A scene file, or the name of a built-in scene.
    #[arg(default_value = etendue::builtin::SCENES[0].name)]
    scene: String,
    /// Picture to write; the ending chooses the format (exr, hdr, pfm: linear light; png, jpg: for a display). May be given again.
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// Solver: path, path-nee, path-mis, direct; the scene's own otherwise.
    #[arg(long, value_name = "NAME")]
    solver: Option<String>,
    /// Samples per pixel.
    #[arg(long, value_name = "N", group = "stop", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Stop after this many seconds of rendering.
    #[arg(long, value_name = "SECONDS", group = "stop", value_parser = seconds)]
    time: Option<Duration>,
    /// Stop when the estimated relative error of the picture is at most this many per cent.
    #[arg(long, value_name = "PERCENT", group = "stop", value_parser = positive)]
    noise: Option<f64>,
    /// Seed of all random decisions.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Threads; all cores otherwise. The picture is the same for any number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Width of the picture in pixels.
    #[arg(long, value_name = "W", value_parser = clap::value_parser!(u32).range(1..))]
    width: Option<u32>,
    /// Height of the picture in pixels.
    #[arg(long, value_name = "H", value_parser = clap::value_parser!(u32).range(1..))]
    height: Option<u32>,
    /// Edges between eye and light at most: 1 shows emitters only, 2 adds direct light, -1 is unbounded.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = depth)]
    max_depth: Option<Depth>,
    /// Light of exactly so many bounces: A..B, or one number; 0 = emitters.
    #[arg(long, value_name = "A..B", value_parser = bounces, conflicts_with = "max_depth")]
    bounces: Option<RangeInclusive<u32>>,
    /// Render with spectra instead of RGB.
    #[arg(long)]
    spectral: bool,
    /// Point set: sobol, stratified, independent.
    #[arg(long, value_name = "NAME", value_parser = sequence)]
    sampler: Option<SequenceKind>,
    /// Set a `<default>` parameter of the scene file.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = define)]
    define: Vec<(String, String)>,
    /// Layers in the EXR beside the picture: albedo, normal, geometric-normal, depth, position, uv.
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = quantity)]
    aov: Vec<Quantity>,
    /// Write one JSON object with the numbers of the render.
    #[arg(long, value_name = "FILE")]
    stats: Option<PathBuf>,
    /// Save the state of the render here now and then, and when it ends.
    #[arg(long, value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// Seconds between checkpoints.
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = seconds, requires = "checkpoint")]
    checkpoint_every: Duration,
    /// Go on from a saved state.
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
    #[command(flatten)]
    tone: ToneArguments,
    /// Show nothing but errors.
    #[arg(short, long)]
    quiet: bool,
}

/// `--max-depth`: `None` is unbounded.
#[derive(Clone, Copy, Debug)]
struct Depth(Option<u32>);

fn depth(text: &str) -> Result<Depth, String> {
    match text.parse::<i64>() {
        Ok(-1) => Ok(Depth(None)),
        Ok(n) if (0..=i64::from(u32::MAX)).contains(&n) => Ok(Depth(Some(n as u32))),
        _ => Err(format!("`{text}` is no number of edges; expected -1 (unbounded) or 0, 1, 2, …")),
    }
}

fn bounces(text: &str) -> Result<RangeInclusive<u32>, String> {
    let number = |t: &str| t.trim_start_matches('=').parse::<u32>().map_err(|_| format!("`{t}` is no number of bounces"));
    let (a, b) = text.split_once("..").unwrap_or((text, text));
    let range = number(a)?..=number(b)?;
    if range.is_empty() { Err(format!("{text} holds no number")) } else { Ok(range) }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err(format!("`{text}` is not a number above 0")),
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    Duration::try_from_secs_f64(positive(text)?).map_err(|_| format!("`{text}` s is too long"))
}

fn sequence(text: &str) -> Result<SequenceKind, String> {
    match text {
        "sobol" => Ok(SequenceKind::Sobol),
        "stratified" => Ok(SequenceKind::Stratified),
        "independent" => Ok(SequenceKind::Independent),
        _ => Err("expected sobol, stratified or independent".to_owned()),
    }
}

fn quantity(text: &str) -> Result<Quantity, String> {
    let names = || Quantity::ALL.map(|(_, name, ..)| name).join(", ");
    Quantity::from_name(text).ok_or_else(|| format!("expected one of {}", names()))
}

pub fn run(a: &RenderArguments) -> Done {
    if a.spectral {
        return Err("rendering with spectra is not there yet; leave --spectral out to render in RGB".to_owned());
    }
    for path in &a.output {
        writable(path)?;
    }
    let options = LoadOptions { defines: a.define.clone(), size: None, width: a.width, height: a.height };
    let loaded = load(&a.scene, &options).map_err(|e| output::load_error(&e))?;
    if !a.quiet {
        output::diagnostics(&loaded.diagnostics, &loaded.description);
    }
    let stop = stop(a).unwrap_or(Stop::Samples(loaded.scene.views[0].sampler.count));
    let options = RenderOptions {
        solver: a.solver.clone(),
        stop: Some(stop),
        seed: a.seed,
        threads: a.threads.map(usize::from),
        max_depth: a.max_depth.map(|d| d.0),
        bounces: a.bounces.clone(),
        sequence: a.sampler,
        aovs: a.aov.clone(),
        checkpoint_every: a.checkpoint.as_ref().map(|_| a.checkpoint_every),
        resume: a.resume.as_deref().map(read_checkpoint).transpose()?,
    };

    let noise = Arc::new(NoiseCell::default());
    let watch = Arc::new(Watch { events: Some(listener(a, &noise)), ..Watch::default() });
    stop_on_ctrl_c(&watch);
    let display = (!a.quiet).then(|| Display::start(Arc::clone(&watch), stop, noise));
    let rendering = render(&loaded, &options, &watch);
    drop(display);
    let rendering = rendering.map_err(|e| e.to_string())?;

    let files = write(a, &loaded.name, &rendering)?;
    if !a.quiet {
        summary(a, &rendering, &files);
    }
    Ok(if rendering.outcome.stopped == Stopped::Cancelled { ExitCode::from(130) } else { ExitCode::SUCCESS })
}

/// Passes at most while a noise target is sought.
const NOISE_LIMIT: u32 = 1 << 20;

fn stop(a: &RenderArguments) -> Option<Stop> {
    let samples = a.spp.map(Stop::Samples);
    let time = a.time.map(Stop::Time);
    let noise = a.noise.map(|percent| Stop::Noise { percent, limit: NOISE_LIMIT });
    samples.or(time).or(noise)
}

/// Refuses, before anything is rendered, a file that could not be written after it.
fn writable(path: &Path) -> Result<(), String> {
    if !Format::of_path(path).is_some_and(Format::can_write) {
        return Err(format!("{}: a picture's name ends in .exr, .hdr, .pfm, .png or .jpg", path.display()));
    }
    match path.parent().filter(|p| !p.as_os_str().is_empty()) {
        Some(folder) if !folder.is_dir() => Err(format!("{}: the folder {} does not exist", path.display(), folder.display())),
        _ => Ok(()),
    }
}

fn read_checkpoint(path: &Path) -> Result<Box<Checkpoint>, String> {
    let bytes = std::fs::read(path).map_err(|e| format!("cannot read {}: {e}", path.display()))?;
    Checkpoint::from_bytes(&bytes).map(Box::new).map_err(|e| format!("{}: {e}", path.display()))
}

fn listener(a: &RenderArguments, noise: &Arc<NoiseCell>) -> Box<dyn Fn(Event<'_>) + Send + Sync> {
    let (checkpoint, noise, quiet) = (a.checkpoint.clone(), Arc::clone(noise), a.quiet);
    Box::new(move |event| match event {
        Event::Noise(_, estimate) => noise.set(estimate.percent().0),
        Event::Checkpoint(state) => {
            if let Some(path) = &checkpoint
                && let Err(e) = write_atomically(path, &state.to_bytes())
                && !quiet
            {
                output::message(&format!("warning: cannot write the checkpoint {}: {e}", path.display()));
            }
        }
        Event::Pass(_) => (),
    })
}

/// The first Ctrl-C stops the render and keeps what is done; the second ends the program.
fn stop_on_ctrl_c(watch: &Arc<Watch>) {
    let watch = Arc::clone(watch);
    let handler = move || {
        if watch.cancel.is_cancelled() {
            output::message("stopped at once; nothing was written");
            #[expect(clippy::exit, reason = "the user has asked twice")]
            std::process::exit(130);
        }
        watch.cancel.cancel();
        output::message("stopping; what is done will be written (Ctrl-C again to quit at once)");
    };
    if let Err(e) = ctrlc::set_handler(handler) {
        output::message(&format!("warning: Ctrl-C will not save the picture: {e}"));
    }
}

/// Writes pictures and numbers; the answer names the pictures.
fn write(a: &RenderArguments, name: &str, rendering: &Rendering) -> Result<Vec<PathBuf>, String> {
    let default = || vec![PathBuf::from(format!("{name}.exr")), PathBuf::from(format!("{name}.png"))];
    let files = if a.output.is_empty() { default() } else { a.output.clone() };
    for path in &files {
        let linear = Format::of_path(path).is_some_and(Format::is_linear);
        let shown = || {
            let image = a.tone.map().image(&rendering.picture.image);
            Picture { image, layers: Vec::new(), attributes: rendering.picture.attributes.clone() }
        };
        let result = if linear {
            save(path, &rendering.picture, &SaveOptions::default())
        } else {
            save(path, &shown(), &SaveOptions::default())
        };
        result.map_err(|e| e.to_string())?;
    }
    if let Some(path) = &a.stats {
        let json = serde_json::to_string_pretty(&rendering.stats).map_err(|e| e.to_string())?;
        write_atomically(path, json.as_bytes()).map_err(|e| format!("cannot write {}: {e}", path.display()))?;
    }
    Ok(files)
}

fn summary(a: &RenderArguments, rendering: &Rendering, files: &[PathBuf]) {
    let s = &rendering.stats;
    let names: Vec<_> = files.iter().map(|f| f.display().to_string()).collect();
    output::message(&format!("wrote {}", names.join(" and ")));
    let per_second = |n: u64| n as f64 / s.render_seconds.max(1e-9) / 1e6;
    output::message(&format!(
        "{} x {} pixels, {} spp by {} in {}: {:.2} M paths/s, {:.2} M rays/s, peak memory {}",
        s.width,
        s.height,
        s.spp,
        s.solver,
        clock(s.render_seconds),
        per_second(s.paths),
        per_second(s.rays),
        memory::human(s.peak_memory_bytes)
    ));
    if let Some([value, low, high]) = s.noise_percent {
        let verdict = if rendering.outcome.stopped == Stopped::Noise { "reached" } else { "not reached" };
        let target = a.noise.unwrap_or_default();
        output::message(&format!(
            "noise target {target} % {verdict}: √relMSE is {value:.3} % (95 % interval {low:.3} to {high:.3} %)"
        ));
    }
    if rendering.outcome.stopped == Stopped::Cancelled {
        output::message("stopped before the end, as asked");
    }
    if s.nonfinite_samples > 0 {
        let which: Vec<_> = s.nonfinite_first.iter().map(|[x, y, n]| format!("sample {n} of pixel ({x}, {y})")).collect();
        output::message(&format!(
            "warning: {} samples were not finite and were dropped: {}",
            s.nonfinite_samples,
            which.join(", ")
        ));
    }
    if !rendering.black.is_empty() {
        output::message("warning: the picture is black");
        for reason in &rendering.black {
            output::message(&format!("  help: {reason}"));
        }
    }
}
