//! Le: where light comes from, and the questions asked of it.

mod lights;

pub use lights::Lights;

use crate::ids::EmitterId;
use crate::interaction::Interaction;
use crate::scene::Scene;
use etendue_numerics::{Pdf, Ray, Spectrum, Vec2, Vec3, Wavelengths};

/// Where light is asked for: a point, and what is known of the surface there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightReference {
    /// The point.
    pub p: Vec3,
    /// Unit shading normal, or zero where there is none (a point of a medium).
    pub n: Vec3,
    /// Whether light matters only on the side that `n` points to.
    pub one_sided: bool,
}

impl From<&Interaction> for LightReference {
    fn from(x: &Interaction) -> Self {
        Self { p: x.p, n: x.shading.n, one_sided: false }
    }
}

/// A point of a light as seen from a [`LightReference`]: contribution = f |cosθ| `le` / `pdf.value()`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit direction towards the light.
    pub wi: Vec3,
    /// The point on the light.
    pub p: Vec3,
    /// Its distance; infinite for the surroundings.
    pub distance: f32,
    /// Radiance, W/(m² sr); irradiance, W/m², for lights without area or of one direction.
    pub le: Spectrum,
    /// Density, with the probability of choosing the light.
    pub pdf: Pdf,
    /// The light.
    pub emitter: EmitterId,
}

impl LightSample {
    /// The ray that tests whether the light is seen from `x`.
    pub fn shadow_ray(&self, x: &Interaction) -> Option<Ray> {
        if self.distance.is_finite() { x.spawn_to(self.p) } else { Some(x.spawn(self.wi)) }
    }
}

/// A light.
#[derive(Clone, Debug)]
pub enum Emitter {}

impl Emitter {
    /// Le(x → wo), W/(m² sr), of a surface that emits.
    pub fn le(&self, _scene: &Scene, _x: &Interaction, _wl: &Wavelengths) -> Spectrum {
        Spectrum::ZERO
    }

    /// Le of the surroundings seen in the unit direction `d`.
    pub fn le_escaped(&self, _scene: &Scene, _d: Vec3, _wl: &Wavelengths) -> Spectrum {
        Spectrum::ZERO
    }
}

#[allow(dead_code)]
fn unused(_: Vec2) {}
