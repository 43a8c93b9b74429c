//! `etendue radiosity`.

use super::interrupt::{Words, stop_on_ctrl_c};
use super::scene::{SceneArguments, ViewArguments, scene};
use super::tonemap::ToneArguments;
use super::{Done, files, output, parse};
use clap::{Args, ValueEnum};
use etendue::radiosity::bounces::bounce_pictures;
use etendue::radiosity::{Report, View, export, look, solve};
use etendue::{LoadOptions, Loaded};
use etendue_image::{Format, Picture, SaveOptions, save, write_atomically};
use etendue_radiosity::Solved;
use etendue_radiosity::patch::PatchSize;
use etendue_radiosity::solved::{Factors, Method, Settings, Stage};
use etendue_solvers::radiosity::Show;
use etendue_solvers::{CancelToken, PathRules};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Solves diffuse light between patches.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  etendue radiosity cornell-box -o box.png -o box.glb -o patches.csv\n  \
    etendue radiosity room.xml --patch-size 0.1 --bounce-images --bounces 4 -o room.png\n\n\
    Files: .exr .hdr .pfm .png .jpg pictures; .glb glTF, .ply, .vtu for ParaView; .csv a row a patch. Lux at K = 683.002 lm/W.\n\
    Ctrl-C while sweeping keeps the last whole sweep and shows it.")]
pub struct RadiosityArguments {
    /// A scene file, or the name of a built-in scene.
    #[arg(default_value = etendue::builtin::SCENES[0].name)]
    scene: String,
    /// File to write; its ending tells what. May be given again; NAME.exr and NAME.png without it.
    #[arg(short, long, value_name = "FILE", value_parser = file)]
    output: Vec<PathBuf>,
    #[command(flatten)]
    solution: SolutionArguments,
    /// Light of so many bounces at most; all of it otherwise. With --bounce-images, the last of the pictures.
    #[arg(long, value_name = "N")]
    bounces: Option<u32>,
    /// Show the patches as they are.
    #[arg(long, conflicts_with = "final_gather")]
    raw: bool,
    /// Indirect light at every point by one more ray each display ray, instead of interpolated.
    #[arg(long)]
    final_gather: bool,
    /// Also write light of exactly 0, 1, 2, … bounces, its running sum, and a contact sheet, named after the first picture.
    #[arg(long)]
    bounce_images: bool,
    /// Colours of a .glb as a lightmap on the second UV set, not at its vertices; beside it NAME-lightmap.exr, radiance in W/(m² sr).
    #[arg(long)]
    lightmap: bool,
    /// K, lm/W, that turns watts into lumens.
    #[arg(long, value_name = "K", default_value_t = export::LUMINOUS_EFFICACY, value_parser = parse::positive)]
    luminous_efficacy: f64,
    /// Display rays a pixel; the scene's own otherwise.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    #[command(flatten)]
    view: ViewArguments,
    #[command(flatten)]
    common: SceneArguments,
    /// Write one JSON object with the numbers of the solution.
    #[arg(long, value_name = "FILE")]
    stats: Option<PathBuf>,
    #[command(flatten)]
    tone: ToneArguments,
    /// Show nothing but errors.
    #[arg(short, long)]
    quiet: bool,
}

/// How the equation is made and solved.
#[derive(Debug, Args)]
pub struct SolutionArguments {
    /// Size of patches in metres.
    #[arg(long, value_name = "METRES", value_parser = parse::positive)]
    patch_size: Option<f64>,
    /// About so many patches, smaller where the light changes.
    #[arg(long, value_name = "N", conflicts_with = "patch_size", default_value_t = 12_000, value_parser = clap::value_parser!(u32).range(1..=4_000_000))]
    patches: u32,
    /// Patches of one size, also where the light changes.
    #[arg(long)]
    even: bool,
    /// How form factors are found.
    #[arg(long, value_enum, default_value_t = FactorsName::Hemisphere)]
    method: FactorsName,
    /// Form-factor rays a patch.
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(16..=1 << 24))]
    samples: u32,
    /// Of `hierarchical`: bound on the error of B, in parts of all reflected light, down to which links are refined.
    #[arg(long, value_name = "E", default_value_t = Settings::default().error, value_parser = parse::positive)]
    error: f64,
    /// How the equation is solved.
    #[arg(long, value_enum, default_value_t = SolveName::Neumann)]
    solve: SolveName,
    /// Relative residual at which it is.
    #[arg(long, value_name = "R", default_value_t = 1e-4, value_parser = parse::positive)]
    residual: f64,
    /// Seed of all rays.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
}

