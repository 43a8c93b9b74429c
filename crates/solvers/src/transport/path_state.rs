//! A walk from the eye as plain data, and the loop that advances it one vertex at a time.

use super::{Crowd, PathRules, ShadowQuery, Vertex, VertexSample, roulette};
use crate::solver::Needs;
use etendue_accel::Hit;
use etendue_bsdf::Scatter;
use etendue_numerics::{Dim, Pdf, Ray, Sampler, Spectrum, Vec2, Wavelengths};
use etendue_scene::{Interaction, LightReference, Scene};

/// The random decisions at a vertex; each has two dimensions.
pub mod slot {
    /// At vertex 0: position within the pixel.
    pub const PIXEL: u32 = 0;
    /// At vertex 0: position on the lens.
    pub const LENS: u32 = 1;
    /// At vertex 0: time.
    pub const TIME: u32 = 2;
    /// At vertex 0: how many edges (x), and which strategy of them (y), where these are chosen.
    pub const STRATEGY: u32 = 3;
    /// At vertex 0: which wavelengths (x).
    pub const WAVELENGTHS: u32 = 5;
    /// At vertex 0: whether to jump (x), and whether the jump is taken (y), where walks are mutations of others.
    pub const JUMP: u32 = 4;
    /// Direction within a lobe.
    pub const BSDF: u32 = 0;
    /// Which lobe (x) and roulette (y).
    pub const LOBE: u32 = 1;
    /// Which light.
    pub const LIGHT: u32 = 2;
    /// Where on the light.
    pub const LIGHT_POINT: u32 = 3;
    /// Where on the surface around, whether it is there.
    pub const PROBE: u32 = 4;
    /// Which of the photons around, whether it is in sight.
    pub const PHOTON: u32 = 5;
    /// Which connections are worth a shadow ray.
    pub const WORTH: u32 = 6;
    /// Whether a walk that its neighbours share is followed.
    pub const SHARED: u32 = 7;
}

/// β: the product of f cosθ / p along the walk so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Throughput(Spectrum);

impl Throughput {
    /// Everything arrives.
    pub const ONE: Self = Self(Spectrum::ONE);

    /// What of `l` arrives at the eye.
    #[inline]
    pub fn carry(&self, l: Spectrum) -> Spectrum {
        self.0 * l
    }

    /// One more factor f cosθ / p.
    #[inline]
    pub fn scatter(&mut self, weight: Spectrum) {
        self.0 *= weight;
    }

    /// Division by a probability.
    #[inline]
    pub fn divide(&mut self, q: f32) {
        self.0 /= q;
    }

    /// The largest lane.
    #[inline]
    pub fn max_lane(&self) -> f32 {
        self.0.max_lane()
    }

    /// Whether nothing arrives any more.
    #[inline]
    pub fn is_zero(&self) -> bool {
        self.0.is_zero()
    }
}

/// A walk between two vertices.
#[derive(Clone, Copy, Debug)]
pub struct PathState {
    /// The ray to be cast next.
    pub ray: Ray,
    /// β.
    pub beta: Throughput,
    /// What has been collected so far.
    pub l: Spectrum,
    /// Wavelengths of the lanes.
    pub wl: Wavelengths,
    /// Edges between the eye and the ray's end.
    pub edges: u32,
    /// Vertices so far, the eye included: the address of random decisions.
    pub vertex: u32,
    /// Density with which the ray's direction was chosen at `from`; discrete for camera rays.
    pub pdf: Pdf,
    /// The last vertex that scattered: what light sampling at it would have known.
    pub from: LightReference,
    /// What β is multiplied with for roulette: the product of η² along the walk, and 1/β of the first vertex where that counts.
    pub roulette_scale: f32,
}

/// What a step asks for: the next ray is in the state.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// A connection to be tested.
    pub shadow: Option<ShadowQuery>,
    /// Whether the walk goes on.
    pub goes_on: bool,
}

impl Step {
    /// The walk is over.
    pub const END: Self = Self { shadow: None, goes_on: false };
}

/// What every walk of a pass shares.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Which paths count.
    pub rules: PathRules,
}

impl Context<'_> {
    /// Whether a walk ends at its ray's end whatever is there: its edges are spent, and no null or mask surface lets it pass for nothing.
    #[inline]
    pub fn ends(&self, state: &PathState) -> bool {
        state.edges >= self.rules.max_edges && (self.rules.null_counts || !self.scene.has_transparent)
    }
}

/// A path solver as a step over a [`PathState`]: drivers decide whether one path runs to its end or many advance together.
pub trait PathSolver: Sync {
    /// What a scene must have.
    fn needs(&self) -> Needs {
        Needs::default()
    }

    /// Advances the walk whose ray met `hit` by one vertex.
    fn scatter(&self, c: &Context<'_>, state: &mut PathState, hit: Option<Hit>, u: &Sampler) -> Step;

    /// Edge of the blocks of pixels whose walks share what they find; 1 leaves each alone.
    fn block(&self) -> u32 {
        1
    }

    /// Lets walks that stand before their second vertex share what they met there. Returns how many rays that took.
    fn meet<'a>(&self, _: &Context<'a>, _: &mut Crowd<'a>) -> u64 {
        0
    }

    /// Advances the walks of a crowd that go on, all by one vertex: the same as [`PathSolver::scatter`] of each.
    fn scatter_all<'a>(&self, c: &Context<'a>, crowd: &mut Crowd<'a>) {
        for k in 0..crowd.going.len() {
            let i = crowd.going[k] as usize;
            let (walk, hit) = (&mut crowd.walks[i], crowd.hits[k]);
            let before = crowd.neighbours.watches(walk.vertex).then_some(*walk);
            let step = self.scatter(c, walk, hit, &crowd.samplers[i]);
            if let Some(before) = &before {
                crowd.neighbours.note(c, i as u32, before, hit.as_ref(), &step, walk);
            }
            crowd.take(i as u32, &step);
        }
    }
}

