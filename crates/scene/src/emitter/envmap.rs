//! `envmap`: a picture all around, in latitude and longitude.
//!
//! ```text
//! φ = atan2(x, -z),  θ = arccos y      (x, y, z) the direction in the picture's coordinates
//! X = W φ/2π - 1/2,  Y = (H - 1) θ/π   where in the picture: texel centres are whole numbers, the top and bottom rows are the poles
//! Le(w) = s · bilinear(X, Y), going round in X
//! p_w = P(cell) / Ω(cell)              cells between four texel centres, P ∝ mean of the four · Ω,  Ω = 2π/W · (cosθ₀ - cosθ₁)
//! Φ = π R² ∫ Le dw through the scene's sphere of radius R
//! ```
//!
//! Where a walk looks for light as well, P ∝ max(mean of the four - L̄, 0) · Ω with L̄ = ∫ Le dw / 4π: light samples see to suns and windows, and
//! leave to the walk what shines from all around, which it finds at least as well [Karlík et al. 2019, MIS compensation].
//!
//! To walks that carry wavelengths Mitsuba shows the product of two interpolations, of texels' brightness (the largest channel) and of their hue, and its
//! scenes are rendered so: between texels of unlike brightness the colour is that of the darker one more than it should be (`hue_apart`).
//!
//! Within a cell directions are drawn evenly in φ and cosθ, so the density is constant there and holds sinθ exactly. A cell is never
//! drawn only if its four corners are black, and then so is all of it.
//!
//! Many rays and many light samples are worked on together (`lanes`), to the same bits.
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `filename` | the picture, linear radiance | |
//! | `scale` | s | 1 |
//! | `to_world` | from the picture's coordinates (y up; the picture's left edge lies towards -z, its middle towards +z) | identity |

mod lanes;

use super::infinity::{emission_pdf, emission_sample, light_sample, power};
use super::{EmissionPdf, EmissionSample, Escape, Extent, Light, LightId, LightQuery, LightReference, LightSample, Seen, scalar};
use crate::scene::Scene;
use crate::texture::{Role, Texels};
use etendue_numerics::math::{PI, TAU, atan2, safe_acos, safe_sqrt, sin_cos_near};
use etendue_numerics::table::Table2D;
use etendue_numerics::{Frame, Pdf, Spectrum, Vec2, Vec3, Wavelengths};
use std::sync::Arc;

/// Surroundings from a picture.
#[derive(Clone, Debug)]
pub struct Environment {
    texels: Arc<Texels>,
    scale: f32,
    width: usize,
    /// Rows of texels; 2 where the picture has one, which then is the same from pole to pole.
    height: usize,
    /// The picture's axes in the world: orthonormal, either hand.
    axes: Frame,
    /// Which cell; rows of cells lie between rows of texels.
    cells: Table2D,
    /// The same beside a walk; no light sample is drawn where it has no weight.
    excess: Table2D,
    /// For each row of texels cosθ, and 1/Ω of a cell of the row that begins there.
    rows: Vec<[f32; 2]>,
    /// ∫ Le dw, W/m².
    integral: Spectrum,
    /// Whether wavelengths see brightness and hue interpolated apart.
    hue_apart: bool,
}

impl Environment {
    /// Surroundings of radiance `scale` times the picture, W/(m² sr). `axes` holds the directions of the picture's x, y and z in the world.
    pub fn new(texels: Arc<Texels>, scale: f32, axes: Frame) -> Self {
        let (width, height) = (texels.width(), texels.height().max(2));
        let rows = (0..height).map(|row| [cos_theta(height, row), 1.0 / solid_angle(width, height, row)]).collect();
        let none = Table2D::new(&[], 1, 1);
        let mut new = Self {
            texels,
            scale,
            width,
            height,
            axes,
            cells: none.clone(),
            excess: none,
            rows,
            integral: Spectrum::ZERO,
            hue_apart: false,
        };

        let mut weights = Vec::with_capacity(width * (height - 1));
        let mut integral = [0f64; 3];
        for row in 0..height - 1 {
            let omega = solid_angle(width, height, row);
            for column in 0..width {
                let corners = [(column, row), (column + 1, row), (column, row + 1), (column + 1, row + 1)];
                let mean = corners.into_iter().map(|(x, y)| new.texel(x % width, y)).sum::<Spectrum>() * (0.25 * omega);
                weights.push(scalar(mean));
                integral.iter_mut().zip(mean.to_rgb()).for_each(|(i, m)| *i += f64::from(m));
            }
        }
        let [r, g, b] = integral.map(|i| i as f32);
        new.integral = Spectrum::rgb(r, g, b);
        new.cells = Table2D::new(&weights, width, height - 1);
        let mean = (new.cells.sum() / f64::from(4.0 * PI)) as f32;
        // A little more, lest rounding make a pattern of an even sky.
        let excess = |(i, w): (usize, &f32)| (w - 1.001 * mean * solid_angle(width, height, i / width)).max(0.0);
        new.excess = Table2D::new(&weights.iter().enumerate().map(excess).collect::<Vec<_>>(), width, height - 1);
        new
    }

