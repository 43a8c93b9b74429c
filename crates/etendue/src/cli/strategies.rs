//! `etendue strategies`: what each strategy of bidirectional path tracing finds.

use super::experiment::ExperimentArguments;
use super::scene::ViewArguments;
use super::tonemap::ToneArguments;
use super::{Done, output};
use clap::Args;
use etendue::experiment::ExperimentError;
use etendue::strategies::{Pyramid, StrategyOptions, pyramid};
use etendue_image::{Picture, SaveOptions, save};
use std::path::PathBuf;
use std::process::ExitCode;

/// Renders each strategy (s, t) of bidirectional path tracing on its own: s vertices from a light, t from the eye.
///
/// Writes `weighted.png` and `unweighted.png`, pyramids with a row for each number of edges and s from left to right, and `strategies.exr`, which holds each as a layer
/// (s1t2-weighted, s1t2-unweighted, …) beside their weighted sum.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: etendue strategies caustic --width 160 --spp 64 --vertices 5 -o pyramid    what walks from each end find of a caustic"
)]
pub struct StrategiesArguments {
    /// A scene file, or the name of a built-in scene.
    scene: String,
    /// Samples per pixel.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// Vertices of a path at most, those on the light and on the lens included.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(2..=12))]
    vertices: u32,
    /// Folder to write to.
    #[arg(short, long, value_name = "FOLDER", default_value = "strategies")]
    output: PathBuf,
    #[command(flatten)]
    view: ViewArguments,
    #[command(flatten)]
    tone: ToneArguments,
    #[command(flatten)]
    common: ExperimentArguments,
}

pub fn run(a: &StrategiesArguments) -> Done {
    let options = StrategyOptions {
        load: a.common.scene.options(a.view.size),
        view: a.view.view,
        spp: a.spp,
        vertices: a.vertices,
        seed: a.common.seed,
    };
    let rendered = a.common.watch("nothing was written", |cancel, tell| {
        let all = pyramid(&a.scene, &options, cancel, tell)?;
        files(&all, a.tone)
    })?;
    let Some(files) = rendered else { return Ok(ExitCode::from(130)) };
    std::fs::create_dir_all(&a.output).map_err(|e| format!("cannot make the folder {}: {e}", a.output.display()))?;
    for (name, picture) in &files {
        save(&a.output.join(name), picture, &SaveOptions::default()).map_err(|e| e.to_string())?;
    }
    if !a.common.quiet {
        output::message(&format!("wrote {}", files.map(|(name, _)| a.output.join(name).display().to_string()).join(", ")));
    }
    Ok(ExitCode::SUCCESS)
}

fn files(all: &Pyramid, tone: ToneArguments) -> Result<[(&'static str, Picture); 3], ExperimentError> {
    let shown = |weighted| all.shown(weighted, tone.map());
    Ok([("strategies.exr", all.layers()?), ("weighted.png", shown(true)?), ("unweighted.png", shown(false)?)])
}
