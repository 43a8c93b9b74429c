//! Which solver for a scene: a trial of a few thousand bidirectional paths tells how well each family of strategies would find what was found.
//!
//! A strategy i draws the path x with the density p_i(x). Walks from both ends, weighed by the balance heuristic, find x with P = Σ p_i in all and bring
//! h = f/P each time. A solver that has only the strategies of a set A would find it with p_A = Σ_{i ∈ A} p_i, so
//!
//! ```text
//! σ_A² = Σ_n [ ∫ f²/p_A dx - Σ_{i ∈ A} I_i² ] ≈ Σ_n [ 1/N Σ_found h²/w_A - Σ_{i ∈ A} (1/N Σ_found h w_i/w_A)² ],    w_A = p_A / P = Σ_{i ∈ A} w_i
//! cost_A = σ_A² / (I² + e) · (time a sample)                    mean over blocks of the picture, e = 0.01 · (picture's mean)²
//! ```
//!
//! I_i is what strategy i of the set brings; the sum over n is that over lengths of paths. (Emitters seen directly are no noise and left out.)
//!
//! Nothing of the other solvers is run, and light that they would hardly ever find is not overlooked for that: it is known from the strategies that do find it.
//! The trial is a function of scene and rules alone.
//!
//! | solver | A | time a sample: rays, times the time a ray takes |
//! | --- | --- | --- |
//! | `path-mis` | s = 0, 1 | of the eye's walk, with one to a light from each vertex; 1 |
//! | `light-nee` | t = 1, and what is seen directly | of the light's walk, with one to the lens from each vertex; 1.6 |
//! | `bidirectional` | all | all; 2 |
//!
//! What no strategy finds is asked for by itself: light that glass or mirrors focus on a surface which is seen in glass or mirrors again. A coarse density estimate,
//! from where both walks first met such a surface by mirrors alone, tells how much of the picture that is. If it is much, and walks from the eye practically never hit a
//! lamp in mirrors, only a photon map is left, although it is biased.

use crate::bidirectional::literal::Whole;
use crate::bidirectional::{Bidirectional, PathVertex, Paths};
use crate::drivers::pixels::eye_walk;
use crate::solver::{AnySolver, SOLVERS};
use crate::transport::{PathRules, PathState, slot};
use etendue_numerics::{Dim, Sampler, SequenceKind, Vec2, Wavelengths};
use etendue_scene::{EmitterId, Scene};
use std::collections::BTreeMap;

/// Paths of the trial from either end.
const PATHS: u32 = 8192;
/// Blocks across and down.
const BLOCKS: usize = 4;
/// A solver must be better than `path-mis` by this factor to be taken instead: the trial is short.
const BETTER: f64 = 1.25;
/// Light that a set of strategies may miss.
const MISSED: f64 = 1e-3;
/// The part of the picture's light that must be of mirrors and seen in mirrors for a biased solver to be taken.
const HIDDEN: f64 = 0.005;
/// Radius of its density estimate, of the scene's.
const AROUND: f32 = 0.02;
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
    /// Time a ray, of that of path-mis.
    time: f64,
    /// Whether strategy s of `vertices` in all is one of its own.
    has: fn(s: usize, vertices: usize) -> bool,
}

const CANDIDATES: [Candidate; 3] = [
    Candidate { solver: "path-mis", time: 1.0, has: |s, _| s <= 1 },
    Candidate { solver: "light-nee", time: 1.6, has: |s, vertices| s + 1 == vertices || vertices == 2 },
    Candidate { solver: "bidirectional", time: 2.0, has: |_, _| true },
];

/// What the trial found.
#[derive(Clone, Debug, Default)]
struct Trial<'a> {
    /// Pixels of the picture.
    pixels: f64,
    /// Σ h by block.
    light: [f64; BLOCKS * BLOCKS],
    /// By candidate and block.
    noise: [[Noise; BLOCKS * BLOCKS]; CANDIDATES.len()],
    /// Rays by candidate.
    rays: [u64; CANDIDATES.len()],
    /// Σ h of what a candidate cannot find.
    missed: [f64; CANDIDATES.len()],
    /// Σ h w of the strategies with s ≥ 2.
    from_lights: f64,
    /// Surfaces that eye walks met first by mirrors alone.
    seen: Vec<PathVertex<'a>>,
    /// Surfaces to which light came first by mirrors alone, and the lamp that it came from.
    focused: Vec<(EmitterId, PathVertex<'a>)>,
    /// Walks that went from a surface into mirrors alone.
    tries: u32,
    /// Those of them that hit a lamp.
    hits: BTreeMap<EmitterId, u32>,
}

