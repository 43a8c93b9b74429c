//! The furnace: each solver is held to its own partial Neumann sum.

use super::VerifyOptions;
use crate::experiment::{ExperimentError, renderer};
use crate::load::{LoadOptions, Loaded, load};
use etendue_solvers::agreement::{Agreement, Expected, REPLICATES, Renderer, Sample, Standard, Trial, judge};
use etendue_solvers::{AnySolver, Estimates, PathRules, SOLVERS};
use std::time::Duration;

/// Depths of the furnace: bounces at most, unbounded at last.
pub(super) const DEPTHS: [Option<u32>; 5] = [Some(0), Some(1), Some(2), Some(4), None];
/// Albedo of the furnace.
const ALBEDO: f64 = 0.5;

pub(super) fn load_furnace(options: &VerifyOptions) -> Result<Loaded, ExperimentError> {
    let defines = vec![("albedo".to_owned(), ALBEDO.to_string())];
    let load_options = LoadOptions { defines, width: Some(16), height: Some(16), threads: options.threads };
    load("furnace", &load_options).map_err(ExperimentError::Load)
}

/// A solver in the furnace, at one depth.
pub(super) struct Oven<'a> {
    pub(super) name: String,
    pub(super) depth: Option<u32>,
    trial: Trial<'a>,
    render: Box<Renderer<'a>>,
    spp: u32,
    stream: u64,
    known: Vec<[f64; 3]>,
    pub(super) sample: Sample,
    pub(super) elapsed: Duration,
}

impl<'a> Oven<'a> {
    /// With its first replicates.
    pub(super) fn new(
        trial: Trial<'a>,
        solver: &'a AnySolver,
        depth: Option<u32>,
        options: &VerifyOptions,
        share: Duration,
    ) -> Option<Self> {
        let rules = PathRules { max_edges: depth.map_or(u32::MAX, |n| n + 1), ..trial.rules };
        let trial = Trial { rules, ..trial };
        let render = renderer(solver, trial.scene);
        let spp = match options.spp {
            Some(spp) => spp,
            None => trial.samples_in(&*render, share, REPLICATES)?,
        };
        let counted = match solver.estimates() {
            Estimates::LightUpTo(edges) => Some(depth.map_or(edges - 1, |n| n.min(edges - 1))),
            _ => depth,
        };
        let l = counted.map_or(1.0 / (1.0 - ALBEDO), |n| (1.0 - ALBEDO.powi(n as i32 + 1)) / (1.0 - ALBEDO));
        let place = SOLVERS.iter().position(|s| s.name == solver.name()).unwrap_or(0) as u64;
        let mut oven = Self {
            name: solver.name().to_owned(),
            depth,
            trial,
            render,
            spp,
            stream: 64 * place + u64::from(depth.unwrap_or(63)),
            known: vec![[l; 3]; trial.grid().len()],
            sample: Sample::new(trial.grid()),
            elapsed: Duration::ZERO,
        };
        oven.measure(REPLICATES)?;
        Some(oven)
    }

    pub(super) fn measure(&mut self, count: u32) -> Option<()> {
        for _ in 0..count {
            let shot = self.trial.replicate(&*self.render, self.spp, self.stream, self.sample.count() as u32)?;
            self.sample.add(&shot.pixels);
            self.elapsed += shot.elapsed;
        }
        Some(())
    }

    pub(super) fn judge(&self, standard: &Standard, tests: usize) -> Agreement {
        judge(&self.sample, Expected::Known(&self.known), standard, tests)
    }

    /// The same by fresh replicates, as one of `failed` that are looked at again.
    pub(super) fn again(&self, standard: &Standard, failed: usize) -> Option<Agreement> {
        let fresh = self.trial.sample(&*self.render, self.spp, self.sample.count() as u32, self.stream + (1 << 32))?;
        Some(judge(&fresh, Expected::Known(&self.known), standard, failed * 3 * self.trial.grid().len()))
    }
}
