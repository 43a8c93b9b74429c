//! Fresnel reflectance of a smooth interface, unpolarised.
//!
//! Dielectrics: F = ½ (a_s² + a_p²), a_s = (cosθ_i - η cosθ_t)/(cosθ_i + η cosθ_t), a_p = (cosθ_t - η cosθ_i)/(cosθ_t + η cosθ_i),
//! with Snell's cosθ_t = √(1 - sin²θ_i/η²), η = η_t/η_i; F = 1 where the root is not real (total internal reflection).
//!
//! Conductors: the same with η + ik, written in real arithmetic [Moeller 1988, "Optics", §2.6].
//!
//! Diffuse average: F_dr(η) = ∫₀¹ 2μ F(μ, η) dμ, by published fits [Egan and Hilgeman 1973; d'Eon and Irving 2011].

use etendue_numerics::{
    Spectrum, Vec3,
    math::{safe_sqrt, sqr},
};

/// What a dielectric interface does to one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fresnel {
    /// Reflectance in [0, 1].
    pub f: f32,
    /// Cosine of the transmitted direction, of opposite sign to the given cosine; 0 at total internal reflection.
    pub cos_t: f32,
    /// η_t/η_i in the direction of travel.
    pub eta_it: f32,
    /// Its reciprocal.
    pub eta_ti: f32,
}

/// Reflectance and refraction for a direction at cosine `cos_i` to the normal (negative: inside); `eta` = interior/exterior index > 0.
#[inline(always)]
pub fn dielectric(cos_i: f32, eta: f32) -> Fresnel {
    let (eta_it, eta_ti) = if cos_i >= 0.0 { (eta, 1.0 / eta) } else { (1.0 / eta, eta) };
    let c = cos_i.abs();
    let cos_t = safe_sqrt(1.0 - (1.0 - c * c) * sqr(eta_ti));
    let a_s = (c - eta_it * cos_t) / (c + eta_it * cos_t);
    let a_p = (cos_t - eta_it * c) / (cos_t + eta_it * c);
    let f = 0.5 * (sqr(a_s) + sqr(a_p));
    let f = if c == 0.0 { 1.0 } else { f };
    let f = if eta == 1.0 { 0.0 } else { f };
    Fresnel { f, cos_t: if cos_i >= 0.0 { -cos_t } else { cos_t }, eta_it, eta_ti }
}

/// Reflectance of a conductor of relative index η + ik, lane by lane; `cos_i` in [0, 1].
#[inline]
pub fn conductor(cos_i: f32, eta: Spectrum, k: Spectrum) -> Spectrum {
    let c2 = sqr(cos_i);
    let s2 = (1.0 - c2).max(0.0);
    let (eta2, k2) = (eta * eta, k * k);
    let t = eta2 - k2 - Spectrum::splat(s2);
    let a2_b2 = (t * t + 4.0 * eta2 * k2).sqrt();
    let a = (0.5 * (a2_b2 + t)).sqrt();
    let (t1, t2) = (a2_b2 + Spectrum::splat(c2), a * (2.0 * cos_i));
    // Lanes that are not in use hold η = k = 0, where both sums may vanish.
    let tiny = f32::MIN_POSITIVE;
    let r_s = (t1 - t2) / (t1 + t2).max(tiny);
    let (t3, t4) = (a2_b2 * c2 + Spectrum::splat(s2 * s2), t2 * s2);
    let r_p = r_s * (t3 - t4) / (t3 + t4).max(tiny);
    (0.5 * (r_s + r_p)).clamp(0.0, 1.0)
}

/// F_dr(η): what diffuse light from the side of index 1 loses to reflection at an interface to index `eta`; relative error
/// below 1 % [Egan and Hilgeman 1973 for 0.4 ≤ η < 1; d'Eon and Irving 2011 for η ≥ 1]. Below 0.4, where the former leaves the
/// physical range, by 1 - F_dr(η) = η² (1 - F_dr(1/η)), the balance of light that crosses both ways.
pub fn diffuse_average(eta: f32) -> f32 {
    if eta < 0.4 {
        1.0 - eta * eta * (1.0 - diffuse_average(1.0 / eta))
    } else if eta < 1.0 {
        (-1.4399 * eta + 0.7099) * eta + 0.6681 + 0.0636 / eta
    } else {
        let x = 1.0 / eta;
        0.919_317 + x * (-3.4793 + x * (6.753_35 + x * (-7.809_89 + x * (4.985_54 - x * 1.368_81))))
    }
}

