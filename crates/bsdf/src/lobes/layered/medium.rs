//! What the layer holds: particles that absorb and scatter.

use etendue_numerics::math::{PI, TAU, exp, safe_sqrt, sin_cos, sqr};
use etendue_numerics::{Frame, Spectrum, Vec2, Vec3};

/// A slab of particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Medium {
    /// Optical thickness.
    pub(super) thickness: f32,
    /// The share of light that a particle scatters.
    pub(super) albedo: Spectrum,
    /// Henyey and Greenstein's g.
    pub(super) g: f32,
}

impl Medium {
    /// What is left after a height `dz` along `d`.
    pub(super) fn through(&self, dz: f32, d: Vec3) -> f32 {
        exp(-(dz / d.z).abs())
    }

    /// Henyey and Greenstein's phase function for light that goes on along `next`, 1/sr [Henyey, Greenstein 1941].
    pub(super) fn phase(&self, d: Vec3, next: Vec3) -> f32 {
        let g = self.g;
        let denominator = (1.0 + g * g - 2.0 * g * d.dot(next)).max(1e-6);
        (1.0 - g * g) / (4.0 * PI * denominator * denominator.sqrt())
    }

    /// A direction drawn by the phase function.
    pub(super) fn scatter(&self, d: Vec3, u: Vec2) -> Vec3 {
        let g = self.g;
        let cos = if g.abs() < 1e-3 {
            1.0 - 2.0 * u.x
        } else {
            (1.0 + g * g - sqr((1.0 - g * g) / (1.0 + g - 2.0 * g * u.x))) / (2.0 * g)
        };
        let cos = cos.clamp(-1.0, 1.0);
        let (sin_phi, cos_phi) = sin_cos(TAU * u.y);
        let sin = safe_sqrt(1.0 - cos * cos);
        Frame::from_normal(d).to_world(Vec3::new(sin * cos_phi, sin * sin_phi, cos)).normalize()
    }
}
