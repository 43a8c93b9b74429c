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

/// The photons of a pass, by place. Its memory is kept from pass to pass.
#[derive(Clone, Debug, Default)]
pub struct Photons {
    /// Where they are.
    pub index: VertexIndex,
    /// What they are, in the order of the index.
    pub photons: Vec<Photon>,
    /// Particles that were shot.
    pub shot: u64,
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
        let count = solver.particles(view.film.crop_size);
        let numbers = Numbers::new(run, k, count);

        let chunk = |tally: &mut Tally, chunk: u64| {
            if (work.stop_now)() {
                return None;
            }
            tally.clear();
            let mut kept = Vec::new();
            let particles = chunk * CHUNK..count.min((chunk + 1) * CHUNK);
            for i in particles.clone() {
                follow(solver, &c, &numbers.of(i), tally, &mut kept);
            }
            let mut books = Books::default();
            books.add(tally.entries(), particles.end - particles.start);
            work.progress.rays.fetch_add(tally.rays, Ordering::Relaxed);
            work.progress.paths.fetch_add(particles.end - particles.start, Ordering::Relaxed);
            Some((books, kept))
        };
        let chunks: Option<Vec<_>> =
            (0..count.div_ceil(CHUNK)).into_par_iter().map_init(|| Tally::new(&view.film), chunk).collect();

        let (mut points, mut photons, mut books) = (Vec::new(), Vec::new(), Books::default());
        for (theirs, kept) in chunks? {
            books.merge(&theirs);
            points.extend(kept.iter().map(|(p, _)| *p));
            photons.extend(kept.into_iter().map(|(_, photon)| photon));
        }
        self.shot = count;
        self.index.build(&points, radius);
        self.photons.clear();
        self.index.numbers().par_iter().map(|i| photons[*i as usize]).collect_into_vec(&mut self.photons);
        Some(books)
    }
}

/// A walk from a light, as in `light`, that leaves a photon at every surface with a smooth part.
fn follow(solver: &PhotonMap, c: &LightContext<'_>, u: &Sampler, tally: &mut Tally, kept: &mut Vec<(Vec3, Photon)>) {
    let Some((mut particle, light)) = Particle::emit(c.path.scene, u) else { return };
    tally.emitted(particle.carried());
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
