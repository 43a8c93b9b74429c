//! Closed forms between polygons that nothing stands between.
//!
//! ```text
//! from a point      F_dA→j = 1/2π Σ_k Θ_k (Γ_k · n),   Γ_k the unit vector along r_k × r_k+1, Θ_k the angle between    [Lambert 1760]
//! between two       A_i F_ij = 1/2π ∮_i ∮_j ln r dl_j · dl_i                                                          [Sparrow 1963]
//! inner integral    ∫ ln r ds = [ z ln r - z + h atan(z/h) ],  z along the edge from the foot of the perpendicular, h its length
//! ```
//!
//! The double contour integral falls into pairs of edges. Its inner integral is closed, its outer one a Gauss-Legendre quadrature: of few points
//! where the edges are far apart, else adaptive to 1e-11 of the product of their lengths. Edges in common make it singular, but only like
//! s ln s. All of it holds for polygons in front of each other: what lies behind the other's plane is cut off first.
//!
//! Polygons are convex, counter-clockwise as seen from their front.

use crate::quadrature::gauss;
use arrayvec::ArrayVec;
use glam::DVec3;
use std::f64::consts::TAU;

/// A polygon; a quadrilateral has five corners at most when a plane has cut it.
pub type Polygon = ArrayVec<DVec3, 8>;

/// Heights above a plane, in diameters of the polygon, that count as none.
const ON_PLANE: f64 = 1e-9;

/// The part of a polygon above the plane through `p` with normal `n`; empty where nothing rises above it.
pub fn above(polygon: &[DVec3], p: DVec3, n: DVec3) -> Polygon {
    let size = polygon.iter().map(|q| (*q - polygon[0]).abs().max_element()).fold(0.0, f64::max);
    let height = |q: DVec3| {
        let h = (q - p).dot(n);
        if h.abs() <= ON_PLANE * (size + (q - p).abs().max_element()) { 0.0 } else { h }
    };
    let mut kept = Polygon::new();
    if polygon.iter().all(|q| height(*q) <= 0.0) {
        return kept;
    }
    for (k, a) in polygon.iter().enumerate() {
        let b = polygon[(k + 1) % polygon.len()];
        let (ha, hb) = (height(*a), height(b));
        if ha >= 0.0 {
            kept.push(*a);
        }
        if ha * hb < 0.0 {
            kept.push(a.lerp(b, ha / (ha - hb)));
        }
    }
    kept
}

/// F from a surface element at `x` with unit normal `n` to a polygon, of which only the part above the element's horizon counts. Zero from
/// behind the polygon.
pub fn from_point(x: DVec3, n: DVec3, polygon: &[DVec3]) -> f64 {
    let polygon = above(polygon, x, n);
    let mut sum = 0.0;
    for (k, a) in polygon.iter().enumerate() {
        let (a, b) = (a - x, polygon[(k + 1) % polygon.len()] - x);
        let cross = a.cross(b);
        let sine = cross.length();
        if sine > 0.0 {
            sum += cross.dot(n) / sine * sine.atan2(a.dot(b));
        }
    }
    // Counter-clockwise from its front, a polygon runs clockwise as seen from the element.
    (-sum / TAU).max(0.0)
}

/// A_a F_ab between polygons with unit normals, each cut off at the other's plane, m².
pub fn exchange(a: &[DVec3], na: DVec3, b: &[DVec3], nb: DVec3) -> f64 {
    let (a, b) = (above(a, b[0], nb), above(b, a[0], na));
    if a.len() < 3 || b.len() < 3 {
        return 0.0;
    }
    let edges = |p: &Polygon| -> Vec<[DVec3; 2]> { (0..p.len()).map(|k| [p[k], p[(k + 1) % p.len()]]).collect() };
    // ln(r / r0) differs from ln r by a constant, of which the contours take nothing; it keeps the sum's terms small.
    let scale = a[0].distance(b[0]).max(a[0].distance(a[1]));
    let of_b = edges(&b);
    let mut sum = 0.0;
    for p in edges(&a) {
        for q in &of_b {
            sum += edge_pair(p.map(|x| x / scale), q.map(|x| x / scale));
        }
    }
    (scale * scale * sum / TAU).max(0.0)
}

