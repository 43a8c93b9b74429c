//! Renders and measures.

use super::{Budget, CompareOptions, Entry, Point, Reference, Results};
use crate::choice::check_solver_name;
use crate::experiment::{BOX, ExperimentError, Header, renderer};
use crate::load::{LoadOptions, load};
use crate::pool;
use etendue_check::student_quantile;
use etendue_image::{Image, Layer, Picture};
use etendue_solvers::agreement::{Expected, Moments, REPLICATES, Renderer, Sample, Trial, judge};
use etendue_solvers::{AnySolver, CancelToken, Estimates, Stop};
use std::sync::Mutex;
use std::time::{Duration, Instant};

type Compared<T> = Result<T, ExperimentError>;
type Pixels = Vec<[f32; 3]>;

/// Replicates of one solver, with sums per pixel.
struct Spread {
    sample: Sample,
    mean: Vec<[f64; 3]>,
    squares: Vec<[f64; 3]>,
    luminance: Moments,
    elapsed: Duration,
    dropped: u64,
    spp: u32,
}

/// The reference, with the variance of its mean.
struct Standardised {
    pixels: Pixels,
    variance: Vec<[f64; 3]>,
    sample: Option<Sample>,
    words: String,
    by: Option<usize>,
}

/// Compares; `tell` hears what is going on.
pub fn compare(scene: &str, options: &CompareOptions, cancel: &CancelToken, tell: &dyn Fn(&str)) -> Compared<Results> {
    let reference_solver = if let Reference::Solver(name) = &options.reference { Some(name) } else { None };
    for name in options.solvers.iter().chain(reference_solver) {
        check_solver_name(name)?;
    }
    let load_options =
        LoadOptions { defines: options.defines.clone(), width: options.width, height: options.height, threads: options.threads };
    let mut loaded = load(scene, &load_options).map_err(ExperimentError::Load)?;
    if !matches!(options.reference, Reference::Picture(_)) {
        // Pixels that share samples would make the variance of one depend on its neighbours, and bias it at low counts.
        loaded.scene.views.iter_mut().for_each(|v| v.film.filter = BOX);
    }
    let scene = &loaded.scene;
    let pool = pool::pool(options.threads)?;
    let trial = Trial { seed: options.seed, ..Trial::new(scene, &pool, cancel) };
    let able = |name: &String| {
        let solver = AnySolver::new(name, &scene.integrator)
            .ok_or_else(|| ExperimentError::Words(format!("the solver `{name}` is not there yet")))?;
        match solver.needs().check(scene) {
            Ok(()) => Ok(solver),
            Err(why) => Err(ExperimentError::Words(format!("`{name}` cannot render this scene: {}", why.reason))),
        }
    };
    let solvers = options.solvers.iter().map(able).collect::<Compared<Vec<_>>>()?;
    let of_reference = reference_solver.map(able).transpose()?;
    let file = match &options.reference {
        Reference::Picture(path) => Some((read(path, trial.shape().size)?, format!("the picture {}", path.display()))),
        _ => None,
    };

    // The solvers, straight through and as replicates.
    let mut runs = Vec::new();
    for (i, solver) in solvers.iter().enumerate() {
        tell(&format!("rendering with {}", solver.name()));
        let render = renderer(solver, scene);
        let straight = straight(&trial, &*render, options.budget, i as u64).ok_or(ExperimentError::Cancelled)?;
        let spp = (straight.3 / REPLICATES).max(1);
        let spread = spread(&trial, &*render, spp, 64 + i as u64).ok_or(ExperimentError::Cancelled)?;
        runs.push((straight, spread));
    }

    // The reference.
    tell("rendering the reference");
    let reference = match (file, &of_reference) {
        (Some((pixels, words)), _) => {
            let variance = vec![[0.0; 3]; pixels.len()];
            Standardised { pixels, variance, sample: None, words, by: None }
        }
        (None, Some(solver)) => {
            let by = options.solvers.iter().position(|s| s == solver.name());
            long(&trial, solver, by, options.budget, by.map(|i| runs[i].1.spp)).ok_or(ExperimentError::Cancelled)?
        }
        (None, None) => {
            let noise = |i: &usize| relative_variance(&runs[*i].1) * runs[*i].1.elapsed.as_secs_f64();
            let unbiased = (0..solvers.len()).filter(|i| solvers[*i].estimates() == Estimates::Light);
            let best = unbiased.min_by(|a, b| noise(a).total_cmp(&noise(b))).ok_or_else(|| {
                ExperimentError::Words(
                    "none of these solvers estimates all light without bias\n  help: name one with --reference".to_owned(),
                )
            })?;
            long(&trial, &solvers[best], Some(best), options.budget, Some(runs[best].1.spp)).ok_or(ExperimentError::Cancelled)?
        }
    };

    tell("measuring");
    let tests = 3 * trial.grid().len() * (0..solvers.len()).filter(|i| reference.by != Some(*i)).count();
    let size = trial.shape().size;
    let mut entries = Vec::new();
    for (i, (solver, (straight, spread))) in solvers.iter().zip(runs).enumerate() {
        entries.push(entry(solver.name(), &straight, &spread, &reference, reference.by == Some(i), options, tests, size)?);
    }
    let mean = trial.grid().means(&reference.pixels)[0];
    let zero = vec![[0.0f32; 3]; reference.pixels.len()];
    Ok(Results {
        header: Header::new(&loaded, &trial, options.standard),
        budget: options.budget,
        tests,
        reference_rel_mse: -rel_mse(&reference.pixels, &reference.pixels, &reference.variance),
        reference: reference.words.clone(),
        reference_mean: mean,
        solvers: entries,
        reference_picture: layered(size, &reference.pixels, &reference.variance, &zero)?,
    })
}

