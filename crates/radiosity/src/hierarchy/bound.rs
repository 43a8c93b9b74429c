//! How wrong a solution may be: asked of rays that had no part in it.
//!
//! ```text
//! r_i = ρ_i (F* B - F B)_i                     what exact factors would change at once;  (F* B)_i: by rays from i, and to lamps
//! w = 1 + F (ρ w)                              what a watt that is wrong at a patch makes wrong in all, after it is reflected again
//! Σ A |B - B*| ≤ Σ A w |r|                     up to (F* - F) in w, an error of second order
//! bound = S (mean of |F* B - F B| / (H + mean H) over patches drawn by s, + t · its standard error) / Σ A (B - Be)
//! s = A w ρ (H + mean H),  S = Σ s
//! ```
//!
//! From (I - ρ F*)(B - B*) = ρ (F - F*) B with I - ρ F* an M-matrix, as all error analysis of radiosity [Lischinski, Smits, Greenberg 1994]. What the links have
//! wrong for whatever reason is in it: their levels, their noise, lamps, neighbours, the closing of rows. Noise of the check itself makes |r| larger on the
//! whole, never smaller; there are so many rays that this is about an eighth of the stated error. Patches are drawn by their light, too, for a few next to
//! lamps hold much of the error: drawn by A w ρ alone they made the bound jump by a fifth from round to round. Rays from patches that meet lamps are left to [`super::lamps`], with points of its own and more of them.

use super::lamps::Lamps;
use super::rays::Caster;
use crate::form_factor::Landing;
use crate::solve::{Equation, Exchange, Until, neumann};
use etendue_numerics::sequence::{mix, unit};
use glam::DVec3;
use rayon::prelude::*;

/// Patches that are asked.
pub const ASKED: usize = 1024;

/// Rays of each, times the square of the stated error.
const RAYS: f64 = 64.0;

/// Quantile of Student's t for one-sided 99.5 % with a thousand degrees of freedom.
const T: f64 = 2.58;

/// The bound on ‖B - B*‖ / ‖B - Be‖, ‖x‖ = Σ A |x| over patches and channels, for radiosities b; holds with 99.5 %.
pub fn bound<F: Exchange>(
    caster: &Caster<'_>,
    lamps: &Lamps<'_>,
    equation: &Equation<'_, F>,
    b: &[DVec3],
    stated: f64,
    set: u64,
) -> f64 {
    let n = b.len();
    let errors = Equation {
        exchange: equation.exchange,
        areas: equation.areas.clone(),
        rho: equation.rho.clone(),
        be: equation.rho.clone(),
        direct: vec![DVec3::ZERO; n],
    };
    // ρ w = ρ + ρ F (ρ w).
    let until = Until { residual: 1e-2, sweeps: 1000, watch: &|_, _| true };
    let weights = neumann::solve(&errors, &until).b;
    let h = equation.exchange.multiply(b);
    let (light, area) = h.iter().zip(&equation.areas).fold((DVec3::ZERO, 0.0), |(s, t), (h, a)| (s + *h * *a, t + a));
    let even = light / area;
    // What is expected of each patch.
    let share: Vec<f64> = (0..n).map(|i| (weights[i] * (h[i] + even)).element_sum()).collect();
    let mut up_to = Vec::with_capacity(n);
    let mut sum = 0.0;
    for (i, (share, a)) in share.iter().zip(&equation.areas).enumerate() {
        sum += if caster.open[i] > 0.0 { share * a } else { 0.0 };
        up_to.push(sum);
    }
    if sum <= 0.0 {
        return 0.0;
    }
    let rays = (RAYS / (stated * stated)).clamp(256.0, f64::from(1 << 16)) as usize;
    let asked = |k: usize| {
        let u = (k as f64 + f64::from(unit(mix(caster.seed ^ mix(k as u64 ^ set << 32)) as u32))) / ASKED as f64;
        let i = up_to.partition_point(|s| *s <= u * sum).min(n - 1);
        let mut light = DVec3::ZERO;
        caster.cast(i as u32, rays, set, |landing| {
            if let Landing::Patch(j) = landing
                && (!lamps.is_lamp(j) || lamps.is_lamp(i as u32))
            {
                light += b[j as usize];
            }
        });
        let exact = light / (rays as f64 * caster.open[i]) + lamps.irradiance(i as u32, b);
        // Channels in the proportion of their weights.
        ((exact - h[i]).abs() * weights[i]).element_sum() / share[i]
    };
    let off: Vec<f64> = (0..ASKED).into_par_iter().map(asked).collect();
    let m = ASKED as f64;
    let mean = off.iter().sum::<f64>() / m;
    let variance = off.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (m - 1.0);
    let light: Vec<DVec3> = b.iter().zip(&equation.be).map(|(b, be)| *b - *be).collect();
    let light = equation.norm(&light).max(f64::MIN_POSITIVE);
    (mean + T * (variance / m).sqrt()) * sum / light
}
