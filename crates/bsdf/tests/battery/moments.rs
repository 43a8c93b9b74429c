//! E[weight g(wi)] over smooth samples is ∫ f(wo, wi) g(wi) |cosθ_i| dwi.

use crate::{FALSE_ALARMS, directions, models};
use etendue_bsdf::Scatter;
use etendue_check::{Moments, family_wise, rng, z_test};
use etendue_numerics::Vec3;
use std::f64::consts::PI;

/// Functions of a direction that tell lobes apart: all alike, one side, a slope, a ripple.
pub const G: [fn(Vec3) -> f64; 4] = [
    |_| 1.0,
    |w| if w.z > 0.0 { 1.0 } else { 0.0 },
    |w| f64::from(1.0 + w.dot(Vec3::new(0.6, 0.0, 0.8))),
    |w| f64::from(1.0 + 0.5 * (5.0 * w.x).sin()),
];

/// The differences between the sampled and the integrated moments, one a function, as (p-value, words).
pub fn differences(f: &dyn Scatter, wo: Vec3, seed: u64) -> Vec<(f64, String)> {
    let mut moments = G.map(|_| Moments::default());
    let mut numbers = rng(seed);
    for _ in 0..8_000 {
        let s = f.sample(wo, numbers.u1(), numbers.u2()).filter(|s| !s.pdf.is_delta());
        for (m, g) in moments.iter_mut().zip(G) {
            m.add(s.map_or(0.0, |s| f64::from(s.weight[0]) * g(s.wi)));
        }
    }
    let compare = |(m, expected): (&Moments, f64)| {
        let test = z_test(m, expected);
        // Where weights do not vary the quadrature's own error is all there is.
        let p = if (m.mean - expected).abs() < 1e-4 + 1e-3 * expected { 1.0 } else { test.p_value };
        (p, format!("sampled {} ± {}, integrated {expected}", m.mean, m.standard_error()))
    };
    moments.iter().zip(integrals(f, wo)).map(compare).collect()
}

/// ∫ f g |cosθ_i| dwi for every g, by midpoints on a grid that is fine where lobes are narrow: at the poles and the horizon
/// (θ = ½π (3t² - 2t³) in each hemisphere) and around the azimuth of the mirror direction (φ = π s³).
fn integrals(f: &dyn Scatter, wo: Vec3) -> [f64; 4] {
    const N: usize = 128;
    let mirror = f64::from(-wo.y).atan2(f64::from(-wo.x));
    let mut sums = [0.0; 4];
    for i in 0..2 * N {
        let t = ((i % N) as f64 + 0.5) / N as f64;
        let theta = 0.5 * PI * t * t * (3.0 - 2.0 * t) + if i < N { 0.0 } else { 0.5 * PI };
        let (sin, cos) = theta.sin_cos();
        let rows = 3.0 * PI * t * (1.0 - t) / N as f64;
        for j in 0..2 * N {
            let s = (j as f64 + 0.5) / N as f64 - 1.0;
            let (sin_phi, cos_phi) = (mirror + PI * s * s * s).sin_cos();
            let wi = Vec3::new((sin * cos_phi) as f32, (sin * sin_phi) as f32, cos as f32);
            let value = f64::from(f.eval(wo, wi)[0]) * cos.abs() * sin * rows * 3.0 * PI * s * s / N as f64;
            if value > 0.0 {
                sums.iter_mut().zip(G).for_each(|(sum, g)| *sum += value * g(wi));
            }
        }
    }
    sums
}

/// Whether a smooth lobe is too narrow for the grid (Dirac lobes have roughness 0 and do not count).
fn narrow(f: &dyn Scatter) -> bool {
    (1e-6..0.04).contains(&f.roughness())
}

#[test]
fn weights_integrate_f() {
    let rows: Vec<_> = models::rows().into_iter().filter(|r| r.bsdf.events().has_smooth() && !narrow(&r.bsdf)).collect();
    let alpha = family_wise(FALSE_ALARMS, rows.len() * directions().len() * G.len());
    let mut faults = Vec::new();
    for row in &rows {
        for (k, wo) in directions().into_iter().enumerate() {
            for (i, (p, words)) in differences(&row.bsdf, wo, 101 + k as u64).into_iter().enumerate() {
                if p < alpha {
                    faults.push(format!("{} from {wo}, g{i}: {words}, p = {p:.2e}", row.name));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}
