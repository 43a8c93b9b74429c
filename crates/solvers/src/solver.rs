//! What a solver is, and the list of them all.

use crate::bidirectional::Bidirectional;
use crate::direct::Direct;
use crate::distribution::Distribution;
use crate::drivers::{Balance, Work};
use crate::light::Light;
use crate::light_nee::LightNee;
use crate::metropolis::Metropolis;
use crate::metropolis::bootstrap::ReplayDiffers;
use crate::parameters::{self, Parameter, ParameterError, ParameterInfo};
use crate::path::Path;
use crate::path_guided::PathGuided;
use crate::path_mis::PathMis;
use crate::path_nee::PathNee;
use crate::photon_map::PhotonMap;
use crate::radiosity::Radiosity;
use crate::run::Run;
use crate::transport::sees_mirrors;
use crate::whitted::Whitted;
use etendue_scene::{Integrator, Material, Scene};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt;

/// A way to solve the rendering equation, in passes: pass k is a pure function of (seed, k, the state after pass k - 1).
pub trait Solver: Sync {
    /// What one pass hands to the next: chains, radii, a learnt distribution; often nothing.
    type State: Serialize + DeserializeOwned + Send;

    /// What a scene must have, or must not have.
    fn needs(&self) -> Needs;

    /// What its picture is an estimate of: what it may be held to.
    fn estimates(&self) -> Estimates {
        Estimates::Light
    }

    /// Why it cannot do a scene with the parameters that it has; asked after [`Solver::needs`].
    fn refuses(&self, _: &Scene) -> Option<Refusal> {
        None
    }

    /// Into how many units of work a pass over a picture of this size is cut: a function of the size alone.
    fn units(&self, size: [u32; 2]) -> usize;

    /// Whether a pass can take more samples in one pixel than in another ([`Work::allocation`]).
    fn adapts(&self) -> bool {
        false
    }

    /// Whether what it finds may fall anywhere on the film ([`etendue_film::Film::add_splats`]), not within tiles alone.
    fn splats(&self) -> bool;

    /// Bytes that its state holds, about, for a picture of this size.
    fn holds(&self, _: [u32; 2]) -> u64 {
        0
    }

    /// Where the light went so far, where the solver keeps books.
    fn books(&self, _: &Self::State) -> Option<Balance> {
        None
    }

    /// The state before pass 0.
    fn prepare(&self, scene: &Scene, run: &Run<'_>) -> Self::State;

    /// Pass k: adds what it measures to `work.film`. An error ends the render, which keeps what it has.
    fn pass(&self, scene: &Scene, run: &Run<'_>, state: &mut Self::State, k: u32, work: &Work<'_>) -> Result<(), CannotGoOn>;
}

/// Why a solver cannot go on: it has found out that what it would add could not be trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CannotGoOn {
    /// A path was another when it was replayed from the numbers that it was made of.
    Replay(ReplayDiffers),
}

impl fmt::Display for CannotGoOn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Replay(differs) => differs.fmt(f),
        }
    }
}

impl std::error::Error for CannotGoOn {}

/// Capabilities that a solver asks of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// Every light has an area or surrounds the scene, so that a random walk can hit it.
    pub lights_that_can_be_hit: bool,
    /// The cameras have lenses, so that a random walk can pass them.
    pub finite_lens: bool,
    /// No camera sees a mirror or smooth glass: no connection to the lens can find what they show.
    pub no_mirrors_in_view: bool,
    /// Light is red, green and blue.
    pub rgb: bool,
    /// No surface is a wall from one side and nothing from the other, as hair is, and no light shines through a portal beside other surroundings: walks from
    /// the lights cannot go the way that the eye looks.
    pub both_ways: bool,
}

