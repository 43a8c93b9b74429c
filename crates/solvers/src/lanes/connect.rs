//! Connections to light points, on lanes: `transport::connection` for Lambert's surfaces.
//!
//! ```text
//! contribution = β f |cosθ| Le w(p_l, p_b) / p_l,    f = ρ/π and p_b = cosθ/π above the surface
//! ```

use super::vertices::Vertices;
use crate::transport::{Heuristic, mis_weight};
use etendue_numerics::math::FRAC_1_PI;
use etendue_numerics::ray::offset_origin;
use etendue_numerics::wide;
use etendue_scene::interaction::SHADOW_EPSILON;

/// Makes shadow rays and contributions of the light samples.
pub(super) struct Connect<'a> {
    pub vertices: &'a mut Vertices,
    pub heuristic: Heuristic,
}

impl wide::Job for Connect<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        match self.heuristic {
            Heuristic::Balance => weigh(self.vertices, |p, q| mis_weight(Heuristic::Balance, p, q)),
            Heuristic::Power => weigh(self.vertices, |p, q| mis_weight(Heuristic::Power, p, q)),
        }
        aim(self.vertices);
    }
}

/// What the light points add to the picture, if nothing is in between.
#[inline(always)]
fn weigh(v: &mut Vertices, weight: impl Fn(f32, f32) -> f32) {
    for i in 0..v.lanes() {
        let frame = v.frame(i);
        let (wo, wi) = (frame.n.dot(v.wo.get(i)), frame.n.dot(v.light.wi.get(i)));
        // Seen from above, or from below where that is a front as well.
        let turned = v.is_turned[i] != 0;
        let (above_o, above_i) = if turned { (-wo, -wi) } else { (wo, wi) };
        let scatters = above_o > 0.0 && above_i > 0.0;
        // What the frame of a back rounds.
        let tilt = if turned { above_i.abs() / wi.abs().max(1e-8) } else { 1.0 };
        let (rho, cos) = (v.rho.get(i), wi.abs());
        let f = [
            rho[0] * FRAC_1_PI * tilt * cos,
            rho[1] * FRAC_1_PI * tilt * cos,
            rho[2] * FRAC_1_PI * tilt * cos,
            rho[3] * FRAC_1_PI * tilt * cos,
        ];
        let p_b = above_i.max(0.0) * FRAC_1_PI;

        let (le, p_l) = (v.light.le.get(i), v.light.pdf[i]);
        let share = if v.light.is_delta[i] != 0 { 1.0 } else { weight(p_l, p_b) };
        let (beta, share) = (v.beta.get(i), share / p_l);
        v.contribution.set(
            i,
            [
                beta[0] * (f[0] * le[0]) * share,
                beta[1] * (f[1] * le[1]) * share,
                beta[2] * (f[2] * le[2]) * share,
                beta[3] * (f[3] * le[3]) * share,
            ],
        );
        let something = (f[0] != 0.0) | (f[1] != 0.0) | (f[2] != 0.0) | (f[3] != 0.0);
        let bright = (le[0] != 0.0) | (le[1] != 0.0) | (le[2] != 0.0) | (le[3] != 0.0);
        v.is_lit[i] = v.light.is_there[i] & u32::from(scatters & something & bright);
    }
}

/// The rays that must arrive unhindered: `LightSample::shadow_ray`.
#[inline(always)]
fn aim(v: &mut Vertices) {
    for i in 0..v.lanes() {
        let (p, q, wi) = (v.p.get(i), v.light.p.get(i), v.light.wi.get(i));
        let near = v.light.is_near[i] != 0;
        let o = offset_origin(p, v.p_error.get(i), v.n.get(i), if near { q - p } else { wi });
        let d = q - o;
        let distance = d.length();
        let apart = (distance > 0.0) & (distance < f32::INFINITY);
        v.shadow.o.set(i, o);
        v.shadow.d.set(i, if near { d / distance } else { wi });
        v.shadow_end[i] = if near { distance * (1.0 - SHADOW_EPSILON) } else { f32::INFINITY };
        v.is_lit[i] &= u32::from(!near | apart);
    }
}
