//! Passes over pixels: one sample of every pixel, tile by tile, each tile one thread's work.

use super::Work;
use super::allotted;
use crate::run::{Run, Stop};
use crate::solver::{CannotGoOn, Estimates, Needs, Solver};
use crate::transport::{Context, Crowd, PathRules, PathSolver, PathState, slot, trace};
use etendue_film::{Replicates, Tile};
use etendue_numerics::sequence::mix;
use etendue_numerics::{Dim, Numbers, Ray, Sampler, Spectrum, Vec2, Vec3, Wavelengths, wide};
use etendue_scene::{FilmSettings, Scene, Sensor, SurfaceId, View, sensor::CameraRays};
use std::ops::Range;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A solver that answers one question: how much radiance arrives along a camera ray?
pub trait PixelSolver: Sync {
    /// What a scene must have.
    fn needs(&self) -> Needs {
        Needs::default()
    }

    /// What its picture is an estimate of.
    fn estimates(&self) -> Estimates {
        Estimates::Light
    }

    /// Edge of the blocks of pixels whose walks are handed over together, as blocks; 1 where each is alone.
    fn block(&self) -> u32 {
        1
    }

    /// An estimate of L along the walk's first ray, times its weight, at the walk's wavelengths. Counts rays.
    fn radiance(&self, c: &Context<'_>, eye: PathState, u: &Sampler, rays: &mut u64) -> Spectrum;

    /// The same for a crowd of walks; each one's answer is left in its `l`. Counts rays.
    fn radiances<'a>(&self, c: &Context<'a>, crowd: &mut Crowd<'a>, rays: &mut u64) {
        for (walk, u) in crowd.walks.iter_mut().zip(&crowd.samplers) {
            walk.l = self.radiance(c, *walk, u, rays);
        }
    }
}

impl<T: PathSolver> PixelSolver for T {
    fn needs(&self) -> Needs {
        PathSolver::needs(self)
    }

    #[inline]
    fn radiance(&self, c: &Context<'_>, eye: PathState, u: &Sampler, rays: &mut u64) -> Spectrum {
        trace(self, c, eye, u, rays)
    }

    fn block(&self) -> u32 {
        PathSolver::block(self)
    }

    fn radiances<'a>(&self, c: &Context<'a>, crowd: &mut Crowd<'a>, rays: &mut u64) {
        crowd.trace(self, c, rays);
    }
}

impl<T: PixelSolver> Solver for T {
    type State = ();

    fn needs(&self) -> Needs {
        PixelSolver::needs(self)
    }

    fn estimates(&self) -> Estimates {
        PixelSolver::estimates(self)
    }

    fn splats(&self) -> bool {
        false
    }

    /// Walks that share what neighbours find do so where all take as many samples.
    fn adapts(&self) -> bool {
        self.block() == 1
    }

    fn units(&self, size: [u32; 2]) -> usize {
        units(size)
    }

    fn prepare(&self, _: &Scene, _: &Run<'_>) {}

    fn pass(&self, scene: &Scene, run: &Run<'_>, (): &mut (), k: u32, work: &Work<'_>) -> Result<(), CannotGoOn> {
        pass(self, scene, run, k, work);
        Ok(())
    }
}

/// Units of a pass.
pub fn units(size: [u32; 2]) -> usize {
    Tiling::new(size).len()
}

/// How a picture is cut into tiles.
pub(crate) struct Tiling {
    size: [u32; 2],
    edge: u32,
}

impl Tiling {
    pub(crate) fn new(size: [u32; 2]) -> Self {
        Self { size, edge: if u64::from(size[0]) * u64::from(size[1]) < 1 << 16 { 8 } else { 16 } }
    }

    /// Tiles of four times as many pixels: the more splats are added at once, the fewer of them find their part of the film gone from the cache.
    pub(crate) fn coarse(size: [u32; 2]) -> Self {
        let Self { size, edge } = Self::new(size);
        Self { size, edge: 2 * edge }
    }

    pub(crate) fn len(&self) -> usize {
        self.size[0].div_ceil(self.edge) as usize * self.size[1].div_ceil(self.edge) as usize
    }

