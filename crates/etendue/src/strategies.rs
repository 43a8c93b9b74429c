//! The pyramid of bidirectional path tracing [Veach 1997, fig. 10.2]: what each strategy (s, t) finds alone, and its share of the picture.
//!
//! ```text
//! (0, 2) (1, 1)                     1 edge: emitters, seen
//! (0, 3) (1, 2) (2, 1)              2 edges: direct light
//! (0, 4) (1, 3) (2, 2) (3, 1)       3 edges, …
//! ```
//!
//! s vertices come from a light's walk, t from the eye's, the lens included. (0, t) is `path`, (1, t) next event estimation, (s, 1) `light-nee`. Unweighted pictures of a row
//! show the same light with other noise, where a strategy can find it at all; weighted ones of all rows add up to the picture.

use crate::experiment::ExperimentError;
use crate::load::{LoadOptions, load};
use crate::picture::{picture, words};
use crate::render::view;
use crate::{memory, pool};
use etendue_image::{Image, Layer, Picture, ToneMap};
use etendue_numerics::SequenceKind;
use etendue_solvers::bidirectional::Bidirectional;
use etendue_solvers::bidirectional::strategies::{StrategyPicture, pictures};
use etendue_solvers::{CancelToken, PathRules, Progress, Run, Solver, Spread, Stop};

/// Bytes of a pixel of a strategy, weighted and not, films and finished pictures together.
const BYTES: u64 = 256;
/// Pixels between pictures.
const GAP: usize = 4;

/// What is rendered.
#[derive(Clone, Debug)]
pub struct StrategyOptions {
    /// How the scene is loaded.
    pub load: LoadOptions,
    /// Which of its views.
    pub view: usize,
    /// Samples per pixel.
    pub spp: u32,
    /// Vertices of a path at most, s + t.
    pub vertices: u32,
    /// Seed.
    pub seed: u64,
}

/// All strategies' pictures.
#[derive(Clone, Debug)]
pub struct Pyramid {
    /// Pixels.
    pub size: [u32; 2],
    /// In the order of s + t and then of s.
    pub strategies: Vec<StrategyPicture>,
    attributes: Vec<(String, String)>,
}

/// Renders every strategy's picture, of paths of at most so many vertices.
pub fn pyramid(
    scene: &str,
    options: &StrategyOptions,
    cancel: &CancelToken,
    tell: &dyn Fn(&str),
) -> Result<Pyramid, ExperimentError> {
    let loaded = load(scene, &options.load).map_err(ExperimentError::Load)?;
    let seen = view(&loaded, options.view)?;
    let solver = Bidirectional::default();
    if let Err(refusal) = solver.needs().check(&loaded.scene) {
        return Err(ExperimentError::Words(format!("bidirectional cannot render this scene: {}", refusal.reason)));
    }
    let size = seen.film.crop_size;
    let count = u64::from(options.vertices * (options.vertices + 1) / 2);
    let bytes = size.map(u64::from).iter().product::<u64>().saturating_mul(count * BYTES);
    if memory::available().is_some_and(|free| bytes > free) {
        let words = "the pictures of all strategies have no room in memory\n  help: a smaller --width, or fewer --vertices";
        return Err(ExperimentError::Words(words.to_owned()));
    }
    let pool = pool::pool(options.load.threads)?;
    let progress = Progress::default();
    let rules = PathRules::of(&loaded.scene.integrator);
    let run = Run {
        view: options.view,
        seed: options.seed,
        sequence: SequenceKind::Sobol,
        stop: Stop::Samples(options.spp),
        spread: Spread::Uniform,
        rules: PathRules { max_edges: rules.max_edges.min(options.vertices - 1), ..rules },
        digest: 0,
        pool: &pool,
        cancel,
        progress: &progress,
        events: &|_| (),
        checkpoint_every: None,
    };
    tell("rendering each strategy");
    let strategies = pictures(&solver, &loaded.scene, &run, options.spp, options.vertices);
    if cancel.is_cancelled() {
        return Err(ExperimentError::Cancelled);
    }
    Ok(Pyramid { size, strategies, attributes: words(&loaded, "bidirectional", options.spp, &run, seen) })
}

impl Pyramid {
    /// The picture, as the sum of all weighted ones, and in layers (`s1t2-weighted`, `s1t2-unweighted`, …) all there is.
    pub fn layers(&self) -> Result<Picture, ExperimentError> {
        let [width, height] = self.size.map(|n| n as usize);
        let mut sum = vec![[0f32; 3]; width * height];
        let mut layers = Vec::new();
        for part in &self.strategies {
            for (sum, weighted) in sum.iter_mut().zip(&part.weighted) {
                sum.iter_mut().zip(weighted).for_each(|(s, w)| *s += w);
            }
            for (pixels, word) in [(&part.weighted, "weighted"), (&part.unweighted, "unweighted")] {
                let image = Image::rgb(width, height, pixels.as_flattened().to_vec());
                let image = image.map_err(|e| ExperimentError::Words(e.to_string()))?;
                layers.push(Layer { name: format!("s{}t{}-{word}", part.s, part.t), image });
            }
        }
        Ok(picture(sum, 3, self.size, layers, self.attributes.clone())?)
    }

    /// The pyramid as one picture for a display: a row for each number of edges, s from left to right.
    pub fn shown(&self, weighted: bool, tone: ToneMap) -> Result<Picture, ExperimentError> {
        let words = |e: &dyn std::fmt::Display| ExperimentError::Words(e.to_string());
        let [w, h] = self.size.map(|n| n as usize);
        let rows = self.strategies.iter().map(|p| (p.s + p.t) as usize - 1).max().unwrap_or(1);
        let (width, height) = ((rows + 1) * (w + GAP) - GAP, rows * (h + GAP) - GAP);
        let mut data = vec![1f32; 3 * width * height];
        let mut encoding = None;
        for part in &self.strategies {
            let pixels = if weighted { &part.weighted } else { &part.unweighted };
            let image = tone.image(&Image::rgb(w, h, pixels.as_flattened().to_vec()).map_err(|e| words(&e))?);
            encoding = Some(image.encoding());
            let row = (part.s + part.t) as usize - 2;
            // Rows are centred.
            let (left, top) = (part.s as usize * (w + GAP) + (rows - 1 - row) * (w + GAP) / 2, row * (h + GAP));
            for (y, line) in image.data().chunks_exact(3 * w).enumerate() {
                let at = 3 * ((top + y) * width + left);
                data[at..at + 3 * w].copy_from_slice(line);
            }
        }
        let mut image = Image::rgb(width, height, data).map_err(|e| words(&e))?;
        if let Some(encoding) = encoding {
            image = image.with_encoding(encoding);
        }
        Ok(Picture { image, layers: Vec::new(), attributes: self.attributes.clone() })
    }
}
