//! Acceptance: every solver against `path-mis` in every block of a grid, at standard errors that are fixed beforehand.
//!
//! `verify` gives a verdict in a fixed time; this asks for as many samples as it takes. Each solver renders K replicates until the standard
//! error of every block's luminance is at most its target, relative to that block; then each block and channel is compared with those of the
//! reference by Welch's t, all in one family. Where `path-mis` would take too long, the solver that knows its blocks best takes its place.
//! Emitters and scattered light are rendered apart, each with the samples that it needs, and
//! added replicate by replicate: a small bright lamp in a block would otherwise ask for as many samples of everything.

use super::contest::{Entrant, chosen, load_small};
use super::report::Bounces;
use super::{Stopped, VerifyOptions};
use crate::experiment::{ExperimentError, Header};
use crate::pool;
use etendue_check::Moments;
use etendue_solvers::agreement::{Area, Expected, Finding, Renderer, Sample, Trial, Verdict, judge};
use etendue_solvers::{CancelToken, Estimates};
use serde::Serialize;
use std::time::{Duration, Instant};

/// Whom the others are held to.
const REFERENCE: &str = "path-mis";
/// Replicates.
const K: usize = 32;
/// The standard error of a block that is asked for, relative, and of solvers that are noisier.
const TARGET: f64 = 0.01;
const NOISIER: &[(&str, f64)] = &[("light-nee", 0.03), ("metropolis", 0.03), ("path", 0.05), ("light", 0.05)];

/// One solver's result.
#[derive(Clone, Debug, Serialize)]
pub struct Acceptance {
    /// Its name.
    pub solver: String,
    /// The standard error that every block must reach, relative.
    pub target: f64,
    /// The largest that there is, and where.
    pub worst_error: f64,
    /// Where it is.
    pub worst_area: Area,
    /// Samples per pixel of all replicates together: of emitters, of scattered light.
    pub spp: [u64; 2],
    /// Time, s.
    pub seconds: f64,
    /// Time that it would take to the target, s, where it was not reached.
    pub needed: Option<f64>,
    /// The comparison with the reference that chance explains least; none for the reference, and where the target was not reached.
    pub worst: Option<Finding>,
    /// Blocks and channels that differ by more than chance.
    pub differences: usize,
}

/// All results.
#[derive(Clone, Debug, Serialize)]
pub struct Accepted {
    /// Scene, size, seed and the like.
    #[serde(flatten)]
    pub header: Header,
    /// Comparisons in the family.
    pub tests: usize,
    /// Whom the others are held to: `path-mis`, or where it did not reach its target the one that knows its blocks best; none where nobody does.
    pub reference: Option<String>,
    /// The solvers', that of `path-mis` first.
    pub solvers: Vec<Acceptance>,
    /// Solvers that were left out, and why.
    pub left_out: Vec<(String, String)>,
    /// FAIL with a difference, INCONCLUSIVE where a target was not reached.
    pub verdict: Verdict,
    /// Time for everything, s.
    pub seconds: f64,
}

/// Emitters or scattered light by one solver.
struct Part<'a> {
    trial: Trial<'a>,
    render: Box<Renderer<'a>>,
    stream: u64,
    spp: u32,
    batches: u32,
    /// Sums of the batches' means of the areas, by replicate.
    sums: Vec<Vec<[f64; 3]>>,
    elapsed: Duration,
}

impl<'a> Part<'a> {
    fn new(trial: Trial<'a>, entrant: &'a Entrant<'_>, bounces: Bounces, stream: u64) -> Stopped<Self> {
        const FIRST: Duration = Duration::from_millis(500);
        let trial = Trial { rules: bounces.of(trial.rules), ..trial };
        let render = entrant.renderer(trial.scene);
        let spp = trial.samples_in(&*render, FIRST, K as u32)?;
        let sums = vec![vec![[0.0; 3]; trial.grid().len()]; K];
        Ok(Self { trial, render, stream, spp, batches: 0, sums, elapsed: Duration::ZERO })
    }

