//! A part of the light, and the solvers that estimate it: every pair is compared.
//!
//! Emitters as the eye sees them and light that was scattered are compared apart. A small bright lamp in view makes the mean of its block
//! noisy, and a fault in the rest could hide there; apart, the lamp costs one ray a sample.

use super::contest::Entrant;
use super::report::{Bounces, Comparison, Effort};
use super::schedule::Unjudged;
use super::{Stopped, VerifyOptions};
use etendue_solvers::agreement::{Pair, Panel, REPLICATES, Standard, Trial, Verdict};
use etendue_solvers::{Estimates, PathRules};
use std::time::Duration;

/// How many times wider the bounds of emitters are: small lamps are hit by chance, and what may be wrong with them is not subtle.
const EMITTERS_LEEWAY: f64 = 2.5;

/// One part of the light.
pub(super) struct Round<'a> {
    pub(super) bounces: Bounces,
    pub(super) panel: Panel<'a>,
    pub(super) pairs: Vec<Pair>,
}

impl<'a> Round<'a> {
    fn new(trial: Trial<'a>, bounces: Bounces) -> Self {
        let rules = trial.rules;
        // A part of the light is told by its edges, those through null surfaces included.
        let null_counts = rules.null_counts || bounces.most.is_some_and(|n| n > 0);
        let rules = bounces.of(PathRules { null_counts, ..rules });
        let seed = trial.seed ^ (u64::from(bounces.least) << 40) ^ (u64::from(bounces.most.unwrap_or(63)) << 48);
        Self { bounces, panel: Panel::new(Trial { rules, seed, ..trial }), pairs: Vec::new() }
    }

    /// One more solver, with its first replicates, in about the time of its `share`.
    fn enter(&mut self, entrant: &'a Entrant<'_>, options: &VerifyOptions, share: Duration) -> Stopped<()> {
        let render = entrant.renderer(self.panel.trial.scene);
        let spp = match options.spp {
            Some(spp) => spp,
            None => self.panel.trial.samples_in(&*render, share, REPLICATES)?,
        };
        self.panel.enter(&entrant.name, render, spp);
        let place = self.panel.candidates.len() - 1;
        self.panel.candidates[place].leeway = if self.bounces.most == Some(0) { EMITTERS_LEEWAY } else { entrant.leeway() };
        self.measure(place, REPLICATES)
    }

    pub(super) fn measure(&mut self, candidate: usize, count: u32) -> Stopped<()> {
        Ok(self.panel.measure(candidate, count)?)
    }

    pub(super) fn judge(&mut self, standard: &Standard, tests: usize) {
        self.pairs = self.panel.pairs(standard, tests);
    }

    /// A difference must be there twice.
    pub(super) fn confirm(&mut self, standard: &Standard, tell: &dyn Fn(&str)) -> Stopped<()> {
        if self.pairs.iter().any(|p| p.verdict == Verdict::Fail) {
            tell("a difference: rendering anew, to see whether it is there again");
            self.panel.confirm(&mut self.pairs, standard)?;
        }
        Ok(())
    }

    /// Candidates that are judged; two at least of a part that one solver alone estimates.
    pub(super) fn judged(&self, unjudged: &[Unjudged]) -> usize {
        let judged = |name: &str| !unjudged.iter().any(|u| u.solver == name);
        let count = self.panel.candidates.iter().filter(|c| judged(&c.name)).count();
        if self.bounces.most.is_some_and(|n| n > 0) { count.max(2) } else { count }
    }

    pub(super) fn comparisons(&self, unjudged: &[Unjudged]) -> Vec<Comparison> {
        let name = |i: usize| self.panel.candidates[i].name.as_str();
        let row = |p: &Pair| {
            let noisy = unjudged.iter().any(|u| [name(p.a), name(p.b)].contains(&u.solver.as_str()));
            let counts = !noisy || p.seen_once || p.verdict != Verdict::Inconclusive;
            let what = format!("{} / {}", name(p.a), name(p.b));
            Comparison::of(what, self.bounces, p.verdict, p.seen_once, counts, &p.agreement)
        };
        self.pairs.iter().map(row).collect()
    }

    /// The smallest bias of the whole picture that would have been seen of a solver; none where it is in no pair.
    pub(super) fn visible(&self, solver: &str) -> Option<f64> {
        let has = |i: usize| self.panel.candidates[i].name == solver;
        self.pairs.iter().filter(|p| has(p.a) || has(p.b)).map(|p| p.agreement.visible_picture).reduce(f64::min)
    }

    pub(super) fn efforts(&self) -> impl Iterator<Item = Effort> {
        self.panel.candidates.iter().map(|c| Effort::of(c, self.bounces))
    }

    /// The candidate whose picture's mean is known best.
    fn best(&self) -> Option<&str> {
        let error = |name: &Effort| name.picture_error;
        let best = self.efforts().enumerate().min_by(|(_, a), (_, b)| error(a).total_cmp(&error(b)));
        best.map(|(i, _)| self.panel.candidates[i].name.as_str())
    }
}

/// The rounds of a scene, each with its first replicates in about `time` together: emitters by all solvers, scattered light by those that
/// estimate all of it, and the part that others estimate by these and the best of those.
pub(super) fn rounds<'a>(
    trial: Trial<'a>,
    entrants: &'a [Entrant<'_>],
    options: &VerifyOptions,
    time: Duration,
    tell: &dyn Fn(&str),
) -> Stopped<Vec<Round<'a>>> {
    const EMITTERS: f64 = 0.2;
    let scattered = trial.rules.max_edges > 1;
    let parts: Vec<(&Entrant<'_>, u32)> = entrants
        .iter()
        .filter_map(|e| if let Estimates::LightUpTo(edges) = e.estimates { Some((e, edges)) } else { None })
        .filter(|(_, edges)| scattered && *edges > 1)
        .collect();

    tell("rendering emitters");
    let mut emitters = Round::new(trial, Bounces { least: 0, most: Some(0) });
    for entrant in entrants {
        emitters.enter(entrant, options, time.mul_f64(EMITTERS / entrants.len().max(1) as f64))?;
    }
    let mut rounds = vec![emitters];
    if !scattered {
        return Ok(rounds);
    }
    let all = || entrants.iter().filter(|e| e.estimates == Estimates::Light);
    let share = time.mul_f64((1.0 - EMITTERS) / (all().count() + 2 * parts.len()).max(1) as f64);
    let mut main = Round::new(trial, Bounces { least: 1, most: None });
    for entrant in all() {
        tell(&format!("rendering with {}", entrant.name));
        main.enter(entrant, options, share)?;
    }
    let best = main.best().map(str::to_owned);
    rounds.push(main);
    for (entrant, edges) in parts {
        let Some(partner) = all().find(|e| Some(&e.name) == best.as_ref()) else { continue };
        tell(&format!("rendering with {}", entrant.name));
        let mut round = Round::new(trial, Bounces { least: 1, most: Some(edges - 1) });
        round.enter(entrant, options, share)?;
        round.enter(partner, options, share)?;
        rounds.push(round);
    }
    Ok(rounds)
}
