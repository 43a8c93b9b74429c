//! Path tracing without next event estimation: a random walk from the eye that collects the light it happens to hit.
//!
//! ```text
//! L = Σ_k β_k Le(x_k → x_{k-1}),    β_{k+1} = β_k · f(x_k) cosθ_k / p(w_k)
//! ```
//!
//! Unbiased for every light that can be hit; the noisiest of its family, and the simplest [Kajiya 1986].

use crate::solver::Needs;
use crate::transport::{Context, PathSolver, PathState, Step, slot};
use etendue_accel::Hit;
use etendue_numerics::Sampler;

/// The solver `path`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Path;

impl PathSolver for Path {
    fn needs(&self) -> Needs {
        Needs { lights_that_can_be_hit: true, ..Needs::default() }
    }

    #[inline]
    fn scatter(&self, c: &Context<'_>, state: &mut PathState, hit: Option<Hit>, u: &Sampler) -> Step {
        let Some(hit) = hit else {
            state.collect(&c.rules, c.scene.le_escaped(&state.ray, &state.wl));
            return Step::END;
        };
        let x = c.scene.interaction(&state.ray, &hit);
        state.collect(&c.rules, c.scene.le(&x, &state.wl));
        if c.ends(state) {
            return Step::END;
        }
        let vertex = state.vertex(c.scene, x);
        let u_lobe = u.u2(state.dim(slot::LOBE));
        let sample = vertex.sample(u_lobe.x, u.u2(state.dim(slot::BSDF)));
        Step { shadow: None, goes_on: state.turn(&c.rules, &vertex, sample, u_lobe.y) }
    }
}
