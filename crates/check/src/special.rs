//! The distribution functions behind p-values: chi-square, normal, Student.
//!
//! | function | definition |
//! | --- | --- |
//! | [`chi_square_p`]`(x, k)` | Q(k/2, x/2), the regularised upper incomplete gamma function |
//! | [`normal_p`]`(z)` | P(\|Z\| ≥ \|z\|) = Q(1/2, z²/2) = erfc(\|z\|/√2) |
//! | [`student_p`]`(t, k)` | P(\|T\| ≥ \|t\|) = I_x(k/2, 1/2), x = k/(k + t²), the regularised incomplete beta function |
//!
//! Series and continued fractions as in [Abramowitz, Stegun 1964, 6.5.29, 6.5.31, 26.5.8]; relative error below 1e-9 where the value is above 1e-250.

use std::f64::consts::PI;

/// Terms after which a series or fraction is taken as it is; enough for arguments up to about 10⁸.
const TERMS: usize = 100_000;
/// Relative size of a term that no longer counts.
const SMALL: f64 = 1e-15;
/// Stands for zero in the denominators of continued fractions [Thompson, Barnett 1986].
const TINY: f64 = 1e-300;

/// ln Γ(x), x > 0: Stirling's series after shifting x above 15; relative error about 1e-14.
pub fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut shift) = (x, 0.0);
    while x < 15.0 {
        shift += x.ln();
        x += 1.0;
    }
    let (i, i2) = (1.0 / x, 1.0 / (x * x));
    let series = i * (1.0 / 12.0 - i2 * (1.0 / 360.0 - i2 * (1.0 / 1260.0 - i2 * (1.0 / 1680.0 - i2 / 1188.0))));
    (x - 0.5) * x.ln() - x + 0.5 * (2.0 * PI).ln() + series - shift
}

/// Q(a, x) = Γ(a, x)/Γ(a), a > 0, x ≥ 0.
fn gamma_q(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        // P(a, x) = front · Σ xⁿ / (a (a+1) … (a+n))
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for n in 1..TERMS {
            term *= x / (a + n as f64);
            sum += term;
            if term < sum * SMALL {
                break;
            }
        }
        (1.0 - front * sum).max(0.0)
    } else {
        let b = x + 1.0 - a;
        front * fraction(b, |n| (-n * (n - a), b + 2.0 * n)).recip()
    }
}

/// b₀ + a₁/(b₁ + a₂/(b₂ + …)) with (aₙ, bₙ) = `terms`(n), by the modified Lentz rule.
fn fraction(b0: f64, terms: impl Fn(f64) -> (f64, f64)) -> f64 {
    let away_from_zero = |x: f64| if x.abs() < TINY { TINY } else { x };
    let mut value = away_from_zero(b0);
    let (mut c, mut d) = (value, 0.0);
    for n in 1..TERMS {
        let (a, b) = terms(n as f64);
        d = 1.0 / away_from_zero(b + a * d);
        c = away_from_zero(b + a / c);
        value *= c * d;
        if (c * d - 1.0).abs() < SMALL {
            break;
        }
    }
    value
}

/// I_x(a, b), the regularised incomplete beta function.
fn beta_i(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta_i(b, a, 1.0 - x);
    }
    let front = (ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * (1.0 - x).ln()).exp() / a;
    let value = fraction(1.0, |n| {
        let m = (n / 2.0).floor();
        let numerator = if n % 2.0 == 1.0 {
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        } else {
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        };
        (numerator, 1.0)
    });
    front / value
}

/// P(X² ≥ x) for k degrees of freedom; 1 for k = 0.
pub fn chi_square_p(x: f64, k: f64) -> f64 {
    if k <= 0.0 { 1.0 } else { gamma_q(0.5 * k, 0.5 * x) }
}

/// Two-sided: P(|Z| ≥ |z|) for a standard normal Z.
pub fn normal_p(z: f64) -> f64 {
    gamma_q(0.5, 0.5 * z * z)
}

/// Two-sided: P(|T| ≥ |t|) for Student's T with k degrees of freedom; the normal one for infinite k.
pub fn student_p(t: f64, k: f64) -> f64 {
    if k.is_finite() { beta_i(0.5 * k, 0.5, k / (k + t * t)) } else { normal_p(t) }
}

/// The t with P(|T| ≥ t) = `alpha` for k degrees of freedom (normal for infinite k): half the width of a confidence interval in standard errors.
pub fn student_quantile(alpha: f64, k: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while student_p(high, k) > alpha && high < 1e12 {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if student_p(middle, k) > alpha { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-9 * b.abs(), "{a} is not {b}");
    }

    #[test]
    fn closed_forms_hold() {
        close(ln_gamma(0.5), 0.5 * PI.ln());
        close(ln_gamma(10.0), 362_880f64.ln());
        // Two degrees of freedom: e^(-x/2). Four: (1 + x/2) e^(-x/2).
        for x in [0.01, 1.0, 5.0, 40.0, 900.0] {
            close(chi_square_p(x, 2.0), (-0.5 * x).exp());
            close(chi_square_p(x, 4.0), (1.0 + 0.5 * x) * (-0.5 * x).exp());
        }
        // Student, k = 1: 1 - (2/π) atan t; k = 2: 1 - t/√(2 + t²).
        for t in [0.1f64, 1.0, 3.0, 30.0] {
            close(student_p(t, 1.0), (2.0 / PI) * (1.0 / t).atan());
            close(student_p(t, 2.0), 1.0 - t / (2.0 + t * t).sqrt());
        }
        // Even and odd: the χ² median of many degrees of freedom sits near k - 2/3.
        assert!((chi_square_p(9_999.333_4, 10_000.0) - 0.5).abs() < 1e-5);
    }

    #[test]
    fn published_values_hold() {
        // Tables of the normal and of Student's distribution.
        assert!((normal_p(1.959_963_985) - 0.05).abs() < 1e-9);
        assert!((normal_p(5.0) - 5.733_031_4e-7).abs() < 1e-13);
        assert!((student_quantile(0.05, 10.0) - 2.228_138_85).abs() < 1e-7);
        assert!((student_quantile(0.05, f64::INFINITY) - 1.959_963_985).abs() < 1e-7);
        assert!((student_p(1e9, 1e7) - 0.0).abs() < 1e-300);
    }
}
