//! Do the solvers agree? Renders a scene with every solver that can, compares all pairs, and holds each to the furnace's closed form.
//!
//! Solvers join by being in the list ([`etendue_solvers::SOLVERS`]): what a scene must have and what a solver estimates, it says itself. All
//! comparisons (pairs, areas, channels, and those of the furnace) are one family with 1 % of false alarms; see
//! [`etendue_solvers::agreement`] for the statistics and the verdicts.

mod contest;
mod furnace;
mod report;
mod schedule;

pub use report::{Comparison, Effort, Verification};

use crate::choice::check_solver_name;
use crate::experiment::{ExperimentError, Header};
use crate::pool;
use contest::{chosen, load_small};
use etendue_solvers::agreement::{Agreement, Pair, Panel, Standard, Trial, Verdict};
use etendue_solvers::{AnySolver, CancelToken, Estimates, PathRules};
use furnace::{DEPTHS, Oven, load_furnace};
use schedule::{FIRST, FURNACE, LATEST, MORE, Next, best, enter, nearest_verdict};
use std::time::{Duration, Instant};

/// How to verify.
#[derive(Clone, Debug)]
pub struct VerifyOptions {
    /// Solvers by name; all otherwise.
    pub solvers: Option<Vec<String>>,
    /// Time for everything.
    pub time: Duration,
    /// Samples per pixel of one replicate, instead of what the time allows; then every solver renders 16 of them.
    pub spp: Option<u32>,
    /// Longer side of the picture, pixels.
    pub size: u32,
    /// Blocks across and down.
    pub blocks: u32,
    /// Seed.
    pub seed: u64,
    /// Threads; all cores otherwise.
    pub threads: Option<usize>,
    /// Values for the file's `<default>` parameters.
    pub defines: Vec<(String, String)>,
    /// How strictly is judged.
    pub standard: Standard,
}

impl Default for VerifyOptions {
    fn default() -> Self {
        Self {
            solvers: None,
            time: Duration::from_secs(45),
            spp: None,
            size: 64,
            blocks: 4,
            seed: 0,
            threads: None,
            defines: Vec::new(),
            standard: Standard::default(),
        }
    }
}

type Stopped<T> = Result<T, ExperimentError>;

