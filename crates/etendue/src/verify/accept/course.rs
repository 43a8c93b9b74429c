//! A solver on its way to its target: replicates of the areas' means, batch by batch, kept in a file where one is named.
//!
//! Emitters and scattered light are rendered apart, each with the samples that it needs, and added replicate by replicate: a small bright lamp
//! in a block would otherwise ask for as many samples of everything.

use super::super::Stopped;
use super::super::contest::Entrant;
use super::super::report::Bounces;
use super::kept::{Keeper, Kept};
use etendue_check::Moments;
use etendue_solvers::agreement::{Area, Renderer, Sample, Trial};
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// Replicates.
pub(super) const K: usize = 32;
/// The first batch of a part.
const FIRST: Duration = Duration::from_millis(500);
/// Emitters, and light that was scattered.
const PARTS: [Bounces; 2] = [Bounces { least: 0, most: Some(0) }, Bounces { least: 1, most: None }];

/// What was rendered of a part of the light.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Sums {
    /// Samples per pixel of a replicate in a batch.
    spp: u32,
    batches: u32,
    seconds: f64,
    /// Sums of the batches' means of the areas, by replicate.
    sums: Vec<Vec<[f64; 3]>>,
}

impl Sums {
    pub(super) fn fits(&self, areas: usize) -> bool {
        self.spp > 0 && self.batches > 0 && self.sums.len() == K && self.sums.iter().all(|s| s.len() == areas)
    }

    fn mean(&self, replicate: usize, area: usize) -> [f64; 3] {
        self.sums[replicate][area].map(|s| s / f64::from(self.batches.max(1)))
    }

    /// The variance of an area's luminance, by replicates.
    fn variance(&self, area: usize) -> f64 {
        (0..K).map(|r| luminance(self.mean(r, area))).collect::<Moments>().standard_error().powi(2)
    }
}

fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// A part of the light, and the means to render more of it.
struct Part<'a> {
    trial: Trial<'a>,
    render: Box<Renderer<'a>>,
    stream: u64,
    done: Sums,
}

impl Part<'_> {
    /// As many samples again for every replicate.
    fn add(&mut self) -> Stopped<()> {
        let grid = self.trial.grid();
        let mut batch = Vec::with_capacity(K);
        for r in 0..K as u32 {
            let shot = self.trial.replicate(&*self.render, self.done.spp, self.stream, self.done.batches * K as u32 + r)?;
            self.done.seconds += shot.elapsed.as_secs_f64();
            batch.push(grid.means(&shot.pixels));
        }
        for (sum, mean) in self.done.sums.iter_mut().flatten().flatten().zip(batch.iter().flatten().flatten()) {
            *sum += mean;
        }
        self.done.batches += 1;
        Ok(())
    }
}

/// A solver on its way.
pub(super) struct Course<'a> {
    pub(super) name: &'a str,
    /// The standard error that every block must reach, relative.
    pub(super) target: f64,
    /// Time of earlier runs, s.
    pub(super) before: f64,
    trial: Trial<'a>,
    parts: [Part<'a>; 2],
    keeper: Option<&'a Keeper>,
}

