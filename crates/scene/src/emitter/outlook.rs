//! What of the surroundings is seen from where, so that light samples go out through the windows and not into the walls.
//!
//! ```text
//! P(tile | x) = (1 - γ) w/Σw + γ E⁺/ΣE⁺          w = E √(mean of (V cos⁺)² over rays from the cell of x to the tile)
//! ```
//!
//! | symbol | meaning |
//! | --- | --- |
//! | E | irradiance that a tile of the sky brings to a surface that faces it, W/m² |
//! | E⁺ | the part of it by radiance above the sky's mean: suns ([`super::envmap`]) |
//! | γ | share of the suns, [`SUNS`] at most, for rays miss gaps |
//!
//! Space is divided into cells, each for one of six ways that normals point. Before the first picture some walks from the eye note down where
//! light scatters, [`STANDS`] places a cell at most. The first light sample asked for in a cell casts a ray from one of them to each
//! tile, more to bright ones. The second moment weighs what is seen in part like what is seen from half of the places. What a cell sees hangs on the
//! scene alone, not on who asks first: the same bits at any number of threads. Sampler and density look at the same cell, so nothing here can
//! bias a picture.
//!
//! Only light samples beside a walk ask ([`LightReference::shared`]): what no ray has seen is left to the walk. Where nothing was seen at all, a few
//! are tried for the suns' sake. Where no walk came by, larger cells are asked, and then nothing is known. Nor is it on surfaces that transmit.

use super::record::LightReference;
use super::tiles::TileChoice;
use super::{Environment, Model};
use crate::ids::EmitterId;
use crate::scene::Scene;
use etendue_bsdf::Scatter;
use etendue_numerics::ray::offset_origin;
use etendue_numerics::sequence::unit;
use etendue_numerics::{Dim, Ray, Sampler, SequenceKind, Spectrum, Vec2, Vec3, Wavelengths};
use std::sync::OnceLock;

/// Walks from the eye, and their length in vertices.
const WALKS: u32 = 8192;
const STEPS: u32 = 6;
/// Cells along the longest side of what the walks saw.
const CELLS: f32 = 16.0;
/// How much larger the cells are that help out.
const COARSER: f32 = 4.0;
/// Places that look around for a cell.
const STANDS: usize = 16;
/// Rays to a tile at most; one, unless it is brighter than most.
const MOST_RAYS: u32 = 32;
/// γ at most.
const SUNS: f32 = 0.15;
/// How often a light sample is tried where no ray found any light.
const BLIND: f32 = 0.25;

/// What all places see of one emitter.
#[derive(Clone, Debug)]
pub(super) struct Outlook {
    emitter: EmitterId,
    fine: Grid,
    coarse: Grid,
}

/// What a cell sees.
#[derive(Clone, Debug)]
pub(super) struct View {
    /// Probabilities of tiles.
    pub choice: TileChoice,
    /// How often a sample is tried at all.
    pub chance: f32,
}

/// A place on a surface, clear of it, and its normal.
#[derive(Clone, Copy, Debug)]
struct Stand {
    p: Vec3,
    n: Vec3,
}

#[derive(Clone, Debug)]
struct Grid {
    low: Vec3,
    per_metre: f32,
    size: [usize; 3],
    /// For each place in the grid and each way that normals point a cell, or [`NONE`].
    slots: Vec<u32>,
    cells: Vec<Cell>,
}

const NONE: u32 = u32::MAX;

#[derive(Clone, Debug, Default)]
struct Cell {
    stands: Vec<Stand>,
    view: OnceLock<View>,
}

