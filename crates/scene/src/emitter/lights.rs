//! How to choose among the emitters.

use super::{LightReference, LightSample};
use crate::ids::EmitterId;
use crate::interaction::Interaction;
use crate::scene::Scene;
use etendue_numerics::{Spectrum, Vec2, Vec3, Wavelengths};

/// The light sampler.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    environments: Vec<EmitterId>,
}

impl Lights {
    /// The sampler of all emitters of `scene`, whose own `lights` are not looked at.
    pub fn new(_scene: &Scene) -> Self {
        Self::default()
    }

    /// The emitters that surround the scene.
    pub fn environments(&self) -> &[EmitterId] {
        &self.environments
    }

    /// Whether nothing emits.
    pub fn is_empty(&self) -> bool {
        true
    }

    /// Density at `from`, 1/sr, of choosing the emitting point `x`.
    pub fn pdf(&self, _scene: &Scene, _from: &LightReference, _x: &Interaction) -> f32 {
        0.0
    }

    /// Density at `from`, 1/sr, of choosing the direction `wi` of the surroundings.
    pub fn pdf_escaped(&self, _scene: &Scene, _from: &LightReference, _wi: Vec3) -> f32 {
        0.0
    }

    /// A point on a light.
    pub fn sample(&self, _: &Scene, _from: &LightReference, _u_light: f32, _u: Vec2, _wl: &Wavelengths) -> Option<LightSample> {
        let _ = Spectrum::ZERO;
        None
    }
}
