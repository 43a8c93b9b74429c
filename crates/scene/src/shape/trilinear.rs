//! The trilinear interpolant of a voxel, and where rays meet its zero set.
//!
//! ```text
//! f(o + t d) = c0 + c1 t + c2 t² + c3 t³
//! ```
//!
//! Roots are bracketed between the extrema of the cubic, where it is monotonic, and refined by Newton's method.

use glam::DVec3;

/// The interpolant within a voxel, corners x fastest, in coordinates [0, 1]³.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trilinear(pub [f64; 8]);

impl Trilinear {
    /// f(p).
    #[inline]
    pub fn at(&self, p: DVec3) -> f64 {
        let s = &self.0;
        let mix = |a: f64, b: f64, t: f64| a * (1.0 - t) + b * t;
        let row = |i: usize| mix(s[i], s[i + 1], p.x);
        let (a, b, c, d) = (row(0), row(2), row(4), row(6));
        mix(mix(a, b, p.y), mix(c, d, p.y), p.z)
    }

    /// ∇f(p).
    pub fn gradient(&self, p: DVec3) -> DVec3 {
        let s = &self.0;
        let mix = |a: f64, b: f64, t: f64| a * (1.0 - t) + b * t;
        let along = |stride: usize, others: [usize; 2], u: f64, v: f64| {
            let d = |i: usize| s[i + stride] - s[i];
            mix(mix(d(0), d(others[0]), u), mix(d(others[1]), d(others[0] + others[1]), u), v)
        };
        DVec3::new(along(1, [2, 4], p.y, p.z), along(2, [1, 4], p.x, p.z), along(4, [1, 2], p.x, p.y))
    }

    /// f(o + t d) as a polynomial in t: the product of linear functions, expanded.
    #[inline]
    fn along(&self, o: DVec3, d: DVec3) -> Cubic {
        let s = &self.0;
        // f = Σ k_m over the monomials 1, x, y, xy, z, xz, yz, xyz.
        let k = [
            s[0],
            s[1] - s[0],
            s[2] - s[0],
            s[3] - s[2] - s[1] + s[0],
            s[4] - s[0],
            s[5] - s[4] - s[1] + s[0],
            s[6] - s[4] - s[2] + s[0],
            s[7] - s[6] - s[5] + s[4] - s[3] + s[2] + s[1] - s[0],
        ];
        // As x (p + q z) with p, q polynomials of the plane: first in x, then y, then z.
        let times = |c: [f64; 4], o: f64, d: f64| [c[0] * o, c[1] * o + c[0] * d, c[2] * o + c[1] * d, c[3] * o + c[2] * d];
        let plus = |a: [f64; 4], b: [f64; 4]| [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]];
        let constant = |c: f64| [c, 0.0, 0.0, 0.0];
        let in_x = |i: usize| plus(constant(k[i]), times(constant(k[i + 1]), o.x, d.x));
        let in_xy = |i: usize| plus(in_x(i), times(in_x(i + 2), o.y, d.y));
        Cubic(plus(in_xy(0), times(in_xy(4), o.z, d.z)))
    }

    /// The first t in [`t0`, `t1`] at which o + t d meets f = 0, given the values of f at both ends; `None` where the sign does not change.
    #[inline]
    pub fn root(&self, o: DVec3, d: DVec3, (t0, f0): (f64, f64), (t1, f1): (f64, f64)) -> Option<f64> {
        let cubic = self.along(o + d * t0, d);
        let length = t1 - t0;

        // The pieces between the extrema are monotonic: at most one root in each.
        let mut ends = [(0.0, f0), (0.0, f0), (0.0, f0), (length, f1)];
        let mut count = 1;
        for t in cubic.extrema() {
            if t > 0.0 && t < length {
                ends[count] = (t, cubic.at(t));
                count += 1;
            }
        }
        ends[count] = (length, f1);
        for pair in ends[..=count].windows(2) {
            let [(a, fa), (b, fb)] = [pair[0], pair[1]];
            if (fa >= 0.0) != (fb >= 0.0) {
                return Some(t0 + cubic.bisect(a, b, fa >= 0.0));
            }
        }
        None
    }
}

/// c0 + c1 t + c2 t² + c3 t³.
struct Cubic([f64; 4]);

impl Cubic {
    fn at(&self, t: f64) -> f64 {
        let [c0, c1, c2, c3] = self.0;
        ((c3 * t + c2) * t + c1) * t + c0
    }

    fn slope(&self, t: f64) -> f64 {
        let [_, c1, c2, c3] = self.0;
        (3.0 * c3 * t + 2.0 * c2) * t + c1
    }

    /// Where the slope vanishes, in order; NaN where it does not.
    fn extrema(&self) -> [f64; 2] {
        let [_, c1, c2, c3] = self.0;
        let q = -(c2 + (c2 * c2 - 3.0 * c1 * c3).sqrt().copysign(c2));
        let (a, b) = (q / (3.0 * c3), c1 / q);
        if a <= b { [a, b] } else { [b, a] }
    }

    /// The root between `a` and `b`, where the sign is `positive` at a only: Newton's method, by halves where it strays.
    fn bisect(&self, mut a: f64, mut b: f64, positive: bool) -> f64 {
        let mut t = 0.5 * (a + b);
        for _ in 0..64 {
            let f = self.at(t);
            if (f >= 0.0) == positive {
                a = t
            } else {
                b = t
            }
            let newton = t - f / self.slope(t);
            let next = if newton > a && newton < b { newton } else { 0.5 * (a + b) };
            if (next - t).abs() <= 1e-12 * t.abs() {
                return next;
            }
            t = next;
        }
        t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIELD: Trilinear = Trilinear([0.3, -0.7, 0.9, 0.2, -0.4, 1.1, -0.8, 0.6]);

    #[test]
    fn the_cubic_is_the_field_along_the_ray() {
        let (o, d) = (DVec3::new(0.1, 0.8, -0.2), DVec3::new(0.7, -0.5, 1.3));
        let cubic = FIELD.along(o, d);
        for t in [0.0, 0.3, 0.9] {
            assert!((cubic.at(t) - FIELD.at(o + d * t)).abs() < 1e-14);
            let h = 1e-5;
            let slope = (FIELD.at(o + d * (t + h)) - FIELD.at(o + d * (t - h))) / (2.0 * h);
            assert!((FIELD.gradient(o + d * t).dot(d) - slope).abs() < 1e-9);
            assert!((cubic.slope(t) - slope).abs() < 1e-9);
        }
    }

    /// Three roots in one voxel: the first is found, and where the ends have one sign a pair between them is.
    #[test]
    fn the_first_root_is_found() {
        // f = (x - 1/4)(y - 1/2)(z - 3/4) along the diagonal.
        let product =
            Trilinear(std::array::from_fn(|c| ((c & 1) as f64 - 0.25) * ((c >> 1 & 1) as f64 - 0.5) * ((c >> 2) as f64 - 0.75)));
        let root = |t0: f64, t1: f64| {
            product.root(DVec3::ZERO, DVec3::ONE, (t0, product.at(DVec3::splat(t0))), (t1, product.at(DVec3::splat(t1))))
        };
        for (t0, t1, expected) in [(0.0, 1.0, 0.25), (0.3, 1.0, 0.5), (0.6, 1.0, 0.75), (0.0, 0.6, 0.25), (0.3, 0.8, 0.5)] {
            assert!((root(t0, t1).expect("a root") - expected).abs() < 1e-10, "{t0} to {t1}");
        }
        assert_eq!(root(0.8, 1.0), None);
        assert_eq!(root(0.3, 0.45), None);
    }
}
