//! `whitted` and `distribution`: trees of rays against closed forms, against the walks they are to agree with, and against themselves.
//!
//! Where a scene has no softness a tree has no noise, and the claims are exact; all others are families with 1 % of false alarms.

mod common;

use common::checks::*;
use common::*;
use etendue_accel::Hit;
use etendue_numerics::{Sampler, Spectrum};
use etendue_scene::Scene;
use etendue_solvers::direct::Direct;
use etendue_solvers::distribution::Distribution;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::transport::{Context, PathSolver, PathState, Step};
use etendue_solvers::whitted::Whitted;
use etendue_solvers::{PathRules, Solver};

const WHITTED: Whitted = Whitted { ambient: Spectrum::ZERO };
const ORIGINAL: Distribution = Distribution { shadow_samples: 4, gloss_samples: 4, diffuse_samples: 0 };
const COMPLETE: Distribution = Distribution { shadow_samples: 3, gloss_samples: 2, diffuse_samples: 3 };

fn ambient(r: f32, g: f32, b: f32) -> Whitted {
    Whitted { ambient: Spectrum::rgb(r, g, b) }
}

/// Every pixel of one sample is `want`.
fn exact(what: &str, scene: &Scene, solver: &impl Solver, job: Job, want: [f64; 3]) {
    for pixel in picture(scene, solver, job) {
        for (x, want) in pixel.iter().zip(want) {
            assert!((f64::from(*x) - want).abs() <= 4e-6 * want.abs().max(1e-3), "{what}: {pixel:?}, not {want}");
        }
    }
}

fn bounces(from: u32, to: u32) -> Job {
    samples(1).with(PathRules::default().with_bounces(from..=to))
}

/// A conductor that reflects `r` whatever the angle.
fn mirror(r: &str) -> String {
    format!(
        r#"<bsdf type="conductor"><spectrum name="eta" value="0"/><spectrum name="k" value="1"/>
            <rgb name="specular_reflectance" value="{r}"/></bsdf>"#
    )
}

