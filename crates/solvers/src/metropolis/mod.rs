//! Metropolis light transport in primary sample space, over all strategies of bidirectional path tracing [Kelemen et al. 2002; multiplexed: Hachisuka,
//! Kaplanyan, Dachsbacher 2014].
//!
//! ```text
//! I_j = ∫ h_j(u) du,    h_j(u) = n_s w_{s,t} C_{s,t}(u)          u ∈ [0, 1)^∞, with s one of the n_s strategies, chosen by u
//! I_j ≈ b/N Σ_i [ (1 - a_i) h_j(x_i)/f(x_i) + a_i h_j(y_i)/f(y_i) ]    a = min(1, f(y)/f(x)),    f = Σ_j h_j,    b = ∫ f du
//! ```
//!
//! A chain proposes at each step a path y near its path x, or a wholly new one, and goes there with probability a: it visits paths in proportion to the
//! light that they carry. Once it has found the gap of a door, it stays there for a while.
//!
//! | what | how |
//! | --- | --- |
//! | f | the mean of a contribution's three channels ([`space`]) |
//! | numbers of edges | each chain keeps to one, n; all beyond 10 are one class, of 11 edges and a geometric number more ([`lengths`]) |
//! | mutation | all numbers together, by ±`largest`·e^(-ξ ln(`largest`/`smallest`)), around the ends of [0, 1) [Kelemen et al. 2002, §3.1]; or all anew ([`mutation`]) |
//! | b | the mean of f over `bootstrap` paths of each length, from which the chains' first paths are drawn in proportion to f ([`bootstrap`]) |
//! | start-up bias | none: first paths drawn in proportion from the same paths that measured b make the estimate right at any number of steps [Veach 1997, §11.3.1] |
//! | renewal | every `renewal` mutations a pixel the chains begin anew from other `bootstrap` paths, so that b has no error that more mutations would not cure |
//! | direct light | paths of up to `direct` edges are left to [`crate::path_mis`], a path for each pixel and pass |
//! | replicates | with a noise target each replicate has its own bootstrap and its own chains |
//!
//! Every chain begins by replaying its first path from the numbers that it keeps; where that does not give the same f to the bit, the path is not a
//! function of these numbers, nothing that follows can be trusted, and the render ends with what it has ([`CannotGoOn`]).
//!
//! A pass makes as many mutations as the film has pixels, shared among the chains. Their number is a parameter, never that of the threads.
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `chains` | chains that run side by side | 512 |
//! | `bootstrap` | paths of each length that b is measured by, at most; no more, over all lengths, than a quarter of the mutations that follow | 16384 |
//! | `large_step` | probability of a wholly new path | 0.3 |
//! | `smallest`, `largest` | how far a number moves, of its range | 1/1024, 1/16 |
//! | `direct` | up to how many edges are left to path tracing: 0 to 2 | 2 |
//! | `renewal` | passes of the same chains | 64 |

pub mod bootstrap;
pub mod chain;
pub mod lengths;
pub mod mutation;
pub mod space;

use crate::drivers::Work;
use crate::drivers::pixels::{self, SamplePlan, Tiling};
use crate::parameters::{Parameter, Slot};
use crate::path_mis::PathMis;
use crate::run::Run;
use crate::solver::{CannotGoOn, Needs, Solver};
use crate::transport::PathRules;
use bootstrap::{Chains, Launch, ReplayDiffers};
use chain::Output;
use etendue_film::Replicates;
use etendue_numerics::sequence::mix;
use etendue_scene::Scene;
use mutation::Mutation;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use space::{Measured, Scratch, Space};
use std::sync::PoisonError;
use std::sync::atomic::Ordering;

/// Paths of each length that chains begin with at least, unless fewer are asked for.
const LEAST: u32 = 256;
/// Chains of a unit of work.
const GROUP: usize = 8;

/// The solver `metropolis`.
#[derive(Clone, Copy, Debug)]
pub struct Metropolis {
    /// Chains that run side by side.
    pub chains: u32,
    /// Paths of each length by which the chains begin.
    pub bootstrap: u32,
    /// How chains move.
    pub mutation: Mutation,
    /// Paths of so many edges or fewer are left to path tracing.
    pub direct: u32,
    /// Passes of the same chains.
    pub renewal: u32,
}

impl Default for Metropolis {
    fn default() -> Self {
        Self { chains: 512, bootstrap: 16384, mutation: Mutation::default(), direct: 2, renewal: 64 }
    }
}

/// The chains of each replicate; one without a noise target.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct State(Vec<Chains>);

impl Metropolis {
    /// What users may set.
    pub const PARAMETERS: &[Parameter<Self>] = &[
        Parameter { name: "chains", summary: "chains that run side by side", slot: |s| Slot::Count(&mut s.chains, 1..=65536) },
        Parameter {
            name: "bootstrap",
            summary: "paths of each length, at most, that measure the brightness and begin the chains",
            slot: |s| Slot::Count(&mut s.bootstrap, 1..=1 << 24),
        },
        Parameter {
            name: "large_step",
            summary: "probability of a wholly new path",
            slot: |s| Slot::Number(&mut s.mutation.large_step, 0.01..=1.0),
        },
        Parameter {
            name: "smallest",
            summary: "smallest change of a number, of its range",
            slot: |s| Slot::Number(&mut s.mutation.smallest, 1e-6..=0.5),
        },
        Parameter {
            name: "largest",
            summary: "largest change of a number, of its range",
            slot: |s| Slot::Number(&mut s.mutation.largest, 1e-6..=0.5),
        },
        Parameter {
            name: "direct",
            summary: "paths of so many edges or fewer are left to path tracing",
            slot: |s| Slot::Count(&mut s.direct, 0..=2),
        },
        Parameter {
            name: "renewal",
            summary: "passes after which the chains begin anew",
            slot: |s| Slot::Count(&mut s.renewal, 1..=1 << 20),
        },
    ];

