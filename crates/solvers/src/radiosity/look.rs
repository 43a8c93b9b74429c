//! What the eye sees of a solution.
//!
//! ```text
//! smooth    L = Le + ρ(x)/π [ Σ Le(y) V cosθ / p + H(x) ]
//! gather    L = Le + ρ(x)/π [ Σ Le(y) V cosθ / p + R(RT(x, w)) ]        w with density cosθ/π
//! patches   L = B/π of the patch
//! ```

use super::shown::{Show, Shown};
use crate::drivers::PixelSolver;
use crate::transport::{Context, PathState, Vertex, arrives, next_event, slot};
use etendue_accel::Hit;
use etendue_numerics::math::{FRAC_1_PI, PI};
use etendue_numerics::warp::square_to_cosine_hemisphere;
use etendue_numerics::{Frame, Ray, Sampler, Spectrum};
use etendue_radiosity::Patches;
use etendue_radiosity::patch::Place;
use etendue_scene::{Interaction, LightReference, Scene};
use glam::DVec3;

/// Looks at a solution.
pub struct Look<'a>(pub &'a Shown);

impl PixelSolver for Look<'_> {
    fn radiance(&self, c: &Context<'_>, mut eye: PathState, u: &Sampler, rays: &mut u64) -> Spectrum {
        let Shown { patches: Some(patches), show, raw, .. } = self.0 else { return eye.l };
        let Some((ray, hit)) = first(c.scene, patches, eye.ray, rays) else {
            eye.collect(&c.rules, c.scene.le_escaped(&eye.ray, &eye.wl));
            return eye.l;
        };
        let place = patches.locate(&ray, &hit);
        let patch = place.and_then(|p| p.patch);
        if *show == Show::Patches {
            let l = patch.map_or(DVec3::ZERO, |i| raw[i as usize]);
            return eye.beta.carry(spectrum(l));
        }
        let x = c.scene.interaction(&ray, &hit);
        eye.collect(&c.rules, c.scene.le(&x, &eye.wl));
        let (Some(place), Some(i)) = (place, patch) else { return eye.l };
        if c.rules.max_edges < 2 {
            return eye.l;
        }

        let vertex = Vertex::new(c.scene, x, &eye.wl);
        let is_diffuse = self.0.is_diffuse[x.surface.index()];
        let rho = if is_diffuse { lambert(&vertex) } else { patches.get(i).rho };
        if rho.is_zero() {
            return eye.l;
        }
        if is_diffuse {
            if let Some(query) = next_event(c, &eye, &vertex, u, |_, _| 1.0) {
                *rays += 1;
                eye.l += arrives(c, &query, &eye.wl);
            }
        } else if c.rules.counts(2) {
            let e = direct(c, &eye, &x, u, rays);
            eye.l += eye.beta.carry(rho * e * FRAC_1_PI);
        }
        if c.rules.max_edges >= 3 {
            let h = match show {
                Show::Gather => self.gather(c, patches, &eye, &x, u, rays),
                _ => self.0.field.value(&self.0.vertices, i, place.local),
            };
            eye.l += eye.beta.carry(rho * spectrum(h) * FRAC_1_PI);
        }
        eye.l
    }
}

impl Look<'_> {
    /// H at x from one direction: the mean of cosine-distributed directions is R itself.
    fn gather(&self, c: &Context<'_>, patches: &Patches, eye: &PathState, x: &Interaction, u: &Sampler, rays: &mut u64) -> DVec3 {
        let n = if x.n.dot(x.wo) < 0.0 { -x.n } else { x.n };
        let w = Frame::from_normal(n).to_world(square_to_cosine_hemisphere(u.u2(eye.dim(slot::BSDF))));
        self.reflected(c.scene, patches, x.spawn(w), rays)
    }

    /// R where a ray ends, W/m².
    fn reflected(&self, scene: &Scene, patches: &Patches, ray: Ray, rays: &mut u64) -> DVec3 {
        let Some((ray, hit)) = first(scene, patches, ray, rays) else { return DVec3::ZERO };
        match patches.locate(&ray, &hit) {
            Some(Place { patch: Some(j), local, .. }) => self.0.field.value(&self.0.vertices, j, local),
            _ => DVec3::ZERO,
        }
    }

    /// The same for a solution that was made ready to be gathered from.
    pub fn leaving_towards(&self, scene: &Scene, ray: Ray) -> Spectrum {
        self.0.patches.as_ref().map_or(Spectrum::ZERO, |patches| spectrum(self.reflected(scene, patches, ray, &mut 0)))
    }
}

/// The first surface with substance along a ray.
fn first(scene: &Scene, patches: &Patches, mut ray: Ray, rays: &mut u64) -> Option<(Ray, Hit)> {
    /// Surfaces without substance that are passed at most.
    const PASSES: usize = 64;
    for _ in 0..PASSES {
        *rays += 1;
        let hit = scene.intersect(&ray)?;
        if !patches.objects[patches.object_of(&hit) as usize].is_clear {
            return Some((ray, hit));
        }
        ray = scene.interaction(&ray, &hit).spawn(ray.d);
    }
    None
}

/// ρ of a diffuse surface: π f, whatever the directions on the eye's side.
fn lambert(vertex: &Vertex) -> Spectrum {
    let ns = vertex.x.shading.n;
    vertex.eval(if vertex.wo.z < 0.0 { -ns } else { ns }).0 * PI
}

/// Irradiance by a point on a light.
fn direct(c: &Context<'_>, eye: &PathState, x: &Interaction, u: &Sampler, rays: &mut u64) -> Spectrum {
    let from = LightReference::reflecting(x);
    let light = c.scene.sample_light(&from, u.u1(eye.dim(slot::LIGHT)), u.u2(eye.dim(slot::LIGHT_POINT)), &eye.wl);
    let Some(light) = light else { return Spectrum::ZERO };
    let cos = from.n.dot(light.wi);
    let Some(ray) = light.shadow_ray(x).filter(|_| cos > 0.0) else { return Spectrum::ZERO };
    *rays += 1;
    match c.scene.transmittance(&ray, c.rules.passes(2), &eye.wl) {
        Some(through) => light.le * through.value * (cos / light.pdf.value()),
        None => Spectrum::ZERO,
    }
}

fn spectrum(x: DVec3) -> Spectrum {
    let [r, g, b] = x.as_vec3().to_array();
    Spectrum::rgb(r, g, b)
}
