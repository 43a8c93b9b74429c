//! A portal: surroundings that are seen through a rectangle only.
//!
//! ```text
//! Le(x, w) = Le of the surroundings along w, where the ray from x along w passes the rectangle from its back to its front; else 0
//! p_w = (p_w of the surroundings + 1/Ω)/2            Ω the solid angle of the rectangle from x; 0 beside it
//! ```
//!
//! Half of the light samples are those of the surroundings, which find the sun, and half are spread over the rectangle [Ureña, Fajardo, King 2013], which find a window
//! in a large room. The portal itself is no surface: nothing need stand there, and what stands before it casts its shadow.
//!
//! Light sets out from the rectangle itself, where nothing stands between it and the surroundings:
//!
//! ```text
//! p_A = 1/(A cosθ)    where a ray of direction d crosses a plane at right angles to it; A of the rectangle, θ between d and its normal
//! ```
//!
//! Beside other surroundings, which shine along the same rays as well, that density would depend on the place: walks from the lights are refused there.

use super::infinity::light_sample;
use super::{EmissionPdf, EmissionSample, Extent, Light, LightId, LightReference, LightSample, Model, PositionPdf};
use crate::scene::Scene;
use etendue_numerics::math::{ONE_MINUS_EPSILON, PI};
use etendue_numerics::warp::SphericalRectangle;
use etendue_numerics::{Pdf, Ray, Spectrum, Vec2, Vec3, Wavelengths};

/// Surroundings behind a rectangle.
#[derive(Clone, Debug)]
pub struct Portal {
    light: Box<Model>,
    corner: Vec3,
    edges: [Vec3; 2],
    /// Outwards, towards the surroundings.
    n: Vec3,
}

impl Portal {
    /// `light`, one of the surroundings, through the rectangle of these edges at right angles; their cross product points outwards. `None` without an area.
    pub fn new(light: Model, corner: Vec3, edges: [Vec3; 2]) -> Option<Self> {
        let n = edges[0].cross(edges[1]).try_normalize()?;
        Some(Self { light: Box::new(light), corner, edges, n })
    }

    /// Whether the ray from `p` along `d` leaves through the rectangle.
    fn lets_through(&self, p: Vec3, d: Vec3) -> bool {
        let (along, away) = (self.n.dot(d), self.n.dot(self.corner - p));
        if along <= 0.0 || away <= 0.0 {
            return false;
        }
        let q = p + d * (away / along) - self.corner;
        self.edges.iter().all(|e| (0.0..=e.length_squared()).contains(&q.dot(*e)))
    }

    /// A, m².
    fn area(&self) -> f32 {
        self.edges[0].cross(self.edges[1]).length()
    }

    /// The rectangle as seen from `p`; none from outside.
    fn seen(&self, p: Vec3) -> Option<SphericalRectangle> {
        if self.n.dot(self.corner - p) <= 0.0 {
            return None;
        }
        SphericalRectangle::new(self.corner - p, self.edges[0], self.edges[1])
    }
}

impl Light for Portal {
    fn le_escaped(&self, p: Vec3, d: Vec3, wl: &Wavelengths) -> Spectrum {
        if self.lets_through(p, d) { self.light.le_escaped(p, d, wl) } else { Spectrum::ZERO }
    }

    fn pdf_escaped(&self, from: &LightReference, wi: Vec3) -> f32 {
        match self.seen(from.p).filter(|_| self.lets_through(from.p, wi)) {
            Some(seen) => 0.5 * (self.light.pdf_escaped(from, wi) + seen.pdf()),
            None => 0.0,
        }
    }

    fn sample(&self, scene: &Scene, from: &LightReference, id: LightId, u: Vec2, wl: &Wavelengths) -> Option<LightSample> {
        let seen = self.seen(from.p)?;
        let wi = if u.x < 0.5 {
            self.light.sample(scene, from, id, Vec2::new((2.0 * u.x).min(ONE_MINUS_EPSILON), u.y), wl)?.wi
        } else {
            seen.sample(Vec2::new((2.0 * u.x - 1.0).clamp(0.0, ONE_MINUS_EPSILON), u.y)).normalize()
        };
        if !self.lets_through(from.p, wi) {
            return None;
        }
        let pdf_w = 0.5 * (self.light.pdf_escaped(from, wi) + seen.pdf());
        Some(light_sample(scene, from, id, wi, Pdf::SolidAngle(pdf_w), self.light.le_escaped(from.p, wi, wl)))
    }

    fn pdf_emission_escaped(&self, scene: &Scene, wi: Vec3) -> EmissionPdf {
        let cos = self.n.dot(wi);
        if cos <= 0.0 {
            return EmissionPdf::ZERO;
        }
        let EmissionPdf { direction, .. } = self.light.pdf_emission_escaped(scene, wi);
        EmissionPdf { position: PositionPdf::Area(1.0 / (self.area() * cos)), direction }
    }

    fn sample_emission(&self, scene: &Scene, id: LightId, u: Vec2, u_direction: Vec2, wl: &Wavelengths) -> Option<EmissionSample> {
        /// How far behind the rectangle a ray begins, in parts of what its place is rounded to or of its edges.
        const CLEAR: f32 = 1e-5;
        let d = self.light.sample_emission(scene, id, u, u_direction, wl)?.ray.d;
        let pdf = self.pdf_emission_escaped(scene, -d);
        let q = self.corner + self.edges[0] * u.x + self.edges[1] * u.y;
        let size = self.edges.iter().fold(q, |a, e| a.abs().max(e.abs())).max_element();
        let o = q + d * (CLEAR * size);
        let lit = pdf.position.value() > 0.0 && pdf.direction.value() > 0.0 && self.lets_through(o, -d);
        (lit && !scene.accel.occluded(&Ray::new(o, -d), &scene.surfaces)).then(|| EmissionSample {
            ray: Ray::new(o, d),
            n: d,
            pdf,
            weight: self.light.le_escaped(o, -d, wl) / (pdf.position.value() * pdf.direction.value()),
            emitter: id.emitter,
            primitive: id.primitive,
        })
    }

    /// That of the surroundings, through the rectangle in place of the scene's disk.
    fn power_of(&self, scene: &Scene, primitive: u32) -> Spectrum {
        let (_, radius) = scene.bounds.bounding_sphere();
        let share = self.area() / (PI * radius * radius).max(f32::MIN_POSITIVE);
        self.light.power_of(scene, primitive) * share.min(1.0)
    }

    fn extent(&self, scene: &Scene, primitive: u32) -> Extent {
        match self.light.extent(scene, primitive) {
            // Walks seldom find a window by themselves.
            Extent::Distant { irradiance, from, .. } => Extent::Distant { irradiance, excess: irradiance, from },
            other => other,
        }
    }
}
