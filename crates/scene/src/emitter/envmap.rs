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
//! leave to the walk what shines from all around, which it finds at least as well [Karlík et al. 2019, MIS compensation]. Where it is known what is
//! seen of the sky, that decides ([`super::outlook`]).
//!
//! Within a cell directions are drawn evenly in φ and cosθ, so the density is constant there and holds sinθ exactly. A cell is never
//! drawn only if its four corners are black, and then so is all of it.
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `filename` | the picture, linear radiance | |
//! | `scale` | s | 1 |
//! | `to_world` | from the picture's coordinates (y up; the picture's left edge lies towards -z, its middle towards +z) | identity |

use super::directional::{disk_density, from_infinity, outside, scene_sphere};
use super::tiles::{TileChoice, Tiles};
use super::{EmissionPdf, EmissionSample, Extent, Light, LightId, LightQuery, LightReference, LightSample, PositionPdf, scalar};
use crate::scene::Scene;
use crate::texture::Texels;
use etendue_numerics::math::{ONE_MINUS_EPSILON, PI, TAU, atan2, safe_acos, safe_sqrt, sin_cos};
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
    cells: Box<Tiles>,
    /// The same beside a walk; no light sample is drawn where it has no weight.
    excess: Box<Table2D>,
    /// Its weights, summed over tiles.
    suns: Vec<f32>,
    /// For each row of texels cosθ, and 1/Ω of a cell of the row that begins there.
    rows: Vec<[f32; 2]>,
    /// ∫ Le dw, W/m².
    integral: Spectrum,
}

