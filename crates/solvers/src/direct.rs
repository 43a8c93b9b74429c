//! Direct light alone: what the eye sees of the emitters and of surfaces that they light, with several samples of each kind.
//!
//! ```text
//! L = Le(x) + 1/n_l Σ w_l f cosθ Le(y) V / p_l + 1/n_b Σ w_b f cosθ Le(RT(x, w)) / p_b
//! ```
//!
//! The weights are the power heuristic of n p [Veach, Guibas 1995, eq. 14]. Paths have two edges at most, and passing a null or mask surface
//! is an edge: what a mask lets through is seen, but a mask's shadow is whole.

use crate::drivers::PixelSolver;
use crate::parameters::{MOST_SAMPLES, Parameter, Slot};
use crate::solver::Estimates;
use crate::transport::{Context, Heuristic, PathRules, PathState, arrives, emission, mis_weight, next_event, slot};
use etendue_numerics::{Dim, Pdf, Sampler, Spectrum};

/// The solver `direct`.
#[derive(Clone, Copy, Debug)]
pub struct Direct {
    /// Light samples per hit, n_l.
    pub emitter_samples: u32,
    /// Material samples per hit, n_b.
    pub bsdf_samples: u32,
}

impl Direct {
    /// What users may set.
    pub const PARAMETERS: &'static [Parameter<Self>] = &[
        Parameter {
            name: "emitter_samples",
            summary: "light points at a hit",
            slot: |s| Slot::Count(&mut s.emitter_samples, 0..=MOST_SAMPLES),
        },
        Parameter {
            name: "bsdf_samples",
            summary: "directions at a hit",
            slot: |s| Slot::Count(&mut s.bsdf_samples, 0..=MOST_SAMPLES),
        },
    ];
}

impl PixelSolver for Direct {
    fn estimates(&self) -> Estimates {
        Estimates::LightUpTo(2)
    }

    fn radiance(&self, c: &Context<'_>, mut eye: PathState, u: &Sampler, rays: &mut u64) -> Spectrum {
        let (n_l, n_b) = (self.emitter_samples as f32, self.bsdf_samples as f32);
        // Walks of one vertex need no roulette.
        let rules = PathRules { max_edges: c.rules.max_edges.min(2), rr_depth: Some(u32::MAX), null_counts: true, ..c.rules };
        let c = &Context { rules, ..*c };
        *rays += 1;
        let x = c.scene.intersect(&eye.ray).map(|hit| c.scene.interaction(&eye.ray, &hit));
        eye.collect(&c.rules, emission(c, &eye, x.as_ref()).0);
        let Some(x) = x.filter(|_| c.rules.counts(2)) else { return eye.l };
        let vertex = eye.vertex(c.scene, x);

        for i in 0..self.emitter_samples {
            eye.vertex = 1 + i;
            let share = |p_light, p_bsdf| mis_weight(Heuristic::Power, n_l * p_light, n_b * p_bsdf);
            if let Some(query) = next_event(c, &eye, &vertex, u, share) {
                *rays += 1;
                eye.l += arrives(c, &query, &eye.wl) / n_l;
            }
        }

        for i in 0..self.bsdf_samples {
            let Some(s) = vertex.sample(u.u1(Dim::at(1 + i, slot::LOBE)), u.u2(Dim::at(1 + i, slot::BSDF))) else { continue };
            let mut walk = eye;
            if !walk.turn(&c.rules, &vertex, Some(s), 0.0) {
                continue;
            }
            *rays += 1;
            let y = c.scene.intersect(&walk.ray).map(|hit| c.scene.interaction(&walk.ray, &hit));
            let (le, p_light) = emission(c, &walk, y.as_ref());
            let share = match walk.pdf {
                // Without light samples nothing else finds this light.
                Pdf::SolidAngle(p_bsdf) => mis_weight(Heuristic::Power, n_b * p_bsdf, n_l * p_light),
                Pdf::Delta(_) => 1.0,
            };
            eye.l += walk.beta.carry(le) * (share / n_b);
        }
        eye.l
    }
}
