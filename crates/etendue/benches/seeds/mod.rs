//! The same picture again and again, each time with a seed of its own: how long it takes and how much it varies.

use etendue::{Loaded, RenderOptions, Watch, render};
use std::time::Instant;

/// Sums over rounds of a pixel's channels and of their squares.
#[derive(Default)]
pub struct Runs {
    seconds: Vec<f64>,
    sums: Vec<[f64; 2]>,
}

impl Runs {
    /// Renders once more.
    pub fn add(&mut self, loaded: &Loaded, options: &RenderOptions) {
        let begun = (Instant::now(), cpu_seconds());
        let rendering = render(loaded, options, &Watch::default()).expect("a picture");
        let spent = begun.1.zip(cpu_seconds()).map_or(begun.0.elapsed().as_secs_f64(), |(before, after)| after - before);
        self.seconds.push(spent);
        let picture = rendering.picture.image.to_rgb();
        let values = picture.pixels().flatten().map(|v| f64::from(*v));
        self.sums.resize(3 * picture.width() * picture.height(), [0.0; 2]);
        self.sums.iter_mut().zip(values).for_each(|([s, s2], v)| (*s, *s2) = (*s + v, *s2 + v * v));
    }

    /// The middle of the seconds that it took, of the processor where the system tells.
    pub fn seconds(&self) -> f64 {
        let mut sorted = self.seconds.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    }

    /// Means over the rounds, pixel by pixel and channel by channel.
    pub fn means(&self) -> Vec<f64> {
        self.sums.iter().map(|[s, _]| s / self.seconds.len() as f64).collect()
    }
}

/// Mean over pixels and channels of s² / (m² + 0.01 M²): s² the variance between the rounds, m the best known mean, M the mean of those.
pub fn noise(runs: &Runs, best: &[f64]) -> f64 {
    let (rounds, n) = (runs.seconds.len() as f64, best.len() as f64);
    let floor = 0.01 * (best.iter().sum::<f64>() / n).powi(2);
    let relative = |([s, s2], m): (&[f64; 2], &f64)| (s2 - s * s / rounds) / (rounds - 1.0) / (m * m + floor);
    runs.sums.iter().zip(best).map(relative).sum::<f64>() / n
}

/// Of this process, as Linux counts them in hundredths.
fn cpu_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = text.rsplit(')').next()?.split_whitespace().collect();
    Some((fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?) / 100.0)
}