    /// As many samples again for every replicate.
    fn add(&mut self, batches: u32) -> Stopped<()> {
        for _ in 0..batches {
            for (r, sums) in self.sums.iter_mut().enumerate() {
                let number = self.batches * K as u32 + r as u32;
                let shot = self.trial.replicate(&*self.render, self.spp, self.stream, number)?;
                self.elapsed += shot.elapsed;
                for (sum, mean) in sums.iter_mut().flatten().zip(self.trial.grid().means(&shot.pixels).iter().flatten()) {
                    *sum += mean;
                }
            }
            self.batches += 1;
        }
        Ok(())
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

/// Renders until every block is known to `target` or `limit` is over: the sample, and what is to be told of it.
fn measure(trial: Trial<'_>, entrant: &Entrant<'_>, stream: u64, limit: Duration) -> Stopped<(Sample, Acceptance)> {
    let target = NOISIER.iter().find(|n| n.0 == entrant.name).map_or(TARGET, |n| n.1);
    let mut parts = Vec::new();
    for (i, bounces) in [Bounces { least: 0, most: Some(0) }, Bounces { least: 1, most: None }].into_iter().enumerate() {
        let mut part = Part::new(trial, entrant, bounces, 2 * stream + i as u64)?;
        part.add(1)?;
        parts.push(part);
    }
    let elapsed = |parts: &[Part<'_>]| parts.iter().map(|p| p.elapsed).sum::<Duration>();
    let error = |parts: &[Part<'_>], area: usize| {
        let mean: f64 = (0..K).flat_map(|r| parts.iter().map(move |p| luminance(p.mean(r, area)))).sum::<f64>() / K as f64;
        let se = parts.iter().map(|p| p.variance(area)).sum::<f64>().sqrt();
        if se > 0.0 { se / mean.abs() } else { 0.0 }
    };
    let areas = trial.grid().len();
    let worst = |parts: &[Part<'_>]| {
        let errors = (1..areas).map(|a| (a, error(parts, a)));
        errors.max_by(|x, y| x.1.total_cmp(&y.1)).unwrap_or((0, error(parts, 0)))
    };
    let (mut area, mut se) = worst(&parts);
    while se > target && elapsed(&parts) < limit {
        // The part whose variance falls most per second; at most as many samples again as there are.
        let falls = |p: &Part<'_>| p.variance(area) / p.elapsed.as_secs_f64().max(1e-9);
        let part = if falls(&parts[0]) > falls(&parts[1]) { &mut parts[0] } else { &mut parts[1] };
        let times = ((se / target).powi(2) - 1.0).clamp(0.0, 1.0);
        let room = limit.saturating_sub(part.elapsed).div_duration_f64(part.elapsed.max(Duration::from_nanos(1)));
        part.add((f64::from(part.batches) * times.min(room)).ceil().max(1.0) as u32)?;
        (area, se) = worst(&parts);
    }

    let mut sample = Sample::new(trial.grid());
    for r in 0..K {
        let sum = |a: usize| std::array::from_fn(|c| parts.iter().map(|p| p.mean(r, a)[c]).sum());
        sample.add_means((0..areas).map(sum));
    }
    let seconds = elapsed(&parts).as_secs_f64();
    let acceptance = Acceptance {
        solver: entrant.name.clone(),
        target,
        worst_error: se,
        worst_area: trial.grid().areas().nth(area).unwrap_or(Area::Picture),
        spp: std::array::from_fn(|i| u64::from(parts[i].spp) * u64::from(parts[i].batches) * K as u64),
        seconds,
        needed: (se > target).then(|| seconds * (se / target).powi(2)),
        worst: None,
        differences: 0,
    };
    Ok((sample, acceptance))
}

/// Accepts a scene's solvers, with at most `options.time` for each. `tell` hears what is going on.
pub fn accept(scene: &str, options: &VerifyOptions, cancel: &CancelToken, tell: &dyn Fn(&str)) -> Stopped<Accepted> {
    let begun = Instant::now();
    let loaded = load_small(scene, options)?;
    let pool = pool::pool(options.threads)?;
    let trial = Trial { seed: options.seed, blocks: options.blocks, ..Trial::new(&loaded.scene, &pool, cancel) };
    let (entrants, mut left_out) = chosen(options, Vec::new(), &loaded.scene);
    let (mut entrants, others): (Vec<_>, Vec<_>) = entrants.into_iter().partition(|e| e.estimates == Estimates::Light);
    left_out.extend(others.into_iter().map(|e| (e.name, "it estimates a part of the light".to_owned())));
    entrants.sort_by_key(|e| e.name != REFERENCE);
    if entrants.first().is_none_or(|e| e.name != REFERENCE) {
        return Err(ExperimentError::Words(format!("`{REFERENCE}` must take part: the others are held to it")));
    }

    let mut found = Vec::new();
    for (i, entrant) in entrants.iter().enumerate() {
        tell(&format!("rendering with {}", entrant.name));
        found.push(measure(trial, entrant, i as u64, options.time)?);
    }
    // Means that are not known well enough are skewed, mostly too small: nobody is held to them, and they are held to nobody.
    let reached = |f: &&(Sample, Acceptance)| f.1.needed.is_none();
    let best = found.iter().filter(reached).min_by(|a, b| a.1.worst_error.total_cmp(&b.1.worst_error));
    let reference = found.iter().take(1).find(reached).or(best).map(|f| (f.0.clone(), f.1.solver.clone()));
    let tests = found.iter().filter(reached).count().saturating_sub(1) * 3 * trial.grid().len();
    if let Some((reference, name)) = &reference {
        for (sample, row) in found.iter_mut().filter(|f| f.1.needed.is_none() && f.1.solver != *name) {
            let agreement = judge(sample, Expected::Sample(reference), &options.standard, tests);
            row.differences = agreement.failures().count();
            row.worst = Some(agreement.worst);
        }
    }
    let solvers: Vec<Acceptance> = found.into_iter().map(|f| f.1).collect();
    let of = |row: &Acceptance| match row {
        Acceptance { differences: 1.., .. } => Verdict::Fail,
        Acceptance { needed: Some(_), .. } => Verdict::Inconclusive,
        _ => Verdict::Pass,
    };
    Ok(Accepted {
        header: Header::new(&loaded, &trial, options.standard),
        tests,
        reference: reference.map(|r| r.1),
        verdict: solvers.iter().map(of).max().unwrap_or(Verdict::Inconclusive),
        solvers,
        left_out,
        seconds: begun.elapsed().as_secs_f64(),
    })
}
