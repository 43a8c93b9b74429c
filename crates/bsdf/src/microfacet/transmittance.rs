//! How much light a rough dielectric boundary lets through from each direction.
//!
//! T(μ) = ∫ (1 - F(wo·m)) G1(wt, m) p_visible(m; wo) dm, μ = cosθ_o, wt the refracted direction: what enters a coated material of
//! index η = interior/exterior, single scattering.
//!
//! T is computed once per material by Gauss quadrature over the sampling square and kept as sixteen Chebyshev coefficients in √μ, 16
//! bits each, so that a lobe stays a small Copy value; the error is below 10⁻³ for α in [10⁻⁴, 1] and η in [1.05, 3] (tested). The square root
//! spreads the grazing angles, where T bends on the scale of α.
//!
//! The internal reflectance is R = (2/64) Σ μ_k R_int(μ_k) over 64 equally spaced cosines from 0 to 1, both ends counted in full. That
//! is some 1.5 % below the integral 2∫μ R_int dμ; the rule is kept because Mitsuba's roughplastic is *defined* by it and its
//! pictures depend on it at first order.

use super::{Microfacets, Ndf};
use crate::fresnel::{self, reflect, refract};
use etendue_numerics::{Vec2, Vec3, math::safe_sqrt};
use std::f64::consts::PI;

/// Coefficients kept.
const TERMS: usize = 16;
/// The unit of a coefficient; none exceeds 1, since 0 ≤ T ≤ 1 bounds the first and twice its spread the others.
const SCALE: f32 = 16_384.0;
/// Cosines that the internal reflectance averages over.
const COSINES: usize = 64;

/// T(μ) and the internal reflectance of a rough boundary; make one per material, not per hit (some milliseconds).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughTransmittance {
    /// Coefficients times [`SCALE`].
    chebyshev: [i16; TERMS],
    internal: f32,
}

impl RoughTransmittance {
    /// The boundary of distribution `ndf`, roughness `alpha` and relative index `eta` = interior/exterior.
    pub fn new(ndf: Ndf, alpha: f32, eta: f32) -> Self {
        let surface = Microfacets::new(ndf, alpha, alpha, true);
        let eta = crate::local::clean_eta(eta);
        let rule = gauss_legendre::<32>();
        let internal = (0..COSINES)
            .map(|k| f64::from((k as f32 / (COSINES - 1) as f32).max(1e-6)))
            .map(|mu| mu * reflected(&surface, &rule, mu, 1.0 / eta));
        Self {
            chebyshev: fit(|mu| transmitted(&surface, &rule, mu, eta)),
            internal: (internal.sum::<f64>() * 2.0 / COSINES as f64) as f32,
        }
    }

    /// A boundary whose T and internal reflectance are known.
    pub(super) fn of(transmittance: impl Fn(f64) -> f64, internal: f64) -> Self {
        Self { chebyshev: fit(transmittance), internal: internal as f32 }
    }

    /// T(μ) in [0, 1] for μ in [0, 1].
    #[inline]
    pub fn at(&self, mu: f32) -> f32 {
        // Clenshaw's recurrence in x = 2√μ - 1, for even and odd terms apart, side by side: T_2k(x) = T_k(y) and T_2k+1(x) = x V_k(y),
        // y = 2x² - 1, V_0 = 1, V_1 = 2y - 1 and both by the same recurrence.
        let x = 2.0 * mu.max(0.0).sqrt() - 1.0;
        let y2 = 4.0 * x * x - 2.0;
        let ([mut e0, mut e1], [mut o0, mut o1]) = ([0.0; 2], [0.0; 2]);
        for c in self.chebyshev.chunks_exact(2).rev() {
            (e0, e1) = ((f32::from(c[0]) - e1) + y2 * e0, e0);
            (o0, o1) = ((f32::from(c[1]) - o1) + y2 * o0, o0);
        }
        ((e0 - 0.5 * y2 * e1 + x * (o0 - o1)) * (1.0 / SCALE)).clamp(0.0, 1.0)
    }

    /// The reflectance for diffuse light from inside, in [0, 1).
    #[inline]
    pub fn internal_reflectance(&self) -> f32 {
        self.internal
    }
}

