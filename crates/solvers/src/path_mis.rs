//! Path tracing with multiple importance sampling: light that a walk hits and light that a light sample finds are both counted,
//! each weighted by how likely its technique was to find it [Veach, Guibas 1995].
//!
//! ```text
//! L = Σ_k β_k [ w_b Le(x_k) + w_l f cosθ Le(y) V / p_l ],    w_b = h(p_b, p_l),  w_l = h(p_l, p_b),  h(p, q) = p²/(p² + q²)
//! ```
//!
//! Walks of neighbouring pixels may share what they find beyond their first vertices: see `neighbours`.
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `block` | edge of the blocks of pixels that share, 1, 2 or 4; 1 leaves each walk alone | 1 |
//! | `follow` | κ: of n walks that find for each other κ √n are followed, from 0.25 to 4; 4 follows all of a block | 1.05 |

use crate::lanes;
use crate::neighbours::{self, How};
use crate::parameters::{Parameter, Slot};
use crate::transport::{
    Context, Crowd, HOPE, Heuristic, PathSolver, PathState, Step, Vertex, emission, mis_weight, next_event, slot,
};
use etendue_accel::Hit;
use etendue_numerics::{Pdf, Sampler, Spectrum};
use etendue_scene::Interaction;

/// The solver `path-mis`.
#[derive(Clone, Copy, Debug)]
pub struct PathMis {
    /// How the two techniques share; the power heuristic unless told otherwise.
    pub heuristic: Heuristic,
    /// The blocks of pixels whose walks share what they find have an edge of 2^`block` pixels.
    pub block: usize,
    /// κ: how many of the walks that share are followed.
    pub follow: f32,
}

impl Default for PathMis {
    fn default() -> Self {
        Self::alone(Heuristic::default())
    }
}

impl PathMis {
    /// What users may set.
    pub const PARAMETERS: &'static [Parameter<Self>] = &[
        Parameter {
            name: "block",
            summary: "edge of the blocks of pixels whose walks share what they find; 1 leaves each alone",
            slot: |s| Slot::Choice(&mut s.block, &["1", "2", "4"]),
        },
        Parameter {
            name: "follow",
            summary: "how many of the walks that share are followed: more cost time, fewer bring noise; 4 follows all",
            slot: |s| Slot::Number(&mut s.follow, 0.25..=4.0),
        },
    ];

    /// Each pixel's walks by themselves, weighted by `heuristic`.
    pub const fn alone(heuristic: Heuristic) -> Self {
        Self { heuristic, block: 0, follow: neighbours::FOLLOWED }
    }

    /// Collects Le at x or of the surroundings, weighted against the light sample that might have found it.
    #[inline]
    pub(crate) fn collect(&self, c: &Context<'_>, state: &mut PathState, x: Option<&Interaction>) {
        let (le, pdf_light) = emission(c, state, x);
        self.weigh(c, state, le, pdf_light);
    }

    /// Collects Le of `pdf_light`.
    #[inline]
    pub(crate) fn weigh(&self, c: &Context<'_>, state: &mut PathState, le: Spectrum, pdf_light: f32) {
        let share = match state.pdf {
            Pdf::Delta(_) => 1.0,
            Pdf::SolidAngle(pdf_bsdf) => mis_weight(self.heuristic, pdf_bsdf, pdf_light),
        };
        state.collect(&c.rules, le * share);
    }
}

impl PathSolver for PathMis {
    #[inline]
    fn scatter(&self, c: &Context<'_>, state: &mut PathState, hit: Option<Hit>, u: &Sampler) -> Step {
        let c = &c.eager();
        // Light that the walk hits.
        let Some(hit) = &hit else {
            self.collect(c, state, None);
            return Step::END;
        };
        let mut vertex = Vertex::at(c.scene.interaction(&state.ray, hit));
        self.collect(c, state, Some(&vertex.x));
        if c.ends(state) {
            return Step::END;
        }

        // Light that a light sample finds.
        state.evaluate(c.scene, &mut vertex);
        vertex.shares_light = true;
        let shadow = next_event(c, state, &vertex, u, |pdf_light, pdf_bsdf| mis_weight(self.heuristic, pdf_light, pdf_bsdf));

        // The next direction.
        let u_lobe = state.choices(&c.rules, &vertex, u);
        let sample = vertex.sample(u_lobe.x, u.u2(state.dim(slot::BSDF)));
        let goes_on = state.turn(&c.rules, &vertex, sample, u_lobe.y);
        state.relate(HOPE);
        Step { shadow, goes_on }
    }

    fn block(&self) -> u32 {
        1 << self.block
    }

    fn meet<'a>(&self, c: &Context<'a>, crowd: &mut Crowd<'a>) -> u64 {
        let how = How { heuristic: self.heuristic, follow: self.follow, hope: HOPE, guide: None };
        neighbours::meet(&how, &c.eager(), crowd)
    }

    fn scatter_all<'a>(&self, c: &Context<'a>, crowd: &mut Crowd<'a>) {
        lanes::scatter_all(self, c, crowd);
    }
}
