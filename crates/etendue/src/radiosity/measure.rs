//! Light meters: irradiance and illuminance at points, from a solution of the radiosity equation and from path tracing.
//!
//! ```text
//! E_v = K (0.2126 R + 0.7152 G + 0.0722 B) of E          K in lm/W
//! mean ± t_{0.975, 15} s / √16                            over 16 replicates
//! ```

use super::export::luminance;
use super::sheet::{Canvas, LETTER};
use crate::compare::maps;
use crate::load::Loaded;
use crate::pool;
use crate::render::RenderError;
use etendue_image::Image;
use etendue_radiosity::Solved;
use etendue_solvers::PathRules;
use etendue_solvers::irradiance::{Meter, REPLICATES, Reflected, irradiance};
use etendue_solvers::radiosity::{Show, Shown};
use glam::DVec3;
use serde::Serialize;

/// Student's t for 95 % of 15 degrees of freedom.
const T_95: f64 = 2.131_449_5;

/// Points in a plane, the middles of `cells` along two edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// A corner, m.
    pub origin: DVec3,
    /// The edges from there, m; their cross product is the side that is lit.
    pub edges: [DVec3; 2],
    /// Points along each.
    pub cells: [usize; 2],
}

impl Grid {
    /// Its meters, row by row; `None` where the edges span no plane.
    pub fn meters(&self) -> Option<Vec<Meter>> {
        let [u, v] = self.edges;
        let n = u.cross(v).try_normalize()?;
        let at = |k: usize, c: usize| (k as f64 + 0.5) / self.cells[c] as f64;
        let point = |i: usize, j: usize| Meter { p: (self.origin + u * at(i, 0) + v * at(j, 1)).as_vec3(), n: n.as_vec3() };
        Some((0..self.cells[1]).flat_map(|j| (0..self.cells[0]).map(move |i| point(i, j))).collect())
    }
}

/// What a meter shows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Reading {
    /// E, W/m², linear Rec.709.
    pub irradiance: [f64; 3],
    /// E_v, lx.
    pub illuminance: f64,
    /// Half of the 95 % interval of E_v, lx: the noise of the rays; what patches do to the light is not in it.
    pub illuminance_95: f64,
}

/// The readings of all meters, by walks or from a solution; `rays` for each in all.
pub fn read(
    loaded: &Loaded,
    solved: Option<&Solved>,
    meters: &[Meter],
    rays: u32,
    seed: u64,
    efficacy: f64,
    threads: Option<usize>,
) -> Result<Vec<Reading>, RenderError> {
    let pool = pool::pool(threads)?;
    let scene = &loaded.scene;
    let shown = solved.map(|s| Shown::new(scene, s, &PathRules::default(), Show::Gather));
    let from = shown.as_ref().map_or(Reflected::Path, Reflected::Solution);
    // Off the surface that a meter may lie on.
    let lift = 1e-6 * scene.bounds.size().length();
    let lifted: Vec<Meter> = meters.iter().map(|m| Meter { p: m.p + m.n * lift, n: m.n }).collect();
    let all = pool.install(|| irradiance(scene, &lifted, from, rays.div_ceil(REPLICATES), seed));
    Ok(all.iter().map(|replicates| reading(replicates, efficacy)).collect())
}

fn reading(replicates: &[[f64; 3]], efficacy: f64) -> Reading {
    let n = replicates.len() as f64;
    let mean = replicates.iter().map(|e| DVec3::from_array(*e)).sum::<DVec3>() / n;
    let lux = |e: DVec3| efficacy * luminance(e);
    let variance = replicates.iter().map(|e| (lux(DVec3::from_array(*e)) - lux(mean)).powi(2)).sum::<f64>() / (n - 1.0);
    Reading { irradiance: mean.to_array(), illuminance: lux(mean), illuminance_95: T_95 * (variance / n).sqrt() }
}

/// A false-colour picture of the illuminance on a grid, its second edge upwards, with a legend; a display picture.
pub fn false_colour(readings: &[Reading], cells: [usize; 2], efficacy: f64) -> Result<Image, RenderError> {
    let [nx, ny] = cells;
    let dot = (512 / nx.max(ny).max(1)).clamp(1, 32);
    let (width, height) = ((nx * dot).max(160), (ny * dot).max(200));
    let legend = 20 * LETTER;
    let line = 2 * LETTER;
    let mut canvas = Canvas::new(width + legend, height + line, 1.0);
    let most = readings.iter().map(|r| r.illuminance).fold(0.0, f64::max);
    let colour = |lux: f64| maps::linear(if most > 0.0 { lux / most } else { 0.0 }).map(|x| x as f32);
    for (k, r) in readings.iter().enumerate() {
        let (i, j) = (k % nx, k / nx);
        for d in 0..dot * dot {
            canvas.set(i * dot + d % dot, (ny - 1 - j) * dot + d / dot, colour(r.illuminance));
        }
    }
    let (left, bar) = (width + LETTER, 3 * LETTER);
    for y in 0..height {
        let lux = most * (1.0 - y as f64 / (height - 1) as f64);
        (0..bar).for_each(|x| canvas.set(left + x, y, colour(lux)));
    }
    for k in 0..=4 {
        let lux = most * f64::from(k) / 4.0;
        let y = (height - LETTER) * (4 - k as usize) / 4;
        canvas.write(&format!("{lux:.4} lx").chars().take(13).collect::<String>(), left + bar + LETTER / 2, y, 1, [0.1; 3]);
    }
    canvas.write(&format!("illuminance, K = {efficacy} lm/W"), 2, height + LETTER / 2, 1, [0.1; 3]);
    canvas.into_image().map_err(|e| RenderError(e.to_string()))
}