fn constant(radiance: &str) -> String {
    format!(r#"<emitter type="constant"><rgb name="radiance" value="{radiance}"/></emitter>"#)
}

fn lamp(p: &str, intensity: &str) -> String {
    format!(r#"<emitter type="point"><point name="position" value="{p}"/><rgb name="intensity" value="{intensity}"/></emitter>"#)
}

/// One bounce and no more: 1 + a.
#[test]
fn furnaces_that_know_no_diffuse_light() {
    let mut family = Family::default();
    for a in [0.2f32, 0.5, 0.9] {
        for (shape, scene) in [("box", furnace_scene([a; 3])), ("ball", round_furnace_scene([a; 3]))] {
            for n in [Some(0), Some(1), Some(2), Some(5), None] {
                let want = 1.0 + if n == Some(0) { 0.0 } else { f64::from(a) };
                let job = samples(64).edges(n.map_or(u32::MAX, |n| n + 1));
                let mut claim = |name: &str, pictures: &[Picture]| {
                    family.expect(format!("{name}, {shape}, albedo {a}, bounces {n:?}"), &mean_of(pictures, 0), want, 0.03);
                };
                claim("whitted", &replicates(&scene, &WHITTED, job));
                claim("distribution", &replicates(&scene, &ORIGINAL, job));
            }
        }
    }
    family.must_hold();
}

/// With directions at diffuse hits the whole sum, at every depth.
#[test]
fn furnaces_with_diffuse_samples() {
    let mut family = Family::default();
    for a in [0.2f32, 0.5, 0.9] {
        let scene = furnace_scene([a; 3]);
        for n in (0..=6).map(Some).chain([None]) {
            furnace(&mut family, "distribution", &COMPLETE, (&scene, a), n, if n.is_none() { 32 } else { 8 }, 0.06);
        }
    }
    family.must_hold();
}

/// A box of mirrors that all shine: Σ rᵏ, without noise.
#[test]
fn a_box_of_mirrors() {
    let scene = scene(&format!(
        r#"{}<shape type="cube"><boolean name="flip_normals" value="true"/>{}{}</shape>"#,
        camera("0, 0, -0.5", "0.1, 0.2, 1", "0, 1, 0", 70.0, [4, 4]),
        mirror("0.9, 0.5, 0.25"),
        area("1")
    ));
    let r = [0.9f32, 0.5, 0.25].map(f64::from);
    for n in 0..=7 {
        let want = r.map(|r| neumann(r, Some(n)));
        let job = samples(1).with(PathRules { max_edges: n + 1, rr_depth: Some(u32::MAX), ..PathRules::default() });
        exact("whitted", &scene, &WHITTED, job, want);
        exact("distribution", &scene, &ORIGINAL, job, want);
    }
    exact("the third bounce alone", &scene, &WHITTED, bounces(3, 3), r.map(|r| r.powi(3)));
    // Endless, with roulette.
    let mut family = Family::default();
    let pictures = replicates(&scene, &WHITTED, samples(64));
    (0..3).for_each(|i| family.expect(format!("endless, {i}"), &mean_of(&pictures, i), neumann(r[i], None), 0.1));
    family.must_hold();
}

/// Both branches of glass at once, with radiance compressed by η² on its way in: F + (1 - F)/η² in a world of radiance 1. A single sample
/// is exact, which no roulette between the two could be.
#[test]
fn both_branches_of_glass() {
    let scene = scene(&format!(
        r#"{}<shape type="rectangle"><transform name="to_world"><scale value="1000"/></transform>
            <bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf></shape>{}"#,
        at_point("0, 3, 4", "0, 0, 0"),
        constant("1")
    ));
    let f = fresnel(0.8, 1.5);
    let want = f + (1.0 - f) / 2.25;
    exact("whitted", &scene, &WHITTED, samples(1), [want; 3]);
    exact("distribution", &scene, &ORIGINAL, samples(1), [want; 3]);
}

/// A ball of clear glass in a world of radiance 1 cannot be seen, nor can panes and half-open masks.
#[test]
fn glass_loses_nothing() {
    let thing = |shape: &str, bsdf: &str| {
        let camera = camera("0, 0.4, -4", "0, 0, 0", "0, 1, 0", 20.0, [8, 8]);
        scene(&format!(r#"{camera}<shape type="{shape}">{bsdf}</shape>{}"#, constant("1")))
    };
    let mut family = Family::default();
    let ball = thing("sphere", r#"<bsdf type="dielectric"/>"#);
    for (name, pictures) in
        [("whitted", replicates(&ball, &WHITTED, samples(16))), ("distribution", replicates(&ball, &ORIGINAL, samples(16)))]
    {
        family.expect(format!("{name}, glass"), &mean_of(&pictures, 0), 1.0, 0.01);
    }
    family.must_hold();

    let pane = r#"<bsdf type="thindielectric"/>"#.to_owned();
    let mask =
        format!(r#"<bsdf type="mask"><float name="opacity" value="0.25"/><bsdf type="twosided">{}</bsdf></bsdf>"#, mirror("1"));
    for (name, bsdf) in [("pane", pane), ("mask", mask)] {
        let scene = thing("rectangle", &bsdf);
        for null_counts in [false, true] {
            let job = samples(1).with(PathRules { null_counts, ..PathRules::default() });
            exact(name, &scene, &WHITTED, job, [1.0; 3]);
            exact(name, &scene, &ORIGINAL, job, [1.0; 3]);
        }
    }
}

/// ρ L_a, on the front of what is diffuse, seen straight or in a mirror, and nowhere else.
#[test]
fn ambient_light() {
    let seen = |bsdf: &str, origin: &str| {
        scene(&format!(
            r#"{}<shape type="rectangle"><transform name="to_world"><scale value="100"/></transform>{bsdf}</shape>{}"#,
            camera(origin, "0, 0, 0", "0, 1, 0", 40.0, [4, 4]),
            constant("0")
        ))
    };
    let solver = ambient(0.5, 1.0, 2.0);
    let front = seen(&diffuse(0.6), "0, 1, 4");
    exact("front", &front, &solver, samples(1), [0.3, 0.6, 1.2]);
    exact("none", &front, &WHITTED, samples(1), [0.0; 3]);
    exact("one bounce", &front, &solver, bounces(1, 1), [0.3, 0.6, 1.2]);
    exact("no bounce", &front, &solver, bounces(0, 0), [0.0; 3]);
    exact("two bounces", &front, &solver, bounces(2, 9), [0.0; 3]);
    exact("back", &seen(&diffuse(0.6), "0, 1, -4"), &solver, samples(1), [0.0; 3]);
    let two = format!(r#"<bsdf type="twosided">{}</bsdf>"#, diffuse(0.6));
    exact("two sides", &seen(&two, "0, 1, -4"), &solver, samples(1), [0.3, 0.6, 1.2]);
    exact("mirror", &seen(&mirror("1"), "0, 1, 4"), &solver, samples(1), [0.0; 3]);
    let blend = format!(r#"<bsdf type="blendbsdf"><float name="weight" value="0.25"/>{}{}</bsdf>"#, mirror("1"), diffuse(0.8));
    exact("blend", &seen(&blend, "0, 1, 4"), &solver, samples(1), [0.1, 0.2, 0.4]);
    let gloss =
        r#"<bsdf type="phong"><rgb name="diffuse_reflectance" value="0.5"/><rgb name="specular_reflectance" value="0.5"/></bsdf>"#;
    exact("gloss", &seen(gloss, "0, 1, 4"), &solver, samples(1), [0.25, 0.5, 1.0]);

    // A floor in a mirror on the wall: the mirror's share of ρ L_a, at the third edge.
    let in_mirror = scene(&format!(
        r#"{}<shape type="rectangle"><transform name="to_world"><scale value="100"/><rotate x="1" angle="180"/>
            <translate z="4"/></transform>{}</shape>
        <shape type="rectangle"><transform name="to_world"><scale value="100"/><translate z="-4"/></transform>{}</shape>{}"#,
        camera("0, 0, 0", "0.1, 0, 1", "0, 1, 0", 30.0, [4, 4]),
        mirror("0.5"),
        diffuse(0.6),
        constant("0")
    ));
    exact("in a mirror", &in_mirror, &solver, samples(1), [0.15, 0.3, 0.6]);
    exact("in a mirror, two bounces", &in_mirror, &solver, bounces(2, 2), [0.15, 0.3, 0.6]);
    exact("in a mirror, one bounce", &in_mirror, &solver, bounces(1, 1), [0.0; 3]);
}

/// Lamps of every kind over diffuse things: a mesh of uneven triangles, a ball, a point, a spot, a sun and the sky.
fn lamps() -> Scene {
    scene(&format!(
        r#"{}
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="4"/></transform>{}</shape>
        <shape type="cube"><transform name="to_world"><scale value="0.4"/><translate y="0.4" z="0.5"/></transform>{}</shape>
        <shape type="cube"><transform name="to_world"><scale x="1" y="0.02" z="0.3"/><translate y="2"/></transform>{}</shape>
        <shape type="sphere"><point name="center" value="-1, 1, 0"/><float name="radius" value="0.2"/>{}</shape>
        {}
        <emitter type="spot"><transform name="to_world"><lookat origin="1, 2, 0" target="0.7, 0, 0" up="0, 0, 1"/></transform>
            <rgb name="intensity" value="1, 3, 2"/><float name="cutoff_angle" value="30"/></emitter>
        <emitter type="directional"><vector name="direction" value="1, -2, 1"/><rgb name="irradiance" value="0.5, 0.4, 0.2"/></emitter>
        {}"#,
        camera("0, 2, -3.5", "0, 0.4, 0", "0, 1, 0", 50.0, [8, 8]),
        diffuse(0.6),
        diffuse(0.4),
        area("1, 2, 3"),
        area("6, 4, 2"),
        lamp("0.5, 1.5, -1", "1, 1, 2"),
        constant("0.1, 0.2, 0.3")
    ))
}

#[test]
fn direct_light_of_every_lamp() {
    let mut family = Family::default();
    let scene = lamps();
    let direct = Direct { emitter_samples: 8, bsdf_samples: 2 };
    let job = samples(64).edges(2);
    let reference = replicates(&scene, &direct, job);
    let mut claim = |name: &str, pictures: &[Picture]| agreement(&mut family, name, &scene, pictures, &reference, 0.1);
    // On diffuse things whitted needs no limit to know no more.
    claim("whitted", &replicates(&scene, &WHITTED, samples(64).seed(2)));
    claim("distribution", &replicates(&scene, &ORIGINAL, job.seed(3)));
    claim("draws alone", &replicates(&scene, &Distribution { shadow_samples: 1, ..COMPLETE }, job.seed(4)));
    family.must_hold();
}

/// `path-mis` of the paths L D? S* E alone: a walk that has turned at a smooth surface does not go on. With point lights nothing is to be
/// found at its end.
struct LocalOnly;

impl PathSolver for LocalOnly {
    fn scatter(&self, c: &Context<'_>, state: &mut PathState, hit: Option<Hit>, u: &Sampler) -> Step {
        let step = PathMis::default().scatter(c, state, hit, u);
        Step { goes_on: step.goes_on && state.pdf.is_delta(), ..step }
    }
}

/// Mirrors, varnish, glass, a pane and a mask under point lights: the tree finds what a walk finds that knows the same paths.
#[test]
fn mirrors_under_point_lights() {
    let mut family = Family::default();
    let pane = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.5"/><rotate y="1" angle="30"/>
            <translate x="-0.6" y="0.6" z="-1"/></transform><bsdf type="thindielectric"/></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="0.3"/><translate x="0.2" y="1" z="-0.6"/></transform>
            <bsdf type="mask"><float name="opacity" value="0.4"/>
                <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></bsdf></shape>"#;
    let scene = scene(&format!(
        r#"{}
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="3"/></transform>
            <bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.2, 0.5, 0.7"/></bsdf></shape>
        <shape type="rectangle"><transform name="to_world"><rotate y="1" angle="180"/><scale value="3"/><translate z="2.5"/></transform>{}</shape>
        <shape type="sphere"><point name="center" value="0.6, 0.5, 0.5"/><float name="radius" value="0.5"/>
            <bsdf type="dielectric"/></shape>
        <shape type="sphere"><point name="center" value="-0.7, 0.5, 0.8"/><float name="radius" value="0.5"/>{}</shape>
        {pane}{}{}"#,
        camera("0, 1.5, -4", "0, 0.6, 0", "0, 1, 0", 45.0, [8, 8]),
        mirror("0.9, 0.8, 0.7"),
        diffuse(0.6),
        lamp("1, 3, -1", "8, 6, 4"),
        lamp("-1.5, 2, -2", "1, 2, 4")
    ));
    for null_counts in [false, true] {
        let rules = PathRules { null_counts, ..PathRules::default() };
        for rules in [rules, rules.with_bounces(0..=3), rules.with_bounces(2..=2)] {
            let walk = replicates(&scene, &LocalOnly, samples(512).with(rules));
            let tree = replicates(&scene, &WHITTED, samples(64).with(rules).seed(2));
            let name = format!("null counts {null_counts}, edges {}..{}", rules.min_edges, rules.max_edges);
            agreement(&mut family, &name, &scene, &tree, &walk, 0.3);
        }
    }
    family.must_hold();
}

/// Where all things are glossy Cook's tree leaves nothing out.
#[test]
fn a_glossy_room() {
    let mut family = Family::default();
    let rough = |alpha: f32, r: &str| {
        format!(
            r#"<bsdf type="roughconductor"><spectrum name="eta" value="0"/><spectrum name="k" value="1"/><float name="alpha" value="{alpha}"/>
                <rgb name="specular_reflectance" value="{r}"/></bsdf>"#
        )
    };
    let scene = scene(&format!(
        r#"{}
        <shape type="cube"><boolean name="flip_normals" value="true"/>{}</shape>
        <shape type="sphere"><point name="center" value="0.3, -0.5, 0.3"/><float name="radius" value="0.4"/>
            <bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf></shape>
        <shape type="sphere"><point name="center" value="-0.3, 0.6, 0"/><float name="radius" value="0.25"/>{}{}</shape>"#,
        camera("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [8, 8]),
        rough(0.4, "0.6, 0.5, 0.4"),
        rough(0.5, "0.2"),
        area("3, 4, 5")
    ));
    let job = |spp: u32| samples(spp).with(PathRules::default().with_bounces(0..=5));
    let reference = replicates(&scene, &PathMis::default(), job(256));
    agreement(&mut family, "glossy", &scene, &replicates(&scene, &ORIGINAL, job(32).seed(2)), &reference, 0.25);
    let without_shadow_rays = Distribution { shadow_samples: 0, ..ORIGINAL };
    agreement(&mut family, "draws alone", &scene, &replicates(&scene, &without_shadow_rays, job(32).seed(3)), &reference, 0.25);
    family.must_hold();
}

/// With directions at diffuse hits it finds all light.
#[test]
fn a_room_with_diffuse_samples() {
    let mut family = Family::default();
    let scene = scene(&format!(
        r#"{}
        <shape type="cube"><boolean name="flip_normals" value="true"/>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.5, 0.3"/></bsdf></shape>
        <shape type="rectangle">
            <transform name="to_world"><rotate x="1" angle="90"/><scale x="0.7" z="0.7"/><translate y="0.95"/></transform>{}{}</shape>
        <shape type="sphere"><point name="center" value="-0.45, -0.6, 0.3"/><float name="radius" value="0.38"/>
            <bsdf type="phong"/></shape>
        <shape type="sphere"><point name="center" value="0.45, -0.6, 0"/><float name="radius" value="0.35"/>
            <bsdf type="dielectric"/></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="0.2"/><translate y="0.2"/></transform>
            <bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="twosided">{}</bsdf></bsdf></shape>"#,
        camera("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [8, 8]),
        diffuse(0.2),
        area("3, 4, 5"),
        diffuse(0.5),
    ));
    for null_counts in [false, true] {
        let rules = PathRules { null_counts, ..PathRules::default() }.with_bounces(0..=4);
        let reference = replicates(&scene, &PathMis::default(), samples(192).with(rules));
        let tree = replicates(&scene, &COMPLETE, samples(64).with(rules).seed(2));
        agreement(&mut family, &format!("null counts {null_counts}"), &scene, &tree, &reference, 0.4);
    }
    family.must_hold();
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    let scene = lamps();
    let bits = |solver: &dyn Fn(Job) -> Picture, threads: usize| -> Vec<u32> {
        let job = Job { threads, ..samples(4) };
        solver(job).iter().flatten().map(|x| x.to_bits()).collect()
    };
    let whitted = |job: Job| picture(&scene, &ambient(0.1, 0.1, 0.1), job);
    let distribution = |job: Job| picture(&scene, &COMPLETE, job);
    for solver in [&whitted as &dyn Fn(Job) -> Picture, &distribution] {
        let one = bits(solver, 1);
        assert_eq!(one, bits(solver, 2));
        assert_eq!(one, bits(solver, 5));
        assert_ne!(one, bits(&|job| solver(job.seed(2)), 1), "the seed matters");
    }
}
