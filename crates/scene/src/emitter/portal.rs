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
//! From the light's side it is not known whether what a ray meets lies behind the portal: walks from the lights are refused.

use super::infinity::light_sample;
use super::{EmissionSample, Extent, Light, LightId, LightReference, LightSample, Model};
use crate::scene::Scene;
use etendue_numerics::math::{ONE_MINUS_EPSILON, PI};
use etendue_numerics::warp::SphericalRectangle;
use etendue_numerics::{Pdf, Spectrum, Vec2, Vec3, Wavelengths};

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

    fn sample_emission(&self, _: &Scene, _: LightId, _: Vec2, _: Vec2, _: &Wavelengths) -> Option<EmissionSample> {
        None
    }

    /// That of the surroundings, through the rectangle in place of the scene's disk.
    fn power_of(&self, scene: &Scene, primitive: u32) -> Spectrum {
        let (_, radius) = scene.bounds.bounding_sphere();
        let share = self.edges[0].cross(self.edges[1]).length() / (PI * radius * radius).max(f32::MIN_POSITIVE);
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