/// What a candidate's variance is made of.
#[derive(Clone, Debug, Default)]
struct Noise {
    /// Σ h²/w_A.
    squares: f64,
    /// Σ h w_i/w_A by vertices and strategy.
    means: BTreeMap<(usize, usize), f64>,
}

/// The solver for a view of a scene, where `rules` say which paths count.
pub fn advise(scene: &Scene, view: usize, rules: PathRules) -> Advice {
    let trial = Trial::of(scene, view, rules);
    let can = |name: &str| {
        SOLVERS.iter().any(|s| s.name == name)
            && AnySolver::new(name, &scene.integrator).is_some_and(|s| s.needs().check(scene).is_ok() && s.refuses(scene).is_none())
    };
    if let Some(advice) = trial.hidden(scene, can("photon-map")) {
        return advice;
    }
    trial.best(&|name| can(name))
}

impl<'a> Trial<'a> {
    fn of(scene: &'a Scene, view: usize, rules: PathRules) -> Self {
        let all = Bidirectional { exponent: 1, ..Bidirectional::default() }.strategies_of(scene, view, rules);
        let film = &all.view.film;
        let [corner, size] = [film.crop_offset, film.crop_size].map(|[x, y]| Vec2::new(x as f32, y as f32));
        let pixels = f64::from(size.x) * f64::from(size.y);
        let (mut trial, mut paths) = (Self::default(), Paths::default());
        for i in 0..PATHS {
            let u = Sampler::new(SequenceKind::Sobol, 0, 0, i, PATHS);
            let place = u.u2(Dim::at(0, slot::PIXEL)) * size;
            // Red, green and blue tell enough, whatever walks will carry.
            let eye = PathState { wl: Wavelengths::Rgb, ..eye_walk(&all.c, view, corner + place, &u) };
            all.sample(eye, &u, &mut paths, &mut |found, light, vertices| {
                let (at, scale) = found.pixel.map_or((place, pixels), |p| (p - corner, 1.0));
                let h = f64::from((found.value * found.weight).luminance()) * scale;
                let block = (at / size * BLOCKS as f32).min(Vec2::splat(BLOCKS as f32 - 1.0));
                if let Some(whole) = Whole::of(&all, found, light, vertices).filter(|_| h.is_finite()) {
                    trial.add(block.y as usize * BLOCKS + block.x as usize, h, &whole.weights(&all), found.s);
                }
            });
            trial.count(&paths);
            trial.look_at_mirrors(scene, &paths);
        }
        (trial.pixels, trial.rays[2]) = (pixels, paths.rays);
        trial
    }

    /// Notes a path of the weights w.
    fn add(&mut self, block: usize, h: f64, w: &[f64], s: u32) {
        self.light[block] += h;
        self.from_lights += if s >= 2 { h } else { 0.0 };
        for (i, candidate) in CANDIDATES.iter().enumerate() {
            let own = || (0..w.len()).filter(|s| (candidate.has)(*s, w.len()));
            let sum: f64 = own().map(|s| w[s]).sum();
            // A path that was found and is said to have no density is beyond the range of numbers.
            if sum.is_nan() {
                continue;
            }
            if sum <= 0.0 {
                self.missed[i] += h;
            } else if w.len() > 2 {
                let noise = &mut self.noise[i][block];
                noise.squares += h * h / sum;
                own().for_each(|s| *noise.means.entry((w.len(), s)).or_default() += h * w[s] / sum);
            }
        }
    }

    /// Counts the rays of either walk.
    fn count(&mut self, paths: &Paths) {
        let rays = |walk: &[PathVertex]| walk.iter().map(|v| 1 + u64::from(v.vertex.is_smooth())).sum::<u64>();
        self.rays[0] += 1 + rays(&paths.eye);
        self.rays[1] += 1 + rays(&paths.light.vertices);
    }

