//! `radiosity`: the furnace at every depth; path tracing's pictures, all light and bounce by bounce; the same bits at any number of threads.
//!
//! It is biased by the size of its patches: against path tracing it is held to a stated bound, with the noise of both added.

mod common;

use common::checks::{furnace_scene, neumann, round_furnace_scene};
use common::*;
use etendue_scene::Scene;
use etendue_solvers::PathRules;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::radiosity::{Radiosity, Show};

/// Every row closes, so the equation has the furnace's own answer; what is left is direct light by sampling, and single precision.
#[test]
fn the_furnace_at_every_depth() {
    for a in [0.5f32, 0.9] {
        let (scene, round) = (furnace_scene([a; 3]), round_furnace_scene([a; 3]));
        let solver = Radiosity { patches: 600, samples: 64, residual: 1e-7, ..Radiosity::default() };
        for n in (0..=4).map(Some).chain([None]) {
            let rules = PathRules { max_edges: n.map_or(u32::MAX, |n| n + 1), ..PathRules::default() };
            let want = neumann(f64::from(a), n);
            // As it is, without one random number in the picture.
            let raw = Radiosity { show: Show::Patches as usize, ..solver };
            for pixel in picture(&scene, &raw, samples(1).with(rules)) {
                assert!((f64::from(pixel[0]) / want - 1.0).abs() < 1e-6, "{n:?} bounces of {a}: {} of {want}", pixel[0]);
            }
            // With direct light by light samples, in a ball, where these have little noise: 2 % in the mean is far beyond it.
            let mean = mean_of(&[picture(&round, &solver, samples(64).with(rules))], 0).mean;
            assert!((mean / want - 1.0).abs() < 0.02, "{n:?} bounces of {a}: {mean} of {want}");
        }
    }
}

/// A room with a red wall, a lamp, a box that stands on the floor, and a blue point light.
fn room() -> Scene {
    let at = |kind: &str, transform: &str, inside: &str| {
        format!(r#"<shape type="{kind}"><transform name="to_world">{transform}</transform>{inside}</shape>"#)
    };
    let red = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.1, 0.1"/></bsdf>"#;
    let body = [
        camera("0, -2.8, 0", "0, 0, 0", "0, 0, 1", 45.0, [32, 32]),
        at("rectangle", r#"<translate z="-1"/>"#, &diffuse(0.6)),
        at("rectangle", r#"<rotate x="1" angle="180"/><translate z="1"/>"#, &diffuse(0.6)),
        at("rectangle", r#"<rotate x="1" angle="90"/><translate y="1"/>"#, &diffuse(0.6)),
        at("rectangle", r#"<rotate y="1" angle="90"/><translate x="-1"/>"#, red),
        at("rectangle", r#"<rotate y="1" angle="-90"/><translate x="1"/>"#, &diffuse(0.6)),
        at("cube", r#"<scale value="0.35"/><rotate z="1" angle="20"/><translate x="0.3" y="0.2" z="-0.65"/>"#, &diffuse(0.5)),
        at("rectangle", r#"<scale value="0.3"/><rotate x="1" angle="180"/><translate z="0.99"/>"#, &area("6")),
        r#"<emitter type="point"><point name="position" x="-0.5" y="-0.5" z="0.3"/><rgb name="intensity" value="0.2, 0.2, 0.6"/></emitter>"#
            .to_owned(),
    ];
    scene(&body.concat())
}

/// The mean of each of 4 x 4 blocks, and of all, with its standard error.
fn blocks(pictures: &[Picture]) -> Vec<(f64, f64)> {
    let block = |p: &Picture, b: Option<usize>| {
        let inside = |i: &usize| b.is_none_or(|b| i % 32 / 8 == b % 4 && i / 256 == b / 4);
        let values: Vec<f64> = (0..1024).filter(inside).map(|i| p[i].iter().map(|x| f64::from(*x)).sum::<f64>() / 3.0).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let moments = |b| {
        let x: Vec<f64> = pictures.iter().map(|p| block(p, b)).collect();
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        let variance = x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (x.len() - 1) as f64;
        (mean, (variance / x.len() as f64).sqrt())
    };
    (0..16).map(Some).chain([None]).map(moments).collect()
}

/// All light, and light of exactly 0 to 3 bounces, in all ways to show it: within 1 % in the mean and 3 % (as they are: 12 %) in every
/// block, and five standard errors (a false alarm in 10⁴ runs over all blocks).
#[test]
fn pictures_of_path_tracing() {
    let scene = room();
    let solver = Radiosity { patches: 2000, samples: 256, ..Radiosity::default() };
    for bounces in [0..=u32::MAX - 1, 0..=0, 1..=1, 2..=2, 3..=3] {
        let rules = PathRules::default().with_bounces(bounces.clone());
        let reference = blocks(&replicates(&scene, &PathMis::default(), samples(32).with(rules)));
        for show in [Show::Smooth, Show::Gather, Show::Patches] {
            if show != Show::Smooth && bounces != (0..=u32::MAX - 1) && bounces != (2..=2) {
                continue;
            }
            let shown = Radiosity { show: show as usize, ..solver };
            // Independent display rays; the solution, and its bias, are those of a seed each.
            let four: Vec<Picture> = (0..4).map(|s| picture(&scene, &shown, samples(64).with(rules).seed(s))).collect();
            let bound = if show == Show::Patches { 0.12 } else { 0.03 };
            let found = blocks(&four);
            for (b, ((x, ex), (y, ey))) in found.iter().zip(&reference).enumerate() {
                let bias = if b == 16 { bound / 3.0 } else { bound } * y.max(0.1 * reference[16].0);
                let noise = 5.0 * (ex * ex + ey * ey).sqrt();
                assert!((x - y).abs() <= bias + noise, "{show:?}, bounces {bounces:?}, block {b}: {x} ± {ex}, path-mis {y} ± {ey}");
            }
        }
    }
}

#[test]
fn the_books_close() {
    let (_, outcome) = render(&room(), &Radiosity { patches: 1000, samples: 64, ..Radiosity::default() }, samples(1));
    let books = outcome.books.expect("books");
    for c in 0..3 {
        assert!(books.emitted[c] > 0.0 && books.escaped[c] > 0.0 && books.absorbed[c] > 0.0);
        assert!(books.residual[c].abs() < 1e-3 * books.emitted[c], "{books:?}");
    }
}
