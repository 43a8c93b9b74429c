//! Bidirectional path tracing against closed forms, against path tracing, and each strategy against the others.
//!
//! Each test is one family of claims with 1 % of false alarms, over independent replicates.

mod common;

use common::checks::{agreement, furnace, furnace_scene, round_furnace_scene};
use common::*;
use etendue_numerics::{Dim, Sampler, SequenceKind, Spectrum, Vec2, Wavelengths};
use etendue_scene::Scene;
use etendue_solvers::bidirectional::literal::Whole;
use etendue_solvers::bidirectional::strategies::{self, StrategyPicture};
use etendue_solvers::bidirectional::{Bidirectional, Paths};
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::solver::Needs;
use etendue_solvers::transport::PathState;
use etendue_solvers::{CancelToken, Checkpoint, Event, PathRules, Progress, Run, Solver, Stop, Stopped, Work};
use std::sync::Mutex;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

const BOTH: [Bidirectional; 2] = [Bidirectional { exponent: 1 }, Bidirectional { exponent: 2 }];
const SIZE: [u32; 2] = [8, 8];

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

fn eye() -> String {
    camera("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, SIZE)
}

/// A box with coloured walls, and what stands in it.
fn room(camera: &str, walls: &str, inside: &str) -> Scene {
    scene(&format!(r#"{camera}<shape type="cube"><boolean name="flip_normals" value="true"/>{walls}</shape>{inside}"#))
}

const WALLS: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.5, 0.3"/></bsdf>"#;

/// A lamp under the ceiling.
fn lamp() -> String {
    format!(
        r#"<shape type="rectangle">
            <transform name="to_world"><rotate x="1" angle="90"/><scale x="0.7" z="0.7"/><translate y="0.95"/></transform>
            {}<emitter type="area"><rgb name="radiance" value="3, 4, 5"/></emitter></shape>"#,
        diffuse(0.2)
    )
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
        rules,
        digest: 0,
        pool: &threads(2),
        cancel: &CancelToken::default(),
        progress: &Progress::default(),
        events: &|_| (),
        checkpoint_every: None,
    })
}

/// Every strategy with t ≥ 1 alone finds all light of its number of edges: the furnace of diffuse walls, and a room with a rough metal wall.
#[test]
fn each_strategy_alone_finds_all() {
    let mut family = Family::default();
    let metal = r#"<bsdf type="roughconductor"><float name="alpha" value="0.5"/></bsdf>"#;
    let wide = r#"<shape type="sphere"><point name="center" x="0.3" y="0.2" z="0.4"/><float name="radius" value="0.4"/>
        <bsdf type="diffuse"/><emitter type="area"><rgb name="radiance" value="3, 4, 5"/></emitter></shape>"#;
    let scenes = [("ball", round_furnace_scene([0.5; 3]), 1500), ("metal", room(&eye(), metal, wide), 1500)];
    for (name, scene, spp) in &scenes {
        let rules = PathRules { max_edges: 4, ..PathRules::default() };
        let all: Vec<_> = (0..K).map(|seed| strategy_pictures(scene, rules, spp / 16, 5, seed + 7)).collect();
        let mean = |i: usize| mean_of(&all.iter().map(|p| p[i].unweighted.clone()).collect::<Vec<_>>(), 1);
        for edges in 1..=4u32 {
            let of = |s: u32| all[0].iter().position(|p| p.s == s && p.s + p.t == edges + 1).expect("strategy");
            let reference = mean(of(u32::from(edges > 1)));
            for s in 0..=edges {
                family.agree(format!("{name}: ({s}, {})", edges + 1 - s), &mean(of(s)), &reference, 0.3, reference.mean);
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
    let whole = picture(&scene, &Bidirectional::default(), samples(16).with(rules).seed(3));
    for (i, pixel) in whole.iter().enumerate() {
        let sum: f32 = parts.iter().map(|p| p.weighted[i][0]).sum();
        assert!((sum / pixel[0] - 1.0).abs() < 1e-4, "pixel {i}: {sum} instead of {}", pixel[0]);
    }
}

const GLASS: &str = r#"<shape type="sphere"><point name="center" x="0.2" y="-0.4" z="0.2"/><float name="radius" value="0.45"/>
    <bsdf type="dielectric"/></shape>"#;
const ROUGH_GLASS: &str = r#"<shape type="sphere"><point name="center" x="0.2" y="-0.4" z="0.2"/><float name="radius" value="0.45"/>
    <bsdf type="roughdielectric"><float name="alpha" value="0.4"/></bsdf></shape>"#;
const POINT: &str =
    r#"<emitter type="point"><point name="position" x="0.3" y="0.5" z="0"/><rgb name="intensity" value="1, 2, 3"/></emitter>"#;
const SPOT: &str = r#"<emitter type="spot"><transform name="to_world"><lookat origin="0, 0.8, 0" target="0.2, -1, 0.3" up="1, 0, 0"/></transform>
    <rgb name="intensity" value="4, 3, 2"/><float name="cutoff_angle" value="35"/></emitter>"#;
const SUN: &str = r#"<emitter type="directional"><vector name="direction" x="0.3" y="-1" z="0.4"/><rgb name="irradiance" value="2, 2, 1"/></emitter>"#;
const SKY: &str = r#"<emitter type="constant"><rgb name="radiance" value="0.5, 0.7, 1"/></emitter>"#;
const MASK: &str = r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><scale x="0.8" z="0.8"/><translate y="0.3"/></transform>
    <bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="twosided"><bsdf type="diffuse"/></bsdf></bsdf></shape>"#;

/// A floor with a wall, open to the sky.
fn yard(camera: &str, inside: &str) -> Scene {
    scene(&format!(
        r#"{camera}<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="2"/><translate y="-1"/></transform>
            {WALLS}</shape>
        <shape type="rectangle"><transform name="to_world"><rotate y="1" angle="180"/><scale value="2"/><translate z="1.2"/></transform>{}</shape>
        {inside}"#,
        diffuse(0.5)
    ))
}

fn lens() -> String {
    camera("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, SIZE).replace(
        r#"type="perspective">"#,
        r#"type="thinlens"><float name="aperture_radius" value="0.1"/><float name="focus_distance" value="1"/>"#,
    )
}

fn crop() -> String {
    let film = r#"<rfilter type="box"/><integer name="crop_offset_x" value="3"/><integer name="crop_offset_y" value="8"/>
        <integer name="crop_width" value="8"/><integer name="crop_height" value="4"/>"#;
    camera_with("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [16, 16], film)
}

const ROUGH_METAL: &str = r#"<bsdf type="roughconductor"><float name="alpha" value="0.4"/></bsdf>"#;
const PROJECTOR: &str = r#"<emitter type="projector"><transform name="to_world"><lookat origin="0, 0.9, 0" target="0.1, -1, 0.4" up="1, 0, 0"/></transform>
    <float name="fov" value="50"/><float name="scale" value="2"/></emitter>"#;

fn parallel() -> String {
    r#"<sensor type="orthographic">
        <transform name="to_world"><scale x="0.9" y="0.9"/><lookat origin="0, 0, -0.95" target="0, -0.2, 1" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/><rfilter type="box"/></film></sensor>"#
        .to_owned()
}

/// Surroundings with a bright side.
fn sky_picture() -> String {
    let pixels: Vec<[f32; 3]> = (0..32).map(|i| [0.1 + 2.0 * f32::from(i % 8 == 3), 0.2 + f32::from(i % 5 == 1), 0.3]).collect();
    format!(
        r#"<emitter type="envmap"><string name="filename" value="{}"/></emitter>"#,
        picture_file("bidirectional-sky", 8, &pixels)
    )
}

/// A lamp of a mesh with vertex normals under a map that mirrors it.
fn mirrored_lamp() -> String {
    let quad = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvn 0.3 0 1\nvn -0.3 0 1\nf 1//1 2//2 3//2\nf 1//1 3//2 4//1\n";
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("bidirectional-quad.obj");
    std::fs::write(&path, quad).expect("the folder for temporary files");
    format!(
        r#"<shape type="obj"><string name="filename" value="{}"/>
            <transform name="to_world"><scale x="-0.7" y="0.7"/><rotate x="1" angle="90"/><translate y="0.9"/></transform>
            {}{}</shape>"#,
        path.display(),
        diffuse(0.5),
        area("3, 4, 5")
    )
}

/// Normals bent far off, by a picture.
fn bumps(bsdf: &str) -> String {
    let pixels: Vec<[f32; 3]> = (0..16)
        .map(|i| [0.5 + 0.3 * ((i * 7 % 5) as f32 / 4.0 - 0.5), 0.5 + 0.3 * ((i * 3 % 4) as f32 / 3.0 - 0.5), 0.9])
        .collect();
    let file = picture_file("bidirectional-bumps", 4, &pixels);
    format!(
        r#"<bsdf type="normalmap"><texture type="bitmap" name="normalmap"><boolean name="raw" value="true"/>
            <string name="filename" value="{file}"/></texture>
            {bsdf}</bsdf>"#
    )
}

fn all_scenes() -> Vec<(&'static str, Scene)> {
    vec![
        ("glass", room(&eye(), WALLS, &(lamp() + GLASS))),
        ("rough glass", room(&eye(), WALLS, &(lamp() + ROUGH_GLASS))),
        ("points", room(&eye(), WALLS, &format!("{POINT}{SPOT}{}", lamp()))),
        ("distant", yard(&eye(), &format!("{SUN}{SKY}{ROUGH_GLASS}"))),
        ("mask", room(&eye(), WALLS, &(lamp() + MASK))),
        ("lens", room(&lens(), WALLS, &lamp())),
        ("crop", room(&crop(), WALLS, &lamp())),
        ("bumps", room(&eye(), &bumps(ROUGH_METAL), &lamp())),
        ("plastic", room(&eye(), r#"<bsdf type="plastic"/>"#, &lamp())),
        ("parallel", yard(&parallel(), &format!("{SUN}{PROJECTOR}"))),
        ("picture sky", yard(&eye(), &format!("{}{SPOT}", sky_picture()))),
        ("mirrored lamp", room(&eye(), WALLS, &mirrored_lamp())),
    ]
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
                        } else {
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

/// bidirectional that asks for its own cancellation in the middle of a pass.
struct Interrupted<'a> {
    cancel: &'a CancelToken,
    units: u64,
}

impl Solver for Interrupted<'_> {
    type State = ();

    fn needs(&self) -> Needs {
        Needs::default()
    }

    fn units(&self, size: [u32; 2]) -> usize {
        Bidirectional::default().units(size)
    }

    fn prepare(&self, _: &Scene, _: &Run<'_>) {}

    fn pass(&self, scene: &Scene, run: &Run<'_>, (): &mut (), k: u32, work: &Work<'_>) {
        let stop_now = || {
            if k == 1 && work.progress.tiles.load(Relaxed) >= self.units {
                self.cancel.cancel();
            }
            (work.stop_now)()
        };
        let work = Work { film: work.film, replicates: None, units: work.units, stop_now: &stop_now, progress: work.progress };
        Bidirectional::default().pass(scene, run, &mut (), k, &work);
    }
}

/// Stopped in the middle of a pass and resumed: the same bits, splats included.
#[test]
fn stopped_and_resumed_is_undisturbed() {
    let camera = camera_with("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [24, 20], r#"<rfilter type="gaussian"/>"#);
    let scene = room(&camera, WALLS, &(lamp() + GLASS));
    let go = |units: u64, resume: Option<&Checkpoint>| {
        let (cancel, last) = (CancelToken::default(), Mutex::new(None));
        let film = blank(&scene);
        let events = |event: Event<'_>| {
            if let Event::Checkpoint(checkpoint) = event {
                *last.lock().expect("unpoisoned") = Some(checkpoint.clone());
            }
        };
        let ended = with_run(PathRules::default(), 4, |run| {
            let run =
                Run { cancel: &cancel, stop: Stop::Samples(3), events: &events, checkpoint_every: Some(Duration::MAX), ..*run };
            etendue_solvers::render(&Interrupted { cancel: &cancel, units }, "test", &scene, &run, &film, resume).expect("resumes")
        });
        (film.develop(), ended.stopped, last.into_inner().expect("unpoisoned"))
    };
    let (whole, ended, _) = go(u64::MAX, None);
    assert_eq!(ended, Stopped::Samples);
    let (part, ended, checkpoint) = go(4, None);
    assert_eq!(ended, Stopped::Cancelled);
    assert!(part != whole);
    let (resumed, ended, _) = go(u64::MAX, checkpoint.as_ref());
    assert_eq!(ended, Stopped::Samples);
    assert!(resumed == whole);
}

/// Vertices very close together: a furnace so flat that nearly every connection is short. Nothing is infinite, nothing is missing.
#[test]
fn very_close_vertices() {
    let camera = camera("0, 0, 0", "1, 0.3, 0", "0, 0, 1", 60.0, [4, 4])
        .replace(r#"<float name="fov""#, r#"<float name="near_clip" value="0.0001"/><float name="fov""#);
    let scene = scene(&format!(
        r#"{camera}<shape type="cube"><boolean name="flip_normals" value="true"/>
            <transform name="to_world"><scale z="0.01"/></transform>{}{}</shape>"#,
        diffuse(0.5),
        area("1")
    ));
    let mut family = Family::default();
    for solver in BOTH {
        furnace(&mut family, "flat", &solver, (&scene, 0.5), Some(4), 1024, 0.1);
    }
    family.must_hold();
}

/// The edge of a spot's cone: light sampled from either end ends at the same place.
#[test]
fn the_edge_of_a_cone() {
    let floor = r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="2"/></transform><bsdf type="diffuse"/></shape>"#;
    let spot = r#"<emitter type="spot"><transform name="to_world"><lookat origin="0, 1, 0" target="0, 0, 0" up="1, 0, 0"/></transform>
        <rgb name="intensity" value="3"/><float name="cutoff_angle" value="30"/><float name="beam_width" value="29.9"/></emitter>"#;
    // The circle of radius tan 30° crosses the picture.
    let scene = scene(&format!("{}{floor}{spot}", camera("0.577, 0.5, 0", "0.577, 0, 0", "0, 0, 1", 20.0, SIZE)));
    let mut family = Family::default();
    agrees(&mut family, "cone", &scene, PathRules { max_edges: 2, ..PathRules::default() }, [64, 64], 0.3);
    family.must_hold();
}