impl Environment {
    /// Surroundings of radiance `scale` times the picture, W/(m² sr). `axes` holds the directions of the picture's x, y and z in the world.
    pub fn new(texels: Arc<Texels>, scale: f32, axes: Frame) -> Self {
        let (width, height) = (texels.width(), texels.height().max(2));
        let rows = (0..height).map(|row| [cos_theta(height, row), 1.0 / solid_angle(width, height, row)]).collect();
        let mut new = Self {
            texels,
            scale,
            width,
            height,
            axes,
            cells: Tiles::new(&[0.0], 1, 1).into(),
            excess: Table2D::new(&[], 1, 1).into(),
            suns: Vec::new(),
            rows,
            integral: Spectrum::ZERO,
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
        new.cells = Tiles::new(&weights, width, height - 1).into();
        let mean = scalar(new.integral) / (4.0 * PI);
        // A little more, lest rounding make a pattern of an even sky.
        let excess = |(i, w): (usize, &f32)| (w - 1.001 * mean * solid_angle(width, height, i / width)).max(0.0);
        let excess: Vec<f32> = weights.iter().enumerate().map(excess).collect();
        new.suns = Tiles::new(&excess, width, height - 1).weights().to_vec();
        new.excess = Table2D::new(&excess, width, height - 1).into();
        new
    }

    /// Radiance of a texel; below zero there is no light.
    fn texel(&self, column: usize, row: usize) -> Spectrum {
        self.texels.texel(column, row.min(self.texels.height() - 1)).max(0.0) * self.scale
    }

    /// The cell of a unit direction in the picture's coordinates, (column, row), and the place in it.
    #[inline]
    fn cell(&self, local: Vec3) -> (usize, usize, Vec2) {
        let (w, h) = (self.width, self.height);
        let phi = atan2(local.x, -local.z) * (1.0 / TAU);
        // From the last texel centre before the left edge on.
        let x = (if phi < 0.0 { phi + 1.0 } else { phi }) * w as f32 + (w as f32 - 0.5);
        let y = safe_acos(local.y) * ((h - 1) as f32 / PI);
        let (column, row) = (x as usize, (y as usize).min(h - 2));
        let place = Vec2::new(x - column as f32, y - row as f32);
        let column = if column >= w { column - w } else { column };
        (column.min(w - 1), row, place)
    }

    /// Le at a place in a cell.
    #[inline]
    fn radiance(&self, (column, row, place): (usize, usize, Vec2)) -> Spectrum {
        let right = if column + 1 == self.width { 0 } else { column + 1 };
        let across = |row: usize| Spectrum::lerp(place.x, self.texel(column, row), self.texel(right, row));
        Spectrum::lerp(place.y, across(row), across(row + 1))
    }

    /// The sky by tiles, weighted with their light, W/m².
    pub(super) fn tiles(&self) -> &Tiles {
        &self.cells
    }

    /// What of the weight of each tile exceeds the mean.
    pub(super) fn suns(&self) -> &[f32] {
        &self.suns
    }

    /// A unit direction into a tile of the sky, by its light, in the world.
    pub(super) fn towards(&self, tile: usize, u: Vec2) -> Vec3 {
        let (cell, _, rest) = self.cells.sample_within(tile, u);
        self.axes.to_world(self.direction(cell, rest))
    }

    /// p_w of a unit direction in the picture's coordinates.
    #[inline]
    fn density(&self, drawn: Drawn<'_>, local: Vec3) -> f32 {
        let (column, row, _) = self.cell(local);
        let probability = match drawn {
            Drawn::Nothing => 0.0,
            Drawn::Tiles(choice) => self.cells.probability(choice, [column, row]),
            Drawn::Excess => self.excess.probability(column, row),
        };
        probability * self.rows[row][1]
    }

    /// A cell, its probability, and the place in it.
    #[inline]
    fn sample_cell(&self, drawn: Drawn<'_>, u: Vec2) -> Option<Chosen> {
        match drawn {
            Drawn::Nothing => None,
            Drawn::Tiles(choice) => Some(self.cells.sample(choice, u)),
            Drawn::Excess => {
                let (column, row, probability, rest) = self.excess.sample_discrete(u);
                Some(([column, row], probability, rest))
            }
        }
    }

    /// The same as light samples for `from` draw it.
    #[inline]
    fn sampled_cell(&self, scene: &Scene, from: &LightReference, u: Vec2) -> Option<Chosen> {
        let (drawn, chance) = self.drawn(scene, from);
        if u.x >= chance {
            return None;
        }
        let (cell, probability, rest) = self.sample_cell(drawn, Vec2::new((u.x / chance).min(ONE_MINUS_EPSILON), u.y))?;
        Some((cell, probability * chance, rest))
    }

    /// The unit direction there in the picture's coordinates, with its p_w and Le.
    fn point(&self, (cell, probability, rest): Chosen) -> (Vec3, f32, Spectrum) {
        let (d, [column, row]) = (self.direction(cell, rest), cell);
        let y = (safe_acos(d.y) * ((self.height - 1) as f32 / PI) - row as f32).clamp(0.0, 1.0);
        (d, probability * self.rows[row][1], self.radiance((column, row, Vec2::new(rest.x, y))))
    }

    /// [`Light::sample`] for many points: texels are asked for ahead.
    pub(super) fn sample_each(
        &self,
        scene: &Scene,
        id: LightId,
        queries: &[LightQuery],
        mut found: impl FnMut(usize, Option<LightSample>),
    ) {
        let chosen: Vec<_> = queries.iter().map(|query| self.sampled_cell(scene, &query.from, query.u)).collect();
        for ([column, row], ..) in chosen.iter().flatten() {
            self.texels.fetch(*column, (*row).min(self.texels.height() - 1));
            self.texels.fetch(*column, (row + 1).min(self.texels.height() - 1));
        }
        for (i, (cell, query)) in chosen.into_iter().zip(queries).enumerate() {
            found(i, cell.map(|cell| self.light_sample(scene, &query.from, id, cell)));
        }
    }

    #[inline]
    fn light_sample(&self, scene: &Scene, from: &LightReference, id: LightId, chosen: Chosen) -> LightSample {
        let (local, pdf_w, le) = self.point(chosen);
        let wi = self.axes.to_world(local);
        LightSample {
            wi,
            p: outside(scene, from.p, wi),
            distance: f32::INFINITY,
            le,
            pdf: Pdf::SolidAngle(pdf_w),
            emitter: id.emitter,
            primitive: 0,
            n: Vec3::ZERO,
        }
    }

    /// All of the sky.
    fn whole(&self) -> Drawn<'_> {
        if self.cells.weights().iter().any(|w| *w > 0.0) { Drawn::Tiles(self.cells.own()) } else { Drawn::Nothing }
    }

