//! The scene, and the questions that solvers ask of it.

use crate::emitter::{Emitter, Escape, LightReference, LightSample, Lights, Model, Seen};
use crate::ids::{EmitterId, MaterialId, NO_INSTANCE, SurfaceId};
use crate::interaction::Interaction;
use crate::material::Material;
use crate::settings::{Integrator, View};
use crate::shape::{Geometry, Surface, Surfaces};
use crate::texture::{Texture, TextureContext};
use etendue_accel::{Accel, Hit};
use etendue_bsdf::{Bsdf, Scatter};
use etendue_numerics::{Bounds3, Ray, Spectrum, Transform, Vec2, Vec3, Wavelengths};
use std::ops::Range;
use std::sync::Arc;

/// A compiled scene: immutable, flat, shared by all threads.
#[derive(Debug)]
pub struct Scene {
    /// RT(x, w) and V(x, y).
    pub accel: Accel,
    /// Shapes with their materials; a hit's `geometry` is an index here.
    pub surfaces: Surfaces,
    /// Local-to-world maps of the instances; a hit's `instance` is an index here.
    pub instances: Vec<Transform>,
    /// The surfaces that each instance shows.
    pub instance_surfaces: Vec<Arc<[SurfaceId]>>,
    /// Scattering.
    pub materials: Vec<Material>,
    /// Textures.
    pub textures: Vec<Texture>,
    /// Emission.
    pub emitters: Vec<Emitter>,
    /// How to choose among the emitters.
    pub lights: Lights,
    /// Cameras, in file order.
    pub views: Vec<View>,
    /// What the file asks of the solver.
    pub integrator: Integrator,
    /// The box around all surfaces.
    pub bounds: Bounds3,
    /// Whether any surface lets rays pass straight through (null, mask).
    pub has_transparent: bool,
    /// Triangles, those of instances counted once.
    pub triangles: u64,
    /// Whether walks carry wavelengths instead of linear Rec.709.
    pub spectral: bool,
}

/// How much passes straight along a segment, and how many null or mask surfaces it passed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmittance {
    /// The fraction that arrives.
    pub value: Spectrum,
    /// Surfaces passed.
    pub passed: u32,
}

impl Scene {
    /// Switches emitters on and off. One that is off sends out no light; its surface reflects, and stands in the way, as before.
    pub fn switch(&mut self, lit: impl Fn(EmitterId) -> bool) {
        for (i, emitter) in self.emitters.iter_mut().enumerate() {
            emitter.lit = lit(EmitterId(i as u32));
        }
        self.lights = Lights::new(self);
    }

    /// Whether some surroundings are seen through a portal: what shines from a direction then depends on the place.
    pub fn has_portals(&self) -> bool {
        self.emitters.iter().any(|e| matches!(e.model, Model::Portal(_)))
    }

    /// What the lanes of a walk stand for; `u` is asked for its number where they are wavelengths.
    #[inline]
    pub fn wavelengths(&self, u: impl FnOnce() -> f32) -> Wavelengths {
        if self.spectral { Wavelengths::hero(u()) } else { Wavelengths::Rgb }
    }

