//! Radiosity: how errors shrink with patches, and how time and memory grow with them.

use crate::Drawn;
use crate::canvas::{Curve, Shot, plot};
use etendue::radiosity::solve;
use etendue::{Image, LoadOptions, Stop, load};
use etendue_radiosity::PatchSize;
use etendue_radiosity::solved::{Factors, Settings};
use std::path::Path;
use std::process::Command;

/// Blocks along a side of the picture.
const BLOCKS: usize = 8;

/// Means of luminance over blocks.
fn blocks(image: &Image) -> Vec<f64> {
    let rgb = image.to_rgb();
    let (w, h) = (rgb.width(), rgb.height());
    let mut sums = vec![(0.0, 0.0); BLOCKS * BLOCKS];
    for (i, p) in rgb.pixels().enumerate() {
        let (sum, count) = &mut sums[i / w * BLOCKS / h * BLOCKS + i % w * BLOCKS / w];
        *sum += 0.2126 * f64::from(p[0]) + 0.7152 * f64::from(p[1]) + 0.0722 * f64::from(p[2]);
        *count += 1.0;
    }
    sums.into_iter().map(|(sum, count)| sum / count).collect()
}

/// The Cornell box with ever more patches against path tracing: block by block, relative. The reference has 0.05 % of noise rms, of 2048 samples it had 0.14 %.
pub fn convergence(folder: &Path) -> Drawn {
    let shot = |solver, parameters: &[(&str, &str)], samples| {
        Shot { scene: "cornell-box", solver, parameters, width: 128, stop: Stop::Samples(samples) }.take()
    };
    let truth = blocks(&shot("path-mis", &[], 16_384)?);
    let (mut worst, mut rms) = (Vec::new(), Vec::new());
    for n in [750u32, 1500, 3000, 6000, 12_000, 24_000] {
        let found = blocks(&shot("radiosity", &[("patches", &n.to_string())], 256)?);
        let off: Vec<f64> = found.iter().zip(&truth).map(|(a, b)| (a / b - 1.0).abs()).collect();
        worst.push((f64::from(n), 100.0 * off.iter().copied().fold(0.0, f64::max)));
        rms.push((f64::from(n), 100.0 * (off.iter().map(|x| x * x).sum::<f64>() / off.len() as f64).sqrt()));
        let mean = found.iter().sum::<f64>() / truth.iter().sum::<f64>() - 1.0;
        println!(
            "{n} patches: mean {:+.3} %, worst block {:.2} %, rms {:.3} %",
            100.0 * mean,
            worst[worst.len() - 1].1,
            rms[rms.len() - 1].1
        );
    }
    println!("falls as n^-p: p = {:.2} of the worst block, {:.2} rms", -slope(&worst), -slope(&rms));
    let line = |name: &str, points: Vec<(f64, f64)>| Curve { name: name.to_owned(), points };
    let guide = worst.iter().map(|(n, _)| (*n, worst[0].1 * worst[0].0 / n)).collect();
    let curves = [line("worst block", worst), line("all blocks, rms", rms), line("1 / n", guide)];
    plot(&folder.join("radiosity-convergence.svg"), "patches", "error of 8 x 8 blocks, %", &curves)
}

/// The exponent of the power of x that fits best.
fn slope(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let n = logs.len() as f64;
    let (x, y) = logs.iter().fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
    let (xy, xx) = logs.iter().fold((0.0, 0.0), |s, p| (s.0 + (p.0 - x) * (p.1 - y), s.1 + (p.0 - x).powi(2)));
    xy / xx
}

/// What is solved: a method, its rays, numbers of patches.
const SERIES: [(Factors, u32, &[u32]); 4] = [
    (Factors::Hemisphere, 64, &[1000, 10_000, 100_000, 1_000_000]),
    (Factors::Hemisphere, 1024, &[1000, 10_000, 100_000]),
    (Factors::Analytic, 1024, &[300, 1000, 3000]),
    (Factors::Area, 1024, &[100, 300]),
];

/// The name under which this program calls itself for one of them: memory is what a process has held at most.
pub const CHILD: &str = "growth-of";

/// Time and memory of factors, repair and solution of the Cornell box, as a table and two plots.
pub fn growth(folder: &Path) -> Drawn {
    let (mut seconds, mut bytes) = (Vec::new(), Vec::new());
    println!("| method | rays a patch | patches | CPU s | MiB |\n| --- | ---: | ---: | ---: | ---: |");
    for (factors, rays, sizes) in SERIES {
        let (mut time, mut memory) = (Vec::new(), Vec::new());
        for n in sizes {
            let run =
                Command::new(std::env::current_exe()?).args([CHILD, factors.name(), &rays.to_string(), &n.to_string()]).output()?;
            let told = String::from_utf8_lossy(&run.stdout).into_owned();
            let numbers: Vec<f64> = told.split_whitespace().filter_map(|w| w.parse().ok()).collect();
            let [patches, cpu, most] = numbers[..] else {
                println!("{} {rays} {n}: {}", factors.name(), String::from_utf8_lossy(&run.stderr));
                continue;
            };
            println!("| `{}` | {rays} | {patches} | {cpu:.1} | {:.0} |", factors.name(), most / f64::from(1 << 20));
            time.push((patches, cpu));
            memory.push((patches, most / f64::from(1 << 20)));
        }
        if time.len() > 1 {
            println!("`{}`, {rays} rays: time as n^{:.2}, memory as n^{:.2}", factors.name(), slope(&time), slope(&memory));
        }
        let name = if factors == Factors::Hemisphere { format!("hemisphere, {rays} rays") } else { factors.name().to_owned() };
        seconds.push(Curve { name: name.clone(), points: time });
        bytes.push(Curve { name, points: memory });
    }
    plot(&folder.join("radiosity-time.svg"), "patches", "CPU s", &seconds)?;
    plot(&folder.join("radiosity-memory.svg"), "patches", "MiB", &bytes)
}

/// One of them: prints patches, CPU seconds (on Linux; elsewhere those of the clock) and the most bytes held.
pub fn growth_of(arguments: &[String]) -> Drawn {
    let [name, rays, n] = arguments else { return Err("a method, rays, patches".into()) };
    let factors = Factors::named(name).ok_or("no such method")?;
    let loaded = load("cornell-box", &LoadOptions::default())?;
    let size = PatchSize::Count(n.parse()?);
    let settings = Settings { size, adaptive: false, factors, rays: rays.parse()?, ..Settings::default() };
    let before = cpu_seconds();
    let (_, report) = solve(&loaded, &settings, None, &|_| true)?;
    let cpu = cpu_seconds().zip(before).map_or(report.seconds, |(after, before)| after - before);
    println!("{} {cpu} {}", report.patches, report.peak_memory_bytes);
    Ok(())
}

/// Of this process, as Linux counts them in hundredths.
fn cpu_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = text.rsplit(')').next()?.split_whitespace().collect();
    Some((fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?) / 100.0)
}
