//! `projector`: a picture thrown from a point, the reverse of a pinhole camera.
//!
//! ```text
//! (X, Y, 1) the direction in the projector's coordinates, cosθ = 1/|(X, Y, 1)|
//! u = 1/2 - X / (2 tx),   v = 1/2 - Y / (2 ty),   tx = tan(fov_x / 2),   ty = tx · height/width
//! I = π s t(u, v) / cos³θ         within the picture
//! Φ = π s · 4 tx ty · mean(t)
//! ```
//!
//! With `falloff` `none` I = s t(u, v) within the picture, and Φ = s ∫ t dw.
//!
//! 1/cos³θ is what makes a constant picture fall evenly on a plane before the projector, where it gives the irradiance π s t / z².
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `irradiance` | the picture t; its width and height set the shape of the beam | 1 |
//! | `scale` | s | 1 |
//! | `falloff` | `even`: a constant picture falls evenly on a plane; `none`: it shines evenly into all directions | `even` |
//! | `power` | s is scaled so that Φ is this, by luminance | none |
//! | `fov`, `fov_axis`, or `focal_length` | field of view, as of a `perspective` sensor | `50mm` |
//! | `to_world` | from the projector's coordinates, which it looks along +z of; scales are taken out | identity |

use super::point::towards;
use super::{EmissionPdf, EmissionSample, Extent, Light, LightBounds, LightId, LightReference, LightSample, PositionPdf, scalar};
use crate::ids::SurfaceId;
use crate::scene::Scene;
use crate::texture::{ColorSlot, TextureContext};
use etendue_numerics::math::PI;
use etendue_numerics::{Frame, Pdf, Ray, Spectrum, Vec2, Vec3, Wavelengths};

/// A picture thrown from a point.
#[derive(Clone, Debug)]
pub struct Projector {
    p: Vec3,
    axes: Frame,
    /// (tx, ty): half the picture's size at distance 1.
    tan_half: Vec2,
    irradiance: ColorSlot,
    scale: f32,
    /// I does not grow by 1/cos³θ.
    plain: bool,
}

/// A texture's place where there is no surface.
pub(super) fn on_no_surface(scene: &Scene, uv: Vec2) -> TextureContext<'_> {
    TextureContext { scene, uv, surface: SurfaceId(u32::MAX), primitive: 0, bary: Vec2::ZERO, p: Vec3::ZERO, n: Vec3::ZERO }
}

impl Projector {
    /// A projector at `p` with the orthonormal `axes` (x, y, and n where it points); `tan_half` = (tx, ty) > 0.
    pub fn new(p: Vec3, axes: Frame, tan_half: Vec2, irradiance: ColorSlot, scale: f32) -> Self {
        Self { p, axes, tan_half, irradiance, scale, plain: false }
    }

    /// The same without the factor π/cos³θ.
    #[must_use]
    pub fn plain(self) -> Self {
        Self { plain: true, ..self }
    }

    /// What the picture is multiplied by into a direction at angle θ.
    fn factor(&self, cos: f32) -> f32 {
        if self.plain { self.scale } else { PI * self.scale / (cos * cos * cos) }
    }

    /// I, W/sr, into the unit direction `w`.
    fn intensity(&self, scene: &Scene, w: Vec3, wl: &Wavelengths) -> Spectrum {
        let local = self.axes.to_local(w);
        let uv = 0.5 * (Vec2::ONE - local.truncate() / (local.z * self.tan_half));
        if local.z <= 0.0 || !(uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all()) {
            return Spectrum::ZERO;
        }
        self.irradiance.eval(&on_no_surface(scene, uv), wl) * self.factor(local.z)
    }

    /// ∫ t dw of a plain one, by the middles of a grid's cells.
    fn flux(&self, scene: &Scene) -> Spectrum {
        const SIDE: usize = 128;
        let cell = self.image_area() / (SIDE * SIDE) as f32;
        (0..SIDE * SIDE)
            .map(|i| {
                let uv = Vec2::new((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5) / SIDE as f32;
                let cos = 1.0 / ((Vec2::ONE - 2.0 * uv) * self.tan_half).extend(1.0).length();
                self.irradiance.eval(&on_no_surface(scene, uv), &Wavelengths::Rgb) * (cell * cos * cos * cos)
            })
            .sum()
    }

    /// The picture's area at distance 1.
    fn image_area(&self) -> f32 {
        4.0 * self.tan_half.x * self.tan_half.y
    }
}

impl Light for Projector {
    fn sample(&self, scene: &Scene, from: &LightReference, id: LightId, _: Vec2, wl: &Wavelengths) -> Option<LightSample> {
        let (wi, distance, inverse_r2) = towards(from.p, self.p)?;
        let le = self.intensity(scene, -wi, wl) * inverse_r2;
        let sample =
            LightSample { wi, p: self.p, distance, le, pdf: Pdf::Delta(1.0), emitter: id.emitter, primitive: 0, n: Vec3::ZERO };
        (!le.is_zero()).then_some(sample)
    }

    fn pdf_emission_discrete(&self, _: &Scene, w: Vec3) -> EmissionPdf {
        let local = self.axes.to_local(w);
        let place = local.truncate() / (local.z * self.tan_half);
        let inside = local.z > 0.0 && place.abs().cmple(Vec2::ONE).all();
        let pdf_w = if inside { 1.0 / (self.image_area() * local.z * local.z * local.z) } else { 0.0 };
        EmissionPdf { position: PositionPdf::Delta(1.0), direction: Pdf::SolidAngle(pdf_w) }
    }

    fn sample_emission(&self, scene: &Scene, id: LightId, _: Vec2, u: Vec2, wl: &Wavelengths) -> Option<EmissionSample> {
        // Uniform over the picture: p_w = 1 / (area cos³θ), which leaves the picture alone as weight.
        let local = ((Vec2::ONE - 2.0 * u) * self.tan_half).extend(1.0).normalize();
        let pdf_w = 1.0 / (self.image_area() * local.z * local.z * local.z);
        let picture = self.irradiance.eval(&on_no_surface(scene, u), wl);
        Some(EmissionSample {
            ray: Ray::new(self.p, self.axes.to_world(local)),
            n: Vec3::ZERO,
            pdf: EmissionPdf { position: PositionPdf::Delta(1.0), direction: Pdf::SolidAngle(pdf_w) },
            weight: picture * (self.factor(local.z) / pdf_w),
            emitter: id.emitter,
            primitive: id.primitive,
        })
    }

    fn power_of(&self, scene: &Scene, _: u32) -> Spectrum {
        if self.plain {
            return self.flux(scene) * self.scale;
        }
        self.irradiance.mean(scene) * (PI * self.scale * self.image_area())
    }

    fn extent(&self, scene: &Scene, _: u32) -> Extent {
        // Brightest towards the corners, by 1/cos³θ.
        let cos = 1.0 / self.tan_half.extend(1.0).length();
        let brightest = self.factor(cos) * scalar(self.irradiance.mean(scene));
        // Rounding must not cut the corners off.
        let cos_e = cos * (1.0 - 1e-5) - 1e-6;
        Extent::Bounded(LightBounds { axis: self.axes.n, cos_o: 1.0, cos_e, ..LightBounds::of_point(self.p, brightest) })
    }
}
