//! Distribution ray tracing [Cook, Porter, Carpenter 1984]: a tree whose rays are spread over what makes edges soft.
//!
//! ```text
//! L(x, wo) = Le + Σ_j w_j L(RT(x, w_j), -w_j)                                      mirrors and clear glass: each direction once
//!          + 1/n_l Σ w_l f cosθ Le(y) V / p_l  +  1/n_b Σ [ w_b Le(x') + L'(x') ] f cosθ / p_b      x' = RT(x, w)
//! ```
//!
//! | effect | rays | parameter |
//! | --- | --- | --- |
//! | soft shadows | n_l light points at each hit | `shadow_samples`, 4 |
//! | gloss, frosted glass | n_b draws at a glossy hit | `gloss_samples`, 4 |
//! | light from diffuse surfaces | that many draws more at a diffuse hit; not part of the original | `diffuse_samples`, 0 |
//! | depth of field, motion, edges of pixels | one camera ray a sample | `--spp` |
//!
//! L' is L without the Le at x'; the power heuristic of n p shares Le between light points and draws [Veach, Guibas 1995, eq. 14]. A draw goes on (L') where its
//! kind of scattering has samples of its own; any other ends at x' and counts for its Le alone, and each hit makes one draw at least, so that
//! direct light is whole whatever the numbers: what is left out is light by way of scattering whose number is 0. With both above 0 nothing is, and
//! the mean is that of `path-mis`.
//!
//! Deeper levels matter less: each turn by a draw divides the numbers by 4, rounded up. From vertex `rr_depth` (or 8) on roulette prunes the tree.
//! The draws of a hit are stratified among each other and over the samples of the pixel.

use crate::drivers::PixelSolver;
use crate::parameters::{MOST_SAMPLES, Parameter, Slot};
use crate::solver::Estimates;
use crate::transport::{Branch, Context, Heuristic, PathState, Vertex, arrives, emission, mis_weight, next_event, slot};
use etendue_bsdf::{Event, Scatter};
use etendue_numerics::{Pdf, Sampler, Spectrum};

/// The solver `distribution`.
#[derive(Clone, Copy, Debug)]
pub struct Distribution {
    /// Light points at a hit, n_l.
    pub shadow_samples: u32,
    /// Draws at a glossy hit.
    pub gloss_samples: u32,
    /// Draws at a diffuse hit.
    pub diffuse_samples: u32,
}

impl Default for Distribution {
    fn default() -> Self {
        Self { shadow_samples: 4, gloss_samples: 4, diffuse_samples: 0 }
    }
}

impl Distribution {
    /// What users may set.
    pub const PARAMETERS: &'static [Parameter<Self>] = &[
        Parameter {
            name: "shadow_samples",
            summary: "light points at a hit: soft shadows",
            slot: |s| Slot::Count(&mut s.shadow_samples, 0..=MOST_SAMPLES),
        },
        Parameter {
            name: "gloss_samples",
            summary: "directions at a glossy hit: blurred reflections and refractions",
            slot: |s| Slot::Count(&mut s.gloss_samples, 0..=MOST_SAMPLES),
        },
        Parameter {
            name: "diffuse_samples",
            summary: "directions at a diffuse hit: light by way of diffuse surfaces, which the original does not know",
            slot: |s| Slot::Count(&mut s.diffuse_samples, 0..=MOST_SAMPLES),
        },
    ];

    /// Whether light that comes by this kind of scattering is followed beyond the lights.
    fn follows(&self, event: Event) -> bool {
        event.intersects(Event::GLOSSY) && self.gloss_samples > 0 || event.intersects(Event::DIFFUSE) && self.diffuse_samples > 0
    }

    /// n_l and n_b at a hit after `turns` turns by draws.
    fn numbers(&self, events: Event, turns: u32) -> (u32, u32) {
        let fewer = |n: u32| n.div_ceil(1 << (2 * turns).min(16));
        let of = |kind: Event, n: u32| if events.intersects(kind) { n } else { 0 };
        let draws = of(Event::GLOSSY, self.gloss_samples) + of(Event::DIFFUSE, self.diffuse_samples);
        (fewer(self.shadow_samples), fewer(draws).max(1))
    }
}

/// A branch about to be cast.
#[derive(Clone, Copy)]
struct Open {
    walk: PathState,
    at: Branch,
    /// Turns by draws so far.
    turns: u32,
    /// Only Le at the end counts.
    le_only: bool,
    /// n_l and n_b where the last draw was made.
    numbers: (f32, f32),
}

