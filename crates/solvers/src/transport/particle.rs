//! A walk from a light as plain data: what path tracing is to the eye.
//!
//! ```text
//! Φ_0 = Le |cosθ| / (p(y) p(w)),    Φ_{k+1} = Φ_k · f*(x_k) |cosθ| / p(w_k)          W
//! I_j = E[ Σ_k Φ_k · f*(x_k → lens) |cosθ| We h_j / p(lens) ]
//! ```
//!
//! A particle carries flux. At each surface it may be connected to the sensor ([`to_sensor`]: next event estimation of the adjoint), or it
//! counts where it passes the lens ([`through_lens`]).
//!
//! *Edges* are counted from the light: with one more to the eye they are those of the whole path.

use super::{Context, PathRules, ShadowQuery, Tally, Throughput, Vertex, VertexSample, arrives, slot};
use crate::drivers::pixels::beyond_emitters;
use etendue_bsdf::Scatter;
use etendue_numerics::{Dim, Pdf, Ray, Sampler, Spectrum, Vec2, Vec3, Wavelengths};
use etendue_scene::emitter::EmissionSample;
use etendue_scene::interaction::SHADOW_EPSILON;
use etendue_scene::{Interaction, Scene, SurfaceId, View};

/// The random decisions of a walk from a light, apart from those of a walk from the eye; each has two dimensions.
pub mod light_slot {
    /// At vertex 0: which light.
    pub const LIGHT: u32 = 8;
    /// At vertex 0: where on the light.
    pub const POSITION: u32 = 9;
    /// At vertex 0: in which direction.
    pub const DIRECTION: u32 = 10;
    /// At vertex 0: the position within a pixel of light that needs no bounce.
    pub const PIXEL: u32 = 11;
    /// Where on the lens; at vertex 0 of the emitting point.
    pub const LENS: u32 = 12;
    /// At vertex 0: where on the lens, of light that needs no bounce.
    pub const SEEN_LENS: u32 = 13;
    /// Direction within a lobe.
    pub const BSDF: u32 = 8;
    /// Which lobe (x) and roulette (y).
    pub const LOBE: u32 = 9;
    /// Whether the connection to the lens is worth a shadow ray.
    pub const WORTH: u32 = 10;
}

/// What every particle of a pass shares.
#[derive(Clone, Copy)]
pub struct LightContext<'a> {
    /// The scene, and which paths count.
    pub path: Context<'a>,
    /// The camera with its film.
    pub view: &'a View,
    /// The most edges that a walk may have before it is of no use any more.
    pub reach: u32,
}

/// A particle between two vertices.
#[derive(Clone, Copy, Debug)]
pub struct Particle {
    /// The ray to be cast next.
    pub ray: Ray,
    /// Φ_0, W.
    pub flux: Spectrum,
    /// Φ_k / Φ_0.
    pub beta: Throughput,
    /// Wavelengths of the lanes.
    pub wl: Wavelengths,
    /// Edges between the light and the ray's end.
    pub edges: u32,
    /// Vertices so far, the light's included: the address of random decisions.
    pub vertex: u32,
    /// What must happen to it before it may count at the lens.
    pub waits_for: Awaited,
    /// How it came to its ray.
    pub came: Came,
}

/// How a particle came from the light, null and mask surfaces that it passed aside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Came {
    /// Straight: what it brings is direct light.
    Straight,
    /// By mirrors and smooth glass alone: a caustic.
    Specular,
    /// By at least one surface that spread it.
    Scattered,
}

/// What must happen to a particle before it may count where it passes the lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Awaited {
    /// Nothing: it comes from a surface, which the eye can see.
    Nothing,
    /// Scattering of any kind: light of the surroundings that needs none is drawn from the lens ([`surroundings`]).
    Scattering,
    /// Scattering into more than a discrete few directions: points and single directions are not seen, nor are they in mirrors.
    Spreading,
}

impl Particle {
    /// A particle about to leave a light, chosen with probability ∝ its flux, and what is known of the point that it leaves.
    pub fn emit(scene: &Scene, u: &Sampler) -> Option<(Self, EmissionSample)> {
        Self::emit_at(wavelengths(scene, u), scene, u)
    }

    /// The same, with wavelengths of one's own.
    pub fn emit_at(wl: Wavelengths, scene: &Scene, u: &Sampler) -> Option<(Self, EmissionSample)> {
        let at = |slot| u.u2(Dim::at(0, slot));
        let u_light = u.u1(Dim::at(0, light_slot::LIGHT));
        let light = scene.lights.sample_emission(scene, u_light, at(light_slot::POSITION), at(light_slot::DIRECTION), &wl)?;
        let waits_for = if scene.emitter(light.emitter).is_delta() {
            Awaited::Spreading
        } else if scene.lights.environments().contains(&light.emitter) {
            Awaited::Scattering
        } else {
            Awaited::Nothing
        };
        let particle = Self {
            ray: light.ray,
            flux: light.weight,
            beta: Throughput::ONE,
            wl,
            edges: 1,
            vertex: 1,
            waits_for,
            came: Came::Straight,
        };
        (light.weight.is_finite() && light.weight.max_lane() > 0.0).then_some((particle, light))
    }

