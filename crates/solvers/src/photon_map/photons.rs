//! Photons: vertices of light paths at surfaces that spread light, kept for a pass.

use super::PhotonMap;
use crate::drivers::particles::{CHUNK, Numbers};
use crate::drivers::pixels::SamplePlan;
use crate::drivers::{Books, Work};
use crate::run::Run;
use crate::transport::{Awaited, Came, Context, LightContext, Particle, Tally, VertexIndex};
use etendue_numerics::sequence::{mix, unit};
use etendue_numerics::{Sampler, Spectrum, Vec3, Wavelengths};
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
    /// Whether it goes on with the hero's wavelength alone.
    pub is_alone: bool,
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
    /// The wavelengths of the pass.
    pub wl: Wavelengths,
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
        self.wl = scene.wavelengths(|| wavelengths_of_pass(run, k));
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
            (first..first + count).for_each(|i| follow(solver, &c, self.wl, &numbers.of(i), tally, kept));
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

/// The number of a pass's wavelengths: the radical inverse of k, turned by the seed. In noise mode each replicate has its own turn.
fn wavelengths_of_pass(run: &Run<'_>, k: u32) -> f32 {
    let plan = SamplePlan::new(run, k);
    (unit(plan.sample.reverse_bits()) + unit(mix(plan.seed) as u32)).fract()
}

/// A walk from a light, as in `light`, that leaves a photon at every surface with a smooth part.
fn follow(
    solver: &PhotonMap,
    c: &LightContext<'_>,
    wl: Wavelengths,
    u: &Sampler,
    tally: &mut Tally,
    kept: &mut Vec<(Vec3, Photon)>,
) {
    let Some((mut particle, light)) = Particle::emit_at(wl, c.path.scene, u) else { return };
    tally.emitted(particle.weighed());
    let rays_find_it = solver.direct_by_rays() && c.path.scene.lights.is_sampled(c.path.scene, light.emitter);
    while let Some(x) = particle.meet(c, tally) {
        let vertex = particle.vertex(c.path.scene, x);
        let direct = particle.came == Came::Straight && rays_find_it;
        if vertex.is_smooth() && !direct && solver.shows(particle.came) {
            let unseen = particle.waits_for == Awaited::Spreading;
            let (flux, came, edges) = (particle.carried(), particle.came, particle.edges);
            let is_alone = particle.wl.is_alone();
            kept.push((x.p, Photon { flux, wi: x.wo, n: x.n, edges, came, is_alone, unseen }));
        }
        if !particle.turn(c, &vertex, u, tally) {
            break;
        }
    }
}
