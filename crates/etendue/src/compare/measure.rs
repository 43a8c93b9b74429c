//! How far from the reference: errors, bias, slope, efficiency.

use super::pictures::{Pixels, Spread, Standardised, Straight};
use super::{CompareOptions, Entry, Point};
use crate::experiment::ExperimentError;
use etendue_check::student_quantile;
use etendue_image::{Image, Layer, Picture};
use etendue_solvers::agreement::{Expected, REPLICATES, judge};
use etendue_solvers::{AnySolver, Estimates};

type Compared<T> = Result<T, ExperimentError>;

pub(super) fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

pub(super) fn epsilon(r: &[[f32; 3]]) -> f64 {
    let mean = r.iter().flatten().map(|x| f64::from(*x)).sum::<f64>() / (3 * r.len()).max(1) as f64;
    (0.01 * mean * mean).max(1e-30)
}

/// relMSE of x against r, less what r's own variance adds to it.
pub(super) fn rel_mse(x: &[[f32; 3]], r: &[[f32; 3]], variance: &[[f64; 3]]) -> f64 {
    let e = epsilon(r);
    let mut sum = 0.0;
    for ((x, r), v) in x.iter().zip(r).zip(variance) {
        for c in 0..3 {
            let (x, r) = (f64::from(x[c]), f64::from(r[c]));
            sum += ((x - r).powi(2) - v[c]) / (r * r + e);
        }
    }
    sum / (3 * r.len()).max(1) as f64
}

/// Noise of the mean of the replicates, relative to a picture that all solvers share: relative to its own, a solver that finds light by rare bright paths
/// would look better than it is.
pub(super) fn relative_variance(s: &Spread, picture: &[[f32; 3]]) -> f64 {
    -rel_mse(picture, picture, &s.variance())
}

/// Of each pixel and channel the least of several pictures, which no rare bright path has lifted.
pub(super) fn darkest(pictures: impl Iterator<Item = Pixels>) -> Pixels {
    let least = |mut a: Pixels, b: Pixels| {
        a.iter_mut().flatten().zip(b.iter().flatten()).for_each(|(a, b)| *a = a.min(*b));
        a
    };
    pictures.reduce(least).unwrap_or_default()
}

#[expect(clippy::too_many_arguments, reason = "what was rendered, and what it is held against; called once")]
pub(super) fn entry(
    solver: &AnySolver,
    (pixels, seconds, rays, spp, dropped, series): &Straight,
    spread: &Spread,
    reference: &Standardised,
    is_reference: bool,
    options: &CompareOptions,
    tests: usize,
    size: [u32; 2],
) -> Compared<Entry> {
    let grid = spread.sample.grid();
    let known = grid.means(&reference.pixels);
    let error = |x: &[[f32; 3]]| rel_mse(x, &reference.pixels, &reference.variance);
    let points: Vec<Point> =
        series.iter().map(|(passes, seconds, x)| Point { passes: *passes, seconds: *seconds, rel_mse: error(x) }).collect();
    let biased = solver.estimates() == Estimates::InTheLimit;
    let agreement = (!is_reference && !biased).then(|| match &reference.sample {
        Some(other) => judge(&spread.sample, Expected::Sample(other), &options.standard, tests),
        None => judge(&spread.sample, Expected::Known(&known), &options.standard, tests),
    });

    // The bias of the luminance of the whole picture: Student's interval, the reference's own error included.
    let y = luminance(known[0]);
    let own = reference.sample.as_ref().map_or(0.0, |s| {
        // Channels are far from independent: their errors are added as if they were one.
        luminance(std::array::from_fn(|c| s.areas()[0][c].standard_error()))
    });
    let se = (spread.luminance.standard_error().powi(2) + own * own).sqrt();
    let t = student_quantile(0.05, f64::from(REPLICATES - 1));
    let variance = spread.variance();
    let e = epsilon(&reference.pixels);
    let total: f64 = variance
        .iter()
        .zip(&reference.pixels)
        .map(|(v, r)| (0..3).map(|c| v[c] / (f64::from(r[c]).powi(2) + e)).sum::<f64>())
        .sum();
    let rel_mse = error(pixels);
    let difference: Pixels =
        spread.mean.iter().zip(&reference.pixels).map(|(x, r)| std::array::from_fn(|c| x[c] as f32 - r[c])).collect();
    Ok(Entry {
        solver: solver.name().to_owned(),
        spp: *spp,
        seconds: *seconds,
        rays: *rays,
        rel_mse,
        efficiency: 1.0 / (rel_mse.max(1e-30) * seconds.max(1e-9)),
        bias: (spread.luminance.mean - y) / y.max(1e-30),
        bias_half_width: t * se / y.max(1e-30),
        slope: slope(&points),
        series: points,
        replicate_spp: spread.spp,
        replicates: REPLICATES,
        variance_second: total / (3 * variance.len()).max(1) as f64 * spread.elapsed.as_secs_f64(),
        biased,
        agreement,
        dropped: dropped + spread.dropped,
        picture: layered(size, pixels, &variance, &difference)?,
    })
}

