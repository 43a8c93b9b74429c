//! Is the guide worth its time? Some guided walks tell, before the first pass.
//!
//! ```text
//! guided:  M_g = E[h²],     without:  M_b = E[h² R],    R = Π p q_g / (p_b q_b)  along the walk up to where it found h
//! it is worth it where   TIME · Σ_blocks M_g / (I² + e)  <  Σ_blocks M_b / (I² + e),    e = 0.01 · (picture's mean)²
//! ```
//!
//! h is what a walk finds at one vertex, q_g and q_b are the probabilities to go on there by either's roulette. Walks without a guide are not asked: what they hardly ever find would be missing from their noise. Emitters that the eye
//! sees are no noise. A function of scene, rules, seed and guide.

use super::walk::Guided;
use crate::drivers::Work;
use crate::drivers::pixels::eye_walk;
use crate::run::Run;
use crate::transport::{Context, PathState, arrives, roulette_survival, slot};
use etendue_film::Fixed;
use etendue_numerics::sequence::mix;
use etendue_numerics::{Dim, Sampler, SequenceKind, Spectrum, Vec2};
use etendue_scene::Scene;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// How long a guided walk takes, of one of `path-mis`: about twice; and what M promises and pictures do not keep, by measurement about as much again.
const TIME: f64 = 4.5;
/// Walks of a unit of work.
const CHUNK: u64 = 256;
/// Blocks of the film across and down.
const BLOCKS: usize = 8;

/// Sums of a block: its walks, their light, and the squares of what they found, with the guide and without.
#[derive(Clone, Copy, Default)]
struct Block {
    walks: u64,
    light: Fixed,
    squares: [Fixed; 2],
}

/// How much more a second is worth with the guide, by so many walks; `None` where the render was stopped.
pub fn gain(scene: &Scene, run: &Run<'_>, guided: &Guided<'_>, walks: u64, work: &Work<'_>) -> Option<f64> {
    let context = Context { scene, rules: run.rules };
    let film = &scene.views[run.view].film;
    let [corner, size] = [film.crop_offset, film.crop_size].map(|[x, y]| Vec2::new(x as f32, y as f32));
    let seed = mix(run.seed ^ 0x7472_6961_6c00);
    let (blocks, rays) = (Mutex::new([Block::default(); BLOCKS * BLOCKS]), AtomicU64::new(0));
    (0..walks.div_ceil(CHUNK)).into_par_iter().for_each(|chunk| {
        if (work.stop_now)() {
            return;
        }
        let (mut ours, mut cast) = ([Block::default(); BLOCKS * BLOCKS], 0);
        for i in chunk * CHUNK..((chunk + 1) * CHUNK).min(walks) {
            let u = Sampler::new(SequenceKind::Sobol, seed, 0, i as u32, walks as u32);
            let place = u.u2(Dim::at(0, slot::PIXEL));
            let at = (place * BLOCKS as f32).min(Vec2::splat(BLOCKS as f32 - 1.0));
            let block = &mut ours[at.y as usize * BLOCKS + at.x as usize];
            follow(guided, &context, eye_walk(&context, run.view, corner + place * size, &u), &u, block, &mut cast);
        }
        rays.fetch_add(cast, Ordering::Relaxed);
        let mut blocks = blocks.lock().unwrap_or_else(PoisonError::into_inner);
        blocks.iter_mut().zip(&ours).for_each(|(all, own)| all.merge(own));
    });
    if (work.stop_now)() {
        return None;
    }
    work.progress.rays.fetch_add(rays.into_inner(), Ordering::Relaxed);
    let [with, without] = noise(&blocks.into_inner().unwrap_or_else(PoisonError::into_inner));
    Some(if with > 0.0 { without / (TIME * with) } else { 0.0 })
}

/// One walk: what it finds, vertex by vertex.
fn follow(guided: &Guided<'_>, c: &Context<'_>, mut state: PathState, u: &Sampler, block: &mut Block, rays: &mut u64) {
    block.walks += 1;
    // R, and how much more than with path-mis β has grown by roulette.
    let (mut ratio, mut grown) = (1.0, 1.0);
    loop {
        let before = state.l;
        let seen_by_eye = state.edges == 1;
        let hit = c.scene.intersect(&state.ray);
        let (step, turned) = guided.step(c, &mut state, hit, u);
        let met = if seen_by_eye { Spectrum::ZERO } else { state.l - before };
        let found = step.shadow.as_ref().map_or(Spectrum::ZERO, |query| arrives(c, query, &state.wl));
        *rays += 1 + u64::from(step.shadow.is_some());
        for h in [met, found].map(|l| f64::from(state.wl.to_rgb(l).luminance())).into_iter().filter(|h| h.is_finite()) {
            block.light += Fixed::from_f64(h);
            block.squares[0] += Fixed::from_f64(h * h);
            block.squares[1] += Fixed::from_f64(h * h * ratio);
        }
        ratio *= f64::from(turned.ratio);
        if turned.hope[0] > 0.0 {
            let [with, without] = [roulette_survival(turned.hope[0], 1.0), roulette_survival(turned.hope[1], grown)];
            ratio *= f64::from(with / without);
            grown *= with / without;
        }
        if !step.goes_on {
            return;
        }
    }
}

impl Block {
    fn merge(&mut self, other: &Self) {
        self.walks += other.walks;
        self.light += other.light;
        self.squares.iter_mut().zip(other.squares).for_each(|(a, b)| *a += b);
    }
}

/// Σ M / (I² + e) over blocks, with the guide and without.
fn noise(blocks: &[Block]) -> [f64; 2] {
    let seen: Vec<_> = blocks.iter().filter(|b| b.walks > 0).collect();
    let per_walk = |b: &Block, sum: Fixed| sum.to_f64() / b.walks as f64;
    let mean = seen.iter().map(|b| per_walk(b, b.light)).sum::<f64>() / seen.len().max(1) as f64;
    let e = (0.01 * mean * mean).max(f64::MIN_POSITIVE);
    [0, 1].map(|i| seen.iter().map(|b| per_walk(b, b.squares[i]) / (per_walk(b, b.light).powi(2) + e)).sum())
}
