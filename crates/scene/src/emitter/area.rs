//! `area`: the front of a surface, equally bright from all directions.
//!
//! ```text
//! Le(x, w) = L(x)  where n·w > 0,  0 behind,    Φ = π ∫ L dA
//! p_w = the shape's own density seen from a point,    p_A = 1/A and p_w = cosθ/π of light that sets out
//! ```
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `radiance` | L, W/(m² sr); constant or textured | 1 |

use super::{EmissionPdf, EmissionSample, Extent, Light, LightBounds, LightId, LightReference, LightSample, PositionPdf, scalar};
use crate::ids::SurfaceId;
use crate::interaction::Interaction;
use crate::scene::Scene;
use crate::shape::{Geometry, Shape, SurfacePoint};
use crate::texture::{ColorSlot, TextureContext};
use etendue_numerics::math::{FRAC_1_PI, PI};
use etendue_numerics::ray::offset_origin;
use etendue_numerics::sequence::unit;
use etendue_numerics::warp::{cosine_hemisphere_pdf, square_to_cosine_hemisphere};
use etendue_numerics::{Frame, Pdf, Ray, Spectrum, Vec2, Wavelengths};

/// An emitting surface.
#[derive(Clone, Debug)]
pub struct Area {
    /// The surface.
    pub surface: SurfaceId,
    /// L, W/(m² sr).
    pub radiance: ColorSlot,
}

/// A place on the surface, for its texture.
#[inline]
pub(super) fn texture_context<'a>(scene: &'a Scene, surface: SurfaceId, at: &SurfacePoint) -> TextureContext<'a> {
    TextureContext { scene, uv: at.uv, surface, primitive: at.primitive, bary: at.bary }
}

/// The mean of a radiance over a primitive: of a texture by its values at a few points, more where there are few primitives.
pub(super) fn mean_radiance(scene: &Scene, surface: SurfaceId, radiance: &ColorSlot, primitive: u32) -> Spectrum {
    let ColorSlot::Texture(_) = radiance else { return radiance.mean(scene) };
    let shape = &scene.surface(surface).shape;
    let points = ((1 << 18) / shape.primitive_count().max(1)).clamp(4, 1 << 12);
    let mut sum = [0f64; 3];
    for i in 0..points {
        // A Hammersley set [Niederreiter 1992, §3.2]: i/n and the bits of i mirrored.
        let u = Vec2::new((i as f32 + 0.5) / points as f32, unit(i.reverse_bits()));
        let at = shape.sample_area(primitive, u);
        let le = radiance.eval(&texture_context(scene, surface, &at), &Wavelengths::Rgb).to_rgb();
        sum.iter_mut().zip(le).for_each(|(s, l)| *s += f64::from(l));
    }
    let [r, g, b] = sum.map(|s| (s / f64::from(points)) as f32);
    Spectrum::rgb(r, g, b)
}

impl Area {
    #[inline]
    fn shape<'a>(&self, scene: &'a Scene) -> &'a Shape {
        &scene.surface(self.surface).shape
    }
}

impl Light for Area {
    #[inline]
    fn le(&self, scene: &Scene, x: &Interaction, wl: &Wavelengths) -> Spectrum {
        if x.n.dot(x.wo) > 0.0 { self.radiance.eval(&scene.texture_context(x), wl) } else { Spectrum::ZERO }
    }

    #[inline]
    fn pdf(&self, scene: &Scene, from: &LightReference, id: LightId, x: &Interaction) -> f32 {
        let front = x.n.dot(from.p - x.p) > 0.0;
        if front { self.shape(scene).pdf_direction(id.primitive, from.p, x) } else { 0.0 }
    }

    #[inline]
    fn sample(&self, scene: &Scene, from: &LightReference, id: LightId, u: Vec2, wl: &Wavelengths) -> Option<LightSample> {
        let sample = self.shape(scene).sample_direction(id.primitive, from.p, u);
        let (at, pdf_w) = sample.as_ref()?;
        let d = from.p - at.p;
        let distance = d.length();
        if at.n.dot(d) <= 0.0 || distance == 0.0 {
            return None;
        }
        Some(LightSample {
            wi: -d / distance,
            p: offset_origin(at.p, at.p_error, at.n, d),
            distance,
            le: self.radiance.eval(&texture_context(scene, self.surface, at), wl),
            pdf: Pdf::SolidAngle(*pdf_w),
            emitter: id.emitter,
            primitive: id.primitive,
            n: at.n,
        })
    }

    fn pdf_emission(&self, scene: &Scene, id: LightId, x: &Interaction) -> EmissionPdf {
        EmissionPdf {
            position: PositionPdf::Area(1.0 / self.shape(scene).area_of(id.primitive)),
            direction: Pdf::SolidAngle(cosine_hemisphere_pdf(x.n.dot(x.wo))),
        }
    }

    fn sample_emission(&self, scene: &Scene, id: LightId, u: Vec2, u_direction: Vec2, wl: &Wavelengths) -> Option<EmissionSample> {
        let at = self.shape(scene).sample_area(id.primitive, u);
        let local = square_to_cosine_hemisphere(u_direction).normalize();
        let d = Frame::from_normal(at.n).to_world(local);
        Some(EmissionSample {
            ray: Ray::new(offset_origin(at.p, at.p_error, at.n, d), d),
            n: at.n,
            pdf: EmissionPdf { position: PositionPdf::Area(at.pdf_a), direction: Pdf::SolidAngle(cosine_hemisphere_pdf(local.z)) },
            weight: self.radiance.eval(&texture_context(scene, self.surface, &at), wl) / (at.pdf_a * FRAC_1_PI),
            emitter: id.emitter,
            primitive: id.primitive,
        })
    }

    fn power_of(&self, scene: &Scene, primitive: u32) -> Spectrum {
        let area = self.shape(scene).area_of(primitive);
        mean_radiance(scene, self.surface, &self.radiance, primitive) * (PI * area)
    }

    fn primitive_count(&self, scene: &Scene) -> u32 {
        self.shape(scene).primitive_count()
    }

    fn extent(&self, scene: &Scene, primitive: u32) -> Extent {
        // A texture is seen at a few points only: half its overall mean keeps parts from being held to be dark that may not be.
        let here = scalar(mean_radiance(scene, self.surface, &self.radiance, primitive));
        let brightness = 0.5 * (here + scalar(self.radiance.mean(scene)));
        Extent::Bounded(LightBounds::of_surface(self.shape(scene), primitive, brightness))
    }
}
