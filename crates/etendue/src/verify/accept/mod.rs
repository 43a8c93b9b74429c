//! Acceptance: every solver against one reference in every block of a grid, at standard errors that are fixed beforehand.
//!
//! `verify` gives a verdict in a fixed time; this asks for as many samples as it takes. Each solver renders K replicates until the standard
//! error of every block's luminance is at most its target, relative to that block; then each block and channel is compared with those of the
//! reference by Welch's t, all in one family.
//!
//! **The reference** is `path-mis` where a first batch says that it reaches 1 % in the time that it has, and otherwise the solver that reaches 1 %
//! soonest.
//!
//! **Who does not reach the target** in the time that there is, is compared as well, at the error that it has reached, but such a means of rare bright
//! paths is skewed: mostly too small, with a spread that is too small as well. Where it is above the reference, that is no excuse: the rare path
//! that lifts it widens its spread by as much, and Student's t errs towards no difference. A block that is too bright is therefore a difference at
//! any error, and one that is too dark only where the target was reached; until then it is doubtful, and the verdict INCONCLUSIVE.

mod course;
mod kept;

use super::contest::{Chosen, chosen, load_small};
use super::{Stopped, VerifyOptions};
use crate::choice::check_solver_name;
use crate::experiment::{ExperimentError, Header};
use crate::pool;
use course::Course;
use etendue_solvers::agreement::{Area, Expected, Finding, Sample, Trial, Verdict, judge};
use etendue_solvers::{CancelToken, Estimates};
use kept::Keeper;
use serde::Serialize;
use std::time::{Duration, Instant};

/// Whom the others are held to where there is time for it.
const REFERENCE: &str = "path-mis";
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
    /// The largest that there is.
    pub worst_error: f64,
    /// Where it is.
    pub worst_area: Area,
    /// Samples per pixel of all replicates together: of emitters, of scattered light.
    pub spp: [u64; 2],
    /// Time, s, that of earlier runs included.
    pub seconds: f64,
    /// Time that it would take to the target, s, where it was not reached.
    pub needed: Option<f64>,
    /// The comparison with the reference that chance explains least; none for the reference.
    pub worst: Option<Finding>,
    /// The smallest bias of a block that would have been seen wherever it is, relative; none for the reference.
    pub visible: Option<f64>,
    /// Blocks and channels that differ by more than chance.
    pub differences: usize,
    /// Blocks and channels that differ by more than Student's t allows, where means are not known well enough to rely on it.
    pub doubtful: usize,
}

impl Acceptance {
    fn new(course: &Course<'_>) -> Self {
        let (worst_area, worst_error) = course.worst();
        Self {
            solver: course.name.to_owned(),
            target: course.target,
            worst_error,
            worst_area,
            spp: course.spp(),
            seconds: course.seconds(),
            needed: (worst_error > course.target).then(|| course.takes(course.target)),
            worst: None,
            visible: None,
            differences: 0,
            doubtful: 0,
        }
    }

    /// FAIL with a difference, INCONCLUSIVE where the target was not reached.
    pub fn verdict(&self) -> Verdict {
        match self {
            Self { differences: 1.., .. } => Verdict::Fail,
            Self { needed: Some(_), .. } | Self { doubtful: 1.., .. } => Verdict::Inconclusive,
            _ => Verdict::Pass,
        }
    }

    /// Compares with the reference, whose means are `known` well or not.
    fn compare(&mut self, sample: &Sample, reference: &Sample, known: bool, options: &VerifyOptions, tests: usize) {
        let agreement = judge(sample, Expected::Sample(reference), &options.standard, tests);
        let reached = self.needed.is_none();
        let counts = |f: &Finding| known && (reached || f.difference > 0.0);
        self.differences = agreement.failures().filter(|f| counts(f)).count();
        self.doubtful = agreement.failures().count() - self.differences;
        (self.worst, self.visible) = (Some(agreement.worst), Some(agreement.visible_block));
    }
}

/// All results.
#[derive(Clone, Debug, Serialize)]
pub struct Accepted {
    /// Scene, size, seed and the like.
    #[serde(flatten)]
    pub header: Header,
    /// Comparisons in the family.
    pub tests: usize,
    /// Whom the others are held to.
    pub reference: String,
    /// The solvers'.
    pub solvers: Vec<Acceptance>,
    /// Solvers that were left out, and why.
    pub left_out: Vec<(String, String)>,
    /// The worst of the solvers' verdicts.
    pub verdict: Verdict,
    /// Time for everything, s.
    pub seconds: f64,
}

