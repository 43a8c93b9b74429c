//! The strategies (s, t): how the vertices of an eye path and of a light path are joined to whole paths.
//!
//! ```text
//! s = 0          C = β_y Le                                      the eye path has hit a light
//! s = 1          C = β_y f_y |cosθ_y| Le / p_N                   next event estimation
//! s, t ≥ 2       C = β_y f_y |cosθ_y| · f*_z |cosθ_z| β_z / r²    both ends wait
//! t = 1          C = β_z f*_z |cosθ_z| We / p                    the light path looks at the lens
//! ```
//!
//! y is the last vertex of the eye path, z that of the light path; f |cosθ| holds |cosθ| to the shading normal and f* |cosθ| what shading normals
//! make of it for a particle, so that 1/r² is all that is left of G.

use super::eye::Eye;
use super::light_path::{Finders, LightPath, Origin, Place, emitting_point, surroundings_density};
use super::path_vertex::{PathVertex, Sides};
use super::walk::Walk;
use super::weights::power;
use super::worth::Worth;
use crate::transport::{Context, Heuristic, LightContext, SensorQuery, ShadowQuery, arrives, arrives_at_sensor, light_slot, slot};
use etendue_numerics::{Dim, Numbers, Pdf, Ray, Spectrum, Vec2, Vec3, Wavelengths};
use etendue_scene::interaction::SHADOW_EPSILON;
use etendue_scene::sensor::SensorSample;
use etendue_scene::{Interaction, LightSample, Sensor, View};

/// What all strategies share.
#[derive(Clone, Copy)]
pub struct Strategies<'a> {
    /// The scene, and which paths count.
    pub c: Context<'a>,
    /// The scene's materials.
    pub sides: Sides<'a>,
    /// The camera with its film.
    pub view: &'a View,
    /// The camera as the weights see it.
    pub eye: Eye,
    /// How they share.
    pub heuristic: Heuristic,
    /// Which connections are worth a shadow ray.
    pub worth: Worth,
    /// The wavelengths of both walks.
    pub wl: Wavelengths,
}

/// A path that a strategy found.
#[derive(Clone, Copy, Debug)]
pub struct Found<'a> {
    /// Its vertices from the light's side.
    pub s: u32,
    /// Its vertices from the eye's side, the lens included.
    pub t: u32,
    /// C: what it would add to the picture if there were no other strategy.
    pub value: Spectrum,
    /// w.
    pub weight: f32,
    /// Where on the full film, in pixels, for t = 1; that of the camera's ray otherwise.
    pub pixel: Option<Vec2>,
    /// How its halves were joined.
    pub joint: Joint<'a>,
}