    /// The same, interpolated for wavelengths as Mitsuba has it.
    pub fn with_hue_apart(self, hue_apart: bool) -> Self {
        Self { hue_apart, ..self }
    }

    /// Radiance of a texel; below zero there is no light.
    fn texel(&self, column: usize, row: usize) -> Spectrum {
        self.texels.texel(column, row.min(self.texels.height() - 1)).max(0.0) * self.scale
    }

    /// The cell of a unit direction in the picture's coordinates, (column, row), and the place in it.
    #[inline]
    fn cell(&self, local: Vec3) -> (usize, usize, Vec2) {
        let ((column, x), (row, y)) = (across(self.width, local), down(self.height, local));
        (column as usize, row as usize, Vec2::new(x, y))
    }

    /// Le at a place in a cell.
    #[inline]
    fn radiance(&self, (column, row, place): (usize, usize, Vec2), wl: &Wavelengths) -> Spectrum {
        let right = if column + 1 == self.width { 0 } else { column + 1 };
        let between = |f: &dyn Fn(Spectrum) -> Spectrum| {
            let across = |row: usize| Spectrum::lerp(place.x, f(self.texel(column, row)), f(self.texel(right, row)));
            Spectrum::lerp(place.y, across(row), across(row + 1))
        };
        let rgb = if self.hue_apart && !wl.is_rgb() {
            let brightness = between(&|texel| Spectrum::splat(texel.max_lane()));
            brightness * between(&|texel| texel / texel.max_lane().max(f32::MIN_POSITIVE))
        } else {
            between(&|texel| texel)
        };
        Role::Emission.spectrum(rgb, wl)
    }

    /// The cells as light samples draw them.
    #[inline]
    fn sampled(&self, from: &LightReference) -> &Table2D {
        if from.shared { &self.excess } else { &self.cells }
    }

    /// p_w of a unit direction in the picture's coordinates, drawn from `cells`.
    #[inline]
    fn density(&self, cells: &Table2D, local: Vec3) -> f32 {
        let (column, row, _) = self.cell(local);
        self.density_of(cells, (column, row))
    }

    /// The same within a cell.
    #[inline]
    fn density_of(&self, cells: &Table2D, (column, row): (usize, usize)) -> f32 {
        if cells.sum() > 0.0 { cells.probability(column, row) * self.rows[row][1] } else { 0.0 }
    }

    /// A unit direction in the picture's coordinates drawn from `cells`, with its p_w and Le.
    fn sample_local(&self, cells: &Table2D, u: Vec2, wl: &Wavelengths) -> Option<(Vec3, f32, Spectrum)> {
        if cells.sum() <= 0.0 {
            return None;
        }
        let (local, pdf_w, cell) = self.direction(cells.sample_discrete(u));
        Some((local, pdf_w, self.radiance(cell, wl)))
    }

    /// The direction at the place `rest` of a cell, with its p_w, and where it is in the picture.
    fn direction(&self, (column, row, probability, rest): (usize, usize, f32, Vec2)) -> (Vec3, f32, (usize, usize, Vec2)) {
        let ([top, per_sr], [bottom, _]) = (self.rows[row], self.rows[row + 1]);
        let (phi, cos) = (azimuth(self.width, column as f32, rest.x), height(top, bottom, rest.y));
        let (d, y) = (toward(phi, cos), below(self.height, row as f32, cos));
        (d, probability * per_sr, (column, row, Vec2::new(rest.x, y)))
    }

    /// Asks for the memory of the texels around a cell.
    #[inline]
    fn fetch(&self, column: usize, row: usize) {
        let last = self.texels.height() - 1;
        self.texels.fetch(column, row.min(last));
        self.texels.fetch(column, (row + 1).min(last));
    }
}