    /// Notes what mirrors did to the walks.
    fn look_at_mirrors(&mut self, scene: &Scene, paths: &Paths<'a>) {
        // The first surface that scatters into more than a discrete few directions, and whether the walk came there by mirrors.
        let first = |walk: &[PathVertex]| {
            let i = walk.iter().position(|v| !v.is_dirac && v.vertex.is_smooth())?;
            Some((i, walk[..i].iter().any(|v| v.is_dirac)))
        };
        if let Some((i, by_mirrors)) = first(&paths.eye) {
            if by_mirrors {
                self.seen.push(paths.eye[i]);
            }
            let behind = &paths.eye[i + 1..];
            if behind.first().is_some_and(|v| v.is_dirac) {
                self.tries += 1;
                let lamps = match behind.iter().find(|v| !v.is_dirac) {
                    Some(v) => scene.surface(v.vertex.x.surface).emitter.as_slice(),
                    None => scene.lights.environments(),
                };
                lamps.iter().for_each(|e| *self.hits.entry(*e).or_default() += 1);
            }
        }
        if let (Some((i, true)), Some(origin)) = (first(&paths.light.vertices), &paths.light.origin) {
            self.focused.push((origin.emitter, paths.light.vertices[i]));
        }
    }

    /// A photon map, where light from mirrors is seen in mirrors. That of a lamp which walks do hit there is none of it: a window beside a small lamp, say.
    fn hidden(&self, scene: &Scene, there_is_one: bool) -> Option<Advice> {
        let n = f64::from(PATHS);
        let radius = AROUND * scene.bounds.bounding_sphere().1;
        let area = f64::from(radius * radius) * std::f64::consts::PI;
        // β_y f(z → y) Φ_z / (π r²)
        let carried = |y: &PathVertex, z: &PathVertex| {
            let (a, b) = (&y.vertex.x, &z.vertex.x);
            let near = a.p.distance_squared(b.p) < radius * radius && a.n.dot(b.n) > 0.5;
            let cos = a.shading.n.dot(b.wo).abs();
            if near && cos > 0.0 { f64::from((y.beta * y.vertex.eval(b.wo).0 * z.beta).luminance() / cos) } else { 0.0 }
        };
        let rate = |hits: u32| f64::from(hits) / f64::from(self.tries.max(1));
        let is_rare = |e: &EmitterId| self.hits.get(e).is_none_or(|hits| rate(*hits) < HIT);
        let rare: Vec<&PathVertex> = self.focused.iter().filter(|(e, _)| is_rare(e)).map(|(_, z)| z).collect();
        let hidden = self.seen.iter().flat_map(|y| rare.iter().map(|z| carried(y, z))).sum::<f64>() / (n * n * area);
        let known = self.light.iter().sum::<f64>() / (n * self.pixels);
        let share = hidden / (hidden + known).max(f64::MIN_POSITIVE);
        let lucky = rate(self.hits.iter().filter(|(e, _)| is_rare(e)).map(|(_, hits)| hits).sum());
        (there_is_one && share > HIDDEN && lucky < HIT).then(|| Advice {
            solver: "photon-map",
            reason: format!(
                "about {:.1} % of the light comes by mirrors or glass and is seen by them, and walks from the eye practically never hit a lamp that way: no \
                 unbiased solver finds it; a photon map does, with a bias that falls with its iterations",
                100.0 * share
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
                // Both may be without any noise that shows.
                let others = costs[0].max(1e-9) / costs[2].max(1e-9);
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

    /// The mean over blocks of the variance of a sample, relative to the squared light there, times its rays.
    fn cost(&self, candidate: usize) -> f64 {
        let n = f64::from(PATHS);
        let blocks = (BLOCKS * BLOCKS) as f64;
        // Light of a block if all paths fell there.
        let mean = |b: usize| self.light[b] / n * blocks;
        let e = 0.01 * ((0..self.light.len()).map(mean).sum::<f64>() / blocks).powi(2);
        let relative = |b: usize| {
            let noise = &self.noise[candidate][b];
            let known: f64 = noise.means.values().map(|sum| (sum / n * blocks).powi(2)).sum();
            (noise.squares / n * blocks - known).max(0.0) / (mean(b).powi(2) + e)
        };
        CANDIDATES[candidate].time * self.rays[candidate] as f64 / n * (0..self.light.len()).map(relative).sum::<f64>() / blocks
    }
}
