//! What was found, as data.

use super::schedule::Unjudged;
use crate::experiment::Header;
use etendue_solvers::PathRules;
use etendue_solvers::agreement::{Agreement, Candidate, Finding, Moments, Verdict};
use serde::Serialize;
use std::fmt;

/// Numbers of bounces: 0 shows emitters, 1 direct light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Bounces {
    /// At least.
    pub least: u32,
    /// At most; none is unbounded.
    pub most: Option<u32>,
}

impl Bounces {
    /// `rules`, for light of these numbers of bounces that they let count.
    pub(super) fn of(self, rules: PathRules) -> PathRules {
        let most = self.most.unwrap_or(u32::MAX).min(rules.max_edges.saturating_sub(1));
        rules.with_bounces(self.least..=most)
    }
}

impl fmt::Display for Bounces {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.least, self.most) {
            (0, None) => f.write_str("all light"),
            (n, None) => write!(f, "{n} bounces or more"),
            (1, Some(1)) => f.write_str("1 bounce"),
            (a, Some(b)) if a == b => write!(f, "{a} bounces"),
            (a, Some(b)) => write!(f, "{a}..{b} bounces"),
        }
    }
}

/// One solver's part.
#[derive(Clone, Debug, Serialize)]
pub struct Effort {
    /// Its name.
    pub solver: String,
    /// Of which light.
    pub bounces: Bounces,
    /// Samples per pixel of one replicate.
    pub spp: u32,
    /// Replicates.
    pub replicates: usize,
    /// Time that they took, s.
    pub seconds: f64,
    /// Standard error of the picture's mean, relative; the worst channel.
    pub picture_error: f64,
    /// Standard error of a block's mean, relative to it (or to half the picture's, in darker blocks); the median over blocks and channels.
    pub block_error: f64,
    /// Samples that were not finite.
    pub dropped: u64,
}

/// Two solvers, compared; or one with a closed form.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// The solvers, or the solver.
    pub what: String,
    /// Of which light.
    pub bounces: Bounces,
    /// The verdict.
    pub verdict: Verdict,
    /// A difference was seen once, and not again in fresh replicates.
    pub seen_once: bool,
    /// It counts for the verdict on everything: both solvers were judged.
    pub counts: bool,
    /// Comparisons of areas and channels.
    pub tests: usize,
    /// The comparison that chance explains least.
    pub worst: Finding,
    /// Where a bias could hide best.
    pub blindest: Finding,
    /// Of the whole picture, the smallest bias that would have been seen, relative.
    pub visible_picture: f64,
    /// Of a block, likewise.
    pub visible_block: f64,
}

/// All that was found.
#[derive(Clone, Debug, Serialize)]
pub struct Verification {
    /// Scene, size, seed and the like.
    #[serde(flatten)]
    pub header: Header,
    /// Comparisons in the family.
    pub tests: usize,
    /// The solvers' parts.
    pub solvers: Vec<Effort>,
    /// Solvers that are too noisy here to be judged in the time.
    pub unjudged: Vec<Unjudged>,
    /// Solvers that were left out, and why.
    pub left_out: Vec<(String, String)>,
    /// Pairs of solvers.
    pub pairs: Vec<Comparison>,
    /// Solvers in the furnace.
    pub furnace: Vec<Comparison>,
    /// The verdict on everything.
    pub verdict: Verdict,
    /// Time for everything, s.
    pub seconds: f64,
}

impl Effort {
    pub(super) fn of(c: &Candidate<'_>, bounces: Bounces) -> Self {
        let areas = c.sample.areas();
        let relative = |m: &Moments, least: f64| m.standard_error() / m.mean.abs().max(least).max(1e-30);
        let picture_error = areas[0].iter().map(|m| relative(m, 0.0)).fold(0.0, f64::max);
        let mut blocks: Vec<f64> =
            areas[1..].iter().flat_map(|a| (0..3).map(|i| relative(&a[i], 0.5 * areas[0][i].mean.abs()))).collect();
        blocks.sort_by(f64::total_cmp);
        Self {
            solver: c.name.clone(),
            bounces,
            spp: c.spp,
            replicates: c.sample.count(),
            seconds: c.elapsed.as_secs_f64(),
            picture_error,
            block_error: blocks.get(blocks.len() / 2).copied().unwrap_or(picture_error),
            dropped: c.dropped,
        }
    }
}

impl Comparison {
    pub(super) fn of(what: String, bounces: Bounces, verdict: Verdict, seen_once: bool, counts: bool, found: &Agreement) -> Self {
        Self {
            what,
            bounces,
            verdict,
            seen_once,
            counts,
            tests: found.findings.len(),
            worst: found.worst,
            blindest: found.blindest,
            visible_picture: found.visible_picture,
            visible_block: found.visible_block,
        }
    }
}
