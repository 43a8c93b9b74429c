//! `etendue measure`.

use super::radiosity::{SolutionArguments, solved};
use super::scene::{SceneArguments, SizeArguments, scene};
use super::{Done, files, output, parse};
use clap::{Args, ValueEnum};
use etendue::radiosity::export::LUMINOUS_EFFICACY;
use etendue::radiosity::measure::{Grid, Reading, false_colour, read};
use etendue_image::{SaveOptions, save, write_atomically};
use etendue_solvers::irradiance::Meter;
use glam::DVec3;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Measures illuminance and irradiance.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  etendue measure room.xml --grid 0,0.8,0 0,0,4 5,0,0 --cells 20x25 -o desk.png -o desk.csv\n  \
    etendue measure room.xml --at 1,0.8,2 --normal 0,1,0 --json\n\n\
    A grid has a corner and two edges from it; the side that their cross product points to is lit. Readings stand in the middles of its cells.\n\
    Lux are K times the luminance of the irradiance, K = 683.002 lm/W unless --luminous-efficacy says otherwise."
)]
pub struct MeasureArguments {
    /// A scene file, or the name of a built-in scene.
    scene: String,
    /// A corner and two edges of a grid, metres.
    #[arg(long, num_args = 3, value_names = ["X,Y,Z", "X,Y,Z", "X,Y,Z"], value_parser = vector, allow_negative_numbers = true, allow_hyphen_values = true)]
    grid: Option<Vec<DVec3>>,
    /// Points along the edges.
    #[arg(long, value_name = "NxM", default_value = "16x16", value_parser = cells)]
    cells: [usize; 2],
    /// A point, metres; may be given again.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, conflicts_with = "grid", requires = "normal")]
    at: Vec<DVec3>,
    /// The normal of the plane of all points.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    normal: Option<DVec3>,
    /// What measures.
    #[arg(long, value_enum, default_value_t = By::Both)]
    by: By,
    /// Rays of a reading, in 16 replicates.
    #[arg(long, value_name = "N", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(16..=1 << 30))]
    rays: u32,
    /// K, lm/W.
    #[arg(long, value_name = "K", default_value_t = LUMINOUS_EFFICACY, value_parser = parse::positive)]
    luminous_efficacy: f64,
    /// .csv, .json, or .png: false colours of a grid with a legend. May be given again.
    #[arg(short, long, value_name = "FILE", value_parser = file)]
    output: Vec<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    solution: SolutionArguments,
    #[command(flatten)]
    common: SceneArguments,
    /// Show nothing but errors and results.
    #[arg(short, long)]
    quiet: bool,
}

/// What measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum By {
    /// A solution of the radiosity equation; direct light by rays to the lights.
    Radiosity,
    /// Path tracing.
    Path,
    /// One beside the other.
    Both,
}

