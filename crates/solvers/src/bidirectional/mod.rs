//! Bidirectional path tracing: a walk from the eye and a walk from a light, connected in all ways [Veach, Guibas 1994; Lafortune, Willems 1993].
//!
//! ```text
//! I_j = Σ_{s ≥ 0} Σ_{t ≥ 1} w_{s,t} C_{s,t}          C_{s,t} = β_t (connection of y_t and z_s) β_s
//! ```
//!
//! Every strategy (s, t) alone finds all light of s + t - 1 edges that it can find at all; the weights give each path to the strategies that
//! find it best. Caustics come by t = 1, light of small lamps by s = 1, lamps in mirrors by s = 0, and light round corners by those in between.
//!
//! | what | where |
//! | --- | --- |
//! | a vertex of either walk, and how it scatters towards the other | [`path_vertex`] |
//! | the walks | [`walk`], [`light_path`], [`eye`] |
//! | C_{s,t} | [`connect`] |
//! | w_{s,t}, in O(1) | [`weights`] |
//! | w_{s,t} from its definition | [`literal`] |
//! | which connections are worth a shadow ray | [`worth`] |
//! | one strategy alone | [`one`] |
//! | each strategy's picture | [`strategies`] |
//! | many samples at once, between diffuse surfaces | `lanes::pairs` |
//!
//! One pass is an eye path and a light path for each pixel. Strategies with t ≥ 2 count for the pixel, those with t = 1 are splat where they fall. A lens is
//! never hit by chance (t = 0): what only that could find, as a laser in a mirror, stays dark.
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `exponent` | β of the weights: 1 is the balance heuristic, 2 the power heuristic | 2 |
//! | `faint` | connections that would add less than this part of the picture's mean to a pixel cast their shadow ray by roulette | 0.05 |

pub mod connect;
pub mod eye;
pub mod light_path;
pub mod literal;
pub mod one;
pub mod path_vertex;
pub mod strategies;
pub mod walk;
pub mod weights;
pub mod worth;

pub use connect::{Found, Joint, Strategies};
pub use light_path::LightPath;
pub use path_vertex::PathVertex;

use crate::drivers::Work;
use crate::drivers::pixels::{SamplePlan, Tiling, camera_ray};
use crate::lanes::pairs::{Pairs, Plain};
use crate::parameters::{Parameter, Slot};
use crate::run::Run;
use crate::solver::{CannotGoOn, Needs, Solver};
use crate::transport::{Context, Heuristic, PathRules, PathState, Throughput};
use etendue_film::{Splat, Tile};
use etendue_numerics::{Numbers, Sampler, Spectrum, Vec2, Wavelengths};
use etendue_scene::Scene;
use eye::Eye;
use path_vertex::Sides;
use rayon::prelude::*;
use std::sync::PoisonError;
use std::sync::atomic::Ordering;
use walk::{End, Walk};
use worth::Worth;

/// Tiles whose splats are added together.
const GROUP: usize = 16;

/// The solver `bidirectional`.
#[derive(Clone, Copy, Debug)]
pub struct Bidirectional {
    /// β of the weights: 1 or 2.
    pub exponent: u32,
    /// δ / L: below which part of the picture's mean connections are cast by roulette; 0 casts all.
    pub faint: f32,
}

impl Default for Bidirectional {
    fn default() -> Self {
        Self { exponent: 2, faint: 0.05 }
    }
}

/// The walks of a sample, kept from one to the next for their memory.
#[derive(Clone, Debug, Default)]
pub struct Paths<'a> {
    /// From the eye.
    pub eye: Vec<PathVertex<'a>>,
    /// From a light.
    pub light: LightPath<'a>,
    /// Rays cast.
    pub rays: u64,
}

impl Bidirectional {
    /// What users may set.
    pub const PARAMETERS: &[Parameter<Self>] = &[
        Parameter {
            name: "exponent",
            summary: "how strategies share: 1 in proportion to their densities, 2 to their squares",
            slot: |s| Slot::Count(&mut s.exponent, 1..=2),
        },
        Parameter {
            name: "faint",
            summary: "below which part of the picture's mean a connection is cast by roulette",
            slot: |s| Slot::Number(&mut s.faint, 0.0..=1.0),
        },
    ];

    /// What the strategies of a run share.
    pub fn strategies<'a>(&self, scene: &'a Scene, run: &Run<'_>) -> Strategies<'a> {
        self.strategies_of(scene, run.view, run.rules)
    }

