//! Bidirectional path tracing against closed forms, against path tracing, and each strategy against the others.
//!
//! Each test is one family of claims with 1 % of false alarms, over independent replicates.

mod common;

use common::checks::{agreement, furnace, furnace_scene, round_furnace_scene};
use common::interrupted::leaves_no_trace;
use common::worlds::*;
use common::*;
use etendue_numerics::{Dim, Sampler, SequenceKind, Spectrum, Vec2, Wavelengths};
use etendue_scene::Scene;
use etendue_solvers::bidirectional::literal::Whole;
use etendue_solvers::bidirectional::strategies::{self, StrategyPicture};
use etendue_solvers::bidirectional::{Bidirectional, Found, Paths};
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::transport::PathState;
use etendue_solvers::{CancelToken, PathRules, Progress, Run, Spread, Stop};

const BOTH: [Bidirectional; 2] = [Bidirectional { exponent: 1, faint: 0.0 }, Bidirectional { exponent: 2, faint: 0.05 }];
#[test]
fn furnaces() {
    let mut family = Family::default();
    for (solver, a) in BOTH.iter().zip([0.5, 0.8]) {
        for scene in [furnace_scene([a; 3]), round_furnace_scene([a; 3])] {
            for n in (0..=4).map(Some).chain([None]) {
                furnace(&mut family, "bidirectional", solver, (&scene, a), n, 64, 0.05);
            }
        }
    }
    family.must_hold();
}

/// Claims that it agrees with path-mis.
fn agrees(family: &mut Family, name: &str, scene: &Scene, rules: PathRules, [ours, mis]: [u32; 2], bound: f64) {
    let job = |spp: u32| samples(spp).with(rules);
    let reference = replicates(scene, &PathMis::default(), job(mis));
    for solver in BOTH {
        let name = format!("exponent {}, {name}", solver.exponent);
        agreement(family, &name, scene, &replicates(scene, &solver, job(ours).seed(2)), &reference, bound);
    }
}

#[test]
fn a_diffuse_box() {
    let mut family = Family::default();
    for bounces in [0..=0, 1..=1, 2..=5] {
        let rules = PathRules::default().with_bounces(bounces.clone());
        agrees(&mut family, &format!("{bounces:?}"), &room(&eye(), WALLS, &lamp()), rules, [48, 64], 0.4);
    }
    family.must_hold();
}

/// Each strategy's pictures.
fn strategy_pictures(scene: &Scene, rules: PathRules, spp: u32, vertices: u32, seed: u64) -> Vec<StrategyPicture> {
    let run = Run {
        view: 0,
        seed,
        sequence: SequenceKind::Sobol,
        stop: Stop::Samples(spp),
        spread: Spread::Uniform,
        rules,
        digest: 0,
        pool: &threads(2),
        cancel: &CancelToken::default(),
        progress: &Progress::default(),
        events: &|_| (),
        checkpoint_every: None,
    };
    strategies::pictures(&Bidirectional::default(), scene, &run, spp, vertices)
}

