//! Renders a scene with several solvers at equal time or equal samples, and measures how far each is from a reference.
//!
//! Each solver renders twice: once straight through, with the error noted after 1, 2, 4, 8, … passes, and once as K = 16 independent replicates
//! of a sixteenth of the work, from whose spread come the variance of each pixel, the interval of the bias, and the test of agreement.
//!
//! The reference is a picture file, or the mean of 16 further replicates that take four times a solver's time together: rendered by the solver
//! that was named, or otherwise by the one of those compared whose pictures are all light, unbiased, and the least noisy. Its own
//! variance is known then, and is taken off the errors:
//!
//! ```text
//! relMSE = mean(((x - r)² - s_r²/K) / (r² + e)),    e = 0.01 · (mean of r)²
//! slope  = d log relMSE / d log t: -1 for independent samples
//! ```

pub(crate) mod maps;
mod measure;
mod page;
mod pictures;
mod plot;
mod run;

pub use page::page;
pub use plot::{COLOURS, axis_number};
pub use run::compare;

use crate::experiment::Header;
use etendue_image::Picture;
use etendue_solvers::agreement::{Agreement, Standard};
use serde::Serialize;
use std::time::Duration;

/// How much each solver may do.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Budget {
    /// Time for the straight render, and as much again for the replicates.
    Time(Duration),
    /// Samples per pixel of each.
    Samples(u32),
}

/// What the solvers are held against.
#[derive(Clone, Debug, PartialEq)]
pub enum Reference {
    /// The least noisy of the solvers that are compared.
    Best,
    /// This solver.
    Solver(String),
    /// A picture, taken as exact.
    Picture(std::path::PathBuf),
}

/// How to compare.
#[derive(Clone, Debug)]
pub struct CompareOptions {
    /// Solvers by name.
    pub solvers: Vec<String>,
    /// What they are held against.
    pub reference: Reference,
    /// How much each may do.
    pub budget: Budget,
    /// Film width, pixels.
    pub width: Option<u32>,
    /// Film height, pixels.
    pub height: Option<u32>,
    /// Seed.
    pub seed: u64,
    /// Threads; all cores otherwise.
    pub threads: Option<usize>,
    /// Values for the file's `<default>` parameters.
    pub defines: Vec<(String, String)>,
    /// Whether walks carry wavelengths; as the file's format has it otherwise.
    pub spectral: Option<bool>,
    /// How strictly is judged.
    pub standard: Standard,
}

/// The error after some passes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Passes.
    pub passes: u32,
    /// Time to there, s.
    pub seconds: f64,
    /// relMSE, the reference's own taken off.
    pub rel_mse: f64,
}

/// One solver's result.
#[derive(Clone, Debug, Serialize)]
pub struct Entry {
    /// Its name.
    pub solver: String,
    /// Samples per pixel of the straight render.
    pub spp: u32,
    /// Time that it took, s.
    pub seconds: f64,
    /// Rays that it cast.
    pub rays: u64,
    /// Its relMSE, the reference's own taken off.
    pub rel_mse: f64,
    /// 1 / (relMSE · s): how much a second is worth.
    pub efficiency: f64,
    /// Mean of the replicates less the reference, of the luminance, relative.
    pub bias: f64,
    /// Half the width of its 95 % confidence interval.
    pub bias_half_width: f64,
    /// Exponent of the error against time, fitted; none with fewer than three points.
    pub slope: Option<f64>,
    /// Errors along the way.
    pub series: Vec<Point>,
    /// Samples per pixel of each replicate.
    pub replicate_spp: u32,
    /// Replicates.
    pub replicates: u32,
    /// Mean over the pixels of the variance of a picture of one second, relative to r² + e.
    pub variance_second: f64,
    /// Its pictures are right in the limit only.
    pub biased: bool,
    /// The test against the reference; none for the solver that made it, nor for one that is biased by design.
    pub agreement: Option<Agreement>,
    /// Samples that were not finite.
    pub dropped: u64,
    /// The picture, with layers: standard error per pixel, difference from the reference.
    #[serde(skip)]
    pub picture: Picture,
}

/// All results.
#[derive(Clone, Debug, Serialize)]
pub struct Results {
    /// Scene, size, seed and the like.
    #[serde(flatten)]
    pub header: Header,
    /// How much each solver could do.
    pub budget: Budget,
    /// Comparisons in the family of all tests.
    pub tests: usize,
    /// What the reference is, in words.
    pub reference: String,
    /// relMSE of the reference itself, from its replicates; zero for a picture file.
    pub reference_rel_mse: f64,
    /// Mean of the reference, linear Rec.709.
    pub reference_mean: [f64; 3],
    /// The solvers, in the order they were named.
    pub solvers: Vec<Entry>,
    /// The reference.
    #[serde(skip)]
    pub reference_picture: Picture,
}
