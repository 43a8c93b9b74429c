//! `area`: the front of a surface, equally bright from all directions.
//!
//! ```text
//! Le(x, w) = L(x)  where n·w > 0,  0 behind,    Φ = π ∫ L dA
//! p_w = the shape's own density seen from a point,    p_A = 1/A and p_w = cosθ/π of light that sets out; of two sides p_A = 1/2A
//! ```
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `radiance` | L, W/(m² sr); constant or textured | 1 |
//! | `two_sided` | the back shines as well | false |
//! | `masked` | L is multiplied by the opacity of the `mask` that is the surface's material | false |
//! | `unseen` | it shines, but no ray meets it: light samples alone find it, as they do a point | false |
//! | `scale` | a factor on L | 1 |
//! | `power` | L is scaled so that where it is 1 the whole (of a mesh each triangle) has this flux, W; of a picture by its mean luminance | none |

use super::{EmissionPdf, EmissionSample, Extent, Light, LightBounds, LightId, LightReference, LightSample, PositionPdf, scalar};
use crate::ids::SurfaceId;
use crate::interaction::Interaction;
use crate::scene::Scene;
use crate::shape::{Geometry, Shape, SurfacePoint};
use crate::texture::{ColorSlot, TextureContext};
use etendue_numerics::math::{FRAC_1_PI, ONE_MINUS_EPSILON, PI};
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
    /// A factor on it.
    pub scale: f32,
    /// The back shines as well.
    pub two_sided: bool,
    /// No ray meets it: of its light samples nobody else has a share.
    pub unseen: bool,
}

/// A place on the surface, for its texture.
#[inline]
pub(super) fn texture_context<'a>(scene: &'a Scene, surface: SurfaceId, at: &SurfacePoint) -> TextureContext<'a> {
    TextureContext { scene, uv: at.uv, surface, primitive: at.primitive, bary: at.bary, p: at.p, n: at.ns }
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
    /// L, whatever the side.
    #[inline]
    fn emitted(&self, x: &TextureContext, wl: &Wavelengths) -> Spectrum {
        let radiance = self.radiance.eval(x, wl);
        if self.scale == 1.0 { radiance } else { radiance * self.scale }
    }

    /// The share of one side.
    #[inline]
    fn side(&self) -> f32 {
        if self.two_sided { 0.5 } else { 1.0 }
    }

    #[inline]
    fn shape<'a>(&self, scene: &'a Scene) -> &'a Shape {
        &scene.surface(self.surface).shape
    }
}

impl Light for Area {
    #[inline]
    fn le(&self, scene: &Scene, x: &Interaction, wl: &Wavelengths) -> Spectrum {
        let shines = self.two_sided || x.n.dot(x.wo) > 0.0;
        if shines { self.emitted(&scene.texture_context(x), wl) } else { Spectrum::ZERO }
    }

    #[inline]
    fn pdf(&self, scene: &Scene, from: &LightReference, id: LightId, x: &Interaction) -> f32 {
        let front = self.two_sided || x.n.dot(from.p - x.p) > 0.0;
        if front { self.shape(scene).pdf_direction(id.primitive, from.p, x) } else { 0.0 }
    }

    #[inline]
    fn sample(&self, scene: &Scene, from: &LightReference, id: LightId, u: Vec2, wl: &Wavelengths) -> Option<LightSample> {
        let sample = self.shape(scene).sample_direction(id.primitive, from.p, u);
        let (at, pdf_w) = sample.as_ref()?;
        let d = from.p - at.p;
        let distance = d.length();
        let behind = at.n.dot(d) <= 0.0;
        if behind && !self.two_sided || distance == 0.0 {
            return None;
        }
        Some(LightSample {
            wi: -d / distance,
            p: offset_origin(at.p, at.p_error, at.n, d),
            distance,
            le: self.emitted(&texture_context(scene, self.surface, at), wl),
            pdf: if self.unseen { Pdf::Delta(*pdf_w) } else { Pdf::SolidAngle(*pdf_w) },
            emitter: id.emitter,
            primitive: id.primitive,
            n: if behind { -at.n } else { at.n },
        })
    }

    fn pdf_emission(&self, scene: &Scene, id: LightId, x: &Interaction) -> EmissionPdf {
        EmissionPdf {
            position: PositionPdf::Area(self.side() / self.shape(scene).area_of(id.primitive)),
            direction: Pdf::SolidAngle(if self.two_sided {
                cosine_hemisphere_pdf(x.n.dot(x.wo).abs())
            } else {
                cosine_hemisphere_pdf(x.n.dot(x.wo))
            }),
        }
    }

    fn sample_emission(&self, scene: &Scene, id: LightId, u: Vec2, u_direction: Vec2, wl: &Wavelengths) -> Option<EmissionSample> {
        let at = self.shape(scene).sample_area(id.primitive, u);
        // Of two sides the halves of u.x serve one each: places on either side are different ones, and the density of a place knows of it.
        let (n, u_direction) = match (self.two_sided, u_direction.x < 0.5) {
            (false, _) => (at.n, u_direction),
            (true, true) => (at.n, Vec2::new(2.0 * u_direction.x, u_direction.y)),
            (true, false) => (-at.n, Vec2::new((2.0 * u_direction.x - 1.0).min(ONE_MINUS_EPSILON), u_direction.y)),
        };
        let pdf_a = self.side() * at.pdf_a;
        let local = square_to_cosine_hemisphere(u_direction).normalize();
        let d = Frame::from_normal(n).to_world(local);
        Some(EmissionSample {
            ray: Ray::new(offset_origin(at.p, at.p_error, at.n, d), d),
            n,
            pdf: EmissionPdf { position: PositionPdf::Area(pdf_a), direction: Pdf::SolidAngle(cosine_hemisphere_pdf(local.z)) },
            weight: self.emitted(&texture_context(scene, self.surface, &at), wl) / (pdf_a * FRAC_1_PI),
            emitter: id.emitter,
            primitive: id.primitive,
        })
    }

    fn power_of(&self, scene: &Scene, primitive: u32) -> Spectrum {
        let area = self.shape(scene).area_of(primitive);
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        mean_radiance(scene, self.surface, &self.radiance, primitive) * (PI * area * sides * self.scale)
    }

    fn primitive_count(&self, scene: &Scene) -> u32 {
        self.shape(scene).primitive_count()
    }

    fn extent(&self, scene: &Scene, primitive: u32) -> Extent {
        // A texture is seen at a few points only: half its overall mean keeps parts from being held to be dark that may not be.
        let here = scalar(mean_radiance(scene, self.surface, &self.radiance, primitive));
        let brightness = 0.5 * self.scale * (here + scalar(self.radiance.mean(scene)));
        let bounds = LightBounds::of_surface(self.shape(scene), primitive, brightness);
        Extent::Bounded(if self.two_sided { bounds.all_around() } else { bounds })
    }
}
