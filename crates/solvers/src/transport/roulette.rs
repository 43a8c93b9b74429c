//! Russian roulette: ends walks that carry little, and pays the survivors for it, so that the mean stays.
//!
//! ```text
//! q = min(max β η², 0.95)               of all light
//! q = min(κ max β η² / max β₁, 0.95)     of the light of its pixel, β₁ the throughput after the first vertex
//! ```
//!
//! The second asks how much a walk may still add to what its pixel has: walks over dark surfaces live on where the pixel is dark anyway, and
//! may be ended two vertices after the eye where they are not the ones that bring the light. `path-mis` and `bidirectional` play so; for walks from a
//! light, β₁ is what they carry on from the first surface.

use super::{Context, PathRules, PathState};

/// The survival probability's upper bound: some walks end even where nothing is absorbed.
const MOST: f32 = 0.95;

/// κ: how much brighter what a walk goes on to may be than what it has left. By measurement: 1 ends too many, from 2 on rays cost more than they bring.
pub(crate) const HOPE: f32 = 1.5;

/// κ of walks from a light: what they bring others find as well.
pub(crate) const HOPE_OF_LIGHT: f32 = 1.0;

/// The first vertex at which roulette of the second kind is played, where nobody asks for another.
const EARLY: u32 = 2;

impl Context<'_> {
    /// The same with roulette from the second vertex on, unless the rules ask for another beginning.
    #[inline]
    pub(crate) fn eager(&self) -> Self {
        let rr_depth = self.rules.rr_depth_or(EARLY);
        Self { rules: PathRules { rr_depth: Some(rr_depth), ..self.rules }, ..*self }
    }
}

impl PathState {
    /// To be called after each turn: past the first vertex roulette looks at the walk's share of its pixel's light.
    #[inline(always)]
    pub(crate) fn relate(&mut self, hope: f32) {
        let first = self.beta.max_lane();
        if self.vertex == 2 && first > 0.0 {
            self.roulette_scale *= hope / first;
        }
    }
}

/// Whether the walk goes on: with probability q from vertex `rr_depth` on, and then β grows to β/q.
/// η² undoes the compression of radiance within refracting media, which is no loss.
#[inline]
pub fn roulette(rules: &PathRules, state: &mut PathState, u: f32) -> bool {
    if state.vertex < rules.rr_depth() {
        return true;
    }
    let q = roulette_survival(state.beta.max_lane(), state.roulette_scale);
    if u >= q {
        return false;
    }
    state.beta.divide(q);
    true
}

/// q for the largest lane of β.
#[inline(always)]
pub(crate) fn roulette_survival(beta: f32, scale: f32) -> f32 {
    (beta * scale).min(MOST)
}
