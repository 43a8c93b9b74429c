//! `etendue bench`: how fast this machine casts rays and renders.

use super::scene::{SceneArguments, ViewArguments, scene};
use super::{Done, interrupt, output};
use clap::Args;
use etendue::bench::{Options, Rate, Report, bench};
use etendue::{Watch, memory};
use std::process::ExitCode;
use std::sync::Arc;

/// Measures how fast this machine casts the rays of a scene, and renders its picture. Run it on an idle machine.
#[derive(Debug, Args)]
#[command(after_help = "Example: etendue bench scene.xml --rounds 9 --json")]
pub struct BenchArguments {
    /// A scene file, or the name of a built-in scene.
    #[arg(default_value = "cornell-box")]
    scene: String,
    #[command(flatten)]
    view: ViewArguments,
    #[command(flatten)]
    common: SceneArguments,
    /// The solver whose picture is timed; the scene's own otherwise.
    #[arg(long, value_name = "NAME")]
    solver: Option<String>,
    /// Samples per pixel of that picture.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    spp: u32,
    /// Rounds, each of which measures everything once.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    rounds: u32,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &BenchArguments) -> Done {
    let loaded = scene(&arguments.scene, &arguments.common.options(arguments.view.size), arguments.json)?;
    let options = Options {
        view: arguments.view.view,
        solver: arguments.solver.clone(),
        spp: arguments.spp,
        threads: arguments.common.threads(),
        rounds: arguments.rounds,
    };
    let watch = Arc::new(Watch::default());
    let words = interrupt::Words { asked: Some("stopping after this round"), ended: None };
    interrupt::stop_on_ctrl_c(&watch, |watch| &watch.cancel, words, "end the program at once");
    let report = bench(&loaded, &options, &watch).map_err(|e| e.to_string())?;
    output::result(&if arguments.json {
        serde_json::to_string_pretty(&report).map_err(|e| e.to_string())?
    } else {
        table(&report)
    });
    Ok(if watch.cancel.is_cancelled() { ExitCode::from(130) } else { ExitCode::SUCCESS })
}

fn table(r: &Report) -> String {
    let tree = memory::human(r.tree_bytes as u64);
    let mut lines = vec![
        format!("{}: {} triangles, {} rounds", r.scene, r.triangles, r.rounds),
        format!("loading   {:.3} s reading, {:.3} s building; {tree} for casting rays", r.load_seconds, r.build_seconds),
        String::new(),
        format!(
            "{:<12}{:>24}{:>24}{:>24}{:>8}",
            "M rays/s",
            "one by one, 1 thread",
            "batches, 1 thread",
            format!("batches, {} threads", r.threads),
            "hit"
        ),
    ];
    lines.extend(r.rays.iter().map(|k| {
        let [single, batch, threads] = [k.single, k.batch, k.threads].map(|rate| words(rate, 1e6));
        format!("{:<12}{single:>24}{batch:>24}{threads:>24}{:>6.0} %", k.kind, 100.0 * k.hits)
    }));
    lines.push(String::new());
    let [single, threads] = [r.paths_single, r.paths_threads].map(|rate| words(rate, 1e6));
    lines.push(format!(
        "{} at {} x {}, {} samples, M paths/s: {single} on 1 thread, {threads} on {}",
        r.solver, r.width, r.height, r.spp, r.threads
    ));
    lines.push(format!("memory    {} at most", memory::human(r.peak_memory_bytes)));
    lines.join("\n")
}

/// `12.3 (11.9 to 12.5)`.
fn words(rate: Rate, unit: f64) -> String {
    format!("{:.2} ({:.2} to {:.2})", rate.median / unit, rate.min / unit, rate.max / unit)
}
