//! `envmap` with `mapping` `equal_area`: surroundings from a square picture, the sphere unfolded with areas kept.
//!
//! ```text
//! Le(w) = s · texel(u, v),    (u, v) = the square's point of w in the picture's coordinates, z in its middle     (see numerics::warp)
//! p_w = P(texel) · N / 4π,    N the number of texels
//! ```
//!
//! Texels are even: pbrt looks them up so. `scale` is s; with `illuminance` s is such that the upper half (z > 0) gives a plane that much,
//! by a luminous efficacy of 1. Many rays and many light samples are worked on together (`lanes`), to the same bits.

mod lanes;

use super::infinity::{emission_pdf, emission_sample, light_sample, power};
use super::{EmissionPdf, EmissionSample, Escape, Extent, Light, LightId, LightQuery, LightReference, LightSample, Seen, scalar};
use crate::scene::Scene;
use crate::texture::{Role, Texels};
use etendue_numerics::math::PI;
use etendue_numerics::table::Table2D;
use etendue_numerics::warp::{equal_area_sphere_to_square, square_to_equal_area_sphere};
use etendue_numerics::{Frame, Pdf, Spectrum, Vec2, Vec3, Wavelengths};
use std::sync::Arc;

/// Surroundings from a square picture.
#[derive(Clone, Debug)]
pub struct Octahedral {
    texels: Arc<Texels>,
    scale: f32,
    /// The picture's axes in the world: orthonormal, either hand.
    axes: Frame,
    /// Which texel.
    cells: Table2D,
    /// ∫ Le dw, W/m².
    integral: Spectrum,
}

impl Octahedral {
    /// Surroundings of radiance `scale` times the picture, W/(m² sr). `axes` holds the directions of the picture's x, y and z in the world.
    pub fn new(texels: Arc<Texels>, scale: f32, axes: Frame) -> Self {
        let (width, height) = (texels.width(), texels.height());
        let light = |i: usize| texels.texel(i % width, i / width).max(0.0) * scale;
        let weights: Vec<f32> = (0..width * height).map(|i| scalar(light(i))).collect();
        let mut sum = [0f64; 3];
        for i in 0..width * height {
            sum.iter_mut().zip(light(i).to_rgb()).for_each(|(s, x)| *s += f64::from(x));
        }
        let [r, g, b] = sum.map(|s| (s * 4.0 * std::f64::consts::PI / (width * height) as f64) as f32);
        let cells = Table2D::new(&weights, width, height);
        Self { texels, scale, axes, cells, integral: Spectrum::rgb(r, g, b) }
    }

    /// The illuminance, by an efficacy of 1, of a plane under the picture's upper half at scale 1.
    pub fn illuminance(texels: &Texels) -> f64 {
        let (width, height) = (texels.width(), texels.height());
        let mut sum = 0.0;
        for i in 0..width * height {
            let uv = Vec2::new((i % width) as f32 + 0.5, (i / width) as f32 + 0.5) / Vec2::new(width as f32, height as f32);
            let up = square_to_equal_area_sphere(uv).z;
            sum += f64::from(up.max(0.0) * texels.texel(i % width, i / width).luminance());
        }
        sum * 4.0 * std::f64::consts::PI / (width * height) as f64
    }

    /// The texel, (column, row), of a unit direction in the picture's coordinates.
    fn texel_of(&self, local: Vec3) -> (usize, usize) {
        let (column, row) = texel_of(self.size(), local);
        (column as usize, row as usize)
    }

    /// Columns and rows.
    fn size(&self) -> [i32; 2] {
        [self.texels.width(), self.texels.height()].map(|n| n as i32)
    }

    fn radiance(&self, (column, row): (usize, usize), wl: &Wavelengths) -> Spectrum {
        self.light(self.texels.texel(column, row), wl)
    }

    /// Le of a texel; below zero there is no light.
    #[inline]
    fn light(&self, texel: Spectrum, wl: &Wavelengths) -> Spectrum {
        Role::Emission.spectrum(texel.max(0.0), wl) * self.scale
    }

    /// p_w of a texel.
    fn density(&self, (column, row): (usize, usize)) -> f32 {
        let texels = (self.texels.width() * self.texels.height()) as f32;
        if self.cells.sum() > 0.0 { self.cells.probability(column, row) * texels / (4.0 * PI) } else { 0.0 }
    }

    /// A unit direction in the picture's coordinates, with its p_w and Le.
    fn sample_local(&self, u: Vec2, wl: &Wavelengths) -> Option<(Vec3, f32, Spectrum)> {
        if self.cells.sum() <= 0.0 {
            return None;
        }
        let (column, row, _, rest) = self.cells.sample_discrete(u);
        let size = Vec2::new(self.texels.width() as f32, self.texels.height() as f32);
        let uv = (Vec2::new(column as f32, row as f32) + rest) / size;
        let local = square_to_equal_area_sphere(uv).normalize();
        // Rounding may carry the direction into the next texel: whoever meets it there sees that one.
        let texel = self.texel_of(local);
        let pdf = self.density(texel);
        (pdf > 0.0).then(|| (local, pdf, self.radiance(texel, wl)))
    }
}

/// The texel of a unit direction in the picture's coordinates.
#[inline(always)]
fn texel_of([width, height]: [i32; 2], local: Vec3) -> (i32, i32) {
    let uv = equal_area_sphere_to_square(local);
    let at = |x: f32, n: i32| ((x * n as f32) as i32).min(n - 1);
    (at(uv.x, width), at(uv.y, height))
}

impl Light for Octahedral {
    fn le_escaped(&self, _: Vec3, d: Vec3, wl: &Wavelengths) -> Spectrum {
        self.radiance(self.texel_of(self.axes.to_local(d)), wl)
    }

    fn pdf_escaped(&self, _: &LightReference, wi: Vec3) -> f32 {
        self.density(self.texel_of(self.axes.to_local(wi)))
    }

    fn escaped_each<'a>(&self, rays: impl Iterator<Item = Escape<'a>>, found: impl FnMut(&Escape<'a>, Seen)) {
        self.seen_each(rays, found);
    }

    fn sample(&self, scene: &Scene, from: &LightReference, id: LightId, u: Vec2, wl: &Wavelengths) -> Option<LightSample> {
        let (local, pdf_w, le) = self.sample_local(u, wl)?;
        Some(light_sample(scene, from, id, self.axes.to_world(local), Pdf::SolidAngle(pdf_w), le))
    }

    fn sample_each(
        &self,
        scene: &Scene,
        id: LightId,
        queries: &[LightQuery],
        wl: &[Wavelengths],
        found: impl FnMut(usize, Option<LightSample>),
    ) {
        self.drawn_each(scene, id, queries, wl, found);
    }

    fn pdf_emission_escaped(&self, scene: &Scene, wi: Vec3) -> EmissionPdf {
        emission_pdf(scene, Pdf::SolidAngle(self.density(self.texel_of(self.axes.to_local(wi)))))
    }

    fn sample_emission(&self, scene: &Scene, id: LightId, u: Vec2, u_direction: Vec2, wl: &Wavelengths) -> Option<EmissionSample> {
        let (local, pdf_w, le) = self.sample_local(u_direction, wl)?;
        emission_sample(scene, id, self.axes.to_world(local), u, Pdf::SolidAngle(pdf_w), le)
    }

    fn power_of(&self, scene: &Scene, _: u32) -> Spectrum {
        power(scene, self.integral)
    }

    fn extent(&self, _: &Scene, _: u32) -> Extent {
        let irradiance = 0.25 * scalar(self.integral);
        Extent::Distant { irradiance, excess: irradiance, from: None }
    }
}
