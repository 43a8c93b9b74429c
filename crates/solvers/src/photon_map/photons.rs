//! Photons: vertices of light paths at surfaces that spread light, kept for a pass.

use super::PhotonMap;
use crate::drivers::particles::{CHUNK, Numbers};
use crate::drivers::{Books, Work};
use crate::run::Run;
use crate::transport::{Awaited, Came, Context, LightContext, Particle, Tally, Vertex, VertexIndex};
use etendue_numerics::{Sampler, Spectrum, Vec3};
use etendue_scene::Scene;
use rayon::prelude::*;
use std::sync::atomic::Ordering;

/// A particle that has arrived at a surface.
#[derive(Clone, Copy, Debug)]
pub struct Photon {
    /// Φ, W, of all particles of the pass together.
    pub flux: Spectrum,
    /// Unit direction back to where it came from.
    pub wi: Vec3,
    /// Unit geometric normal of the surface there.
    pub n: Vec3,
    /// Edges between the light and here.
    pub edges: u32,
    /// How it came.
    pub came: Came,
    /// Whether no walk from the eye can go back its way to the light: it came from a point or in a single direction, and was not spread since.
    pub unseen: bool,
}

/// The photons of a pass, by place. Their memory is kept from pass to pass.
#[derive(Clone, Debug, Default)]
pub struct Photons {
    /// Where they are.
    pub index: VertexIndex,
    /// What they are, in the order of the index.
    pub photons: Vec<Photon>,
    /// Particles that were shot.
    pub shot: u64,
    /// Photons as they come, chunk by chunk.
    chunks: Vec<Vec<(Vec3, Photon)>>,
    /// Where they are, in that order.
    points: Vec<Vec3>,
}

impl Photons {
    /// Shoots the particles of pass `k` and sorts what they leave behind; the books of the pass, or `None` where it was stopped.
    pub fn shoot(
        &mut self,
        solver: &PhotonMap,
        scene: &Scene,
        run: &Run<'_>,
        k: u32,
        radius: f32,
        work: &Work<'_>,
    ) -> Option<Books> {
        let view = &scene.views[run.view];
        let path = Context { scene, rules: run.rules };
        // The edge to the eye is to come.
        let c = LightContext { path, view, reach: run.rules.max_edges.saturating_sub(1) };
        self.shot = solver.particles(view.film.crop_size);
        let numbers = Numbers::new(run, k, self.shot);
        self.chunks.resize_with(self.shot.div_ceil(CHUNK) as usize, Vec::new);

        let chunk = |tally: &mut Tally, (chunk, kept): (usize, &mut Vec<(Vec3, Photon)>)| {
            if (work.stop_now)() {
                return None;
            }
            tally.clear();
            kept.clear();
            let first = chunk as u64 * CHUNK;
            let count = CHUNK.min(self.shot - first);
            (first..first + count).for_each(|i| follow(solver, &c, &numbers.of(i), tally, kept));
            let mut books = Books::default();
            books.add(tally.entries(), count);
            work.progress.rays.fetch_add(tally.rays, Ordering::Relaxed);
            work.progress.paths.fetch_add(count, Ordering::Relaxed);
            Some(books)
        };
        let merge = |a: Option<Books>, b: Option<Books>| Some(a?.merged(&b?));
        let nothing = || Some(Books::default());
        let chunks = self.chunks.par_iter_mut().enumerate();
        let books = chunks.map_init(|| Tally::new(&view.film), chunk).reduce(nothing, merge)?;
        self.sort(radius);
        Some(books)
    }

    /// From the order in which they came to the order of the index.
    fn sort(&mut self, radius: f32) {
        self.points.clear();
        let mut ends = Vec::with_capacity(self.chunks.len());
        for chunk in &self.chunks {
            self.points.extend(chunk.iter().map(|(p, _)| *p));
            ends.push(self.points.len());
        }
        self.index.build(&self.points, radius);
        let number = |i: &u32| {
            let i = *i as usize;
            let chunk = ends.partition_point(|end| *end <= i);
            self.chunks[chunk][i - if chunk == 0 { 0 } else { ends[chunk - 1] }].1
        };
        self.index.numbers().par_iter().map(number).collect_into_vec(&mut self.photons);
    }
}

/// A walk from a light, as in `light`, that leaves a photon at every surface with a smooth part.
fn follow(solver: &PhotonMap, c: &LightContext<'_>, u: &Sampler, tally: &mut Tally, kept: &mut Vec<(Vec3, Photon)>) {
    let Some((mut particle, light)) = Particle::emit(c.path.scene, u) else { return };
    tally.emitted(particle.weighed());
    let rays_find_it = solver.direct_by_rays() && c.path.scene.lights.is_sampled(c.path.scene, light.emitter);
    while let Some(x) = particle.meet(c, tally) {
        let mut vertex = Vertex::at(x);
        vertex.evaluate(c.path.scene, &particle.wl);
        let direct = particle.came == Came::Straight && rays_find_it;
        if vertex.is_smooth() && !direct && solver.shows(particle.came) {
            let unseen = particle.waits_for == Awaited::Spreading;
            let (flux, came, edges) = (particle.carried(), particle.came, particle.edges);
            kept.push((x.p, Photon { flux, wi: x.wo, n: x.n, edges, came, unseen }));
        }
        if !particle.turn(c, &vertex, u, tally) {
            break;
        }
    }
}
