//! No more light leaves than arrives, and none is lost where nothing absorbs.

use crate::{directions, models, models::Energy};
use etendue_bsdf::Scatter;
use etendue_check::{Moments, rng};
use etendue_numerics::Vec3;

/// The mean weight of samples from `wo` in the first lane: the directional albedo.
pub fn albedo(f: &dyn Scatter, wo: Vec3, n: usize) -> Moments {
    let mut moments = Moments::default();
    let mut numbers = rng(5);
    for _ in 0..n {
        moments.add(f.sample(wo, numbers.u1(), numbers.u2()).map_or(0.0, |s| f64::from(s.weight[0])));
    }
    moments
}

#[test]
fn no_light_is_made() {
    for row in models::rows() {
        for wo in directions() {
            let m = albedo(&row.bsdf, wo, 20_000);
            if m.mean == 0.0 {
                continue;
            }
            // Five standard errors; Beckmann's rational masking is off by up to 0.35 %, the fitted F_dr by up to 1 %.
            let slack = 5.0 * m.standard_error() + 0.01;
            let (low, high) = match row.energy {
                Energy::Kept => (1.0 - 1e-6, 1.0 + 1e-6),
                // At grazing incidence single scattering keeps less, so the lower bound is for the first three directions.
                Energy::AtLeast(share) => (if wo.z > 0.2 { share - slack } else { 0.0 }, 1.0 + slack),
                Energy::AtMost(most) => (0.0, most + slack),
            };
            assert!(m.mean >= low && m.mean <= high, "{} from {wo}: {} ± {}", row.name, m.mean, m.standard_error());
        }
    }
}
