//! `hierarchical`: links between clusters of patches, each at the coarsest level that a stated error allows.
//!
//! ```text
//! B_i = Be_i + ρ_i (E_i + Σ_{R holding i} Σ_links k A_S B_S)        clusters R, S of all sizes
//! ```
//!
//! | | file |
//! | --- | --- |
//! | clusters | `tree.rs` |
//! | rays from all patches | `rays.rs` |
//! | links of rays, each at the level that they allow | `refine.rs` |
//! | links with what emits light | `lamps.rs` |
//! | F b: pull, gather, push | `carry.rs` |
//! | rows that close | `closure.rs` |
//! | how wrong the solution may be | `bound.rs` |
//!
//! It goes in rounds: cast rays from every patch, as many again as there are; make links of them; sweep; bound the error. Rounds end when the bound is not above the
//! stated error. Which links are made depends on brightness; that comes from the round before, in the first from the mean light of the scene.
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `error` | bound on ‖B - B*‖ / ‖B - Be‖, over patches and channels by area, that ends refinement | 0.2 |
//! | `seed` | of the rays | 0 |
//! | `memory` | bytes that rays and links may take; there refinement ends, as it does where more rays no longer lower the bound, and the report tells the bound that was reached | – |
//!
//! B* solves the equation of the same patches with exact factors: what patches are too large for is not in the bound. Rays of a cluster serve all its patches, so
//! the finer a scene is cut the fewer rays a patch are needed for one error, [`FIRST`] at least.

mod bound;
mod carry;
mod closure;
mod lamps;
mod rays;
mod refine;
mod tree;

pub use tree::{Node, Tree};

use crate::form_factor::{Cancelled, Repair, Sight, Watch};
use crate::patch::Patches;
use crate::solve::{Equation, Exchange, rgb};
use carry::Rows;
use closure::{Links, Scales};
use etendue_scene::Scene;
use glam::DVec3;
use lamps::Lamps;
use rays::{Caster, Samples};
use refine::{Refinement, lights};

/// Parameters of the method.
#[derive(Clone, Copy, Debug)]
pub struct Hierarchical {
    /// The bound on the error that ends refinement.
    pub error: f64,
    /// Of the rays.
    pub seed: u64,
    /// Bytes that rays and links may take.
    pub memory: u64,
}

impl Default for Hierarchical {
    fn default() -> Self {
        Self { error: 0.2, seed: 0, memory: u64::MAX }
    }
}

/// What two clusters exchange: k A_S B_S W/m² arrive at the first from the second, and k A_R B_R the other way.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Link {
    /// The clusters, [R, S].
    ends: [u32; 2],
    /// Mean of V cosθ cosθ / (π r²), 1/m².
    k: f32,
}

/// Rays a patch of the first round, and rounds at most, each with as many rays as all before.
pub const FIRST: usize = 32;
const ROUNDS: usize = 9;

/// Points on either side that lamps are looked at by in the first round.
const POINTS: usize = 2;

/// Sweeps of a round, and the change of the light at which fewer do.
const SWEEPS: usize = 16;
const SETTLED: f64 = 1e-2;

/// More rays are worth their while as long as the bound falls at least to this part of what it was.
const WORTH: f64 = 0.95;

/// How near to one rows get, in a round and in the end.
const CLOSED: [f64; 2] = [1e-3, 1e-7];

/// What a link may send wrong, in parts of the stated error of all reflected light.
const THRESHOLD: f64 = 1e-8;

/// The first of the sets of rays that check.
const CHECK: u64 = 1 << 20;

/// Bytes of a ray, and of a link both ways.
const BYTES: [u64; 2] = [8, 28];

/// Links that carry light between all patches.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    tree: Tree,
    rows: Links,
    /// A_i, m².
    areas: Vec<f64>,
    scales: Scales,
    /// The parts of the light of each patch that escape, and that are absorbed by what is no patch, as rays found them.
    measured: Vec<[f64; 2]>,
    /// The bound on ‖B - B*‖ / ‖B - Be‖.
    pub bound: f64,
    /// How many pairs of clusters are linked.
    pub links: usize,
    /// Rays from each patch that they are made of.
    pub rays: usize,
    /// Whether the bound is as low as was asked.
    pub reached: bool,
    /// What closing the rows took.
    pub repair: Repair,
}

impl Exchange for Hierarchy {
    fn multiply(&self, b: &[DVec3]) -> Vec<DVec3> {
        self.scales.carry(&self.tree, &self.rows, &self.areas, b)
    }

    fn lost(&self, i: usize) -> [f64; 2] {
        self.scales.lost[i]
    }
}

