//! Renders and measures.

use super::measure::{darkest, entry, layered, rel_mse, relative_variance};
use super::pictures::{Pixels, Standardised, long, spread, straight};
use super::{CompareOptions, Reference, Results};
use crate::choice::{check_solver_name, listed};
use crate::experiment::{BOX, ExperimentError, Header, renderer};
use crate::load::{LoadOptions, load};
use crate::pool;
use etendue_solvers::agreement::{REPLICATES, Trial};
use etendue_solvers::{CancelToken, Estimates};

type Compared<T> = Result<T, ExperimentError>;

/// Compares; `tell` hears what is going on.
pub fn compare(scene: &str, options: &CompareOptions, cancel: &CancelToken, tell: &dyn Fn(&str)) -> Compared<Results> {
    let reference_solver = if let Reference::Solver(name) = &options.reference { Some(name) } else { None };
    for name in options.solvers.iter().chain(reference_solver) {
        check_solver_name(name)?;
    }
    let load_options = LoadOptions {
        defines: options.defines.clone(),
        width: options.width,
        height: options.height,
        threads: options.threads,
        spectral: options.spectral,
        ..LoadOptions::default()
    };
    let mut loaded = load(scene, &load_options).map_err(ExperimentError::Load)?;
    if !matches!(options.reference, Reference::Picture(_)) {
        // Pixels that share samples would make the variance of one depend on its neighbours, and bias it at low counts.
        loaded.scene.views.iter_mut().for_each(|v| v.film.filter = BOX);
    }
    let scene = &loaded.scene;
    let pool = pool::pool(options.threads)?;
    let trial = Trial { seed: options.seed, ..Trial::new(scene, &pool, cancel) };
    let able = |name: &String| {
        let solver = listed(name, &loaded)?;
        match solver.needs().check(scene) {
            Ok(()) => Ok(solver),
            Err(why) => Err(ExperimentError::Words(format!("`{name}` cannot render this scene: {}", why.reason))),
        }
    };
    let solvers = options.solvers.iter().map(able).collect::<Compared<Vec<_>>>()?;
    let of_reference = reference_solver.map(able).transpose()?;
    let file = match &options.reference {
        Reference::Picture(path) => Some((read(path, trial.shape().size)?, format!("the picture {}", path.display()))),
        _ => None,
    };

    // The solvers, straight through and as replicates.
    let mut runs = Vec::new();
    for (i, solver) in solvers.iter().enumerate() {
        tell(&format!("rendering with {}", solver.name()));
        let render = renderer(solver, scene);
        let straight = straight(&trial, &*render, options.budget, i as u64)?;
        let spp = (straight.3 / REPLICATES).max(1);
        let spread = spread(&trial, &*render, spp, 64 + i as u64)?;
        runs.push((straight, spread));
    }

    // The reference.
    tell("rendering the reference");
    let reference = match (file, &of_reference) {
        (Some((pixels, words)), _) => {
            let variance = vec![[0.0; 3]; pixels.len()];
            Standardised { pixels, variance, sample: None, words, by: None }
        }
        (None, Some(solver)) => {
            let by = options.solvers.iter().position(|s| s == solver.name());
            long(&trial, solver, by, options.budget, by.map(|i| runs[i].1.spp))?
        }
        (None, None) => {
            let darkest = darkest(runs.iter().map(|r| r.1.pixels()));
            let noise = |i: &usize| relative_variance(&runs[*i].1, &darkest) * runs[*i].1.elapsed.as_secs_f64();
            let unbiased = (0..solvers.len()).filter(|i| solvers[*i].estimates() == Estimates::Light);
            let best = unbiased.min_by(|a, b| noise(a).total_cmp(&noise(b))).ok_or_else(|| {
                ExperimentError::Words(
                    "none of these solvers estimates all light without bias\n  help: name one with --reference".to_owned(),
                )
            })?;
            long(&trial, &solvers[best], Some(best), options.budget, Some(runs[best].1.spp))?
        }
    };

    tell("measuring");
    let tests = 3 * trial.grid().len() * (0..solvers.len()).filter(|i| reference.by != Some(*i)).count();
    let size = trial.shape().size;
    let mut entries = Vec::new();
    for (i, (solver, (straight, spread))) in solvers.iter().zip(runs).enumerate() {
        entries.push(entry(solver, &straight, &spread, &reference, reference.by == Some(i), options, tests, size)?);
    }
    let mean = trial.grid().means(&reference.pixels)[0];
    let zero = vec![[0.0f32; 3]; reference.pixels.len()];
    Ok(Results {
        header: Header::new(&loaded, &trial, options.standard),
        budget: options.budget,
        tests,
        reference_rel_mse: -rel_mse(&reference.pixels, &reference.pixels, &reference.variance),
        reference: reference.words.clone(),
        reference_mean: mean,
        solvers: entries,
        reference_picture: layered(size, &reference.pixels, &reference.variance, &zero)?,
    })
}

/// A picture file as a reference.
fn read(path: &std::path::Path, size: [u32; 2]) -> Compared<Pixels> {
    let image = etendue_image::load(path).map_err(|e| ExperimentError::Words(e.to_string()))?;
    let found = [image.width() as u32, image.height() as u32];
    if found != size {
        let words = format!("{} is {} x {}, and the render {} x {}", path.display(), found[0], found[1], size[0], size[1]);
        return Err(ExperimentError::Words(words + "\n  help: --width and --height set the size of the render"));
    }
    let linear = image.to_linear().to_rgb();
    Ok(linear.pixels().map(|p| [p[0], p[1], p[2]].map(|x| if x.is_finite() { x } else { 0.0 })).collect())
}
