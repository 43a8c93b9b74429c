//! The photon map from its definition: every photon is looked at, the sight of each is tested, and P is an integral over a lattice.
//!
//! Slow, and the judge of `density`: at every radius both have the same mean. All light is brought by photons here, direct light too.

use super::density::Around;
use super::photons::Photons;
use super::{PhotonMap, State, radius};
use crate::drivers::pixels::{self, PixelSolver, Tiling};
use crate::drivers::{Books, Work};
use crate::run::Run;
use crate::solver::{CannotGoOn, Estimates, Needs, Solver};
use crate::transport::{Context, PathState, Vertex, slot};
use etendue_numerics::math::PI;
use etendue_numerics::{Dim, Frame, Ray, Sampler, Spectrum, Wavelengths};
use etendue_scene::Scene;

/// The solver by its definition.
#[derive(Clone, Copy, Debug)]
pub struct Literal(PhotonMap);

/// Points of the lattice along each side of the disc.
const LATTICE: i32 = 12;
const WL: Wavelengths = Wavelengths::Rgb;

impl Literal {
    /// The same as `solver`, direct light by photons.
    pub fn new(solver: PhotonMap) -> Self {
        Self(PhotonMap { direct: 0, ..solver })
    }

    /// L along a ray that is edge number `edges` of its path.
    fn radiance(&self, c: &Context<'_>, map: &Photons, ray: &Ray, edges: u32, at: u32, u: &Sampler) -> Spectrum {
        let seen = |le: Spectrum| if c.rules.counts(edges) { le } else { Spectrum::ZERO };
        let Some(hit) = c.scene.intersect(ray) else { return seen(c.scene.le_escaped(ray, &WL)) };
        let vertex = Vertex::new(c.scene, c.scene.interaction(ray, &hit), &WL);
        let mut l = seen(c.scene.le(&vertex.x, &WL)) + self.gathered(c, map, &vertex, edges);
        let sample = vertex.sample(u.u2(Dim::at(at, slot::LOBE)).x, u.u2(Dim::at(at, slot::BSDF)));
        if let Some(s) = sample.filter(|s| self.0.walks(s)) {
            let edges = edges + u32::from(c.rules.null_counts || !s.is_null);
            if edges <= c.rules.max_edges {
                l += s.weight * self.radiance(c, map, &vertex.x.spawn(s.wi), edges, at + 1, u);
            }
        }
        l
    }

    fn gathered(&self, c: &Context<'_>, map: &Photons, vertex: &Vertex, edges: u32) -> Spectrum {
        let (x, r) = (&vertex.x, map.index.radius());
        let around = Around::new(c, x, r);
        let kernel = |d2: f32| 2.0 / (PI * r * r) * (1.0 - d2 / (r * r)).max(0.0);
        let mut sum = Spectrum::ZERO;
        for (place, photon) in map.photons.iter().enumerate() {
            let y = map.index.point(place);
            let near = y.distance_squared(x.p) < r * r && around.continues_at(y, photon.n);
            if near && c.rules.counts(edges + photon.edges) && around.sees(y) {
                sum += self.0.brings(vertex, photon) * kernel(y.distance_squared(x.p));
            }
        }
        if sum.is_zero() {
            return sum;
        }

        // P, with what the lattice makes of 1 taken out.
        let frame = Frame::from_normal(around.n);
        let (mut there, mut all) = (0.0, 0.0);
        for (i, j) in (-LATTICE..LATTICE).flat_map(|i| (-LATTICE..LATTICE).map(move |j| (i, j))) {
            let [a, b] = [i, j].map(|i| (i as f32 + 0.5) / LATTICE as f32);
            let q = (frame.s * a + frame.t * b) * r;
            let weight = kernel(q.length_squared());
            all += weight;
            if weight > 0.0 && around.is_there(q, &mut 0) {
                there += weight;
            }
        }
        sum * (all / (there * map.shot as f32))
    }
}

struct Eye<'a> {
    solver: &'a Literal,
    map: &'a Photons,
}

impl PixelSolver for Eye<'_> {
    fn radiance(&self, c: &Context<'_>, eye: PathState, u: &Sampler, _: &mut u64) -> Spectrum {
        eye.beta.carry(self.solver.radiance(c, self.map, &eye.ray, eye.edges, eye.vertex, u))
    }
}

impl Solver for Literal {
    type State = State;

    fn needs(&self) -> Needs {
        Needs::default()
    }

    fn estimates(&self) -> Estimates {
        self.0.estimates()
    }

    fn splats(&self) -> bool {
        false
    }

    fn units(&self, size: [u32; 2]) -> usize {
        Tiling::new(size).len()
    }

    fn prepare(&self, scene: &Scene, run: &Run<'_>) -> State {
        self.0.prepare(scene, run)
    }

    fn pass(&self, scene: &Scene, run: &Run<'_>, state: &mut State, k: u32, work: &Work<'_>) -> Result<(), CannotGoOn> {
        let r = radius::radius_of_pass(state.radius, self.0.alpha, k);
        let shot: Option<Books> = state.map.shoot(&self.0, scene, run, k, r, work);
        if shot.is_some() {
            pixels::pass(&Eye { solver: self, map: &state.map }, scene, run, k, work);
        }
        Ok(())
    }
}