    /// The rules for what chains look for; `None` where nothing is left to them.
    fn chained(&self, rules: PathRules) -> Option<PathRules> {
        let rules = PathRules { min_edges: rules.min_edges.max(self.direct + 1), rr_depth: Some(u32::MAX), ..rules };
        (rules.min_edges <= rules.max_edges).then_some(rules)
    }

    /// The rules for what path tracing looks for; `None` where nothing is left to it.
    fn traced(&self, rules: PathRules) -> Option<PathRules> {
        let rules = PathRules { max_edges: rules.max_edges.min(self.direct), ..rules };
        (rules.min_edges <= rules.max_edges).then_some(rules)
    }

    /// The chains that pass `plan` goes on with: those of the last pass, or new ones; a pass makes so many mutations.
    fn chains<'s, 'a>(
        &self,
        space: &Space<'a>,
        plan: &SamplePlan,
        mutations: u64,
        state: &'s mut State,
        work: &Work<'_>,
    ) -> Result<&'s mut Chains, ReplayDiffers> {
        if state.0.len() <= plan.replicate {
            state.0.resize_with(plan.replicate + 1, Chains::default);
        }
        let chains = &mut state.0[plan.replicate];
        let age = plan.sample / self.renewal + 1;
        if chains.age != age {
            let seed = mix(plan.seed ^ mix(u64::from(age) ^ 0x6d65_7472_6f70));
            let lengths = space.lengths();
            let passes = u64::from(self.renewal.min(plan.count));
            let in_proportion = passes * mutations / (4 * lengths.len().max(1) as u64);
            let paths = u64::from(self.bootstrap).min(in_proportion.max(u64::from(LEAST))) as u32;
            let launch = Launch { lengths, seed, paths, chains: self.chains };
            let measure = |at: &space::Point<'_>, out: &mut Measured, scratch: &mut Scratch<'a>| space.measure(at, out, scratch);
            *chains = launch.run(age, &measure, &work.progress.rays)?;
        }
        Ok(chains)
    }
}

impl Solver for Metropolis {
    type State = State;

    fn needs(&self) -> Needs {
        Needs { both_ways: true, ..Needs::default() }
    }

    fn splats(&self) -> bool {
        true
    }

    fn units(&self, size: [u32; 2]) -> usize {
        Tiling::new(size).len() + (self.chains as usize).div_ceil(GROUP)
    }

    fn prepare(&self, _: &Scene, _: &Run<'_>) -> State {
        State::default()
    }

    fn pass(&self, scene: &Scene, run: &Run<'_>, state: &mut State, k: u32, work: &Work<'_>) -> Result<(), CannotGoOn> {
        let film = &scene.views[run.view].film;
        let tiles = Tiling::new(film.crop_size).len();
        let plan = SamplePlan::new(run, k);
        match self.traced(run.rules) {
            Some(rules) => pixels::pass_over(&PathMis::default(), scene, run, rules, &plan, 0..tiles, work),
            None => (0..tiles).for_each(|unit| work.units.done(unit)),
        }
        if (work.stop_now)() {
            return Ok(());
        }
        let Some(rules) = self.chained(run.rules) else {
            (tiles..work.units.len()).for_each(|unit| work.units.done(unit));
            return Ok(());
        };

        let space = Space::new(scene, run, rules);
        let mutations = u64::from(film.crop_size[0]) * u64::from(film.crop_size[1]);
        let Chains { chains, brightness, .. } = self.chains(&space, &plan, mutations, state, work).map_err(CannotGoOn::Replay)?;
        let (count, brightness) = (chains.len() as u64, *brightness);
        let first_of = |i: usize| i as u64 * mutations / count.max(1);
        chains.par_chunks_mut(GROUP).enumerate().for_each_init(
            || (Scratch::default(), Output::default()),
            |(scratch, out), (group, chains)| {
                let unit = tiles + group;
                if work.units.is_done(unit) || (work.stop_now)() {
                    return;
                }
                let first = group * GROUP;
                for (i, chain) in (first..).zip(chains.iter_mut()) {
                    chain.run(first_of(i + 1) - first_of(i), &space, &self.mutation, brightness, scratch, out);
                }
                let started = first_of(first + chains.len()) - first_of(first);
                work.film.add_splats(&out.splats);
                work.film.start_particles(started);
                track(out, plan.replicate, mutations, work);
                out.splats.clear();
                work.units.done(unit);
                work.progress.tiles.fetch_add(1, Ordering::Relaxed);
                work.progress.rays.fetch_add(scratch.take_rays(), Ordering::Relaxed);
                work.progress.paths.fetch_add(started, Ordering::Relaxed);
            },
        );
        // No light, no chains.
        let left = if count == 0 { tiles..work.units.len() } else { 0..0 };
        left.for_each(|unit| work.units.done(unit));
        Ok(())
    }
}

/// Notes the splats by pixel, in noise mode.
fn track(out: &Output, replicate: usize, mutations: u64, work: &Work<'_>) {
    let Some(replicates) = work.replicates else { return };
    let mut sums = replicates.lock().unwrap_or_else(PoisonError::into_inner);
    let add = |sums: &mut Replicates, splat: &etendue_film::Splat| {
        let pixel = [splat.position.x as u32, splat.position.y as u32];
        if let Some(slot) = sums.slot(pixel) {
            sums.add(replicate, slot, (splat.value / mutations as f32).to_rgb());
        }
    };
    out.splats.iter().for_each(|splat| add(&mut sums, splat));
}
