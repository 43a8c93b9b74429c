//! What is rendered, and by whom.

use super::VerifyOptions;
use crate::experiment::{BOX, ExperimentError};
use crate::load::{LoadOptions, Loaded, load};
use etendue_scene::Scene;
use etendue_solvers::{AnySolver, Estimates, SOLVERS};

/// The scene at a size whose longer side is at most `options.size`, with pixels that share no samples: a filter that is divided by the sum of
/// its weights is unbiased only in the limit of many samples, and light tracers divide by no such sum.
pub(super) fn load_small(scene: &str, options: &VerifyOptions) -> Result<Loaded, ExperimentError> {
    let mut loaded = load_at_size(scene, options)?;
    loaded.scene.views.iter_mut().for_each(|v| v.film.filter = BOX);
    Ok(loaded)
}

fn load_at_size(scene: &str, options: &VerifyOptions) -> Result<Loaded, ExperimentError> {
    let at = |width: Option<u32>, height: Option<u32>| {
        let load_options = LoadOptions { defines: options.defines.clone(), width, height, threads: options.threads };
        load(scene, &load_options).map_err(ExperimentError::Load)
    };
    let loaded = at(None, None)?;
    let Some(view) = loaded.scene.views.first() else {
        return Err(ExperimentError::Words("the scene has no sensor".to_owned()));
    };
    let [w, h] = view.film.size;
    let scale = f64::from(options.size) / f64::from(w.max(h));
    if scale >= 1.0 {
        return Ok(loaded);
    }
    let small = |n: u32| Some(((f64::from(n) * scale).round() as u32).max(1));
    at(small(w), small(h))
}

/// The solvers that take part, and those that do not, with the reason.
pub(super) fn chosen(options: &VerifyOptions, scene: &Scene) -> (Vec<AnySolver>, Vec<(String, String)>) {
    let names: Vec<&str> = match &options.solvers {
        Some(names) => names.iter().map(String::as_str).collect(),
        None => SOLVERS.iter().map(|s| s.name).collect(),
    };
    let (mut solvers, mut left_out) = (Vec::new(), Vec::new());
    for name in names {
        let Some(solver) = AnySolver::new(name, &scene.integrator) else {
            left_out.push((name.to_owned(), "it stands for one of the others".to_owned()));
            continue;
        };
        let reason = match (solver.needs().check(scene), solver.estimates()) {
            (Err(refusal), _) => refusal.reason,
            (_, Estimates::InTheLimit) => {
                "biased at any sample count: held to its rate of convergence, not to agreement".to_owned()
            }
            (_, Estimates::Other(words)) => format!("it estimates other light: {words}"),
            (_, Estimates::Light | Estimates::LightUpTo(_)) => {
                solvers.push(solver);
                continue;
            }
        };
        left_out.push((name.to_owned(), reason));
    }
    (solvers, left_out)
}
