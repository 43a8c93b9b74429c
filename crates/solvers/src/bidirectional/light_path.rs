//! A path from a light: what bidirectional path tracing connects to, and what a photon map would keep.

use super::Strategies;
use super::path_vertex::PathVertex;
use super::walk::{End, Walk};
use super::weights::{Trail, power};
use crate::transport::{PathState, light_slot};
use etendue_numerics::{Dim, Frame, Numbers, Pdf, Ray, Spectrum, Vec2, Vec3, Wavelengths};
use etendue_scene::emitter::{EmissionPdf, EmissionSample, Model};
use etendue_scene::{EmitterId, Interaction, LightReference, NO_INSTANCE, Scene};

/// z_0: where light sets out, with the densities that all its strategies share.
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    /// The light.
    pub emitter: EmitterId,
    /// What kind of place.
    pub place: Place,
    /// The ray along which the light leaves.
    pub ray: Ray,
    /// Φ_0, W.
    pub flux: Spectrum,
    /// p_E of z_0: 1/m², 1/sr times 1/m² of the surroundings, or a probability.
    pub density: f32,
    /// p⃗ of the direction, 1/sr; 1 where there is but one, or where it is part of `density`.
    pub pdf_w: f32,
}

/// What z_0 is.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    /// A point of an emitting surface.
    Surface(Interaction, Finders),
    /// A point.
    Point,
    /// A single direction.
    Direction,
    /// A direction of the surroundings, which are one light.
    Surroundings,
}

/// Who else finds the light of an emitting surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finders {
    /// Light samples, and walks from the eye that hit it.
    SamplesAndHits,
    /// Light samples alone: it shines unseen.
    Samples,
    /// Nobody: it shines in single directions.
    Nobody,
}

impl Finders {
    /// Of the surface x of `scene`.
    pub fn of(scene: &Scene, x: &Interaction) -> Self {
        match scene.surface(x.surface).emitter.map(|id| &scene.emitter(id).model) {
            Some(Model::Area(area)) if area.unseen => Self::Samples,
            Some(Model::Area(_)) => Self::SamplesAndHits,
            _ => Self::Nobody,
        }
    }
}

impl Origin {
    /// Light that sets out, chosen with probability ∝ Φ. `None` where it is none.
    pub fn sample(scene: &Scene, u: &impl Numbers, wl: &Wavelengths) -> Option<Self> {
        let at = |slot| u.u2(Dim::at(0, slot));
        let u_light = u.u1(Dim::at(0, light_slot::LIGHT));
        let s = scene.lights.sample_emission(scene, u_light, at(light_slot::POSITION), at(light_slot::DIRECTION), wl)?;
        let origin = match &scene.emitter(s.emitter).model {
            Model::Area(_) | Model::DirectionalArea(_) => Self::on_surface(scene, &s)?,
            Model::Point(_) | Model::Spot(_) | Model::Projector(_) | Model::Goniometric(_) => Self::new(&s, Place::Point),
            Model::Directional(_) => Self { pdf_w: 1.0, ..Self::new(&s, Place::Direction) },
            Model::Environment(_) | Model::Octahedral(_) | Model::Constant(_) | Model::Portal(_) => {
                Self::of_surroundings(scene, &s, wl)
            }
        };
        let lit = origin.flux.is_finite() && origin.flux.max_lane() > 0.0;
        (lit && origin.density > 0.0 && origin.pdf_w > 0.0).then_some(origin)
    }

    fn new(s: &EmissionSample, place: Place) -> Self {
        let (density, pdf_w) = (s.pdf.position.value(), s.pdf.direction.value());
        Self { emitter: s.emitter, place, ray: s.ray, flux: s.weight, density, pdf_w }
    }

    fn on_surface(scene: &Scene, s: &EmissionSample) -> Option<Self> {
        let x = emitting_point(scene, s.emitter, s.primitive, s.ray.o, s.n, s.ray.d)?;
        Some(Self::new(s, Place::Surface(x, Finders::of(scene, &x))))
    }

    /// Several surroundings are one light of their summed radiance, whichever of them drew the direction.
    fn of_surroundings(scene: &Scene, s: &EmissionSample, wl: &Wavelengths) -> Self {
        let wi = -s.ray.d;
        let density = surroundings_density(scene, wi);
        let le = scene.le_escaped(&Ray::new(s.ray.o, wi), wl);
        Self { flux: le / density, density, pdf_w: 1.0, ..Self::new(s, Place::Surroundings) }
    }

