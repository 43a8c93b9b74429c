//! Several solvers that estimate the same light: every pair is compared.

use super::{Agreement, Expected, NoPicture, REPLICATES, Renderer, Sample, Standard, Trial, Verdict, judge};
use std::time::Duration;

/// One of the solvers.
pub struct Candidate<'a> {
    /// Its name.
    pub name: String,
    /// Renders with it.
    pub render: Box<Renderer<'a>>,
    /// Samples per pixel of one replicate.
    pub spp: u32,
    /// How many times wider than usual the bounds of its comparisons are.
    pub leeway: f64,
    /// Replicates so far.
    pub sample: Sample,
    /// Time that they took.
    pub elapsed: Duration,
    /// Samples that were not finite.
    pub dropped: u64,
    stream: u64,
}

/// Two candidates, compared.
#[derive(Clone, Debug)]
pub struct Pair {
    /// Index of the first.
    pub a: usize,
    /// Index of the second.
    pub b: usize,
    /// What was found.
    pub agreement: Agreement,
    /// FAIL only where the difference was seen twice, in independent replicates.
    pub verdict: Verdict,
    /// A difference was seen once, and not again in fresh replicates.
    pub seen_once: bool,
}

/// Candidates of one trial.
pub struct Panel<'a> {
    /// What is rendered.
    pub trial: Trial<'a>,
    /// By which solvers.
    pub candidates: Vec<Candidate<'a>>,
}

impl<'a> Panel<'a> {
    /// Nobody yet.
    pub fn new(trial: Trial<'a>) -> Self {
        Self { trial, candidates: Vec::new() }
    }

    /// One more, whose replicates have `spp` samples per pixel.
    pub fn enter(&mut self, name: &str, render: Box<Renderer<'a>>, spp: u32) {
        let sample = Sample::new(self.trial.grid());
        let stream = self.candidates.len() as u64;
        let name = name.to_owned();
        self.candidates.push(Candidate { name, render, spp, leeway: 1.0, sample, elapsed: Duration::ZERO, dropped: 0, stream });
    }

    /// `count` more replicates of candidate `i`.
    pub fn measure(&mut self, i: usize, count: u32) -> Result<(), NoPicture> {
        let Self { trial, candidates } = self;
        let c = &mut candidates[i];
        for _ in 0..count {
            let shot = trial.replicate(&*c.render, c.spp, c.stream, c.sample.count() as u32)?;
            c.sample.add(&shot.pixels);
            c.elapsed += shot.elapsed;
            c.dropped += shot.dropped;
        }
        Ok(())
    }

    /// Comparisons of all pairs.
    pub fn tests(&self) -> usize {
        let n = self.candidates.len();
        n * n.saturating_sub(1) / 2 * 3 * self.trial.grid().len()
    }

    fn standard(&self, standard: &Standard, a: usize, b: usize) -> Standard {
        standard.widened(self.candidates[a].leeway.max(self.candidates[b].leeway))
    }

    /// Every pair by what was measured so far, in a family of `tests` comparisons.
    pub fn pairs(&self, standard: &Standard, tests: usize) -> Vec<Pair> {
        let n = self.candidates.len();
        let all = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b)));
        let compare = |(a, b): (usize, usize)| {
            let other = Expected::Sample(&self.candidates[b].sample);
            let agreement = judge(&self.candidates[a].sample, other, &self.standard(standard, a, b), tests);
            Pair { a, b, verdict: agreement.verdict, agreement, seen_once: false }
        };
        all.map(compare).collect()
    }

    /// Renders the candidates of pairs that failed anew, as often as before: rare bright paths make t overstate its case in a few areas, and a
    /// difference that is real is seen again. One that is not becomes inconclusive.
    pub fn confirm(&self, pairs: &mut [Pair], standard: &Standard) -> Result<(), NoPicture> {
        let failed = pairs.iter().filter(|p| p.verdict == Verdict::Fail).count();
        let tests = failed * 3 * self.trial.grid().len();
        let mut anew: Vec<Option<Sample>> = self.candidates.iter().map(|_| None).collect();
        for pair in pairs.iter_mut().filter(|p| p.verdict == Verdict::Fail) {
            for i in [pair.a, pair.b] {
                if anew[i].is_none() {
                    let c = &self.candidates[i];
                    let k = (c.sample.count() as u32).max(REPLICATES);
                    anew[i] = Some(self.trial.sample(&*c.render, c.spp, k, c.stream + (1 << 32))?);
                }
            }
            if let (Some(a), Some(b)) = (&anew[pair.a], &anew[pair.b])
                && judge(a, Expected::Sample(b), &self.standard(standard, pair.a, pair.b), tests).verdict != Verdict::Fail
            {
                (pair.verdict, pair.seen_once) = (Verdict::Inconclusive, true);
            }
        }
        Ok(())
    }
}