/// What a solver's picture converges to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Estimates {
    /// All light that the rules count, without bias at any sample count.
    #[default]
    Light,
    /// Light of at most so many edges, without bias; passing a null or mask surface is an edge.
    LightUpTo(u32),
    /// All light in the limit of many passes, with a bias on the way there.
    InTheLimit,
    /// Something else.
    Other {
        /// What, in words.
        words: &'static str,
        /// Where all surfaces are diffuse it is all light of at most so many edges.
        diffuse: Option<u32>,
    },
}

/// Why a solver cannot do a scene, and who can.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// The reason, in words.
    pub reason: String,
    /// Solvers that can.
    pub instead: Vec<&'static str>,
}

impl Needs {
    /// Whether `scene` has what is needed.
    pub fn check(&self, scene: &Scene) -> Result<(), Refusal> {
        if self.rgb && scene.spectral {
            let reason = "patches carry red, green and blue, and no wavelengths; leave --spectral out, or say --rgb".to_owned();
            return Err(Refusal { reason, instead: vec!["path-mis"] });
        }
        if self.both_ways && scene.materials.iter().any(|m| matches!(m, Material::Hair(_))) {
            let reason = "hair takes in light that crosses it along walks from the eye alone: of walks from the lights much would be missing";
            return Err(Refusal { reason: reason.to_owned(), instead: vec!["path-mis"] });
        }
        if self.both_ways && scene.has_portals() && scene.lights.environments().len() > 1 {
            let reason = "where other surroundings shine beside it, light through a portal is known from where it is seen alone: walks from the lights cannot find it";
            return Err(Refusal { reason: reason.to_owned(), instead: vec!["path-mis"] });
        }
        let points = scene.emitters.iter().filter(|e| e.is_delta()).count();
        if self.lights_that_can_be_hit && points > 0 {
            let lights = if points == 1 {
                "one of the lights is a point, a single direction, or shines unseen".to_owned()
            } else {
                format!("{points} of the lights are points, single directions, or shine unseen")
            };
            let reason = format!("{lights}, which no random walk can hit: their light would be missing");
            return Err(Refusal { reason, instead: vec!["path-nee", "path-mis"] });
        }
        if let Some(view) = scene.views.iter().find(|v| self.finite_lens && !v.sensor.has_lens()) {
            let name = view.sensor.name().to_lowercase();
            let reason = format!("a random walk never passes the lens of a `{name}` camera, which has none of any size");
            return Err(Refusal { reason, instead: vec!["light-nee", "path"] });
        }
        if self.no_mirrors_in_view && scene.views.iter().any(|view| sees_mirrors(scene, view)) {
            let reason =
                "the camera sees a mirror or smooth glass: what it shows cannot be connected to the lens and would be missing";
            return Err(Refusal { reason: reason.to_owned(), instead: vec!["path-mis"] });
        }
        Ok(())
    }
}

/// A solver's entry in the list.
#[derive(Clone, Copy, Debug)]
pub struct SolverInfo {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it does, in a line.
    pub summary: &'static str,
}

macro_rules! declared {
    () => {
        &[]
    };
    ($parameters:expr) => {
        $parameters
    };
}