impl Hierarchy {
    /// Links the patches of a scene, of which the parts `open` are not covered, under irradiance `direct` from lights that are no patches.
    /// `watch` hears how many patches of all have cast their rays of a round, and `false` ends with the round before, if there was any; `told` hears how many
    /// rays a patch there were after a round and the bound, and `false` ends with that. Returns B as well, as far as the last round has swept.
    pub fn new(
        scene: &Scene,
        patches: &Patches,
        open: &[f64],
        direct: &[DVec3],
        method: &Hierarchical,
        watch: &Watch<'_>,
        told: &(dyn Fn(usize, f64) -> bool + Sync),
    ) -> Result<(Self, Vec<DVec3>), Cancelled> {
        let areas: Vec<f64> = patches.patches.iter().map(|p| p.area).collect();
        let tree = Tree::new(patches, |i| open[i as usize] > 0.0);
        let whole: Vec<f32> = tree.order.iter().map(|i| (areas[*i as usize] / open[*i as usize]) as f32).collect();
        let caster = Caster { scene, patches, open, seed: method.seed };
        let rho: Vec<DVec3> = patches.patches.iter().map(|p| rgb(p.rho)).collect();
        let (mut b, reflected) = guess(patches, direct);
        let power = tree.sums(|i| (rgb(patches.get(i).be) * areas[i as usize]).element_sum(), 0.0);
        let lamps = Lamps::new(patches, &tree, Sight::new(scene, patches), &whole, power, method.seed);
        let mut samples = Samples::default();
        let mut found: Option<Self> = None;
        for round in 0..ROUNDS {
            let more = samples.rays.max(FIRST);
            let links = found.as_ref().map_or(0, |f: &Self| f.links) as u64;
            let bytes = (tree.order.len() * (samples.rays + more)) as u64 * BYTES[0] + 2 * links * BYTES[1];
            let fits = bytes <= method.memory || found.is_none();
            if !fits || !samples.cast_more(&caster, &tree, more, &|k| watch(k, tree.order.len())) {
                break;
            }
            let lights = lights(&tree, &areas, &rho, &b);
            let threshold = (THRESHOLD * method.error * reflected) as f32;
            let refinement = Refinement { tree: &tree, lights: &lights, areas: &whole, rays: samples.rays, threshold };
            let (within, across) = (refinement.links(&mut samples.pairs), lamps.links(POINTS << (round / 2)));
            let [links, rays] = [within.len() + across.len(), samples.rays];
            let [within, across] = [within, across].map(|links| Rows::new(tree.nodes.len(), &links));
            let rows = Links { within, across };
            let measured = closure::losses(&tree, &samples, &caster);
            let is_lamp = |i: usize| lamps.is_lamp(i as u32);
            let (scales, repair) = closure::close(&tree, &rows, &areas, &measured, is_lamp, CLOSED[0]);
            let (tree, areas) = (tree.clone(), areas.clone());
            let mut carrier = Self { tree, rows, areas, scales, measured, bound: 0.0, links, rays, reached: false, repair };
            let equation = Equation::new(patches, &carrier, direct.to_vec());
            for _ in 0..SWEEPS {
                let h = equation.irradiance(&b);
                let next: Vec<DVec3> = (0..b.len()).map(|i| equation.be[i] + equation.rho[i] * h[i]).collect();
                let change: Vec<DVec3> = next.iter().zip(&b).map(|(x, y)| *x - *y).collect();
                b = next;
                if equation.norm(&change) <= SETTLED * reflected {
                    break;
                }
            }
            let bound = bound::bound(&caster, &lamps, &equation, &b, method.error, CHECK + round as u64);
            (carrier.bound, carrier.reached) = (bound, bound <= method.error);
            let before = found.as_ref().map_or(f64::INFINITY, |f| f.bound);
            if bound < before {
                found = Some(carrier);
            }
            if !told(samples.rays, bound) || bound <= method.error || bound > WORTH * before {
                break;
            }
        }
        let mut found = found.ok_or(Cancelled)?;
        let is_lamp = |i: usize| lamps.is_lamp(i as u32);
        (found.scales, found.repair) = closure::close(&found.tree, &found.rows, &areas, &found.measured, is_lamp, CLOSED[1]);
        Ok((found, b))
    }

    /// Bytes that it holds.
    pub fn bytes(&self) -> usize {
        self.rows.within.bytes() + self.rows.across.bytes() + self.tree.nodes.len() * size_of::<Node>() + self.areas.len() * 60
    }
}

/// Radiosities as if all light that is reflected were spread evenly, and how much of it there is in W over channels.
fn guess(patches: &Patches, direct: &[DVec3]) -> (Vec<DVec3>, f64) {
    let all = patches.patches.iter().zip(direct);
    let [area, light, rho] = all.fold([DVec3::ZERO; 3], |[area, light, rho], (p, e)| {
        [area + p.area, light + (rgb(p.be) + rgb(p.rho) * *e) * p.area, rho + rgb(p.rho) * p.area]
    });
    let rho = (rho / area).min(DVec3::splat(0.95));
    let even = light / area / (DVec3::ONE - rho);
    let b = patches.patches.iter().zip(direct).map(|(p, e)| rgb(p.be) + rgb(p.rho) * (*e + even)).collect();
    let reflected = (rho * even * area).element_sum();
    (b, if reflected > 0.0 { reflected } else { 1.0 })
}
