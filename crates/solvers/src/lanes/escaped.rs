//! Rays that meet nothing: what they see of the surroundings, looked up for all of them together.

use crate::path_mis::PathMis;
use crate::transport::{Context, PathState};
use etendue_scene::{Escape, Seen};

/// The walks whose rays met nothing, which end there.
#[derive(Default)]
pub(crate) struct Escaped {
    walks: Vec<u32>,
    seen: Vec<Seen>,
}

impl Escaped {
    #[inline(always)]
    pub fn push(&mut self, i: u32) {
        self.walks.push(i);
    }

    /// [`PathMis::collect`] of each. Empties itself.
    pub fn collect(&mut self, solver: &PathMis, c: &Context<'_>, walks: &mut [PathState]) {
        let escape = |i: &u32| {
            let walk = &walks[*i as usize];
            Escape { ray: &walk.ray, from: (!walk.pdf.is_delta()).then_some(&walk.from), wl: &walk.wl }
        };
        c.scene.escaped_each(self.walks.iter().map(escape), &mut self.seen);
        for (i, seen) in self.walks.drain(..).zip(&self.seen) {
            solver.weigh(c, &mut walks[i as usize], seen.le, seen.pdf);
        }
    }
}
