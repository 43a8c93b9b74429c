//! The next direction of guided walks, on lanes: `Guided::step` for Lambert's surfaces.
//!
//! ```text
//! wi ~ p = a p_b + (1 - a) p_g,    β ← β ρ (p_b / p),    p_b = cosθ/π
//! ```
//!
//! What the guide says of a direction is looked up walk by walk, its targets on lanes.

use super::turn::{aim, survive};
use super::vertices::Vertices;
use super::{Turns, draw};
use crate::path_guided::field::Field;
use crate::path_guided::walk::{self, Guided};
use crate::path_mis::PathMis;
use crate::transport::slot;
use etendue_numerics::math::FRAC_1_PI;
use etendue_numerics::ray::offset_origin;
use etendue_numerics::{Dim, Vec2, wide};

impl Turns for Guided<'_> {
    const HOPE: f32 = walk::HOPE;
    const ALIKE: bool = false;

    fn mis(&self) -> &PathMis {
        &self.mis
    }

    fn turn(&self, v: &mut Vertices, vertex: u32, roulette: bool) {
        draw(&v.samplers, Dim::at(vertex, slot::BSDF), &mut v.u_bsdf);
        draw(&v.samplers, Dim::at(vertex, slot::LOBE), &mut v.u_lobe);
        wide::widest(Aim(v));
        wide::widest(Ask(v, self.field));
        wide::widest(Weigh { v, is_first: vertex == 1, roulette });
    }
}

/// p_g of the BSDF's directions, or other directions with theirs.
struct Ask<'a>(&'a mut Vertices, &'a Field);

impl wide::Job for Ask<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let v = self.0;
        for i in 0..v.count() {
            let (n, wo, p) = (v.n.get(i), v.wo.get(i), v.p.get(i));
            let leaf = self.1.at(p, if n.dot(wo) < 0.0 { -n } else { n });
            let chosen = v.u_lobe[0][i] >= leaf.fraction;
            v.guide.a[i] = leaf.fraction;
            v.guide.is_chosen[i] = u32::from(chosen);
            v.guide.pdf[i] = if chosen {
                let (wi, pdf) = leaf.guide.sample(p, Vec2::new(v.u_bsdf[0][i], v.u_bsdf[1][i]));
                v.ray.d.set(i, wi);
                pdf
            } else {
                leaf.guide.pdf(p, v.ray.d.get(i))
            };
        }
    }
}

/// The BSDF's directions.
struct Aim<'a>(&'a mut Vertices);

impl wide::Job for Aim<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        aim(self.0);
    }
}

/// What the walks carry on in the directions that were chosen.
struct Weigh<'a> {
    v: &'a mut Vertices,
    is_first: bool,
    roulette: bool,
}

impl wide::Job for Weigh<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let v = self.v;
        for i in 0..v.lanes() {
            let chosen = v.guide.is_chosen[i] != 0;
            let (a, p_g) = (v.guide.a[i], v.guide.pdf[i]);
            let found = v.ray.d.get(i);
            let frame = v.frame(i);
            let turned = v.is_turned[i] != 0;
            let (wo, wi) = (frame.n.dot(v.wo.get(i)), frame.n.dot(found));
            let (above_o, above_i) = if turned { (-wo, -wi) } else { (wo, wi) };
            let scatters = (above_o > 0.0) & (above_i > 0.0);
            // What the frame of a back rounds.
            let tilt = if turned { above_i.abs() / wi.abs().max(1e-8) } else { 1.0 };
            let (rho, cos) = (v.rho.get(i), wi.abs());

            let p_b = if chosen { above_i.max(0.0) * FRAC_1_PI } else { v.pdf[i] };
            let p = a * p_b + (1.0 - a) * p_g;
            let ratio = if chosen { p / p_b } else { a + (1.0 - a) * p_g / p_b };
            let f = [
                rho[0] * FRAC_1_PI * tilt * cos,
                rho[1] * FRAC_1_PI * tilt * cos,
                rho[2] * FRAC_1_PI * tilt * cos,
                rho[3] * FRAC_1_PI * tilt * cos,
            ];
            let (b, over) = (v.beta.get(i), if chosen { p } else { ratio });
            let w = if chosen { f } else { rho };
            let beta = [b[0] * (w[0] / over), b[1] * (w[1] / over), b[2] * (w[2] / over), b[3] * (w[3] / over)];
            let alive = (beta[0] != 0.0) | (beta[1] != 0.0) | (beta[2] != 0.0) | (beta[3] != 0.0);
            v.beta.set(i, beta);
            v.pdf[i] = p_b;
            v.roulette_scale[i] *= if self.is_first { 1.0 } else { ratio };
            let goes_on = if chosen { scatters } else { v.goes_on[i] != 0 };
            v.goes_on[i] = u32::from(goes_on & alive);

            v.ray.o.set(i, offset_origin(v.p.get(i), v.p_error.get(i), v.n.get(i), found));
        }
        if self.roulette {
            survive(v);
        }
    }
}
