//! `spot`: a point that radiates into a cone.
//!
//! ```text
//! I(θ) = I t(u, v) · 1                     θ ≤ θb
//!                  · (θc - θ)/(θc - θb)    θb < θ < θc
//!                  · 0                     θ ≥ θc
//! u = 1/2 + x / (2 z tanθc),  v = 1/2 + y / (2 z tanθc)     (x, y, z) the direction in the light's coordinates
//! Φ = 2π I (1 - (sinθc - sinθb)/(θc - θb))     where t = 1
//! ```
//!
//! With the smooth falloff, between θb and θc: x² (3 - 2x), x = (cosθ - cosθc)/(cosθb - cosθc); then Φ = 2π I (1 - (cosθb + cosθc)/2).
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `intensity` | I on the axis, W/sr | 1 |
//! | `cutoff_angle` | θc, degrees | 20 |
//! | `beam_width` | θb, degrees | 3/4 of the cutoff angle |
//! | `falloff` | `linear` in the angle, or `smooth` | `linear` |
//! | `texture` | t, unitless, over the cone | 1 |
//! | `to_world` | from the light's coordinates, which it looks along +z of; scales are taken out | identity |

use super::point::towards;
use super::{EmissionPdf, EmissionSample, Extent, Light, LightBounds, LightId, LightReference, LightSample, PositionPdf, scalar};
use crate::scene::Scene;
use crate::texture::{Color, ColorSlot};
use etendue_numerics::math::{TAU, safe_acos};
use etendue_numerics::warp::{cone_pdf, square_to_cone};
use etendue_numerics::{Frame, Pdf, Ray, Spectrum, Vec2, Vec3, Wavelengths};

/// A point light with a cone.
#[derive(Clone, Debug)]
pub struct Spot {
    p: Vec3,
    /// The light's axes, `n` the middle of the cone. A left-handed map keeps its handedness here: the triple need not be right-handed.
    axes: Frame,
    intensity: Color,
    texture: Option<ColorSlot>,
    cutoff: f32,
    beam: f32,
    smooth: bool,
}

impl Spot {
    /// A spot at `p` with the orthonormal `axes` (x, y, and n where it points), angles in radians, 0 < cutoff ≤ π.
    pub fn new(p: Vec3, axes: Frame, intensity: Color, cutoff: f32, beam: f32, texture: Option<ColorSlot>) -> Self {
        Self { p, axes, intensity, texture, cutoff, beam: beam.clamp(0.0, cutoff), smooth: false }
    }

    /// The same with the smooth falloff.
    #[must_use]
    pub fn smooth(self) -> Self {
        Self { smooth: true, ..self }
    }

    /// I(θ), W/sr, into the unit direction `w`.
    fn intensity(&self, scene: &Scene, w: Vec3, wl: &Wavelengths) -> Spectrum {
        let local = self.axes.to_local(w);
        let falloff = self.falloff(local.z);
        if falloff == 0.0 {
            return Spectrum::ZERO;
        }
        let picture = self.texture.as_ref().map_or(Spectrum::ONE, |t| {
            let uv = local.truncate() / (local.z * self.cutoff.tan());
            t.eval(&super::projector::on_no_surface(scene, 0.5 * (uv + Vec2::ONE)), wl)
        });
        self.intensity.at(wl) * picture * falloff
    }

    fn falloff(&self, cos: f32) -> f32 {
        let theta = safe_acos(cos);
        if theta <= self.beam {
            1.0
        } else if theta < self.cutoff && self.smooth {
            let x = (cos - self.cutoff.cos()) / (self.beam.cos() - self.cutoff.cos());
            (x * x * (3.0 - 2.0 * x)).clamp(0.0, 1.0)
        } else if theta < self.cutoff {
            (self.cutoff - theta) / (self.cutoff - self.beam)
        } else {
            0.0
        }
    }

    /// 1 - cosθc, without cancellation for narrow cones.
    fn versine(&self) -> f32 {
        let half = (0.5 * self.cutoff).sin();
        2.0 * half * half
    }

    fn mean_intensity(&self, scene: &Scene) -> Spectrum {
        self.intensity.mean(scene) * self.texture.as_ref().map_or(Spectrum::ONE, |t| t.mean(scene))
    }
}

impl Light for Spot {
    fn sample(&self, scene: &Scene, from: &LightReference, id: LightId, _: Vec2, wl: &Wavelengths) -> Option<LightSample> {
        let (wi, distance, inverse_r2) = towards(from.p, self.p)?;
        let le = self.intensity(scene, -wi, wl) * inverse_r2;
        let sample =
            LightSample { wi, p: self.p, distance, le, pdf: Pdf::Delta(1.0), emitter: id.emitter, primitive: 0, n: Vec3::ZERO };
        (!le.is_zero()).then_some(sample)
    }

    fn pdf_emission_discrete(&self, _: &Scene, w: Vec3) -> EmissionPdf {
        let inside = 1.0 - self.axes.to_local(w).z <= self.versine();
        let pdf_w = if inside { cone_pdf(self.versine()) } else { 0.0 };
        EmissionPdf { position: PositionPdf::Delta(1.0), direction: Pdf::SolidAngle(pdf_w) }
    }

    fn sample_emission(&self, scene: &Scene, id: LightId, _: Vec2, u: Vec2, wl: &Wavelengths) -> Option<EmissionSample> {
        let d = self.axes.to_world(square_to_cone(u, self.versine())).normalize();
        let pdf_w = cone_pdf(self.versine());
        Some(EmissionSample {
            ray: Ray::new(self.p, d),
            n: Vec3::ZERO,
            pdf: EmissionPdf { position: PositionPdf::Delta(1.0), direction: Pdf::SolidAngle(pdf_w) },
            weight: self.intensity(scene, d, wl) / pdf_w,
            emitter: id.emitter,
            primitive: id.primitive,
        })
    }

    /// Of a textured spot by the texture's mean: not exact, since the texture does not spread evenly over angles.
    fn power_of(&self, scene: &Scene, _: u32) -> Spectrum {
        let (c, b) = (f64::from(self.cutoff), f64::from(self.beam));
        if self.smooth {
            return self.mean_intensity(scene) * (TAU * (1.0 - 0.5 * (c.cos() + b.cos())) as f32);
        }
        let slope = if c - b > 1e-6 { (c.sin() - b.sin()) / (c - b) } else { c.cos() };
        self.mean_intensity(scene) * (TAU * (1.0 - slope) as f32)
    }

    fn extent(&self, scene: &Scene, _: u32) -> Extent {
        let everywhere = LightBounds::of_point(self.p, scalar(self.mean_intensity(scene)));
        // Wider than a half space: as good as a point.
        let cos_e = self.cutoff.cos();
        Extent::Bounded(if cos_e > 0.0 { LightBounds { axis: self.axes.n, cos_o: 1.0, cos_e, ..everywhere } } else { everywhere })
    }
}