    pub(crate) fn rectangle(&self, tile: usize) -> ([u32; 2], [u32; 2]) {
        let columns = self.size[0].div_ceil(self.edge) as usize;
        let low = [(tile % columns) as u32 * self.edge, (tile / columns) as u32 * self.edge];
        (low, [(low[0] + self.edge).min(self.size[0]), (low[1] + self.edge).min(self.size[1])])
    }

    /// The squares of `edge` by `edge` pixels that a tile has a part of: left, top, right and bottom in pixels of the whole film, from which they are cut; the picture
    /// begins at `film.crop_offset` there.
    fn squares(&self, tile: usize, edge: u32, film: &FilmSettings) -> impl Iterator<Item = [u32; 4]> + use<> {
        let ((low, high), [x, y], size) = (self.rectangle(tile), film.crop_offset, film.size);
        let starts = move |low: u32, high: u32| (low - low % edge..high).step_by(edge as usize);
        starts(low[1] + y, high[1] + y).flat_map(move |top| {
            starts(low[0] + x, high[0] + x).map(move |left| [left, top, (left + edge).min(size[0]), (top + edge).min(size[1])])
        })
    }

    /// The pixels of a tile, row by row.
    pub(crate) fn pixels(&self, tile: usize) -> impl Iterator<Item = [u32; 2]> + use<> {
        let (low, high) = self.rectangle(tile);
        (low[1]..high[1]).flat_map(move |y| (low[0]..high[0]).map(move |x| [x, y]))
    }
}

/// Walks that set out together, about: enough to fill lanes, few enough to stay in a core's cache.
pub(super) const CROWD: usize = 1024;

/// Pass k: sample k of every pixel. In noise mode passes belong to replicates in turn, each with a scramble of its own.
pub fn pass(solver: &impl PixelSolver, scene: &Scene, run: &Run<'_>, k: u32, work: &Work<'_>) {
    pass_over(solver, scene, run, run.rules, &SamplePlan::new(run, k), 0..work.units.len(), work);
}

/// The same for a solver of which this is only a part: `rules` say which paths count here, `units` are the tiles among its units.
pub(crate) fn pass_over(
    solver: &impl PixelSolver,
    scene: &Scene,
    run: &Run<'_>,
    rules: PathRules,
    plan: &SamplePlan,
    units: Range<usize>,
    work: &Work<'_>,
) {
    let context = Context { scene, rules };
    let tiling = Tiling::new(work.film.shape().size);
    if let Some(allocation) = work.allocation {
        return allotted::Pass { solver, context, run, plan, tiling: &tiling, allocation, work }.over(units);
    }
    // Tiles are taken in groups, unless there are too few of them to go round.
    let per_crowd = CROWD / (tiling.edge * tiling.edge) as usize;
    let group = (units.len() / (4 * rayon::current_num_threads())).clamp(1, per_crowd);
    let next = AtomicUsize::new(units.start);
    rayon::broadcast(|_| {
        let (mut tile, mut crowd) = (work.film.tile(), Crowd::default());
        loop {
            let first = next.fetch_add(group, Ordering::Relaxed);
            if first >= units.end || (work.stop_now)() {
                return;
            }
            let tiles = first..(first + group).min(units.end);
            fill(solver, &context, run, plan, &tiling, tiles, &mut crowd, &mut tile, work);
        }
    });
}

/// Which sample of which point set a pass takes.
pub(crate) struct SamplePlan {
    pub(crate) seed: u64,
    pub(crate) replicate: usize,
    pub(crate) pass: u32,
    pub(crate) sample: u32,
    pub(crate) count: u32,
}

impl SamplePlan {
    pub(crate) fn new(run: &Run<'_>, k: u32) -> Self {
        let count = run.planned_samples();
        let plan = Self { seed: run.seed, replicate: 0, pass: k, sample: k, count };
        match run.stop {
            Stop::Noise { .. } => {
                let replicate = k % Replicates::K as u32;
                let seed = mix(run.seed ^ mix(u64::from(replicate) + 1));
                Self { seed, replicate: replicate as usize, sample: k / Replicates::K as u32, ..plan }
            }
            _ => plan,
        }
    }

