//! Which solver for a scene: a trial of a few thousand bidirectional paths tells how well each family of strategies would find what was found.
//!
//! A strategy i draws the path x with the density p_i(x). Walks from both ends, weighed by the balance heuristic, find x with P = Σ p_i in all and bring
//! h = f/P each time. A solver that has only the strategies of a set A would find it with p_A = Σ_{i ∈ A} p_i, so
//!
//! ```text
//! E[X_A²] = ∫ f²/p_A dx ≈ 1/N Σ_found h² / w_A,    w_A = p_A / P = Σ_{i ∈ A} w_i           of each block of the picture
//! cost_A = (E[X_A²] - E[X]²) / (E[X]² + e) · (time a sample)                                  mean over blocks, e = 0.01 · (picture's mean)²
//! ```
//!
//! Nothing of the other solvers is run, and light that they would hardly ever find is not overlooked for that: it is known from the strategies that do find it.
//! The trial is a function of scene and rules alone.
//!
//! | solver | A | time a sample, of `path-mis` |
//! | --- | --- | --- |
//! | `path-mis` | s = 0, 1 | 1 |
//! | `light-nee` | t = 1, and s = 0 of what is seen directly | 2 |
//! | `bidirectional` | all | 4 |
//!
//! What no strategy finds is asked for by itself: light that glass or mirrors focus on a surface which is seen in glass or mirrors again. Where a good part of the
//! picture is of that kind, and walks from the eye practically never hit a lamp in mirrors, only a photon map is left, although it is biased.

use crate::bidirectional::literal::Whole;
use crate::bidirectional::{Bidirectional, PathVertex, Paths};
use crate::drivers::pixels::eye_walk;
use crate::solver::{AnySolver, SOLVERS};
use crate::transport::{PathRules, slot};
use etendue_numerics::{Dim, Sampler, SequenceKind, Vec2};
use etendue_scene::Scene;

/// Paths of the trial from either end.
const PATHS: u32 = 8192;
/// Blocks across and down.
const BLOCKS: usize = 4;
/// A solver must be better than `path-mis` by this factor to be taken instead: the trial is short.
const BETTER: f64 = 1.25;
/// Light that a set of strategies may miss.
const MISSED: f64 = 1e-3;
/// The part of the picture that must be light from mirrors seen in mirrors for a biased solver to be taken.
const HIDDEN: f64 = 0.02;
/// How often walks hit lamps in mirrors, at most, for that.
const HIT: f64 = 0.005;

/// A ratio in words.
fn times(x: f64) -> String {
    if x < 10.0 { format!("{x:.1}") } else { format!("{x:.0}") }
}

/// A choice.
#[derive(Clone, Debug, PartialEq)]
pub struct Advice {
    /// The solver.
    pub solver: &'static str,
    /// Why, in words that complete "because …".
    pub reason: String,
}

/// A solver that may be taken.
struct Candidate {
    solver: &'static str,
    /// Time a sample, of path-mis.
    time: f64,
    /// Whether strategy s of `vertices` in all is one of its own.
    has: fn(s: usize, vertices: usize) -> bool,
}

const CANDIDATES: [Candidate; 3] = [
    Candidate { solver: "path-mis", time: 1.0, has: |s, _| s <= 1 },
    Candidate { solver: "light-nee", time: 2.0, has: |s, vertices| s + 1 == vertices || vertices == 2 },
    Candidate { solver: "bidirectional", time: 4.0, has: |_, _| true },
];

/// What the trial found.
#[derive(Clone, Debug, Default)]
struct Trial {
    /// Σ h by block.
    light: [f64; BLOCKS * BLOCKS],
    /// Σ h²/w_A by candidate and block.
    squares: [[f64; BLOCKS * BLOCKS]; CANDIDATES.len()],
    /// Σ h of what a candidate cannot find.
    missed: [f64; CANDIDATES.len()],
    /// Σ h w of the strategies with s ≥ 2.
    from_lights: f64,
    /// Eye paths that saw a surface by mirrors alone, and all that saw one.
    seen_in_mirrors: [u32; 2],
    /// Flux that came to a surface by mirrors alone, and all that came to one.
    focused: [f64; 2],
    /// Walks that went from a surface into mirrors alone and hit a lamp, and all that went there.
    lucky: [u32; 2],
}

/// The solver for a view of a scene, where `rules` say which paths count.
pub fn advise(scene: &Scene, view: usize, rules: PathRules) -> Advice {
    let trial = Trial::of(scene, view, rules);
    let can = |name: &str| {
        SOLVERS.iter().any(|s| s.name == name)
            && AnySolver::new(name, &scene.integrator).is_some_and(|s| s.needs().check(scene).is_ok())
    };
    if let Some(advice) = trial.hidden(can("photon-map")) {
        return advice;
    }
    trial.best(&|name| can(name))
}

impl Trial {
    fn of(scene: &Scene, view: usize, rules: PathRules) -> Self {
        let all = Bidirectional { exponent: 1 }.strategies_of(scene, view, rules);
        let film = &all.view.film;
        let [corner, size] = [film.crop_offset, film.crop_size].map(|[x, y]| Vec2::new(x as f32, y as f32));
        let pixels = f64::from(size.x) * f64::from(size.y);
        let (mut trial, mut paths) = (Self::default(), Paths::default());
        for i in 0..PATHS {
            let u = Sampler::new(SequenceKind::Sobol, 0, 0, i, PATHS);
            let place = u.u2(Dim::at(0, slot::PIXEL)) * size;
            let eye = eye_walk(&all.c, view, corner + place, &u);
            all.sample(eye, &u, &mut paths, &mut |found, light, vertices| {
                let (at, scale) = found.pixel.map_or((place, pixels), |p| (p - corner, 1.0));
                let h = f64::from((found.value * found.weight).luminance()) * scale;
                let block = (at / size * BLOCKS as f32).min(Vec2::splat(BLOCKS as f32 - 1.0));
                if let Some(whole) = Whole::of(&all, found, light, vertices).filter(|_| h.is_finite()) {
                    trial.add(block.y as usize * BLOCKS + block.x as usize, h, &whole.weights(&all), found.s);
                }
            });
            trial.look_at_mirrors(scene, &paths);
        }
        trial
    }

