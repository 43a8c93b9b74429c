//! What the path solvers share: the state of a walk, the vertex and its adjoint corrections, next event estimation, MIS weights,
//! roulette. Free functions, no bases.

mod mis;
mod next_event;
mod path_state;
mod roulette;
mod rules;
mod vertex;

pub use mis::{Heuristic, mis_weight};
pub use next_event::{ShadowQuery, next_event};
pub(crate) use path_state::emission;
pub use path_state::{Context, PathSolver, PathState, Step, Throughput, arrives, slot, trace};
pub use roulette::roulette;
pub use rules::PathRules;
pub use vertex::{Vertex, VertexSample};