impl Outlook {
    /// Of the picture all around that is `emitter`; `None` where the eye sees no surface.
    pub fn new(scene: &Scene, emitter: EmitterId) -> Option<Self> {
        let stands = walk(scene);
        if stands.is_empty() || !stands.iter().all(|s| s.p.is_finite()) {
            return None;
        }
        let mut axes = [0, 1, 2].map(|a| stands.iter().map(|s| s.p[a]).collect::<Vec<_>>());
        axes.iter_mut().for_each(|c| c.sort_by(f32::total_cmp));
        let at = |i: usize| Vec3::from(axes.each_ref().map(|c| c[i]));
        let ends = |cut: usize| (at(cut), at(stands.len() - 1 - cut));
        // Few far places must not make all cells large.
        let ((low, high), (lowest, highest)) = (ends(stands.len() / 100), ends(0));
        let whole = (highest - lowest).max_element();
        let size = ((high - low).max_element() / CELLS).max(1e-6 * whole).max(f32::MIN_POSITIVE);
        let coarse = (COARSER * size).max(whole / CELLS);
        Some(Self { emitter, fine: Grid::new(&stands, low, high, size), coarse: Grid::new(&stands, lowest, highest, coarse) })
    }

    /// What is seen at `from`, a place on a surface that reflects, if anything is known.
    #[inline]
    pub fn view(&self, scene: &Scene, from: &LightReference) -> Option<&View> {
        let cell = self.fine.cell(from).or_else(|| self.coarse.cell(from))?;
        match cell.view.get() {
            Some(view) => Some(view),
            None => self.look(scene, cell),
        }
    }

    #[cold]
    #[inline(never)]
    fn look<'a>(&self, scene: &Scene, cell: &'a Cell) -> Option<&'a View> {
        let Model::Environment(environment) = &scene.emitter(self.emitter).model else { return None };
        Some(cell.view.get_or_init(|| View::new(scene, environment, &cell.stands)))
    }
}

impl View {
    fn new(scene: &Scene, environment: &Environment, stands: &[Stand]) -> Self {
        let (tiles, suns) = (environment.tiles(), environment.suns());
        let mean = tiles.weights().iter().sum::<f32>() / tiles.weights().len() as f32;
        let mut index = 0u32;
        let look = |(tile, &weight): (usize, &f32)| {
            let rays = if weight > 0.0 { ((weight / mean) as u32).clamp(1, MOST_RAYS) } else { 0 };
            let square: f32 = (0..rays)
                .map(|_| {
                    // The R2 sequence [Roberts 2018], and the stands in turn.
                    index += 1;
                    let u = Vec2::new(unit(index.wrapping_mul(3_242_174_889)), unit(index.wrapping_mul(2_447_445_414)));
                    stands[index as usize % stands.len()].sees(scene, environment.towards(tile, u)).powi(2)
                })
                .sum();
            square / rays.max(1) as f32
        };
        let squares: Vec<f32> = tiles.weights().iter().enumerate().map(look).collect();
        let weigh = |(tile, weight): (usize, &f32)| weight * blurred(&squares, tiles.across(), tile).sqrt();
        let seen: Vec<f32> = tiles.weights().iter().enumerate().map(weigh).collect();

        let (all_seen, all_suns, all): (f32, f32, f32) = (seen.iter().sum(), suns.iter().sum(), tiles.weights().iter().sum());
        let share = if all_seen > 0.0 { SUNS.min(all_suns / all) } else { 1.0 };
        let factors =
            [if all_seen > 0.0 { (1.0 - share) / all_seen } else { 0.0 }, if all_suns > 0.0 { share / all_suns } else { 0.0 }];
        let mixed: Vec<f32> = seen.iter().zip(suns).map(|(seen, sun)| factors[0] * seen + factors[1] * sun).collect();
        let chance = match (all_seen > 0.0, all_suns > 0.0) {
            (true, _) => 1.0,
            (false, true) => BLIND,
            (false, false) => 0.0,
        };
        Self { choice: TileChoice::new(&mixed, tiles.across()), chance }
    }
}

/// A tile's value, half of it from its neighbours: one ray each is little.
fn blurred(values: &[f32], across: usize, tile: usize) -> f32 {
    let (column, row, rows) = (tile % across, tile / across, values.len() / across);
    let at = |column: usize, row: usize| values[row.min(rows - 1) * across + column % across];
    let beside = at(column + 1, row) + at(column + across - 1, row) + at(column, row + 1) + at(column, row.saturating_sub(1));
    0.5 * values[tile] + 0.125 * beside
}

