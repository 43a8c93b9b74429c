//! `goniometric`: a point whose intensity a measured picture tells for each direction.
//!
//! ```text
//! I(w) = I t(u, v),    (u, v) = the square's point of w in the light's coordinates, areas kept       (see numerics::warp)
//! Φ = 4π I mean(t)
//! ```
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `intensity` | I, W/sr | 1 |
//! | `filename` | a square picture; its luminance is t | |
//! | `power` | I is scaled so that Φ is this times I, by its luminance | none |
//! | `to_world` | from the light's coordinates; scales are taken out | identity |

use super::point::towards;
use super::{EmissionPdf, EmissionSample, Extent, Light, LightBounds, LightId, LightReference, LightSample, PositionPdf, scalar};
use crate::scene::Scene;
use crate::texture::{Color, Texels};
use etendue_numerics::math::PI;
use etendue_numerics::table::Table2D;
use etendue_numerics::warp::{equal_area_sphere_to_square, square_to_equal_area_sphere};
use etendue_numerics::{Frame, Pdf, Ray, Spectrum, Vec2, Vec3, Wavelengths};

/// A measured lamp.
#[derive(Clone, Debug)]
pub struct Goniometric {
    p: Vec3,
    axes: Frame,
    intensity: Color,
    scale: f32,
    /// t by texel; its table draws directions.
    values: Vec<f32>,
    cells: Table2D,
}

impl Goniometric {
    /// A lamp at `p` with the orthonormal `axes`, of intensity `scale` · `intensity` times the picture's luminance.
    pub fn new(p: Vec3, axes: Frame, intensity: Color, scale: f32, texels: &Texels) -> Self {
        let (w, h) = (texels.width(), texels.height());
        let values: Vec<f32> = (0..w * h).map(|i| texels.scalar(texels.texel(i % w, i / w)).max(0.0)).collect();
        let cells = Table2D::new(&values, w, h);
        Self { p, axes, intensity, scale, values, cells }
    }

    /// The mean of t.
    pub fn mean(&self) -> f64 {
        self.cells.sum() / self.values.len().max(1) as f64
    }

    fn texel(&self, w: Vec3) -> (usize, usize) {
        let uv = equal_area_sphere_to_square(self.axes.to_local(w));
        let (width, height) = self.cells.size();
        let at = |x: f32, n: usize| ((x * n as f32) as usize).min(n - 1);
        (at(uv.x, width), at(uv.y, height))
    }

    /// I, W/sr, into the unit direction `w`.
    fn intensity(&self, w: Vec3, wl: &Wavelengths) -> Spectrum {
        let (column, row) = self.texel(w);
        self.intensity.at(wl) * (self.scale * self.values[row * self.cells.size().0 + column])
    }

    fn pdf_w(&self, w: Vec3) -> f32 {
        let (column, row) = self.texel(w);
        if self.cells.sum() > 0.0 { self.cells.probability(column, row) * self.values.len() as f32 / (4.0 * PI) } else { 0.0 }
    }
}

impl Light for Goniometric {
    fn sample(&self, _: &Scene, from: &LightReference, id: LightId, _: Vec2, wl: &Wavelengths) -> Option<LightSample> {
        let (wi, distance, inverse_r2) = towards(from.p, self.p)?;
        let le = self.intensity(-wi, wl) * inverse_r2;
        let sample =
            LightSample { wi, p: self.p, distance, le, pdf: Pdf::Delta(1.0), emitter: id.emitter, primitive: 0, n: Vec3::ZERO };
        (!le.is_zero()).then_some(sample)
    }

    fn pdf_emission_discrete(&self, _: &Scene, w: Vec3) -> EmissionPdf {
        EmissionPdf { position: PositionPdf::Delta(1.0), direction: Pdf::SolidAngle(self.pdf_w(w)) }
    }

    fn sample_emission(&self, _: &Scene, id: LightId, _: Vec2, u: Vec2, wl: &Wavelengths) -> Option<EmissionSample> {
        if self.cells.sum() <= 0.0 {
            return None;
        }
        let (column, row, _, rest) = self.cells.sample_discrete(u);
        let (width, height) = self.cells.size();
        let uv = (Vec2::new(column as f32, row as f32) + rest) / Vec2::new(width as f32, height as f32);
        let d = self.axes.to_world(square_to_equal_area_sphere(uv)).normalize();
        let pdf_w = self.pdf_w(d);
        (pdf_w > 0.0).then(|| EmissionSample {
            ray: Ray::new(self.p, d),
            n: Vec3::ZERO,
            pdf: EmissionPdf { position: PositionPdf::Delta(1.0), direction: Pdf::SolidAngle(pdf_w) },
            weight: self.intensity(d, wl) / pdf_w,
            emitter: id.emitter,
            primitive: id.primitive,
        })
    }

    fn power_of(&self, scene: &Scene, _: u32) -> Spectrum {
        self.intensity.mean(scene) * (4.0 * PI * self.scale * self.mean() as f32)
    }

    fn extent(&self, scene: &Scene, _: u32) -> Extent {
        let brightest = self.values.iter().copied().fold(0.0, f32::max);
        Extent::Bounded(LightBounds::of_point(self.p, self.scale * brightest * scalar(self.intensity.mean(scene))))
    }
}
