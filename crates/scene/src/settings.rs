//! What a scene file asks of the rendering itself: which solver, how deep, which film, how many samples.
//! Plain data: the program hands it to films and solvers.

use crate::sensor::Sensor;
use etendue_numerics::SequenceKind;
use etendue_numerics::kernel::Kernel;

/// A sensor with the film and the samples that the file gives it.
#[derive(Clone, Debug)]
pub struct View {
    /// The camera.
    pub sensor: Sensor,
    /// Its film.
    pub film: FilmSettings,
    /// Its samples.
    pub sampler: SamplerSettings,
}

/// Size, crop and filter of a film.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmSettings {
    /// Full size in pixels.
    pub size: [u32; 2],
    /// First pixel of the part that is rendered.
    pub crop_offset: [u32; 2],
    /// Size of the part that is rendered: the picture's size.
    pub crop_size: [u32; 2],
    /// Reconstruction filter.
    pub filter: Kernel,
    /// Channels of the picture: 1 (luminance) or 3.
    pub channels: u32,
}

/// Which point set and how many samples a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SamplerSettings {
    /// The point set that the file names; étendue's own default where it says `independent`.
    pub kind: SequenceKind,
    /// Samples per pixel.
    pub count: u32,
    /// Seed.
    pub seed: u64,
}

/// The integrator that the file asks for, in étendue's names.
#[derive(Clone, Debug, PartialEq)]
pub struct Integrator {
    /// Solver name as the program knows it (`path-mis`, `direct`, …).
    pub solver: String,
    /// Edges between eye and light at most; `None` is unbounded. 1 shows emitters only.
    pub max_depth: Option<u32>,
    /// Depth from which paths are ended by Russian roulette; `None` leaves it to the solver.
    pub rr_depth: Option<u32>,
    /// Emitters are not seen directly by the camera.
    pub hide_emitters: bool,
    /// Passing a null or mask surface counts as an edge.
    pub null_counts: bool,
    /// `direct`: light samples per hit.
    pub emitter_samples: u32,
    /// `direct`: BSDF samples per hit.
    pub bsdf_samples: u32,
    /// AOV layers asked for: (layer name, quantity).
    pub aovs: Vec<(String, String)>,
}

impl Default for Integrator {
    fn default() -> Self {
        Self {
            solver: "path-mis".to_owned(),
            max_depth: None,
            rr_depth: None,
            hide_emitters: false,
            null_counts: true,
            emitter_samples: 1,
            bsdf_samples: 1,
            aovs: Vec::new(),
        }
    }
}
