//! The lesson: particles from the lights, and what they leave behind where walks may learn from it.

use super::field::Photon;
use crate::drivers::Work;
use crate::drivers::particles::CHUNK;
use crate::run::Run;
use crate::transport::{Awaited, Came, Context, LightContext, Particle, Tally};
use etendue_numerics::sequence::mix;
use etendue_numerics::{Sampler, SequenceKind};
use etendue_scene::Scene;
use rayon::prelude::*;
use std::sync::atomic::Ordering;

/// Particles at most.
const MOST: u64 = 1 << 22;

/// As many photons as wanted, or somewhat more; fewer where particles have cast so many rays before. In the order of the particles; `None` where the render
/// was stopped.
pub fn photons(scene: &Scene, run: &Run<'_>, wanted: usize, rays: u64, work: &Work<'_>) -> Option<Vec<Photon>> {
    let view = &scene.views[run.view];
    let path = Context { scene, rules: run.rules };
    // The edge to the eye is to come.
    let c = LightContext { path, view, reach: run.rules.max_edges.saturating_sub(1) };
    let seed = mix(run.seed ^ 0x6c65_7373_6f6e);
    let (mut all, mut cast, mut shot) = (Vec::new(), 0, 0);
    while all.len() < wanted && cast < rays && shot < MOST {
        // As many again as were shot so far.
        let batch = (shot / CHUNK).max(1);
        let chunk = |tally: &mut Tally, chunk: u64| {
            if (work.stop_now)() {
                return None;
            }
            tally.clear();
            let mut left = Vec::new();
            for i in 0..CHUNK {
                let u = Sampler::new(SequenceKind::Sobol, seed, 0, (shot + chunk * CHUNK + i) as u32, u32::MAX);
                follow(&c, &u, tally, &mut left);
            }
            Some((left, tally.rays))
        };
        let chunks: Option<Vec<_>> = (0..batch).into_par_iter().map_init(|| Tally::new(&view.film), chunk).collect();
        for (left, rays) in chunks? {
            all.extend(left);
            cast += rays;
        }
        shot += batch * CHUNK;
    }
    work.progress.rays.fetch_add(cast, Ordering::Relaxed);
    Some(all)
}

/// A walk from a light that leaves a photon wherever the walks from the eye could use it: direct light is for light samples, and what no such walk
/// can meet is of no use.
fn follow(c: &LightContext<'_>, u: &Sampler, tally: &mut Tally, left: &mut Vec<Photon>) {
    let scene = c.path.scene;
    let Some((mut particle, light)) = Particle::emit(scene, u) else { return };
    let samples_find_it = scene.lights.is_sampled(scene, light.emitter);
    while let Some(x) = particle.meet(c, tally) {
        let from = particle.ray.o;
        let vertex = particle.vertex(scene, x);
        let direct = particle.came == Came::Straight && samples_find_it;
        let flux = particle.weighed().luminance();
        if vertex.is_smooth() && !direct && particle.waits_for != Awaited::Spreading && flux > 0.0 && flux.is_finite() {
            let n = if x.n.dot(x.wo) < 0.0 { -x.n } else { x.n };
            left.push(Photon { p: x.p, from, n, flux });
        }
        if !particle.turn(c, &vertex, u, tally) {
            break;
        }
    }
}
