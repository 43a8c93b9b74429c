//! Do the solvers agree? Renders a scene with every solver that can, compares all pairs, and holds each to the furnace's closed form.
//!
//! Solvers join by being in the list ([`etendue_solvers::SOLVERS`]): what a scene must have and what a solver estimates, it says itself. All
//! comparisons (pairs, areas, channels, and those of the furnace) are one family with 1 % of false alarms; see
//! [`etendue_solvers::agreement`] for the statistics and the verdicts.

use crate::choice::check_solver_name;
use crate::load::{LoadError, LoadOptions, Loaded, load};
use crate::pool;
use etendue_numerics::kernel::Kernel;
use etendue_scene::Scene;
use etendue_solvers::agreement::{
    Agreement, Candidate, Expected, Finding, Moments, Pair, Panel, REPLICATES, Renderer, Sample, Standard, Trial, Verdict, judge,
};
use etendue_solvers::{AnySolver, CancelToken, Estimates, PathRules, SOLVERS};
use serde::Serialize;
use std::time::{Duration, Instant};

/// How to verify.
#[derive(Clone, Debug)]
pub struct VerifyOptions {
    /// Solvers by name; all otherwise.
    pub solvers: Option<Vec<String>>,
    /// Time for everything.
    pub time: Duration,
    /// Samples per pixel of one replicate, instead of what the time allows; then every solver renders 16 of them.
    pub spp: Option<u32>,
    /// Longer side of the picture, pixels.
    pub size: u32,
    /// Blocks across and down.
    pub blocks: u32,
    /// Seed.
    pub seed: u64,
    /// Threads; all cores otherwise.
    pub threads: Option<usize>,
    /// Values for the file's `<default>` parameters.
    pub defines: Vec<(String, String)>,
    /// How strictly is judged.
    pub standard: Standard,
}

impl Default for VerifyOptions {
    fn default() -> Self {
        Self {
            solvers: None,
            time: Duration::from_secs(45),
            spp: None,
            size: 64,
            blocks: 4,
            seed: 0,
            threads: None,
            defines: Vec::new(),
            standard: Standard::default(),
        }
    }
}

/// Why nothing was verified.
#[derive(Debug)]
pub enum VerifyError {
    /// There is no scene.
    Load(LoadError),
    /// In words.
    Words(String),
    /// It was asked to stop.
    Cancelled,
}

