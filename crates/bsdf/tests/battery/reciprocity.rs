//! f(wo, wi) = η² f(wi, wo), η = η_i/η_o.

use crate::models;
use etendue_bsdf::{Bsdf, Scatter};
use etendue_check::rng;
use etendue_numerics::Vec3;

/// The largest relative difference between f(wo, wi) and η² f(wi, wo) over random pairs of which half are near reflections or
/// refractions; `everywhere`, or only where both sides see each other.
pub fn worst(f: &Bsdf, scatter: &dyn Scatter, everywhere: bool, seed: u64) -> f32 {
    let mut numbers = rng(seed);
    let mut direction = || {
        let v = Vec3::new(numbers.u1(), numbers.u1(), numbers.u1()) * 2.0 - 1.0;
        if v.length_squared() < 1e-3 { Vec3::X } else { v.normalize() }
    };
    let mut worst = 0f32;
    for k in 0..2_000 {
        let (wo, other) = (direction(), direction());
        let wi = match k % 4 {
            0 => (Vec3::new(-wo.x, -wo.y, wo.z) + 0.2 * other).normalize(),
            1 => (-wo + 0.2 * other).normalize(),
            _ => other,
        };
        // Near the horizon f32 has lost too much of cosθ to compare.
        if wo.z.abs() < 0.02 || wi.z.abs() < 0.02 {
            continue;
        }
        let eta = f.relative_eta(wo, wi);
        let (a, b) = (scatter.eval(wo, wi)[0], scatter.eval(wi, wo)[0] * eta * eta);
        if !everywhere && (a == 0.0 || b == 0.0) {
            continue;
        }
        worst = worst.max((a - b).abs() / (a.abs() + b.abs() + 1e-3));
    }
    worst
}

#[test]
fn light_may_go_either_way() {
    for row in models::rows().into_iter().filter(|r| !r.bent) {
        let worst = worst(&row.bsdf, &row.bsdf, row.reciprocal, 3);
        assert!(worst < 2e-2, "{}: {worst}", row.name);
    }
}
