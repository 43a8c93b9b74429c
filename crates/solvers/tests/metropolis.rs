//! Metropolis light transport against closed forms and path tracing; its chains, stopped and resumed, on any number of threads.
//!
//! Each test is one family of claims with 1 % of false alarms, over independent replicates: each has its own bootstrap and its own chains.

mod common;

use common::checks::{agreement, furnace, furnace_scene, round_furnace_scene};
use common::interrupted::leaves_no_trace;
use common::worlds::*;
use common::*;
use etendue_scene::Scene;
use etendue_solvers::metropolis::Metropolis;
use etendue_solvers::metropolis::mutation::Mutation;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::{PathRules, Stop};

/// For small pictures; all light by chains, or direct light by path tracing.
fn metropolis(direct: u32) -> Metropolis {
    Metropolis { chains: 32, bootstrap: 4096, direct, renewal: 256, ..Metropolis::default() }
}

/// The partial Neumann sum of each depth, by chains alone; unbounded, too, where the last class is open.
#[test]
fn furnaces() {
    let mut family = Family::default();
    for (scene, a) in [(round_furnace_scene([0.5; 3]), 0.5), (furnace_scene([0.8; 3]), 0.8)] {
        for n in (0..=4).map(Some).chain([Some(12), None]) {
            furnace(&mut family, "metropolis", &metropolis(0), (&scene, a), n, 512, 0.06);
        }
        furnace(&mut family, "metropolis, direct light traced", &metropolis(2), (&scene, a), None, 512, 0.06);
    }
    family.must_hold();
}

/// Every kind of light, camera and scattering.
#[test]
fn agrees_with_path_mis_everywhere() {
    let mut family = Family::default();
    let mut agrees = |name: &str, scene: &Scene, rules: PathRules, direct: u32, bound: f64| {
        let job = |spp: u32| samples(spp).with(rules);
        let reference = replicates(scene, &PathMis::default(), job(96));
        let ours = replicates(scene, &metropolis(direct), job(384).seed(2));
        agreement(&mut family, &format!("{name}, direct {direct}"), scene, &ours, &reference, bound);
    };
    for (i, (name, scene)) in all_scenes().iter().enumerate() {
        agrees(name, scene, PathRules { max_edges: 5, ..PathRules::default() }, 2 * (i as u32 % 2), 0.9);
    }
    for (null_counts, direct) in [(false, 0), (true, 0), (true, 2)] {
        let rules = PathRules { max_edges: 4, null_counts, ..PathRules::default() }.with_bounces(1..=2);
        agrees(&format!("mask, null counts: {null_counts}"), &room(&eye(), WALLS, &(lamp() + MASK)), rules, direct, 0.9);
    }
    let rules = PathRules { hide_emitters: true, max_edges: 3, ..PathRules::default() };
    agrees("hidden", &room(&eye(), WALLS, &lamp()), rules, 0, 0.9);
    agrees("lengths of the open class alone", &room(&eye(), WALLS, &lamp()), PathRules::default().with_bounces(12..=20), 2, 2.0);
    family.must_hold();
}

/// Chains that never jump but by large steps, that hardly jump, and that begin anew at every pass: all right on average at any number of steps.
#[test]
fn right_whatever_the_parameters() {
    let scene = room(&eye(), WALLS, &(lamp() + GLASS));
    let mut family = Family::default();
    let rules = PathRules { max_edges: 5, ..PathRules::default() };
    let reference = replicates(&scene, &PathMis::default(), samples(128).with(rules));
    let usual = metropolis(2);
    for (name, solver, spp) in [
        ("large steps", Metropolis { mutation: Mutation { large_step: 1.0, ..usual.mutation }, ..usual }, 512),
        ("hardly any", Metropolis { mutation: Mutation { large_step: 0.02, smallest: 0.02, largest: 0.1 }, ..usual }, 512),
        ("renewed at every pass", Metropolis { renewal: 1, chains: 7, bootstrap: 64, ..usual }, 512),
    ] {
        let ours = replicates(&scene, &solver, samples(spp).with(rules).seed(2));
        agreement(&mut family, name, &scene, &ours, &reference, 0.8);
    }
    family.must_hold();
}

/// A room from which the picture's noise is told and then looked for.
fn lit_room() -> Scene {
    let camera = camera_with("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [20, 16], r#"<rfilter type="gaussian"/>"#);
    room(&camera, WALLS, &(lamp() + GLASS))
}

/// The same bits at any number of threads: the chains are a number of the solver's own.
#[test]
fn the_same_bits_on_any_threads() {
    let scene = lit_room();
    for stop in [Stop::Samples(3), Stop::Noise { percent: 1e-9, limit: 17 }] {
        let of = |threads| picture(&scene, &metropolis(2), Job { threads, stop, ..samples(0) });
        let one = of(1);
        assert!(one == of(2) && one == of(5), "{stop:?}");
    }
}

/// Chains of short life, so that they begin anew within the test.
const SHORT: Metropolis = Metropolis {
    chains: 24,
    bootstrap: 128,
    mutation: Mutation { large_step: 0.3, smallest: 1e-3, largest: 1e-2 },
    direct: 2,
    renewal: 2,
};

/// Stopped among the tiles of direct light, among the chains, and where they begin anew: six tiles, three groups of chains.
#[test]
fn stopped_and_resumed_is_undisturbed() {
    for stop in [Stop::Samples(5), Stop::Noise { percent: 1e-9, limit: 33 }] {
        leaves_no_trace(&lit_room(), &SHORT, stop, &[(0, 3), (1, 6), (2, 7), (4, 0)]);
    }
}

/// The error bar of the noise stop, from replicates with their own bootstrap each, is the error: within a factor of 1.4 over six renders.
#[test]
fn the_noise_is_what_it_says() {
    let scene = room(&camera("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [16, 16]), WALLS, &lamp());
    let reference = picture(&scene, &PathMis::default(), samples(4096).seed(99));
    let mean = reference.iter().flatten().map(|r| f64::from(*r)).sum::<f64>() / (3 * reference.len()) as f64;
    let (mut truth, mut told) = (0.0, 0.0);
    for seed in 0..6 {
        let job = Job { stop: Stop::Noise { percent: 1e-9, limit: 256 }, ..samples(0) }.seed(seed);
        let (film, outcome) = render(&scene, &metropolis(2), job);
        told += outcome.noise.expect("noise mode").rel_mse;
        let term = |(x, r): (&f32, &f32)| f64::from(x - r).powi(2) / (f64::from(*r).powi(2) + 0.01 * mean * mean);
        truth +=
            film.develop().iter().flatten().zip(reference.iter().flatten()).map(term).sum::<f64>() / (3 * reference.len()) as f64;
    }
    let ratio = told / truth;
    assert!((1.0 / 1.4..=1.4).contains(&ratio), "told {told:.3e}, true {truth:.3e}, ratio {ratio:.3}");
}
