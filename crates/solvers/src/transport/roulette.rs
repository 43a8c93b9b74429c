//! Russian roulette: ends walks that carry little, and pays the survivors for it, so that the mean stays.

use super::{PathRules, PathState};

/// The survival probability's upper bound: some walks end even where nothing is absorbed.
const MOST: f32 = 0.95;

/// Whether the walk goes on: with probability q = min(max β η², 0.95) from vertex `rr_depth` on, and then β grows to β/q.
/// η² undoes the compression of radiance within refracting media, which is no loss.
#[inline]
pub fn roulette(rules: &PathRules, state: &mut PathState, u: f32) -> bool {
    if state.vertex < rules.rr_depth {
        return true;
    }
    let q = roulette_survival(state.beta.max_lane(), state.eta_scale);
    if u >= q {
        return false;
    }
    state.beta.divide(q);
    true
}

/// q for the largest lane of β.
#[inline(always)]
pub(crate) fn roulette_survival(beta: f32, eta_scale: f32) -> f32 {
    (beta * eta_scale).min(MOST)
}
