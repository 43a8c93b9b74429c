//! The textbook's recursion, word for word: slow, literal, and the judge of the optimised solvers [Dutré, Bekaert, Bala 2006, ch. 5].
//!
//! ```text
//! computePixel:     average of computeRadiance over `view_samples` rays through the pixel
//! computeRadiance = Le(x → Θ) + directIllumination(x, Θ) + indirectIllumination(x, Θ)
//!
//! directIllumination:   for each of `shadow_rays`: pick a light k (p_k), a point y on it (p(y|k), 1/m²)
//!                           Le(y → x) f(x, Θ ↔ Ψ) G(x, y) V(x, y) / (p_k p(y|k)),     G = cosθx cosθy / r²
//! indirectIllumination: survive with probability 1 - absorption; for each of `indirect_samples`: pick Ψ (p(Ψ), 1/sr)
//!                           f(x, Θ ↔ Ψ) cosθ L(RT(x, Ψ) → -Ψ) / (p(Ψ) (1 - absorption))
//! ```
//!
//! Taken word for word the recursion adds Le where direct light was already added. [`Recursion::Mended`] counts Le only at the
//! vertex that the eye sees (and behind mirrors and glass, and of surroundings, which the light samples here cannot find);
//! [`Recursion::AsTold`] keeps the slip, to show what it does: (1 + a)/(1 - a) instead of 1/(1 - a) in the furnace.

use crate::drivers::PixelSolver;
use crate::solver::Needs;
use crate::transport::{Context, PathState, Vertex, VertexSample};
use etendue_bsdf::Event;
use etendue_numerics::math::{FRAC_1_PI, TAU, safe_sqrt, sin_cos};
use etendue_numerics::sequence::{mix, unit};
use etendue_numerics::{Dim, Frame, Pdf, Ray, Sampler, Spectrum, Vec2, Vec3, Wavelengths};
use etendue_scene::shape::SurfacePoint;
use etendue_scene::{Geometry, Interaction, NO_INSTANCE, SurfaceId};

/// How directions of indirect light are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Directions {
    /// Uniformly over the hemisphere: the 2π/N estimator.
    Uniform,
    /// In proportion to the cosine.
    Cosine,
    /// As the material scatters.
    #[default]
    Bsdf,
}

/// Which recursion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Recursion {
    /// Le only where no light sample has counted it.
    #[default]
    Mended,
    /// Le again at every vertex.
    AsTold,
}

/// The literal estimator. Area lights are sampled by area; surfaces scatter into the hemisphere of `wo`.
#[derive(Clone, Copy, Debug)]
pub struct Oracle {
    /// Rays per pixel sample.
    pub view_samples: u32,
    /// Light points per vertex.
    pub shadow_rays: u32,
    /// Directions per vertex; a tree where above 1.
    pub indirect_samples: u32,
    /// Probability that a walk ends at a vertex.
    pub absorption: f32,
    /// How directions are drawn.
    pub directions: Directions,
    /// Which recursion.
    pub recursion: Recursion,
}

impl Default for Oracle {
    fn default() -> Self {
        Self {
            view_samples: 1,
            shadow_rays: 1,
            indirect_samples: 1,
            absorption: 0.3,
            directions: Directions::Bsdf,
            recursion: Recursion::Mended,
        }
    }
}

/// A node of the recursion's tree: the key of its random decisions.
#[derive(Clone, Copy)]
struct Branch(u64);

impl Branch {
    fn child(self, i: u32) -> Self {
        Self(mix(self.0 ^ mix(u64::from(i) + 1)))
    }

    fn u2(self, decision: u32) -> Vec2 {
        let bits = mix(self.0.wrapping_add(u64::from(decision) << 40));
        Vec2::new(unit(bits as u32), unit((bits >> 32) as u32))
    }
}

impl PixelSolver for Oracle {
    fn needs(&self) -> Needs {
        Needs { lights_that_can_be_hit: true, ..Needs::default() }
    }

    fn radiance(&self, c: &Context<'_>, eye: PathState, u: &Sampler, rays: &mut u64) -> Spectrum {
        let root = u.u2(Dim::at(1, 0));
        let root = Branch(mix(u64::from(root.x.to_bits()) << 32 | u64::from(root.y.to_bits())));
        let sum: Spectrum = (0..self.view_samples).map(|i| self.seen(c, &eye.ray, 1, true, root.child(i), rays)).sum();
        eye.beta.carry(sum) / self.view_samples as f32
    }
}