impl Stand {
    /// V cos⁺ towards the unit direction `w`.
    fn sees(&self, scene: &Scene, w: Vec3) -> f32 {
        let cos = self.n.dot(w);
        if cos <= 0.0 {
            return 0.0;
        }
        let passes = scene.transmittance(&Ray::new(self.p, w), u32::MAX, &Wavelengths::Rgb);
        passes.map_or(0.0, |t| cos * super::scalar(t.value))
    }
}

/// Where light scatters along walks from the eye.
fn walk(scene: &Scene) -> Vec<Stand> {
    let mut stands = Vec::new();
    for i in 0..WALKS {
        let Some(view) = scene.views.get(i as usize % scene.views.len().max(1)) else { break };
        let u = Sampler::new(SequenceKind::Sobol, 0, 0, i, WALKS);
        // Over the whole film: a crop sees what the film sees, to the bit.
        let [width, height] = view.film.size.map(|n| n as f32);
        let pixel = Vec2::new(width, height) * u.u2(Dim::at(0, 0));
        let mut ray = view.sensor.sample_ray(pixel, u.u2(Dim::at(0, 1)), u.u1(Dim::at(0, 2))).ray;
        for vertex in 1..=STEPS {
            let Some(hit) = scene.intersect(&ray) else { break };
            let x = scene.interaction(&ray, &hit);
            let bsdf = scene.bsdf(&x, &Wavelengths::Rgb);
            if bsdf.events().has_smooth() && !bsdf.events().transmits() {
                stands.push(Stand { p: offset_origin(x.p, x.p_error, x.n, x.wo), n: LightReference::reflecting(&x).n });
            }
            let Some(sample) = bsdf.sample(x.wo_local(), u.u1(Dim::at(vertex, 0)), u.u2(Dim::at(vertex, 1))) else { break };
            if sample.weight == Spectrum::ZERO {
                break;
            }
            ray = x.spawn(x.shading.to_world(sample.wi));
        }
    }
    stands
}

impl Grid {
    /// Of cells `size` metres long from `low` to `high`, each with the first stands in it.
    fn new(stands: &[Stand], low: Vec3, high: Vec3, size: f32) -> Self {
        // What lies on the border is within.
        let (low, high) = (low - 0.5 * size, high + 0.5 * size);
        let count = ((high - low) / size).ceil().max(Vec3::ONE);
        let size_in_cells = [count.x as usize, count.y as usize, count.z as usize];
        let slots = vec![NONE; 6 * size_in_cells.iter().product::<usize>()];
        let mut grid = Self { low, per_metre: 1.0 / size, size: size_in_cells, slots, cells: Vec::new() };
        for stand in stands {
            let Some(slot) = grid.slot(stand.p, stand.n) else { continue };
            if grid.slots[slot] == NONE {
                grid.slots[slot] = grid.cells.len() as u32;
                grid.cells.push(Cell::default());
            }
            let stands = &mut grid.cells[grid.slots[slot] as usize].stands;
            if stands.len() < STANDS {
                stands.push(*stand);
            }
        }
        grid
    }

    #[inline]
    fn cell(&self, from: &LightReference) -> Option<&Cell> {
        self.cells.get(self.slots[self.slot(from.p, from.n)?] as usize)
    }

    #[inline]
    fn slot(&self, p: Vec3, n: Vec3) -> Option<usize> {
        let at = (p - self.low) * self.per_metre;
        if !at.cmpge(Vec3::ZERO).all() {
            return None;
        }
        let [x, y, z] = [at.x as usize, at.y as usize, at.z as usize];
        let [sx, sy, sz] = self.size;
        let axis = n.abs().max_position();
        let way = 2 * axis + usize::from(n[axis] < 0.0);
        (x < sx && y < sy && z < sz).then(|| 6 * ((z * sy + y) * sx + x) + way)
    }
}
