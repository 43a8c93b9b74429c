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
//! | [`direct`] | direct light alone, with several samples of each kind |
//! | [`oracle`] | the textbook's recursion, word for word: slow, and the judge of the others |
//!
//! A solver works in passes and owns no loop, clock, file or message: that is the driver's part ([`drivers`]).

pub mod aov;
pub mod direct;
pub mod drivers;
pub mod oracle;
pub mod path;
pub mod path_mis;
pub mod path_nee;
pub mod run;
pub mod solver;
pub mod transport;

pub use drivers::{Checkpoint, Outcome, Work, render};
pub use run::{CancelToken, Event, Progress, Run, Stop, Stopped};
pub use solver::{AnySolver, Refusal, SOLVERS, Solver, SolverInfo};
pub use transport::PathRules;