    /// Φ as red, green and blue, W.
    #[inline]
    pub fn weighed(&self) -> Spectrum {
        self.wl.to_rgb(self.carried())
    }

    /// Φ, W.
    #[inline]
    pub fn carried(&self) -> Spectrum {
        self.beta.carry(self.flux)
    }

    /// The address of a random decision at the vertex that the ray leads to.
    #[inline]
    pub fn dim(&self, slot: u32) -> Dim {
        Dim::at(self.vertex, slot)
    }

    /// The surface that the particle meets next; `None` where it escapes, or has no edges left.
    #[inline]
    pub fn meet(&self, c: &LightContext<'_>, tally: &mut Tally) -> Option<Interaction> {
        if self.edges > c.reach {
            tally.cut(self.weighed());
            return None;
        }
        tally.rays += 1;
        let hit = c.path.scene.intersect(&self.ray);
        if hit.is_none() {
            tally.escaped(self.weighed());
        }
        hit.map(|hit| c.path.scene.interaction(&self.ray, &hit))
    }

    /// The vertex at x with its material. Where that sends each wavelength another way the particle goes on with one.
    #[inline(always)] // it is large, and better made where it stays
    pub fn vertex<'a>(&mut self, scene: &'a Scene, x: Interaction) -> Vertex<'a> {
        let mut vertex = Vertex::at(x);
        vertex.evaluate(scene, &self.wl);
        if vertex.bsdf.events().disperses() {
            self.beta.scatter(self.wl.single_out());
        }
        vertex
    }

    /// Turns the particle into a direction sampled at a vertex; `false` where it ends.
    #[inline]
    pub fn turn(&mut self, c: &LightContext<'_>, vertex: &Vertex, u: &Sampler, tally: &mut Tally) -> bool {
        let before = self.weighed();
        let u_lobe = u.u2(self.dim(light_slot::LOBE));
        let sample = vertex.sample_adjoint(c.path.scene, u_lobe.x, u.u2(self.dim(light_slot::BSDF)), &self.wl);
        let Some(s) = sample.filter(|s| !s.weight.is_zero()) else {
            tally.absorbed(before);
            return false;
        };
        self.scatter(&c.path.rules, vertex, &s);
        tally.absorbed(before - self.weighed());
        let before = self.weighed();
        let goes_on = self.survives(&c.path.rules, u_lobe.y);
        tally.cut(if goes_on { before - self.weighed() } else { before });
        self.vertex += 1;
        goes_on
    }

    fn scatter(&mut self, rules: &PathRules, vertex: &Vertex, s: &VertexSample) {
        self.beta.scatter(s.weight);
        self.ray = vertex.x.spawn(s.wi);
        self.edges += u32::from(rules.null_counts || !s.is_null);
        if !s.pdf.is_delta() || !s.is_null && self.waits_for == Awaited::Scattering {
            self.waits_for = Awaited::Nothing;
        }
        if !s.pdf.is_delta() {
            self.came = Came::Scattered;
        } else if !s.is_null && self.came == Came::Straight {
            self.came = Came::Specular;
        }
    }

    /// Roulette: q = min(Φ_k / Φ_0, 0.95) in the brightest channel. Importance is not compressed by refraction: no η² here.
    fn survives(&mut self, rules: &PathRules, u: f32) -> bool {
        const MOST: f32 = 0.95;
        if self.vertex < rules.rr_depth() {
            return true;
        }
        let q = (self.carried().max_lane() / self.flux.max_lane()).min(MOST);
        if u >= q {
            return false;
        }
        self.beta.divide(q);
        true
    }
}

/// The wavelengths of a particle, and of all that is done with its numbers.
#[inline]
pub(crate) fn wavelengths(scene: &Scene, u: &Sampler) -> Wavelengths {
    scene.wavelengths(|| u.u1(Dim::at(0, slot::WAVELENGTHS)))
}

/// A connection to the sensor: where it falls on the full film, and what must be free for it to count.
#[derive(Clone, Copy, Debug)]
pub struct SensorQuery {
    /// The segment and what arrives if nothing is in between.
    pub shadow: ShadowQuery,
    /// Where on the full film, in pixels.
    pub pixel: Vec2,
    /// The camera's ray along the same line: where it starts, and its direction.
    pub eye: (Vec3, Vec3),
    /// The surface of the vertex.
    pub surface: Option<SurfaceId>,
}

/// The connection of a surface vertex to a point of the lens.
#[inline]
pub fn to_sensor(c: &LightContext<'_>, particle: &Particle, vertex: &Vertex, u: &Sampler) -> Option<SensorQuery> {
    let edges = particle.edges + 1;
    if !vertex.is_smooth() || !may_count(&c.path, edges) {
        return None;
    }
    let lens = c.view.sensor.sample_direction(vertex.x.p, u.u2(particle.dim(light_slot::LENS)))?;
    let (f_cos, _) = vertex.eval_adjoint(c.path.scene, lens.wi, &particle.wl);
    if f_cos.is_zero() {
        return None;
    }
    let contribution = particle.beta.carry(particle.flux * f_cos) * (lens.we / lens.pdf.value());
    let shadow = ShadowQuery { ray: lens.shadow_ray(&vertex.x)?, contribution, edges };
    Some(SensorQuery { shadow, pixel: lens.pixel, eye: (lens.p, -lens.wi), surface: Some(vertex.x.surface) })
}

