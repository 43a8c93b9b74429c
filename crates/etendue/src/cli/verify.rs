//! `etendue verify`: do the solvers agree?

use super::experiment::ExperimentArguments;
use super::parse::{positive, seconds};
use super::{Done, acceptance, output};
use clap::Args;
use etendue::verify::{Bounces, Comparison, Verification, VerifyOptions, accept, verify};
use etendue_solvers::agreement::{Standard, Verdict};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Tests whether all solvers find the same light: every pair on a scene, and each in the furnace, whose answer is known.
///
/// The last line says PASS, FAIL or INCONCLUSIVE; the exit status is 0 for PASS alone.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  etendue verify                                       all solvers on the Cornell box, in under a minute\n  \
    etendue verify scene.xml --solvers path-mis,bidirectional --time 300 --json verdict.json\n  \
    etendue verify veach-mis --accept --time 600 --keep veach    each block of an 8 x 8 grid, at fixed standard errors; again to go on"
)]
pub struct VerifyArguments {
    /// A scene file, or the name of a built-in scene.
    #[arg(default_value = etendue::builtin::SCENES[0].name)]
    scene: String,
    /// Solvers to compare; all that can render the scene otherwise.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    solvers: Option<Vec<String>>,
    /// Seconds for everything.
    #[arg(long, value_name = "SECONDS", default_value = "45", value_parser = seconds)]
    time: Duration,
    /// Samples per pixel of each of 16 replicates, instead of what the time allows: the same numbers on every machine.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Longer side of the picture in pixels.
    #[arg(long, value_name = "PIXELS", default_value_t = 64, value_parser = clap::value_parser!(u32).range(4..=4096))]
    size: u32,
    /// Blocks across and down whose means are compared, 4 unless told (8 with --accept): more find smaller places, and take longer to be sure.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    blocks: Option<u32>,
    /// Instead of a verdict in a fixed time: every solver against path-mis, or whoever is known soonest, with as many samples as it takes to know each
    /// block to 1 % (light-nee and metropolis 3 %, path and light 5 %), and at most --time for each.
    #[arg(long, conflicts_with_all = ["spp", "bound", "block_bound"])]
    accept: bool,
    /// Keep the replicates of --accept in this folder, and go on from those that are there: the time is then for each run, and adds up.
    #[arg(long, value_name = "FOLDER", requires = "accept")]
    keep: Option<PathBuf>,
    /// Probability, in per cent, of a false alarm in the whole family of comparisons.
    #[arg(long, value_name = "PERCENT", default_value_t = 1.0, value_parser = positive)]
    alpha: f64,
    /// Bias of the whole picture, in per cent, that must not go unseen.
    #[arg(long, value_name = "PERCENT", default_value_t = 2.0, value_parser = positive)]
    bound: f64,
    /// Bias of one block, in per cent of it, that must not go unseen.
    #[arg(long, value_name = "PERCENT", default_value_t = 20.0, value_parser = positive)]
    block_bound: f64,
    /// Write all figures as one JSON object.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    common: ExperimentArguments,
}

pub fn run(a: &VerifyArguments) -> Done {
    let options = VerifyOptions {
        solvers: a.solvers.clone(),
        time: a.time,
        spp: a.spp,
        size: a.size,
        blocks: a.blocks.unwrap_or(if a.accept { 8 } else { 4 }),
        seed: a.common.seed,
        threads: a.common.scene.threads(),
        defines: a.common.scene.define.clone(),
        spectral: a.common.scene.spectral(),
        standard: Standard { alpha: 0.01 * a.alpha, bound: 0.01 * a.bound, block_bound: 0.01 * a.block_bound },
        keep: a.keep.clone(),
    };
    if a.accept {
        return run_accept(a, &options);
    }
    let Some(found) = a.common.watch("there is no verdict", |cancel, tell| verify(&a.scene, &options, cancel, tell))? else {
        return Ok(ExitCode::from(130));
    };
    write_json(a, &found)?;
    output::result(&report(&found));
    Ok(status(found.verdict))
}

fn run_accept(a: &VerifyArguments, options: &VerifyOptions) -> Done {
    let stopped = if a.keep.is_some() { "what was rendered is kept" } else { "nothing is accepted" };
    let Some(found) = a.common.watch(stopped, |cancel, tell| accept(&a.scene, options, cancel, tell))? else {
        return Ok(ExitCode::from(130));
    };
    write_json(a, &found)?;
    output::result(&acceptance::report(&found));
    Ok(status(found.verdict))
}

