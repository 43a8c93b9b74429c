//! The textbook's particle shooting, word for word: slow, literal, and the judge of the light tracers [Dutré, Bekaert, Bala 2006, §6.2].
//!
//! ```text
//! computeImage:    for each particle: pick a light k (p_k), a point y on it (p(y|k), 1/m²) and a direction Θ (p(Θ), 1/sr)
//!                      contributeToPixels(y): Le(y → lens) G(y, lens) V We / (p_k p(y|k))
//!                      shootParticle(RT(y, Θ), Θ, Le(y → Θ) cosθy / (p_k p(y|k) p(Θ)))
//! shootParticle(x, Θ, Φ):
//!                      contributeToPixels(x): Φ f(x, -Θ ↔ Ψ) G(x, lens) V We
//!                      survive with probability 1 - absorption; pick Ψ (p(Ψ), 1/sr)
//!                      shootParticle(RT(x, Ψ), Ψ, Φ f(x, -Θ ↔ Ψ) cosθ / (p(Ψ) (1 - absorption)))
//! ```
//!
//! Directions are drawn uniformly over the hemisphere, lights, faces and points uniformly. For area lights and surfaces whose shading and geometric
//! normals are one, which scatter into the hemisphere of the light; nothing is shared with the optimised solvers but f, We and rays.

use crate::drivers::ParticleSolver;
use crate::solver::Needs;
use crate::transport::{LightContext, Tally};
use etendue_bsdf::Scatter;
use etendue_numerics::math::{TAU, safe_sqrt, sin_cos};
use etendue_numerics::{Dim, Frame, Ray, Sampler, Spectrum, Vec2, Vec3, Wavelengths};
use etendue_scene::interaction::SHADOW_EPSILON;
use etendue_scene::{Geometry, Interaction, Scene, SurfaceId};

/// The literal estimator.
#[derive(Clone, Copy, Debug)]
pub struct LightOracle {
    /// Probability that a particle ends at a surface.
    pub absorption: f32,
}

/// A uniform direction of the hemisphere around `n`; its density is 1/2π.
fn hemisphere(n: Vec3, u: Vec2) -> Vec3 {
    let (sin, cos) = sin_cos(TAU * u.y);
    let r = safe_sqrt(1.0 - u.x * u.x);
    Frame::from_normal(n).to_world(Vec3::new(r * cos, r * sin, u.x))
}

impl ParticleSolver for LightOracle {
    fn needs(&self) -> Needs {
        Needs { lights_that_can_be_hit: true, no_mirrors_in_view: true, ..Needs::default() }
    }

    fn shoot(&self, c: &LightContext<'_>, u: &Sampler, tally: &mut Tally) {
        let scene = c.path.scene;
        let lights: Vec<SurfaceId> =
            (0..scene.surfaces.len() as u32).map(SurfaceId).filter(|id| scene.surface(*id).emitter.is_some()).collect();
        if lights.is_empty() {
            return;
        }

        // A light, a face of it and a point on the face, each uniformly.
        let pick = |x: f32, n: usize| ((x * n as f32) as usize).min(n - 1);
        let which = u.u2(Dim::at(0, 0));
        let light = lights[pick(which.x, lights.len())];
        let shape = &scene.surface(light).shape;
        let faces = shape.primitive_count() as usize;
        let y = shape.sample_area(pick(which.y, faces) as u32, u.u2(Dim::at(0, 1)));
        let pdf_y = y.pdf_a / (lights.len() * faces) as f32;

        let theta = hemisphere(y.n, u.u2(Dim::at(0, 2)));
        let out = Ray::new(etendue_numerics::ray::offset_origin(y.p, y.p_error, y.n, theta), theta);
        let le = |w: Vec3| {
            let seen = crate::oracle::seen_from(&y, light, w);
            scene.le(&seen, &Wavelengths::Rgb)
        };

        // What the eye sees of the light itself.
        if c.path.rules.counts(1)
            && let Some(lens) = c.view.sensor.sample_direction(out.o, u.u2(Dim::at(0, 3)))
        {
            let free = Ray::new(out.o, lens.wi).until((lens.p - out.o).length() * (1.0 - SHADOW_EPSILON));
            let cos = y.n.dot(lens.wi);
            if cos > 0.0 && !scene.accel.occluded(&free, &scene.surfaces) {
                tally.splat(lens.pixel, le(lens.wi) * (cos * lens.we / (lens.pdf.value() * pdf_y)));
            }
        }
        let flux = le(theta) * (y.n.dot(theta) * TAU / pdf_y);
        tally.emitted(flux);
        self.shoot_particle(c, &out, flux, 1, u, tally);
    }
}

impl LightOracle {
    /// A particle of `flux` along `ray`, whose end is `edges` edges from the light.
    fn shoot_particle(&self, c: &LightContext<'_>, ray: &Ray, flux: Spectrum, edges: u32, u: &Sampler, tally: &mut Tally) {
        let scene = c.path.scene;
        if edges >= c.path.rules.max_edges {
            tally.cut(flux);
            return;
        }
        let Some(hit) = scene.intersect(ray) else {
            tally.escaped(flux);
            return;
        };
        let x = scene.interaction(ray, &hit);
        let n = if x.n.dot(x.wo) < 0.0 { -x.n } else { x.n };

        if c.path.rules.counts(edges + 1)
            && let Some(lens) = c.view.sensor.sample_direction(x.p, u.u2(Dim::at(edges, 3)))
            && let Some(free) = lens.shadow_ray(&x)
            && n.dot(lens.wi) > 0.0
            && !scene.accel.occluded(&free, &scene.surfaces)
        {
            let g_we = n.dot(lens.wi) * lens.we / lens.pdf.value();
            tally.splat(lens.pixel, flux * f(scene, &x, lens.wi) * g_we);
        }

        if u.u1(Dim::at(edges, 0)) < self.absorption {
            tally.absorbed(flux);
            return;
        }
        let psi = hemisphere(n, u.u2(Dim::at(edges, 1)));
        let left = flux * f(scene, &x, psi) * (n.dot(psi) * TAU / (1.0 - self.absorption));
        tally.absorbed(flux - left);
        if !left.is_zero() {
            self.shoot_particle(c, &x.spawn(psi), left, edges + 1, u, tally);
        }
    }
}

/// f(x, -Θ ↔ Ψ).
fn f(scene: &Scene, x: &Interaction, psi: Vec3) -> Spectrum {
    scene.bsdf(x, &Wavelengths::Rgb).eval(x.shading.to_local(psi), x.wo_local())
}

crate::solve_by_particles!(LightOracle);