/// The connection of the emitting point itself: emitters as the eye sees them. Points and single directions cannot be seen.
///
/// A surface of the lights here is equally bright from all directions, so the particle's own flux tells its radiance: Le = Φ_0 p(y) p(w) / |cosθ|.
pub fn emitter_to_sensor(c: &LightContext<'_>, particle: &Particle, light: &EmissionSample, u: &Sampler) -> Option<SensorQuery> {
    let Pdf::SolidAngle(pdf_w) = light.pdf.direction else { return None };
    if particle.waits_for != Awaited::Nothing || !may_count(&c.path, 1) {
        return None;
    }
    let lens = c.view.sensor.sample_direction(light.ray.o, u.u2(Dim::at(0, light_slot::LENS)))?;
    let (cos, cos_emitted) = (light.n.dot(lens.wi), light.n.dot(light.ray.d));
    if cos <= 0.0 || cos_emitted <= 0.0 {
        return None;
    }
    let le_over_pdf = particle.flux * (pdf_w / cos_emitted);
    let contribution = le_over_pdf * (cos * lens.we / lens.pdf.value());
    let distance = (lens.p - light.ray.o).length() * (1.0 - SHADOW_EPSILON);
    let shadow = ShadowQuery { ray: Ray::new(light.ray.o, lens.wi).until(distance), contribution, edges: 1 };
    Some(SensorQuery { shadow, pixel: lens.pixel, eye: (lens.p, -lens.wi), surface: None })
}

/// What of a connection arrives. Hidden emitters do not stand in the eye's way, nor are they seen without a null surface before them.
pub fn arrives_at_sensor(c: &LightContext<'_>, query: &SensorQuery, wl: &Wavelengths) -> Spectrum {
    if !c.path.rules.hide_emitters {
        return arrives(&c.path, &query.shadow, wl);
    }
    let scene = c.path.scene;
    let (p, d) = query.eye;
    let length = (query.shadow.ray.o - p).length() * (1.0 - SHADOW_EPSILON);
    let ray = beyond_emitters(scene, Ray::new(p, d).until(length));
    let emits = query.surface.is_some_and(|s| scene.surface(s).emitter.is_some());
    let clear = scene.transmittance(&ray, 0, wl).is_some();
    if emits && clear { Spectrum::ZERO } else { arrives(&c.path, &ShadowQuery { ray, ..query.shadow }, wl) }
}

/// Whether a path of so many edges may count, null surfaces that a connection passes still to be added.
#[inline]
pub(crate) fn may_count(c: &Context<'_>, edges: u32) -> bool {
    if c.rules.null_counts && c.scene.has_transparent { edges <= c.rules.max_edges } else { c.rules.counts(edges) }
}

/// The particle's own passage through the lens, before it meets the next surface at `t_hit`: We at that place of the film.
#[inline]
pub fn through_lens(c: &LightContext<'_>, particle: &Particle, t_hit: f32, from: Option<SurfaceId>) -> Option<(Vec2, Spectrum)> {
    if particle.waits_for != Awaited::Nothing || !c.path.rules.counts(particle.edges) {
        return None;
    }
    let passage = c.view.sensor.passage(&particle.ray)?;
    let free = if c.path.rules.hide_emitters {
        let eye = Ray::new(particle.ray.at(passage.t), -particle.ray.d).until(passage.t * (1.0 - SHADOW_EPSILON));
        let emits = from.is_some_and(|s| c.path.scene.surface(s).emitter.is_some());
        !emits && !c.path.scene.accel.occluded(&beyond_emitters(c.path.scene, eye), &c.path.scene.surfaces)
    } else {
        passage.t <= t_hit
    };
    free.then(|| (passage.pixel, particle.weighed() * passage.we))
}

/// The surroundings as the eye sees them, through one position of the film. Their light sets out from a disk before the scene, which may
/// miss the lens: what needs no bounce is drawn from the lens, one ray a particle, as path tracing does.
pub fn surroundings(c: &LightContext<'_>, pixel: Vec2, u: &Sampler, tally: &mut Tally) -> Option<Spectrum> {
    let scene = c.path.scene;
    if scene.lights.environments().is_empty() || !may_count(&c.path, 1) {
        return None;
    }
    let seen = c.view.sensor.sample_ray(pixel, u.u2(Dim::at(0, light_slot::SEEN_LENS)), 0.0);
    tally.rays += 1;
    let wl = wavelengths(scene, u);
    let ray = if c.path.rules.hide_emitters { beyond_emitters(scene, seen.ray) } else { seen.ray };
    let le = scene.le_escaped(&ray, &wl);
    Some(wl.to_rgb(arrives(&c.path, &ShadowQuery { ray, contribution: le * seen.weight, edges: 1 }, &wl)))
}
