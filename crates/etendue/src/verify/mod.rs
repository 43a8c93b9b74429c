//! Do the solvers agree? Renders a scene with every solver that can, compares all pairs, and holds each to the furnace's closed form.
//!
//! Solvers join by being in the list ([`etendue_solvers::SOLVERS`]): what a scene must have and what a solver estimates, it says itself. All
//! comparisons (pairs, areas, channels, and those of the furnace) are one family with 1 % of false alarms; see
//! [`etendue_solvers::agreement`] for the statistics and the verdicts.

mod accept;
mod contest;
mod furnace;
mod report;
mod round;
mod schedule;

pub use accept::{Acceptance, Accepted, accept};
pub use contest::Entrant;
pub use report::{Bounces, Comparison, Effort, Verification};
pub use schedule::Unjudged;

use crate::choice::check_solver_name;
use crate::experiment::{ExperimentError, Header};
use crate::pool;
use contest::{Chosen, chosen, load_small};
use etendue_solvers::CancelToken;
use etendue_solvers::agreement::{Standard, Trial, Verdict};
use furnace::{Oven, load_furnace, ovens};
use round::{Round, rounds};
use schedule::Questions;
use std::path::PathBuf;
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
    /// Whether walks carry wavelengths; as the file's format has it otherwise.
    pub spectral: Option<bool>,
    /// How strictly is judged.
    pub standard: Standard,
    /// Folder where [`accept`] keeps its replicates and goes on from them.
    pub keep: Option<PathBuf>,
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
            spectral: None,
            standard: Standard::default(),
            keep: None,
        }
    }
}

type Stopped<T> = Result<T, ExperimentError>;

/// Shares of the time: the first replicates of the pairs, and those of the furnace; after the last one nothing more is begun.
const FIRST: f64 = 0.25;
const FURNACE: f64 = 0.12;
const LATEST: f64 = 0.9;

/// Verifies a scene with the solvers of the list. `tell` hears what is going on.
pub fn verify(scene: &str, options: &VerifyOptions, cancel: &CancelToken, tell: &dyn Fn(&str)) -> Stopped<Verification> {
    verify_with(Vec::new(), scene, options, cancel, tell)
}

/// Verifies solvers of your own beside those of the list.
pub fn verify_with(
    guests: Vec<Entrant<'_>>,
    scene: &str,
    options: &VerifyOptions,
    cancel: &CancelToken,
    tell: &dyn Fn(&str),
) -> Stopped<Verification> {
    let begun = Instant::now();
    for name in options.solvers.iter().flatten() {
        check_solver_name(name)?;
    }
    let (loaded, furnace) = (load_small(scene, options)?, load_furnace(options)?);
    let pool = pool::pool(options.threads)?;
    let trial = Trial { seed: options.seed, blocks: options.blocks, ..Trial::new(&loaded.scene, &pool, cancel) };
    let in_furnace = Trial { seed: options.seed ^ 0xf0, ..Trial::new(&furnace.scene, &pool, cancel) };
    let named: Vec<String> = guests.iter().map(|g| g.name.clone()).chain(options.solvers.iter().flatten().cloned()).collect();
    let Chosen { entrants, beside, mut left_out } = chosen(options, guests, &loaded)?;

    // First replicates of everything; what is left of the time goes where it decides most.
    let rounds = rounds(trial, &entrants, options, options.time.mul_f64(FIRST), tell)?;
    tell("holding the solvers to the furnace");
    let all: Vec<&Entrant<'_>> = entrants.iter().chain(&beside).collect();
    let (ovens, slow) = ovens(in_furnace, &all, options, options.time.mul_f64(FURNACE))?;
    for (_, why) in left_out.iter_mut().filter(|(name, _)| slow.contains(name)) {
        *why += ", which takes too long here (--time)";
    }
    let tests = rounds.iter().map(|r| r.panel.tests()).sum::<usize>() + ovens.iter().map(Oven::tests).sum::<usize>();
    let mut all = Questions { rounds, ovens, standard: options.standard, tests, named };
    all.judge();
    if options.spp.is_none() {
        tell("comparing");
        all.pursue(|| options.time.mul_f64(LATEST).saturating_sub(begun.elapsed()))?;
    }

    // A difference must be there twice.
    for round in &mut all.rounds {
        round.confirm(&options.standard, tell)?;
    }
    let failed = all.ovens.iter().filter(|o| o.found.verdict == Verdict::Fail).count();
    if failed > 0 {
        tell("a difference in the furnace: rendering anew, to see whether it is there again");
    }
    for oven in &mut all.ovens {
        oven.confirm(&options.standard, failed)?;
    }

    let unjudged = all.too_noisy();
    // With fewer than two solvers judged nothing is shown, and everything stays open.
    let excused = if all.rounds.iter().all(|r| r.judged(&unjudged) > 1) { unjudged.as_slice() } else { &[] };
    let pairs: Vec<Comparison> = all.rounds.iter().flat_map(|r| r.comparisons(excused)).collect();
    let furnace: Vec<Comparison> = all.ovens.iter().map(|o| o.comparison(excused)).collect();
    let counted = pairs.iter().chain(&furnace).filter(|c| c.counts).map(|c| c.verdict);
    let verdict = counted.fold(if pairs.is_empty() { Verdict::Inconclusive } else { Verdict::Pass }, Verdict::max);
    Ok(Verification {
        header: Header::new(&loaded, &trial, options.standard),
        tests,
        solvers: all.rounds.iter().flat_map(Round::efforts).collect(),
        verdict,
        unjudged,
        left_out,
        pairs,
        furnace,
        seconds: begun.elapsed().as_secs_f64(),
    })
}