fn status(verdict: Verdict) -> ExitCode {
    if verdict == Verdict::Pass { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn write_json(a: &VerifyArguments, found: &impl Serialize) -> Result<(), String> {
    let Some(path) = &a.json else { return Ok(()) };
    let json = serde_json::to_string_pretty(found).map_err(|e| e.to_string())?;
    etendue_image::write_atomically(path, json.as_bytes()).map_err(|e| format!("cannot write {}: {e}", path.display()))
}

pub(super) fn percent(x: f64) -> String {
    let p = 100.0 * x;
    match p.abs() {
        a if !a.is_finite() => "any".to_owned(),
        a if a >= 100.0 => format!("{p:.0} %"),
        a if a >= 10.0 => format!("{p:.1} %"),
        a if a >= 0.1 => format!("{p:.2} %"),
        a if a > 0.0 => format!("{p:.4} %"),
        _ => "0 %".to_owned(),
    }
}

fn report(v: &Verification) -> String {
    let h = &v.header;
    let mut lines = vec![format!(
        "{} at {} x {} pixels in {} x {} blocks, seed {}, {} threads, {:.1} s",
        h.scene, h.size[0], h.size[1], h.blocks[0], h.blocks[1], h.seed, h.threads, v.seconds
    )];
    lines.push(String::new());
    lines.push(format!("{:<34}{:>12}{:>12}{:>10}{:>14}{:>14}", "solver", "spp", "replicates", "time", "± picture", "± block"));
    for e in &v.solvers {
        let name = named(&e.solver, e.bounces);
        let time = format!("{:.1} s", e.seconds);
        let (picture, block) = (percent(e.picture_error), percent(e.block_error));
        lines.push(format!("{name:<34}{:>12}{:>12}{time:>10}{picture:>14}{block:>14}", e.spp, e.replicates));
        if e.dropped > 0 {
            lines.push(format!("{:<34}{} samples were not finite and were dropped", "", e.dropped));
        }
    }
    lines.extend(v.left_out.iter().map(|(name, why)| format!("{name:<34}left out: {why}")));
    lines.extend(v.unjudged.iter().map(|u| {
        let (name, seconds) = (&u.solver, u.seconds);
        let seen = u.visible.map_or(String::new(), |x| format!("; a bias of {} of the picture would have been seen", percent(x)));
        format!(
            "{name:<34}not judged: too noisy here; to compare it {} would take about {seconds:.0} s more (--time){seen}",
            u.comparison
        )
    }));
    lines.push(String::new());
    let longest = v.pairs.iter().chain(&v.furnace).map(|c| named(&c.what, c.bounces).chars().count()).max().unwrap_or(0) + 2;
    lines.push(header("pair", longest));
    lines.extend(v.pairs.iter().map(|c| row(c, longest)));
    if v.pairs.is_empty() {
        lines.push("no two solvers can be compared".to_owned());
    }
    lines.push(String::new());
    lines.push(header("furnace", longest));
    lines.extend(v.furnace.iter().map(|c| row(c, longest)));
    lines.push(String::new());
    lines.push(last_line(v));
    lines.join("\n")
}

fn header(first: &str, width: usize) -> String {
    format!(
        "{first:<width$}{:<14}{:>8}  {:<21}{:>22}{:>12}{:>12}",
        "verdict", "|t|", "largest at", "difference ± interval", "sees", "in a block"
    )
}

fn named(what: &str, bounces: Bounces) -> String {
    format!("{what}, {bounces}")
}

fn row(c: &Comparison, width: usize) -> String {
    let w = &c.worst;
    let place = if w.t == 0.0 { "–".to_owned() } else { format!("{} {}", w.area, ["red", "green", "blue"][w.channel.min(2)]) };
    let difference = format!("{} ± {}", percent(w.difference), percent(w.half_width));
    let note = match (c.seen_once, c.counts) {
        (true, _) => "  (a difference was seen once, and not again)",
        (_, false) => "  (not judged)",
        _ => "",
    };
    format!(
        "{:<width$}{:<14}{:>8.2}  {place:<21}{difference:>22}{:>12}{:>12}{note}",
        named(&c.what, c.bounces),
        c.verdict,
        w.t.abs(),
        percent(c.visible_picture),
        percent(c.visible_block)
    )
}

fn last_line(v: &Verification) -> String {
    let all = || v.pairs.iter().chain(&v.furnace).filter(|c| c.counts);
    let of =
        |verdict: Verdict| all().filter(|c| c.verdict == verdict).map(|c| named(&c.what, c.bounces)).collect::<Vec<_>>().join("; ");
    let most = |f: &dyn Fn(&Comparison) -> f64| percent(all().map(f).fold(0.0, f64::max));
    let (picture, block) = (most(&|c| c.visible_picture), most(&|c| c.visible_block));
    let seen = format!("a bias of {picture} of the picture, or of {block} of one block, would have been seen everywhere (95 %)");
    let judged = judged(v).join(", ");
    let but = match v.unjudged.iter().map(|u| u.solver.as_str()).collect::<Vec<_>>() {
        none if none.is_empty() => String::new(),
        names => format!("; of {} nothing is said", names.join(", ")),
    };
    match v.verdict {
        Verdict::Pass => {
            format!("PASS: {judged} show no difference in {} comparisons; {seen}{but}", all().map(|c| c.tests).sum::<usize>())
        }
        Verdict::Fail => format!("FAIL: a difference that chance does not explain: {}", of(Verdict::Fail)),
        Verdict::Inconclusive if v.pairs.is_empty() => "INCONCLUSIVE: nothing to compare with".to_owned(),
        Verdict::Inconclusive => format!(
            "INCONCLUSIVE: no difference, but a bias above the bound ({} of the picture, {} of a block) could hide in {}; more --time shows more",
            percent(v.header.standard.bound),
            percent(v.header.standard.block_bound),
            of(Verdict::Inconclusive)
        ),
    }
}

/// Those whose comparisons all count.
fn judged(v: &Verification) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for e in &v.solvers {
        if !names.contains(&e.solver.as_str()) && !v.unjudged.iter().any(|u| u.solver == e.solver) {
            names.push(&e.solver);
        }
    }
    names
}
