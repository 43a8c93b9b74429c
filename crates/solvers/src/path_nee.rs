//! Path tracing with next event estimation: at each vertex one light point is sampled and connected.
//!
//! ```text
//! L = Le(x_1) + Σ_k β_k · f(x_k) cosθ Le(y → x_k) V(x_k, y) / p(y)
//! ```
//!
//! Le counts only where no light sample could have found it: at the vertex that the eye sees, after a discrete (mirror or glass)
//! direction, and where the light samplers' density is zero. Counting it elsewhere as well would count direct light twice.

use crate::transport::{Context, PathSolver, PathState, Step, emission, next_event, slot};
use etendue_accel::Hit;
use etendue_numerics::Sampler;

/// The solver `path-nee`.
#[derive(Clone, Copy, Debug, Default)]
pub struct PathNee;

impl PathSolver for PathNee {
    #[inline]
    fn scatter(&self, c: &Context<'_>, state: &mut PathState, hit: Option<Hit>, u: &Sampler) -> Step {
        let x = hit.map(|hit| c.scene.interaction(&state.ray, &hit));
        let (le, pdf_light) = emission(c, state, x.as_ref());
        if pdf_light == 0.0 {
            state.collect(&c.rules, le);
        }
        let Some(x) = x.filter(|_| !c.ends(state)) else { return Step::END };
        let vertex = state.vertex(c.scene, x);
        let shadow = next_event(c, state, &vertex, u, |_, _| 1.0);
        let u_lobe = state.choices(&c.rules, &vertex, u);
        let sample = vertex.sample(u_lobe.x, u.u2(state.dim(slot::BSDF)));
        Step { shadow, goes_on: state.turn(&c.rules, &vertex, sample, u_lobe.y) }
    }
}