    /// Which of each two by two pixels of the film, [x, y] one of them, go to which of the four blocks of a square: any of them.
    #[inline]
    fn turn(&self, [x, y]: [u32; 2]) -> u32 {
        mix(self.seed ^ mix(u64::from(y >> 1) << 32 ^ u64::from(x >> 1))) as u32
    }

    /// Where a pixel of the film stands in a picture whose blocks are put together, with its `turn`.
    /// Its numbers are those of that place, for neighbours there have the most even ones together.
    #[inline]
    fn together(edge: u32, [x, y]: [u32; 2], turn: u32) -> [u32; 2] {
        // The edge is a power of two.
        let place = |x: u32, turn: u32| (x & !(2 * edge - 1)) + (x >> 1 & (edge - 1)) + ((x ^ turn) & 1) * edge;
        [place(x, turn), place(y, turn >> 1)]
    }

    #[inline]
    pub(crate) fn sampler(&self, run: &Run<'_>, x: u32, y: u32) -> Sampler {
        Sampler::on_screen(run.sequence, self.seed, [x, y], self.sample, self.count)
    }
}

#[expect(clippy::too_many_arguments, reason = "the inner loop of a pass, called in one place")]
fn fill<'a>(
    solver: &impl PixelSolver,
    c: &Context<'a>,
    run: &Run<'_>,
    plan: &SamplePlan,
    tiling: &Tiling,
    tiles: Range<usize>,
    crowd: &mut Crowd<'a>,
    tile: &mut Tile,
    work: &Work<'_>,
) {
    // Walks through all pixels of the tiles, block by block.
    let view = &c.scene.views[run.view];
    let todo = || tiles.clone().filter(|index| !work.units.is_done(*index));
    let edge = solver.block();
    let Places { pixels, order, ends } = Places::new(plan, tiling, todo(), edge, &view.film);
    let mut positions = Vec::with_capacity(pixels.len());
    crowd.clear();
    crowd.blocks.extend(ends);
    let walk = |(pixel, [x, y]): &([u32; 2], [u32; 2])| (*pixel, plan.sampler(run, *x, *y));
    set_out(c, run.view, &pixels, walk, crowd, |position| positions.push(position));
    let mut rays = 0;
    solver.radiances(c, crowd, &mut rays);

    // What they collected, tile by tile.
    let mut next = 0..pixels.len();
    for index in todo() {
        let (low, high) = tiling.rectangle(index);
        tile.begin(low, high);
        let mut tracked = work.replicates.map(|r| r.lock().unwrap_or_else(PoisonError::into_inner));
        for (pixel, k) in tiling.pixels(index).zip(&mut next) {
            let i = order[k];
            let l = crowd.walks[i].seen();
            tile.add(positions[i], l, plan.pass);
            if let Some(sums) = tracked.as_mut().filter(|sums| sums.has_pixels())
                && let Some(slot) = sums.slot(pixel)
            {
                sums.add(plan.replicate, slot, l.to_rgb());
            }
        }
        if let Some(sums) = &mut tracked {
            sums.add_tile(plan.replicate, tile);
        }
        drop(tracked);
        work.film.add_tile(tile);
        work.units.done(index);
        work.progress.tiles.fetch_add(1, Ordering::Relaxed);
    }
    work.progress.rays.fetch_add(rays, Ordering::Relaxed);
    work.progress.paths.fetch_add(next.start as u64, Ordering::Relaxed);
}