macro_rules! solvers {
    ($($(#[doc = $doc:literal])+ $variant:ident => $name:literal, $make:expr $(, $parameters:expr)?;)*) => {
        /// All solvers, each listed once.
        #[derive(Clone, Debug)]
        pub enum AnySolver {
            $($(#[doc = $doc])+ $variant($variant),)*
        }

        /// The names and summaries of all solvers.
        pub const SOLVERS: &[SolverInfo] = &[$(SolverInfo { name: $name, summary: concat!($($doc),+) },)*];

        impl AnySolver {
            /// The solver of a name, with the parameters that the scene file gives; `None` for an unknown name.
            pub fn new(name: &str, integrator: &Integrator) -> Option<Self> {
                match name {
                    $($name => Some(Self::$variant(($make)(integrator))),)*
                    _ => None,
                }
            }

            /// Its name on the command line.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$variant(_) => $name,)* }
            }

            /// The parameters that it declares, with their values.
            pub fn parameters(&self) -> Vec<ParameterInfo> {
                match &mut self.clone() { $(Self::$variant(s) => {
                    let declared: &[Parameter<$variant>] = declared!($($parameters)?);
                    parameters::list(s, declared)
                })* }
            }

            /// Sets a parameter to what `value` says.
            pub fn set(&mut self, name: &str, value: &str) -> Result<(), ParameterError> {
                match self { $(Self::$variant(s) => {
                    let declared: &[Parameter<$variant>] = declared!($($parameters)?);
                    parameters::set(s, declared, name, value)
                })* }
            }

            /// What it asks of a scene.
            pub fn needs(&self) -> Needs {
                match self { $(Self::$variant(s) => s.needs(),)* }
            }

            /// Why it cannot do a scene with the parameters that it has.
            pub fn refuses(&self, scene: &Scene) -> Option<Refusal> {
                match self { $(Self::$variant(s) => s.refuses(scene),)* }
            }

            /// Whether it can take more samples in one pixel than in another.
            pub fn adapts(&self) -> bool {
                match self { $(Self::$variant(s) => Solver::adapts(s),)* }
            }

            /// Bytes that its state holds, about, for a picture of this size.
            pub fn holds(&self, size: [u32; 2]) -> u64 {
                match self { $(Self::$variant(s) => Solver::holds(s, size),)* }
            }

            /// What its picture is an estimate of.
            pub fn estimates(&self) -> Estimates {
                match self { $(Self::$variant(s) => s.estimates(),)* }
            }

            /// Renders with it: see [`crate::drivers::render`].
            pub fn render(&self, scene: &Scene, run: &Run<'_>, film: &etendue_film::Film, resume: Option<&crate::Checkpoint>)
                -> Result<crate::Outcome, crate::drivers::CannotResume> {
                match self { $(Self::$variant(s) => crate::drivers::render(s, $name, scene, run, film, resume),)* }
            }
        }
    };
}

solvers! {
    /// A random walk that only collects light it hits.
    Path => "path", |_: &Integrator| Path;
    /// A random walk with the lights sampled at each vertex.
    PathNee => "path-nee", |_: &Integrator| PathNee;
    /// Both, combined by multiple importance sampling: the default.
    PathMis => "path-mis", |_: &Integrator| PathMis::default(), PathMis::PARAMETERS;
    /// The same, sent where photons have shown that light comes from, if that is worth its time.
    PathGuided => "path-guided", |_: &Integrator| PathGuided::default(), PathGuided::PARAMETERS;
    /// Direct light only, by light and material samples.
    Direct => "direct", |i: &Integrator| Direct { emitter_samples: i.emitter_samples, bsdf_samples: i.bsdf_samples },
        Direct::PARAMETERS;
    /// Particles from the lights that happen to pass the lens.
    Light => "light", |_: &Integrator| Light;
    /// Particles from the lights, connected to the lens at every surface.
    LightNee => "light-nee", |_: &Integrator| LightNee;
    /// Mirrors and glass over direct and ambient light, by recursion.
    Whitted => "whitted", |_: &Integrator| Whitted::default(), Whitted::PARAMETERS;
    /// The same with soft shadows and gloss, by trees of samples.
    Distribution => "distribution", |_: &Integrator| Distribution::default(), Distribution::PARAMETERS;
    /// Walks from the eye and from the lights, connected in all ways.
    Bidirectional => "bidirectional", |_: &Integrator| Bidirectional::default(), Bidirectional::PARAMETERS;
    /// Chains of such walks, each a small change of the last, that go where the light is.
    Metropolis => "metropolis", |_: &Integrator| Metropolis::default(), Metropolis::PARAMETERS;
    /// Photons from the lights, whose density the eye sees: right in the limit.
    PhotonMap => "photon-map", |_: &Integrator| PhotonMap::default(), PhotonMap::PARAMETERS;
    /// Diffuse light between patches, solved once and then looked at.
    Radiosity => "radiosity", |_: &Integrator| Radiosity::default(), Radiosity::PARAMETERS;
}
