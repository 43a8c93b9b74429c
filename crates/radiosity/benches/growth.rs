//! How time and memory of radiosity grow with the number of patches: `cargo bench -p etendue-radiosity --bench growth`.
//!
//! A hall of boxes and balls, half of each, hanging between sixteen lamps: a thousand and more of them, or one to ten patches where there are only a few
//! patches. From 1e3 to 1e6 patches, by links (`hierarchical`) and by a matrix (`hemisphere`, as far as memory goes), each in a process of its own:
//!
//! | argument after `--` | |
//! | --- | --- |
//! | METHOD PATCHES [ERROR] | that run alone |
//! | `scene` PATCHES | the scene's text |
//!
//! CPU seconds are of all threads, from the text of the scene to the solution; the exponent p of n^p is fitted by least squares to their logarithms.

#![allow(clippy::print_stdout, reason = "what it measured is all that it has to say")]

mod common;

use common::{compile, usage};
use etendue_numerics::sequence::{mix, unit};
use etendue_radiosity::patch::PatchSize;
use etendue_radiosity::solved::{Factors, Settings, Solved, Stage};
use std::fmt::Write as _;
use std::time::Instant;

/// Sizes; the matrix goes up to [`MATRIX`].
const SIZES: [usize; 7] = [1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000];
const MATRIX: usize = 100_000;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    match &arguments[..] {
        [] => table(),
        [what, patches, errors @ ..] if what == "check" => check(number(patches), errors),
        [what, patches] if what == "scene" => println!("{}", hall(objects(number(patches)))),
        [method, patches, rest @ ..] => alone(method, number(patches), rest.first().map(|e| e.parse().expect("a number"))),
        _ => println!("METHOD PATCHES [ERROR], or nothing"),
    }
}

fn number(text: &str) -> usize {
    text.parse().expect("a number of patches")
}

/// Objects of the hall: 1000, and more where there are very many patches; fewer where there are too few patches for their sides.
fn objects(patches: usize) -> usize {
    (patches / 300).clamp(1000.min(patches / 10), 2000)
}

/// One run.
fn alone(method: &str, patches: usize, error: Option<f64>) {
    let factors = Factors::named(method).expect("a method");
    let begun = Instant::now();
    let scene = compile(&hall(objects(patches)));
    let defaults = Settings::default();
    let settings =
        Settings { size: PatchSize::Count(patches), adaptive: false, factors, error: error.unwrap_or(defaults.error), ..defaults };
    let told = |stage: Stage| {
        if std::env::var_os("VERBOSE").is_some() {
            println!("{:8.1} s {stage:?}", begun.elapsed().as_secs_f64());
        }
        true
    };
    let solved = Solved::new(&scene, &settings, &told).expect("a solution");
    let (seconds, [cpu, peak]) = (begun.elapsed().as_secs_f64(), usage());
    let energy = solved.equation().energy(&solved.solution.b);
    println!(
        "{method} {} {} {cpu:.2} {seconds:.2} {:.0} {} {:.3} {:.1e} {:.1e}",
        scene.surfaces.len(),
        solved.patches.len(),
        peak / 1048576.0,
        solved.exchange.entries(),
        solved.exchange.links().map_or(f64::NAN, |l| l.bound),
        solved.solution.residual(),
        energy.residual.element_sum() / energy.emitted.element_sum(),
    );
}

/// Errors that are stated, bounded and there, against a matrix of many rays, whose own noise is that between two of them.
fn check(patches: usize, errors: &[String]) {
    let scene = compile(&hall(objects(patches)));
    let with = |settings: Settings| {
        let settings = Settings { size: PatchSize::Count(patches), adaptive: false, residual: 1e-6, ..settings };
        Solved::new(&scene, &settings, &|_| true).expect("a solution")
    };
    let exact = |seed| with(Settings { rays: 16_384, seed, ..Settings::default() });
    let [one, other] = [exact(1), exact(2)];
    let equation = one.equation();
    let light: Vec<_> = one.solution.b.iter().zip(&equation.be).map(|(b, be)| *b - *be).collect();
    let far = |a: &Solved, b: &Solved| {
        let d: Vec<_> = a.solution.b.iter().zip(&b.solution.b).map(|(a, b)| *a - *b).collect();
        equation.norm(&d) / equation.norm(&light)
    };
    println!("noise of the matrix {:.5}", far(&one, &other) / 2f64.sqrt());
    for error in errors {
        let links =
            with(Settings { factors: Factors::Hierarchical, error: error.parse().expect("a number"), ..Settings::default() });
        let h = links.exchange.links().expect("links");
        println!(
            "stated {error}, {} links, {} rays a patch, bound {:.4}, there {:.5}",
            h.links,
            h.rays,
            h.bound,
            far(&links, &one)
        );
    }
}

