//! Hair: a fibre of cuticle, cortex and pigment, seen from so far that it is a line [Marschner et al. 2003; Chiang et al. 2016].
//!
//! ```text
//! f |cosθ| = Σ_p M_p(θo, θi) A_p(ωo) N_p(φ)        p = 0: off the cuticle (R), 1: through (TT), 2: off the far wall (TRT), 3: all that is left
//!
//! M_p = I0(cosθi cosθo/v) exp(-sinθi sinθo/v) / (2 v sinh(1/v))                       [d'Eon et al. 2011, eq. 7]
//! A_0 = F,  A_1 = (1 - F)² T,  A_2 = A_1 T F,  A_3 = A_2 T F/(1 - T F)                [Chiang et al. 2016, eq. 12 ff.]
//! T   = exp(-σ 2 cosγt/cosθt),   F = Fresnel(cosθo cosγo)                             a chord in units of the fibre's radius
//! N_p = logistic(φ - Φ_p; s) cut off at ±π,  N_3 = 1/2π,   Φ_p = 2 p γt - 2 γo + p π
//! ```
//!
//! | symbol | identifier | |
//! | --- | --- | --- |
//! | θ, φ | `sin`, `phi` | sinθ = x, φ around x from y: x runs along the fibre, z is the normal of its wall |
//! | γo, γt | `sin_o`, `gamma_t` | the azimuth between ωo and the normal, outside and refracted |
//! | v | `v` | variances along the fibre, (0.726 βm + 0.812 βm² + 3.7 βm²⁰)² for R, a quarter for TT, four times for the others |
//! | s | `s` | √(π/8) (0.265 βn + 1.194 βn² + 5.372 βn²²) |
//!
//! Cuticle scales are tilted by α: R, TT and TRT are turned by -2α, α and 4α along the fibre. The wall's normal and ωo give γo; on a ribbon that faces its
//! viewer that is asin h, h the offset from its axis. So f belongs to the side of ωo: it is not reciprocal, and zero from within.

use crate::{BsdfSample, Event, Scatter, fresnel, local};
use etendue_numerics::math::{FRAC_PI_2, PI, TAU, atan2, exp, ln, safe_asin, safe_sqrt, sin_cos, sqr};
use etendue_numerics::{Spectrum, Vec2, Vec3};

/// Ways through the fibre that are told apart; what is left is the last.
const WAYS: usize = 4;

/// What [`Hair`] is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HairParams {
    /// σ, absorption per radius of the fibre; default none.
    pub sigma_a: Spectrum,
    /// 1 in the lanes in use; default red, green, blue.
    pub lanes: Spectrum,
    /// η of the fibre; default 1.55.
    pub eta: f32,
    /// Roughness along the fibre, in [0.01, 1]; default 0.3.
    pub beta_m: f32,
    /// Roughness around it, in [0.01, 1]; default 0.3.
    pub beta_n: f32,
    /// Tilt of the cuticle's scales, degrees; default 2.
    pub alpha: f32,
}

impl Default for HairParams {
    fn default() -> Self {
        let lanes = Spectrum::rgb(1.0, 1.0, 1.0);
        Self { sigma_a: Spectrum::ZERO, lanes, eta: 1.55, beta_m: 0.3, beta_n: 0.3, alpha: 2.0 }
    }
}

/// A fibre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hair {
    sigma_a: Spectrum,
    lanes: Spectrum,
    eta: f32,
    v: [f32; WAYS],
    s: f32,
    /// Sine and cosine of the turn of each way.
    tilt: [(f32, f32); WAYS],
    beta: f32,
}

/// The fibre as it is seen along ωo.
struct Seen {
    phi: f32,
    /// A_p.
    a: [Spectrum; WAYS],
    /// The share of each way in `a`.
    share: [f32; WAYS],
    /// Sine and cosine of θo, turned by the scales' tilt.
    theta: [(f32, f32); WAYS],
    gamma: [f32; 2],
}

impl Hair {
    /// The lobe of these parameters.
    pub fn new(p: HairParams) -> Self {
        let [m, n] = [p.beta_m, p.beta_n].map(|beta| local::clean_f32(beta, 0.01, 1.0, 0.3));
        let v = sqr(0.726 * m + 0.812 * m * m + 3.7 * m.powi(20));
        let s = (PI / 8.0).sqrt() * (0.265 * n + 1.194 * n * n + 5.372 * n.powi(22));
        let alpha = local::clean_f32(p.alpha, -45.0, 45.0, 0.0).to_radians();
        let tilt = [-2.0, 1.0, 4.0, 0.0].map(|k| sin_cos(k * alpha));
        let sigma_a = local::clean(p.sigma_a);
        // Below 1 light would be shut in, and nothing would come out.
        let eta = local::clean_f32(p.eta, 1.0, 10.0, 1.55);
        Self { sigma_a, lanes: local::clean(p.lanes), eta, v: [v, 0.25 * v, 4.0 * v, 4.0 * v], s, tilt, beta: m.min(n) }
    }

