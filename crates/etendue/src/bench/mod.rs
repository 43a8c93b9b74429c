//! How fast this machine casts the rays of a scene, and renders its picture.
//!
//! Every round takes all measurements in turns; each is told as the median of the rounds, with the least and the greatest. Rates are per second of
//! wall clock: run it on an idle machine, and compare only rates of one run.

pub mod rays;

use crate::render::{RenderError, RenderOptions, Watch, render, software, view};
use crate::{Loaded, Stats, Stop, memory, pool};
use etendue_numerics::Ray;
use etendue_scene::Scene;
use rayon::prelude::*;
use rays::Kind;
use serde::Serialize;
use std::hint::black_box;
use std::time::Instant;

/// Rays are cast again and again for at least this long, s.
const AT_LEAST: f64 = 0.1;
/// Rays that a thread takes together.
const BATCH: usize = 1024;

/// What is measured.
#[derive(Clone, Debug)]
pub struct Options {
    /// Which of the scene's views, 0 = the first.
    pub view: usize,
    /// The solver whose picture is timed; the scene's own otherwise.
    pub solver: Option<String>,
    /// Samples per pixel of that picture, > 0.
    pub spp: u32,
    /// Threads; all cores otherwise.
    pub threads: Option<usize>,
    /// Rounds, > 0.
    pub rounds: u32,
}

/// A rate per second over the rounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rate {
    /// The middle one.
    pub median: f64,
    /// The least.
    pub min: f64,
    /// The greatest.
    pub max: f64,
}

/// Rays of one kind.
#[derive(Clone, Debug, Serialize)]
pub struct RayRates {
    /// `camera`, `bounce`, `occlusion` or `shadow`.
    pub kind: &'static str,
    /// How many different rays.
    pub rays: usize,
    /// The share of them that hit something.
    pub hits: f64,
    /// Rays per second, one after the other on one thread.
    pub single: Rate,
    /// Rays per second in batches on one thread.
    pub batch: Rate,
    /// Rays per second in batches on all threads.
    pub threads: Rate,
}

/// The figures.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Program and version.
    pub software: String,
    /// Scene name.
    pub scene: String,
    /// Threads, where not one.
    pub threads: usize,
    /// Rounds that were made.
    pub rounds: usize,
    /// Triangles, those of instances counted once.
    pub triangles: u64,
    /// Reading files, s.
    pub load_seconds: f64,
    /// Compiling the scene, s.
    pub build_seconds: f64,
    /// The tree of the scene, bytes, without those of instances.
    pub tree_bytes: usize,
    /// Rays by kind; kinds without rays are left out.
    pub rays: Vec<RayRates>,
    /// Solver of the picture.
    pub solver: String,
    /// Its size.
    pub width: u32,
    /// Its size.
    pub height: u32,
    /// Its samples per pixel.
    pub spp: u32,
    /// Paths per second of the picture on one thread.
    pub paths_single: Rate,
    /// Paths per second of the picture on all threads.
    pub paths_threads: Rate,
    /// Largest memory held, bytes.
    pub peak_memory_bytes: u64,
}