impl PathState {
    /// What the walk has collected, as the film sees it: linear Rec.709.
    #[inline]
    pub fn seen(&self) -> Spectrum {
        self.wl.to_rgb(self.l)
    }

    /// A walk about to leave the eye.
    #[inline(always)]
    pub fn start(ray: Ray, weight: Spectrum, wl: Wavelengths) -> Self {
        Self {
            ray,
            beta: Throughput(weight),
            l: Spectrum::ZERO,
            wl,
            edges: 1,
            vertex: 1,
            pdf: Pdf::Delta(1.0),
            from: LightReference::point(ray.o),
            roulette_scale: 1.0,
        }
    }

    /// The same of a walk that has not moved since: what tells walks apart is set, where it stays.
    #[inline(always)]
    pub fn set_out(&mut self, ray: Ray, weight: Spectrum, wl: Wavelengths) {
        (self.ray, self.beta, self.wl, self.from.p) = (ray, Throughput(weight), wl, ray.o);
    }

    /// The address of a random decision at the vertex that the ray leads to.
    #[inline]
    pub fn dim(&self, slot: u32) -> Dim {
        Dim::at(self.vertex, slot)
    }

    /// The numbers that choose among the lobes (x) and between life and death (y); not drawn where nobody looks at them.
    #[inline]
    pub fn choices(&self, rules: &PathRules, vertex: &Vertex, u: &Sampler) -> Vec2 {
        let asked = vertex.bsdf.has_choice() || self.vertex >= rules.rr_depth();
        if asked { u.u2(self.dim(slot::LOBE)) } else { Vec2::ZERO }
    }

    /// Evaluates the material of the vertex that the walk has come to. Where it sends each wavelength another way the walk goes on with one.
    #[inline]
    pub fn evaluate<'a>(&mut self, scene: &'a Scene, vertex: &mut Vertex<'a>) {
        vertex.evaluate(scene, &self.wl);
        if vertex.bsdf.events().disperses() {
            self.beta.scatter(self.wl.single_out());
        }
    }

    /// [`PathState::evaluate`] of a new vertex at x.
    #[inline]
    pub fn vertex<'a>(&mut self, scene: &'a Scene, x: Interaction) -> Vertex<'a> {
        let mut vertex = Vertex::at(x);
        self.evaluate(scene, &mut vertex);
        vertex
    }

    /// Collects emission at the ray's end.
    #[inline]
    pub fn collect(&mut self, rules: &PathRules, le: Spectrum) {
        if rules.counts(self.edges) {
            self.l += self.beta.carry(le);
        }
    }

    /// Turns the walk into a sampled direction; `false` where it ends.
    #[inline]
    pub fn turn(&mut self, rules: &PathRules, vertex: &Vertex, sample: Option<VertexSample>, u_roulette: f32) -> bool {
        let Some(s) = &sample else { return false };
        self.beta.scatter(s.weight);
        if self.beta.is_zero() {
            return false;
        }
        self.roulette_scale *= s.eta_scale;
        self.ray = vertex.x.spawn(s.wi);
        if s.is_null {
            // Light sampling looks straight through, so it competes with the walk at the vertex before.
            self.edges += u32::from(rules.null_counts);
        } else {
            self.edges += 1;
            self.pdf = s.pdf;
            self.from = vertex.light_reference();
        }
        let goes_on = self.edges <= rules.max_edges && roulette(rules, self, u_roulette);
        self.vertex += 1;
        goes_on
    }
}

/// The emission that the walk meets at its ray's end, and the density of light sampling for it, 1/sr: zero where no light sample at
/// the last vertex could have found it, or nobody asked for one (after a discrete direction).
#[inline(always)]
pub(crate) fn emission(c: &Context<'_>, state: &PathState, x: Option<&Interaction>) -> (Spectrum, f32) {
    let le = match x {
        Some(x) => c.scene.le(x, &state.wl),
        None => c.scene.le_escaped(&state.ray, &state.wl),
    };
    if le.is_zero() || state.pdf.is_delta() {
        return (le, 0.0);
    }
    let pdf_light = match x {
        Some(x) => c.scene.pdf_light(&state.from, x),
        None => c.scene.pdf_light_escaped(&state.from, state.ray.d),
    };
    (le, pdf_light)
}

/// One walk from start to end. Returns what it collected; counts its rays.
#[inline]
pub fn trace(solver: &impl PathSolver, c: &Context<'_>, mut state: PathState, u: &Sampler, rays: &mut u64) -> Spectrum {
    loop {
        *rays += 1;
        let hit = c.scene.intersect(&state.ray);
        let step = solver.scatter(c, &mut state, hit, u);
        if let Some(query) = &step.shadow {
            *rays += 1;
            state.l += arrives(c, query, &state.wl);
        }
        if !step.goes_on {
            return state.l;
        }
    }
}

/// What of a connection's contribution arrives.
#[inline]
pub fn arrives(c: &Context<'_>, query: &ShadowQuery, wl: &Wavelengths) -> Spectrum {
    match c.scene.transmittance(&query.ray, c.rules.passes(query.edges), wl) {
        Some(t) if c.rules.counts(query.edges + if c.rules.null_counts { t.passed } else { 0 }) => query.contribution * t.value,
        _ => Spectrum::ZERO,
    }
}
