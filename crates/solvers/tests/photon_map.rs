//! Photon mapping: biased at every number of passes, and held to what it promises all the same. Its sums are those of the definition; irradiance that
//! is constant is found exactly, however large the radius; photons behind walls and corners do not count; the error falls at the rate of its α; and
//! what is left of the bias is small beside bidirectional path tracing of the same scenes.

mod common;

use common::checks::{agreement, furnace, furnace_scene, neumann};
use common::interrupted::leaves_no_trace;
use common::*;
use etendue_check::{Moments, compare_means, student_quantile};
use etendue_scene::Scene;
use etendue_solvers::agreement::Trial;
use etendue_solvers::bidirectional::Bidirectional;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::photon_map::PhotonMap;
use etendue_solvers::photon_map::literal::Literal;
use etendue_solvers::{CancelToken, PathRules, Stop};
use std::sync::Mutex;

/// Direct light by photons, or by shadow rays.
const BY: [usize; 2] = [0, 1];
const ALL: usize = 0;
const CAUSTIC: usize = 1;
const GLOBAL: usize = 2;

fn photons(count: u32, direct: usize) -> PhotonMap {
    PhotonMap { photons: count, direct, ..PhotonMap::default() }
}

/// The ladder: constant irradiance, so that the estimate has no bias at any radius, corners included.
#[test]
fn furnace_ladder() {
    let mut family = Family::default();
    for (a, direct, depths) in [(0.5, 0, 0..=5), (0.9, 1, 0..=3), (0.2, 1, 2..=2)] {
        let scene = furnace_scene([a; 3]);
        for n in depths.map(Some).chain([None]) {
            furnace(&mut family, "photon-map", &photons(256, direct), (&scene, a), n, 24, 0.1);
        }
    }
    // Light of exactly so many bounces.
    let scene = furnace_scene([0.5; 3]);
    for (from, to) in [(1u32, 1u32), (2, 3)] {
        let job = samples(96).with(PathRules::default().with_bounces(from..=to));
        let pictures = replicates(&scene, &photons(256, 1), job);
        let want = neumann(0.5, Some(to)) - neumann(0.5, Some(from - 1));
        family.expect(format!("photon-map, bounces {from} to {to}"), &mean_of(&pictures, 0), want, 0.1);
    }
    family.must_hold();
}