/// Adds a walk about to leave the eye for each of `places`; `walk` says through which pixel of the whole film, and with which numbers. `added` hears of each in turn
/// where it is in the picture. The first numbers are drawn for many together.
pub(super) fn set_out<'a, T>(
    c: &Context<'a>,
    view: usize,
    places: &[T],
    walk: impl Fn(&T) -> ([u32; 2], Sampler),
    crowd: &mut Crowd<'a>,
    mut added: impl FnMut(Vec2),
) {
    let View { film, sensor, .. } = &c.scene.views[view];
    const LANES: usize = 16 * wide::PAD;
    let [within_x, within_y, time, hue] = &mut [[0.0; LANES]; 4];
    let (mut pixels, mut places_on_film, mut rays) = ([[0; 2]; LANES], [[0.0; LANES]; 2], CameraRays::NONE);
    // Walks are made where they stay.
    let blank = PathState::start(Ray::new(Vec3::ZERO, Vec3::ZERO), Spectrum::ZERO, Wavelengths::Rgb);
    for some in places.chunks(pixels.len()) {
        let first = crowd.samplers.len();
        crowd.samplers.extend(some.iter().zip(&mut pixels).map(|(place, to)| {
            let (pixel, u) = walk(place);
            *to = pixel;
            u
        }));
        let samplers = &crowd.samplers[first..];
        Sampler::u2_each(samplers, Dim::at(0, slot::PIXEL), within_x, within_y);
        Sampler::u1_each(samplers, Dim::at(0, slot::TIME), time);
        if c.scene.spectral {
            Sampler::u1_each(samplers, Dim::at(0, slot::WAVELENGTHS), hue);
        }
        for (i, (pixel, x)) in pixels.iter().zip(within_x.iter()).enumerate().take(some.len()) {
            let (position, on_film) = place(film, *pixel, Vec2::new(*x, within_y[i]));
            added(position);
            (places_on_film[0][i], places_on_film[1][i]) = on_film.into();
        }
        sensor.sample_rays(&places_on_film, some.len(), |i| lens(sensor, &samplers[i]), &mut rays);
        crowd.walks.resize(first + some.len(), blank);
        for (i, state) in crowd.walks[first..].iter_mut().enumerate() {
            let (ray, weight) = rays.get(i, time[i]);
            let wl = c.scene.wavelengths(|| hue[i]);
            state.set_out(seen(c, ray), wl.grey(weight), wl);
        }
    }
}

/// Edge of the squares of pixels whose walks stand side by side where each is alone: as many as go through a tree in a packet.
const TOGETHER: u32 = 4;

/// The pixels of some tiles, those beyond them that belong to their blocks included. Four blocks are mingled in a square of twice their edge
/// ([`SamplePlan::together`]), lest the errors that a block has in common be seen as a block.
struct Places {
    /// In pixels of the whole film, block by block; each with the place whose numbers it takes.
    pixels: Vec<([u32; 2], [u32; 2])>,
    /// For each pixel of the tiles, row by row, its place among those.
    order: Vec<usize>,
    /// Where blocks end.
    ends: Vec<u32>,
}

impl Places {
    fn new(plan: &SamplePlan, tiling: &Tiling, tiles: impl Iterator<Item = usize>, edge: u32, film: &FilmSettings) -> Self {
        let mut all = Self { pixels: Vec::with_capacity(CROWD), order: Vec::new(), ends: Vec::new() };
        let [left, top] = film.crop_offset;
        let (mut blocks, mut turns): ([Vec<_>; 4], _) = (Default::default(), vec![0; edge as usize]);
        for tile in tiles {
            let (low, high) = tiling.rectangle(tile);
            let (first, width) = (all.order.len(), high[0] - low[0]);
            all.order.resize(first + (width * (high[1] - low[1])) as usize, 0);
            if edge == 1 {
                // Sixteen rays next to each other in both directions stay together for longest.
                for [x0, y0, x1, y1] in tiling.squares(tile, TOGETHER, film) {
                    let (x0, x1) = (x0.max(low[0] + left), x1.min(high[0] + left));
                    for y in y0.max(low[1] + top)..y1.min(high[1] + top) {
                        for x in x0..x1 {
                            all.order[first + ((y - top - low[1]) * width + x - left - low[0]) as usize] = all.pixels.len();
                            all.pixels.push(([x, y], [x, y]));
                        }
                    }
                }
                continue;
            }
            for [left, top, right, bottom] in tiling.squares(tile, 2 * edge, film) {
                blocks.iter_mut().for_each(Vec::clear);
                for y in top..bottom {
                    for x in left..right {
                        // Two rows and two columns share a turn.
                        let turn = &mut turns[((x - left) >> 1) as usize];
                        if (x | y) & 1 == 0 {
                            *turn = plan.turn([x, y]);
                        }
                        let place = SamplePlan::together(edge, [x, y], *turn);
                        let [i, j] = place.map(|x| usize::from(x & edge != 0));
                        blocks[i | j << 1].push(([x, y], place));
                    }
                }
                for same in blocks.iter().filter(|same| !same.is_empty()) {
                    for (pixel @ [x, y], place) in same {
                        let at = [x.wrapping_sub(film.crop_offset[0]), y.wrapping_sub(film.crop_offset[1])];
                        if (low[0]..high[0]).contains(&at[0]) && (low[1]..high[1]).contains(&at[1]) {
                            all.order[first + ((at[1] - low[1]) * width + at[0] - low[0]) as usize] = all.pixels.len();
                        }
                        all.pixels.push((*pixel, *place));
                    }
                    all.ends.push(all.pixels.len() as u32);
                }
            }
        }
        all
    }
}

