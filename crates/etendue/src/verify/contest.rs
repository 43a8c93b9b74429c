//! What is rendered, and by whom.

use super::{Stopped, VerifyOptions};
use crate::choice::listed;
use crate::experiment::{BOX, ExperimentError};
use crate::load::{LoadOptions, Loaded, load};
use etendue_film::Film;
use etendue_scene::Scene;
use etendue_solvers::agreement::Renderer;
use etendue_solvers::drivers::CannotResume;
use etendue_solvers::solver::Needs;
use etendue_solvers::{AnySolver, Estimates, Outcome, Run, SOLVERS, Solver};

/// Renders any scene.
type RenderScene<'s> = dyn Fn(&Scene, &Run<'_>, &Film) -> Result<Outcome, CannotResume> + Sync + 's;

/// A solver that takes part: one of the list, or one of your own.
pub struct Entrant<'s> {
    /// Its name.
    pub name: String,
    /// What its picture is an estimate of.
    pub estimates: Estimates,
    needs: Needs,
    render: Box<RenderScene<'s>>,
}

impl<'s> Entrant<'s> {
    /// A solver of your own.
    pub fn new<S: Solver>(name: &str, solver: &'s S) -> Self {
        Self {
            name: name.to_owned(),
            estimates: solver.estimates(),
            needs: solver.needs(),
            render: Box::new(move |scene, run, film| etendue_solvers::render(solver, "guest", scene, run, film, None)),
        }
    }

    /// One of the list.
    pub fn listed(solver: AnySolver) -> Self {
        Self {
            name: solver.name().to_owned(),
            estimates: solver.estimates(),
            needs: solver.needs(),
            render: Box::new(move |scene, run, film| solver.render(scene, run, film, None)),
        }
    }

    /// Up to how many edges it shows all light of the furnace, which is diffuse; none where it claims nothing there.
    pub(super) fn in_furnace(&self) -> Option<u32> {
        match self.estimates {
            Estimates::Light | Estimates::InTheLimit => Some(u32::MAX),
            Estimates::LightUpTo(edges) => Some(edges),
            Estimates::Other { diffuse, .. } => diffuse,
        }
    }

    /// How many times wider its bounds are: solvers that connect nothing, and wait for a lamp or the lens to be hit by chance, are noisier.
    pub(super) fn leeway(&self) -> f64 {
        const CHANCE: f64 = 2.5;
        if self.needs.finite_lens || self.needs.lights_that_can_be_hit { CHANCE } else { 1.0 }
    }

    /// Renders a scene with it.
    pub(super) fn renderer<'a>(&'a self, scene: &'a Scene) -> Box<Renderer<'a>> {
        Box::new(move |run, film| (self.render)(scene, run, film))
    }
}

/// The scene at a size whose longer side is at most `options.size`, with pixels that share no samples: a filter that is divided by the sum of
/// its weights is unbiased only in the limit of many samples, and light tracers divide by no such sum.
pub(super) fn load_small(scene: &str, options: &VerifyOptions) -> Result<Loaded, ExperimentError> {
    let mut loaded = load_at_size(scene, options)?;
    loaded.scene.views.iter_mut().for_each(|v| v.film.filter = BOX);
    Ok(loaded)
}

fn load_at_size(scene: &str, options: &VerifyOptions) -> Result<Loaded, ExperimentError> {
    let at = |width: Option<u32>, height: Option<u32>| {
        let load_options = LoadOptions {
            defines: options.defines.clone(),
            width,
            height,
            threads: options.threads,
            spectral: options.spectral,
            ..LoadOptions::default()
        };
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

/// Those that take part, and those that do not, with the reason.
pub(super) struct Chosen<'s> {
    /// They estimate light without bias, all of it or a part: compared in pairs, and with the furnace.
    pub(super) entrants: Vec<Entrant<'s>>,
    /// Whatever else they estimate: compared with the furnace, where they claim to show all light.
    pub(super) beside: Vec<Entrant<'s>>,
    /// Those that are in no pair.
    pub(super) left_out: Vec<(String, String)>,
}

/// Who takes part in a scene.
pub(super) fn chosen<'s>(options: &VerifyOptions, guests: Vec<Entrant<'s>>, loaded: &Loaded) -> Stopped<Chosen<'s>> {
    let names: Vec<&str> = match &options.solvers {
        Some(names) => names.iter().map(String::as_str).collect(),
        None => SOLVERS.iter().map(|s| s.name).collect(),
    };
    let (mut entrants, mut beside, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
    let of_list = names.into_iter().map(|name| Ok(Entrant::listed(listed(name, loaded)?)));
    let of_list = of_list.collect::<Stopped<Vec<Entrant<'s>>>>()?;
    for entrant in of_list.into_iter().chain(guests) {
        let reason = match (entrant.needs.check(&loaded.scene), entrant.estimates) {
            (Err(refusal), _) => refusal.reason,
            (_, Estimates::InTheLimit) => {
                "biased at any sample count, so that it would differ: held to the furnace alone".to_owned()
            }
            (_, Estimates::Other { words, diffuse: Some(_) }) => {
                format!("it estimates other light: {words}; held to the furnace alone")
            }
            (_, Estimates::Other { words, diffuse: None }) => format!("it estimates other light: {words}"),
            (_, Estimates::Light | Estimates::LightUpTo(_)) => {
                entrants.push(entrant);
                continue;
            }
        };
        left_out.push((entrant.name.clone(), reason));
        if entrant.in_furnace().is_some() && entrant.needs.check(&loaded.scene).is_ok() {
            beside.push(entrant);
        }
    }
    Ok(Chosen { entrants, beside, left_out })
}