impl PixelSolver for Distribution {
    fn estimates(&self) -> Estimates {
        if self.gloss_samples > 0 && self.diffuse_samples > 0 {
            Estimates::Light
        } else {
            Estimates::Other {
                words: "light that came by way of the kinds of scattering that have samples, and direct light",
                diffuse: (self.diffuse_samples == 0).then_some(2),
            }
        }
    }

    fn radiance(&self, c: &Context<'_>, eye: PathState, u: &Sampler, rays: &mut u64) -> Spectrum {
        let c = &Context { rules: c.rules.of_tree(), ..*c };
        let mut l = Spectrum::ZERO;
        let mut open = vec![Open { walk: eye, at: Branch::ROOT, turns: 0, le_only: false, numbers: (0.0, 1.0) }];
        while let Some(mut branch) = open.pop() {
            // Emission that the branch meets, shared with the light points of the hit it comes from.
            *rays += 1;
            let walk = &mut branch.walk;
            let x = c.scene.intersect(&walk.ray).map(|hit| c.scene.interaction(&walk.ray, &hit));
            let (le, p_light) = emission(c, walk, x.as_ref());
            let (n_l, n_b) = branch.numbers;
            let share = match walk.pdf {
                Pdf::SolidAngle(p_bsdf) => mis_weight(Heuristic::Power, n_b * p_bsdf, n_l * p_light),
                Pdf::Delta(_) => 1.0,
            };
            walk.collect(&c.rules, le * share);
            l += walk.l;
            walk.l = Spectrum::ZERO;

            let end = c.ends(walk) || branch.le_only && !c.scene.has_transparent;
            let Some(x) = x.filter(|_| !end) else { continue };
            let vertex = branch.walk.vertex(c.scene, x);
            follow_diracs(c, &branch, &vertex, u, &mut open);
            if vertex.is_smooth() && !branch.le_only {
                l += self.shadows(c, &branch, &vertex, u, rays);
                self.draw(c, &branch, &vertex, u, &mut open);
            }
        }
        l
    }
}

/// Perfect reflection and refraction; a branch that has only Le to find looks straight through and no other way.
fn follow_diracs(c: &Context<'_>, branch: &Open, vertex: &Vertex, u: &Sampler, open: &mut Vec<Open>) {
    let mut i = 0;
    vertex.diracs(|s| {
        i += 1;
        let at = branch.at.child(MOST_SAMPLES + i);
        let mut next = Open { at, ..*branch };
        let u_roulette = u.u1(at.dim(slot::LOBE));
        if (s.is_null || !branch.le_only) && next.walk.turn(&c.rules, vertex, Some(s), u_roulette) {
            open.push(next);
        }
    });
}

impl Distribution {
    /// Light points.
    fn shadows(&self, c: &Context<'_>, branch: &Open, vertex: &Vertex, u: &Sampler, rays: &mut u64) -> Spectrum {
        let (shadows, draws) = self.numbers(vertex.bsdf.events(), branch.turns);
        let (n_l, n_b) = (shadows as f32, draws as f32);
        let walk = PathState { vertex: branch.at.vertex(), ..branch.walk };
        let mut l = Spectrum::ZERO;
        for i in 0..shadows {
            let share = |p_light, p_bsdf| mis_weight(Heuristic::Power, n_l * p_light, n_b * p_bsdf);
            if let Some(query) = next_event(c, &walk, vertex, &u.part(i, shadows), share) {
                *rays += 1;
                l += arrives(c, &query, &walk.wl) / n_l;
            }
        }
        l
    }

    /// Directions as the surface scatters; discrete ones have been followed already.
    fn draw(&self, c: &Context<'_>, branch: &Open, vertex: &Vertex, u: &Sampler, open: &mut Vec<Open>) {
        let (shadows, draws) = self.numbers(vertex.bsdf.events(), branch.turns);
        for i in 0..draws {
            let u = u.part(i, draws);
            let u_lobe = u.u2(branch.at.dim(slot::LOBE));
            let sample = vertex.sample(u_lobe.x, u.u2(branch.at.dim(slot::BSDF)));
            let Some(mut s) = sample.filter(|s| !s.pdf.is_delta()) else { continue };
            s.weight /= draws as f32;
            let mut next = Open {
                at: branch.at.child(i),
                turns: branch.turns + 1,
                le_only: !self.follows(s.event),
                numbers: (shadows as f32, draws as f32),
                ..*branch
            };
            if next.walk.turn(&c.rules, vertex, Some(s), u_lobe.y) {
                open.push(next);
            }
        }
    }
}
