//! What is rendered: each solver straight through and as replicates, and the reference.

use super::Budget;
use super::measure::luminance;
use crate::experiment::renderer;
use etendue_solvers::agreement::{Moments, NoPicture, REPLICATES, Renderer, Sample, Trial};
use etendue_solvers::{AnySolver, Stop};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Linear Rec.709, rows from the top.
pub(super) type Pixels = Vec<[f32; 3]>;

/// Replicates of one solver, with sums per pixel.
pub(super) struct Spread {
    pub(super) sample: Sample,
    pub(super) mean: Vec<[f64; 3]>,
    pub(super) squares: Vec<[f64; 3]>,
    pub(super) luminance: Moments,
    pub(super) elapsed: Duration,
    pub(super) dropped: u64,
    pub(super) spp: u32,
}

/// The reference, with the variance of its mean.
pub(super) struct Standardised {
    pub(super) pixels: Pixels,
    pub(super) variance: Vec<[f64; 3]>,
    pub(super) sample: Option<Sample>,
    pub(super) words: String,
    pub(super) by: Option<usize>,
}

/// Picture, error-free time, rays, samples, dropped samples, and pictures along the way.
pub(super) type Straight = (Pixels, f64, u64, u32, u64, Vec<(u32, f64, Pixels)>);

/// Snapshots after 1, 2, 4, … passes. Their own time is not counted.
pub(super) fn straight(trial: &Trial<'_>, render: &Renderer<'_>, budget: Budget, stream: u64) -> Result<Straight, NoPicture> {
    let stop = match budget {
        Budget::Time(limit) => Stop::Time(limit),
        Budget::Samples(n) => Stop::Samples(n),
    };
    let begun = Instant::now();
    // Passes, pictures, and the time that developing them took.
    let seen = Mutex::new((0u32, Vec::new(), Duration::ZERO));
    let watch = |passes: u32, film: &etendue_film::Film| {
        let now = begun.elapsed();
        let mut seen = seen.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        seen.0 = passes;
        if passes.is_power_of_two() {
            let seconds = now.saturating_sub(seen.2).as_secs_f64();
            let picture = film.develop();
            seen.1.push((passes, seconds, picture));
            let developing = begun.elapsed().saturating_sub(now);
            seen.2 += developing;
        }
    };
    let shot = trial.shoot(render, stop, trial.seed_of(stream, 0), &watch)?;
    let (passes, mut series, developing) = seen.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    let seconds = shot.elapsed.saturating_sub(developing).as_secs_f64();
    if series.last().is_none_or(|s| f64::from(passes) > 1.3 * f64::from(s.0)) {
        series.push((passes, seconds, shot.pixels.clone()));
    }
    Ok((shot.pixels, seconds, shot.rays, passes.max(1), shot.dropped, series))
}

/// Replicates of so many samples per pixel.
pub(super) fn spread(trial: &Trial<'_>, render: &Renderer<'_>, spp: u32, stream: u64) -> Result<Spread, NoPicture> {
    let shape = trial.shape().size;
    let count = shape[0] as usize * shape[1] as usize;
    let mut s = Spread {
        sample: Sample::new(trial.grid()),
        mean: vec![[0.0; 3]; count],
        squares: vec![[0.0; 3]; count],
        luminance: Moments::default(),
        elapsed: Duration::ZERO,
        dropped: 0,
        spp,
    };
    for r in 0..REPLICATES {
        let shot = trial.replicate(render, spp, stream, r)?;
        s.sample.add(&shot.pixels);
        s.elapsed += shot.elapsed;
        s.dropped += shot.dropped;
        let n = f64::from(r + 1);
        for ((mean, squares), x) in s.mean.iter_mut().zip(&mut s.squares).zip(&shot.pixels) {
            for c in 0..3 {
                let d = f64::from(x[c]) - mean[c];
                mean[c] += d / n;
                squares[c] += d * (f64::from(x[c]) - mean[c]);
            }
        }
        s.luminance.add(luminance(trial.grid().means(&shot.pixels)[0]));
    }
    Ok(s)
}

impl Spread {
    /// The variance of the mean of the replicates, pixel by pixel.
    pub(super) fn variance(&self) -> Vec<[f64; 3]> {
        let k = f64::from(REPLICATES);
        self.squares.iter().map(|s| s.map(|x| x / (k - 1.0) / k)).collect()
    }

    pub(super) fn pixels(&self) -> Pixels {
        self.mean.iter().map(|p| p.map(|x| x as f32)).collect()
    }
}

/// Four times the work of a solver's replicates, in as many replicates.
pub(super) fn long(
    trial: &Trial<'_>,
    solver: &AnySolver,
    by: Option<usize>,
    budget: Budget,
    spp: Option<u32>,
) -> Result<Standardised, NoPicture> {
    let render = renderer(solver, trial.scene);
    let spp = match (spp, budget) {
        (Some(spp), _) => 4 * spp,
        (None, Budget::Samples(n)) => (4 * n / REPLICATES).max(1),
        (None, Budget::Time(time)) => trial.samples_in(&*render, 4 * time, REPLICATES)?,
    };
    let spread = spread(trial, &*render, spp, 1 << 20)?;
    let words =
        format!("{REPLICATES} replicates of {spp} spp by {}, {:.1} s together", solver.name(), spread.elapsed.as_secs_f64());
    Ok(Standardised { pixels: spread.pixels(), variance: spread.variance(), sample: Some(spread.sample), words, by })
}
