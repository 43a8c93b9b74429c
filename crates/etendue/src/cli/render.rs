//! `etendue render`.

use super::interrupt::{Words, stop_on_ctrl_c};
use super::parse::{self, Depth};
use super::progress::{Display, NoiseCell, Style};
use super::scene::{SceneArguments, ViewArguments, scene};
use super::tonemap::ToneArguments;
use super::{Done, files, output, summary};
use clap::Args;
use etendue::{
    Listener, RenderOptions, Rendering, Spread, Stop, Stopped, Watch, advise, check, check_per_light, cores, render,
    render_per_light,
};
use etendue_image::{Format, write_atomically};
use etendue_numerics::SequenceKind;
use etendue_solvers::aov::Quantity;
use etendue_solvers::{Checkpoint, Event};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, PoisonError};
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
    #[arg(short, long, value_name = "FILE", value_parser = parse::picture)]
    output: Vec<PathBuf>,
    /// Solver, one of those that `etendue solvers` lists; the scene's own otherwise.
    #[arg(long, value_name = "NAME", value_parser = parse::solver)]
    solver: Option<String>,
    /// Set a parameter of the solver; `etendue solvers` lists them. May be given again.
    #[arg(long, value_name = "NAME=VALUE", value_parser = parse::define)]
    param: Vec<(String, String)>,
    /// Samples per pixel.
    #[arg(long, value_name = "N", group = "stop", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Stop after this many seconds of rendering; every pixel is sampled once in any case.
    #[arg(long, value_name = "SECONDS", group = "stop", value_parser = parse::seconds)]
    time: Option<Duration>,
    /// Stop when the estimated relative error of the picture, √relMSE, is at most this many per cent.
    #[arg(long, value_name = "PERCENT", group = "stop", value_parser = parse::positive)]
    noise: Option<f64>,
    /// How the samples of a noise target are spread over the pixels: adaptive (more where there is noise, if that pays; the default of solvers that can) or
    /// uniform.
    #[arg(long, value_name = "HOW", requires = "noise", value_parser = parse::spread)]
    spread: Option<Spread>,
    /// Seed of all random decisions.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    #[command(flatten)]
    view: ViewArguments,
    /// Edges between eye and light at most: 1 shows emitters only, 2 adds direct light, -1 is unbounded.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = parse::depth)]
    max_depth: Option<Depth>,
    /// Light of exactly so many bounces: A..B with both ends, A.. without an end, or one number; 0 = emitters.
    #[arg(long, value_name = "A..B", value_parser = parse::bounces, conflicts_with = "max_depth")]
    bounces: Option<RangeInclusive<u32>>,
    /// Point set: sobol, stratified, independent.
    #[arg(long, value_name = "NAME", value_parser = parse::sequence)]
    sampler: Option<SequenceKind>,
    #[command(flatten)]
    common: SceneArguments,
    /// Layers in the EXR beside the picture: albedo, normal, geometric-normal, depth, position, uv, samples, …
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = parse::quantity)]
    aov: Vec<Quantity>,
    /// Render each light alone, and the picture as their sum. In .exr each light is a layer of its name, other formats get a file more for each:
    /// NAME.LIGHT.png.
    #[arg(long, conflicts_with_all = ["checkpoint", "resume"])]
    per_light: bool,
    /// Write one JSON object with the numbers of the render.
    #[arg(long, value_name = "FILE")]
    stats: Option<PathBuf>,
    /// Save the state of the render here now and then, and when it ends.
    #[arg(long, value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// Seconds between checkpoints.
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = parse::seconds, requires = "checkpoint")]
    checkpoint_every: Duration,
    /// Go on from a saved state, to the same picture as if nothing had stopped.
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
    #[command(flatten)]
    tone: ToneArguments,
    /// How progress is shown.
    #[arg(long, value_enum, value_name = "STYLE", default_value_t)]
    progress: Style,
    /// Show nothing but errors.
    #[arg(short, long)]
    quiet: bool,
}

