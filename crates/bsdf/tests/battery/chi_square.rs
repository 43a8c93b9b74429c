//! Smooth samples are distributed by `pdf`, and ∫pdf is the share of draws that give one.

use crate::{FALSE_ALARMS, directions, models};
use etendue_bsdf::Scatter;
use etendue_check::{ChiSquare, ChiSquareTest, Sphere, family_wise};
use etendue_numerics::{Vec2, Vec3};

/// The report for one model seen from `wo`; Dirac samples count as absorbed.
pub fn report(f: &dyn Scatter, wo: Vec3, seed: u64) -> ChiSquare {
    let draw = |[a, b, c]: [f32; 3]| f.sample(wo, a, Vec2::new(b, c)).filter(|s| !s.pdf.is_delta()).map(|s| s.wi);
    ChiSquareTest::new(Sphere).samples(1 << 15).seed(seed).run(draw, |wi| f.pdf(wo, wi))
}

#[test]
fn smooth_samples_follow_their_density() {
    // Rough mirrors are sampled as rough gold is.
    let rows: Vec<_> =
        models::rows().into_iter().filter(|r| r.bsdf.events().has_smooth() && !r.name.starts_with("rough mirror")).collect();
    let alpha = family_wise(FALSE_ALARMS, rows.len() * directions().len());
    let mut faults = Vec::new();
    for row in &rows {
        for (k, wo) in directions().into_iter().enumerate() {
            let report = report(&row.bsdf, wo, 11 + k as u64);
            if !report.passes(alpha) {
                faults.push(format!("{} from {wo}: {report}", row.name));
            }
        }
    }
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}