/// A run for tests that need no driver.
fn with_run<T>(rules: PathRules, seed: u64, f: impl FnOnce(&Run<'_>) -> T) -> T {
    f(&Run {
        view: 0,
        seed,
        sequence: SequenceKind::Sobol,
        stop: Stop::Samples(16),
        spread: Spread::Uniform,
        rules,
        digest: 0,
        pool: &threads(2),
        cancel: &CancelToken::default(),
        progress: &Progress::default(),
        events: &|_| (),
        checkpoint_every: None,
    })
}

/// Every strategy with t ≥ 1 alone finds all light of its number of edges, in every block and channel: the furnace of diffuse walls, and a ball of rough
/// copper. All strategies, blocks and channels are one family with 1 % of false alarms.
#[test]
fn each_strategy_alone_finds_all() {
    let mut family = Family::default();
    let metal = r#"<bsdf type="roughconductor"><string name="material" value="Cu"/><float name="alpha" value="0.5"/></bsdf>"#;
    let wide = r#"<shape type="sphere"><point name="center" x="0.3" y="0.2" z="0.4"/><float name="radius" value="0.3"/>
        <bsdf type="diffuse"/><emitter type="area"><rgb name="radiance" value="3, 4, 5"/></emitter></shape>"#;
    // Round, since between the walls of a corner 1/r² has no variance.
    let wall = format!(r#"<shape type="sphere"><boolean name="flip_normals" value="true"/>{metal}</shape>"#);
    let metal_ball = scene(&format!("{}{wall}{wide}", eye()));
    let scenes = [("ball", round_furnace_scene([0.5, 0.6, 0.4]), 4096), ("metal", metal_ball, 8192)];
    for (name, scene, spp) in &scenes {
        let rules = PathRules { max_edges: 4, ..PathRules::default() };
        let all: Vec<_> = (0..K).map(|seed| strategy_pictures(scene, rules, spp / 16, 5, seed + 7)).collect();
        let pictures = |i: usize| all.iter().map(|p| p[i].unweighted.clone()).collect::<Vec<_>>();
        for edges in 1..=4u32 {
            let of = |s: u32| all[0].iter().position(|p| p.s == s && p.s + p.t == edges + 1).expect("strategy");
            // Next event estimation, and of what the lens sees directly the walk from the eye.
            let best = u32::from(edges > 1);
            let reference = pictures(of(best));
            for s in (0..=edges).filter(|s| *s != best) {
                let name = format!("{name}: ({s}, {})", edges + 1 - s);
                agreement(&mut family, &name, scene, &pictures(of(s)), &reference, 0.8);
            }
        }
    }
    family.must_hold();
}

/// All weighted pictures together are the picture.
#[test]
fn the_weighted_pictures_sum_to_the_picture() {
    let scene = room(&eye(), WALLS, &lamp());
    let rules = PathRules { max_edges: 4, ..PathRules::default() };
    let parts = strategy_pictures(&scene, rules, 16, 5, 3);
    let whole = picture(&scene, &Bidirectional { faint: 0.0, ..Bidirectional::default() }, samples(16).with(rules).seed(3));
    for (i, pixel) in whole.iter().enumerate() {
        let sum: f32 = parts.iter().map(|p| p.weighted[i][0]).sum();
        assert!((sum / pixel[0] - 1.0).abs() < 1e-4, "pixel {i}: {sum} instead of {}", pixel[0]);
    }
}

/// The weights of random paths equal those from the definition, and so sum to one over the strategies that may find the same path.
#[test]
fn weights_are_those_of_the_definition() {
    for (name, scene) in all_scenes() {
        for solver in BOTH {
            let (mut paths, mut count, mut worst, mut far, mut never) = (Paths::default(), 0, 0.0f64, 0, 0);
            with_run(PathRules { max_edges: 6, ..PathRules::default() }, 1, |run| {
                let all = solver.strategies(&scene, run);
                for i in 0..1000u64 {
                    let u = Sampler::new(SequenceKind::Sobol, 5, 0, i as u32, 1000);
                    let film = &scene.views[0].film;
                    let size = Vec2::new(film.crop_size[0] as f32, film.crop_size[1] as f32);
                    let corner = Vec2::new(film.crop_offset[0] as f32, film.crop_offset[1] as f32);
                    let ray = scene.views[0].sensor.sample_ray(corner + u.u2(Dim(0)) * size, u.u2(Dim(1)), 0.0).ray;
                    all.sample(PathState::start(ray, Spectrum::ONE, Wavelengths::Rgb), &u, &mut paths, &mut |f, light, eye| {
                        // Light that grazes a lamp's own plane is next to nothing, and on which side it arrives is up to rounding.
                        if f.value.max_lane() < 1e-6 {
                            return;
                        }
                        let whole = Whole::of(&all, f, light, eye).expect("a whole path");
                        let want = whole.weights(&all)[f.s as usize];
                        let error = (f64::from(f.weight) - want).abs() / want.max(1e-6);
                        count += 1;
                        // On which side of a lamp's own plane grazing light arrives is up to rounding: then one of them says never.
                        if want > 0.0 {
                            worst = worst.max(error);
                        } else if f.weight > 0.0 {
                            never += 1;
                        }
                        far += u32::from(error > 1e-4);
                    });
                }
            });
            assert!(count > 1000, "{name}: {count} paths");
            // A direction between two stored points is not quite the one that was sampled, which shows where they are close or lobes are narrow.
            assert!(
                f64::from(far) <= 1e-2 * f64::from(count) && worst < 0.01 && never <= 2,
                "{name}: {far} of {count} are off, {worst} at worst, {never} by all"
            );
        }
    }
}

/// A path that a strategy found, to the bit.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
struct Bits(u32, u32, [f32; 3], f32, Option<[f32; 2]>);

/// One strategy at a time finds the same paths as all of them together, from the same numbers, to the bit: through masks, by all cameras and lights.
#[test]
fn one_by_one_is_all_at_once() {
    for (name, scene) in all_scenes() {
        for null_counts in [true, false] {
            let (mut paths, mut count) = (Paths::default(), 0);
            let rules = PathRules { max_edges: 5, rr_depth: Some(u32::MAX), null_counts, ..PathRules::default() };
            with_run(rules, 1, |run| {
                let all = Bidirectional::default().strategies(&scene, run);
                let film = &scene.views[0].film;
                let [corner, size] = [film.crop_offset, film.crop_size].map(|[x, y]| Vec2::new(x as f32, y as f32));
                for i in 0..200 {
                    let u = Sampler::new(SequenceKind::Sobol, 6, 0, i, 200);
                    let ray = scene.views[0].sensor.sample_ray(corner + u.u2(Dim(0)) * size, u.u2(Dim(1)), 0.0).ray;
                    let eye = || PathState::start(ray, Spectrum::ONE, Wavelengths::Rgb);
                    let (mut together, mut alone) = (Vec::new(), Vec::new());
                    let bits = |f: &Found<'_>| Bits(f.s, f.t, f.value.to_rgb(), f.weight, f.pixel.map(|p| p.to_array()));
                    all.sample(eye(), &u, &mut paths, &mut |f, _, _| together.push(bits(f)));
                    for (s, t) in (1..=5).flat_map(|n| (0..=n).map(move |s| (s, n + 1 - s))) {
                        all.one((s, t), eye, &u, &mut paths, &mut |f| alone.push(bits(f)));
                    }
                    for found in [&mut together, &mut alone] {
                        found.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
                    }
                    assert_eq!(together, alone, "{name}, sample {i}");
                    count += alone.len();
                }
            });
            assert!(count > 200, "{name}: {count} paths");
        }
    }
}

#[test]
fn agrees_with_path_mis_everywhere() {
    let mut family = Family::default();
    for (name, scene) in all_scenes() {
        let rules = PathRules { max_edges: 5, ..PathRules::default() };
        agrees(&mut family, name, &scene, rules, [64, 128], 0.8);
    }
    for null_counts in [false, true] {
        let rules = PathRules { max_edges: 4, null_counts, ..PathRules::default() }.with_bounces(1..=2);
        let scene = room(&eye(), WALLS, &(lamp() + MASK));
        agrees(&mut family, &format!("mask, null counts: {null_counts}"), &scene, rules, [64, 128], 0.8);
    }
    let rules = PathRules { hide_emitters: true, max_edges: 3, ..PathRules::default() };
    agrees(&mut family, "hidden", &room(&eye(), WALLS, &lamp()), rules, [64, 128], 0.8);
    family.must_hold();
}

/// The same bits at any number of threads.
#[test]
fn the_same_bits_on_any_threads() {
    let scene = room(&crop(), WALLS, &(lamp() + GLASS));
    let pictures: Vec<Picture> =
        [1, 2, 5].iter().map(|t| picture(&scene, &Bidirectional::default(), Job { threads: *t, ..samples(3) })).collect();
    assert!(pictures[0] == pictures[1] && pictures[1] == pictures[2]);
}

/// Stopped in the middle of a pass: splats are resumed as well.
#[test]
fn stopped_and_resumed_is_undisturbed() {
    let camera = camera_with("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [24, 20], r#"<rfilter type="gaussian"/>"#);
    let scene = room(&camera, WALLS, &(lamp() + GLASS));
    leaves_no_trace(&scene, &Bidirectional::default(), Stop::Samples(3), &[(1, 2)]);
}

/// Vertices very close together: a furnace so flat that nearly every connection is short. Nothing is infinite, nothing is missing.
#[test]
fn very_close_vertices() {
    let scene = flat_furnace();
    let mut family = Family::default();
    for solver in BOTH {
        furnace(&mut family, "flat", &solver, (&scene, 0.5), Some(4), 1024, 0.1);
    }
    family.must_hold();
}

/// The edge of a spot's cone: light sampled from either end ends at the same place.
#[test]
fn the_edge_of_a_cone() {
    let scene = cone();
    let mut family = Family::default();
    agrees(&mut family, "cone", &scene, PathRules { max_edges: 2, ..PathRules::default() }, [64, 64], 0.3);
    family.must_hold();
}