/// The ways to find form factors.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum FactorsName {
    /// Cosine-distributed rays from each patch.
    Hemisphere,
    /// Closed forms between polygons, less what rays find blocked; for some thousands of patches.
    Analytic,
    /// Quadrature of the double integral; for some thousands of patches.
    Area,
    /// Links between clusters of patches, as coarse as --error allows; for up to millions of patches.
    Hierarchical,
}

/// The ways to solve.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum SolveName {
    /// Bounce by bounce.
    Neumann,
    /// Gathering from what is newest.
    GaussSeidel,
    /// The patch with most unshot light shoots first.
    Shooting,
    /// A dense factorisation, for small scenes.
    Direct,
}

impl SolutionArguments {
    /// As the library takes it.
    pub fn settings(&self) -> Settings {
        let method = match self.solve {
            SolveName::Neumann => Method::Neumann,
            SolveName::GaussSeidel => Method::GaussSeidel,
            SolveName::Shooting => Method::Shooting,
            SolveName::Direct => Method::Direct,
        };
        let factors = match self.method {
            FactorsName::Hemisphere => Factors::Hemisphere,
            FactorsName::Analytic => Factors::Analytic,
            FactorsName::Area => Factors::Area,
            FactorsName::Hierarchical => Factors::Hierarchical,
        };
        let size = self.patch_size.map_or(PatchSize::Count(self.patches as usize), PatchSize::Metres);
        Settings {
            size,
            adaptive: !self.even,
            factors,
            rays: self.samples,
            error: self.error,
            method,
            residual: self.residual,
            seed: self.seed,
            ..Settings::default()
        }
    }
}

fn file(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let ending = ending(&path);
    if export::ENDINGS.contains(&ending.as_str()) || parse::picture(text).is_ok() {
        return Ok(path);
    }
    Err(format!("a file of `radiosity` ends in .exr, .hdr, .pfm, .png, .jpg, .{}", export::ENDINGS.join(", .")))
}

fn ending(path: &Path) -> String {
    path.extension().map_or(String::new(), |e| e.to_string_lossy().to_lowercase())
}

/// How far a solution is: a bar on a terminal, a line now and then otherwise.
struct Stages {
    bar: ProgressBar,
    /// When the last line was written; none where no lines are.
    last: Option<Mutex<Instant>>,
}

impl Stages {
    fn new(quiet: bool) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(1) };
        let style = ProgressStyle::with_template("{msg} {bar:30} {pos} of {len}, {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.set_message("form factors");
        let last = (!quiet && !std::io::stderr().is_terminal()).then(|| Mutex::new(Instant::now()));
        Self { bar, last }
    }

    fn tell(&self, stage: Stage) {
        /// Between lines.
        const PAUSE: Duration = Duration::from_secs(2);
        let words = match stage {
            Stage::Rows(done, of) => {
                self.bar.set_length(of as u64);
                self.bar.set_position(done as u64);
                format!("form factors: {done} of {of} rows")
            }
            Stage::Sweep(k, residual) => {
                let words = format!("sweep {k}, residual {residual:.1e}");
                self.bar.set_message(words.clone());
                words
            }
            Stage::Links(rays, bound) => {
                let words = format!("links of {rays} rays a patch, error below {:.1} %", 100.0 * bound);
                self.bar.set_message(words.clone());
                words
            }
            Stage::Patches(_) | Stage::Repaired => return,
        };
        let Some(last) = &self.last else { return };
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.elapsed() >= PAUSE {
            *last = Instant::now();
            output::message(&words);
        }
    }
}

