//! Lambert's ground under a smooth boundary: what `plastic` and `coateddiffuse` differ in.
//!
//! ```text
//! plastic, nonlinear    ρ / (1 - ρ F)                     F = ∫ 2 cosθ F(cosθ) dcosθ, from within
//! plastic               ρ / (1 - F)
//! coateddiffuse         a² ρ Σ_{k<K} (ρ F_t)^k            a = exp(-1.15 t): once through a layer of thickness t, in the mean
//!                                                         F_t = ∫ 2 cosθ F(cosθ) exp(-2t/cosθ) dcosθ
//! ```
//!
//! K is half of the layer's `max_depth`. Each function gives the ρ of one that lets out as much light as the other.

/// F_t: how much diffuse light within a layer of index `eta` comes back from its boundary.
fn from_within(eta: f64, thickness: f64) -> f64 {
    const STEPS: u32 = 4096;
    let fresnel = |cos: f64| {
        let sin2 = (1.0 - cos * cos) * eta * eta;
        if sin2 >= 1.0 {
            return 1.0;
        }
        let out = (1.0 - sin2).sqrt();
        let s = (eta * cos - out) / (eta * cos + out);
        let p = (eta * out - cos) / (eta * out + cos);
        0.5 * (s * s + p * p)
    };
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(STEPS);
    (0..STEPS).map(at).map(|cos| 2.0 * cos * fresnel(cos) * (-2.0 * thickness / cos).exp()).sum::<f64>() / f64::from(STEPS)
}

/// The ρ of a `plastic` that is `nonlinear`, for that of one that is not.
pub(super) fn nonlinear(rho: f64, eta: f64) -> f64 {
    let f = from_within(eta, 0.0);
    rho / (1.0 - f + f * rho)
}

/// The ρ of a `plastic` that is `nonlinear`, for that of a `coateddiffuse`.
pub(super) fn without_coat(rho: f64, eta: f64, thickness: f64, max_depth: i64) -> f64 {
    let (f, ft) = (from_within(eta, 0.0), from_within(eta, thickness));
    let bounces = (max_depth.clamp(1, 1000) + 1) as i32 / 2;
    let out = (-2.3 * thickness).exp() * rho * (1.0 - (rho * ft).powi(bounces)) / (1.0 - rho * ft);
    out / (1.0 + out * f)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// [Egan, Hilgeman 1973] fit 0.5962 for 1.5.
    #[test]
    fn the_boundary_of_glass_throws_back_three_fifths() {
        assert!((from_within(1.5, 0.0) - 0.5963).abs() < 1e-3);
        assert!(from_within(1.0, 0.0).abs() < 1e-6);
    }

    #[test]
    fn as_much_light_comes_out() {
        let f = from_within(1.5, 0.0);
        for rho in [0.0, 0.3, 1.0] {
            let other = nonlinear(rho, 1.5);
            assert!((other / (1.0 - other * f) - rho / (1.0 - f)).abs() < 1e-12, "{rho}");
            // A thin layer with bounces without end is none.
            assert!((without_coat(rho, 1.5, 0.0, 1000) - rho).abs() < 1e-12, "{rho}");
        }
        assert!(without_coat(1.0, 1.5, 0.01, 10) < 0.95);
    }
}
