//! The numbers of a render, as `--stats` writes them.

use etendue_solvers::Balance;
use serde::Serialize;

/// One render in numbers.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Stats {
    /// Program and version.
    pub software: String,
    /// Scene name.
    pub scene: String,
    /// Solver name.
    pub solver: String,
    /// Why it was chosen, with `--solver auto`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub because: Option<String>,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples taken per pixel.
    pub spp: u32,
    /// The fewest and the most samples of a pixel, where they differ; `spp` is their mean.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub samples: Option<[u32; 2]>,
    /// Seed.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
    /// Reading files, s.
    pub load_seconds: f64,
    /// Compiling the scene, s.
    pub build_seconds: f64,
    /// From the first ray to the last, s.
    pub render_seconds: f64,
    /// Paths started from the eye.
    pub paths: u64,
    /// Rays cast, shadow rays included.
    pub rays: u64,
    /// Largest memory held, bytes.
    pub peak_memory_bytes: u64,
    /// Samples dropped because they were not finite.
    pub nonfinite_samples: u64,
    /// Where the first of them were: x, y, sample.
    pub nonfinite_first: Vec<[u32; 3]>,
    /// Triangles, those of instances counted once.
    pub triangles: u64,
    /// Mean of the picture, linear Rec.709.
    pub mean: [f64; 3],
    /// Why the render ended: samples, time, noise, limit, cancelled.
    pub stopped: String,
    /// Estimated √relMSE in per cent with its 95 % interval, in noise mode.
    pub noise_percent: Option<[f64; 3]>,
    /// The lights, where each was rendered alone.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lights: Vec<LightStats>,
    /// Light tracers: where the flux went, W by channel, emitted = absorbed + escaped + cut + residual.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub books: Option<Balance>,
}

/// One light, rendered alone.
#[derive(Clone, Debug, Default, Serialize)]
pub struct LightStats {
    /// Its name, and its layer's.
    pub name: String,
    /// Samples taken per pixel.
    pub spp: u32,
    /// Mean of its picture, linear Rec.709.
    pub mean: [f64; 3],
    /// Estimated √relMSE in per cent with its 95 % interval, in noise mode.
    pub noise_percent: Option<[f64; 3]>,
}