    /// What the weights remember of z_0 when its light travels to a vertex.
    pub fn trail(&self) -> Trail {
        let (p, n, distant) = match &self.place {
            Place::Surface(x, _) => (x.p, x.n, false),
            Place::Point => (self.ray.o, Vec3::ZERO, false),
            Place::Direction | Place::Surroundings => (self.ray.o, self.ray.d, true),
        };
        // An eye path hits surfaces and surroundings: one strategy, s = 0, behind r_0.
        let sums = match &self.place {
            Place::Surface(_, Finders::SamplesAndHits) | Place::Surroundings => 1.0,
            _ => 0.0,
        };
        Trail { p, n, distant, density: self.density, pdf_w: self.pdf_w, connect: 0.0, sums }
    }

    /// p_N(z_0) in the measure of `density`: what the light sampler would have done at `from`, z_1.
    pub fn next_event_density(&self, scene: &Scene, from: &LightReference) -> f32 {
        let w = self.ray.d;
        match &self.place {
            Place::Surface(_, Finders::Nobody) => 0.0,
            Place::Surface(x, _) => scene.pdf_light(from, x) * x.n.dot(w).abs() / x.p.distance_squared(from.p),
            Place::Point | Place::Direction => scene.lights.probability(from, self.emitter),
            Place::Surroundings => scene.pdf_light_escaped(from, -w),
        }
    }
}

/// p_E of a direction of the surroundings: Σ P(light) p_w / (π R²), 1/(sr m²).
pub fn surroundings_density(scene: &Scene, wi: Vec3) -> f32 {
    let density = |pdf: EmissionPdf| pdf.position.value() * pdf.direction.value();
    scene.lights.environments().iter().map(|e| density(scene.lights.pdf_emission_escaped(scene, *e, wi))).sum()
}

/// A point of an emitting surface that sends light towards `w`, as far as densities need it.
pub fn emitting_point(scene: &Scene, emitter: EmitterId, primitive: u32, p: Vec3, n: Vec3, w: Vec3) -> Option<Interaction> {
    let surface = match &scene.emitter(emitter).model {
        Model::Area(light) => light.surface,
        Model::DirectionalArea(light) => light.surface,
        _ => return None,
    };
    Some(Interaction {
        p,
        p_error: Vec3::ZERO,
        n,
        shading: Frame::from_normal(n),
        uv: Vec2::ZERO,
        dp_du: Vec3::ZERO,
        dp_dv: Vec3::ZERO,
        wo: w,
        t: 0.0,
        time: 0.0,
        surface,
        primitive,
        bary: Vec2::ZERO,
        instance: NO_INSTANCE,
    })
}

/// A path from a light.
#[derive(Clone, Debug, Default)]
pub struct LightPath<'a> {
    /// z_0.
    pub origin: Option<Origin>,
    /// z_1, z_2, …; those at which the walk passed a null or mask surface are in no other's past.
    pub vertices: Vec<PathVertex<'a>>,
}

impl<'a> LightPath<'a> {
    /// Walks from a light until it ends; paths of more than `max_edges` edges, one of them to the lens, are of no use.
    pub fn trace(&mut self, all: &Strategies<'a>, u: &impl Numbers, rays: &mut u64) {
        self.trace_up_to(u32::MAX, all, u, rays);
    }

    /// The same of at most so many vertices, z_0 and all those of the last one's number included.
    pub fn trace_up_to(&mut self, count: u32, all: &Strategies<'a>, u: &impl Numbers, rays: &mut u64) {
        let Strategies { c, sides, heuristic, wl, .. } = all;
        let (heuristic, wl) = (*heuristic, *wl);
        self.vertices.clear();
        self.origin = Origin::sample(c.scene, u, &wl);
        let Some(origin) = self.origin else { return };
        let state = PathState { pdf: Pdf::Delta(1.0), ..PathState::start(origin.ray, Spectrum::ONE, wl) };
        let mut walk =
            Walk { c, sides, heuristic, end: End::Light, state, start: origin.flux, trail: origin.trail(), parent: None, count: 1 };
        while walk.state.edges < c.rules.max_edges && walk.count < count {
            let Some(x) = walk.meet(rays) else { return };
            let place = self.vertices.len();
            self.vertices.push(walk.vertex(x));
            let v = &mut self.vertices[place];
            if walk.count == 1 {
                // The light sampler at z_1 competes for z_0.
                let pdf = origin.next_event_density(c.scene, &v.vertex.light_reference());
                v.link.connect = power(heuristic, pdf, origin.density);
            }
            let is_last = walk.count + 1 == count && !v.may_be_passed();
            if is_last || !walk.turn(v, place as u32, u) {
                return;
            }
        }
    }
}