pub fn run(a: &RenderArguments) -> Done {
    for path in a.output.iter().chain(&a.stats).chain(&a.checkpoint) {
        files::writable(path)?;
    }
    let resume = a.resume.as_deref().map(read_checkpoint).transpose()?;
    let threads = a.common.threads();
    let mut loaded = scene(&a.scene, &a.common.options(a.view.size), a.quiet)?;
    let pictures = pictures(a, &loaded.name);
    if a.output.is_empty() {
        pictures.iter().try_for_each(|path| files::writable(path))?;
    }
    let view = loaded.scene.views.get(a.view.view).or(loaded.scene.views.first());
    let stop = stop(a).or(view.map(|v| Stop::Samples(v.sampler.count))).unwrap_or(Stop::Samples(1));
    let mut options = RenderOptions {
        view: a.view.view,
        solver: a.solver.clone(),
        because: None,
        parameters: a.param.clone(),
        stop: Some(stop),
        spread: a.spread,
        seed: a.seed,
        threads,
        max_depth: a.max_depth.map(|d| d.0),
        bounces: a.bounces.clone(),
        sequence: a.sampler,
        aovs: a.aov.clone(),
        checkpoint_every: a.checkpoint.as_ref().map(|_| a.checkpoint_every),
        resume,
    };
    if let Some(advice) = advise(&loaded, &options).map_err(|e| e.to_string())? {
        if !a.quiet {
            output::message(&format!("auto: {}, because {}", advice.solver, advice.reason));
        }
        options.solver = Some(advice.solver.to_owned());
        options.because = Some(advice.reason);
    }
    let may_begin = if a.per_light { check_per_light(&loaded, &options) } else { check(&loaded, &options) };
    may_begin.map_err(|e| e.to_string())?;

    if !a.quiet {
        if !a.aov.is_empty() && !pictures.iter().any(|p| Format::of_path(p) == Some(Format::Exr)) {
            output::message("warning: layers are written to .exr only, and no such file is asked for");
        }
        let count = loaded.scene.views.len();
        if count > 1 {
            output::message(&format!("note: the scene has {count} sensors; this renders number {} (--view)", a.view.view));
        }
        let solver = options.solver.as_deref().unwrap_or(&loaded.scene.integrator.solver);
        output::message(&summary::headline(&loaded, a.view.view, solver, stop, threads.unwrap_or_else(cores)));
    }
    let noise = Arc::new(NoiseCell::default());
    let watch = Arc::new(Watch { events: Some(listener(a, &noise)), ..Watch::default() });
    stop_on_ctrl_c(&watch, |watch| &watch.cancel, INTERRUPTED, "not save the picture");
    let style = if a.quiet && a.progress != Style::Json { Style::None } else { a.progress };
    let pixels = view.map_or(0, |v| v.film.crop_size.map(u64::from).iter().product());
    let show = |stop: Stop| Display::start(style, Arc::clone(&watch), stop, pixels, Arc::clone(&noise));
    let rendering = if a.per_light {
        let (count, mut display) = (loaded.scene.emitters.len(), None);
        let stop = if let Stop::Time(time) = stop { Stop::Time(time / count.max(1) as u32) } else { stop };
        render_per_light(&mut loaded, &options, &watch, &mut |i, name| {
            // The one before ends first: there is one line for both.
            drop(display.take());
            if !a.quiet {
                output::message(&format!("light {} of {count}: {name}", i + 1));
            }
            display = Some(show(stop));
        })
    } else {
        let _display = show(stop);
        render(&loaded, &options, &watch)
    };
    finish(a, &pictures, &rendering.map_err(|e| e.to_string())?)
}

/// Writes what there is, and says how it ended: a render that could not go on is a failure, with the picture so far.
fn finish(a: &RenderArguments, pictures: &[PathBuf], rendering: &Rendering) -> Done {
    let written = files::write_pictures(pictures, a.tone, rendering);
    files::write_lights(pictures, a.tone, rendering)?;
    if let Some(path) = &a.stats {
        files::write_stats(path, rendering)?;
    }
    written?;
    if a.progress == Style::Json {
        let line = serde_json::json!({ "event": "done", "files": pictures, "stats": rendering.stats });
        output::result(&line.to_string());
    }
    if !a.quiet {
        summary::tell(rendering, pictures, a.noise);
    }
    if let Some(why) = &rendering.failure {
        return Err(format!("the render ended early: {why}\n  the picture holds what was done before"));
    }
    Ok(if rendering.stopped == Stopped::Cancelled { ExitCode::from(130) } else { ExitCode::SUCCESS })
}

