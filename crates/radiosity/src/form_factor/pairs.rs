//! `analytic` and `area`: the exchange of each pair of patches by itself.
//!
//! ```text
//! nothing between    F = F_clear
//! else               F_clear minus the sampled part of ∬ G/π that is blocked
//! ```
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `samples` | rays a patch, shared among the patches that something may hide from it, in 16 scramblings (`analytic`) | 2^20 |
//! | `seed` | of the scramblings | 0 |
//!
//! F_clear is the closed form between polygons, Lambert's formula between a polygon and points of a round patch, or the double integral between two
//! round ones. What something may hide is [`blocked`](super::blocked)'s.
//!
//! Every pair costs time, and rows hold all that is seen: for thousands of patches, not for hundreds of thousands.

use super::blocked::blocked;
use super::hemisphere::probe;
use super::polygon::{self, from_point};
use super::visible::Between;
use super::{Cancelled, FormFactors, Matrix, Rows, Watch, area};
use crate::patch::{Chart, Patches, Span};
use crate::quadrature::gauss;
use arrayvec::ArrayVec;
use etendue_scene::Scene;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Rays a patch by which a scene is taken for closed.
const PROBES: usize = 64;

/// Parameters of the methods that go from pair to pair.
#[derive(Clone, Copy, Debug)]
pub struct Pairs {
    /// Rays a patch, shared among all others; a pair has 64 at least.
    pub samples: u32,
    /// Of the scramblings.
    pub seed: u64,
}

impl Default for Pairs {
    fn default() -> Self {
        Self { samples: 1 << 20, seed: 0 }
    }
}

/// Closed forms, and sampled corrections where something stands between.
pub fn analytic(scene: &Scene, patches: &Patches, method: &Pairs, watch: &Watch) -> Result<FormFactors, Cancelled> {
    let polygons: Vec<_> = (0..patches.len() as u32).map(|i| patches.polygon(i)).collect();
    let between = Between::new(scene, patches);
    all_pairs(scene, patches, watch, |i, j| {
        let clear = clear_exchange(patches, &polygons, i, j);
        if clear == 0.0 || between.is_clear(i, j) {
            return (clear, 0.0);
        }
        blocked(patches, &polygons, &between, method, (i, j), clear)
    })
}

/// Quadrature of the double integral.
pub fn by_area(scene: &Scene, patches: &Patches, watch: &Watch) -> Result<FormFactors, Cancelled> {
    let between = Between::new(scene, patches);
    all_pairs(scene, patches, watch, |i, j| {
        let tested = (!between.is_clear(i, j)).then_some(&between);
        let sum = area::exchange(patches, i, j, tested);
        (sum.value, sum.variance.sqrt())
    })
}