    /// Notes a path of the weights w.
    fn add(&mut self, block: usize, h: f64, w: &[f64], s: u32) {
        self.light[block] += h;
        self.from_lights += if s >= 2 { h } else { 0.0 };
        for (i, candidate) in CANDIDATES.iter().enumerate() {
            let own: f64 = (0..w.len()).filter(|s| (candidate.has)(*s, w.len())).map(|s| w[s]).sum();
            if own > 0.0 {
                self.squares[i][block] += h * h / own;
            } else {
                self.missed[i] += h;
            }
        }
    }

    /// Notes what mirrors did to the walks.
    fn look_at_mirrors(&mut self, scene: &Scene, paths: &Paths) {
        // The first surface that scatters into more than a discrete few directions, and whether the walk came there by mirrors.
        let first = |walk: &[PathVertex]| {
            let i = walk.iter().position(|v| !v.is_dirac && v.vertex.is_smooth())?;
            Some((i, walk[..i].iter().any(|v| v.is_dirac)))
        };
        if let Some((i, by_mirrors)) = first(&paths.eye) {
            self.seen_in_mirrors[0] += u32::from(by_mirrors);
            self.seen_in_mirrors[1] += 1;
            let behind = &paths.eye[i + 1..];
            if behind.first().is_some_and(|v| v.is_dirac) {
                let hits_lamp = match behind.iter().find(|v| !v.is_dirac) {
                    Some(v) => scene.surface(v.vertex.x.surface).emitter.is_some(),
                    None => !scene.lights.environments().is_empty(),
                };
                self.lucky[0] += u32::from(hits_lamp);
                self.lucky[1] += 1;
            }
        }
        if let Some((i, by_mirrors)) = first(&paths.light.vertices) {
            let flux = f64::from(paths.light.vertices[i].beta.luminance());
            self.focused[0] += if by_mirrors { flux } else { 0.0 };
            self.focused[1] += flux;
        }
    }

    /// A photon map, where light from mirrors is seen in mirrors.
    fn hidden(&self, there_is_one: bool) -> Option<Advice> {
        let share = |[part, all]: [f64; 2]| part / all.max(f64::MIN_POSITIVE);
        let seen = share(self.seen_in_mirrors.map(f64::from));
        let (focused, lucky) = (share(self.focused), share(self.lucky.map(f64::from)));
        (there_is_one && seen * focused > HIDDEN && lucky < HIT).then(|| Advice {
            solver: "photon-map",
            reason: format!(
                "{:.0} % of the picture is seen in mirrors or through glass, {:.0} % of the light comes by them, and walks from the eye practically never hit a \
                 lamp that way: no unbiased solver finds that light; a photon map does, with a bias that falls with the number of iterations",
                100.0 * seen,
                100.0 * focused
            ),
        })
    }

    /// The cheapest candidate that finds all light.
    fn best(&self, can: &dyn Fn(&str) -> bool) -> Advice {
        let total: f64 = self.light.iter().sum();
        if total <= 0.0 {
            return Advice { solver: "path-mis", reason: "a short trial found no light at all: it is the default".to_owned() };
        }
        let costs: Vec<f64> = (0..CANDIDATES.len()).map(|i| self.cost(i)).collect();
        let usable = |i: usize| (can(CANDIDATES[i].solver) && self.missed[i] <= MISSED * total).then_some(costs[i]);
        let best = (0..CANDIDATES.len()).filter_map(|i| Some((i, usable(i)?))).min_by(|a, b| a.1.total_cmp(&b.1));
        let found = 100.0 * self.from_lights / total;
        match best {
            Some((i, cost)) if i > 0 && usable(0).is_none_or(|default| default > BETTER * cost) => {
                let gain = match usable(0) {
                    Some(default) => format!("a trial expects {} times the efficiency of path-mis", times(default / cost)),
                    None => format!("path-mis would miss {:.1} % of the light", 100.0 * self.missed[0] / total),
                };
                Advice {
                    solver: CANDIDATES[i].solver,
                    reason: format!("{gain}; {found:.0} % of the light is found best from the lights"),
                }
            }
            _ => {
                let others = costs[0] / costs[2];
                Advice {
                    solver: "path-mis",
                    reason: format!(
                        "walks from the eye find the light: a trial expects {} times their efficiency of walks from both ends",
                        times(others)
                    ),
                }
            }
        }
    }

    /// The mean over blocks of the variance of a sample, relative to the squared light there, times the time that it takes.
    fn cost(&self, candidate: usize) -> f64 {
        let n = f64::from(PATHS);
        let blocks = (BLOCKS * BLOCKS) as f64;
        // Light of a block if all paths fell there.
        let mean = |b: usize| self.light[b] / n * blocks;
        let e = 0.01 * ((0..self.light.len()).map(mean).sum::<f64>() / blocks).powi(2);
        let relative = |b: usize| {
            let square = self.squares[candidate][b] / n * blocks;
            (square - mean(b).powi(2)).max(0.0) / (mean(b).powi(2) + e)
        };
        CANDIDATES[candidate].time * (0..self.light.len()).map(relative).sum::<f64>() / blocks
    }
}