/// ∫∫ ln r dl_q · dl_p over two edges.
fn edge_pair(p: [DVec3; 2], q: [DVec3; 2]) -> f64 {
    let (ep, eq) = (p[1] - p[0], q[1] - q[0]);
    let along = ep.dot(eq);
    let (lp, lq) = (ep.length(), eq.length());
    if along.abs() <= 1e-14 * lp * lq || lp == 0.0 || lq == 0.0 {
        return 0.0;
    }
    let inner = |s: f64| mean_log(p[0] + ep * s, q[0], eq, lq);
    // How far apart the edges are at least, against their lengths.
    let apart = (p[0] + 0.5 * ep).distance(q[0] + 0.5 * eq) - 0.5 * (lp + lq);
    let rule = |n: usize| gauss(n).iter().map(|(s, w)| w * inner(*s)).sum::<f64>();
    let integral = if apart > 4.0 * lp {
        rule(4)
    } else if apart > lp {
        rule(8)
    } else {
        adaptive(&inner, 0.0, 1.0, rule(8), 48)
    };
    along * integral
}

/// ∫ f over [a, b], of which `whole` is an estimate by 8 points.
fn adaptive(f: &impl Fn(f64) -> f64, a: f64, b: f64, whole: f64, depth: u32) -> f64 {
    let m = 0.5 * (a + b);
    let rule = |a: f64, b: f64| (b - a) * gauss(8).iter().map(|(s, w)| w * f(a + (b - a) * s)).sum::<f64>();
    let (left, right) = (rule(a, m), rule(m, b));
    if (left + right - whole).abs() <= 1e-12 * (1.0 + whole.abs()) || depth == 0 {
        return left + right;
    }
    adaptive(f, a, m, left, depth - 1) + adaptive(f, m, b, right, depth - 1)
}

/// The mean of ln r between `x` and the points of an edge of length `l`.
fn mean_log(x: DVec3, q: DVec3, edge: DVec3, l: f64) -> f64 {
    let d = x - q;
    let u = d.dot(edge) / l;
    let h = (d - edge * (u / l)).length();
    let part = |z: f64| {
        let r2 = z * z + h * h;
        if r2 == 0.0 { 0.0 } else { 0.5 * z * r2.ln() - z + h * z.atan2(h) }
    };
    (part(l - u) - part(-u)) / l
}

/// The part of `a` that lies over `b`, both in one plane with normal `n`, `a` counter-clockwise about it, `b` either way round.
pub(crate) fn common(a: &[DVec3], b: &[DVec3], n: DVec3) -> Polygon {
    let turn = (b[1] - b[0]).cross(b[2] - b[1]).dot(n).signum();
    let mut kept: Polygon = a.iter().copied().collect();
    for (k, p) in b.iter().enumerate() {
        let edge = b[(k + 1) % b.len()] - *p;
        if kept.len() < 3 {
            break;
        }
        kept = above(&kept, *p, n.cross(edge).normalize_or_zero() * turn);
    }
    kept
}