/// Measures. Ends after the round in which `watch` is asked to stop.
///
/// # Errors
/// If there is no such view, no such solver, one that cannot do the scene, or no threads.
pub fn bench(loaded: &Loaded, options: &Options, watch: &Watch) -> Result<Report, RenderError> {
    let scene = &loaded.scene;
    let pool = pool::pool(options.threads)?;
    let threads = pool.current_num_threads();
    let kinds: Vec<Kind> =
        rays::kinds(scene, view(loaded, options.view)?).into_iter().filter(|kind| !kind.rays.is_empty()).collect();
    let picture = |threads: usize| {
        let options = RenderOptions {
            view: options.view,
            solver: options.solver.clone(),
            stop: Some(Stop::Samples(options.spp)),
            threads: Some(threads),
            ..RenderOptions::default()
        };
        render(loaded, &options, &Watch::default()).map(|rendering| rendering.stats)
    };

    let mut times: Vec<[Vec<f64>; 3]> = vec![Default::default(); kinds.len()];
    let mut paths: [Vec<f64>; 2] = Default::default();
    let mut stats = Stats::default();
    for _ in 0..options.rounds {
        for (kind, [single, batch, all]) in kinds.iter().zip(&mut times) {
            single.push(rate(kind, || one_by_one(scene, kind)));
            batch.push(rate(kind, || kind.rays.chunks(BATCH).map(|rays| together(scene, rays, kind.any)).sum()));
            all.push(pool.install(|| rate(kind, || kind.rays.par_chunks(BATCH).map(|rays| together(scene, rays, kind.any)).sum())));
        }
        for (rates, threads) in paths.iter_mut().zip([1, threads]) {
            stats = picture(threads)?;
            rates.push(stats.paths as f64 / stats.render_seconds);
        }
        if watch.cancel.is_cancelled() {
            break;
        }
    }

    let rounds = paths[0].len();
    let [paths_single, paths_threads] = paths.map(Rate::of);
    let told = kinds.iter().zip(times).map(|(kind, times)| {
        let [single, batch, threads] = times.map(Rate::of);
        let hits = one_by_one(scene, kind) as f64 / kind.rays.len() as f64;
        RayRates { kind: kind.name, rays: kind.rays.len(), hits, single, batch, threads }
    });
    Ok(Report {
        software: software(),
        scene: loaded.name.clone(),
        threads,
        triangles: scene.triangles,
        load_seconds: loaded.read_time.as_secs_f64(),
        build_seconds: loaded.build_time.as_secs_f64(),
        tree_bytes: scene.accel.stats().bytes,
        rays: told.collect(),
        rounds,
        solver: stats.solver,
        width: stats.width,
        height: stats.height,
        spp: stats.spp,
        paths_single,
        paths_threads,
        peak_memory_bytes: memory::peak(),
    })
}

/// Rays per second of `cast`, which casts all rays of a kind and counts the hits.
fn rate(kind: &Kind, cast: impl Fn() -> usize) -> f64 {
    let start = Instant::now();
    let mut times = 0;
    while times == 0 || start.elapsed().as_secs_f64() < AT_LEAST {
        black_box(cast());
        times += 1;
    }
    (times * kind.rays.len()) as f64 / start.elapsed().as_secs_f64()
}

fn one_by_one(scene: &Scene, kind: &Kind) -> usize {
    let hit = |ray| if kind.any { scene.accel.occluded(ray, &scene.surfaces) } else { scene.intersect(ray).is_some() };
    kind.rays.iter().filter(|ray| hit(ray)).count()
}

fn together(scene: &Scene, rays: &[Ray], any: bool) -> usize {
    if any {
        let mut hits = Vec::new();
        scene.occluded_each(rays, &mut hits);
        hits.into_iter().filter(|hit| *hit).count()
    } else {
        let mut hits = Vec::new();
        scene.intersect_each(rays, &mut hits);
        hits.iter().flatten().count()
    }
}

impl Rate {
    fn of(mut rates: Vec<f64>) -> Self {
        rates.sort_by(f64::total_cmp);
        let (n, at) = (rates.len(), |i: usize| rates.get(i).copied().unwrap_or_default());
        Self { median: 0.5 * (at(n.saturating_sub(1) / 2) + at(n / 2)), min: at(0), max: at(n.saturating_sub(1)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LoadOptions, load};

    /// In a closed box every ray hits; batches find what single rays find; shadow rays end before their lamp.
    #[test]
    fn rays_of_a_closed_box() {
        let loaded = load("furnace", &LoadOptions::default()).unwrap();
        let kinds = rays::kinds(&loaded.scene, &loaded.scene.views[0]);
        assert_eq!(kinds.each_ref().map(|kind| kind.any), [false, false, true, true]);
        for kind in &kinds {
            let hits = one_by_one(&loaded.scene, kind);
            assert_eq!(
                hits,
                kind.rays.chunks(BATCH).map(|rays| together(&loaded.scene, rays, kind.any)).sum::<usize>(),
                "{}",
                kind.name
            );
            assert!(!kind.rays.is_empty(), "{}", kind.name);
            if !kind.any {
                assert_eq!(hits, kind.rays.len(), "{}", kind.name);
            }
        }
        assert_eq!(one_by_one(&loaded.scene, &kinds[3]), 0, "the furnace is empty: all of it sees all of it");
    }

    #[test]
    fn the_middle_of_the_rounds() {
        assert_eq!(Rate::of(vec![3.0, 1.0, 2.0]), Rate { median: 2.0, min: 1.0, max: 3.0 });
        assert_eq!(Rate::of(vec![4.0, 1.0]), Rate { median: 2.5, min: 1.0, max: 4.0 });
    }
}