/// (1 - cosθ)⁵ [Schlick 1994].
#[inline]
pub fn schlick_weight(cos: f32) -> f32 {
    let m = (1.0 - cos).clamp(0.0, 1.0);
    sqr(sqr(m)) * m
}

/// `w` mirrored at the microfacet normal `m`.
#[inline]
pub fn reflect(w: Vec3, m: Vec3) -> Vec3 {
    2.0 * w.dot(m) * m - w
}

/// `w` mirrored at +z.
#[inline]
pub fn reflect_z(w: Vec3) -> Vec3 {
    Vec3::new(-w.x, -w.y, w.z)
}

/// `w` refracted at the microfacet normal `m`; `x` is [`dielectric`] of w·m.
#[inline]
pub fn refract(w: Vec3, m: Vec3, x: &Fresnel) -> Vec3 {
    m * (w.dot(m) * x.eta_ti + x.cos_t) - w * x.eta_ti
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_incidence_brewster_and_total_reflection() {
        assert!((dielectric(1.0, 1.5).f - 0.04).abs() < 1e-7);
        assert!((dielectric(-1.0, 1.5).f - 0.04).abs() < 1e-7);
        // At Brewster's angle tanθ = η only the s amplitude is left: F = ½ ((1-η²)/(1+η²))².
        let brewster = 1.0 / (1.0f32 + 1.5 * 1.5).sqrt();
        assert!((dielectric(brewster, 1.5).f - 0.5 * sqr(1.25 / 3.25)).abs() < 1e-6);
        assert_eq!(dielectric(-0.1, 1.5).f, 1.0);
        assert_eq!(dielectric(0.3, 1.0).f, 0.0);
    }

    #[test]
    fn both_sides_reflect_alike() {
        for i in 1..100 {
            let c = i as f32 / 100.0;
            let x = dielectric(c, 1.7);
            assert!((dielectric(x.cos_t, 1.7).f - x.f).abs() < 1e-4, "{c}");
        }
    }

    #[test]
    fn a_conductor_without_absorption_is_a_dielectric() {
        for i in 1..=100 {
            let c = i as f32 / 100.0;
            let r = conductor(c, Spectrum::splat(1.5), Spectrum::ZERO);
            assert!((r[0] - dielectric(c, 1.5).f).abs() < 1e-5, "{c}: {r:?}");
        }
        let r = conductor(1.0, Spectrum::splat(0.2), Spectrum::splat(3.9));
        assert!((r[0] - (0.8 * 0.8 + 3.9 * 3.9) / (1.2 * 1.2 + 3.9 * 3.9)).abs() < 1e-6);
    }

    #[test]
    fn unused_lanes_stay_finite() {
        for c in [0.0, 1e-30, 0.5, 1.0] {
            assert!(conductor(c, Spectrum::ZERO, Spectrum::ZERO).is_finite());
        }
        assert_eq!(conductor(0.3, Spectrum::ZERO, Spectrum::ONE)[0], 1.0);
    }

    #[test]
    fn the_average_fits_the_integral() {
        for eta in [0.1, 0.3, 0.41, 1.0 / 1.5, 1.0 / 1.33, 1.2, 1.5, 1.9, 3.0, 5.0] {
            let n = 4000;
            let sum: f64 = (0..n)
                .map(|i| (f64::from(i) + 0.5) / f64::from(n))
                .map(|mu| 2.0 * mu * f64::from(dielectric(mu as f32, eta).f))
                .sum();
            let exact = (sum / f64::from(n)) as f32;
            assert!((diffuse_average(eta) / exact - 1.0).abs() < 0.01, "{eta}: {} {exact}", diffuse_average(eta));
        }
    }
}
