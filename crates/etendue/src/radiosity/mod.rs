//! A scene's radiosity: solved, reported, shown, and written for other programs.
//!
//! ```text
//! scene → etendue_radiosity::Solved → Report, pictures (all light, or bounce by bounce), tables and meshes
//! ```

pub mod bounces;
pub mod export;
mod glb;
pub mod measure;
mod report;
mod sheet;

pub use report::Report;

use crate::load::Loaded;
use crate::picture::{picture, words};
use crate::pool;
use crate::render::RenderError;
use etendue_film::{Film, FilmShape};
use etendue_image::Picture;
use etendue_radiosity::Solved;
use etendue_radiosity::solved::{Settings, Stage};
use etendue_solvers::radiosity::{Look, Show, Shown};
use etendue_solvers::{CancelToken, PathRules, Progress, Run, Spread, Stop};
use std::time::Instant;

/// Hears of stages; its `false` stops.
pub type Told<'a> = dyn Fn(Stage) -> bool + Sync + 'a;

/// Solves a scene.
pub fn solve(
    loaded: &Loaded,
    settings: &Settings,
    threads: Option<usize>,
    told: &Told<'_>,
) -> Result<(Solved, Report), RenderError> {
    let pool = pool::pool(threads)?;
    let begun = Instant::now();
    let memory = crate::memory::available().unwrap_or(u64::MAX);
    let settings = Settings { memory: memory.min(settings.memory), ..*settings };
    let solved = pool.install(|| Solved::new(&loaded.scene, &settings, told)).map_err(|e| RenderError(e.to_string()))?;
    let report = Report::new(loaded, &settings, &solved, begun.elapsed(), pool.current_num_threads());
    Ok((solved, report))
}

/// How a solution is looked at.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Which of the scene's views.
    pub view: usize,
    /// How indirect light is shown.
    pub show: Show,
    /// Display rays a pixel.
    pub spp: u32,
    /// Of the display rays.
    pub seed: u64,
    /// Which light.
    pub rules: PathRules,
}

/// A picture of a solution.
pub fn look(
    loaded: &Loaded,
    solved: &Solved,
    how: &View,
    threads: Option<usize>,
    cancel: &CancelToken,
) -> Result<Picture, RenderError> {
    let scene = &loaded.scene;
    let view = scene.views.get(how.view).ok_or_else(|| RenderError(format!("there is no view {}", how.view)))?;
    let pool = pool::pool(threads)?;
    let run = Run {
        view: how.view,
        seed: how.seed,
        sequence: Default::default(),
        stop: Stop::Samples(how.spp),
        spread: Spread::Uniform,
        rules: how.rules,
        digest: 0,
        pool: &pool,
        cancel,
        progress: &Progress::default(),
        events: &|_| (),
        checkpoint_every: None,
    };
    let shown = pool.install(|| Shown::new(scene, solved, &how.rules, how.show));
    let shape = FilmShape { size: view.film.crop_size, kernel: view.film.filter };
    let film = Film::new(shape);
    let end = etendue_solvers::render(&Look(&shown), "radiosity", scene, &run, &film, None);
    let passes = end.map_err(|e| RenderError(e.to_string()))?.passes;
    picture(film.develop(), view.film.channels, shape.size, Vec::new(), words(loaded, "radiosity", passes, &run, view))
}
