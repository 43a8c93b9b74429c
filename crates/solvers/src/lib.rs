//! The verbs: solvers of the rendering equation, one short file each, and the drivers that run them.
//!
//! ```text
//! L(x, wo) = Le(x, wo) + ∫ f(wi, x, wo) · L(RT(x, wi), -wi) · cosθ dwi
//! ```
//!
//! | solver | estimates the integral by |
//! | --- | --- |
//! | [`path`] | a random walk that collects the light it happens to hit |
//! | [`path_nee`] | a walk that samples the lights at every vertex (next event estimation) |
//! | [`path_mis`] | both at once, weighted by multiple importance sampling |
//! | [`path_guided`] | the same walk, sent where photons have shown that light comes from |
//! | [`direct`] | direct light alone, with several samples of each kind |
//! | [`whitted`] | a tree of mirrored and refracted rays over direct and ambient light |
//! | [`distribution`] | the same with rays spread over lights and glossy lobes |
//! | [`light`] | particles from the lights that happen to pass the lens: the dual of [`path`] |
//! | [`light_nee`] | particles connected to the lens at every surface: the dual of [`path_nee`] |
//! | [`bidirectional`] | a walk from either end, connected in all ways, weighted by multiple importance sampling |
//! | [`metropolis`] | chains of such paths, each a small change of the last, that go where the light is |
//! | [`photon_map`] | photons from the lights, whose density the eye sees |
//! | [`radiosity`] | one linear equation between patches, solved before the eye opens |
//! | [`oracle`] | the textbook's recursion, word for word: slow, and the judge of the others |
//! | [`oracle_light`] | the textbook's particle shooting, word for word: the judge of the light tracers |
//!
//! A solver works in passes and owns no loop, clock, file or message: that is the driver's part ([`drivers`]).

pub mod agreement;
pub mod aov;
pub mod bidirectional;
pub mod choosing;
pub mod direct;
pub mod distribution;
pub mod drivers;
pub mod irradiance;
mod lanes;
pub mod light;
pub mod light_nee;
pub mod metropolis;
mod neighbours;
pub mod oracle;
pub mod oracle_light;
pub mod parameters;
pub mod path;
pub mod path_guided;
pub mod path_mis;
pub mod path_nee;
pub mod photon_map;
pub mod radiosity;
pub mod run;
pub mod solver;
pub mod transport;
pub mod whitted;

pub use drivers::{Balance, Checkpoint, Outcome, Work, render};
pub use parameters::{ParameterError, ParameterInfo};
pub use run::{CancelToken, Event, Progress, Run, Spread, Stop, Stopped};
pub use solver::{AnySolver, CannotGoOn, Estimates, Refusal, SOLVERS, Solver, SolverInfo};
pub use transport::PathRules;
