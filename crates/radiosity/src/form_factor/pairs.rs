//! `analytic` and `area`: the exchange of each pair of patches by itself.
//!
//! ```text
//! nothing between    F = F_clear
//! else               F_r = mean(V g) + β_r (F_clear - mean(g)),    g the integrand G/π over the density of the pair of points
//! ```
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `samples` | rays a patch, shared among the patches that something may hide from it, in 16 scramblings (`analytic`) | 2^18 |
//! | `seed` | of the scramblings | 0 |
//!
//! F_clear is the closed form between polygons, Lambert's formula between a polygon and points of a round patch, or the double integral between two
//! round ones. With β = 1 it is F_clear minus the sampled blocked part of ∬ G/π, with β = 0 the sampled part that is not blocked. Both are without
//! bias, and so is every mixture whose β does not know the samples it is applied to: β_r is the regression of V g on g over the other
//! scramblings. A pair that no ray finds blocked has F_clear exactly, one that none finds open exactly 0.
//! F_clear times the mean of V is another thing: it is biased wherever V goes with g.
//!
//! Every pair costs time, and rows hold all that is seen: for thousands of patches, not for hundreds of thousands.

use super::hemisphere::probe;
use super::polygon::{self, from_point};
use super::tally::REPLICATES;
use super::visible::Between;
use super::{Cancelled, FormFactors, Matrix, Rows, Watch, area};
use crate::patch::{Chart, PatchPoint, Patches, Span};
use crate::quadrature::gauss;
use arrayvec::ArrayVec;
use etendue_numerics::warp::SphericalTriangle;
use etendue_numerics::{Net4, Vec2};
use etendue_scene::Scene;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::PI;

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
        Self { samples: 1 << 18, seed: 0 }
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
    if !probe(scene, patches) {
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

/// Sums over the samples of a scrambling.
#[derive(Clone, Copy, Default)]
struct Moments {
    g: f64,
    vg: f64,
    gg: f64,
    vgg: f64,
}

impl std::ops::Add for Moments {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self { g: self.g + o.g, vg: self.vg + o.vg, gg: self.gg + o.gg, vgg: self.vgg + o.vgg }
    }
}

/// A_i F_ij of a pair that may be blocked, with its standard error.
fn blocked(
    patches: &Patches,
    polygons: &[Option<ArrayVec<DVec3, 4>>],
    between: &Between,
    method: &Pairs,
    (i, j): (u32, u32),
    clear: f64,
) -> (f64, f64) {
    let each = (method.samples / REPLICATES / patches.len() as u32).max(4).next_power_of_two();
    let near = {
        let ((p, r), (q, s)) = (patches.ball(i), patches.ball(j));
        p.distance(q) < 2.0 * (r + s)
    };
    let target = polygons[j as usize].as_ref().filter(|_| near);
    let mut moments = [Moments::default(); REPLICATES as usize];
    for (r, m) in moments.iter_mut().enumerate() {
        let stream = (u64::from(i) * patches.len() as u64 + u64::from(j)) * u64::from(REPLICATES) + r as u64;
        for [u, v, s, t] in Net4::new(method.seed, stream).take(each as usize) {
            let x = patches.sample(i, Vec2::new(u, v));
            let drawn = match target {
                Some(polygon) => by_solid_angle(patches, &x, i, j, polygon, Vec2::new(s, t)),
                None => by_points(patches, &x, i, j, Vec2::new(s, t)),
            };
            let Some((y, g)) = drawn else { continue };
            let vg = if between.sees((i, &x), (j, &y)) { g } else { 0.0 };
            *m = *m + Moments { g, vg, gg: g * g, vgg: vg * g };
        }
    }

    let all = moments.iter().fold(Moments::default(), |a, b| a + *b);
    let n = f64::from(each);
    let estimate = |m: &Moments| {
        let others = Moments { g: all.g - m.g, vg: all.vg - m.vg, gg: all.gg - m.gg, vgg: all.vgg - m.vgg };
        let count = n * f64::from(REPLICATES - 1);
        let (covariance, variance) = (others.vgg - others.vg * others.g / count, others.gg - others.g * others.g / count);
        // With g the same everywhere the two estimates differ by nothing but V.
        let beta = if variance > 1e-12 * others.gg {
            (covariance / variance).clamp(0.0, 1.0)
        } else {
            f64::from(others.vg > 0.5 * others.g)
        };
        m.vg / n + beta * (clear - m.g / n)
    };
    if all.vg == all.g {
        return (clear, 0.0);
    }
    let estimates = moments.each_ref().map(estimate);
    let r = f64::from(REPLICATES);
    let mean = estimates.iter().sum::<f64>() / r;
    let variance = estimates.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (r * (r - 1.0));
    (mean, variance.sqrt())
}

/// y uniform over patch j; g = A_i A_j G/π, m².
fn by_points(patches: &Patches, x: &PatchPoint, i: u32, j: u32, u: Vec2) -> Option<(PatchPoint, f64)> {
    let y = patches.sample(j, u);
    let d = y.p - x.p;
    let (r2, cos_x, cos_y) = (d.length_squared(), d.dot(x.n), -d.dot(y.n));
    let areas = patches.get(i).area * patches.get(j).area * x.weight * y.weight;
    (cos_x > 0.0 && cos_y > 0.0).then(|| (y, areas * cos_x * cos_y / (PI * r2 * r2)))
}

/// y uniform in the solid angle Ω of patch j as seen from x; g = A_i Ω cosθx / π, m²: bounded where G is not.
fn by_solid_angle(patches: &Patches, x: &PatchPoint, i: u32, j: u32, polygon: &[DVec3], u: Vec2) -> Option<(PatchPoint, f64)> {
    let n = patches.get(j).n;
    let height = (x.p - polygon[0]).dot(n);
    if height <= 0.0 {
        return None;
    }
    let seen = |k: usize| {
        let [a, b, c] = [polygon[0], polygon[k], polygon[k + 1]].map(|p| (p - x.p).as_vec3());
        SphericalTriangle::new(a, b, c)
    };
    let triangles = [seen(1), if polygon.len() > 3 { seen(2) } else { None }];
    let angles = triangles.each_ref().map(|t| t.as_ref().map_or(0.0, |t| t.solid_angle()));
    let total = angles[0] + angles[1];
    let (k, ux) = if u.x * total < angles[0] { (0, u.x * total / angles[0]) } else { (1, (u.x * total - angles[0]) / angles[1]) };
    let w = triangles[k].as_ref()?.sample(Vec2::new(ux.min(0.999_999_9), u.y)).as_dvec3();
    let (cos_x, cos_y) = (w.dot(x.n), -w.dot(n));
    if cos_x <= 0.0 || cos_y <= 0.0 {
        return None;
    }
    let y = PatchPoint { p: x.p + w * (height / cos_y), n, st: DVec2::ZERO, weight: 1.0 };
    Some((y, patches.get(i).area * x.weight * f64::from(total) * cos_x / PI))
}
