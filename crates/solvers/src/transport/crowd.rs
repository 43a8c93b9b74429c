//! Many walks that advance together, a vertex at a time: the driver of batches.
//!
//! ```text
//! while any walk goes on:   hits = RT(rays);   shadows = scatter(walks, hits);   L += contribution · V(shadows)
//! ```
//!
//! The walks set out together, so all of them are at the same vertex. Each gives the same bits as alone ([`super::trace`]): what a walk
//! computes does not depend on its company, and what it collects is summed in the same order. Only walks that are handed over as a block may share what they
//! find, where the solver says how ([`PathSolver::meet`]); they depend on each other, and on nobody else.

use super::{Context, PathSolver, PathState, ShadowQuery, Step, arrives};
use crate::lanes::{Lanes, escaped::Escaped, others::Others};
use crate::neighbours::Neighbours;
use etendue_accel::Hit;
use etendue_numerics::{Ray, Sampler, Spectrum};

/// Walks, and the queues between the stages.
#[derive(Default)]
pub struct Crowd<'a> {
    /// The walks.
    pub walks: Vec<PathState>,
    /// The numbers of each.
    pub samplers: Vec<Sampler>,
    /// Those that go on, by number.
    pub going: Vec<u32>,
    /// What the ray of each of those met.
    pub hits: Vec<Option<Hit>>,
    /// Those that go on from the vertex that is being made.
    pub(crate) onward: Vec<u32>,
    /// Connections to be tested, with the number of the walk.
    pub(crate) shadows: Vec<(u32, ShadowQuery)>,
    rays: Vec<Ray>,
    occluded: Vec<bool>,
    /// Memory of those steps that work on lanes.
    pub(crate) lanes: Option<Lanes>,
    pub(crate) others: Others<'a>,
    pub(crate) escaped: Escaped,
    /// Where each block of walks that may share ends.
    pub(crate) blocks: Vec<u32>,
    pub(crate) neighbours: Neighbours<'a>,
}

impl<'a> Crowd<'a> {
    /// Takes away all walks.
    pub fn clear(&mut self) {
        self.walks.clear();
        self.samplers.clear();
        self.blocks.clear();
    }

    /// Whether there are no walks.
    pub fn is_empty(&self) -> bool {
        self.walks.is_empty()
    }

    /// Notes what the step of walk `i` asks for.
    #[inline]
    pub fn take(&mut self, i: u32, step: &Step) {
        if let Some(query) = &step.shadow {
            self.shadows.push((i, *query));
        }
        if step.goes_on {
            self.onward.push(i);
        }
    }

    /// Traces all walks to their ends. What each collected is in its `l`; counts the rays.
    pub fn trace(&mut self, solver: &impl PathSolver, c: &Context<'a>, rays: &mut u64) {
        self.going.clear();
        self.going.extend(0..self.walks.len() as u32);
        let share = c.may_share() && !self.blocks.is_empty();
        self.neighbours.begin(share, self.walks.len());
        let mut vertex = 1;
        while !self.going.is_empty() {
            // RT.
            self.rays.clear();
            self.rays.extend(self.going.iter().map(|i| self.walks[*i as usize].ray));
            c.scene.intersect_each(&self.rays, &mut self.hits);
            c.scene.fetch_each(&self.hits);
            *rays += self.going.len() as u64;

            // The next vertex.
            if share && vertex == 2 {
                *rays += solver.meet(c, self);
            }
            solver.scatter_all(c, self);

            // V.
            *rays += self.shadows.len() as u64;
            self.connect(c);
            if share && vertex == 2 {
                self.neighbours.connected(&mut self.walks);
            }
            std::mem::swap(&mut self.going, &mut self.onward);
            self.onward.clear();
            vertex += 1;
        }
        self.neighbours.part(&mut self.walks);
    }

    /// Adds what of the connections arrives.
    fn connect(&mut self, c: &Context<'_>) {
        if c.scene.has_transparent {
            for (i, query) in self.shadows.drain(..) {
                let walk = &mut self.walks[i as usize];
                walk.l += arrives(c, &query, &walk.wl);
            }
            return;
        }
        self.rays.clear();
        self.rays.extend(self.shadows.iter().map(|(_, query)| query.ray));
        c.scene.occluded_each(&self.rays, &mut self.occluded);
        for ((i, query), occluded) in self.shadows.drain(..).zip(&self.occluded) {
            if !occluded && c.rules.counts(query.edges) {
                self.walks[i as usize].l += query.contribution;
            }
        }
    }

    /// What each walk collected, as the film sees it.
    pub fn collected(&self) -> impl Iterator<Item = Spectrum> {
        self.walks.iter().map(PathState::seen)
    }
}