/// Solves with a bar; the first Ctrl-C ends the sweeps.
pub fn solved(
    loaded: &Loaded,
    a: &SolutionArguments,
    threads: Option<usize>,
    quiet: bool,
) -> Result<(Solved, Report, Arc<CancelToken>), String> {
    let cancel = Arc::new(CancelToken::default());
    let words = Words {
        asked: Some("stopping after this sweep (Ctrl-C again to quit at once)"),
        ended: Some("stopped at once; nothing was written"),
    };
    stop_on_ctrl_c(&cancel, |c| c, words, "not keep the last sweep");
    let shown = Stages::new(quiet);
    let told = |stage: Stage| {
        shown.tell(stage);
        !cancel.is_cancelled()
    };
    let found = solve(loaded, &a.settings(), threads, &told);
    shown.bar.finish_and_clear();
    let (solved, report) = found.map_err(|e| e.to_string())?;
    if !quiet {
        tell(&report);
    }
    Ok((solved, report, cancel))
}

pub fn run(a: &RadiosityArguments) -> Done {
    a.output.iter().chain(&a.stats).try_for_each(|path| files::writable(path))?;
    a.common.no_wavelengths()?;
    let threads = a.common.threads();
    let loaded = scene(&a.scene, &LoadOptions { spectral: Some(false), ..a.common.options(a.view.size) }, a.quiet)?;
    let default = || vec![PathBuf::from(format!("{}.exr", loaded.name)), PathBuf::from(format!("{}.png", loaded.name))];
    let outputs = if a.output.is_empty() { default() } else { a.output.clone() };
    let (tables, pictures): (Vec<_>, Vec<_>) = outputs.iter().partition(|p| export::ENDINGS.contains(&ending(p).as_str()));
    let view = loaded.scene.views.get(a.view.view);
    if view.is_none() && (!pictures.is_empty() || a.bounce_images) {
        return Err(format!("there is no view {}: the scene has {} sensors", a.view.view, loaded.scene.views.len()));
    }

    let (solved, report, stopped) = solved(&loaded, &a.solution, threads, a.quiet)?;
    let was_stopped = stopped.is_cancelled();
    let wrote = |path: &Path| {
        if !a.quiet {
            output::message(&format!("wrote {}", path.display()));
        }
    };
    for path in tables {
        let bytes = export::write(&loaded, &solved, &ending(path), a.luminous_efficacy, a.lightmap)?;
        write_atomically(path, &bytes).map_err(|e| format!("cannot write {}: {e}", path.display()))?;
        wrote(path);
        if a.lightmap && ending(path) == "glb" {
            let stem = path.file_stem().map_or(loaded.name.clone(), |s| s.to_string_lossy().into_owned());
            let beside = path.with_file_name(format!("{stem}-lightmap.exr"));
            let picture = export::lightmap(&loaded, &solved)?.into();
            save(&beside, &picture, &SaveOptions::default()).map_err(|e| e.to_string())?;
            wrote(&beside);
        }
    }
    if let Some(path) = &a.stats {
        let json = serde_json::to_string_pretty(&report).map_err(|e| e.to_string())? + "\n";
        write_atomically(path, json.as_bytes()).map_err(|e| format!("cannot write {}: {e}", path.display()))?;
    }

    // What was stopped is shown all the same, with a ray a pixel.
    let cancel = if was_stopped { &CancelToken::default() } else { &*stopped };
    let spp = if was_stopped { 1 } else { a.spp.or(view.map(|v| v.sampler.count)).unwrap_or(1) };
    let show = match (a.raw, a.final_gather) {
        (true, _) => Show::Patches,
        (_, true) => Show::Gather,
        _ => Show::Smooth,
    };
    let all = PathRules::of(&loaded.scene.integrator);
    let most = |n: u32| PathRules { max_edges: n.saturating_add(1), ..all };
    let rules = a.bounces.map_or(PathRules { max_edges: u32::MAX, ..all }, most);
    let how = View { view: a.view.view, show, spp, seed: a.solution.seed, rules };
    if !pictures.is_empty() {
        let picture = look(&loaded, &solved, &how, threads, cancel).map_err(|e| e.to_string())?;
        for path in &pictures {
            store(path, &picture, a.tone)?;
            wrote(path);
        }
    }
    if a.bounce_images {
        /// Bounces that are shown unless told otherwise.
        const BOUNCES: u32 = 5;
        let first = pictures.first().map_or(PathBuf::from(format!("{}.png", loaded.name)), |p| (*p).clone());
        let (images, sheet) = bounce_pictures(&loaded, &solved, &how, a.bounces.unwrap_or(BOUNCES), a.tone.map(), threads, cancel)
            .map_err(|e| e.to_string())?;
        let named = |name: &str, ending: &str| {
            let stem = first.file_stem().map_or(loaded.name.clone(), |s| s.to_string_lossy().into_owned());
            first.with_file_name(format!("{stem}-{name}.{ending}"))
        };
        for image in &images {
            let path = named(&image.name, &ending(&first));
            store(&path, &image.picture, a.tone)?;
            wrote(&path);
        }
        let path = named("bounces", "png");
        save(&path, &sheet.into(), &SaveOptions::default()).map_err(|e| e.to_string())?;
        wrote(&path);
    }
    Ok(if was_stopped { ExitCode::from(130) } else { ExitCode::SUCCESS })
}