    /// What light samples for `from` draw, and how often they are tried.
    #[inline]
    fn drawn<'a>(&'a self, scene: &'a Scene, from: &LightReference) -> (Drawn<'a>, f32) {
        if !from.shared {
            return (self.whole(), 1.0);
        }
        match scene.lights.view(scene, from) {
            Some(view) => (if view.chance > 0.0 { Drawn::Tiles(&view.choice) } else { Drawn::Nothing }, view.chance),
            None => (if self.excess.sum() > 0.0 { Drawn::Excess } else { Drawn::Nothing }, 1.0),
        }
    }

    /// The unit direction to a place in a cell, evenly in φ and cosθ.
    #[inline]
    fn direction(&self, [column, row]: [usize; 2], place: Vec2) -> Vec3 {
        let phi = TAU * (column as f32 + 0.5 + place.x) / self.width as f32;
        let (top, bottom) = (self.rows[row][0], self.rows[row + 1][0]);
        let cos = top + (bottom - top) * place.y;
        let sin = safe_sqrt((1.0 - cos) * (1.0 + cos));
        let (sin_phi, cos_phi) = sin_cos(phi);
        Vec3::new(sin * sin_phi, cos, -sin * cos_phi).normalize()
    }
}

/// A cell (column, row), its probability, and a place in it.
type Chosen = ([usize; 2], f32, Vec2);

/// From what a direction is drawn.
#[derive(Clone, Copy)]
enum Drawn<'a> {
    /// There is no light.
    Nothing,
    /// A tile, then a cell by its light.
    Tiles(&'a TileChoice),
    /// A cell by what exceeds the mean.
    Excess,
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
    fn le_escaped(&self, d: Vec3, _: &Wavelengths) -> Spectrum {
        self.radiance(self.cell(self.axes.to_local(d)))
    }

    fn pdf_escaped(&self, scene: &Scene, from: &LightReference, wi: Vec3) -> f32 {
        let (drawn, chance) = self.drawn(scene, from);
        chance * self.density(drawn, self.axes.to_local(wi))
    }

    fn sample(&self, scene: &Scene, from: &LightReference, id: LightId, u: Vec2, _: &Wavelengths) -> Option<LightSample> {
        let cell = self.sampled_cell(scene, from, u)?;
        Some(self.light_sample(scene, from, id, cell))
    }

    fn pdf_emission_escaped(&self, scene: &Scene, wi: Vec3) -> EmissionPdf {
        let direction = Pdf::SolidAngle(self.density(self.whole(), self.axes.to_local(wi)));
        EmissionPdf { position: PositionPdf::Area(disk_density(scene)), direction }
    }

    fn sample_emission(&self, scene: &Scene, id: LightId, u: Vec2, u_direction: Vec2, _: &Wavelengths) -> Option<EmissionSample> {
        let (local, pdf_w, le) = self.point(self.sample_cell(self.whole(), u_direction)?);
        let d = -self.axes.to_world(local);
        let (ray, pdf_a) = from_infinity(scene, d, u)?;
        Some(EmissionSample {
            ray,
            n: d,
            pdf: EmissionPdf { position: PositionPdf::Area(pdf_a), direction: Pdf::SolidAngle(pdf_w) },
            weight: le / (pdf_a * pdf_w),
            emitter: id.emitter,
            primitive: id.primitive,
        })
    }

    fn power_of(&self, scene: &Scene, _: u32) -> Spectrum {
        let (_, radius) = scene_sphere(scene);
        self.integral * (PI * radius * radius)
    }

    fn extent(&self, _: &Scene, _: u32) -> Extent {
        // A quarter of the integral: the irradiance of surroundings that are everywhere as bright as on average.
        let excess = 0.25 * self.excess.sum() as f32;
        Extent::Distant { irradiance: 0.25 * scalar(self.integral), excess, from: None }
    }
}
