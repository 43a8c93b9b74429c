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

mod join;
mod stage;

use super::place::Place;
use super::turn::{Turn, relate};
use super::vertices::{Colours, LANES, Lane3, Vertices};
use super::{draw, reflectance};
use crate::bidirectional::light_path::{Origin, emitting_point};
use crate::bidirectional::walk::{End, Walk};
use crate::bidirectional::weights::{Trail, power};
use crate::bidirectional::{Strategies, eye::Center};
use crate::transport::{Heuristic, PathState, Throughput, light_slot, slot};
use etendue_accel::Hit;
use etendue_numerics::{Dim, Pdf, Ray, Sampler, Spectrum, Vec2, Vec3, Wavelengths, wide};
use etendue_scene::emitter::Model;
use etendue_scene::{LightQuery, LightSample, Lone, NO_INSTANCE, Scene, SurfaceId};
use join::{Emitting, Inner, Joints, Lens, NextEvent, OfLamp, ToLens};
use stage::{Arrive, Leave, Stage, Trails, TurnToEye};

/// What is known of a scene whose samples may go on lanes.
pub(crate) struct Plain<'a> {
    all: &'a Strategies<'a>,
    center: Center,
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
            && scene.emitters.iter().all(|e| matches!(&e.model, Model::Area(area) if !area.two_sided));
        let half = Vec2::splat(0.5);
        let emission = scene.lights.sample_emission(scene, 0.5, half, half, &Wavelengths::Rgb);
        let lone_density = emission.map_or(0.0, |s| s.pdf.position.value());
        Some(Self { all, center: all.eye.center()?, lone: scene.lights.lone(scene), lone_density }).filter(|_| is_plain)
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
            lens: Box::new(Lens { is_there: [0; LANES], wi: three, p: three, we: one }),
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

    /// The walks from the lights; their vertices stay in `lights`.
    fn walk_from_lights<const SQUARE: bool>(&mut self, plain: &Plain<'_>, samplers: &[Sampler], rays: &mut u64) {
        let (all, scene, rules) = (plain.all, plain.all.c.scene, &plain.all.c.rules);
        self.v.roulette_scale = [1.0; LANES];
        self.origins.clear();
        self.rays.clear();
        self.going.clear();
        for (i, u) in samplers.iter().enumerate() {
            let origin = Origin::sample(scene, u, &Wavelengths::Rgb);
            if let Some(origin) = &origin {
                self.set_out(i, &origin.ray, origin.flux, &origin.trail());
                if let Some((query, weight)) = all.look_at_emitter(origin, u) {
                    let value = query.shadow.contribution * weight;
                    self.shadows.push(Shadow { ray: query.shadow.ray, lane: i as u32, value, pixel: Some(query.pixel) });
                }
            }
            self.origins.push(origin);
        }

        let mut lights = std::mem::take(&mut self.lights);
        self.kept = 0;
        for edges in 1..rules.max_edges {
            if self.going.is_empty() {
                break;
            }
            self.cast(scene, rays);
            if self.kept == lights.len() {
                lights.push(Stage::new());
            }
            let z = &mut *lights[self.kept];
            z.alive = [0; LANES];
            for k in 0..self.going.len() {
                if let Some(hit) = self.hits[k] {
                    self.gather(scene, self.going[k] as usize, k, &hit);
                    z.alive[self.going[k] as usize] = 1;
                }
            }
            self.arrive(z);
            if edges == 1 {
                for (i, origin) in self.origins.iter().enumerate().filter(|(i, _)| z.alive[*i] != 0) {
                    // The light sampler at z_1 competes for z_0.
                    let compete = |o: &Origin| power(all.heuristic, o.next_event_density(scene, &self.v.from(i)), o.density);
                    z.connect[i] = origin.as_ref().map_or(0.0, compete);
                }
            }
            if all.may_count(edges + 1) {
                self.show::<SQUARE>(plain, z, edges, samplers);
            }

            // The next direction.
            let roulette = edges >= rules.rr_depth();
            draw(samplers, Dim::at(edges, light_slot::BSDF), &mut self.v.u_bsdf);
            if roulette {
                draw(samplers, Dim::at(edges, light_slot::LOBE), &mut self.v.u_lobe);
            }
            *self.carried = self.v.beta;
            wide::widest(Turn { vertices: &mut self.v, roulette: false });
            wide::widest(TurnToEye { v: &mut self.v, stage: z, carried: &self.carried, roulette });
            if edges == 1 {
                relate(&mut self.v);
            }
            self.leave::<SQUARE>(z);
            self.kept += 1;
        }
        self.lights = lights;
        self.connect(scene, rays);
    }

    /// The walks from the eye.
    fn walk_from_eye<const SQUARE: bool>(&mut self, plain: &Plain<'_>, eyes: &[PathState], samplers: &[Sampler], rays: &mut u64) {
        let (all, scene, rules) = (plain.all, plain.all.c.scene, &plain.all.c.rules);
        self.v.roulette_scale = [1.0; LANES];
        self.rays.clear();
        self.going.clear();
        for (i, eye) in eyes.iter().enumerate() {
            self.set_out(i, &eye.ray, eye.beta.carry(Spectrum::ONE), &all.eye.trail(&eye.ray, all.heuristic));
        }
        let (lights, mut eye) = (std::mem::take(&mut self.lights), self.eye.take().unwrap_or_else(Stage::new));
        let y = &mut *eye;
        for edges in 1..=rules.max_edges {
            if self.going.is_empty() {
                break;
            }
            self.cast(scene, rays);

            // s = 0.
            y.alive = [0; LANES];
            for k in 0..self.going.len() {
                let (i, Some(hit)) = (self.going[k] as usize, self.hits[k]) else { continue };
                if scene.surface(SurfaceId(hit.geometry)).emitter.is_some() {
                    self.hit(plain, i, k, &hit, edges);
                }
                if edges < rules.max_edges {
                    self.gather(scene, i, k, &hit);
                    y.alive[i] = 1;
                }
            }
            if edges == rules.max_edges {
                break;
            }
            self.arrive(y);

            // s = 1, and s ≥ 2.
            if all.may_count(edges + 1) {
                self.next_event::<SQUARE>(plain, y, edges, samplers);
            }
            for (z, z_edges) in lights[..self.kept].iter().zip(1..) {
                if all.may_count(edges + z_edges + 1) {
                    self.inner::<SQUARE>(plain, (y, edges), (z, z_edges), samplers);
                }
            }
            self.connect(scene, rays);

            // The next direction.
            let roulette = edges >= rules.rr_depth();
            draw(samplers, Dim::at(edges, slot::BSDF), &mut self.v.u_bsdf);
            if roulette {
                draw(samplers, Dim::at(edges, slot::LOBE), &mut self.v.u_lobe);
            }
            wide::widest(Turn { vertices: &mut self.v, roulette });
            if edges == 1 {
                relate(&mut self.v);
            }
            self.leave::<SQUARE>(y);
        }
        (self.lights, self.eye) = (lights, Some(eye));
    }

    /// Lane i is a walk about to begin.
    fn set_out(&mut self, i: usize, ray: &Ray, start: Spectrum, trail: &Trail) {
        self.v.times[i] = ray.time;
        self.v.beta.set_spectrum(i, Spectrum::ONE);
        let [r, g, b] = start.to_rgb();
        self.start.set(i, Vec3::new(r, g, b));
        self.trails.set(i, trail);
        self.going.push(i as u32);
        self.rays.push(*ray);
    }

    /// RT of all rays.
    fn cast(&mut self, scene: &Scene, rays: &mut u64) {
        scene.intersect_each(&self.rays, &mut self.hits);
        *rays += self.rays.len() as u64;
    }

    /// Puts the surface that the k-th ray met into lane i.
    fn gather(&mut self, scene: &Scene, i: usize, k: usize, hit: &Hit) {
        let (v, ray) = (&mut self.v, &self.rays[k]);
        let surface = scene.surface(SurfaceId(hit.geometry));
        let Some((rho, two_sided)) = scene.material(surface.material).lambert(scene) else { return };
        v.wo.set(i, -ray.d);
        v.two_sided[i] = u32::from(two_sided);
        v.set_count(i + 1);
        if let Some(mesh) = surface.shape.mesh().filter(|_| hit.instance == NO_INSTANCE) {
            let bary = Vec2::new(hit.u, hit.v);
            v.rho.set_spectrum(i, reflectance(rho, &Wavelengths::Rgb, || scene.texture_context(&scene.interaction(ray, hit))));
            v.place_on(mesh, hit.primitive, bary);
        } else {
            let x = scene.interaction(ray, hit);
            v.rho.set_spectrum(i, reflectance(rho, &Wavelengths::Rgb, || scene.texture_context(&x)));
            v.place_at(&x);
        }
    }

    /// The walks arrive at the surfaces that were gathered.
    fn arrive(&mut self, stage: &mut Stage) {
        self.v.set_count(LANES);
        wide::widest(Place(&mut self.v));
        wide::widest(Arrive { v: &self.v, trails: &self.trails, start: &self.start, stage });
    }

    /// Those that survived leave.
    fn leave<const SQUARE: bool>(&mut self, stage: &Stage) {
        wide::widest(Leave::<SQUARE> { v: &self.v, trails: &mut self.trails, stage });
        self.going.clear();
        self.rays.clear();
        let v = &self.v;
        for i in (0..LANES).filter(|i| stage.alive[*i] & v.goes_on[*i] != 0) {
            self.going.push(i as u32);
            self.rays.push(Ray { time: v.times[i], ..Ray::new(v.ray.o.get(i), v.ray.d.get(i)) });
        }
    }

    /// s = 0: the k-th ray, of lane i, hit a light.
    fn hit(&mut self, plain: &Plain<'_>, i: usize, k: usize, hit: &Hit, edges: u32) {
        let (all, v) = (plain.all, &self.v);
        let mut beta = Throughput::ONE;
        beta.scatter(v.beta.spectrum(i));
        let x = all.c.scene.interaction(&self.rays[k], hit);
        let start = PathState::start(self.rays[k], Spectrum::ONE, Wavelengths::Rgb);
        let walk = Walk {
            c: &all.c,
            sides: &all.sides,
            heuristic: all.heuristic,
            end: End::Eye,
            state: PathState { beta, edges, vertex: edges, from: v.from(i), ..start },
            start: rgb(self.start.get(i)),
            trail: self.trails.get(i),
            parent: None,
            count: edges,
        };
        if let Some(f) = all.hit(&walk, &x) {
            self.l[i] += f.value * f.weight;
        }
    }

    /// s = 1: light samples at all y.
    fn next_event<const SQUARE: bool>(&mut self, plain: &Plain<'_>, y: &Stage, address: u32, samplers: &[Sampler]) {
        let (scene, v, emitting) = (plain.all.c.scene, &mut self.v, &mut self.emitting);
        if !scene.lights.is_alone() {
            Sampler::u1_each(samplers, Dim::at(address, slot::LIGHT), &mut v.u_light);
        }
        draw(samplers, Dim::at(address, slot::LIGHT_POINT), &mut v.u_point);
        if let Some(lamp) = &plain.lone {
            emitting.density = [plain.lone_density; LANES];
            wide::widest(OfLamp { v, lamp, emitting });
        }
        let asks = |i: &usize| y.alive[*i] != 0 && plain.lone.as_ref().is_none_or(|lamp| lamp.is_near(v.p.get(*i)));
        let lanes: Vec<usize> = (0..samplers.len()).filter(asks).collect();
        let query =
            |i: &usize| LightQuery { from: v.from(*i), u_light: v.u_light[*i], u: Vec2::new(v.u_point[0][*i], v.u_point[1][*i]) };
        let queries: Vec<LightQuery> = lanes.iter().map(query).collect();
        let density = |s: &LightSample| {
            let z = emitting_point(scene, s.emitter, s.primitive, s.p, s.n, -s.wi);
            z.map_or(0.0, |z| scene.lights.pdf_emission(scene, &z).position.value())
        };
        scene.lights.sample_each(scene, &queries, &[], |k, sample| {
            let sample = sample.filter(|s| matches!(s.pdf, Pdf::SolidAngle(_)));
            v.set_light(lanes[k], sample.as_ref());
            if let Some(s) = &sample {
                emitting.n.set(lanes[k], s.n);
                emitting.density[lanes[k]] = density(s);
            }
        });
        wide::widest(NextEvent::<SQUARE> { y, light: &self.v.light, emitting: &self.emitting, joints: &mut self.joints });
        self.propose(y, |_, _| Some(1.0), |_| None);
    }

    /// s, t ≥ 2: all y with all z, each so many edges from its end.
    fn inner<const SQUARE: bool>(
        &mut self,
        plain: &Plain<'_>,
        (y, address): (&Stage, u32),
        (z, z_edges): (&Stage, u32),
        samplers: &[Sampler],
    ) {
        wide::widest(Inner::<SQUARE> { y, z, joints: &mut self.joints });
        let number = |i: usize| Strategies::number_of_worth(address, z_edges + 1, &samplers[i]);
        self.propose(y, |i, c| plain.all.worth.decide(c, || number(i)), |_| None);
    }

    /// t = 1: all z look at the lens.
    fn show<const SQUARE: bool>(&mut self, plain: &Plain<'_>, z: &Stage, address: u32, samplers: &[Sampler]) {
        let mut pixels = [Vec2::ZERO; LANES];
        let lens = &mut self.lens;
        for (i, u) in samplers.iter().enumerate().filter(|(i, _)| z.alive[*i] != 0) {
            let seen = plain.all.seen(z.p.get(i), address, u);
            lens.is_there[i] = u32::from(seen.is_some());
            if let Some(s) = &seen {
                lens.wi.set(i, s.wi);
                lens.p.set(i, s.p);
                lens.we[i] = s.we / s.pdf.value();
                pixels[i] = s.pixel;
            }
        }
        wide::widest(ToLens::<SQUARE> { z, lens, eye: plain.center, joints: &mut self.joints });
        let number = |i: usize| samplers[i].u1(Dim::at(address, light_slot::WORTH));
        self.propose(z, |i, c| plain.all.worth.decide_splat(c, || number(i)), |i| Some(pixels[i]));
    }

    /// Queues the connections that are there and worth it.
    fn propose(&mut self, stage: &Stage, grown: impl Fn(usize, Spectrum) -> Option<f32>, pixel: impl Fn(usize) -> Option<Vec2>) {
        let j = &self.joints;
        for i in (0..LANES).filter(|i| j.is_there[*i] != 0) {
            let (contribution, weight) = (rgb(j.contribution.get(i)), j.weight[i]);
            if let Some(grown) = grown(i, contribution * weight) {
                let ray = Ray { time: stage.times[i], ..Ray::new(j.shadow.o.get(i), j.shadow.d.get(i)).until(j.end[i]) };
                self.shadows.push(Shadow { ray, lane: i as u32, value: contribution * grown * weight, pixel: pixel(i) });
            }
        }
    }

    /// V of all that was queued.
    fn connect(&mut self, scene: &Scene, rays: &mut u64) {
        self.rays.clear();
        self.rays.extend(self.shadows.iter().map(|s| s.ray));
        *rays += self.rays.len() as u64;
        scene.occluded_each(&self.rays, &mut self.occluded);
        for (s, occluded) in self.shadows.drain(..).zip(&self.occluded) {
            if *occluded || s.value.is_zero() {
                continue;
            }
            match s.pixel {
                Some(pixel) => self.splats.push((s.lane, pixel, s.value)),
                None => self.l[s.lane as usize] += s.value,
            }
        }
    }
}
