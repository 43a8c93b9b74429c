//! Gauss-Legendre quadrature on [0, 1]: ∫ f dx ≈ Σ w f(x), exact for polynomials up to degree 2 n - 1.

use std::sync::OnceLock;

/// The most points there are.
const MOST: usize = 32;

/// `n` points with their weights, 1 ≤ n ≤ 32.
pub(crate) fn gauss(n: usize) -> &'static [(f64, f64)] {
    static RULES: OnceLock<Vec<Vec<(f64, f64)>>> = OnceLock::new();
    &RULES.get_or_init(|| (0..=MOST).map(rule).collect())[n.min(MOST)]
}

/// The zeros of the Legendre polynomial P_n by Newton's method, w = 2 / ((1 - x²) P_n'(x)²), moved from [-1, 1] to [0, 1].
fn rule(n: usize) -> Vec<(f64, f64)> {
    let mut points: Vec<_> = (0..n)
        .map(|i| {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..16 {
                // (k + 1) P_{k+1} = (2 k + 1) x P_k - k P_{k-1}
                let (mut p, mut before) = (x, 1.0);
                for k in 1..n {
                    let k = k as f64;
                    (p, before) = (((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0), p);
                }
                slope = n as f64 * (x * p - before) / (x * x - 1.0);
                x -= p / slope;
            }
            (0.5 * (x + 1.0), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect();
    points.reverse();
    points
}

#[cfg(test)]
mod tests {
    use super::gauss;

    #[test]
    fn polynomials_are_exact() {
        for n in 1..=32 {
            for degree in 0..2 * n as i32 {
                let sum: f64 = gauss(n).iter().map(|(x, w)| w * x.powi(degree)).sum();
                assert!((sum - 1.0 / f64::from(degree + 1)).abs() < 1e-14, "{n} points, degree {degree}: {sum}");
            }
        }
    }
}
