//! Where the time goes, and who is too noisy for it.

use super::Stopped;
use super::furnace::Oven;
use super::round::Round;
use etendue_check::family_wise;
use etendue_solvers::agreement::{Agreement, Pair, Standard, Verdict, quantile_of_many};
use serde::Serialize;
use std::collections::BTreeMap;
use std::time::Duration;

/// Replicates that are added at once where more are wanted.
const MORE: u32 = 4;
/// By how much what comparisons seem to need may be above the time that is left: early on it is known roughly.
const HOPE: f64 = 2.0;

/// All that is asked: comparisons of pairs on the scene, and of each solver with the furnace.
pub(super) struct Questions<'a> {
    pub(super) rounds: Vec<Round<'a>>,
    pub(super) ovens: Vec<Oven<'a>>,
    pub(super) standard: Standard,
    /// Comparisons in the family.
    pub(super) tests: usize,
    /// Solvers that must be judged, however long it takes.
    pub(super) named: Vec<String>,
}

/// A solver that would need more time for a verdict than there is.
#[derive(Clone, Debug, Serialize)]
pub struct Unjudged {
    /// Its name.
    pub solver: String,
    /// The comparison that needs most, in words.
    pub comparison: String,
    /// Time that its comparisons would need in addition, s.
    pub seconds: f64,
    /// The smallest bias of the whole picture that would have been seen all the same, relative, in each part of the light by the comparison that shows most;
    /// none where it is in no pair.
    pub visible: Option<f64>,
}

/// A comparison that is still open.
struct Open {
    /// The noisier solver, and the other.
    solver: String,
    other: Option<String>,
    comparison: String,
    /// The samples that are compared, with the time that each still needs, s.
    needs: Vec<(Place, f64)>,
    /// The sample whose replicates narrow the widest interval fastest, and the time of the next few.
    next: (Place, Duration),
}

/// Where a sample is.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    /// A candidate of a round.
    Round(usize, usize),
    Oven(usize),
}

impl Questions<'_> {
    /// Judges everything by what was measured so far.
    pub(super) fn judge(&mut self) {
        self.rounds.iter_mut().for_each(|r| r.judge(&self.standard, self.tests));
        self.ovens.iter_mut().for_each(|o| o.judge(&self.standard, self.tests));
    }

    /// Measures where it decides most: of the solvers that can be judged in the time that `left` tells, what is nearest to being told comes first.
    pub(super) fn pursue(&mut self, left: impl Fn() -> Duration) -> Stopped<()> {
        loop {
            let left = left();
            let mut open = self.open();
            self.leave_out(&mut open, HOPE * left.as_secs_f64());
            // Where nothing can be told in the time that is left, what is nearest to it comes nearer, and smaller biases would be seen.
            if open.is_empty() {
                open = self.open();
            }
            open.retain(|o| o.next.1 <= left);
            let Some(next) = open.iter().min_by(|a, b| a.seconds().total_cmp(&b.seconds())) else { return Ok(()) };
            match next.next.0 {
                Place::Round(r, candidate) => {
                    self.rounds[r].measure(candidate, MORE)?;
                    self.rounds[r].judge(&self.standard, self.tests);
                }
                Place::Oven(i) => {
                    self.ovens[i].measure(MORE)?;
                    self.ovens[i].judge(&self.standard, self.tests);
                }
            }
        }
    }

    /// Solvers that leave no comparison open when they are left out.
    pub(super) fn too_noisy(&self) -> Vec<Unjudged> {
        self.leave_out(&mut self.open(), 0.0)
    }

    /// Leaves out the solver that needs most time, again and again, until what is open needs no more than `budget`, s.
    fn leave_out(&self, open: &mut Vec<Open>, budget: f64) -> Vec<Unjudged> {
        let mut found = Vec::new();
        while !open.is_empty() && needs(open.iter()).values().sum::<f64>() > budget {
            let mut solvers: Vec<&str> = open.iter().map(|o| o.solver.as_str()).filter(|s| !self.is_named(s)).collect();
            solvers.sort_unstable();
            solvers.dedup();
            let of = |solver: &str| needs(open.iter().filter(|o| o.solver == solver)).values().sum::<f64>();
            let most = solvers.into_iter().map(|s| (s, of(s))).max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((solver, seconds)) = most.map(|(s, seconds)| (s.to_owned(), seconds)) else { break };
            let worst = open.iter().filter(|o| o.solver == solver).max_by(|a, b| a.seconds().total_cmp(&b.seconds()));
            let comparison = worst.map_or(String::new(), |o| o.comparison.clone());
            open.retain(|o| o.solver != solver && o.other.as_ref() != Some(&solver));
            let visible = self.rounds.iter().filter_map(|r| r.visible(&solver)).reduce(f64::max);
            found.push(Unjudged { solver, comparison, seconds, visible });
        }
        found
    }

    fn is_named(&self, solver: &str) -> bool {
        self.named.iter().any(|n| n == solver)
    }

    fn open(&self) -> Vec<Open> {
        let level = family_wise(self.standard.alpha, self.tests);
        let need = |a: &Agreement, elapsed: Duration| (a.more(level) - 1.0) * elapsed.as_secs_f64();
        let few = |elapsed: Duration, count: usize| elapsed.mul_f64(f64::from(MORE) / count.max(1) as f64);
        let is_open = |a: &Agreement| a.verdict == Verdict::Inconclusive;
        let mut open = Vec::new();
        for (r, round) in self.rounds.iter().enumerate() {
            for pair in round.pairs.iter().filter(|p| is_open(&p.agreement)) {
                let (noisier, helps) = roles(round, pair);
                let of = |c: usize| &round.panel.candidates[c];
                let other = &of(pair.a + pair.b - noisier).name;
                open.push(Open {
                    solver: of(noisier).name.clone(),
                    comparison: format!("with {other}, {}", round.bounces),
                    other: Some(other.clone()),
                    needs: shares(round, pair, level).map(|(c, seconds)| (Place::Round(r, c), seconds)).to_vec(),
                    next: (Place::Round(r, helps), few(of(helps).elapsed, of(helps).sample.count())),
                });
            }
        }
        for (i, oven) in self.ovens.iter().enumerate().filter(|(_, o)| is_open(&o.found)) {
            open.push(Open {
                solver: oven.name.clone(),
                other: None,
                comparison: format!("with the furnace, {}", oven.bounces),
                needs: vec![(Place::Oven(i), need(&oven.found, oven.elapsed))],
                next: (Place::Oven(i), few(oven.elapsed, oven.sample.count())),
            });
        }
        open
    }
}

