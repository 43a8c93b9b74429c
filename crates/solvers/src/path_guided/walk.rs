//! The step of a guided walk: that of [`crate::path_mis`], but for where the next direction comes from.
//!
//! ```text
//! wi ~ p = a p_b + (1 - a) p_g,    β ← β f cosθ / p,    w_b = h(p_b, p_l),  w_l = h(p_l, p_b)
//! ```
//!
//! MIS weights look at p_b, although directions are drawn with p: any two that sum to one at every direction will do, and these ask for no density of the
//! guide at light samples. Light that a walk meets then counts at most 1/a times as much as without a guide.
//!
//! Roulette looks at what β would be without a guide: a walk is not worth less for being sent where there is light. It is gentler than that of `path-mis`
//! ([`HOPE`]), whose walks mostly find nothing if they go on. Discrete directions are never guided.
//!
//! In crowds walks turn on lanes where surfaces are Lambert's (`lanes/steer.rs`), to the same bits.

use super::field::{Field, Leaf};
use crate::lanes;
use crate::neighbours::{self, How};
use crate::path_mis::PathMis;
use crate::transport::{self, Context, Crowd, PathSolver, PathState, Step, Vertex, VertexSample, mis_weight, next_event, slot};
use etendue_accel::Hit;
use etendue_bsdf::Event;
use etendue_numerics::{Pdf, Sampler, Vec2};

/// κ of roulette: how much brighter what a walk goes on to may be than what it has left.
pub const HOPE: f32 = 8.0;

/// Walks by what `field` knows.
pub struct Guided<'a> {
    /// What is known.
    pub field: &'a Field,
    /// All else.
    pub mis: PathMis,
}

/// What a turn owes to the guide.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turned {
    /// p/p_b.
    pub ratio: f32,
    /// β for roulette, as it is and as `path-mis` would have it were its walks as long; zero before there is any.
    pub hope: [f32; 2],
}

impl Turned {
    /// Nothing.
    const NOT: Self = Self { ratio: 1.0, hope: [0.0; 2] };
}

impl PathSolver for Guided<'_> {
    fn scatter(&self, c: &Context<'_>, state: &mut PathState, hit: Option<Hit>, u: &Sampler) -> Step {
        self.step(c, state, hit, u).0
    }

    fn block(&self) -> u32 {
        self.mis.block()
    }

    fn meet<'a>(&self, c: &Context<'a>, crowd: &mut Crowd<'a>) -> u64 {
        let PathMis { heuristic, follow, .. } = self.mis;
        neighbours::meet(&How { heuristic, follow, hope: HOPE, guide: Some(self.field) }, &c.eager(), crowd)
    }

    fn scatter_all<'a>(&self, c: &Context<'a>, crowd: &mut Crowd<'a>) {
        lanes::scatter_all(self, c, crowd);
    }
}

impl Guided<'_> {
    /// The step, and what its turn owes to the guide.
    #[inline(always)]
    pub(super) fn step(&self, c: &Context<'_>, state: &mut PathState, hit: Option<Hit>, u: &Sampler) -> (Step, Turned) {
        let mis = &self.mis;
        let c = &c.eager();
        // Light that the walk meets.
        let Some(hit) = &hit else {
            mis.collect(c, state, None);
            return (Step::END, Turned::NOT);
        };
        let mut vertex = Vertex::at(c.scene.interaction(&state.ray, hit));
        mis.collect(c, state, Some(&vertex.x));
        if c.ends(state) {
            return (Step::END, Turned::NOT);
        }

        // Light that a light sample finds.
        state.evaluate(c.scene, &mut vertex);
        vertex.shares_light = true;
        let shadow = next_event(c, state, &vertex, u, |p, q| mis_weight(mis.heuristic, p, q));

        // The next direction.
        let n = if vertex.x.n.dot(vertex.x.wo) < 0.0 { -vertex.x.n } else { vertex.x.n };
        let leaf = self.field.at(vertex.x.p, n);
        let u_lobe = u.u2(state.dim(slot::LOBE));
        let (sample, p_over_p_b) = sample(&vertex, leaf, u_lobe.x, u.u2(state.dim(slot::BSDF)));
        if state.vertex > 1 {
            state.roulette_scale *= p_over_p_b;
        }
        let hope = match &sample {
            Some(s) if state.vertex >= c.rules.rr_depth() => {
                let hope = state.beta.carry(s.weight).max_lane() * state.roulette_scale * s.eta_scale;
                [hope, hope * (transport::HOPE / HOPE)]
            }
            _ => [0.0; 2],
        };
        let goes_on = state.turn(&c.rules, &vertex, sample, u_lobe.y);
        state.relate(HOPE);
        (Step { shadow, goes_on }, Turned { ratio: p_over_p_b, hope })
    }
}

/// A direction of density p, whose `pdf` is p_b; and p/p_b.
#[inline]
fn sample(vertex: &Vertex<'_>, leaf: &Leaf, u_lobe: f32, u: Vec2) -> (Option<VertexSample>, f32) {
    let a = if vertex.is_smooth() { leaf.fraction } else { 1.0 };
    if u_lobe < a {
        // As the BSDF has it.
        let Some(s) = vertex.sample(u_lobe / a, u) else { return (None, 1.0) };
        let ratio = match s.pdf {
            Pdf::Delta(_) => a,
            Pdf::SolidAngle(p_b) => a + (1.0 - a) * leaf.guide.pdf(vertex.x.p, s.wi) / p_b,
        };
        return (Some(VertexSample { weight: s.weight / ratio, ..s }), ratio);
    }
    // As the guide has it.
    let (wi, p_g) = leaf.guide.sample(vertex.x.p, u);
    let (f_cos, p_b) = vertex.eval(wi);
    if p_b <= 0.0 {
        return (None, 1.0);
    }
    let p = a * p_b + (1.0 - a) * p_g;
    let s = VertexSample { wi, weight: f_cos / p, pdf: Pdf::SolidAngle(p_b), eta_scale: 1.0, is_null: false, event: Event::NONE };
    (Some(s), p / p_b)
}