/// One solver's part.
#[derive(Clone, Debug, Serialize)]
pub struct Effort {
    /// Its name.
    pub solver: String,
    /// Bounces at most, where not all light was compared.
    pub bounces: Option<u32>,
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
    /// Bounces at most; none is unbounded.
    pub bounces: Option<u32>,
    /// The verdict.
    pub verdict: Verdict,
    /// A difference was seen once, and not again in fresh replicates.
    pub seen_once: bool,
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
    /// Program and version.
    pub software: String,
    /// The scene.
    pub scene: String,
    /// Pixels.
    pub size: [u32; 2],
    /// Blocks across and down.
    pub blocks: [u32; 2],
    /// Seed.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
    /// How strictly was judged.
    pub standard: Standard,
    /// Comparisons in the family.
    pub tests: usize,
    /// The solvers' parts.
    pub solvers: Vec<Effort>,
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

/// Depths of the furnace: bounces at most, unbounded at last.
const DEPTHS: [Option<u32>; 5] = [Some(0), Some(1), Some(2), Some(4), None];
/// Albedo of the furnace.
const ALBEDO: f64 = 0.5;
/// Shares of the time: first measurements of the pairs and of the furnace; after the last one nothing more is begun.
const FIRST: f64 = 0.25;
const FURNACE: f64 = 0.12;
const LATEST: f64 = 0.9;
/// Replicates that are added at once where more are wanted.
const MORE: u32 = 4;

/// A pixel's samples are its own.
pub(crate) const BOX: Kernel = Kernel::Box { radius: 0.5 };

type Stopped<T> = Result<T, VerifyError>;

/// Verifies a scene. `tell` hears what is going on.
pub fn verify(scene: &str, options: &VerifyOptions, cancel: &CancelToken, tell: &dyn Fn(&str)) -> Stopped<Verification> {
    let begun = Instant::now();
    for name in options.solvers.iter().flatten() {
        check_solver_name(name).map_err(|e| VerifyError::Words(e.to_string()))?;
    }
    let loaded = load_small(scene, options)?;
    let oven = load_furnace(options)?;
    let pool = pool::pool(options.threads).map_err(|e| VerifyError::Words(e.to_string()))?;
    let trial = Trial { seed: options.seed, blocks: options.blocks, ..Trial::new(&loaded.scene, &pool, cancel) };
    let ovens = Trial { seed: options.seed ^ 0xf0, ..Trial::new(&oven.scene, &pool, cancel) };
    let (solvers, mut left_out) = chosen(options, &loaded.scene);

    // Those that estimate all light meet each other; those that estimate a part meet the best of these, on that part.
    let all = |s: &&AnySolver| s.estimates() == Estimates::Light;
    let parts: Vec<(&AnySolver, u32)> =
        solvers.iter().filter_map(|s| if let Estimates::LightUpTo(n) = s.estimates() { Some((s, n)) } else { None }).collect();
    let mut main = Panel::new(trial);
    let share = options.time.mul_f64(FIRST / (solvers.iter().filter(all).count() + 2 * parts.len()).max(1) as f64);
    for solver in solvers.iter().filter(all) {
        tell(&format!("rendering with {}", solver.name()));
        enter(&mut main, solver, options, share).ok_or(VerifyError::Cancelled)?;
    }
    let mut sides = Vec::new();
    for (solver, edges) in parts {
        let Some(partner) = best(&main).and_then(|name| solvers.iter().find(|s| s.name() == name)) else {
            left_out.push((solver.name().to_owned(), "no other solver is there to compare it with".to_owned()));
            continue;
        };
        tell(&format!("rendering with {}", solver.name()));
        let rules = PathRules { max_edges: trial.rules.max_edges.min(edges), null_counts: true, ..trial.rules };
        let mut side = Panel::new(Trial { rules, seed: trial.seed ^ 0xd1, ..trial });
        for s in [solver, partner] {
            enter(&mut side, s, options, share).ok_or(VerifyError::Cancelled)?;
        }
        sides.push((side, Some(edges - 1)));
    }

    // The family: everything that is compared.
    let furnace_depths = |s: &AnySolver| {
        let in_part = matches!(s.estimates(), Estimates::LightUpTo(_));
        DEPTHS.into_iter().filter(move |d| d.is_some() || !in_part)
    };
    let ovens_tests = solvers.iter().map(|s| furnace_depths(s).count()).sum::<usize>() * 3 * ovens.grid().len();
    let tests = main.tests() + sides.iter().map(|s| s.0.tests()).sum::<usize>() + ovens_tests;

    tell("holding the solvers to the furnace");
    let mut in_furnace = Vec::new();
    let share = options.time.mul_f64(FURNACE * 3.0 * ovens.grid().len() as f64 / ovens_tests.max(1) as f64);
    for solver in &solvers {
        for depth in furnace_depths(solver) {
            in_furnace.push(Oven::new(ovens, solver, depth, options, share).ok_or(VerifyError::Cancelled)?);
        }
    }

    // What is left of the time goes where it decides most: to what is nearest to being told.
    tell("comparing");
    let mut panels: Vec<(Panel<'_>, Option<u32>)> = std::iter::once((main, None)).chain(sides).collect();
    let mut found: Vec<Vec<Pair>> = panels.iter().map(|(p, _)| p.pairs(&options.standard, tests)).collect();
    let mut held: Vec<Agreement> = in_furnace.iter().map(|o| o.judge(&options.standard, tests)).collect();
    while options.spp.is_none() {
        let room = options.time.mul_f64(LATEST).saturating_sub(begun.elapsed());
        let Some(next) = nearest_verdict(&panels, &found, &in_furnace, &held, room) else { break };
        match next {
            Next::Candidate(i, candidate) => {
                panels[i].0.measure(candidate, MORE).ok_or(VerifyError::Cancelled)?;
                found[i] = panels[i].0.pairs(&options.standard, tests);
            }
            Next::Oven(i) => {
                in_furnace[i].measure(MORE).ok_or(VerifyError::Cancelled)?;
                held[i] = in_furnace[i].judge(&options.standard, tests);
            }
        }
    }

    // A difference must be there twice.
    let (mut pairs, mut efforts, mut furnace) = (Vec::new(), Vec::new(), Vec::new());
    for ((panel, bounces), mut found) in panels.into_iter().zip(found) {
        if found.iter().any(|p| p.verdict == Verdict::Fail) {
            tell("a difference: rendering anew, to see whether it is there again");
            panel.confirm(&mut found, &options.standard).ok_or(VerifyError::Cancelled)?;
        }
        for pair in found {
            let what = format!("{} / {}", panel.candidates[pair.a].name, panel.candidates[pair.b].name);
            pairs.push(comparison(what, bounces, pair.verdict, pair.seen_once, &pair.agreement));
        }
        efforts.extend(panel.candidates.iter().map(|c| effort(c, bounces)));
    }
    let failed = held.iter().filter(|h| h.verdict == Verdict::Fail).count();
    for (oven, held) in in_furnace.iter().zip(&held) {
        let seen_once = held.verdict == Verdict::Fail && {
            tell("a difference: rendering anew, to see whether it is there again");
            let again = oven.again(&options.standard, failed).ok_or(VerifyError::Cancelled)?;
            again.verdict != Verdict::Fail
        };
        let verdict = if seen_once { Verdict::Inconclusive } else { held.verdict };
        furnace.push(comparison(oven.name.clone(), oven.depth, verdict, seen_once, held));
    }

    let verdicts = pairs.iter().chain(&furnace).map(|c| c.verdict);
    let verdict = if pairs.is_empty() { Verdict::Inconclusive } else { Verdict::Pass };
    let grid = trial.grid();
    Ok(Verification {
        software: crate::render::software(),
        scene: loaded.name.clone(),
        size: grid.size,
        blocks: grid.blocks,
        seed: options.seed,
        threads: pool.current_num_threads(),
        standard: options.standard,
        tests,
        solvers: efforts,
        left_out,
        verdict: verdicts.fold(verdict, Verdict::max),
        pairs,
        furnace,
        seconds: begun.elapsed().as_secs_f64(),
    })
}

/// The scene at a size whose longer side is at most `options.size`, with pixels that share no samples: a filter that is divided by the sum of
/// its weights is unbiased only in the limit of many samples, and light tracers divide by no such sum.
fn load_small(scene: &str, options: &VerifyOptions) -> Stopped<Loaded> {
    let mut loaded = load_at_size(scene, options)?;
    loaded.scene.views.iter_mut().for_each(|v| v.film.filter = BOX);
    Ok(loaded)
}

fn load_at_size(scene: &str, options: &VerifyOptions) -> Stopped<Loaded> {
    let at = |width: Option<u32>, height: Option<u32>| {
        let load_options = LoadOptions { defines: options.defines.clone(), width, height, threads: options.threads };
        load(scene, &load_options).map_err(VerifyError::Load)
    };
    let loaded = at(None, None)?;
    let Some(view) = loaded.scene.views.first() else {
        return Err(VerifyError::Words("the scene has no sensor".to_owned()));
    };
    let [w, h] = view.film.size;
    let scale = f64::from(options.size) / f64::from(w.max(h));
    if scale >= 1.0 {
        return Ok(loaded);
    }
    let small = |n: u32| Some(((f64::from(n) * scale).round() as u32).max(1));
    at(small(w), small(h))
}

fn load_furnace(options: &VerifyOptions) -> Stopped<Loaded> {
    let defines = vec![("albedo".to_owned(), ALBEDO.to_string())];
    let load_options = LoadOptions { defines, width: Some(16), height: Some(16), threads: options.threads };
    load("furnace", &load_options).map_err(VerifyError::Load)
}

/// The solvers that take part, and those that do not, with the reason.
fn chosen(options: &VerifyOptions, scene: &Scene) -> (Vec<AnySolver>, Vec<(String, String)>) {
    let names: Vec<&str> = match &options.solvers {
        Some(names) => names.iter().map(String::as_str).collect(),
        None => SOLVERS.iter().map(|s| s.name).collect(),
    };
    let (mut solvers, mut left_out) = (Vec::new(), Vec::new());
    for name in names {
        let Some(solver) = AnySolver::new(name, &scene.integrator) else {
            left_out.push((name.to_owned(), "it is not there yet".to_owned()));
            continue;
        };
        let reason = match (solver.needs().check(scene), solver.estimates()) {
            (Err(refusal), _) => refusal.reason,
            (_, Estimates::InTheLimit) => {
                "biased at any sample count: held to its rate of convergence, not to agreement".to_owned()
            }
            (_, Estimates::Other(words)) => format!("it estimates other light: {words}"),
            (_, Estimates::Light | Estimates::LightUpTo(_)) => {
                solvers.push(solver);
                continue;
            }
        };
        left_out.push((name.to_owned(), reason));
    }
    (solvers, left_out)
}

/// The renderer of a solver from the list.
pub(crate) fn renderer<'a>(solver: &'a AnySolver, scene: &'a Scene) -> Box<Renderer<'a>> {
    Box::new(move |run, film| solver.render(scene, run, film, None))
}

fn enter<'a>(panel: &mut Panel<'a>, solver: &'a AnySolver, options: &VerifyOptions, share: Duration) -> Option<()> {
    let render = renderer(solver, panel.trial.scene);
    let spp = match options.spp {
        Some(spp) => spp,
        None => panel.trial.samples_in(&*render, share, REPLICATES)?,
    };
    panel.enter(solver.name(), render, spp);
    panel.measure(panel.candidates.len() - 1, REPLICATES)
}

/// The candidate whose picture's mean is known best.
fn best<'p>(panel: &'p Panel<'_>) -> Option<&'p str> {
    let error = |c: &&Candidate<'_>| effort(c, None).picture_error;
    panel.candidates.iter().min_by(|a, b| error(a).total_cmp(&error(b))).map(|c| c.name.as_str())
}

/// Where more replicates are wanted.
enum Next {
    /// Of this candidate of this panel.
    Candidate(usize, usize),
    /// In this oven.
    Oven(usize),
}

/// The comparison that needs the least time to be told, if intervals shrink with its root. None where all is told, or where the time that is
/// left holds no more replicates.
fn nearest_verdict(
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

/// A solver in the furnace, at one depth.
struct Oven<'a> {
    name: String,
    depth: Option<u32>,
    trial: Trial<'a>,
    render: Box<Renderer<'a>>,
    spp: u32,
    stream: u64,
    known: Vec<[f64; 3]>,
    sample: Sample,
    elapsed: Duration,
}

impl<'a> Oven<'a> {
    /// With its first replicates.
    fn new(trial: Trial<'a>, solver: &'a AnySolver, depth: Option<u32>, options: &VerifyOptions, share: Duration) -> Option<Self> {
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

    fn measure(&mut self, count: u32) -> Option<()> {
        for _ in 0..count {
            let shot = self.trial.replicate(&*self.render, self.spp, self.stream, self.sample.count() as u32)?;
            self.sample.add(&shot.pixels);
            self.elapsed += shot.elapsed;
        }
        Some(())
    }

    fn judge(&self, standard: &Standard, tests: usize) -> Agreement {
        judge(&self.sample, Expected::Known(&self.known), standard, tests)
    }

    /// The same by fresh replicates, as one of `failed` that are looked at again.
    fn again(&self, standard: &Standard, failed: usize) -> Option<Agreement> {
        let fresh = self.trial.sample(&*self.render, self.spp, self.sample.count() as u32, self.stream + (1 << 32))?;
        Some(judge(&fresh, Expected::Known(&self.known), standard, failed * 3 * self.trial.grid().len()))
    }
}

fn comparison(what: String, bounces: Option<u32>, verdict: Verdict, seen_once: bool, found: &Agreement) -> Comparison {
    Comparison {
        what,
        bounces,
        verdict,
        seen_once,
        tests: found.findings.len(),
        worst: found.worst,
        blindest: found.blindest,
        visible_picture: found.visible_picture,
        visible_block: found.visible_block,
    }
}

fn effort(c: &Candidate<'_>, bounces: Option<u32>) -> Effort {
    let areas = c.sample.areas();
    let relative = |m: &Moments, least: f64| m.standard_error() / m.mean.abs().max(least).max(1e-30);
    let picture_error = areas[0].iter().map(|m| relative(m, 0.0)).fold(0.0, f64::max);
    let mut blocks: Vec<f64> =
        areas[1..].iter().flat_map(|a| (0..3).map(|i| relative(&a[i], 0.5 * areas[0][i].mean.abs()))).collect();
    blocks.sort_by(f64::total_cmp);
    Effort {
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
