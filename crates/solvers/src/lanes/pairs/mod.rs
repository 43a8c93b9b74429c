//! Bidirectional path tracing of many samples at once, a sample a lane: the twin of `Strategies::sample` where all surfaces are Lambert's, all lights
//! are surfaces, and all rays leave through one point or lens. The same bits.
//!
//! ```text
//! walks from the lights, a vertex at a time, each vertex kept and shown to the lens;
//! walks from the eye, a vertex y at a time:   l += Le;   light samples at y;   y with each z that is kept
//! ```
//!
//! A lane is a sample from its beginning to its end, so the k-th vertices of all light paths lie beside the j-th of all eye paths, and connecting them
//! is one loop over lanes ([`join`]); lanes whose walk has ended are computed and forgotten. Rays are cast together.
//!
//! | what | where |
//! | --- | --- |
//! | the walks from both ends | [`walks`] |
//! | which connections there are, and which arrive | [`connect`] |
//! | their loops over lanes | [`join`] |
//! | one vertex of each walk | [`stage`] |

mod connect;
mod join;
mod stage;
mod walks;

use super::vertices::{Colours, LANES, Lane, Lane3, Vertices};
use crate::bidirectional::light_path::Origin;
use crate::bidirectional::{Strategies, eye::Center};
use crate::transport::{Heuristic, PathState};
use etendue_accel::Hit;
use etendue_numerics::{Ray, Sampler, Spectrum, Vec2, Vec3, Wavelengths};
use etendue_scene::emitter::Model;
use etendue_scene::sensor::Perspective;
use etendue_scene::{Lone, Sensor, SurfaceId};
use join::{Emitting, Joints, Lens};
use stage::{Stage, Trails};

/// What is known of a scene whose samples may go on lanes.
pub(crate) struct Plain<'a> {
    all: &'a Strategies<'a>,
    center: Center,
    pinhole: Option<&'a Perspective>,
    lone: Option<Lone>,
    /// p_E of the points of a lone lamp.
    lone_density: f32,
}

impl<'a> Plain<'a> {
    /// `None` where samples must go one by one.
    pub fn of(all: &'a Strategies<'a>) -> Option<Self> {
        let scene = all.c.scene;
        let lambert = |s: u32| scene.material(scene.surface(SurfaceId(s)).material).lambert(scene).is_some();
        let is_plain = !all.c.rules.hide_emitters
            && !scene.has_transparent
            && (0..scene.surfaces.len() as u32).all(lambert)
            && scene.emitters.iter().all(|e| matches!(&e.model, Model::Area(area) if !area.two_sided && !area.unseen));
        let half = Vec2::splat(0.5);
        let emission = scene.lights.sample_emission(scene, 0.5, half, half, &Wavelengths::Rgb);
        let lone_density = emission.map_or(0.0, |s| s.pdf.position.value());
        let pinhole = if let Sensor::Perspective(pinhole) = &all.view.sensor { Some(pinhole) } else { None };
        let lone = scene.lights.lone(scene);
        Some(Self { all, center: all.eye.center()?, pinhole, lone, lone_density }).filter(|_| is_plain)
    }
}

/// A colour without a fourth lane.
#[inline(always)]
fn rgb(c: Vec3) -> Spectrum {
    Spectrum::rgb(c.x, c.y, c.z)
}

/// A connection that waits to be cast.
struct Shadow {
    ray: Ray,
    lane: u32,
    value: Spectrum,
    /// Where it is splat; to its own pixel otherwise.
    pixel: Option<Vec2>,
}

/// Samples side by side, and the memory for all that happens to them.
pub(crate) struct Pairs {
    v: Box<Vertices>,
    trails: Box<Trails>,
    /// What the walks started with, and their β before they turned.
    start: Box<Lane3>,
    carried: Box<Colours>,
    /// The vertices of the walks from the lights, the first `kept`; and of those from the eye the last.
    lights: Vec<Box<Stage>>,
    kept: usize,
    eye: Option<Box<Stage>>,
    joints: Box<Joints>,
    lens: Box<Lens>,
    u_worth: Box<Lane>,
    emitting: Box<Emitting>,
    origins: Vec<Option<Origin>>,
    going: Vec<u32>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    shadows: Vec<Shadow>,
    occluded: Vec<bool>,
    /// What each sample's own pixel gets.
    pub l: Vec<Spectrum>,
    /// What samples give to other pixels.
    pub splats: Vec<(u32, Vec2, Spectrum)>,
}

impl Default for Pairs {
    fn default() -> Self {
        let (three, one) = (Lane3::ZERO, [0.0; LANES]);
        Self {
            v: Vertices::new(),
            trails: Trails::new(),
            start: Box::new(three),
            carried: Box::new(Colours::ZERO),
            lights: Vec::new(),
            kept: 0,
            eye: None,
            joints: Joints::new(),
            lens: Box::new(Lens { is_there: [0; LANES], wi: three, p: three, we: one, pixel: [one; 2] }),
            u_worth: Box::new(one),
            emitting: Box::new(Emitting { n: three, density: one }),
            origins: Vec::new(),
            going: Vec::new(),
            rays: Vec::new(),
            hits: Vec::new(),
            shadows: Vec::new(),
            occluded: Vec::new(),
            l: Vec::new(),
            splats: Vec::new(),
        }
    }
}

impl Pairs {
    /// So many samples at most.
    pub const MOST: usize = LANES;

    /// Traces samples whose walks from the eye begin with `eyes`; counts rays.
    pub fn trace(&mut self, plain: &Plain<'_>, eyes: &[PathState], samplers: &[Sampler], rays: &mut u64) {
        match plain.all.heuristic {
            Heuristic::Balance => self.trace_by::<false>(plain, eyes, samplers, rays),
            Heuristic::Power => self.trace_by::<true>(plain, eyes, samplers, rays),
        }
    }

    fn trace_by<const SQUARE: bool>(&mut self, plain: &Plain<'_>, eyes: &[PathState], samplers: &[Sampler], rays: &mut u64) {
        self.splats.clear();
        self.l.clear();
        self.l.resize(samplers.len(), Spectrum::ZERO);
        self.walk_from_lights::<SQUARE>(plain, samplers, rays);
        self.walk_from_eye::<SQUARE>(plain, eyes, samplers, rays);
    }
}