fn store(path: &Path, picture: &Picture, tone: ToneArguments) -> Result<(), String> {
    if Format::of_path(path).is_some_and(Format::is_linear) {
        return save(path, picture, &SaveOptions::default()).map_err(|e| e.to_string());
    }
    let shown = Picture { image: tone.map().image(&picture.image), layers: Vec::new(), attributes: picture.attributes.clone() };
    save(path, &shown, &SaveOptions::default()).map_err(|e| e.to_string())
}

/// The numbers that everyone should see.
fn tell(r: &Report) {
    if r.patches == 0 {
        output::message("note: the scene has no surface that can be cut into patches");
        return;
    }
    let sum = |x: [f64; 3]| x.iter().sum::<f64>();
    let noise = if r.moved_by_noise > 0.0 {
        format!(", where the noise of the rays alone is expected to move {:.2} %", 100.0 * r.moved_by_noise)
    } else {
        String::new()
    };
    output::message(&match r.error_bound {
        Some(bound) => format!(
            "{} patches, {} links by `{}` of {} rays a patch in {} MiB; rows closed to {:.1e}, pairs to 0; error of B below {:.1} % of all reflected light{}",
            r.patches,
            r.factors,
            r.method,
            r.rays_per_patch,
            r.factor_bytes >> 20,
            r.closure_after,
            100.0 * bound,
            if r.error_reached { "" } else { ", not as low as asked: more rays no longer lowered it, or would not fit" },
        ),
        None => format!(
            "{} patches, {} factors above zero by `{}` in {} MiB; before repair rows closed to {:.1e} and pairs to {:.1e}, now to {:.1e} and 0; that moved {:.2} % of the light{noise}",
            r.patches,
            r.factors,
            r.method,
            r.factor_bytes >> 20,
            r.closure_before,
            r.reciprocity_before,
            r.closure_after,
            100.0 * r.moved_by_repair
        ),
    });
    let (sweeps, last) = (r.residuals.len() - 1, r.residuals.last().copied().unwrap_or(0.0));
    let end = if r.converged { "" } else { ": stopped before the residual asked for" };
    output::message(&format!("{}: residual {last:.1e} after {sweeps} sweeps, {:.1} s{end}", r.solve, r.seconds));
    output::message(&format!(
        "light in W over channels: emitted {:.6} + from elsewhere {:.6} = absorbed {:.6} + escaped {:.6} + residual {:.1e}",
        sum(r.emitted),
        sum(r.arrived),
        sum(r.absorbed),
        sum(r.escaped),
        sum(r.residual)
    ));
    let three = |x: [f32; 3]| x.map(|x| format!("{x:.3}")).join(", ");
    for n in &r.not_diffuse {
        let lost = if n.transmitted == [0.0; 3] {
            String::new()
        } else {
            format!("; {} that passes through is lost", three(n.transmitted))
        };
        output::message(&format!(
            "note: `{}`, {}: {} stands as a diffuse surface of reflectance {}{lost}",
            n.surface,
            n.side,
            n.material,
            three(n.reflectance)
        ));
    }
    etendue::surfaces::words(&r.defects).iter().for_each(|words| output::message(words));
}