    /// RT(x, w): the first surface along the ray.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.accel.closest(ray, &self.surfaces)
    }

    /// RT of many rays, in their order.
    pub fn intersect_each(&self, rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        self.accel.closest_each(rays, &self.surfaces, hits);
    }

    /// Asks for the memory of what shading will look at where each ray ended, so that nobody waits for it alone.
    pub fn fetch_each(&self, hits: &[Option<Hit>]) {
        /// So many are asked for before the first is looked at.
        const AHEAD: usize = 16;
        /// What stays near by anyway.
        const FEW: u64 = 1024;
        if self.triangles < FEW {
            return;
        }
        let fetch = |hit: &Hit, stages: Range<u32>| {
            if let Some(mesh) = self.surface(SurfaceId(hit.geometry)).shape.mesh() {
                stages.for_each(|stage| mesh.fetch(hit.primitive, stage));
            }
        };
        let mut behind = hits.iter();
        for (k, hit) in hits.iter().enumerate() {
            if let Some(hit) = hit {
                fetch(hit, 0..1);
            }
            if k >= AHEAD
                && let Some(Some(hit)) = behind.next()
            {
                fetch(hit, 1..3);
            }
        }
        behind.flatten().for_each(|hit| fetch(hit, 1..3));
    }

    /// Whether anything stands in the way of each ray, null and mask surfaces included.
    pub fn occluded_each(&self, rays: &[Ray], occluded: &mut Vec<bool>) {
        self.accel.occluded_each(rays, &self.surfaces, occluded);
    }

    /// The surface at a hit, seen along `ray`.
    #[inline(always)] // as a return value it would go through memory
    pub fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
        let surface = self.surfaces.get(SurfaceId(hit.geometry));
        if hit.instance == NO_INSTANCE {
            surface.shape.interaction(ray, hit)
        } else {
            surface.shape.interaction_through(&self.instances[hit.instance as usize], ray, hit)
        }
    }

    /// V(x, y) as a spectrum: what passes along the ray up to its end, looking straight through null and mask surfaces.
    /// At most `passes` such surfaces are passed; `None` where nothing arrives.
    #[inline]
    pub fn transmittance(&self, ray: &Ray, passes: u32, wl: &Wavelengths) -> Option<Transmittance> {
        if !self.has_transparent {
            let clear = Transmittance { value: Spectrum::ONE, passed: 0 };
            return (!self.accel.occluded(ray, &self.surfaces)).then_some(clear);
        }
        self.transmittance_through(ray, passes, wl)
    }

    fn transmittance_through(&self, ray: &Ray, passes: u32, wl: &Wavelengths) -> Option<Transmittance> {
        let (mut ray, mut value, mut passed) = (*ray, Spectrum::ONE, 0);
        while let Some(hit) = self.intersect(&ray) {
            let surface = self.surface(SurfaceId(hit.geometry));
            if !self.material(surface.material).may_be_transparent() || passed == passes {
                return None;
            }
            let x = self.interaction(&ray, &hit);
            value *= self.bsdf(&x, wl).transparency(x.wo_local());
            if value.is_zero() {
                return None;
            }
            passed += 1;
            let next = x.spawn(ray.d);
            ray = Ray { t_max: ray.t_max - hit.t, ..next };
        }
        Some(Transmittance { value, passed })
    }

    /// f(·, x, ·): the material at x, evaluated once.
    #[inline]
    pub fn bsdf(&self, x: &Interaction, wl: &Wavelengths) -> Bsdf<'_> {
        let material = self.surface(x.surface).material;
        self.material(material).evaluate(self, x, wl)
    }

    /// The same into an empty `Bsdf`, where it stays.
    #[inline]
    pub fn bsdf_into<'s>(&'s self, x: &Interaction, wl: &Wavelengths, to: &mut Bsdf<'s>) {
        let material = self.surface(x.surface).material;
        self.material(material).evaluate_into(self, x, wl, to);
    }

    /// Le(x → wo), W/(m² sr): what the surface itself emits back along the ray.
    #[inline]
    pub fn le(&self, x: &Interaction, wl: &Wavelengths) -> Spectrum {
        match self.surface(x.surface).emitter {
            Some(id) => self.emitter(id).le(self, x, wl),
            None => Spectrum::ZERO,
        }
    }

    /// Le of the surroundings along a ray that meets nothing, W/(m² sr).
    pub fn le_escaped(&self, ray: &Ray, wl: &Wavelengths) -> Spectrum {
        self.lights.environments().iter().map(|id| self.emitter(*id).le_escaped(ray.o, ray.d, wl)).sum()
    }

    /// [`Scene::le_escaped`] of many rays, and [`Scene::pdf_light_escaped`] where it is asked for, in their order.
    pub fn escaped_each<'a>(&self, rays: impl Iterator<Item = Escape<'a>>, seen: &mut Vec<Seen>) {
        seen.clear();
        self.lights.escaped_each(self, rays, |found| seen.push(found));
    }

    /// A point on a light, chosen for the surface point `from`: `u_light` chooses the light, `u` the point on it.
    #[inline]
    pub fn sample_light(&self, from: &LightReference, u_light: f32, u: Vec2, wl: &Wavelengths) -> Option<LightSample> {
        self.lights.sample(self, from, u_light, u, wl)
    }

    /// The density, 1/sr at `from`, with which [`Scene::sample_light`] would have chosen the emitting point `x`.
    #[inline]
    pub fn pdf_light(&self, from: &LightReference, x: &Interaction) -> f32 {
        self.lights.pdf(self, from, x)
    }

    /// The density, 1/sr at `from`, with which [`Scene::sample_light`] would have chosen the direction `wi` of the surroundings.
    #[inline]
    pub fn pdf_light_escaped(&self, from: &LightReference, wi: Vec3) -> f32 {
        self.lights.pdf_escaped(self, from, wi)
    }

    /// What textures may know of x.
    #[inline]
    pub fn texture_context<'a>(&'a self, x: &Interaction) -> TextureContext<'a> {
        TextureContext { scene: self, uv: x.uv, surface: x.surface, primitive: x.primitive, bary: x.bary, p: x.p, n: x.shading.n }
    }

    /// The surface of an id.
    #[inline]
    pub fn surface(&self, id: SurfaceId) -> &Surface {
        self.surfaces.get(id)
    }

    /// The material of an id.
    #[inline]
    pub fn material(&self, id: MaterialId) -> &Material {
        &self.materials[id.index()]
    }

    /// The emitter of an id.
    #[inline]
    pub fn emitter(&self, id: EmitterId) -> &Emitter {
        &self.emitters[id.index()]
    }
}