/// The column of cells of a unit direction, and where in it: from the last texel centre before the left edge on.
#[inline(always)]
fn across(width: usize, local: Vec3) -> (i32, f32) {
    let (w, phi) = (width as i32, atan2(local.x, -local.z) * (1.0 / TAU));
    let x = (if phi < 0.0 { phi + 1.0 } else { phi }) * w as f32 + (w as f32 - 0.5);
    let column = x as i32;
    let place = x - column as f32;
    let column = if column >= w { column - w } else { column };
    (column.min(w - 1), place)
}

/// Its row, and where in it.
#[inline(always)]
fn down(height: usize, local: Vec3) -> (i32, f32) {
    let y = safe_acos(local.y) * ((height - 1) as f32 / PI);
    let row = (y as i32).min(height as i32 - 2);
    (row, y - row as f32)
}

/// φ of a place in a column.
#[inline(always)]
fn azimuth(width: usize, column: f32, x: f32) -> f32 {
    TAU * (column + 0.5 + x) / width as f32
}

/// cosθ of a place in a row, even between those of its top and its bottom.
#[inline(always)]
fn height(top: f32, bottom: f32, y: f32) -> f32 {
    top + (bottom - top) * y
}

/// The unit direction of φ and cosθ.
#[inline(always)]
fn toward(phi: f32, cos: f32) -> Vec3 {
    let sin = safe_sqrt((1.0 - cos) * (1.0 + cos));
    let (sin_phi, cos_phi) = sin_cos_near(phi);
    Vec3::new(sin * sin_phi, cos, -sin * cos_phi).normalize()
}

/// Where in a row of cells cosθ is.
#[inline(always)]
fn below(height: usize, row: f32, cos: f32) -> f32 {
    (safe_acos(cos) * ((height - 1) as f32 / PI) - row).clamp(0.0, 1.0)
}

/// cosθ of a row of texels.
fn cos_theta(height: usize, row: usize) -> f32 {
    (std::f64::consts::PI * row as f64 / (height - 1) as f64).cos() as f32
}

/// Ω of a cell of a row, sr: 2π/W (cosθ₀ - cosθ₁), without cancellation at the poles.
fn solid_angle(width: usize, height: usize, row: usize) -> f32 {
    let step = std::f64::consts::PI / (height - 1) as f64;
    let middle = (row as f64 + 0.5) * step;
    (std::f64::consts::TAU / width as f64 * 2.0 * middle.sin() * (0.5 * step).sin()) as f32
}

impl Light for Environment {
    fn le_escaped(&self, _: Vec3, d: Vec3, wl: &Wavelengths) -> Spectrum {
        self.radiance(self.cell(self.axes.to_local(d)), wl)
    }

    fn pdf_escaped(&self, from: &LightReference, wi: Vec3) -> f32 {
        self.density(self.sampled(from), self.axes.to_local(wi))
    }

    fn escaped_each<'a>(&self, rays: impl Iterator<Item = Escape<'a>>, found: impl FnMut(&Escape<'a>, Seen)) {
        self.seen_each(rays, found);
    }

    fn sample(&self, scene: &Scene, from: &LightReference, id: LightId, u: Vec2, wl: &Wavelengths) -> Option<LightSample> {
        let (local, pdf_w, le) = self.sample_local(self.sampled(from), u, wl)?;
        let wi = self.axes.to_world(local);
        from.faces(wi).then(|| light_sample(scene, from, id, wi, Pdf::SolidAngle(pdf_w), le))
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
        emission_pdf(scene, Pdf::SolidAngle(self.density(&self.cells, self.axes.to_local(wi))))
    }

    fn sample_emission(&self, scene: &Scene, id: LightId, u: Vec2, u_direction: Vec2, wl: &Wavelengths) -> Option<EmissionSample> {
        let (local, pdf_w, le) = self.sample_local(&self.cells, u_direction, wl)?;
        emission_sample(scene, id, self.axes.to_world(local), u, Pdf::SolidAngle(pdf_w), le)
    }

    fn power_of(&self, scene: &Scene, _: u32) -> Spectrum {
        power(scene, self.integral)
    }

    fn extent(&self, _: &Scene, _: u32) -> Extent {
        // A quarter of the integral: the irradiance of surroundings that are everywhere as bright as on average.
        let excess = 0.25 * self.excess.sum() as f32;
        Extent::Distant { irradiance: 0.25 * scalar(self.integral), excess, from: None }
    }
}
