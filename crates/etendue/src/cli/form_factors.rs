//! `etendue form-factors`: the part of the light of each patch, and of each shape, that arrives at each other.

use super::interrupt::{Words, stop_on_ctrl_c};
use super::scene::{SceneArguments, SizeArguments, scene};
use super::{Done, output, parse};
use clap::{Args, ValueEnum};
use etendue::LoadOptions;
use etendue::form_factors::{ENDINGS, FormFactorOptions, Selection, ShapeFactors, form_factors, json, write};
use etendue_radiosity::form_factor::{Hemisphere, Method, Pairs};
use etendue_radiosity::{Cutting, PatchSize, Sides};
use etendue_solvers::CancelToken;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// Computes form factors (view factors) between patches and between whole shapes.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  etendue form-factors oven.obj -o oven.npz -o oven.csv\n  \
    etendue form-factors scene.xml --between lamp floor --samples 1048576\n\n\
    Without -o the factors between shapes are printed. A shape is named by its id in the file, one facet of it as NAME:FACET.\n\
    .mtx is Matrix Market, .npz opens with scipy.sparse.load_npz.")]
pub struct FormFactorArguments {
    /// A scene file, a plain .obj or .ply, or the name of a built-in scene.
    scene: String,
    /// Write the factors between patches: .json, .csv, .mtx, .npz; may be repeated.
    #[arg(short, long, value_name = "FILE", value_parser = table)]
    output: Vec<PathBuf>,
    /// Only from one shape to another, and back.
    #[arg(long, num_args = 2, value_names = ["SHAPE", "SHAPE"])]
    between: Option<Vec<String>>,
    /// How to find them.
    #[arg(long, value_enum, default_value_t = MethodName::Hemisphere)]
    method: MethodName,
    /// Rays from each patch; 65536 unless told, and 1048576 for `analytic`, which shares them among the patches that may be hidden.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=1 << 30))]
    samples: Option<u32>,
    /// Cut surfaces into patches near this size, in metres; facets and shapes stay whole otherwise.
    #[arg(long, value_name = "METRES", value_parser = parse::positive)]
    patch_size: Option<f64>,
    /// Cut surfaces into about this many patches.
    #[arg(long, value_name = "N", conflicts_with = "patch_size", value_parser = clap::value_parser!(u32).range(1..))]
    patches: Option<u32>,
    /// Count both sides of every surface, and not fronts alone.
    #[arg(long)]
    two_sided: bool,
    /// Leave the factors as they were estimated, without restoring reciprocity and closure.
    #[arg(long)]
    raw: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Seed of the rays.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    common: SceneArguments,
    /// No progress.
    #[arg(short, long)]
    quiet: bool,
}

/// The methods.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum MethodName {
    /// Cosine-distributed rays from each patch.
    Hemisphere,
    /// Closed forms between polygons, less what rays find blocked.
    Analytic,
    /// Quadrature of the double integral.
    Area,
}

fn table(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let known = path.extension().and_then(|e| e.to_str()).is_some_and(|e| ENDINGS.contains(&e));
    if known { Ok(path) } else { Err(format!("a file of form factors ends in .{}", ENDINGS.join(", ."))) }
}