    /// None from within the fibre, and where ωo runs along it.
    fn seen(&self, wo: Vec3) -> Option<Seen> {
        let cos_o = wo.y.hypot(wo.z);
        if wo.z <= 0.0 || cos_o < 1e-4 {
            return None;
        }
        let (sin_o, phi) = (wo.x, atan2(wo.z, wo.y));
        let h = -wo.y / cos_o;
        let cos_gamma = wo.z / cos_o;

        // The refracted ray's inclination, and in the cross section its deflection with the index that it seems to have there [Bravais].
        let sin_t = sin_o / self.eta;
        let cos_t = safe_sqrt(1.0 - sin_t * sin_t);
        let eta_p = safe_sqrt(self.eta * self.eta - sin_o * sin_o) / cos_o;
        let sin_gamma_t = (h / eta_p).clamp(-1.0, 1.0);
        let chord = 2.0 * safe_sqrt(1.0 - sin_gamma_t * sin_gamma_t) / cos_t;

        let f = fresnel::dielectric(cos_o * cos_gamma, self.eta).f;
        let passed = |sigma: f32| exp(-sigma * chord);
        let t = Spectrum(self.sigma_a.0.to_array().map(passed).into());
        let through = t * (sqr(1.0 - f));
        let left = through * t * f;
        let rest = left * t * f / (Spectrum::ONE - t * f).max(f32::MIN_POSITIVE);
        let a = [Spectrum::splat(f), through, left, rest].map(|a| a * self.lanes);
        let weight = a.map(|a| local::mean(a).max(0.0));
        let total: f32 = weight.iter().sum();
        let share = if total > 0.0 { weight.map(|w| w / total) } else { [1.0, 0.0, 0.0, 0.0] };
        let theta = self.tilt.map(|(sin, cos)| (sin_o * cos + cos_o * sin, (cos_o * cos - sin_o * sin).abs()));
        Some(Seen { phi, a, share, theta, gamma: [safe_asin(h), safe_asin(sin_gamma_t)] })
    }

    /// M_p N_p at `wi`, per steradian.
    fn way(&self, seen: &Seen, p: usize, wi: Vec3) -> f32 {
        let cos_i = wi.y.hypot(wi.z);
        let m = longitudinal(wi.x, cos_i, seen.theta[p], self.v[p]);
        let n = match p {
            3 => 1.0 / TAU,
            _ => logistic(wrapped(atan2(wi.z, wi.y) - seen.phi - deflection(p, seen.gamma)), self.s),
        };
        m * n
    }

    /// f |cosθi| and the density of `wi`.
    fn both(&self, seen: &Seen, wi: Vec3) -> (Spectrum, f32) {
        let mut sum = (Spectrum::ZERO, 0.0);
        for p in 0..WAYS {
            let way = self.way(seen, p, wi);
            sum.0 += seen.a[p] * way;
            sum.1 += seen.share[p] * way;
        }
        sum
    }
}

/// Φ_p: how far around the fibre way p leads.
fn deflection(p: usize, [gamma_o, gamma_t]: [f32; 2]) -> f32 {
    let p = p as f32;
    2.0 * p * gamma_t - 2.0 * gamma_o + p * PI
}

/// An angle in [-π, π].
fn wrapped(x: f32) -> f32 {
    x - TAU * (x / TAU).round()
}

/// I0(x) exp(-x) [Abramowitz, Stegun 1964, 9.8.1, 9.8.2], of relative error below 1e-6.
fn scaled_i0(x: f32) -> f32 {
    const LOW: [f32; 7] = [1.0, 3.515_623, 3.089_942_4, 1.206_749_2, 0.265_973_2, 0.036_076_8, 0.004_581_3];
    const HIGH: [f32; 9] = [
        0.398_942_3,
        0.013_285_92,
        0.002_253_19,
        -0.001_575_65,
        0.009_162_81,
        -0.020_577_06,
        0.026_355_37,
        -0.016_476_33,
        0.003_923_77,
    ];
    let polynomial = |c: &[f32], t: f32| c.iter().rev().fold(0.0, |sum, c| sum * t + c);
    if x < 3.75 { polynomial(&LOW, sqr(x / 3.75)) * exp(-x) } else { polynomial(&HIGH, 3.75 / x) / x.sqrt() }
}

/// M_p, whose integral over cosθi dθi is 1. As differences, since both exponents are large where v is small.
fn longitudinal(sin_i: f32, cos_i: f32, (sin_o, cos_o): (f32, f32), v: f32) -> f32 {
    let apart = 0.5 * (sqr(cos_i - cos_o) + sqr(sin_i + sin_o));
    scaled_i0(cos_i * cos_o / v) * exp(-apart / v) / (v * (1.0 - exp(-2.0 / v)))
}

