//! Integrals over rectangles and spheres in f64, to compare densities and estimators with.
//!
//! Each rectangle is integrated by the product of two four-point Gauss-Legendre rules and by that of two five-point Lobatto rules; where the
//! two disagree by more than the tolerance, its quarters are integrated in the same way, each to half the tolerance. Both rules have
//! degree 7 and errors of opposite sign, in the ratio 4 : -5, so that (5 G + 4 L)/9 is better than either. For a jump at any place between the
//! nodes the rules give different values: no jump is overlooked, as it is by two levels of a single rule. A feature smaller
//! than the starting grid can be missed: whoever knows where it lies starts from smaller rectangles, as the chi-square test does.

use crate::domain::Rect;
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// Nodes and weights of the four-point Gauss-Legendre rule on [0, 1].
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Nodes and weights of the five-point Lobatto rule on [0, 1].
const LOBATTO: [(f64, f64); 5] = [
    (0.0, 1.0 / 20.0),
    (0.172_673_164_646_011_43, 49.0 / 180.0),
    (0.5, 16.0 / 45.0),
    (0.827_326_835_353_988_6, 49.0 / 180.0),
    (1.0, 1.0 / 20.0),
];

/// The product of a rule with itself over `rect`.
fn product(rule: &[(f64, f64)], rect: &Rect, f: &impl Fn(f64, f64) -> f64) -> f64 {
    let [dx, dy] = rect.size();
    let mut sum = 0.0;
    for (x, wx) in rule {
        for (y, wy) in rule {
            sum += wx * wy * f(rect.min[0] + dx * x, rect.min[1] + dy * y);
        }
    }
    sum * dx * dy
}

/// ∫ f over `rect`, to about `tolerance(rough value)`, halving at most `depth` times.
pub(crate) fn adaptive(rect: &Rect, f: &impl Fn(f64, f64) -> f64, depth: u32, tolerance: impl Fn(f64) -> f64) -> f64 {
    fn refine(rect: &Rect, f: &impl Fn(f64, f64) -> f64, depth: u32, tolerance: &dyn Fn(f64) -> f64) -> f64 {
        let (g, l) = (product(&GAUSS, rect, f), product(&LOBATTO, rect, f));
        let value = (5.0 * g + 4.0 * l) / 9.0;
        let tolerance = tolerance(value);
        if depth == 0 || (g - l).abs() <= tolerance {
            return value;
        }
        rect.quarters().iter().map(|q| refine(q, f, depth - 1, &|_| 0.5 * tolerance)).sum()
    }
    refine(rect, f, depth, &tolerance)
}

/// ∫∫ f(x, y) dx dy over the rectangle [x₀, x₁] × [y₀, y₁], started on an 8 × 8 grid; error about 1e-7 of ∫|f| where f is piecewise smooth.
pub fn integrate_rect(x: [f64; 2], y: [f64; 2], f: impl Fn(f64, f64) -> f64) -> f64 {
    let cells: Vec<Rect> = Rect { min: [x[0], y[0]], max: [x[1], y[1]] }.grid(8, 8).collect();
    let scale: f64 = cells.iter().map(|c| product(&GAUSS, c, &|x, y| f(x, y).abs())).sum();
    cells.iter().map(|c| adaptive(c, &f, 10, |_| 1e-8 * scale + 1e-15)).sum()
}

/// ∫∫ f over the unit square.
pub fn integrate_square(f: impl Fn(f64, f64) -> f64) -> f64 {
    integrate_rect([0.0, 1.0], [0.0, 1.0], f)
}

/// ∫ f(x) dx over [a, b]; error about 1e-10 where f is piecewise smooth.
pub fn integrate_interval(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    fn rule(nodes: &[(f64, f64)], a: f64, b: f64, f: &impl Fn(f64) -> f64) -> f64 {
        nodes.iter().map(|(x, w)| w * f(a + (b - a) * x)).sum::<f64>() * (b - a)
    }
    fn refine(a: f64, b: f64, depth: u32, tolerance: f64, f: &impl Fn(f64) -> f64) -> f64 {
        let (g, l) = (rule(&GAUSS, a, b, f), rule(&LOBATTO, a, b, f));
        if depth == 0 || (g - l).abs() <= tolerance {
            return (5.0 * g + 4.0 * l) / 9.0;
        }
        let m = 0.5 * (a + b);
        refine(a, m, depth - 1, 0.5 * tolerance, f) + refine(m, b, depth - 1, 0.5 * tolerance, f)
    }
    let step = (b - a) / 64.0;
    let edge = |i: u32| if i == 64 { b } else { a + step * f64::from(i) };
    let scale: f64 = (0..64).map(|i| rule(&GAUSS, edge(i), edge(i + 1), &|x| f(x).abs())).sum();
    (0..64).map(|i| refine(edge(i), edge(i + 1), 30, 1e-12 * scale + 1e-300, &f)).sum()
}

/// The unit vector at (θ, φ).
pub(crate) fn spherical(theta: f64, phi: f64) -> DVec3 {
    let ((st, ct), (sp, cp)) = (theta.sin_cos(), phi.sin_cos());
    DVec3::new(st * cp, st * sp, ct)
}

fn integrate_cap(theta: f64, f: impl Fn(Vec3) -> f64) -> f64 {
    integrate_rect([0.0, theta], [0.0, TAU], |t, p| f(spherical(t, p).as_vec3()) * t.sin())
}

/// ∫ f(w) dw over the sphere of directions.
pub fn integrate_sphere(f: impl Fn(Vec3) -> f64) -> f64 {
    integrate_cap(PI, f)
}

/// ∫ f(w) dw over the directions with z ≥ 0. No cosine: bring it along.
pub fn integrate_hemisphere(f: impl Fn(Vec3) -> f64) -> f64 {
    integrate_cap(0.5 * PI, f)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_forms_hold() {
        let close = |a: f64, b: f64, e: f64| assert!((a - b).abs() < e, "{a} is not {b}");
        close(integrate_sphere(|_| 1.0), 4.0 * PI, 1e-6);
        close(integrate_hemisphere(|w| f64::from(w.z)), PI, 1e-6);
        close(integrate_sphere(|w| f64::from(w.z * w.z)), 4.0 * PI / 3.0, 1e-6);
        // A jump along a slanted great circle.
        close(integrate_sphere(|w| f64::from(u8::from(w.dot(Vec3::new(0.36, 0.48, 0.8)) > 0.0))), 2.0 * PI, 1e-4);
        // A lobe of width 0.01: ∫ e^(-(1 - cosθ)/s) = 2π s (1 - e^(-2/s)).
        let axis = Vec3::new(0.48, 0.36, 0.8).as_dvec3();
        close(integrate_sphere(|w| ((w.as_dvec3().dot(axis) - 1.0) / 1e-4).exp()), TAU * 1e-4, 1e-7);
        close(integrate_interval(0.0, 2.0, f64::sqrt), 2f64.powf(1.5) * 2.0 / 3.0, 1e-9);
        close(integrate_square(|x, y| (x + y).exp()), (1f64.exp() - 1.0).powi(2), 1e-9);
    }
}