impl Open {
    fn seconds(&self) -> f64 {
        self.needs.iter().map(|n| n.1).sum()
    }
}

/// The time that each sample still needs: the most that any of its comparisons asks for.
fn needs<'o>(open: impl Iterator<Item = &'o Open>) -> BTreeMap<Place, f64> {
    let mut most = BTreeMap::new();
    for (place, seconds) in open.flat_map(|o| &o.needs) {
        let known = most.entry(*place).or_insert(0.0f64);
        *known = known.max(*seconds);
    }
    most
}

/// The time that each of a pair's candidates still needs, if there is no difference. With variances r/t after the times t their sum falls to σ²
/// soonest, for both together, at t_a = √r_a (√r_a + √r_b) / σ².
fn shares(round: &Round<'_>, pair: &Pair, level: f64) -> [(usize, f64); 2] {
    let most = quantile_of_many(level);
    let both = [pair.a, pair.b].map(|c| &round.panel.candidates[c]);
    let mut seconds = [0.0f64; 2];
    for (i, f) in pair.agreement.findings.iter().enumerate().filter(|(_, f)| f.verdict == Verdict::Inconclusive) {
        let aim = f.bound * f.scale / most;
        let elapsed = both.map(|c| c.elapsed.as_secs_f64());
        let error = both.map(|c| c.sample.areas()[i / 3][f.channel].standard_error());
        let root = [0, 1].map(|k| error[k] * elapsed[k].sqrt());
        for k in 0..2 {
            let to_bound = root[k] * (root[0] + root[1]) / (aim * aim) - elapsed[k];
            let to_be_told = if error[k] >= error[1 - k] { (f.evidence.recip() - 1.0) * elapsed[k] } else { 0.0 };
            seconds[k] = seconds[k].max(to_bound).max(to_be_told);
        }
    }
    [(pair.a, seconds[0]), (pair.b, seconds[1])]
}

/// Of a pair's candidates the noisier one where the interval is widest, and the one whose replicates narrow it fastest: whose variance falls
/// most per second.
fn roles(round: &Round<'_>, pair: &Pair) -> (usize, usize) {
    let blindest = &pair.agreement.blindest;
    let area = round.panel.trial.grid().areas().position(|a| a == blindest.area).unwrap_or(0);
    let variance = |c: usize| round.panel.candidates[c].sample.areas()[area][blindest.channel].standard_error().powi(2);
    let falls = |c: usize| variance(c) / round.panel.candidates[c].elapsed.as_secs_f64().max(1e-9);
    let larger = |f: &dyn Fn(usize) -> f64| if f(pair.a) > f(pair.b) { pair.a } else { pair.b };
    (larger(&variance), larger(&falls))
}
