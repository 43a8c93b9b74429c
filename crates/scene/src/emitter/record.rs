//! What is handed to lights and what they answer.

use crate::ids::EmitterId;
use crate::interaction::Interaction;
use etendue_numerics::{Pdf, Ray, Spectrum, Vec2, Vec3, Wavelengths};

/// A part of an emitter that the light sampler may choose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LightId {
    /// The emitter.
    pub emitter: EmitterId,
    /// The triangle of an emitting mesh; 0 for emitters of one piece.
    pub primitive: u32,
}

/// Where light is asked for: a point, and what is known of the surface there. The same reference must be given when a light is
/// sampled and when the density of that sample is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightReference {
    /// The point.
    pub p: Vec3,
    /// Unit shading normal, or zero where there is none (in a medium).
    pub n: Vec3,
    /// Whether only light on the side of `n` matters, because nothing is transmitted.
    pub one_sided: bool,
    /// Whether a walk that goes on from here counts the light that it meets, too: then light samples may leave to it what it finds best.
    pub shared: bool,
}

impl LightReference {
    /// A point that light reaches from all sides alike.
    pub fn point(p: Vec3) -> Self {
        Self { p, n: Vec3::ZERO, one_sided: false, shared: false }
    }

    /// Whether light from the direction `wi` may be scattered there.
    #[inline]
    pub fn faces(&self, wi: Vec3) -> bool {
        !self.one_sided || self.n == Vec3::ZERO || self.n.dot(wi) > 0.0
    }

    /// A surface that scatters to the side of `x.wo` only: lights behind it are not chosen.
    #[inline]
    pub fn reflecting(x: &Interaction) -> Self {
        let ns = x.shading.n;
        Self { p: x.p, n: if ns.dot(x.wo) < 0.0 { -ns } else { ns }, one_sided: true, shared: false }
    }
}

impl From<&Interaction> for LightReference {
    /// A surface that may scatter to both sides.
    #[inline]
    fn from(x: &Interaction) -> Self {
        Self { p: x.p, n: x.shading.n, one_sided: false, shared: false }
    }
}

/// A light sample asked for: where, which light and which point on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightQuery {
    /// Where.
    pub from: LightReference,
    /// Which light.
    pub u_light: f32,
    /// Where on it.
    pub u: Vec2,
}

/// A ray that meets nothing, where the surroundings are asked what it sees.
#[derive(Clone, Copy, Debug)]
pub struct Escape<'a> {
    /// The ray.
    pub ray: &'a Ray,
    /// For whom light samples might have found the same; nobody asks for their density where there is none.
    pub from: Option<&'a LightReference>,
    /// The wavelengths of the walk.
    pub wl: &'a Wavelengths,
}

/// What such a ray sees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Le, W/(m² sr).
    pub le: Spectrum,
    /// The density of light samples for its direction, 1/sr; 0 where nobody asked.
    pub pdf: f32,
}

/// Light that arrives at a [`LightReference`]: contribution = f |cosθ| `le` / `pdf.value()`, where nothing stands between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit direction towards the light.
    pub wi: Vec3,
    /// The point on the light, clear of its surface on the side of the reference; far outside the scene for the surroundings.
    pub p: Vec3,
    /// Its distance, m; infinite for the surroundings.
    pub distance: f32,
    /// Radiance, W/(m² sr); for a discrete direction the irradiance on a surface that faces it, W/m²: I/r² of a point.
    pub le: Spectrum,
    /// Density of `wi`, 1/sr, or the probability of the discrete direction; [`crate::Lights`] includes the choice of the light. `Delta` where no ray that
    /// is scattered could find the light: of a surface that shines unseen the number is the density nevertheless.
    pub pdf: Pdf,
    /// The light.
    pub emitter: EmitterId,
    /// Its primitive, as in [`LightId`].
    pub primitive: u32,
    /// The light's unit normal at the point; zero of points and of the surroundings.
    pub n: Vec3,
}

impl LightSample {
    /// The ray from `x` that must arrive unhindered.
    #[inline]
    pub fn shadow_ray(&self, x: &Interaction) -> Option<Ray> {
        if self.distance.is_finite() { x.spawn_to(self.p) } else { Some(x.spawn(self.wi)) }
    }
}

/// The density of a sampled place: per area, or a probability where there is only one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PositionPdf {
    /// A density with respect to area, 1/m².
    Area(f32),
    /// The probability of a discrete place, unitless.
    Delta(f32),
}

impl PositionPdf {
    /// The number without its measure.
    #[inline]
    pub fn value(self) -> f32 {
        match self {
            Self::Area(p) | Self::Delta(p) => p,
        }
    }

    /// The density per area, 1/m²; zero for a discrete place.
    #[inline]
    pub fn area(self) -> f32 {
        match self {
            Self::Area(p) => p,
            Self::Delta(_) => 0.0,
        }
    }

    /// Whether there is only one place.
    #[inline]
    pub fn is_delta(self) -> bool {
        matches!(self, Self::Delta(_))
    }

    /// The same times a probability.
    #[inline]
    pub fn times(self, probability: f32) -> Self {
        match self {
            Self::Area(p) => Self::Area(p * probability),
            Self::Delta(p) => Self::Delta(p * probability),
        }
    }
}

/// The densities of a ray that sets out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissionPdf {
    /// Of where: p_A, with the choice of the light where [`crate::Lights`] says so.
    pub position: PositionPdf,
    /// Of whereto, given where: p_w.
    pub direction: Pdf,
}

impl EmissionPdf {
    /// Cannot be drawn.
    pub const ZERO: Self = Self { position: PositionPdf::Area(0.0), direction: Pdf::SolidAngle(0.0) };
}

/// Light that sets out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissionSample {
    /// The ray, clear of the light's surface.
    pub ray: Ray,
    /// The light's unit normal where the ray starts; zero for points, the direction of travel for light from infinity.
    pub n: Vec3,
    /// The densities.
    pub pdf: EmissionPdf,
    /// Flux that the ray stands for, W: Le |cosθ| / (p_A p_w), its discrete parts left out.
    pub weight: Spectrum,
    /// The light.
    pub emitter: EmitterId,
    /// Its primitive, as in [`LightId`].
    pub primitive: u32,
}