/// The least-squares slope of log error against log time; the first pass, which warms up, is left out where there are enough others.
pub(super) fn slope(points: &[Point]) -> Option<f64> {
    let good: Vec<(f64, f64)> = points
        .iter()
        .filter(|p| p.rel_mse > 0.0 && p.seconds > 0.0 && (p.passes > 1 || points.len() < 4))
        .map(|p| (p.seconds.ln(), p.rel_mse.ln()))
        .collect();
    if good.len() < 3 {
        return None;
    }
    let n = good.len() as f64;
    let (mx, my) = (good.iter().map(|p| p.0).sum::<f64>() / n, good.iter().map(|p| p.1).sum::<f64>() / n);
    let (xy, xx) = good.iter().fold((0.0, 0.0), |(xy, xx), (x, y)| (xy + (x - mx) * (y - my), xx + (x - mx).powi(2)));
    (xx > 0.0).then(|| xy / xx)
}

/// A picture with the layers `error` (the standard error of the replicates' mean) and `difference` (that mean less the reference).
pub(super) fn layered(size: [u32; 2], pixels: &[[f32; 3]], variance: &[[f64; 3]], difference: &[[f32; 3]]) -> Compared<Picture> {
    let [w, h] = size.map(|n| n as usize);
    let image = |data: Vec<f32>| Image::rgb(w, h, data).map_err(|e| ExperimentError::Words(e.to_string()));
    let error = image(variance.iter().flatten().map(|v| v.max(0.0).sqrt() as f32).collect())?;
    let layers = vec![
        Layer { name: "error".to_owned(), image: error },
        Layer { name: "difference".to_owned(), image: image(difference.as_flattened().to_vec())? },
    ];
    Ok(Picture { image: image(pixels.as_flattened().to_vec())?, layers, attributes: Vec::new() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_solvers::agreement::{Grid, Moments, Sample};
    use std::time::Duration;

    /// A solver that found a rare bright path, once in its replicates, is the noisier one, though relative to its own picture it is not.
    #[test]
    fn rare_bright_paths_are_noise() {
        let grid = Grid::new([2, 1], 1);
        let spread = |mean: f64, squares: f64| Spread {
            sample: Sample::new(grid),
            mean: vec![[1.0; 3], [mean; 3]],
            squares: vec![[0.0; 3], [squares; 3]],
            luminance: Moments::default(),
            elapsed: Duration::from_secs(1),
            dropped: 0,
            spp: 1,
        };
        let k = f64::from(REPLICATES);
        let (steady, bright) = (spread(0.1, 0.1), spread(100.0, (1.0 - 1.0 / k) * (k * 100.0f64).powi(2)));
        let of = |s: &Spread, picture: &[[f32; 3]]| relative_variance(s, picture);
        assert!(of(&steady, &steady.pixels()) < 0.1 && of(&bright, &bright.pixels()) <= 0.5);
        let least = darkest([&steady, &bright].into_iter().map(Spread::pixels));
        assert_eq!(least, steady.pixels());
        assert!(of(&bright, &least) > 1e3 * of(&steady, &least));
    }

    #[test]
    fn slopes_of_power_laws() {
        let law = |p: f64| -> Vec<Point> {
            (0..6).map(|i| Point { passes: 1 << i, seconds: f64::from(1 << i), rel_mse: 0.3 * f64::from(1 << i).powf(p) }).collect()
        };
        for p in [-1.0, -1.5, -0.5] {
            assert!((slope(&law(p)).expect("six points") - p).abs() < 1e-12);
        }
        assert_eq!(slope(&law(-1.0)[..2]), None);
    }

    #[test]
    fn the_references_own_variance_is_taken_off() {
        // x and r both miss the truth 1 by independent noise of variance 0.01: r's share is known.
        let (x, r) = (vec![[1.1f32; 3]; 4], vec![[1.0f32; 3]; 4]);
        let plain = rel_mse(&x, &r, &[[0.0; 3]; 4]);
        assert!((plain - 0.01 / 1.01).abs() < 1e-7);
        assert!(rel_mse(&x, &r, &[[0.01; 3]; 4]).abs() < 1e-7);
    }
}
