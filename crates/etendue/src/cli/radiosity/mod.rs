//! `etendue radiosity`.

mod solution;
mod tell;

pub use solution::{SolutionArguments, solved};

use super::scene::{SceneArguments, ViewArguments, scene};
use super::tonemap::ToneArguments;
use super::{Done, files, output, parse};
use clap::Args;
use etendue::LoadOptions;
use etendue::radiosity::bounces::bounce_pictures;
use etendue::radiosity::{View, export, look};
use etendue_image::{Format, Picture, SaveOptions, save, write_atomically};
use etendue_solvers::radiosity::Show;
use etendue_solvers::{CancelToken, PathRules};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

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