fn pictures(a: &RenderArguments, name: &str) -> Vec<PathBuf> {
    let default = || vec![PathBuf::from(format!("{name}.exr")), PathBuf::from(format!("{name}.png"))];
    if a.output.is_empty() { default() } else { a.output.clone() }
}

/// Passes at most while a noise target is sought.
const NOISE_LIMIT: u32 = 1 << 20;

fn stop(a: &RenderArguments) -> Option<Stop> {
    let samples = a.spp.map(Stop::Samples);
    let time = a.time.map(Stop::Time);
    let noise = a.noise.map(|percent| Stop::Noise { percent, limit: NOISE_LIMIT });
    samples.or(time).or(noise)
}

fn read_checkpoint(path: &Path) -> Result<Box<Checkpoint>, String> {
    let bytes = std::fs::read(path).map_err(|e| format!("cannot read the checkpoint {}: {e}", path.display()))?;
    Checkpoint::from_bytes(&bytes).map(Box::new).map_err(|e| format!("{}: {e}", path.display()))
}

fn listener(a: &RenderArguments, noise: &Arc<NoiseCell>) -> Listener {
    let (checkpoint, noise, json) = (a.checkpoint.clone(), Arc::clone(noise), a.progress == Style::Json);
    let tell = move |value: serde_json::Value| {
        if json {
            output::result(&value.to_string());
        }
    };
    Box::new(move |event| match event {
        Event::Noise(passes, estimate) => {
            let percent = estimate.percent();
            *noise.lock().unwrap_or_else(PoisonError::into_inner) = Some((passes, percent.0));
            tell(
                serde_json::json!({ "event": "noise", "passes": passes, "percent": percent.0, "interval": [percent.1, percent.2] }),
            );
        }
        Event::Checkpoint(state) => {
            let Some(path) = &checkpoint else { return };
            match write_atomically(path, &state.to_bytes()) {
                Ok(()) => tell(serde_json::json!({ "event": "checkpoint", "passes": state.passes, "file": path })),
                // Whoever counts on a checkpoint must know, quiet or not.
                Err(e) => output::message(&format!("warning: cannot write the checkpoint {}: {e}", path.display())),
            }
        }
        Event::Pass(_) => (),
    })
}

/// What Ctrl-C says while a picture is at stake.
const INTERRUPTED: Words = Words {
    asked: Some("stopping; what is done will be written (Ctrl-C again to quit at once)"),
    ended: Some("stopped at once; nothing was written"),
};

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use etendue::{LoadOptions, load};

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        render: RenderArguments,
    }

    /// No right solver fails, so that the failure is put in by hand: the picture and its numbers are written, and the command ends with an error.
    #[test]
    fn a_render_that_could_not_go_on_is_an_error_with_its_picture() {
        let folder = tempfile::tempdir().expect("a folder");
        let [picture, stats] = ["x.exr", "x.json"].map(|name| folder.path().join(name));
        let [to, numbers] = [&picture, &stats].map(|path| path.to_str().expect("UTF-8"));
        let a = Line::parse_from(["render", "furnace", "-q", "-o", to, "--stats", numbers]).render;
        let loaded = load("furnace", &LoadOptions { width: Some(8), height: Some(8), ..LoadOptions::default() }).expect("a scene");
        let options = RenderOptions { stop: Some(Stop::Samples(2)), ..RenderOptions::default() };
        let mut rendering = render(&loaded, &options, &Watch::default()).expect("a picture");
        assert!(finish(&a, &a.output, &rendering).is_ok());
        std::fs::remove_file(&picture).expect("it was written");
        rendering.failure = Some("metropolis cannot go on: a path came out otherwise".to_owned());
        let ended = finish(&a, &a.output, &rendering);
        assert!(ended.is_err_and(|why| why.contains("ended early: metropolis cannot go on") && why.contains("done before")));
        assert!(etendue_image::load_picture(&picture).is_ok_and(|p| p.image.width() == 8) && stats.exists());
    }
}
