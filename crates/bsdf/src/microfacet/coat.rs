//! What a layer with a dielectric boundary on top lets through to its ground, and sends back to it.
//!
//! ```text
//! T(μ) = E[(1 - F) G/G1 e^(-d/|cos wt|)]                   over visible facets, wt the refracted direction; d the layer's thickness
//! R    = ∫ 2 c e^(-d/c) E[F G/G1 e^(-d/|cos wi|)] dc       from Lambert's ground to the boundary and back
//! ```
//!
//! T reaches the ground, R comes back to it: both count the way through the layer, which absorbs [Guo, Hašan, Zhao 2018; Pharr, Jakob,
//! Humphreys 2023, §14.3]. By reciprocity the radiance L of Lambert's ground is T L/η² outside.

use super::transmittance::{RoughTransmittance, gauss_legendre, over_visible};
use super::{Microfacets, Ndf};
use crate::fresnel::{self, reflect, refract};
use etendue_numerics::Vec3;

/// T and R of a layer of index `eta` against the outside, optical `thickness` and a boundary of roughness `alpha`; make one per material. Of a
/// smooth boundary `alpha` is `None`.
pub fn coat(alpha: Option<f32>, eta: f32, thickness: f32) -> RoughTransmittance {
    let eta = crate::local::clean_eta(eta);
    let rule = gauss_legendre::<32>();
    let through = |w: Vec3| (-thickness / w.z.abs()).exp();
    let average = |mu: f64, g: &dyn Fn(Vec3, Vec3) -> f32| match alpha {
        Some(alpha) => over_visible(&Microfacets::new(Ndf::GgxCorrelated, alpha, alpha, true), &rule, mu, g),
        None => {
            let mu = mu as f32;
            f64::from(g(Vec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu), Vec3::Z))
        }
    };
    let left = |wo: Vec3, w: Vec3, m: Vec3| match alpha {
        Some(alpha) => Microfacets::new(Ndf::GgxCorrelated, alpha, alpha, true).unshadowed(wo, w, m),
        None => 1.0,
    };
    let down = |mu: f64| {
        average(mu, &|wo, m| {
            let x = fresnel::dielectric(wo.dot(m), eta);
            let wt = refract(wo, m, &x);
            if wt.z < 0.0 { (1.0 - x.f) * left(wo, wt, m) * through(wt) } else { 0.0 }
        })
    };
    let back = |mu: f64| {
        average(mu, &|wo, m| {
            let wi = reflect(wo, m);
            // Seen from within: the index is upside down.
            if wi.z > 0.0 { fresnel::dielectric(wo.dot(m), 1.0 / eta).f * left(wo, wi, m) * through(wi) } else { 0.0 }
        })
    };
    // The kink at the angle of total reflection wants many nodes, and its two sides rules of their own.
    let critical = (1.0 - 1.0 / f64::from(eta * eta)).max(0.0).sqrt();
    let piece = |from: f64, to: f64| -> f64 {
        let node = |&(x, w): &(f64, f64)| {
            let c = from + (to - from) * x;
            (to - from) * w * 2.0 * c * (-f64::from(thickness) / c).exp() * back(c)
        };
        rule.iter().map(node).sum()
    };
    let internal = piece(0.0, critical) + piece(critical, 1.0);
    RoughTransmittance::of(|mu| down(mu.max(1e-6)), internal)
}