/// Verifies a scene. `tell` hears what is going on.
pub fn verify(scene: &str, options: &VerifyOptions, cancel: &CancelToken, tell: &dyn Fn(&str)) -> Stopped<Verification> {
    let begun = Instant::now();
    for name in options.solvers.iter().flatten() {
        check_solver_name(name)?;
    }
    let loaded = load_small(scene, options)?;
    let oven = load_furnace(options)?;
    let pool = pool::pool(options.threads)?;
    let trial = Trial { seed: options.seed, blocks: options.blocks, ..Trial::new(&loaded.scene, &pool, cancel) };
    let ovens = Trial { seed: options.seed ^ 0xf0, ..Trial::new(&oven.scene, &pool, cancel) };
    let (solvers, mut left_out) = chosen(options, &loaded.scene);

    // Those that estimate all light meet each other; those that estimate a part meet the best of these, on that part.
    let all = |s: &&AnySolver| s.estimates() == Estimates::Light;
    let parts: Vec<(&AnySolver, u32)> =
        solvers.iter().filter_map(|s| if let Estimates::LightUpTo(n) = s.estimates() { Some((s, n)) } else { None }).collect();
    let mut main = Panel::new(trial);
    let share = options.time.mul_f64(FIRST / (solvers.iter().filter(all).count() + 2 * parts.len()).max(1) as f64);
    for solver in solvers.iter().filter(all) {
        tell(&format!("rendering with {}", solver.name()));
        enter(&mut main, solver, options, share).ok_or(ExperimentError::Cancelled)?;
    }
    let mut sides = Vec::new();
    for (solver, edges) in parts {
        let Some(partner) = best(&main).and_then(|name| solvers.iter().find(|s| s.name() == name)) else {
            left_out.push((solver.name().to_owned(), "no other solver is there to compare it with".to_owned()));
            continue;
        };
        tell(&format!("rendering with {}", solver.name()));
        let rules = PathRules { max_edges: trial.rules.max_edges.min(edges), null_counts: true, ..trial.rules };
        let mut side = Panel::new(Trial { rules, seed: trial.seed ^ 0xd1, ..trial });
        for s in [solver, partner] {
            enter(&mut side, s, options, share).ok_or(ExperimentError::Cancelled)?;
        }
        sides.push((side, Some(edges - 1)));
    }

    // The family: everything that is compared.
    let furnace_depths = |s: &AnySolver| {
        let in_part = matches!(s.estimates(), Estimates::LightUpTo(_));
        DEPTHS.into_iter().filter(move |d| d.is_some() || !in_part)
    };
    let ovens_tests = solvers.iter().map(|s| furnace_depths(s).count()).sum::<usize>() * 3 * ovens.grid().len();
    let tests = main.tests() + sides.iter().map(|s| s.0.tests()).sum::<usize>() + ovens_tests;

    tell("holding the solvers to the furnace");
    let mut in_furnace = Vec::new();
    let share = options.time.mul_f64(FURNACE * 3.0 * ovens.grid().len() as f64 / ovens_tests.max(1) as f64);
    for solver in &solvers {
        for depth in furnace_depths(solver) {
            in_furnace.push(Oven::new(ovens, solver, depth, options, share).ok_or(ExperimentError::Cancelled)?);
        }
    }

    // What is left of the time goes where it decides most: to what is nearest to being told.
    tell("comparing");
    let mut panels: Vec<(Panel<'_>, Option<u32>)> = std::iter::once((main, None)).chain(sides).collect();
    let mut found: Vec<Vec<Pair>> = panels.iter().map(|(p, _)| p.pairs(&options.standard, tests)).collect();
    let mut held: Vec<Agreement> = in_furnace.iter().map(|o| o.judge(&options.standard, tests)).collect();
    while options.spp.is_none() {
        let room = options.time.mul_f64(LATEST).saturating_sub(begun.elapsed());
        let Some(next) = nearest_verdict(&panels, &found, &in_furnace, &held, room) else { break };
        match next {
            Next::Candidate(i, candidate) => {
                panels[i].0.measure(candidate, MORE).ok_or(ExperimentError::Cancelled)?;
                found[i] = panels[i].0.pairs(&options.standard, tests);
            }
            Next::Oven(i) => {
                in_furnace[i].measure(MORE).ok_or(ExperimentError::Cancelled)?;
                held[i] = in_furnace[i].judge(&options.standard, tests);
            }
        }
    }

    // A difference must be there twice.
    let (mut pairs, mut efforts, mut furnace) = (Vec::new(), Vec::new(), Vec::new());
    for ((panel, bounces), mut found) in panels.into_iter().zip(found) {
        if found.iter().any(|p| p.verdict == Verdict::Fail) {
            tell("a difference: rendering anew, to see whether it is there again");
            panel.confirm(&mut found, &options.standard).ok_or(ExperimentError::Cancelled)?;
        }
        for pair in found {
            let what = format!("{} / {}", panel.candidates[pair.a].name, panel.candidates[pair.b].name);
            pairs.push(Comparison::of(what, bounces, pair.verdict, pair.seen_once, &pair.agreement));
        }
        efforts.extend(panel.candidates.iter().map(|c| Effort::of(c, bounces)));
    }
    let failed = held.iter().filter(|h| h.verdict == Verdict::Fail).count();
    for (oven, held) in in_furnace.iter().zip(&held) {
        let seen_once = held.verdict == Verdict::Fail && {
            tell("a difference: rendering anew, to see whether it is there again");
            let again = oven.again(&options.standard, failed).ok_or(ExperimentError::Cancelled)?;
            again.verdict != Verdict::Fail
        };
        let verdict = if seen_once { Verdict::Inconclusive } else { held.verdict };
        furnace.push(Comparison::of(oven.name.clone(), oven.depth, verdict, seen_once, held));
    }

    let verdicts = pairs.iter().chain(&furnace).map(|c| c.verdict);
    let verdict = if pairs.is_empty() { Verdict::Inconclusive } else { Verdict::Pass };
    Ok(Verification {
        header: Header::new(&loaded, &trial, options.standard),
        tests,
        solvers: efforts,
        left_out,
        verdict: verdicts.fold(verdict, Verdict::max),
        pairs,
        furnace,
        seconds: begun.elapsed().as_secs_f64(),
    })
}
