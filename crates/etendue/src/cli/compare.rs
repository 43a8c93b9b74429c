//! `etendue compare`: several solvers on one scene, as a page.

use super::experiment::ExperimentArguments;
use super::parse::seconds;
use super::scene::SizeArguments;
use super::{Done, output};
use clap::Args;
use etendue::compare::{Budget, CompareOptions, Reference, Results, compare, page};
use etendue_image::{SaveOptions, save, write_atomically};
use etendue_solvers::agreement::Standard;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Renders a scene with several solvers and writes a page that shows how far each is from a reference.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  etendue compare cornell-box --solvers path,path-nee,path-mis --time 10 -o comparison\n  \
    etendue compare scene.xml --solvers path-mis,bidirectional --spp 256 --reference truth.exr")]
pub struct CompareArguments {
    /// A scene file, or the name of a built-in scene.
    scene: String,
    /// Solvers to compare.
    #[arg(long, value_name = "NAME", value_delimiter = ',', required = true)]
    solvers: Vec<String>,
    /// A solver that renders the reference, in four times the time, or a picture file; the least noisy of the solvers otherwise.
    #[arg(long, value_name = "NAME|FILE")]
    reference: Option<String>,
    /// Seconds for each solver's picture, and as many again for its replicates.
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = seconds)]
    time: Duration,
    /// Samples per pixel for each solver, instead of equal time.
    #[arg(long, value_name = "N", conflicts_with = "time", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Folder to write to.
    #[arg(short, long, value_name = "FOLDER", default_value = "comparison")]
    output: PathBuf,
    #[command(flatten)]
    size: SizeArguments,
    #[command(flatten)]
    common: ExperimentArguments,
}

pub fn run(a: &CompareArguments) -> Done {
    let reference = match &a.reference {
        None => Reference::Best,
        Some(file) if Path::new(file).is_file() => Reference::Picture(PathBuf::from(file)),
        Some(name) => Reference::Solver(name.clone()),
    };
    let options = CompareOptions {
        solvers: a.solvers.clone(),
        reference,
        budget: a.spp.map_or(Budget::Time(a.time), Budget::Samples),
        width: a.size.width,
        height: a.size.height,
        seed: a.common.seed,
        threads: a.common.scene.threads(),
        defines: a.common.scene.define.clone(),
        spectral: a.common.scene.spectral(),
        standard: Standard::default(),
    };
    let Some(results) = a.common.watch("nothing was written", |cancel, tell| compare(&a.scene, &options, cancel, tell))? else {
        return Ok(ExitCode::from(130));
    };
    write(&a.output, &results)?;
    if !a.common.quiet {
        output::message(&format!("wrote {}", a.output.join("index.html").display()));
    }
    Ok(ExitCode::SUCCESS)
}

fn write(folder: &Path, results: &Results) -> Result<(), String> {
    let failed = |path: &Path, e: std::io::Error| format!("cannot write {}: {e}", path.display());
    std::fs::create_dir_all(folder).map_err(|e| failed(folder, e))?;
    let named = results.solvers.iter().map(|s| (s.solver.as_str(), &s.picture));
    for (name, picture) in named.chain([("reference", &results.reference_picture)]) {
        save(&folder.join(format!("{name}.exr")), picture, &SaveOptions::default()).map_err(|e| e.to_string())?;
    }
    let json = serde_json::to_string_pretty(results).map_err(|e| e.to_string())?;
    for (name, text) in [("results.json", json), ("index.html", page(results))] {
        let path = folder.join(name);
        write_atomically(&path, text.as_bytes()).map_err(|e| failed(&path, e))?;
    }
    Ok(())
}