/// Accepts a scene's solvers, with at most `options.time` for each, beside what was kept of earlier runs. `tell` hears what is going on, and first of all
/// what it costs.
pub fn accept(scene: &str, options: &VerifyOptions, cancel: &CancelToken, tell: &dyn Fn(&str)) -> Stopped<Accepted> {
    let begun = Instant::now();
    for name in options.solvers.iter().flatten() {
        check_solver_name(name)?;
    }
    let loaded = load_small(scene, options)?;
    let pool = pool::pool(options.threads)?;
    let trial = Trial { seed: options.seed, blocks: options.blocks, ..Trial::new(&loaded.scene, &pool, cancel) };
    let Chosen { entrants, mut left_out, .. } = chosen(options, Vec::new(), &loaded)?;
    let (entrants, others): (Vec<_>, Vec<_>) = entrants.into_iter().partition(|e| e.estimates == Estimates::Light);
    left_out.extend(others.into_iter().map(|e| (e.name, "it estimates a part of the light".to_owned())));
    // One alone is rendered for what is kept: others come from other runs, side by side with this one perhaps.
    if entrants.len() < 2 && (entrants.is_empty() || options.keep.is_none()) {
        return Err(ExperimentError::Words(
            "fewer than two solvers estimate all light of this scene: nothing to compare".to_owned(),
        ));
    }

    // What it will cost, by a first batch or by what was kept.
    let keeper = Keeper::new(&loaded, &trial, options)?;
    let mut courses = Vec::new();
    for entrant in &entrants {
        let target = NOISIER.iter().find(|n| n.0 == entrant.name).map_or(TARGET, |n| n.1);
        let course = Course::new(trial, entrant, target, keeper.as_ref())?;
        tell(&cost(&course));
        courses.push(course);
    }
    if courses.len() > 1 {
        let reference = planned(&courses, options.time);
        courses[reference].target = TARGET;
        courses.swap(0, reference);
        tell(&format!("the reference is {}", courses[0].name));
    }
    for course in &mut courses {
        tell(&format!("rendering with {}", course.name));
        course.run(options.time)?;
    }

    // First batches promise too much where bright paths are rare: the reference is the one that is known best in the end.
    let mut rows: Vec<Acceptance> = courses.iter().map(Acceptance::new).collect();
    let by_error = |a: &usize, b: &usize| rows[*a].worst_error.total_cmp(&rows[*b].worst_error);
    let reference = if rows[0].needed.is_none() { 0 } else { (0..rows.len()).min_by(by_error).unwrap_or(0) };
    let known = rows[reference].needed.is_none();
    let tests = (rows.len() - 1) * 3 * trial.grid().len();
    let samples: Vec<Sample> = courses.iter().map(Course::sample).collect();
    for i in (0..rows.len()).filter(|i| *i != reference) {
        rows[i].compare(&samples[i], &samples[reference], known, options, tests);
    }
    Ok(Accepted {
        header: Header::new(&loaded, &trial, options.standard),
        tests,
        reference: rows[reference].solver.clone(),
        verdict: if tests > 0 { rows.iter().map(Acceptance::verdict).max() } else { None }.unwrap_or(Verdict::Inconclusive),
        solvers: rows,
        left_out,
        seconds: begun.elapsed().as_secs_f64(),
    })
}

fn cost(course: &Course<'_>) -> String {
    let (name, target) = (course.name, 100.0 * course.target);
    let (after, takes) = (course.seconds(), course.takes(course.target));
    let error = 100.0 * course.worst().1;
    if takes <= after {
        format!("{name}: {target} % of each block was reached in {after:.0} s")
    } else {
        format!("{name}: {error:.1} % of the worst block after {after:.0} s; {target} % of each takes about {takes:.0} s")
    }
}

/// Whom the others will be held to: `path-mis` where it reaches 1 % in its time, and whoever reaches it soonest otherwise.
fn planned(courses: &[Course<'_>], time: Duration) -> usize {
    let takes = |i: &usize| courses[*i].takes(TARGET);
    let first = courses.iter().position(|c| c.name == REFERENCE);
    first.filter(|i| takes(i) <= courses[*i].before + time.as_secs_f64()).unwrap_or_else(|| {
        let soonest = (0..courses.len()).min_by(|a, b| takes(a).total_cmp(&takes(b)));
        soonest.unwrap_or(0)
    })
}
