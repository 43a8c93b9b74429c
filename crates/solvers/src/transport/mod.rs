//! What the path solvers share: the state of a walk, the vertex and its adjoint corrections, an index of vertices, next event
//! estimation, MIS weights, roulette. Free functions, no bases.

mod adjoint;
mod crowd;
mod each_light;
mod mirrors;
mod mis;
mod next_event;
mod particle;
mod path_state;
mod roulette;
mod rules;
mod tally;
mod tree;
mod vertex;
mod vertex_index;

pub use crowd::Crowd;
pub use each_light::EachLight;
pub(crate) use mirrors::sees_mirrors;
pub use mis::{Heuristic, mis_weight};
pub use next_event::{ShadowQuery, connection, connection_of, next_event};
pub use particle::{
    Awaited, Came, LightContext, Particle, SensorQuery, arrives_at_sensor, emitter_to_sensor, light_slot, surroundings,
    through_lens, to_sensor,
};
pub(crate) use path_state::emission;
pub use path_state::{Context, PathSolver, PathState, Step, Throughput, arrives, slot, trace};
pub use roulette::roulette;
pub(crate) use roulette::{HOPE, HOPE_OF_LIGHT, roulette_survival};
pub use rules::PathRules;
pub use tally::{Entries, Tally};
pub use tree::Branch;
pub use vertex::{Vertex, VertexSample};
pub use vertex_index::VertexIndex;
