//! The error function and its inverse in f32.
//!
//! erf(x) = x P(x²) below 1 and 1 - exp(-Q(x)) above, P and Q fitted by Chebyshev interpolation; absolute error below 2·10⁻⁷.
//! erf⁻¹ by [Giles 2012, "Approximating the erfinv function", single precision]; relative error below 10⁻⁶.

use etendue_numerics::math::{exp, ln};
use std::f32::consts::FRAC_2_SQRT_PI;

/// Σ cₖ xᵏ.
#[inline(always)]
fn polynomial<const N: usize>(c: &[f32; N], x: f32) -> f32 {
    // Horner's scheme, by hand: an iterator may stay a call, which loops over lanes must not hold.
    let (mut sum, mut k) = (0.0, N);
    while k > 0 {
        k -= 1;
        sum = sum * x + c[k];
    }
    sum
}

/// erf(x) for any x.
#[inline(always)]
pub fn erf(x: f32) -> f32 {
    const P: [f32; 7] = [FRAC_2_SQRT_PI, -0.376_126_27, 0.112_835_97, -0.026_854_329, 0.005_189_312, -8.018_855e-4, 7.882_497e-5];
    const Q: [f32; 8] =
        [5.022_605e-4, 1.126_771_3, 0.637_938_4, 0.104_162_7, -0.022_978_953, 0.003_524_585_3, -3.291_969e-4, 1.395_206e-5];
    let a = x.abs();
    if a < 1.0 {
        x * polynomial(&P, x * x)
    } else if a < 4.0 {
        (1.0 - exp(-polynomial(&Q, a))).copysign(x)
    } else {
        1f32.copysign(x)
    }
}

/// erf⁻¹(y), -1 < y < 1.
#[inline(always)]
pub fn erf_inv(y: f32) -> f32 {
    const CENTRAL: [f32; 9] = [
        1.501_409_4,
        0.246_640_72,
        -0.004_177_682,
        -0.001_253_725,
        2.185_808_7e-4,
        -4.391_506_5e-6,
        -3.523_387_7e-6,
        3.432_739_5e-7,
        2.810_226_4e-8,
    ];
    const TAIL: [f32; 9] = [
        2.832_976_8,
        1.001_674,
        0.009_438_87,
        -0.007_622_461_3,
        0.005_739_508,
        -0.003_673_428_4,
        0.001_349_343_2,
        1.009_505_6e-4,
        -2.002_142_6e-4,
    ];
    let w = -ln((1.0 - y) * (1.0 + y));
    if w < 5.0 { y * polynomial(&CENTRAL, w - 2.5) } else { y * polynomial(&TAIL, w.sqrt() - 3.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// erf by its Maclaurin series in f64.
    fn series(x: f64) -> f64 {
        let (mut term, mut sum, mut n) = (x, x, 0.0);
        while term.abs() > 1e-18 {
            n += 1.0;
            term *= -x * x / n;
            sum += term / (2.0 * n + 1.0);
        }
        sum * 2.0 / std::f64::consts::PI.sqrt()
    }

    #[test]
    fn erf_meets_its_series() {
        for i in -450..450 {
            let x = i as f32 / 100.0;
            assert!((f64::from(erf(x)) - series(f64::from(x))).abs() < 3e-7, "{x}");
        }
    }

    #[test]
    fn erf_inv_inverts() {
        for i in -999..1000 {
            let y = i as f32 / 1000.0;
            assert!((erf(erf_inv(y)) - y).abs() < 6e-7, "{y}");
        }
    }
}