/// Area of a polygon, m².
pub(crate) fn area(polygon: &[DVec3]) -> f64 {
    let fan = |k: usize| (polygon[k] - polygon[0]).cross(polygon[k + 1] - polygon[0]);
    if polygon.len() < 3 { 0.0 } else { 0.5 * (1..polygon.len() - 1).map(fan).sum::<DVec3>().length() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// The rectangle [x0, x1] x [y0, y1] at height z, facing up or down.
    fn level([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], z: f64, up: bool) -> ([DVec3; 4], DVec3) {
        let mut p = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| DVec3::new(x, y, z));
        if !up {
            p.reverse();
        }
        (p, if up { DVec3::Z } else { DVec3::NEG_Z })
    }

    /// The rectangle [y0, y1] x [z0, z1] in the plane x, facing +x.
    fn upright(x: f64, [y0, y1]: [f64; 2], [z0, z1]: [f64; 2]) -> ([DVec3; 4], DVec3) {
        ([(y0, z0), (y1, z0), (y1, z1), (y0, z1)].map(|(y, z)| DVec3::new(x, y, z)), DVec3::X)
    }

    /// Σ ± g over the sixteen corners of two rectangles, by the area of the first, [x1, x2] x [y1, y2].
    fn over_corners(x: [f64; 2], y: [f64; 2], eta: [f64; 2], xi: [f64; 2], g: impl Fn(f64, f64, f64, f64) -> f64) -> f64 {
        let mut sum = 0.0;
        for (i, x) in x.iter().enumerate() {
            for (j, y) in y.iter().enumerate() {
                for (k, eta) in eta.iter().enumerate() {
                    for (l, xi) in xi.iter().enumerate() {
                        let sign = if (i + j + k + l) % 2 == 0 { 1.0 } else { -1.0 };
                        sum += sign * g(*x, *y, *eta, *xi);
                    }
                }
            }
        }
        sum / ((x[1] - x[0]) * (y[1] - y[0]))
    }

    /// F from [x1, x2] x [y1, y2] at z = 0 to [ξ1, ξ2] x [η1, η2] at height z, by sixteen corners.
    fn parallel(x: [f64; 2], y: [f64; 2], xi: [f64; 2], eta: [f64; 2], z: f64) -> f64 {
        let g = |u: f64, v: f64| {
            let (p, q) = ((u * u + z * z).sqrt(), (v * v + z * z).sqrt());
            (v * p * (v / p).atan() + u * q * (u / q).atan() - 0.5 * z * z * (u * u + v * v + z * z).ln()) / TAU
        };
        over_corners(x, y, eta, xi, |x, y, eta, xi| g(x - xi, y - eta))
    }

    /// F from the rectangle [x1, x2] x [y1, y2] of the floor to [y, ξ] = [η1, η2] x [ξ1, ξ2] of the wall x = 0, ξ its height.
    fn perpendicular(x: [f64; 2], y: [f64; 2], eta: [f64; 2], xi: [f64; 2]) -> f64 {
        let g = |x: f64, y: f64, eta: f64, xi: f64| {
            let (c, d2) = ((x * x + xi * xi).sqrt(), (y - eta).powi(2));
            let k = (y - eta) / if c == 0.0 { f64::INFINITY } else { c };
            let r2 = c * c + d2;
            let log = if r2 == 0.0 { 0.0 } else { 0.25 * (c * c - d2) * r2.ln() };
            ((y - eta) * c * k.atan() - log) / TAU
        };
        over_corners(x, y, eta, xi, g)
    }

    #[test]
    fn parallel_rectangles() {
        let unit = 2.0 / PI * ((2.0 / 3f64.sqrt()).ln() + 2.0 * 2f64.sqrt() * (1.0 / 2f64.sqrt()).atan() - PI / 2.0);
        assert!((parallel([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], [0.0, 1.0], 1.0) - unit).abs() < 1e-12, "the corners' sum");
        for (x, y, xi, eta, z) in [
            ([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], [0.0, 1.0], 1.0),
            ([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], [0.0, 1.0], 0.01),
            ([0.0, 2.0], [0.0, 0.5], [1.0, 1.5], [0.3, 3.0], 0.7),
            ([0.0, 1.0], [0.0, 1.0], [1.0, 2.0], [0.0, 1.0], 0.2),
            ([0.0, 1.0], [0.0, 1.0], [5.0, 6.0], [-7.0, -6.0], 3.0),
            ([0.0, 0.01], [0.0, 0.02], [0.5, 0.51], [0.4, 0.41], 1.0),
        ] {
            let ((a, na), (b, nb)) = (level(x, y, 0.0, true), level(xi, eta, z, false));
            let found = exchange(&a, na, &b, nb) / area(&a);
            let exact = parallel(x, y, xi, eta, z);
            assert!((found - exact).abs() < 1e-9, "{x:?} {y:?} {xi:?} {eta:?} {z}: {found} for {exact}");
            let back = exchange(&b, nb, &a, na) / area(&a);
            assert!((found - back).abs() < 1e-9, "reciprocity");
            // From many points, by Lambert's formula.
            let points = gauss(16).iter().flat_map(|(s, v)| gauss(16).iter().map(move |(t, w)| (s, t, v * w)));
            let at = |s: f64, t: f64| DVec3::new(x[0] + (x[1] - x[0]) * s, y[0] + (y[1] - y[0]) * t, 0.0);
            let mean: f64 = points.map(|(s, t, w)| w * from_point(at(*s, *t), na, &b)).sum();
            assert!((mean - exact).abs() < 2e-3 * exact, "{mean} for {exact}");
        }
    }

    #[test]
    fn perpendicular_rectangles() {
        let adjacent = 1.0 / PI * (0.25 * 0.75f64.ln() + PI / 2.0 - 2f64.sqrt() * (1.0 / 2f64.sqrt()).atan());
        assert!((perpendicular([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], [0.0, 1.0]) - adjacent).abs() < 1e-12, "the corners' sum");
        for (x, y, eta, xi) in [
            ([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], [0.0, 1.0]),
            ([0.0, 3.0], [0.0, 1.0], [0.0, 1.0], [0.0, 0.2]),
            ([0.0, 1.0], [0.0, 1.0], [1.0, 2.0], [0.0, 1.0]),
            ([0.0, 1.0], [0.0, 1.0], [0.5, 2.0], [0.0, 1.0]),
            ([0.001, 1.0], [0.0, 1.0], [0.0, 1.0], [0.0, 1.0]),
            ([0.5, 1.0], [0.0, 2.0], [3.0, 4.0], [0.1, 0.6]),
        ] {
            let ((a, na), (b, nb)) = (level(x, y, 0.0, true), upright(0.0, eta, xi));
            let found = exchange(&a, na, &b, nb) / area(&a);
            let exact = perpendicular(x, y, eta, xi);
            assert!((found - exact).abs() < 1e-9, "{x:?} {y:?} {eta:?} {xi:?}: {found} for {exact}");
        }
    }

    /// Two sides of a wedge: F = 1 - sin(α/2) for endless strips; here by the crossed strings of long ones, to their ends' share.
    #[test]
    fn what_is_behind_does_not_count() {
        let ((a, na), (b, nb)) = (level([0.0, 1.0], [0.0, 1.0], 0.0, true), upright(0.0, [0.0, 1.0], [-1.0, 1.0]));
        let whole = exchange(&a, na, &b, nb);
        let upper = upright(0.0, [0.0, 1.0], [0.0, 1.0]).0;
        assert!((whole - exchange(&a, na, &upper, nb)).abs() < 1e-12, "the half below the floor");
        let (back, nback) = level([0.0, 1.0], [0.0, 1.0], 1.0, true);
        assert_eq!(exchange(&a, na, &back, nback), 0.0, "face to back");
        assert_eq!(exchange(&a, na, &a, na), 0.0, "in one plane");
        assert_eq!(from_point(DVec3::new(0.5, 0.5, -1.0), DVec3::Z, &a), 0.0, "from behind");
    }

    #[test]
    fn overlaps_are_cut_out() {
        let (a, n) = level([0.0, 2.0], [0.0, 2.0], 0.0, true);
        for up in [true, false] {
            let (b, _) = level([1.0, 3.0], [-1.0, 0.5], 0.0, up);
            assert!((area(&common(&a, &b, n)) - 0.5).abs() < 1e-12);
            let (c, _) = level([2.0, 3.0], [0.0, 2.0], 0.0, up);
            assert!(area(&common(&a, &c, n)) < 1e-9, "an edge in common");
        }
    }
}