impl Oracle {
    /// L along `ray`, whose end is `edges` edges from the eye; `le_counts` says whether emission there is still uncounted.
    fn seen(&self, c: &Context<'_>, ray: &Ray, edges: u32, le_counts: bool, branch: Branch, rays: &mut u64) -> Spectrum {
        *rays += 1;
        let wl = Wavelengths::Rgb;
        let counts = c.rules.counts(edges);
        let Some(hit) = c.scene.intersect(ray) else {
            return if counts { c.scene.le_escaped(ray, &wl) } else { Spectrum::ZERO };
        };
        let x = c.scene.interaction(ray, &hit);
        let mut l = Spectrum::ZERO;
        if counts && (le_counts || self.recursion == Recursion::AsTold) {
            l += c.scene.le(&x, &wl);
        }
        if edges >= c.rules.max_edges && (c.rules.null_counts || !c.scene.has_transparent) {
            return l;
        }
        let vertex = Vertex::new(c.scene, x, &wl);
        l + self.direct_illumination(c, &vertex, edges, branch, rays) + self.indirect_illumination(c, &vertex, edges, branch, rays)
    }

    fn direct_illumination(&self, c: &Context<'_>, vertex: &Vertex, edges: u32, branch: Branch, rays: &mut u64) -> Spectrum {
        let lights: Vec<SurfaceId> =
            (0..c.scene.surfaces.len() as u32).map(SurfaceId).filter(|id| c.scene.surface(*id).emitter.is_some()).collect();
        if lights.is_empty() || !c.rules.counts(edges + 1) || !vertex.is_smooth() {
            return Spectrum::ZERO;
        }
        let mut sum = Spectrum::ZERO;
        for i in 0..self.shadow_rays {
            // A light, a face of it and a point on the face, each uniformly.
            let pick = |x: f32, n: usize| ((x * n as f32) as usize).min(n - 1);
            let which = branch.u2(3 * i);
            let light = lights[pick(which.x, lights.len())];
            let shape = &c.scene.surface(light).shape;
            let faces = shape.primitive_count();
            let y = shape.sample_area(pick(which.y, faces as usize) as u32, branch.u2(3 * i + 1));
            let pdf_a = y.pdf_a / (lights.len() as f32 * faces as f32);
            let y_seen = seen_from(&y, light, (vertex.x.p - y.p).normalize_or_zero());
            let Some(shadow) = vertex.x.spawn_between(&y_seen) else { continue };
            *rays += 1;
            if c.scene.accel.occluded(&shadow, &c.scene.surfaces) {
                continue;
            }
            let le = c.scene.le(&y_seen, &Wavelengths::Rgb);
            let r2 = (y.p - vertex.x.p).length_squared();
            let (f_cos, _) = vertex.eval(shadow.d);
            sum += f_cos * le * (y.n.dot(shadow.d).abs() / (r2 * pdf_a));
        }
        sum / self.shadow_rays as f32
    }

    fn indirect_illumination(&self, c: &Context<'_>, vertex: &Vertex, edges: u32, branch: Branch, rays: &mut u64) -> Spectrum {
        const SURVIVAL: u32 = 1 << 20;
        if branch.u2(SURVIVAL).x < self.absorption {
            return Spectrum::ZERO;
        }
        let mut sum = Spectrum::ZERO;
        for i in 0..self.indirect_samples {
            let child = branch.child(i);
            let Some(s) = self.direction(vertex, child) else { continue };
            let edges = edges + u32::from(c.rules.null_counts || !s.is_null);
            if edges <= c.rules.max_edges {
                sum += s.weight * self.seen(c, &vertex.x.spawn(s.wi), edges, s.pdf.is_delta(), child, rays);
            }
        }
        sum / (self.indirect_samples as f32 * (1.0 - self.absorption))
    }

    /// A direction with f cosθ / p.
    fn direction(&self, vertex: &Vertex, branch: Branch) -> Option<VertexSample> {
        const DIRECTION: u32 = 1 << 21;
        let u = branch.u2(DIRECTION);
        let (z, pdf_of): (f32, fn(f32) -> f32) = match self.directions {
            Directions::Bsdf => return vertex.sample(branch.u2(DIRECTION + 1).x, u),
            Directions::Uniform => (u.x, |_| 1.0 / TAU),
            Directions::Cosine => (u.x.sqrt(), |z| z * FRAC_1_PI),
        };
        let (sin, cos) = sin_cos(TAU * u.y);
        let r = safe_sqrt(1.0 - z * z);
        let wi = vertex.x.shading.to_world(Vec3::new(r * cos, r * sin, z.copysign(vertex.wo.z)));
        let pdf = pdf_of(z);
        (pdf > 0.0).then(|| VertexSample {
            wi,
            weight: vertex.eval(wi).0 / pdf,
            pdf: Pdf::SolidAngle(pdf),
            eta_scale: 1.0,
            is_null: false,
            event: Event::REFLECT | Event::DIFFUSE,
        })
    }
}

/// The light point as the surface point that it is, seen from along `wo`.
pub(crate) fn seen_from(y: &SurfacePoint, surface: SurfaceId, wo: Vec3) -> Interaction {
    Interaction {
        p: y.p,
        p_error: y.p_error,
        n: y.n,
        shading: Frame::from_normal(y.ns),
        uv: y.uv,
        dp_du: Vec3::ZERO,
        dp_dv: Vec3::ZERO,
        wo,
        t: 0.0,
        time: 0.0,
        surface,
        primitive: y.primitive,
        bary: y.bary,
        instance: NO_INSTANCE,
    }
}