    /// What the strategies of a view share, where `rules` say which paths count.
    pub fn strategies_of<'a>(&self, scene: &'a Scene, view: usize, rules: PathRules) -> Strategies<'a> {
        let view = &scene.views[view];
        let heuristic = if self.exponent == 1 { Heuristic::Balance } else { Heuristic::Power };
        let worth = Worth::all(view);
        Strategies {
            c: Context { scene, rules }.eager(),
            sides: Sides::new(scene),
            view,
            eye: Eye::new(view),
            heuristic,
            worth,
            wl: Wavelengths::Rgb,
        }
    }
}

impl<'a> Strategies<'a> {
    /// A walk about to leave the eye.
    fn walk_from(&self, eye: PathState) -> Walk<'_, 'a> {
        Walk {
            c: &self.c,
            sides: &self.sides,
            heuristic: self.heuristic,
            end: End::Eye,
            trail: self.eye.trail(&eye.ray, self.heuristic),
            start: eye.beta.carry(Spectrum::ONE),
            state: PathState { beta: Throughput::ONE, ..eye },
            parent: None,
            count: 1,
        }
    }

    /// One path from each end, connected in all ways; `found` is told each path that carries light, with the walks so far.
    pub fn sample(
        &self,
        eye: PathState,
        u: &impl Numbers,
        paths: &mut Paths<'a>,
        found: &mut impl FnMut(&Found<'_>, &LightPath<'a>, &[PathVertex<'a>]),
    ) {
        let this = &Strategies { wl: eye.wl, ..*self };
        let Paths { eye: vertices, light, rays } = paths;
        light.trace(this, u, rays);
        vertices.clear();

        // t = 1.
        if let Some(f) = this.emitter(light, u, rays) {
            found(&f, light, vertices);
        }
        for z in light.vertices.iter().filter(|z| z.vertex.is_smooth()) {
            if let Some(f) = this.lens(z, u, rays) {
                found(&f, light, vertices);
            }
        }

        let mut walk = this.walk_from(eye);
        loop {
            // s = 0.
            let Some(x) = walk.meet(rays) else {
                if let Some(f) = this.escape(&walk) {
                    found(&f, light, vertices);
                }
                return;
            };
            if let Some(f) = this.hit(&walk, &x) {
                found(&f, light, vertices);
            }
            if this.c.ends(&walk.state) {
                return;
            }

            // s = 1, and s ≥ 2.
            let place = vertices.len();
            vertices.push(walk.vertex(x));
            let y = &vertices[place];
            if y.vertex.is_smooth() {
                this.next_event(y, u, rays, &mut |f| found(f, light, vertices));
                for z in light.vertices.iter().filter(|z| z.vertex.is_smooth()) {
                    if let Some(f) = this.inner(y, z, u, rays) {
                        found(&f, light, vertices);
                    }
                }
            }
            if !walk.turn(&mut vertices[place], place as u32, u) {
                return;
            }
        }
    }
}

impl Solver for Bidirectional {
    type State = Worth;

    fn needs(&self) -> Needs {
        Needs { both_ways: true, ..Needs::default() }
    }

    fn splats(&self) -> bool {
        true
    }

    fn units(&self, size: [u32; 2]) -> usize {
        Tiling::coarse(size).len()
    }

    fn prepare(&self, scene: &Scene, run: &Run<'_>) -> Worth {
        Worth::by_trial(self.faint, &self.strategies(scene, run), run)
    }

    fn pass(&self, scene: &Scene, run: &Run<'_>, worth: &mut Worth, k: u32, work: &Work<'_>) -> Result<(), CannotGoOn> {
        let strategies = Strategies { worth: *worth, ..self.strategies(scene, run) };
        let plan = SamplePlan::new(run, k);
        let tiling = Tiling::coarse(work.film.shape().size);
        // Tiles are taken in groups, unless there are too few of them to go round: the more splats are added at once, the nearer they fall to each other.
        let units = work.units.len();
        let group = (units / (4 * rayon::current_num_threads())).clamp(1, GROUP);
        (0..units.div_ceil(group)).into_par_iter().for_each_init(
            || (work.film.tile(), Paths::default(), None, Vec::new()),
            |(tile, paths, pairs, splats), index| {
                splats.clear();
                let (mut done, mut count) = (Vec::with_capacity(group), 0);
                for unit in (index * group..units.min((index + 1) * group)).filter(|unit| !work.units.is_done(*unit)) {
                    if (work.stop_now)() {
                        break;
                    }
                    let (low, high) = tiling.rectangle(unit);
                    fill(&strategies, run, &plan, tile, low, high, paths, pairs, splats, work);
                    work.film.add_tile(tile);
                    count += u64::from(high[0] - low[0]) * u64::from(high[1] - low[1]);
                    done.push(unit);
                }
                work.film.add_splats(splats);
                work.film.start_particles(count);
                work.progress.tiles.fetch_add(done.len() as u64, Ordering::Relaxed);
                done.into_iter().for_each(|unit| work.units.done(unit));
                work.progress.rays.fetch_add(std::mem::take(&mut paths.rays), Ordering::Relaxed);
                work.progress.paths.fetch_add(2 * count, Ordering::Relaxed);
            },
        );
        Ok(())
    }
}

#[expect(clippy::too_many_arguments, reason = "the inner loop of a pass, called in one place")]
fn fill<'a>(
    strategies: &Strategies<'a>,
    run: &Run<'_>,
    plan: &SamplePlan,
    tile: &mut Tile,
    low: [u32; 2],
    high: [u32; 2],
    paths: &mut Paths<'a>,
    pairs: &mut Option<Pairs>,
    splats: &mut Vec<Splat>,
    work: &Work<'_>,
) {
    let film = &strategies.view.film;
    let [width, height] = film.crop_size;
    let corner = Vec2::new(film.crop_offset[0] as f32, film.crop_offset[1] as f32);
    let pixels = u64::from(width) * u64::from(height);
    let (mut tracked, before) = (Vec::new(), splats.len());
    tile.begin(low, high);
    let mut taken = |[x, y]: [u32; 2], position: Vec2, l: Spectrum| {
        tile.add(position, l, plan.pass);
        if work.replicates.is_some() {
            tracked.push(([x, y], l.to_rgb()));
        }
    };
    let particle = |[x, y]: [u32; 2]| u64::from(plan.pass) * pixels + u64::from(y * width + x);
    let places: Vec<[u32; 2]> = (low[1]..high[1]).flat_map(|y| (low[0]..high[0]).map(move |x| [x, y])).collect();
    let plain = Plain::of(strategies);
    for some in places.chunks(Pairs::MOST) {
        let samplers: Vec<Sampler> =
            some.iter().map(|[x, y]| plan.sampler(run, x + film.crop_offset[0], y + film.crop_offset[1])).collect();
        let (positions, eyes): (Vec<Vec2>, Vec<PathState>) =
            some.iter().zip(&samplers).map(|(at, u)| camera_ray(&strategies.c, run, film, *at, u)).unzip();
        if let Some(plain) = plain.as_ref().filter(|_| eyes.iter().all(|eye| eye.wl.is_rgb())) {
            let pairs = pairs.get_or_insert_default();
            pairs.trace(plain, &eyes, &samplers, &mut paths.rays);
            some.iter().zip(positions).zip(&pairs.l).for_each(|((at, position), l)| taken(*at, position, *l));
            let splat = |(i, pixel, value): &(u32, Vec2, Spectrum)| Splat {
                position: *pixel - corner,
                value: *value,
                particle: particle(some[*i as usize]),
            };
            splats.extend(pairs.splats.iter().map(splat));
            continue;
        }
        for ((at, u), (position, eye)) in some.iter().zip(&samplers).zip(positions.into_iter().zip(eyes)) {
            let (wl, mut l) = (eye.wl, Spectrum::ZERO);
            strategies.sample(eye, u, paths, &mut |f, _, _| {
                let value = wl.to_rgb(f.value * f.weight);
                match f.pixel {
                    None => l += value,
                    Some(_) if value.is_zero() => (),
                    Some(pixel) => splats.push(Splat { position: pixel - corner, value, particle: particle(*at) }),
                }
            });
            taken(*at, position, l);
        }
    }
    if let Some(replicates) = work.replicates {
        let mut sums = replicates.lock().unwrap_or_else(PoisonError::into_inner);
        let splat = |s: &Splat| ([s.position.x as u32, s.position.y as u32], (s.value / pixels as f32).to_rgb());
        for (pixel, l) in tracked.into_iter().chain(splats[before..].iter().map(splat)) {
            if let Some(slot) = sums.slot(pixel) {
                sums.add(plan.replicate, slot, l);
            }
        }
    }
}