fn vector(text: &str) -> Result<DVec3, String> {
    let lanes: Option<Vec<f64>> = text.split(',').map(|t| t.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    match lanes.as_deref() {
        Some([x, y, z]) => Ok(DVec3::new(*x, *y, *z)),
        _ => Err(format!("`{text}` is not of the form X,Y,Z")),
    }
}

fn cells(text: &str) -> Result<[usize; 2], String> {
    let number = |t: &str| t.parse::<usize>().ok().filter(|n| (1..=4096).contains(n));
    match text.split_once('x').map(|(a, b)| (number(a), number(b))) {
        Some((Some(n), Some(m))) => Ok([n, m]),
        _ => Err(format!("`{text}` is not of the form NxM, each from 1 to 4096")),
    }
}

fn file(text: &str) -> Result<PathBuf, String> {
    let known = [".csv", ".json", ".png"].iter().any(|e| text.ends_with(e));
    if known { Ok(text.into()) } else { Err("measurements are written to .csv, .json or .png".to_owned()) }
}

/// A method's name and its readings.
type Series = (&'static str, Vec<Reading>);

pub fn run(a: &MeasureArguments) -> Done {
    a.output.iter().try_for_each(|path| files::writable(path))?;
    let grid = a.grid.as_ref().map(|g| Grid { origin: g[0], edges: [g[1], g[2]], cells: a.cells });
    let meters: Vec<Meter> = match (&grid, a.normal.map(DVec3::try_normalize)) {
        (Some(grid), _) => grid.meters().ok_or("the two edges of the grid span no plane")?,
        (None, Some(Some(n))) => a.at.iter().map(|p| Meter { p: p.as_vec3(), n: n.as_vec3() }).collect(),
        (None, Some(None)) => return Err("--normal has no direction".to_owned()),
        (None, None) => Vec::new(),
    };
    if meters.is_empty() {
        return Err("there is nothing to measure\n  help: give --grid CORNER EDGE EDGE, or --at X,Y,Z --normal X,Y,Z".to_owned());
    }
    if grid.is_none() && a.output.iter().any(|p| p.extension().is_some_and(|e| e == "png")) {
        return Err("a false-colour picture wants a --grid".to_owned());
    }
    let threads = a.common.threads();
    let loaded = scene(&a.scene, &a.common.options(SizeArguments::default()), a.quiet)?;

    let k = a.luminous_efficacy;
    let mut series: Vec<Series> = Vec::new();
    if a.by != By::Path {
        let (solution, ..) = solved(&loaded, &a.solution, threads, a.quiet)?;
        let readings = read(&loaded, Some(&solution), &meters, a.rays, a.solution.seed, k, threads);
        series.push(("radiosity", readings.map_err(|e| e.to_string())?));
    }
    if a.by != By::Radiosity {
        let readings = read(&loaded, None, &meters, a.rays, a.solution.seed, k, threads);
        series.push(("path", readings.map_err(|e| e.to_string())?));
    }
    for path in &a.output {
        let told = |e: &dyn std::fmt::Display| format!("cannot write {}: {e}", path.display());
        match path.extension().and_then(|e| e.to_str()) {
            Some("png") => {
                let picture = false_colour(&series[0].1, a.cells, k).map_err(|e| told(&e))?;
                save(path, &picture.into(), &SaveOptions::default()).map_err(|e| told(&e))?;
            }
            Some("json") => {
                write_atomically(path, (json_of(&meters, &series, k).to_string() + "\n").as_bytes()).map_err(|e| told(&e))?
            }
            _ => write_atomically(path, csv(&meters, &series, k).as_bytes()).map_err(|e| told(&e))?,
        }
        if !a.quiet {
            output::message(&format!("wrote {}", path.display()));
        }
    }
    if a.json {
        output::result(&json_of(&meters, &series, k).to_string());
    } else if a.output.is_empty() {
        table(&meters, &series, k);
    } else if !a.quiet {
        summary(&series, k);
    }
    Ok(ExitCode::SUCCESS)
}

fn json_of(meters: &[Meter], series: &[Series], k: f64) -> Value {
    let points: Vec<Value> = meters
        .iter()
        .enumerate()
        .map(|(i, m)| {
            let mut point = json!({ "position": m.p.to_array(), "normal": m.n.to_array() });
            series.iter().for_each(|(name, readings)| point[name] = json!(readings[i]));
            point
        })
        .collect();
    let units = json!({ "position": "m", "irradiance": "W/m2, linear Rec.709", "illuminance": "lx", "illuminance_95": "lx, half of the 95 % interval" });
    json!({ "luminous_efficacy_lm_per_W": k, "units": units, "points": points })
}

fn csv(meters: &[Meter], series: &[Series], k: f64) -> String {
    let mut text = "x_m,y_m,z_m,nx,ny,nz".to_owned();
    for (name, _) in series {
        let e = |c: &str| format!("{name}_irradiance_{c}_W_per_m2");
        let _ = write!(text, ",{},{},{},{name}_illuminance_lx_at_{k}_lm_per_W,{name}_illuminance_95_lx", e("r"), e("g"), e("b"));
    }
    text.push('\n');
    for (i, m) in meters.iter().enumerate() {
        let place: Vec<String> = m.p.to_array().iter().chain(&m.n.to_array()).map(f32::to_string).collect();
        text += &place.join(",");
        for r in series.iter().map(|(_, readings)| &readings[i]) {
            let [red, green, blue] = r.irradiance;
            let _ = write!(text, ",{red},{green},{blue},{},{}", r.illuminance, r.illuminance_95);
        }
        text.push('\n');
    }
    text
}

/// A line a point.
fn table(meters: &[Meter], series: &[Series], k: f64) {
    let names: Vec<String> = series.iter().map(|(name, _)| format!("{name:>24}")).collect();
    output::result(&format!("{:>30}  {}   lx at K = {k} lm/W, ± 95 %", "x, y, z in m", names.join(" ")));
    for (i, m) in meters.iter().enumerate() {
        let place = m.p.to_array().map(|x| format!("{x:.4}")).join(", ");
        let lux = series.iter().map(|(_, r)| format!("{:>14.5} ± {:<7.2}", r[i].illuminance, r[i].illuminance_95));
        output::result(&format!("{place:>30}  {}", lux.collect::<Vec<_>>().join(" ")));
    }
}

/// Least, mean and most of each method.
fn summary(series: &[Series], k: f64) {
    for (name, readings) in series {
        let lux = || readings.iter().map(|r| r.illuminance);
        let (low, high) = lux().fold((f64::INFINITY, 0.0f64), |(low, high), x| (low.min(x), high.max(x)));
        let mean = lux().sum::<f64>() / readings.len() as f64;
        output::message(&format!(
            "{name}: {low:.4} to {high:.4} lx, mean {mean:.4} lx, uniformity {:.3}, K = {k} lm/W",
            low / mean
        ));
    }
}
