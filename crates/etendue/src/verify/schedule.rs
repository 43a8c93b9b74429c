//! Where the time goes.

use super::VerifyOptions;
use super::furnace::Oven;
use super::report::Effort;
use crate::experiment::renderer;
use etendue_solvers::AnySolver;
use etendue_solvers::agreement::{Agreement, Candidate, Pair, Panel, REPLICATES, Verdict};
use std::time::Duration;

/// Shares of the time: first measurements of the pairs and of the furnace; after the last one nothing more is begun.
pub(super) const FIRST: f64 = 0.25;
pub(super) const FURNACE: f64 = 0.12;
pub(super) const LATEST: f64 = 0.9;
/// Replicates that are added at once where more are wanted.
pub(super) const MORE: u32 = 4;

pub(super) fn enter<'a>(panel: &mut Panel<'a>, solver: &'a AnySolver, options: &VerifyOptions, share: Duration) -> Option<()> {
    let render = renderer(solver, panel.trial.scene);
    let spp = match options.spp {
        Some(spp) => spp,
        None => panel.trial.samples_in(&*render, share, REPLICATES)?,
    };
    panel.enter(solver.name(), render, spp);
    panel.measure(panel.candidates.len() - 1, REPLICATES)
}

/// The candidate whose picture's mean is known best.
pub(super) fn best<'p>(panel: &'p Panel<'_>) -> Option<&'p str> {
    let error = |c: &&Candidate<'_>| Effort::of(c, None).picture_error;
    panel.candidates.iter().min_by(|a, b| error(a).total_cmp(&error(b))).map(|c| c.name.as_str())
}

/// Where more replicates are wanted.
pub(super) enum Next {
    /// Of this candidate of this panel.
    Candidate(usize, usize),
    /// In this oven.
    Oven(usize),
}

/// The comparison that needs the least time to be told, if intervals shrink with its root. None where all is told, or where the time that is
/// left holds no more replicates.
pub(super) fn nearest_verdict(
    panels: &[(Panel<'_>, Option<u32>)],
    found: &[Vec<Pair>],
    ovens: &[Oven<'_>],
    held: &[Agreement],
    room: Duration,
) -> Option<Next> {
    let mut best: Option<(f64, Next)> = None;
    let mut propose = |agreement: &Agreement, elapsed: Duration, count: usize, next: Next| {
        let cost = (agreement.reach().powi(2) - 1.0).max(0.01) * elapsed.as_secs_f64();
        let fits = elapsed.mul_f64(f64::from(MORE) / count.max(1) as f64) <= room;
        if fits && best.as_ref().is_none_or(|b| cost < b.0) {
            best = Some((cost, next));
        }
    };
    let open = |a: &Agreement| a.verdict == Verdict::Inconclusive;
    for (i, ((panel, _), pairs)) in panels.iter().zip(found).enumerate() {
        for pair in pairs.iter().filter(|p| open(&p.agreement)) {
            let area = panel.trial.grid().areas().position(|a| a == pair.agreement.blindest.area).unwrap_or(0);
            let error = |c: usize| panel.candidates[c].sample.areas()[area][pair.agreement.blindest.channel].standard_error();
            let noisier = if error(pair.a) > error(pair.b) { pair.a } else { pair.b };
            let c = &panel.candidates[noisier];
            propose(&pair.agreement, c.elapsed, c.sample.count(), Next::Candidate(i, noisier));
        }
    }
    for (i, (oven, held)) in ovens.iter().zip(held).enumerate().filter(|(_, (_, h))| open(h)) {
        propose(held, oven.elapsed, oven.sample.count(), Next::Oven(i));
    }
    best.map(|b| b.1)
}