/// A picture file as a reference.
fn read(path: &std::path::Path, size: [u32; 2]) -> Compared<Pixels> {
    let image = etendue_image::load(path).map_err(|e| ExperimentError::Words(e.to_string()))?;
    let found = [image.width() as u32, image.height() as u32];
    if found != size {
        let words = format!("{} is {} x {}, and the render {} x {}", path.display(), found[0], found[1], size[0], size[1]);
        return Err(ExperimentError::Words(words + "\n  help: --width and --height set the size of the render"));
    }
    let linear = image.to_linear().to_rgb();
    Ok(linear.pixels().map(|p| [p[0], p[1], p[2]].map(|x| if x.is_finite() { x } else { 0.0 })).collect())
}

/// Picture, error-free time, rays, samples, dropped samples, and pictures along the way.
type Straight = (Pixels, f64, u64, u32, u64, Vec<(u32, f64, Pixels)>);

/// Snapshots after 1, 2, 4, … passes. Their own time is not counted.
fn straight(trial: &Trial<'_>, render: &Renderer<'_>, budget: Budget, stream: u64) -> Option<Straight> {
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
    Some((shot.pixels, seconds, shot.rays, passes.max(1), shot.dropped, series))
}

fn spread(trial: &Trial<'_>, render: &Renderer<'_>, spp: u32, stream: u64) -> Option<Spread> {
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
    Some(s)
}

impl Spread {
    /// The variance of the mean of the replicates, pixel by pixel.
    fn variance(&self) -> Vec<[f64; 3]> {
        let k = f64::from(REPLICATES);
        self.squares.iter().map(|s| s.map(|x| x / (k - 1.0) / k)).collect()
    }

    fn pixels(&self) -> Pixels {
        self.mean.iter().map(|p| p.map(|x| x as f32)).collect()
    }
}

fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Four times the work of a solver's replicates, in as many replicates.
fn long(trial: &Trial<'_>, solver: &AnySolver, by: Option<usize>, budget: Budget, spp: Option<u32>) -> Option<Standardised> {
    let render = renderer(solver, trial.scene);
    let spp = match (spp, budget) {
        (Some(spp), _) => 4 * spp,
        (None, Budget::Samples(n)) => (4 * n / REPLICATES).max(1),
        (None, Budget::Time(time)) => trial.samples_in(&*render, 4 * time, REPLICATES)?,
    };
    let spread = spread(trial, &*render, spp, 1 << 20)?;
    let words =
        format!("{REPLICATES} replicates of {spp} spp by {}, {:.1} s together", solver.name(), spread.elapsed.as_secs_f64());
    Some(Standardised { pixels: spread.pixels(), variance: spread.variance(), sample: Some(spread.sample), words, by })
}

fn epsilon(r: &[[f32; 3]]) -> f64 {
    let mean = r.iter().flatten().map(|x| f64::from(*x)).sum::<f64>() / (3 * r.len()).max(1) as f64;
    (0.01 * mean * mean).max(1e-30)
}

/// relMSE of x against r, less what r's own variance adds to it.
fn rel_mse(x: &[[f32; 3]], r: &[[f32; 3]], variance: &[[f64; 3]]) -> f64 {
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

/// Noise of the mean of the replicates, relative.
fn relative_variance(s: &Spread) -> f64 {
    let pixels = s.pixels();
    -rel_mse(&pixels, &pixels, &s.variance())
}

#[expect(clippy::too_many_arguments, reason = "what was rendered, and what it is held against; called once")]
fn entry(
    name: &str,
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
    let agreement = (!is_reference).then(|| match &reference.sample {
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
        solver: name.to_owned(),
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
        agreement,
        dropped: dropped + spread.dropped,
        picture: layered(size, pixels, &variance, &difference)?,
    })
}

/// The least-squares slope of log error against log time; the first pass, which warms up, is left out where there are enough others.
fn slope(points: &[Point]) -> Option<f64> {
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
fn layered(size: [u32; 2], pixels: &[[f32; 3]], variance: &[[f64; 3]], difference: &[[f32; 3]]) -> Compared<Picture> {
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
