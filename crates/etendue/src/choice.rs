//! Which solver renders: the caller's choice, or what the scene file asks for.

use crate::load::Loaded;
use crate::render::{RenderError, RenderOptions, rules, view};
use etendue_description::nearest;
use etendue_solvers::aov::{Aov, Quantity};
use etendue_solvers::choosing::Advice;
use etendue_solvers::{AnySolver, ParameterError, Refusal, SOLVERS};

/// Chooses one of the others.
pub(crate) const AUTO: &str = "auto";

/// Names that show what the eye sees first, as numbers: Mitsuba's `depth`, and `aov` without an integrator of light.
const SHOWING: &[&str] = &["depth", "aov"];

/// What fills the film.
pub(crate) enum Choice {
    /// Light.
    Solver(Box<AnySolver>),
    /// A quantity of the first surfaces.
    Quantity(Aov),
}

impl Choice {
    /// Bytes that the solver's state holds, about, for a picture of this size.
    pub(crate) fn holds(&self, size: [u32; 2]) -> u64 {
        match self {
            Self::Solver(solver) => solver.holds(size),
            Self::Quantity(_) => 0,
        }
    }

    /// Whether it can take more samples in one pixel than in another.
    pub(crate) fn adapts(&self) -> bool {
        match self {
            Self::Solver(solver) => solver.adapts(),
            Self::Quantity(_) => true,
        }
    }

    /// Whether walks of neighbouring pixels share what they find.
    pub(crate) fn shares(&self) -> bool {
        matches!(self, Self::Solver(solver) if solver.parameters().iter().any(|p| p.name == "block" && p.value != "1"))
    }

    /// The solver's parameters as `name=value`, with spaces between; defaults included.
    pub(crate) fn parameters(&self) -> String {
        match self {
            Self::Solver(solver) => {
                solver.parameters().iter().map(|p| format!("{}={}", p.name, p.value)).collect::<Vec<_>>().join(" ")
            }
            Self::Quantity(_) => String::new(),
        }
    }
}

/// Refuses a name that no solver has, with the nearest one that some solver has; for callers who know the name before the scene.
pub fn check_solver_name(name: &str) -> Result<(), RenderError> {
    let known = || SOLVERS.iter().map(|s| s.name).chain(SHOWING.iter().copied());
    if known().chain([AUTO]).any(|n| n == name) {
        return Ok(());
    }
    let mut words = format!("no solver is called `{name}`");
    if let Some(near) = nearest(name, known().chain([AUTO])) {
        words += &format!("\n  help: did you mean `{near}`?");
    }
    Err(RenderError(words + &format!("\n  help: solvers: {}; or {AUTO}", solver_names())))
}

/// The solver that `auto` stands for, where options or scene ask for it: a function of scene, view and rules alone.
pub fn advise(loaded: &Loaded, options: &RenderOptions) -> Result<Option<Advice>, RenderError> {
    if options.solver.as_deref().unwrap_or(&loaded.scene.integrator.solver) != AUTO {
        return Ok(None);
    }
    view(loaded, options.view)?;
    Ok(Some(etendue_solvers::choosing::advise(&loaded.scene, options.view, rules(loaded, options))))
}

fn solver_names() -> String {
    SOLVERS.iter().map(|s| s.name).collect::<Vec<_>>().join(", ")
}

/// The solver of a name that [`check_solver_name`] knows, if it is one that renders light by itself.
pub(crate) fn listed(name: &str, loaded: &Loaded) -> Result<AnySolver, RenderError> {
    AnySolver::new(name, &loaded.scene.integrator).ok_or_else(|| {
        RenderError(match SHOWING.contains(&name) {
            true => {
                format!("`{name}` shows no light, but what the eye sees first, as numbers\n  help: etendue render --solver {name}")
            }
            false => format!("`{name}` stands for one of the others\n  help: solvers: {}", solver_names()),
        })
    })
}

/// The solver of `asked`, or of the scene; refused in words where the scene is not for it.
/// `parameters` are set on it in their order.
pub(crate) fn choose(asked: Option<&str>, parameters: &[(String, String)], loaded: &Loaded) -> Result<Choice, RenderError> {
    let integrator = &loaded.scene.integrator;
    let name = asked.unwrap_or(&integrator.solver);
    if SHOWING.contains(&name) {
        if let Some((parameter, _)) = parameters.first() {
            return Err(RenderError(format!("`{name}` has no parameters, and `{parameter}` is given")));
        }
        return shown_quantity(name, loaded).map(|q| Choice::Quantity(Aov(q)));
    }
    check_solver_name(name)?;
    let mut solver = listed(name, loaded)?;
    let refused = |refusal: Refusal| {
        let instead = refusal.instead.join(" or --solver ");
        RenderError(format!("`{name}` cannot render this scene: {}\n  help: try --solver {instead}", refusal.reason))
    };
    solver.needs().check(&loaded.scene).map_err(refused)?;
    set(&mut solver, parameters)?;
    if let Some(refusal) = solver.refuses(&loaded.scene) {
        return Err(refused(refusal));
    }
    Ok(Choice::Solver(Box::new(solver)))
}

/// Sets parameters; an unknown one is refused with the nearest that the solver has.
fn set(solver: &mut AnySolver, parameters: &[(String, String)]) -> Result<(), RenderError> {
    for (name, value) in parameters {
        solver.set(name, value).map_err(|e| {
            let solver = solver.name();
            RenderError(match &e {
                ParameterError::Unknown { known, .. } => {
                    let near = nearest(name, known.iter().copied()).map(|near| format!("\n  help: did you mean `{near}`?"));
                    let list = match known.is_empty() {
                        true => "it has none".to_owned(),
                        false => format!("it has {}", known.join(", ")),
                    };
                    format!("the solver `{solver}` has no parameter `{name}`{}\n  help: {list}", near.unwrap_or_default())
                }
                ParameterError::Invalid { .. } => format!("a parameter of `{solver}`: {e}"),
            })
        })?;
    }
    Ok(())
}

/// `depth` shows depth; `aov` the first layer that the scene names.
fn shown_quantity(name: &str, loaded: &Loaded) -> Result<Quantity, RenderError> {
    if name == "depth" {
        return Ok(Quantity::Depth);
    }
    let first = loaded.scene.integrator.aovs.first();
    let none = || {
        RenderError("`aov` shows the layers that a scene file names, and this one names none\n  help: try --aov albedo,normal,depth beside the picture".to_owned())
    };
    first.and_then(|(_, quantity)| Quantity::from_name(quantity)).ok_or_else(none)
}
