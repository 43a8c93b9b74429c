//! Layers beside the picture: quantities of the first surfaces, through the same filter.

use crate::load::Loaded;
use crate::render::RenderError;
use etendue_film::{Film, FilmShape};
use etendue_image::{Image, Layer};
use etendue_solvers::aov::{Aov, Quantity};
use etendue_solvers::{CancelToken, Progress, Run, Spread, Stop};

/// Samples per pixel of a layer at most: its edges are as smooth then as any display shows.
const MOST_SAMPLES: u32 = 64;

/// A layer to be made.
pub(crate) struct Plan {
    pub(crate) name: String,
    pub(crate) quantity: Quantity,
}

/// The layers that the scene file names and those asked for beside them; refused before anything is rendered where one cannot be had.
pub(crate) fn plan(loaded: &Loaded, asked: &[Quantity]) -> Result<Vec<Plan>, RenderError> {
    let mut plans: Vec<Plan> = Vec::new();
    for (name, what) in &loaded.scene.integrator.aovs {
        let Some(quantity) = Quantity::from_name(what) else {
            let known: Vec<_> = Quantity::ALL.iter().map(|(_, _, theirs, _)| *theirs).collect();
            let words = format!("the layer `{name}` holds `{what}`, which cannot be rendered yet");
            return Err(RenderError(format!("{words}\n  help: layers that can: {}", known.join(", "))));
        };
        plans.push(Plan { name: name.clone(), quantity });
    }
    for quantity in asked {
        // Asked for twice is had once.
        if !plans.iter().any(|p| p.name == quantity.name() && p.quantity == *quantity) {
            plans.push(Plan { name: quantity.name().to_owned(), quantity: *quantity });
        }
    }
    for (i, plan) in plans.iter().enumerate() {
        if plan.name.is_empty() || plans[..i].iter().any(|p| p.name == plan.name) {
            return Err(RenderError(format!("two layers would be called `{}`: each needs a name of its own", plan.name)));
        }
    }
    Ok(plans)
}

/// Bytes of the finished layers, per pixel.
pub(crate) fn bytes_per_pixel(plans: &[Plan]) -> u64 {
    plans.iter().map(|p| size_of::<f32>() as u64 * p.quantity.channels().len() as u64).sum()
}

/// Renders the layers, one after the other, so that only one film is held at a time.
pub(crate) fn render(
    plans: &[Plan],
    passes: u32,
    samples: Option<&[u32]>,
    loaded: &Loaded,
    run: &Run<'_>,
    shape: FilmShape,
) -> Result<Vec<Layer>, RenderError> {
    let (progress, cancel) = (Progress::default(), CancelToken::default());
    let quiet = Run {
        stop: Stop::Samples(passes.clamp(1, MOST_SAMPLES)),
        spread: Spread::Uniform,
        progress: &progress,
        cancel: &cancel,
        events: &|_| (),
        checkpoint_every: None,
        ..*run
    };
    let [width, height] = shape.size.map(|n| n as usize);
    let layer = |plan: &Plan, data: Vec<f32>| {
        let image = Image::from_data(width, height, plan.quantity.channels(), data).map_err(|e| RenderError(e.to_string()))?;
        Ok(Layer { name: plan.name.clone(), image })
    };
    let one = |plan: &Plan| {
        if plan.quantity == Quantity::Samples {
            let counts = samples.map_or_else(|| vec![passes as f32; width * height], |s| s.iter().map(|n| *n as f32).collect());
            return layer(plan, counts);
        }
        let film = Film::new(shape);
        etendue_solvers::render(&Aov(plan.quantity), "aov", &loaded.scene, &quiet, &film, None)
            .map_err(|e| RenderError(e.to_string()))?;
        let names = plan.quantity.channels();
        let data = film.develop().iter().flat_map(|p| p.iter().take(names.len()).copied()).collect();
        layer(plan, data)
    };
    plans.iter().map(one).collect()
}