/// A logistic density of scale s, cut off at ±π.
fn logistic(x: f32, s: f32) -> f32 {
    let e = exp(-x.abs() / s);
    let [a, b] = [exp(-PI / s), 1.0 + e];
    e / (s * b * b) * (1.0 + a) / (1.0 - a)
}

/// A number of that density.
fn logistic_sample(u: f32, s: f32) -> f32 {
    let a = exp(-PI / s);
    let (lowest, whole) = (a / (1.0 + a), (1.0 - a) / (1.0 + a));
    let tail = lowest + u.min(1.0 - u) * whole;
    let x = s * ln((1.0 / tail - 1.0).max(1.0));
    (if u < 0.5 { -x } else { x }).clamp(-PI, PI)
}

impl Scatter for Hair {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        self.eval_pdf(wo, wi).0
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.eval_pdf(wo, wi).1
    }

    fn sample(&self, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample> {
        let seen = self.seen(wo)?;

        // A way, and what u1 leaves for its azimuth.
        let (mut p, mut before) = (0, 0.0);
        while p + 1 < WAYS && u1 >= before + seen.share[p] {
            before += seen.share[p];
            p += 1;
        }
        let u1 = local::stretch(u1, before, seen.share[p].max(f32::MIN_POSITIVE));

        // θi: about the reflection of θo, turned about it [d'Eon et al. 2013].
        let v = self.v[p];
        let versine = (-v * ln((1.0 - u2.x) + u2.x * exp(-2.0 / v))).clamp(0.0, 2.0);
        let (cos, sin) = (1.0 - versine, safe_sqrt(versine * (2.0 - versine)));
        let (sin_o, cos_o) = seen.theta[p];
        let sin_i = (-cos * sin_o + sin * sin_cos(TAU * u2.y).1 * cos_o).clamp(-1.0, 1.0);
        let cos_i = safe_sqrt(1.0 - sin_i * sin_i);

        let around = if p == 3 { TAU * u1 - PI } else { deflection(p, seen.gamma) + logistic_sample(u1, self.s) };
        let (sin_phi, cos_phi) = sin_cos(wrapped(seen.phi + around));
        let wi = Vec3::new(sin_i, cos_i * cos_phi, cos_i * sin_phi);
        if wi.z == 0.0 {
            return None;
        }
        let (f_cos, pdf) = self.both(&seen, wi);
        let side = if wi.z > 0.0 { Event::REFLECT } else { Event::TRANSMIT };
        local::weighted(wi, f_cos / pdf, pdf, 1.0, side | Event::GLOSSY)
    }

    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        let Some(seen) = self.seen(wo).filter(|_| wi.z != 0.0) else { return (Spectrum::ZERO, 0.0) };
        let (f_cos, pdf) = self.both(&seen, wi);
        (f_cos / wi.z.abs().max(1e-8), pdf)
    }

    fn events(&self) -> Event {
        Event::REFLECT | Event::TRANSMIT | Event::GLOSSY
    }

    fn albedo(&self, wo: Vec3) -> Spectrum {
        self.seen(wo).map_or(Spectrum::ZERO, |seen| seen.a.into_iter().sum())
    }

    fn roughness(&self) -> f32 {
        self.beta
    }

    fn importance(&self) -> f32 {
        self.albedo(Vec3::new(0.0, sin_cos(0.25 * FRAC_PI_2).0, sin_cos(0.25 * FRAC_PI_2).1)).max_lane()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of I0 from tables, and of both densities the integrals.
    #[test]
    fn densities_are_densities() {
        for (x, i0) in [(0.0, 1.0f64), (1.0, 1.266_065_877_752), (3.0, 4.880_792_585_865), (10.0, 2_815.716_628_466)] {
            assert!((f64::from(scaled_i0(x)) / (i0 * f64::from(-x).exp()) - 1.0).abs() < 2e-6, "{x}");
        }
        for s in [0.01f32, 0.1, 0.6, 3.0] {
            let n = 40_000;
            let step = TAU / n as f32;
            let sum: f64 = (0..n).map(|i| f64::from(logistic(-PI + (i as f32 + 0.5) * step, s) * step)).sum();
            assert!((sum - 1.0).abs() < 1e-4, "{s}: {sum}");
        }
        for v in [5e-4f32, 0.02, 0.3, 2.0, 20.0] {
            for sin_o in [0.0f32, 0.5, -0.9] {
                let cos_o = safe_sqrt(1.0 - sin_o * sin_o);
                let n = 20_000;
                let step = 2.0 / n as f32;
                // cosθ dθ = d sinθ.
                let at = |i: i32| -1.0 + (i as f32 + 0.5) * step;
                let m = |x: f32| longitudinal(x, safe_sqrt(1.0 - x * x), (sin_o, cos_o), v);
                let sum: f64 = (0..n).map(|i| f64::from(m(at(i)) * step)).sum();
                assert!((sum - 1.0).abs() < 2e-3, "v = {v}, sinθo = {sin_o}: {sum}");
            }
        }
    }
}