/// How the halves of a path were joined.
#[derive(Clone, Copy, Debug)]
pub enum Joint<'a> {
    /// The eye path, its last vertex `from` if there is one, hit an emitting surface.
    Hit(Option<u32>, &'a Interaction),
    /// The eye path left the scene along the direction.
    Escape(Option<u32>, Vec3),
    /// The light sampler at y.
    Light(&'a PathVertex<'a>, &'a LightSample),
    /// y and z were connected.
    Inner(&'a PathVertex<'a>, &'a PathVertex<'a>),
    /// z was connected to the lens, seen in the direction.
    Lens(&'a PathVertex<'a>, Vec3),
    /// The emitting point was connected to the lens, seen in the direction.
    Emitter(&'a Origin, Vec3),
}

/// 1 / (1 + all others).
#[inline]
fn share(others: f32) -> f32 {
    1.0 / (1.0 + others)
}

impl<'a> Strategies<'a> {
    /// Whether a path of so many edges may count, null surfaces that a connection passes still to be added.
    #[inline]
    pub(crate) fn may_count(&self, edges: u32) -> bool {
        let rules = &self.c.rules;
        if rules.null_counts && self.c.scene.has_transparent { edges <= rules.max_edges } else { rules.counts(edges) }
    }

    /// s = 0: the eye path hits an emitting surface at x.
    #[inline]
    pub fn hit<'v>(&self, walk: &Walk<'_, '_>, x: &'v Interaction) -> Option<Found<'v>> {
        if !self.c.rules.counts(walk.state.edges) {
            return None;
        }
        let le = self.c.scene.le(x, &self.wl);
        if le.is_zero() {
            return None;
        }
        let h = self.heuristic;
        let link = walk.trail.arrive(x.p, x.n, x.wo);
        let pdf = self.c.scene.lights.pdf_emission(self.c.scene, x);
        let (position, direction) = (pdf.position.value(), pdf.direction.value());
        // What the lens sees of a lamp it sees without noise: no other strategy has a share.
        let others = if walk.count == 1 {
            0.0
        } else {
            let pdf_light = if link.connect > 0.0 { self.c.scene.pdf_light(&walk.state.from, x) } else { 0.0 };
            let to_area = walk.trail.to_area(x.p, x.n, x.wo);
            link.next_event(h, pdf_light * to_area) + link.emitted(h, position, direction)
        };
        let joint = Joint::Hit(walk.parent, x);
        Some(Found { s: 0, t: walk.count + 1, value: walk.beta() * le, weight: share(others), pixel: None, joint })
    }

    /// s = 0: the eye path sees the surroundings.
    pub fn escape(&self, walk: &Walk<'_, '_>) -> Option<Found<'static>> {
        let ray = walk.ray();
        if !self.c.rules.counts(walk.state.edges) {
            return None;
        }
        let le = self.c.scene.le_escaped(ray, &self.wl);
        if le.is_zero() {
            return None;
        }
        let h = self.heuristic;
        let others = if walk.count == 1 {
            0.0
        } else {
            let link = walk.trail.escape(ray.d);
            let pdf_light = if link.connect > 0.0 { self.c.scene.pdf_light_escaped(&walk.state.from, ray.d) } else { 0.0 };
            link.next_event(h, pdf_light) + link.emitted(h, surroundings_density(self.c.scene, ray.d), 1.0)
        };
        let joint = Joint::Escape(walk.parent, ray.d);
        Some(Found { s: 0, t: walk.count + 1, value: walk.beta() * le, weight: share(others), pixel: None, joint })
    }

    /// s = 1: a light sample at y; `found` is told.
    #[inline]
    pub fn next_event(&self, y: &PathVertex, u: &impl Numbers, rays: &mut u64, found: &mut impl FnMut(&Found<'_>)) {
        let (scene, x, edges) = (self.c.scene, &y.vertex.x, y.edges + 1);
        if !self.may_count(edges) {
            return;
        }
        let at = |slot| Dim::at(y.address, slot);
        let u_light = if scene.lights.is_alone() { 0.0 } else { u.u1(at(slot::LIGHT)) };
        let from = y.vertex.light_reference();
        let Some(light) = scene.sample_light(&from, u_light, u.u2(at(slot::LIGHT_POINT)), &self.wl) else { return };
        let Some(turn) = self.sides.turn_to_light(&y.vertex, light.wi, &self.wl) else { return };
        let Some(ray) = light.shadow_ray(x) else { return };
        let contribution = y.beta * turn.f_cos * light.le / light.pdf.value();
        *rays += 1;
        let value = arrives(&self.c, &ShadowQuery { ray, contribution, edges }, &self.wl);
        if value.is_zero() {
            return;
        }

        let h = self.heuristic;
        let hit = match light.pdf {
            Pdf::SolidAngle(p) => power(h, turn.onward, p),
            Pdf::Delta(_) => 0.0,
        };
        let emitted = self.emitted_towards(&light, x) / light.pdf.value();
        let weight = share(hit + y.link.others(h, emitted, turn.way_back));
        found(&Found { s: 1, t: y.count, value, weight, pixel: None, joint: Joint::Light(y, &light) });
    }

    /// p_E(z_0) p⃗(x), of a light sample at x, in the measure of the sample's own density.
    fn emitted_towards(&self, light: &LightSample, x: &Interaction) -> f32 {
        let (scene, w) = (self.c.scene, -light.wi);
        let cos = x.n.dot(w).abs();
        let r2 = light.distance * light.distance;
        let product = |pdf: etendue_scene::emitter::EmissionPdf| pdf.position.value() * pdf.direction.value();
        match (emitting_point(scene, light.emitter, light.primitive, light.p, light.n, w), light.pdf) {
            // From area to the solid angle of the sample: the distance cancels.
            (Some(z), _) => product(scene.lights.pdf_emission(scene, &z)) * cos / light.n.dot(w).abs(),
            (None, Pdf::Delta(_)) => {
                let spread = if light.distance.is_finite() { 1.0 / r2 } else { 1.0 };
                product(scene.lights.pdf_emission_discrete(scene, light.emitter, w)) * cos * spread
            }
            (None, Pdf::SolidAngle(_)) => surroundings_density(scene, light.wi) * cos,
        }
    }

    /// s, t ≥ 2: y and z connected.
    #[inline]
    pub fn inner<'v>(&self, y: &'v PathVertex, z: &'v PathVertex, u: &impl Numbers, rays: &mut u64) -> Option<Found<'v>> {
        let edges = y.edges + z.edges + 1;
        if !self.may_count(edges) {
            return None;
        }
        let (a, b) = (&y.vertex.x, &z.vertex.x);
        let d = b.p - a.p;
        let r2 = d.length_squared();
        let w = d / r2.sqrt();
        if !w.is_finite() {
            return None;
        }
        let at_y = self.sides.turn_to_light(&y.vertex, w, &self.wl)?;
        let at_z = self.sides.turn_to_eye(&z.vertex, -w, &self.wl)?;

        let h = self.heuristic;
        let (to_y, to_z) = (a.n.dot(w).abs() / r2, b.n.dot(w).abs() / r2);
        let more_light = y.link.others(h, at_z.onward * to_y, at_y.way_back);
        let more_eye = z.link.others(h, at_y.onward * to_z, at_z.way_back);
        let weight = share(more_light + more_eye);

        // Where both walks go on with one wavelength each has made up for the others: once is enough.
        let r2 = if y.is_alone && z.is_alone { 4.0 * r2 } else { r2 };
        let contribution = (y.beta * at_y.f_cos) * (z.beta * at_z.f_cos) / r2;
        let grown =
            self.worth.decide(contribution * weight, || Self::number_of_worth(u.u1(Dim::at(y.address, slot::WORTH)), z.count))?;
        let ray = a.spawn_between(b)?;
        *rays += 1;
        let value = arrives(&self.c, &ShadowQuery { ray, contribution: contribution * grown, edges }, &self.wl);
        if value.is_zero() {
            return None;
        }
        Some(Found { s: z.count, t: y.count, value, weight, pixel: None, joint: Joint::Inner(y, z) })
    }

    /// The number that decides about the shadow ray between y and z, where y has the number `u`: turned by the golden ratio from each z to the next.
    #[inline(always)]
    pub(crate) fn number_of_worth(u: f32, count: u32) -> f32 {
        (u + 0.618_034 * count as f32).fract()
    }

    /// t = 1: z looks at the lens.
    #[inline]
    pub fn lens<'v>(&self, z: &'v PathVertex, u: &impl Numbers, rays: &mut u64) -> Option<Found<'v>> {
        let edges = z.edges + 1;
        if !self.may_count(edges) {
            return None;
        }
        let x = &z.vertex.x;
        let lens = self.seen(x.p, z.address, u)?;
        let turn = self.sides.turn_to_eye(&z.vertex, lens.wi, &self.wl)?;
        let h = self.heuristic;
        let others = z.link.others(h, self.eye.density(x.p, x.n, -lens.wi), turn.way_back);
        let weight = share(others / power(h, self.eye.rho, 1.0));

        let contribution = z.beta * turn.f_cos * (lens.we / lens.pdf.value());
        let grown = self.worth.decide_splat(contribution * weight, || u.u1(Dim::at(z.address, light_slot::WORTH)))?;
        let shadow = ShadowQuery { ray: lens.shadow_ray(x)?, contribution: contribution * grown, edges };
        let query = SensorQuery { shadow, pixel: lens.pixel, eye: (lens.p, -lens.wi), surface: Some(x.surface) };
        let value = self.arrives_at_sensor(&query, rays)?;
        Some(Found { s: z.count, t: 1, value, weight, pixel: Some(lens.pixel), joint: Joint::Lens(z, lens.wi) })
    }

    /// s = 1, t = 1: the emitting point itself looks at the lens. Points and single directions are not seen; the surroundings are by s = 0 alone. Its weight
    /// is 0, since the walk from the eye finds the same without noise: it is a picture to compare with.
    pub fn emitter<'v>(&self, path: &'v LightPath, u: &impl Numbers, rays: &mut u64) -> Option<Found<'v>> {
        let origin = path.origin.as_ref()?;
        let Place::Surface(x, Finders::SamplesAndHits) = &origin.place else { return None };
        if !self.may_count(1) {
            return None;
        }
        let lens = self.seen(x.p, 0, u)?;
        let (cos, cos_emitted) = (x.n.dot(lens.wi), x.n.dot(origin.ray.d));
        if cos <= 0.0 || cos_emitted <= 0.0 {
            return None;
        }
        // Surfaces are equally bright from all directions: the particle's own flux tells Le / p.
        let le = origin.flux * (origin.pdf_w / cos_emitted);
        let distance = (lens.p - x.p).length() * (1.0 - SHADOW_EPSILON);
        let shadow = ShadowQuery {
            ray: Ray::new(x.p, lens.wi).until(distance),
            contribution: le * (cos * lens.we / lens.pdf.value()),
            edges: 1,
        };
        let query = SensorQuery { shadow, pixel: lens.pixel, eye: (lens.p, -lens.wi), surface: Some(x.surface) };
        let value = self.arrives_at_sensor(&query, rays)?;
        Some(Found { s: 1, t: 1, value, weight: 0.0, pixel: Some(query.pixel), joint: Joint::Emitter(origin, lens.wi) })
    }

    /// The lens as `p` sees it, where that falls within the crop.
    #[inline]
    pub(crate) fn seen(&self, p: Vec3, address: u32, u: &impl Numbers) -> Option<SensorSample> {
        // Only a lens of some size has a choice.
        let has_size = matches!(self.view.sensor, Sensor::ThinLens(_));
        let lens = if has_size { u.u2(Dim::at(address, light_slot::LENS)) } else { Vec2::ZERO };
        let film = &self.view.film;
        let own = |s: &SensorSample| s.pixel - Vec2::new(film.crop_offset[0] as f32, film.crop_offset[1] as f32);
        let size = Vec2::new(film.crop_size[0] as f32, film.crop_size[1] as f32);
        let within = |q: Vec2| q.cmpge(Vec2::ZERO).all() && q.cmplt(size).all();
        self.view.sensor.sample_direction(p, lens).filter(|s| within(own(s)))
    }

    fn arrives_at_sensor(&self, query: &SensorQuery, rays: &mut u64) -> Option<Spectrum> {
        *rays += 1;
        let c = LightContext { path: self.c, view: self.view, reach: u32::MAX };
        let value = arrives_at_sensor(&c, query, &self.wl);
        (!value.is_zero()).then_some(value)
    }
}
