//! The exchange of two patches that something may stand between, by rays.
//!
//! ```text
//! F_r = mean(V g) + β_r (F_clear - mean(g)),    g the integrand G/π over the density of the pair of points
//! ```
//!
//! With β = 1 it is F_clear minus the sampled blocked part of ∬ G/π, with β = 0 the sampled part that is not blocked. Both are without
//! bias, and so is every mixture whose β does not know the samples it is applied to: β_r is the regression of V g on g over the other
//! scramblings. A pair that no ray finds blocked has F_clear exactly, one that none finds open exactly 0.
//! F_clear times the mean of V is another thing: it is biased wherever V goes with g.

use super::pairs::Pairs;
use super::tally::REPLICATES;
use super::visible::Between;
use crate::patch::{PatchPoint, Patches};
use arrayvec::ArrayVec;
use etendue_numerics::warp::SphericalTriangle;
use etendue_numerics::{Net4, Vec2};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

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
pub(super) fn blocked(
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
pub(crate) fn by_points(patches: &Patches, x: &PatchPoint, i: u32, j: u32, u: Vec2) -> Option<(PatchPoint, f64)> {
    let y = patches.sample(j, u);
    let d = y.p - x.p;
    let (r2, cos_x, cos_y) = (d.length_squared(), d.dot(x.n), -d.dot(y.n));
    let areas = patches.get(i).area * patches.get(j).area * x.weight * y.weight;
    (cos_x > 0.0 && cos_y > 0.0).then(|| (y, areas * cos_x * cos_y / (PI * r2 * r2)))
}

/// y uniform in the solid angle Ω of patch j as seen from x; g = A_i Ω cosθx / π, m²: bounded where G is not.
pub(crate) fn by_solid_angle(
    patches: &Patches,
    x: &PatchPoint,
    i: u32,
    j: u32,
    polygon: &[DVec3],
    u: Vec2,
) -> Option<(PatchPoint, f64)> {
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