/// All runs, each in a process of its own.
fn table() {
    println!("method surfaces patches cpu_s wall_s peak_MiB entries bound residual energy_residual");
    for method in ["hierarchical", "hemisphere"] {
        let mut points = Vec::new();
        for n in SIZES.iter().filter(|n| method == "hierarchical" || **n <= MATRIX) {
            let program = std::env::current_exe().expect("this program");
            let out = std::process::Command::new(program).args([method, &n.to_string()]).output().expect("a run");
            let line = String::from_utf8_lossy(&out.stdout);
            print!("{line}");
            let numbers: Vec<f64> = line.split_whitespace().filter_map(|w| w.parse().ok()).collect();
            points.extend((numbers.len() > 2 && *n >= 10_000).then(|| (numbers[1].ln(), numbers[2].ln())));
        }
        println!("{method}: CPU seconds grow as n^{:.2} from 1e4 patches on", slope(&points));
    }
}

/// The slope of the line through points, by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
    let (xy, xx) = points.iter().fold((0.0, 0.0), |s, p| (s.0 + (p.0 - x) * (p.1 - y), s.1 + (p.0 - x).powi(2)));
    xy / xx
}

/// A closed hall of 10 x 4 x 10 m with `n` things in it, on a jittered grid, and sixteen lamps under its ceiling.
fn hall(n: usize) -> String {
    let mut text = r#"<scene version="3.0.0">
<integrator type="path"/>
<sensor type="perspective">
  <float name="fov" value="75"/>
  <transform name="to_world"><lookat origin="-4.8,1.2,-4.8" target="1,-1,1" up="0,1,0"/></transform>
  <film type="hdrfilm"><integer name="width" value="480"/><integer name="height" value="320"/></film>
</sensor>
<shape type="cube"><boolean name="flip_normals" value="true"/>
  <transform name="to_world"><scale x="5" y="2" z="5"/></transform>
  <bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.65, 0.6"/></bsdf></shape>
"#
    .to_owned();
    for k in 0..16 {
        let at = |i: usize| -3.75 + 2.5 * i as f64;
        let _ = writeln!(
            text,
            r#"<shape type="cube"><transform name="to_world"><scale x="0.3" y="0.03" z="0.3"/><translate x="{}" y="1.9" z="{}"/></transform>
  <emitter type="area"><rgb name="radiance" value="8, 7.5, 7"/></emitter></shape>"#,
            at(k % 4),
            at(k / 4)
        );
    }
    let layers = (n as f64 * 0.16).cbrt().round().max(1.0);
    let side = (n as f64 / layers).sqrt().ceil();
    let (dx, dy) = (9.6 / side, 3.2 / layers);
    for i in 0..n {
        let u = |k: u64| f64::from(unit(mix(mix(i as u64) + k) as u32));
        let cell = [i as f64 % side, (i as f64 / side).floor() % side, (i as f64 / (side * side)).floor()];
        let r = dx.min(dy) * (0.15 + 0.15 * u(0));
        let place = |low: f64, d: f64, k: usize| low + d * (cell[k] + 0.5 + 0.3 * (u(k as u64 + 1) - 0.5));
        let (x, y, z) = (place(-4.8, dx, 0), place(-1.8, dy, 2), place(-4.8, dx, 1));
        let colour = [4, 5, 6].map(|k| 0.2 + 0.6 * u(k));
        let (shape, size) = if i % 2 == 0 { ("sphere", r) } else { ("cube", 0.7 * r) };
        let _ = writeln!(
            text,
            r#"<shape type="{shape}"><transform name="to_world"><scale value="{size}"/><rotate x="1" angle="{}"/><rotate y="1" angle="{}"/><translate x="{x}" y="{y}" z="{z}"/></transform>
  <bsdf type="diffuse"><rgb name="reflectance" value="{}, {}, {}"/></bsdf></shape>"#,
            90.0 * u(7),
            90.0 * u(8),
            colour[0],
            colour[1],
            colour[2]
        );
    }
    text + "</scene>\n"
}
