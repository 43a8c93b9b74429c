//! The walks from both ends, a vertex at a time: `LightPath::trace` and `Strategies::sample` of many samples at once.

use super::super::place::Place;
use super::super::turn::{Turn, relate};
use super::super::vertices::LANES;
use super::super::{draw, reflectance};
use super::stage::{Arrive, Leave, Stage, TurnToEye};
use super::{Pairs, Plain};
use crate::bidirectional::light_path::Origin;
use crate::bidirectional::weights::{Trail, power};
use crate::transport::{HOPE, HOPE_OF_LIGHT, PathState, light_slot, slot};
use etendue_accel::Hit;
use etendue_numerics::{Dim, Ray, Sampler, Spectrum, Vec2, Vec3, Wavelengths, wide};
use etendue_scene::{NO_INSTANCE, Scene, SurfaceId};

impl Pairs {
    /// The walks from the lights; their vertices stay in `lights`.
    pub(super) fn walk_from_lights<const SQUARE: bool>(&mut self, plain: &Plain<'_>, samplers: &[Sampler], rays: &mut u64) {
        let (all, scene, rules) = (plain.all, plain.all.c.scene, &plain.all.c.rules);
        self.v.roulette_scale = [1.0; LANES];
        self.origins.clear();
        self.rays.clear();
        self.going.clear();
        for (i, u) in samplers.iter().enumerate() {
            let origin = Origin::sample(scene, u, &Wavelengths::Rgb);
            if let Some(origin) = &origin {
                self.set_out(i, &origin.ray, origin.flux, &origin.trail());
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
                relate(&mut self.v, HOPE_OF_LIGHT);
            }
            self.leave::<SQUARE>(z);
            self.kept += 1;
        }
        self.lights = lights;
        self.connect(scene, rays);
    }

    /// The walks from the eye.
    pub(super) fn walk_from_eye<const SQUARE: bool>(
        &mut self,
        plain: &Plain<'_>,
        eyes: &[PathState],
        samplers: &[Sampler],
        rays: &mut u64,
    ) {
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
            self.inner::<SQUARE>(plain, y, edges, &lights[..self.kept], samplers);
            self.connect(scene, rays);

            // The next direction.
            let roulette = edges >= rules.rr_depth();
            draw(samplers, Dim::at(edges, slot::BSDF), &mut self.v.u_bsdf);
            if roulette {
                draw(samplers, Dim::at(edges, slot::LOBE), &mut self.v.u_lobe);
            }
            wide::widest(Turn { vertices: &mut self.v, roulette });
            if edges == 1 {
                relate(&mut self.v, HOPE);
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
}