/// A walk about to leave the eye through pixel [x, y] of the picture, and its position there.
#[inline]
pub(crate) fn camera_ray(c: &Context<'_>, run: &Run<'_>, film: &FilmSettings, [x, y]: [u32; 2], u: &Sampler) -> (Vec2, PathState) {
    let pixel = [x + film.crop_offset[0], y + film.crop_offset[1]];
    let (position, on_film) = place(film, pixel, u.u2(Dim::at(0, slot::PIXEL)));
    (position, eye_walk(c, run.view, on_film, u))
}

/// A place `within` a pixel of the full film: in the picture, and on the film.
#[inline]
fn place(film: &FilmSettings, [x, y]: [u32; 2], within: Vec2) -> (Vec2, Vec2) {
    // Far from zero the sum may round up to the next pixel: this one would go without, and stay black with a single sample.
    let below = |n: u32| (n as f32 + 1.0).next_down();
    let [column, row] = [x.wrapping_sub(film.crop_offset[0]), y.wrapping_sub(film.crop_offset[1])];
    let position = (Vec2::new(column as f32, row as f32) + within).min(Vec2::new(below(column), below(row)));
    // Added to whole numbers, so that a crop sees the same directions as the whole film, to the bit.
    (position, Vec2::new(x as f32, y as f32) + within)
}

/// A walk about to leave the eye through a place of the full film, in pixels.
#[inline]
pub(crate) fn eye_walk(c: &Context<'_>, view: usize, on_film: Vec2, u: &impl Numbers) -> PathState {
    let lens = lens(&c.scene.views[view].sensor, u);
    let wl = c.scene.wavelengths(|| u.u1(Dim::at(0, slot::WAVELENGTHS)));
    eye_walk_at(c, view, on_film, lens, u.u1(Dim::at(0, slot::TIME)), wl)
}

/// The numbers that pick a point on the lens; not drawn where there is none.
#[inline]
fn lens(sensor: &Sensor, u: &impl Numbers) -> Vec2 {
    if sensor.has_lens() { u.u2(Dim::at(0, slot::LENS)) } else { Vec2::ZERO }
}

/// [`eye_walk`] through a point of the lens, at a time, with its wavelengths.
#[inline(always)] // as a return value it would go through memory
fn eye_walk_at(c: &Context<'_>, view: usize, on_film: Vec2, lens: Vec2, time: f32, wl: Wavelengths) -> PathState {
    let ray = c.scene.views[view].sensor.sample_ray(on_film, lens, time);
    PathState::start(seen(c, ray.ray), wl.grey(ray.weight), wl)
}

/// A camera ray as far as the eye sees.
#[inline(always)]
fn seen(c: &Context<'_>, ray: Ray) -> Ray {
    if c.rules.hide_emitters { beyond_emitters(c.scene, ray) } else { ray }
}

/// What is left of a camera ray behind the emitting surfaces that it meets first: hidden emitters do not stand in the eye's way.
pub(crate) fn beyond_emitters(scene: &Scene, mut ray: Ray) -> Ray {
    while let Some(hit) = scene.intersect(&ray)
        && scene.surface(SurfaceId(hit.geometry)).emitter.is_some()
    {
        let behind = scene.interaction(&ray, &hit).spawn(ray.d);
        ray = Ray { t_max: ray.t_max - hit.t, medium: ray.medium, ..behind };
    }
    ray
}