pub fn run(a: &FormFactorArguments) -> Done {
    a.common.no_wavelengths()?;
    let threads = a.common.threads();
    let options = LoadOptions { bare_meshes: true, ..a.common.options(SizeArguments::default()) };
    let loaded = scene(&a.scene, &options, a.quiet)?;

    let size = match (a.patch_size, a.patches) {
        (Some(h), _) => PatchSize::Metres(h),
        (_, Some(n)) => PatchSize::Count(n as usize),
        _ => PatchSize::Whole,
    };
    let sides = if a.two_sided { Sides::Both } else { Sides::Front };
    let method = match a.method {
        MethodName::Hemisphere => {
            Method::Hemisphere(Hemisphere { rays: a.samples.unwrap_or(1 << 16), seed: a.seed, ..Hemisphere::default() })
        }
        MethodName::Analytic => Method::Analytic(Pairs { samples: a.samples.unwrap_or(Pairs::default().samples), seed: a.seed }),
        MethodName::Area => Method::Area,
    };
    let options = FormFactorOptions { cutting: Cutting { size, sides, ..Cutting::default() }, method, repair: !a.raw, threads };

    let cancel = Arc::new(CancelToken::default());
    stop_on_ctrl_c(&cancel, |c| c, Words::default(), "end the program at once");
    let bar = if a.quiet { ProgressBar::hidden() } else { ProgressBar::new(1) };
    let style = ProgressStyle::with_template("{bar:40} {pos} of {len} patches, {eta} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.set_style(style);
    let watch = |done: usize, of: usize| {
        bar.set_length(of as u64);
        bar.set_position(done as u64);
        !cancel.is_cancelled()
    };
    let computed = form_factors(&loaded, &options, &watch);
    bar.finish_and_clear();
    if cancel.is_cancelled() {
        return Ok(ExitCode::from(130));
    }
    let shapes = computed.map_err(|e| e.to_string())?;

    shapes.warnings.iter().for_each(|words| output::message(words));
    summary(&shapes);
    match &a.between {
        Some(names) => pair(&shapes, names, a.json)?,
        None if a.json => output::result(&json(&shapes, false).to_string()),
        None if a.output.is_empty() => table_of_shapes(&shapes),
        None => {}
    }
    for path in &a.output {
        write(&shapes, path).map_err(|e| format!("{}: {e}", path.display()))?;
        output::message(&format!("wrote {}", path.display()));
    }
    Ok(ExitCode::SUCCESS)
}

/// Closure, reciprocity, and what the repair did.
fn summary(shapes: &ShapeFactors) {
    let f = &shapes.factors;
    let (patches, entries) = (shapes.patches.len(), f.matrix.rows.nnz());
    output::message(&format!("{patches} patches, {entries} factors above zero, method {}", shapes.method));
    let (chi_square, pairs, largest) = shapes.reciprocity;
    // Methods that go from pair to pair are reciprocal but for rounding.
    if chi_square > 1e-3 {
        let rms = (chi_square / pairs as f64).sqrt();
        output::message(&format!(
            "reciprocity: of {pairs} pairs that both sides have seen, the two differ by {rms:.2} standard errors (rms), by {largest:.1} at most"
        ));
    }
    if let Some(r) = shapes.repair {
        let noise = if r.moved_by_noise > 0.0 {
            format!(" (noise alone is expected to move {:.2e})", r.moved_by_noise)
        } else {
            String::new()
        };
        let told = if r.closed {
            format!("repair of a closed scene: rows were up to {:.1e} off and are {:.1e}", r.closure_before, r.closure_after)
        } else {
            "repair of an open scene: made reciprocal only".to_owned()
        };
        output::message(&format!(
            "{told}; pairs were {:.1e} off on the whole and are 0; {:.2e} of all light moved to make them agree{noise}, {:.2e} {} ({} sweeps)",
            r.reciprocity_before,
            r.moved_by_symmetry,
            r.moved_by_scaling,
            if r.closed { "to close rows" } else { "so that no row exceeds one" },
            r.sweeps
        ));
        let areas = shapes.patches.patches.iter().map(|p| p.area);
        let total: f64 = areas.clone().sum();
        let mean = |lost: &[f64]| lost.iter().zip(areas.clone()).map(|(l, a)| l * a).sum::<f64>() / total;
        if !r.closed {
            output::message(&format!("escaped: {:.6} of all light; absorbed by backs: {:.6}", mean(&f.escaped), mean(&f.absorbed)));
        }
    }
}

/// One pair of shapes, both ways.
fn pair(shapes: &ShapeFactors, names: &[String], as_json: bool) -> Result<(), String> {
    let select = |name: &String| shapes.select(name).map_err(|e| e.to_string());
    let (a, b) = (select(&names[0])?, select(&names[1])?);
    let mut entries = Vec::new();
    let mut show = |from: &Selection, to: &Selection| {
        let (f, error, zero) = shapes.between_selections(from, to);
        if as_json {
            entries.push(json!({"from": from.name, "to": to.name, "f": f, "standard_error": error, "why_zero": zero}));
        } else {
            output::result(&format!("{} → {}: {f:.8} ± {error:.1e}", from.name, to.name));
        }
        if let Some(why) = zero {
            output::message(&format!("note: from `{}` to `{}` it is 0: {why}", from.name, to.name));
        }
    };
    show(&a, &b);
    if a != b {
        show(&b, &a);
    }
    if as_json {
        output::result(&serde_json::Value::from(entries).to_string());
    }
    Ok(())
}

/// All pairs of shapes that exchange anything.
fn table_of_shapes(shapes: &ShapeFactors) {
    for (a, row) in shapes.between.iter().enumerate() {
        for (b, (f, error)) in row.iter().enumerate().filter(|(_, (f, _))| *f > 0.0) {
            output::result(&format!("{} → {}: {f:.8} ± {error:.1e}", shapes.names[a], shapes.names[b]));
        }
    }
}