/// The matrix from A_i F_ij and its standard error, asked for once for each pair i ≤ j that may see each other.
fn all_pairs(
    scene: &Scene,
    patches: &Patches,
    watch: &Watch,
    exchange: impl Fn(u32, u32) -> (f64, f64) + Sync,
) -> Result<FormFactors, Cancelled> {
    let n = patches.len();
    let balls: Vec<(DVec3, f64)> = (0..n as u32).into_par_iter().map(|i| patches.ball(i)).collect();
    let facing = |i: usize, j: usize| {
        let (p, r) = balls[j];
        let patch = &patches.patches[i];
        !patches.geometry(i as u32).1.is_flat() || (p - patch.p).dot(patch.n) > -r
    };
    // Upper rows, some at a time so that the watch hears of them.
    let mut upper: Vec<Vec<(u32, f64, f64)>> = Vec::with_capacity(n);
    while upper.len() < n {
        let begin = upper.len();
        let batch = (begin..(begin + 64).min(n)).into_par_iter().map(|i| {
            let others = (i..n).filter(|j| facing(i, *j) && facing(*j, i) && (*j != i || !patches.geometry(i as u32).1.is_flat()));
            let entry = |j: usize| {
                let (value, error) =
                    patches.contact(i as u32, j as u32).map_or_else(|| exchange(i as u32, j as u32), |area| (area, 0.0));
                (value > 0.0 || error > 0.0).then_some((j as u32, value.max(0.0), error))
            };
            others.filter_map(entry).collect::<Vec<_>>()
        });
        upper.extend(batch.collect::<Vec<_>>());
        if !watch(upper.len(), n) {
            return Err(Cancelled);
        }
    }

    // Both halves, in rows.
    let mut rows: Vec<Vec<(u32, f64, f64)>> = vec![Vec::new(); n];
    for (i, row) in upper.iter().enumerate() {
        for (j, value, error) in row {
            rows[*j as usize].extend((i as u32 != *j).then_some((i as u32, *value, *error)));
        }
        rows[i].extend_from_slice(row);
    }
    let mut begins = vec![0];
    let (mut columns, mut values, mut errors) = (Vec::new(), Vec::new(), Vec::new());
    for (row, patch) in rows.iter().zip(&patches.patches) {
        for (j, value, error) in row {
            columns.push(*j);
            values.push((value / patch.area) as f32);
            errors.push((error / patch.area) as f32);
        }
        begins.push(columns.len());
    }
    let mut f = FormFactors::new(Matrix { rows: Rows::new((n, n), begins, columns, values), errors });
    if !probe(scene, patches, PROBES, |_| true) {
        f.losses_are_measured = false;
        f.escaped = (0..n).map(|i| (1.0 - f.row_sum(i)).max(0.0)).collect();
    }
    Ok(f)
}

/// A_i F_ij where nothing stands between.
fn clear_exchange(patches: &Patches, polygons: &[Option<ArrayVec<DVec3, 4>>], i: u32, j: u32) -> f64 {
    let normal = |k: u32| patches.get(k).n;
    match (&polygons[i as usize], &polygons[j as usize]) {
        (Some(a), Some(b)) => polygon::exchange(a, normal(i), b, normal(j)),
        (Some(polygon), None) => to_polygon(patches, j, polygon),
        (None, Some(polygon)) => to_polygon(patches, i, polygon),
        (None, None) => area::exchange(patches, i, j, None).value,
    }
}

/// ∫ F_dA→polygon dA over the round patch i, cut until its pieces are smaller than they are far away.
fn to_polygon(patches: &Patches, i: u32, polygon: &[DVec3]) -> f64 {
    let (span, chart) = patches.geometry(i);
    let middle = polygon.iter().sum::<DVec3>() / polygon.len() as f64;
    let radius = polygon.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
    let n = (polygon[1] - polygon[0]).cross(polygon[2] - polygon[0]).normalize_or(DVec3::Z);
    integrate_to(
        chart,
        *span,
        patches.get(i).side.sign(),
        &|p| ((p - middle).length() - radius).max((p - middle).dot(n).abs()),
        polygon,
        9,
    )
}

fn integrate_to(chart: &Chart, span: Span, sign: f64, distance: &impl Fn(DVec3) -> f64, polygon: &[DVec3], depth: u32) -> f64 {
    let corners = span.corners().map(|st| chart.point(st));
    let middle = chart.point(span.middle(chart));
    let reach = corners.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
    // Until the shape is nearly flat, too: its horizon cuts across the polygon.
    if depth > 0 && (reach > 0.5 * distance(middle) || span.size.max_element() > 1.0 / 16.0) {
        return span.quarters(false).into_iter().map(|q| integrate_to(chart, q, sign, distance, polygon, depth - 1)).sum();
    }
    let mut sum = 0.0;
    for (x, wx) in gauss(3) {
        for (y, wy) in gauss(3) {
            let st = span.global(DVec2::new(*x, *y));
            sum += wx * wy * chart.stretch(st) * from_point(chart.point(st), chart.normal(st) * sign, polygon);
        }
    }
    sum * (span.size.x * span.size.y).abs()
}