/// The interpolant of `f` at the Chebyshev nodes of √μ.
fn fit(f: impl Fn(f64) -> f64) -> [i16; TERMS] {
    let angle = |j: usize| PI * (j as f64 + 0.5) / TERMS as f64;
    let values: [f64; TERMS] = std::array::from_fn(|j| f((0.5 * (angle(j).cos() + 1.0)).powi(2)));
    std::array::from_fn(|k| {
        let sum: f64 = values.iter().enumerate().map(|(j, v)| v * (k as f64 * angle(j)).cos()).sum();
        (sum * if k == 0 { 1.0 } else { 2.0 } / TERMS as f64 * f64::from(SCALE)).round() as i16
    })
}

/// T(μ): the mean of (1 - F) G1(wt) over visible normals.
fn transmitted<const N: usize>(surface: &Microfacets, rule: &[(f64, f64); N], mu: f64, eta: f32) -> f64 {
    over_visible(surface, rule, mu, |wo, m| {
        let x = fresnel::dielectric(wo.dot(m), eta);
        let wt = refract(wo, m, &x);
        if wt.z < 0.0 { (1.0 - x.f) * surface.unshadowed(wo, wt, m) } else { 0.0 }
    })
}

/// R(μ): the mean of F G1(wi) over visible normals.
fn reflected<const N: usize>(surface: &Microfacets, rule: &[(f64, f64); N], mu: f64, eta: f32) -> f64 {
    over_visible(surface, rule, mu, |wo, m| {
        let wi = reflect(wo, m);
        if wi.z > 0.0 { fresnel::dielectric(wo.dot(m), eta).f * surface.unshadowed(wo, wi, m) } else { 0.0 }
    })
}

pub(super) fn over_visible<const N: usize>(
    surface: &Microfacets,
    rule: &[(f64, f64); N],
    mu: f64,
    g: impl Fn(Vec3, Vec3) -> f32,
) -> f64 {
    let mu = mu as f32;
    let wo = Vec3::new(safe_sqrt(1.0 - mu * mu), 0.0, mu);
    let row =
        |x: f64| rule.iter().map(|&(y, w)| w * f64::from(g(wo, surface.sample(wo, Vec2::new(x as f32, y as f32))))).sum::<f64>();
    rule.iter().map(|&(x, w)| w * row(x)).sum()
}

/// Nodes and weights on [0, 1]: roots of the Legendre polynomial by Newton's method from Tricomi's estimate.
pub(super) fn gauss_legendre<const N: usize>() -> [(f64, f64); N] {
    let n = N as f64;
    std::array::from_fn(|i| {
        let mut x = (PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut p, mut before) = (1.0, 0.0);
            for k in 0..N {
                let k = k as f64;
                (p, before) = (((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0), p);
            }
            slope = n * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_integrates_polynomials() {
        let rule = gauss_legendre::<8>();
        for power in 0..16 {
            let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power)).sum();
            assert!((sum - 1.0 / f64::from(power + 1)).abs() < 1e-12, "{power}: {sum}");
        }
    }

    #[test]
    fn the_fit_follows_the_integral() {
        let rule = gauss_legendre::<40>();
        let mut worst = (0.0, String::new());
        for ndf in [Ndf::Beckmann, Ndf::Ggx] {
            for alpha in [1e-4, 0.01, 0.05, 0.1, 0.3, 0.6, 1.0] {
                for eta in [1.05, 1.3, 1.49, 2.0, 3.0] {
                    let boundary = Microfacets::new(ndf, alpha, alpha, true);
                    let fitted = RoughTransmittance {
                        chebyshev: fit(|mu| transmitted(&boundary, &gauss_legendre::<32>(), mu, eta)),
                        internal: 0.0,
                    };
                    for mu in [0.001, 0.003, 0.01, 0.02, 0.04, 0.07, 0.1, 0.15, 0.2, 0.3, 0.45, 0.6, 0.8, 0.95, 1.0] {
                        let error = (f64::from(fitted.at(mu as f32)) - transmitted(&boundary, &rule, mu, eta)).abs();
                        if error > worst.0 {
                            worst = (error, format!("{error} for {ndf:?} alpha {alpha} eta {eta} mu {mu}"));
                        }
                    }
                }
            }
        }
        assert!(worst.0 < 1e-3, "{}", worst.1);
    }

    #[test]
    fn a_smooth_boundary_is_fresnel() {
        let t = RoughTransmittance::new(Ndf::Ggx, 1e-4, 1.49);
        for mu in [0.05, 0.2, 0.5, 1.0] {
            assert!((t.at(mu) - (1.0 - fresnel::dielectric(mu, 1.49).f)).abs() < 1e-3);
        }
        assert!((t.internal_reflectance() - fresnel::diffuse_average(1.0 / 1.49)).abs() < 0.015);
    }
}
