//! Separable reconstruction kernels k(x) k(y) over pixels.

use crate::math::{PI, exp};

/// A one-dimensional even kernel with bounded support; x in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kernel {
    /// 1 within the radius.
    Box {
        /// Half width.
        radius: f32,
    },
    /// 1 - |x|/r.
    Tent {
        /// Half width.
        radius: f32,
    },
    /// exp(-x²/2σ²) - exp(-r²/2σ²), r = 4σ.
    Gaussian {
        /// Standard deviation σ.
        stddev: f32,
    },
    /// The two-parameter cubic of [Mitchell, Netravali 1988, eq. 8], radius 2.
    Mitchell {
        /// B.
        b: f32,
        /// C.
        c: f32,
    },
    /// Mitchell with B = 0, C = 1/2.
    CatmullRom,
    /// sinc(x) sinc(x/τ), radius τ.
    Lanczos {
        /// Number of lobes τ.
        lobes: f32,
    },
}

impl Kernel {
    /// Half the width of the support, pixels.
    pub fn radius(&self) -> f32 {
        match *self {
            Self::Box { radius } | Self::Tent { radius } => radius,
            Self::Gaussian { stddev } => 4.0 * stddev,
            Self::Mitchell { .. } | Self::CatmullRom => 2.0,
            Self::Lanczos { lobes } => lobes,
        }
    }

    /// k(x); zero outside the support.
    pub fn eval(&self, x: f32) -> f32 {
        let x = x.abs();
        let radius = self.radius();
        if x > radius {
            return 0.0;
        }
        match *self {
            Self::Box { .. } => 1.0,
            Self::Tent { radius } => 1.0 - x / radius,
            Self::Gaussian { stddev } => {
                let alpha = -0.5 / (stddev * stddev);
                (exp(alpha * x * x) - exp(alpha * radius * radius)).max(0.0)
            }
            Self::Mitchell { b, c } => cubic(x, b, c),
            Self::CatmullRom => cubic(x, 0.0, 0.5),
            Self::Lanczos { lobes } => sinc(x) * sinc(x / lobes),
        }
    }

    /// The variance that the filter leaves of independent pixels of equal variance, (∫k² / (∫k)²)² over both axes; 1 for the unit box.
    pub fn noise_factor(&self) -> f64 {
        const STEPS: usize = 4096;
        let h = 2.0 * f64::from(self.radius()) / STEPS as f64;
        let k = |i: usize| f64::from(self.eval((-f64::from(self.radius()) + (i as f64 + 0.5) * h) as f32));
        let (sum, squares) = (0..STEPS).map(k).fold((0.0, 0.0), |(s, q), x| (s + x * h, q + x * x * h));
        (squares / (sum * sum)).powi(2)
    }
}

fn cubic(x: f32, b: f32, c: f32) -> f32 {
    let (x2, x3) = (x * x, x * x * x);
    let sixth = 1.0 / 6.0;
    if x < 1.0 {
        sixth * ((12.0 - 9.0 * b - 6.0 * c) * x3 + (-18.0 + 12.0 * b + 6.0 * c) * x2 + (6.0 - 2.0 * b))
    } else if x < 2.0 {
        sixth * ((-b - 6.0 * c) * x3 + (6.0 * b + 30.0 * c) * x2 + (-12.0 * b - 48.0 * c) * x + (8.0 * b + 24.0 * c))
    } else {
        0.0
    }
}

fn sinc(x: f32) -> f32 {
    let y = PI * x;
    if y.abs() < 1e-4 { 1.0 } else { y.sin() / y }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_are_even_and_vanish_outside() {
        let all = [
            Kernel::Box { radius: 0.5 },
            Kernel::Tent { radius: 1.0 },
            Kernel::Gaussian { stddev: 0.5 },
            Kernel::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 },
            Kernel::CatmullRom,
            Kernel::Lanczos { lobes: 3.0 },
        ];
        for k in all {
            assert_eq!(k.eval(k.radius() * 1.01), 0.0);
            assert_eq!(k.eval(0.3), k.eval(-0.3));
            assert!(k.eval(0.0) > 0.5, "{k:?}");
        }
    }

    #[test]
    fn the_gaussian_leaves_its_known_share_of_noise() {
        assert!((Kernel::Box { radius: 0.5 }.noise_factor() - 1.0).abs() < 1e-3);
        assert!((Kernel::Tent { radius: 1.0 }.noise_factor() - 4.0 / 9.0).abs() < 1e-3);
        // Untruncated: 1 / (4πσ²) = 1/π at σ = 1/2.
        assert!((Kernel::Gaussian { stddev: 0.5 }.noise_factor() * std::f64::consts::PI - 1.0).abs() < 0.01);
    }

    #[test]
    fn cubics_are_partitions_of_unity() {
        for k in [Kernel::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 }, Kernel::CatmullRom] {
            for x in [0.0, 0.25, 0.7] {
                let sum: f32 = (-3..=3).map(|i| k.eval(x - i as f32)).sum();
                assert!((sum - 1.0).abs() < 1e-6);
            }
        }
    }
}