fn rectangle(transform: &str, inside: &str) -> String {
    format!(r#"<shape type="rectangle"><transform name="to_world">{transform}</transform>{inside}</shape>"#)
}

/// A floor at y = 0.
fn ground(inside: &str) -> String {
    rectangle(r#"<rotate x="1" angle="-90"/><scale value="3"/>"#, inside)
}

const SUN: &str =
    r#"<emitter type="directional"><vector name="direction" value="0, -1, 0"/><rgb name="irradiance" value="2"/></emitter>"#;

/// Light that falls straight down: a floor is as bright at the foot of a wall and beside a step as elsewhere, and walls are black.
#[test]
fn corners_and_edges_neither_leak_nor_darken() {
    let white = diffuse(0.5);
    let block = r#"<transform name="to_world"><scale x="0.3" y="0.2" z="0.3"/><translate x="-0.4" y="0.2"/></transform>"#;
    let things = format!(
        "{SUN}{}{}<shape type=\"cube\">{block}{white}</shape>",
        ground(&white),
        rectangle(r#"<rotate y="1" angle="-90"/><translate x="0.3"/>"#, &white)
    );
    let solver = PhotonMap { radius: 0.25, alpha: 0.9, ..photons(4000, 0) };
    let expected = f64::from(0.5 * 2.0 / std::f32::consts::PI);
    let mut family = Family::default();
    // At the foot of the wall, at the foot of the block, at its upper edge.
    for (name, x, y) in [("wall", 0.25, 0.0), ("foot", -0.07, 0.0), ("edge", -0.13, 0.4), ("corner", -0.13, 0.4)] {
        let z = if name == "corner" { 0.27 } else { 0.0 };
        let eye = camera(&format!("{x}, {}, {z}", y + 0.5), &format!("{x}, {y}, {z}"), "0, 0, 1", 5.0, [2, 2]);
        let pictures = replicates(&scene(&format!("{eye}{things}")), &solver, samples(24).edges(2));
        family.expect(name, &mean_of(&pictures, 0), expected, 0.12);
    }
    family.must_hold();
    for (name, eye, target) in [("the wall", "0, 0.15, 0", "0.3, 0.05, 0"), ("the block's side", "0.2, 0.1, 0", "-0.1, 0.1, 0")] {
        let scene = scene(&format!("{}{things}", camera(eye, target, "0, 1, 0", 5.0, [2, 2])));
        assert!(picture(&scene, &solver, samples(8).edges(2)).iter().all(|p| *p == [0.0; 3]), "{name} is black");
    }
}

/// A sheet without thickness between a bright room and a dark one, as little of it within the radius as may be: its floor stays dark.
#[test]
fn nothing_leaks_through_walls() {
    let grey = r#"<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.7"/></bsdf></bsdf>"#;
    let things = format!(
        r#"<shape type="cube"><boolean name="flip_normals" value="true"/>{grey}</shape>{}
        <shape type="sphere"><point name="center" value="0.5, 0, 0"/><float name="radius" value="0.2"/>{}{}</shape>"#,
        rectangle(r#"<rotate y="1" angle="90"/>"#, grey),
        diffuse(0.0),
        area("5")
    );
    let mean = |eye: &str| {
        let solver = PhotonMap { radius: 0.3, ..photons(2000, 0) };
        let scene = scene(&format!("{}{things}", camera(eye, "0, -1, 0", "0, 0, 1", 40.0, [8, 8])));
        mean_of(&[picture(&scene, &solver, samples(2))], 0).mean
    };
    let (bright, dark) = (mean("0.3, 0, 0"), mean("-0.3, 0, 0"));
    assert!(bright > 0.2 && dark.abs() < 1e-6 * bright, "bright {bright}, dark {dark}");
}

/// A room with a lamp, a block, and a ball.
fn room(camera: &str, ball: &str) -> Scene {
    scene(&format!(
        r#"{camera}
        <shape type="cube"><boolean name="flip_normals" value="true"/>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.5, 0.3"/></bsdf></shape>
        <shape type="cube"><transform name="to_world"><scale value="0.25"/><rotate y="1" angle="20"/><translate x="-0.4" y="-0.75" z="0.3"/></transform>{}</shape>
        <shape type="sphere"><point name="center" value="0.45, -0.6, 0.2"/><float name="radius" value="0.35"/>{ball}</shape>
        {}"#,
        diffuse(0.6),
        rectangle(
            r#"<rotate x="1" angle="90"/><scale x="0.4" z="0.4"/><translate y="0.95"/>"#,
            &format!("{}{}", diffuse(0.2), area("9, 11, 13"))
        )
    ))
}

fn eye(size: [u32; 2]) -> String {
    camera("0, 0, -0.95", "0, -0.1, 1", "0, 1, 0", 75.0, size)
}

/// The sums over photons are those of the definition: for one photon map to rounding where nothing is in the way, in the mean where something is.
#[test]
fn the_definition_agrees() {
    let floor = scene(&format!("{SUN}{}{}", camera("0, 2, 0", "0, 0, 0", "0, 0, 1", 40.0, [12, 12]), ground(&diffuse(0.5))));
    let solver = PhotonMap { radius: 0.3, ..photons(500, 0) };
    let (ours, theirs) = (picture(&floor, &solver, samples(2)), picture(&floor, &Literal::new(solver), samples(2)));
    assert!(ours.iter().flatten().filter(|x| **x > 0.0).count() > 300);
    for (a, b) in ours.iter().flatten().zip(theirs.iter().flatten()) {
        assert!((a - b).abs() <= 1e-5 * b.abs(), "{a} instead of {b}");
    }

    let mut family = Family::default();
    let room = room(&eye([8, 8]), r#"<bsdf type="roughplastic"><float name="alpha" value="0.2"/></bsdf>"#);
    let solver = PhotonMap { radius: 0.3, alpha: 0.9, ..photons(300, 0) };
    let job = samples(16).edges(4);
    let (ours, theirs) = (replicates(&room, &solver, job), replicates(&room, &Literal::new(solver), job.seed(2)));
    agreement(&mut family, "density", &room, &ours, &theirs, 0.4);
    family.must_hold();
}

/// The bias and its interval, relative, of the picture's mean and of the worst block: (picture, blocks).
fn biases(scene: &Scene, solver: &PhotonMap, job: Job, reference: &[Picture]) -> (f64, f64) {
    let pictures = replicates(scene, solver, job);
    let t = student_quantile(0.01, K as f64 - 1.0);
    let most = |a: &_, b: &Moments, least: f64| {
        let test = compare_means(a, b);
        (test.difference.abs() + t * test.standard_error) / b.mean.max(least)
    };
    let (mut whole, mut worst) = (0f64, 0f64);
    let mean = (0..3).map(|c| mean_of(reference, c).mean).sum::<f64>() / 3.0;
    for channel in 0..3 {
        whole = whole.max(most(&mean_of(&pictures, channel), &mean_of(reference, channel), 0.1 * mean));
    }
    let width = scene.views[0].film.crop_size[0] as usize;
    for ((_, a), (_, b)) in blocks_of(&pictures, width).iter().zip(&blocks_of(reference, width)) {
        worst = worst.max(most(a, b, 0.5 * mean));
    }
    (whole, worst)
}

/// Claims that with its noise the bias is at most so large: of the picture, and of every block.
fn is_near(name: &str, scene: &Scene, solver: &PhotonMap, rules: PathRules, (spp, reference): (u32, u32), most: (f64, f64)) {
    let reference = replicates(scene, &Bidirectional::default(), samples(reference).with(rules));
    let (whole, worst) = biases(scene, solver, samples(spp).with(rules).seed(7), &reference);
    assert!(whole <= most.0 && worst <= most.1, "{name}: picture {whole:.4}, blocks {worst:.4}; allowed {most:?}");
}

/// What the photon map shows is what other solvers show: glossy, smooth and rough surfaces on both sides, masks, hidden emitters.
#[test]
fn surfaces_of_all_kinds() {
    for (i, (name, ball)) in [
        ("diffuse", diffuse(0.5)),
        ("glass", r#"<bsdf type="dielectric"/>"#.to_owned()),
        ("rough glass", r#"<bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf>"#.to_owned()),
        ("gloss", r#"<bsdf type="roughconductor"><float name="alpha" value="0.1"/></bsdf>"#.to_owned()),
        ("plastic", r#"<bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.2, 0.5, 0.6"/></bsdf>"#.to_owned()),
        (
            "mask",
            format!(r#"<bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="twosided">{}</bsdf></bsdf>"#, diffuse(0.5)),
        ),
    ]
    .iter()
    .enumerate()
    {
        let (direct, odd) = (BY[i % 2], i % 2 == 1);
        let rules = PathRules { hide_emitters: odd, null_counts: odd, max_edges: 6, ..PathRules::default() };
        let solver = PhotonMap { radius: 0.2, ..photons(1000, direct) };
        is_near(name, &room(&eye([8, 8]), ball), &solver, rules, (32, 64), (0.06, 0.2));
    }
}

/// Light of all kinds, through all cameras.
#[test]
fn lights_of_all_kinds() {
    let sky: Vec<[f32; 3]> = (0..128).map(|i| if matches!(i, 20 | 21) { [9.0, 8.0, 7.0] } else { [0.3, 0.4, 0.5] }).collect();
    let sky = picture_file("photons-sky", 16, &sky);
    let down = r#"<transform name="to_world"><lookat origin="0.3, 1.5, 0" target="0, 0, 0.1" up="0, 0, 1"/></transform>"#;
    let lens = r#"<sensor type="thinlens"><float name="fov" value="60"/><float name="aperture_radius" value="0.2"/><float name="focus_distance" value="3"/>
        <transform name="to_world"><lookat origin="0, 1.5, -2.5" target="0, 0.4, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/><rfilter type="box"/></film></sensor>"#;
    let parallel = r#"<sensor type="orthographic">
        <transform name="to_world"><scale x="1.2" y="1.2"/><lookat origin="0, 3, -2.5" target="0, 0.4, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/><rfilter type="box"/></film></sensor>"#;
    let pinhole = camera("0, 1.5, -2.5", "0, 0.4, 0", "0, 1, 0", 60.0, [8, 8]);
    let gloss = r#"<bsdf type="roughconductor"><float name="alpha" value="0.3"/></bsdf>"#;
    for (i, (name, light)) in [
        ("point", r#"<emitter type="point"><point name="position" value="0.3, 1, 0"/></emitter>"#.to_owned()),
        ("spot", format!(r#"<emitter type="spot">{down}<float name="cutoff_angle" value="40"/></emitter>"#)),
        ("directional", r#"<emitter type="directional"><vector name="direction" value="0.3, -1, 0.2"/></emitter>"#.to_owned()),
        ("constant", r#"<emitter type="constant"><rgb name="radiance" value="0.5, 1, 2"/></emitter>"#.to_owned()),
        ("envmap", format!(r#"<emitter type="envmap"><string name="filename" value="{sky}"/></emitter>"#)),
        (
            "unsampled lamp",
            r#"<shape type="cube"><transform name="to_world"><scale value="0.3"/><translate y="1.2" x="0.5"/></transform>
                <emitter type="area"><rgb name="radiance" value="4, 5, 6"/><float name="sampling_weight" value="0"/></emitter></shape>"#
                .to_owned(),
        ),
    ]
    .iter()
    .enumerate()
    {
        let camera = [pinhole.as_str(), lens, parallel][i % 3];
        let ball = format!(r#"<shape type="sphere"><point name="center" value="-0.4, 0.4, 0"/><float name="radius" value="0.3"/>{gloss}</shape>"#);
        let scene = scene(&format!("{camera}{light}{ball}{}", ground(&diffuse(0.6))));
        let rules = PathRules { max_edges: 5, ..PathRules::default() };
        // Those of odd places shine by shadow rays but for what these cannot find.
        let solver = PhotonMap { radius: 0.15, ..photons(3000, BY[i % 2]) };
        is_near(name, &scene, &solver, rules, (48, 64), (0.035, 0.2));
    }
}

/// Caustics and the rest, apart, are the whole; light that mirrors and glass bring is a caustic.
#[test]
fn caustics_apart() {
    let solver = |show: usize| PhotonMap { show, ..photons(2000, 1) };
    let scene = room(&eye([16, 16]), r#"<bsdf type="dielectric"/>"#);
    let [all, caustic, global] = [ALL, CAUSTIC, GLOBAL].map(|show| replicates(&scene, &solver(show), samples(8)));
    let sum: Vec<Picture> = caustic
        .iter()
        .zip(&global)
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| std::array::from_fn(|c| a[c] + b[c])).collect())
        .collect();
    for channel in 0..3 {
        let [all, sum, caustic] = [&all, &sum, &caustic].map(|p| mean_of(p, channel));
        // The same photons; but which of them is tested for sight differs.
        assert!((sum.mean / all.mean - 1.0).abs() < 1e-3, "{} and {}", sum.mean, all.mean);
        assert!(caustic.mean > 0.001 * all.mean && caustic.mean < 0.2 * all.mean, "{} of {}", caustic.mean, all.mean);
    }
    let without = room(&eye([16, 16]), &diffuse(0.5));
    assert!(picture(&without, &solver(CAUSTIC), samples(2)).iter().all(|p| *p == [0.0; 3]), "nothing focuses light here");
}

/// Mean relMSE over replicates and the bias of their mean, both relative, after 2^4 … 2^8 passes.
fn errors(alpha: f32) -> Vec<(f64, f64, f64)> {
    // A lamp close to the floor: irradiance is curved, and known: L = ρ/π I cosθ/d².
    let lamp = r#"<emitter type="point"><point name="position" value="0, 0.5, 0"/><rgb name="intensity" value="1"/></emitter>"#;
    let floor = scene(&format!("{lamp}{}{}", camera("0, 2, 0", "0, 0, 0", "0, 0, 1", 40.0, [16, 16]), ground(&diffuse(0.5))));
    let reference = picture(&floor, &PathMis::default(), samples(256).edges(2));
    let solver = PhotonMap { radius: 0.4, alpha, ..photons(1000, 0) };
    let e = 0.01 * mean_of(std::slice::from_ref(&reference), 0).mean.powi(2);
    let (pool, cancel) = (threads(2), CancelToken::default());
    let trial = Trial { rules: PathRules { max_edges: 2, ..PathRules::default() }, ..Trial::new(&floor, &pool, &cancel) };
    let render = trial.renderer(&solver);
    // Every replicate is looked at on its way.
    let along = |r: u32| {
        let seen = Mutex::new(Vec::new());
        let watch = |passes: u32, film: &etendue_film::Film| {
            if passes >= 16 && passes.is_power_of_two() {
                seen.lock().expect("unpoisoned").push(film.develop());
            }
        };
        trial.shoot(&*render, Stop::Samples(256), trial.seed_of(0, r), &watch).expect("renders");
        seen.into_inner().expect("unpoisoned")
    };
    let replicates: Vec<Vec<Picture>> = (0..K as u32).map(along).collect();
    let at = |m: usize| {
        let (mut error, mut bias) = (0.0, 0.0);
        for (i, r) in reference.iter().enumerate() {
            let r = f64::from(r[0]);
            let values: Moments = replicates.iter().map(|p| f64::from(p[m][i][0])).collect();
            let off = (values.mean - r).powi(2);
            error += (off + values.variance()) / (r * r + e);
            bias += (off - values.standard_error().powi(2)) / (r * r + e);
        }
        let n = reference.len() as f64;
        (f64::from(16 << m), error / n, bias / n)
    };
    (0..5).map(at).collect()
}

/// Least squares over logarithms.
fn slope(points: impl Iterator<Item = (f64, f64)>) -> f64 {
    let points: Vec<(f64, f64)> = points.map(|(x, y)| (x.ln(), y.ln())).collect();
    let n = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>() / points.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>()
}

/// The bias falls at every doubling, its square like N^{2(α-1)}; the whole error like the slower of that and the variance's N^{-α}.
#[test]
fn errors_fall_at_the_rate_of_alpha() {
    for (alpha, total, bias) in [(2.0 / 3.0, -2.0 / 3.0, -2.0 / 3.0), (0.8, -0.4, -0.4)] {
        let errors = errors(alpha);
        let told = format!("alpha {alpha}: {errors:.5?}");
        assert!(errors.windows(2).all(|w| w[1].2 < w[0].2 && w[1].2 > 0.0), "{told}");
        let of_bias = slope(errors.iter().map(|e| (e.0, e.2)));
        let of_error = slope(errors.iter().map(|e| (e.0, e.1)));
        assert!((of_bias - bias).abs() < 0.15 && (of_error - total).abs() < 0.15, "{told}: {of_bias:.3}, {of_error:.3}");
    }
}

/// In a closed box what is emitted is absorbed.
#[test]
fn the_books_are_balanced() {
    let scene = furnace_scene([0.5; 3]);
    for max_edges in [u32::MAX, 4] {
        let job = samples(8).edges(max_edges);
        let books = render(&scene, &photons(4096, 1), job).1.books.expect("books");
        // Six faces of 4 m², π W/m² each; the walk is cut after three edges.
        let flux = 24.0 * std::f64::consts::PI;
        let cut = if max_edges == 4 { 0.125 * flux } else { 0.0 };
        assert!((books.emitted[0] / flux - 1.0).abs() < 1e-4);
        assert!((books.absorbed[1] - (flux - cut)).abs() < 0.02 * flux && (books.cut[1] - cut).abs() < 0.02 * flux);
        assert!(books.escaped == [0.0; 3] && books.residual.iter().all(|r| r.abs() < 1e-4));
    }
}

/// A film of several tiles, more photons than one chunk, a wide filter, a crop.
fn wide() -> Scene {
    let film = r#"<integer name="crop_offset_x" value="3"/><integer name="crop_offset_y" value="5"/>
        <integer name="crop_width" value="61"/><integer name="crop_height" value="50"/><rfilter type="gaussian"/>"#;
    room(&camera_with("0, 0, -0.95", "0, -0.1, 1", "0, 1, 0", 75.0, [80, 60], film), r#"<bsdf type="plastic"/>"#)
}

#[test]
fn threads_do_not_matter() {
    let scene = wide();
    for stop in [Stop::Samples(2), Stop::Noise { percent: 1e-9, limit: 16 }] {
        let at = |threads: usize| {
            let (film, outcome) = render(&scene, &PhotonMap::default(), Job { stop, threads, ..samples(0) });
            (bits(&film.develop()), outcome.books, outcome.noise.map(|n| n.rel_mse.to_bits()))
        };
        let once = at(1);
        for threads in [2, 5] {
            assert!(at(threads) == once, "{threads} threads, {stop:?}");
        }
    }
}

/// Stopped among the photons (no tile is done) and among the pixels.
#[test]
fn stopped_and_resumed_is_undisturbed() {
    leaves_no_trace(&wide(), &PhotonMap::default(), Stop::Samples(4), &[(0, 3), (1, 0), (2, 5)]);
}
