//! The furnace: each solver is held to its own partial Neumann sum.
//!
//! ```text
//! L = Le (1 - aⁿ⁺¹) / (1 - a)        light of at most n bounces, in every pixel
//! ```

use super::contest::Entrant;
use super::report::{Bounces, Comparison};
use super::schedule::Unjudged;
use super::{Stopped, VerifyOptions};
use crate::experiment::ExperimentError;
use crate::load::{LoadOptions, Loaded, load};
use etendue_solvers::Estimates;
use etendue_solvers::agreement::{Agreement, Expected, REPLICATES, Renderer, Sample, Standard, Trial, Verdict, judge};
use std::time::Duration;

/// Bounces at most, unbounded at last.
const DEPTHS: [Option<u32>; 5] = [Some(0), Some(1), Some(2), Some(4), None];
/// How many times longer than its share the first replicates of a solver that is in no pair may take.
const PATIENCE: u32 = 4;
/// Albedo.
const ALBEDO: f64 = 0.5;
/// Radius and field of view of the lens, degrees: wide, since some solvers must hit it by chance.
const LENS: [&str; 2] = ["0.5", "90"];

pub(super) fn load_furnace(options: &VerifyOptions) -> Result<Loaded, ExperimentError> {
    let [radius, fov] = LENS.map(str::to_owned);
    let defines = [("albedo", ALBEDO.to_string()), ("aperture", radius), ("fov", fov)];
    let defines = defines.map(|(name, value)| (name.to_owned(), value)).to_vec();
    let load_options = LoadOptions {
        defines,
        width: Some(16),
        height: Some(16),
        threads: options.threads,
        spectral: options.spectral,
        ..LoadOptions::default()
    };
    load("furnace", &load_options).map_err(ExperimentError::Load)
}

/// A solver in the furnace, at one depth.
pub(super) struct Oven<'a> {
    pub(super) name: String,
    pub(super) bounces: Bounces,
    pub(super) sample: Sample,
    pub(super) elapsed: Duration,
    pub(super) found: Agreement,
    seen_once: bool,
    leeway: f64,
    trial: Trial<'a>,
    render: Box<Renderer<'a>>,
    spp: u32,
    stream: u64,
    known: Vec<[f64; 3]>,
}

/// Every solver at every depth that it can, each with its first replicates, in about `time` together; and the names of those in no pair whose replicates
/// take too long for that.
pub(super) fn ovens<'a>(
    trial: Trial<'a>,
    entrants: &[&'a Entrant<'_>],
    options: &VerifyOptions,
    time: Duration,
) -> Stopped<(Vec<Oven<'a>>, Vec<String>)> {
    let (mut all, mut slow) = (Vec::new(), Vec::new());
    let first = time.div_f64((entrants.len() * DEPTHS.len()).max(1) as f64);
    for (i, entrant) in entrants.iter().enumerate() {
        let once = trial.replicate(&*entrant.renderer(trial.scene), 1, u64::MAX, i as u32)?.elapsed;
        if entrant.estimates == Estimates::InTheLimit && once * REPLICATES > PATIENCE * first {
            slow.push(entrant.name.clone());
            continue;
        }
        let edges = entrant.in_furnace().unwrap_or(0);
        let depths = DEPTHS.into_iter().filter(|d| d.is_some() || edges == u32::MAX);
        all.extend(depths.map(|d| (i as u64, *entrant, d)));
    }
    let share = time.div_f64(all.len().max(1) as f64);
    let ovens = all.into_iter().map(|(place, entrant, depth)| Oven::new(trial, (place, entrant), depth, options, share));
    Ok((ovens.collect::<Stopped<_>>()?, slow))
}

impl<'a> Oven<'a> {
    fn new(
        trial: Trial<'a>,
        (place, entrant): (u64, &'a Entrant<'_>),
        depth: Option<u32>,
        options: &VerifyOptions,
        share: Duration,
    ) -> Stopped<Self> {
        let bounces = Bounces { least: 0, most: depth };
        let trial = Trial { rules: bounces.of(trial.rules), ..trial };
        let render = entrant.renderer(trial.scene);
        let spp = match options.spp {
            Some(spp) => spp,
            None => trial.samples_in(&*render, share, REPLICATES)?,
        };
        let counted = match entrant.in_furnace() {
            Some(edges) if edges < u32::MAX => Some(depth.map_or(edges - 1, |n| n.min(edges - 1))),
            _ => depth,
        };
        let l = counted.map_or(1.0, |n| 1.0 - ALBEDO.powi(n as i32 + 1)) / (1.0 - ALBEDO);
        let known = vec![[l; 3]; trial.grid().len()];
        let sample = Sample::new(trial.grid());
        let mut oven = Self {
            name: entrant.name.clone(),
            bounces,
            found: judge(&sample, Expected::Known(&known), &options.standard, 1),
            sample,
            elapsed: Duration::ZERO,
            seen_once: false,
            leeway: entrant.leeway(),
            trial,
            render,
            spp,
            stream: 64 * place + u64::from(depth.unwrap_or(63)),
            known,
        };
        oven.measure(REPLICATES)?;
        Ok(oven)
    }

    /// More replicates.
    pub(super) fn measure(&mut self, count: u32) -> Stopped<()> {
        for _ in 0..count {
            let shot = self.trial.replicate(&*self.render, self.spp, self.stream, self.sample.count() as u32)?;
            self.sample.add(&shot.pixels);
            self.elapsed += shot.elapsed;
        }
        Ok(())
    }

    /// Comparisons with the closed form.
    pub(super) fn tests(&self) -> usize {
        3 * self.trial.grid().len()
    }

    pub(super) fn judge(&mut self, standard: &Standard, tests: usize) {
        self.found = judge(&self.sample, Expected::Known(&self.known), &standard.widened(self.leeway), tests);
    }

    /// A difference must be there again in fresh replicates, of one of `failed` ovens that are looked at again.
    pub(super) fn confirm(&mut self, standard: &Standard, failed: usize) -> Stopped<()> {
        if self.found.verdict == Verdict::Fail {
            let fresh = self.trial.sample(&*self.render, self.spp, self.sample.count() as u32, self.stream + (1 << 32))?;
            let again = judge(&fresh, Expected::Known(&self.known), &standard.widened(self.leeway), failed * self.tests());
            self.seen_once = again.verdict != Verdict::Fail;
        }
        Ok(())
    }

    pub(super) fn comparison(&self, unjudged: &[Unjudged]) -> Comparison {
        let verdict = if self.seen_once { Verdict::Inconclusive } else { self.found.verdict };
        let noisy = unjudged.iter().any(|u| u.solver == self.name);
        let counts = !noisy || self.seen_once || verdict != Verdict::Inconclusive;
        Comparison::of(self.name.clone(), self.bounces, verdict, self.seen_once, counts, &self.found)
    }
}
