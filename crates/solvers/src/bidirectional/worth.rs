//! Which connections are worth a shadow ray: roulette before the ray is cast [after Veach 1997, §10.3.3].
//!
//! ```text
//! c = w C, were nothing in between       cast with probability q = min(1, c / δ),  and then C grows to C / q        δ = `faint` · L
//! ```
//!
//! L is the picture's mean without emitters seen directly, from a short trial. Most connections carry next to nothing, because some other strategy finds their path far better; δ is far below the
//! noise of a sample: on the Cornell box a fifth of all rays is saved, for 1 % of relMSE.

use super::{Paths, Strategies};
use crate::drivers::pixels::eye_walk;
use crate::run::Run;
use crate::transport::slot;
use etendue_numerics::{Dim, Sampler, SequenceKind, Spectrum, Vec2, Vec3};
use etendue_scene::View;
use serde::{Deserialize, Serialize};

/// Paths of the trial.
const PATHS: u32 = 512;

/// What light must carry for its visibility to be asked for in any case.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Worth {
    /// δ, as the largest channel.
    least: f32,
    /// What a splat is to a sample of a pixel: 1 / pixels.
    splat: f32,
}

impl Worth {
    /// Every connection is worth it.
    pub fn all(view: &View) -> Self {
        let [width, height] = view.film.crop_size.map(|n| n as f32);
        Self { least: 0.0, splat: 1.0 / (width * height) }
    }

    /// Those that add at least the part `faint` of the picture's mean.
    pub fn by_trial(faint: f32, all: &Strategies<'_>, run: &Run<'_>) -> Self {
        if faint <= 0.0 {
            return all.worth;
        }
        let film = &all.view.film;
        let [corner, size] = [film.crop_offset, film.crop_size].map(|[x, y]| Vec2::new(x as f32, y as f32));
        let (mut paths, mut sum) = (Paths::default(), 0.0f64);
        for i in 0..PATHS {
            let u = Sampler::new(SequenceKind::Sobol, run.seed, u64::MAX, i, PATHS);
            let eye = eye_walk(&all.c, run.view, corner + u.u2(Dim::at(0, slot::PIXEL)) * size, &u);
            all.sample(eye, &u, &mut paths, &mut |f, _, _| {
                // A lamp in view is no measure for what it lights.
                let seen = if f.s + f.t > 2 { f.weight } else { 0.0 };
                let c = (f.value * seen).max_lane() * if f.pixel.is_some() { all.worth.splat } else { 1.0 };
                sum += if c.is_finite() { f64::from(c) } else { 0.0 };
            });
        }
        Self { least: faint * (sum / f64::from(PATHS)) as f32, ..all.worth }
    }

    /// By how much light that would add `c` to a pixel must be multiplied; `None` where no ray shall be cast for it.
    #[inline]
    pub fn decide(&self, c: Spectrum, u: impl FnOnce() -> f32) -> Option<f32> {
        // What is not a number goes on, and is told where it arrives.
        if c.max_lane() >= self.least || !c.is_finite() {
            return Some(1.0);
        }
        let q = c.max_lane() / self.least;
        (u() < q).then(|| 1.0 / q)
    }

    /// The same without branches, for loops over lanes: by how much, and whether.
    #[inline(always)]
    pub(crate) fn decide_at_once(&self, c: Vec3, u: f32) -> (f32, bool) {
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        let largest = larger(larger(c.x, c.y), larger(c.z, 0.0));
        let is_finite = c.x.is_finite() & c.y.is_finite() & c.z.is_finite();
        let q = largest / self.least;
        let certain = (largest >= self.least) | !is_finite;
        (if certain { 1.0 } else { 1.0 / q }, certain | (u < q))
    }

    /// The same for light that is splat.
    #[inline]
    pub fn decide_splat(&self, c: Spectrum, u: impl FnOnce() -> f32) -> Option<f32> {
        self.decide(c * self.splat, u)
    }

    /// The same without branches.
    #[inline(always)]
    pub(crate) fn decide_splat_at_once(&self, c: Vec3, u: f32) -> (f32, bool) {
        self.decide_at_once(c * self.splat, u)
    }
}
