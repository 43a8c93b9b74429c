//! What `verify` and `compare` share: how solvers are rendered for statistics, how a report begins, why there is none.

use crate::load::{LoadError, Loaded};
use crate::render::{RenderError, software};
use etendue_numerics::kernel::Kernel;
use etendue_scene::Scene;
use etendue_solvers::AnySolver;
use etendue_solvers::agreement::{Grid, NoPicture, Renderer, Standard, Trial};
use serde::Serialize;

/// Why there is no result.
#[derive(Debug)]
pub enum ExperimentError {
    /// There is no scene.
    Load(LoadError),
    /// In words.
    Words(String),
    /// It was asked to stop.
    Cancelled,
}

impl From<RenderError> for ExperimentError {
    fn from(e: RenderError) -> Self {
        Self::Words(e.to_string())
    }
}

impl From<NoPicture> for ExperimentError {
    fn from(why: NoPicture) -> Self {
        match why {
            NoPicture::Cancelled => Self::Cancelled,
            NoPicture::Failed(why) => Self::Words(why.to_string()),
        }
    }
}

/// What every report begins with.
#[derive(Clone, Debug, Serialize)]
pub struct Header {
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
}

impl Header {
    /// Of a trial on a scene.
    pub(crate) fn new(scene: &Loaded, trial: &Trial<'_>, standard: Standard) -> Self {
        let Grid { size, blocks } = trial.grid();
        let threads = trial.pool.current_num_threads();
        Self { software: software(), scene: scene.name.clone(), size, blocks, seed: trial.seed, threads, standard }
    }
}

/// A pixel's samples are its own.
pub(crate) const BOX: Kernel = Kernel::Box { radius: 0.5 };

/// The renderer of a solver from the list.
pub(crate) fn renderer<'a>(solver: &'a AnySolver, scene: &'a Scene) -> Box<Renderer<'a>> {
    Box::new(move |run, film| solver.render(scene, run, film, None))
}
