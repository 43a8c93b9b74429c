//! Recursive ray tracing [Whitted 1980]: light from the lights and an ambient constant, and what mirrors and glass show of it.
//!
//! ```text
//! L(x, wo) = Le(x, wo) + Σ_k f cosθ Le(y_k) V / p_k + ρ_d L_a + Σ_j w_j L(RT(x, w_j), -w_j)
//! ```
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | k, y_k, p_k | the lights, all of them, and a point on each with its density | –, –, 1/sr |
//! | ρ_d | hemispherical diffuse reflectance: of glossy and mirrored light ambient light knows nothing | 1 |
//! | L_a | ambient radiance, parameter `ambient`, 0 unless given: stands for all light that came by way of other surfaces | W/(m² sr) |
//! | w_j | weights of the discrete directions: Fresnel's R and T, divided by η² where radiance leaves a denser medium | 1 |
//!
//! Both branches of glass are followed, so that a picture of mirrors, glass and point lights has no noise of its own. From vertex `rr_depth` (or
//! 8) on roulette prunes the tree. Glossy lobes reflect the lights and nothing else. With L_a = 0 the mean is the light of all paths L D? S* E, D a smooth
//! scattering and S a discrete one: in the furnace 1 + a at any depth.
//!
//! Ambient light counts as light of one bounce at the surface that reflects it: one edge more than the eye needs to get there.

use crate::drivers::{PixelSolver, Work, pixels};
use crate::parameters::{Parameter, Slot};
use crate::run::Run;
use crate::solver::{CannotGoOn, Estimates, Needs, Solver};
use crate::transport::{Branch, Context, EachLight, PathState, Vertex, arrives, connection, emission, slot};
use etendue_bsdf::Scatter;
use etendue_numerics::{Sampler, Spectrum, Vec3};
use etendue_scene::{Scene, texture::Role};

/// The solver `whitted`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Whitted {
    /// L_a, W/(m² sr).
    pub ambient: Spectrum,
}

impl Whitted {
    /// What users may set.
    pub const PARAMETERS: &'static [Parameter<Self>] = &[Parameter {
        name: "ambient",
        summary: "radiance that diffuse surfaces reflect everywhere, instead of light from other surfaces",
        slot: |s| Slot::Radiance(&mut s.ambient),
    }];
}

impl Solver for Whitted {
    type State = ();

    fn needs(&self) -> Needs {
        Needs::default()
    }

    fn estimates(&self) -> Estimates {
        Estimates::Other {
            words: "direct and ambient light, and what mirrors and glass show of it",
            diffuse: self.ambient.is_zero().then_some(2),
        }
    }

    fn splats(&self) -> bool {
        false
    }

    fn units(&self, size: [u32; 2]) -> usize {
        Tree { ambient: self.ambient, lights: EachLight::default() }.units(size)
    }

    fn prepare(&self, _: &Scene, _: &Run<'_>) {}

    fn pass(&self, scene: &Scene, run: &Run<'_>, (): &mut (), k: u32, work: &Work<'_>) -> Result<(), CannotGoOn> {
        pixels::pass(&Tree { ambient: self.ambient, lights: EachLight::new(scene) }, scene, run, k, work);
        Ok(())
    }
}

/// The tree of rays.
struct Tree {
    ambient: Spectrum,
    lights: EachLight,
}

impl PixelSolver for Tree {
    fn radiance(&self, c: &Context<'_>, eye: PathState, u: &Sampler, rays: &mut u64) -> Spectrum {
        let c = &Context { rules: c.rules.of_tree(), ..*c };
        let mut l = Spectrum::ZERO;
        let mut open = vec![(eye, Branch::ROOT)];
        while let Some((mut walk, at)) = open.pop() {
            *rays += 1;
            let x = c.scene.intersect(&walk.ray).map(|hit| c.scene.interaction(&walk.ray, &hit));
            walk.collect(&c.rules, emission(c, &walk, x.as_ref()).0);
            l += walk.l;
            let Some(x) = x.filter(|_| !c.ends(&walk)) else { continue };
            let vertex = walk.vertex(c.scene, x);
            l += self.local_illumination(c, &walk, at, &vertex, u, rays);

            // Perfect reflection and refraction.
            let mut branches = 0;
            vertex.diracs(|s| {
                let (mut next, branch) = (PathState { l: Spectrum::ZERO, ..walk }, at.child(branches));
                branches += 1;
                if next.turn(&c.rules, &vertex, Some(s), u.u1(branch.dim(slot::LOBE))) {
                    open.push((next, branch));
                }
            });
        }
        l
    }
}

impl Tree {
    /// Light that comes straight from the lights, and ambient light.
    fn local_illumination(
        &self,
        c: &Context<'_>,
        walk: &PathState,
        at: Branch,
        vertex: &Vertex,
        u: &Sampler,
        rays: &mut u64,
    ) -> Spectrum {
        let mut l = Spectrum::ZERO;
        if !vertex.is_smooth() || walk.edges >= c.rules.max_edges {
            return l;
        }
        if c.rules.counts(walk.edges + 1) {
            let ambient = Role::Emission.spectrum(self.ambient, &walk.wl);
            l += walk.beta.carry(diffuse_reflectance(vertex) * ambient);
        }
        let from = vertex.light_reference();
        for k in 0..self.lights.len() {
            let at = at.child(FIRST_LIGHT + k);
            let (u_primitive, u_point) = (u.u1(at.dim(slot::LIGHT)), u.u2(at.dim(slot::LIGHT_POINT)));
            let light = self.lights.sample(c.scene, k, &from, u_primitive, u_point, &walk.wl);
            if let Some(query) = light.and_then(|light| connection(walk, vertex, &light, |_, _| 1.0)) {
                *rays += 1;
                l += arrives(c, &query, &walk.wl);
            }
        }
        l
    }
}

/// Branches towards lights are numbered behind those of a surface's discrete directions.
const FIRST_LIGHT: u32 = 64;

/// ρ_d on the side of `wo`: none on the black back of a surface.
fn diffuse_reflectance(vertex: &Vertex) -> Spectrum {
    let above = Vec3::new(0.0, 0.0, vertex.wo.z.signum());
    if vertex.bsdf.eval(vertex.wo, above).is_zero() { Spectrum::ZERO } else { vertex.bsdf.diffuse_reflectance() }
}
