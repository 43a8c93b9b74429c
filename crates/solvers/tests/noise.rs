//! The noise stop: its estimate against the truth, and its promise.
//!
//! relMSE = mean((x - r)²/(r² + e)), e = 0.01 · (mean r)² of a reference r; estimated from K = 16 replicates within the render.

mod common;

use common::*;
use etendue_scene::Scene;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::{Spread, Stop, Stopped};

fn scene_through(filter: &str) -> Scene {
    scene(&format!(
        r#"{}<shape type="cube"><boolean name="flip_normals" value="true"/>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.6, 0.5"/></bsdf></shape>
        <shape type="sphere"><point name="center" value="0.3, 0.2, 0.3"/><float name="radius" value="0.3"/>{}</shape>"#,
        camera_with("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [16, 16], filter),
        area("5, 4, 3")
    ))
}

fn rel_mse(x: &Picture, reference: &Picture) -> f64 {
    let n = (3 * reference.len()) as f64;
    let mean = reference.iter().flatten().map(|r| f64::from(*r)).sum::<f64>() / n;
    let e = 0.01 * mean * mean;
    let term = |(x, r): (&f32, &f32)| (f64::from(*x) - f64::from(*r)).powi(2) / (f64::from(*r).powi(2) + e);
    x.iter().flatten().zip(reference.iter().flatten()).map(term).sum::<f64>() / n
}

const FILTERS: [(&str, &str); 3] = [
    ("box", r#"<rfilter type="box"/>"#),
    ("tent", r#"<rfilter type="tent"><float name="radius" value="1"/></rfilter>"#),
    ("gaussian", r#"<rfilter type="gaussian"/>"#),
];

/// The mean estimate over eight renders is near the mean truth, with as many samples in every pixel and with more where there is noise: 0.87 to 1.00 of it for these seeds. (It is
/// low by up to a tenth at so few samples: replicates that met bright light by chance raise the mean that their variance is divided by.)
fn the_estimate_is_near_the_truth(name: &str, scene: &Scene, reference: &Picture) {
    for spread in [Spread::Uniform, Spread::Adaptive] {
        let (mut truth, mut told) = (0.0, 0.0);
        for seed in 0..8 {
            let job = Job { stop: Stop::Noise { percent: 1e-9, limit: 64 }, spread, ..samples(0) }.seed(seed);
            let (film, outcome) = render(scene, &PathMis::default(), job);
            assert_eq!(outcome.stopped, Stopped::Limit);
            truth += rel_mse(&film.develop(), reference);
            told += outcome.noise.expect("noise mode").rel_mse;
        }
        let ratio = told / truth;
        assert!((0.8..=1.15).contains(&ratio), "{name}, {spread:?}: told {told:.3e}, true {truth:.3e}, ratio {ratio:.3}");
    }
}

/// What was asked for is reached: the true error is at most 1.3 times the target.
fn the_target_is_reached(name: &str, scene: &Scene, reference: &Picture) {
    for percent in [12.0, 6.0] {
        let job = Job { stop: Stop::Noise { percent, limit: 4096 }, ..samples(0) };
        let (film, outcome) = render(scene, &PathMis::default(), job);
        assert_eq!(outcome.stopped, Stopped::Noise);
        let rounds = outcome.passes / 16;
        assert!(outcome.passes.is_multiple_of(16) && rounds.is_power_of_two(), "tested at {}", outcome.passes);
        let truth = 100.0 * rel_mse(&film.develop(), reference).sqrt();
        assert!(truth <= 1.3 * percent, "{name}: asked for {percent} %, got {truth:.2} %");
    }
}

#[test]
fn the_estimate_and_the_promise_hold_for_every_filter() {
    for (name, filter) in FILTERS {
        let scene = scene_through(filter);
        let reference = picture(&scene, &PathMis::default(), samples(2048).seed(99));
        the_estimate_is_near_the_truth(name, &scene, &reference);
        the_target_is_reached(name, &scene, &reference);
    }
}

/// Darkness has no noise, and ends at the first test.
#[test]
fn a_dark_scene_ends() {
    let scene = scene(&camera("0, 0, 0", "0, 0, 1", "0, 1, 0", 75.0, [8, 8]));
    let (_, outcome) = render(&scene, &PathMis::default(), Job { stop: Stop::Noise { percent: 1.0, limit: 4096 }, ..samples(0) });
    assert_eq!((outcome.stopped, outcome.passes), (Stopped::Noise, 16));
}