impl<'a> Course<'a> {
    /// From what was kept, or from a first batch.
    pub(super) fn new(trial: Trial<'a>, entrant: &'a Entrant<'_>, target: f64, keeper: Option<&'a Keeper>) -> Stopped<Self> {
        let areas = trial.grid().len();
        let kept = keeper.map_or(Ok(None), |keeper| keeper.read(&entrant.name, areas))?;
        let mut first = kept.map(|k| k.parts.into_iter());
        // Numbers of its own, whoever else takes part.
        let own = entrant.name.bytes().fold(0u64, |h, b| h.wrapping_mul(0x100_0000_01b3) ^ u64::from(b));
        let mut part = |i: usize| -> Stopped<Part<'a>> {
            let trial = Trial { rules: PARTS[i].of(trial.rules), ..trial };
            let render = entrant.renderer(trial.scene);
            let (stream, kept) = (own << 1 | i as u64, first.as_mut().and_then(Iterator::next));
            if let Some(done) = kept {
                return Ok(Part { trial, render, stream, done });
            }
            let spp = trial.samples_in(&*render, FIRST, K as u32)?;
            let done = Sums { spp, batches: 0, seconds: 0.0, sums: vec![vec![[0.0; 3]; areas]; K] };
            let mut part = Part { trial, render, stream, done };
            part.add()?;
            Ok(part)
        };
        let parts = [part(0)?, part(1)?];
        let before = if first.is_some() { parts.iter().map(|p| p.done.seconds).sum() } else { 0.0 };
        Ok(Self { name: &entrant.name, target, before, trial, parts, keeper })
    }

    /// Time of all that there is, s.
    pub(super) fn seconds(&self) -> f64 {
        self.parts.iter().map(|p| p.done.seconds).sum()
    }

    /// Samples per pixel of all replicates together: of emitters, of scattered light.
    pub(super) fn spp(&self) -> [u64; 2] {
        std::array::from_fn(|i| u64::from(self.parts[i].done.spp) * u64::from(self.parts[i].done.batches) * K as u64)
    }

    fn error(&self, area: usize) -> f64 {
        let light = |r: usize| self.parts.iter().map(|p| luminance(p.done.mean(r, area))).sum::<f64>();
        let mean = (0..K).map(light).sum::<f64>() / K as f64;
        let se = self.parts.iter().map(|p| p.done.variance(area)).sum::<f64>().sqrt();
        if se > 0.0 { se / mean.abs() } else { 0.0 }
    }

    /// The block that is known least, and its standard error, relative.
    pub(super) fn worst(&self) -> (Area, f64) {
        let errors = self.trial.grid().areas().enumerate().skip(1).map(|(i, area)| (area, self.error(i)));
        errors.max_by(|x, y| x.1.total_cmp(&y.1)).unwrap_or((Area::Picture, self.error(0)))
    }

    /// Time from the beginning on that it takes to know every block to `target`, s, by what is known so far.
    pub(super) fn takes(&self, target: f64) -> f64 {
        self.seconds() * (self.worst().1 / target).powi(2)
    }

    /// Renders until every block is known to the target, or `limit` is over.
    pub(super) fn run(&mut self, limit: Duration) -> Stopped<()> {
        let end = self.seconds() + limit.as_secs_f64();
        loop {
            let (area, se) = self.worst();
            if se <= self.target || self.seconds() >= end {
                return self.keep();
            }
            // The part whose variance falls most per second; at most half as many samples again as there are before it is looked at again.
            let place = self.trial.grid().areas().position(|a| a == area).unwrap_or(0);
            let falls = |p: &Part<'_>| p.done.variance(place) / p.done.seconds.max(1e-9);
            let i = usize::from(falls(&self.parts[0]) <= falls(&self.parts[1]));
            let part = &mut self.parts[i];
            let batch = part.done.seconds / f64::from(part.done.batches);
            let wanted = f64::from(part.done.batches) * ((se / self.target).powi(2) - 1.0).clamp(0.0, 0.5);
            let begun = part.done.seconds;
            for _ in 0..(wanted.ceil() as u32).max(1) {
                part.add()?;
                // What is kept is at most some ten seconds old.
                if part.done.seconds - begun > (10.0f64).max(batch) {
                    break;
                }
            }
            self.keep()?;
        }
    }

    fn keep(&self) -> Stopped<()> {
        let Some(keeper) = self.keeper else { return Ok(()) };
        keeper.write(self.name, Kept { parts: self.parts.iter().map(|p| p.done.clone()).collect() })
    }

    /// The replicates of all light.
    pub(super) fn sample(&self) -> Sample {
        let mut sample = Sample::new(self.trial.grid());
        for r in 0..K {
            let sum = |a: usize| std::array::from_fn(|c| self.parts.iter().map(|p| p.done.mean(r, a)[c]).sum());
            sample.add_means((0..self.trial.grid().len()).map(sum));
        }
        sample
    }
}
