//! Agreement: solvers that find light in different ways must find the same light, in every 4 × 4 block and channel.
//!
//! Means of K independent scrambles, Welch's t; one family of claims per test, 1 % of false alarms [Šidák 1967]. A claim passes only if a bias as
//! large as its bound would have been seen.

mod common;

use common::checks::agreement;
use common::*;
use etendue_scene::Scene;
use etendue_solvers::PathRules;
use etendue_solvers::oracle::{Directions, Oracle};
use etendue_solvers::path::Path;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::path_nee::PathNee;
use etendue_solvers::transport::Heuristic;

const BALANCE: PathMis = PathMis::alone(Heuristic::Balance);
const SIZE: [u32; 2] = [8, 8];

/// Samples per pixel of each solver.
struct Effort {
    path: u32,
    nee: u32,
    mis: u32,
    oracle: u32,
}

/// Claims that all agree with path-mis.
fn all_agree(family: &mut Family, name: &str, scene: &Scene, rules: PathRules, effort: &Effort, bound: f64) {
    let job = |spp: u32| samples(spp).with(rules);
    let reference = replicates(scene, &PathMis::default(), job(effort.mis));
    let mut compare = |solver: &str, pictures: &[Picture]| {
        agreement(family, &format!("{solver}, {name}"), scene, pictures, &reference, bound);
    };
    compare("path-mis (balance)", &replicates(scene, &BALANCE, job(effort.mis).seed(2)));
    compare("path-nee", &replicates(scene, &PathNee, job(effort.nee).seed(3)));
    if effort.path > 0 {
        compare("path", &replicates(scene, &Path, job(effort.path).seed(4)));
    }
    if effort.oracle > 0 {
        let oracle = Oracle { absorption: 0.2, directions: Directions::Bsdf, ..Oracle::default() };
        compare("oracle", &replicates(scene, &oracle, job(effort.oracle).seed(5)));
    }
}

/// A box with coloured walls and a large lamp under its ceiling; `inside` stands in it.
fn room(inside: &str) -> Scene {
    scene(&format!(
        r#"{}
        <shape type="cube"><boolean name="flip_normals" value="true"/>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.5, 0.3"/></bsdf></shape>
        <shape type="rectangle">
            <transform name="to_world"><rotate x="1" angle="90"/><scale x="0.7" z="0.7"/><translate y="0.95"/></transform>
            {}<emitter type="area"><rgb name="radiance" value="3, 4, 5"/></emitter></shape>{inside}"#,
        camera("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, SIZE),
        diffuse(0.2)
    ))
}

fn balls() -> Scene {
    room(
        r#"<shape type="sphere"><point name="center" value="-0.45, -0.6, 0.3"/><float name="radius" value="0.38"/>
            <bsdf type="roughconductor"><string name="material" value="Au"/><float name="alpha" value="0.3"/></bsdf></shape>
        <shape type="sphere"><point name="center" value="0.45, -0.6, 0"/><float name="radius" value="0.35"/>
            <bsdf type="dielectric"/></shape>"#,
    )
}

#[test]
fn a_room_with_gold_and_glass() {
    let mut family = Family::default();
    let effort = Effort { path: 256, nee: 512, mis: 128, oracle: 512 };
    all_agree(&mut family, "room", &balls(), PathRules::default().with_bounces(0..=5), &effort, 0.1);
    family.must_hold();
}

/// Walks that share with those of neighbouring pixels against walks alone: Lambert's walls, varnish and gold before the eye and beyond, edges within blocks, a sky through a
/// window, bounce by bounce.
#[test]
fn neighbours_that_share() {
    let mut family = Family::default();
    let varnish = |rest: &str| {
        format!(
            r#"<bsdf type="twosided"><bsdf type="roughplastic"><float name="alpha" value="0.15"/>
            <rgb name="diffuse_reflectance" value="0.6, 0.4, 0.5"/>{rest}</bsdf></bsdf>"#
        )
    };
    let sky: Vec<[f32; 3]> = (0..128).map(|i| if i % 64 < 3 { [9.0, 7.0, 5.0] } else { [1.0, 1.5, 2.0] }).collect();
    let scene = scene(&format!(
        r#"{}<emitter type="envmap"><string name="filename" value="{}"/></emitter>
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><translate y="-1"/></transform>{}</shape>
        <shape type="rectangle"><transform name="to_world"><translate z="1"/></transform>{}</shape>
        <shape type="rectangle"><transform name="to_world"><rotate y="1" angle="90"/><translate x="-1"/></transform>{}</shape>
        <shape type="rectangle"><transform name="to_world"><scale x="0.6"/><rotate x="1" angle="90"/><translate x="-0.4" y="1"/></transform>{}</shape>
        <shape type="cube"><transform name="to_world"><scale value="0.25"/><rotate y="1" angle="25"/><translate x="0.4" y="-0.75" z="0.2"/></transform>{}</shape>
        <shape type="sphere"><point name="center" value="-0.4, -0.7, 0"/><float name="radius" value="0.3"/>
            <bsdf type="roughconductor"><float name="alpha" value="0.2"/></bsdf></shape>"#,
        camera("0, 0, -2.2", "0, -0.2, 0", "0, 1, 0", 50.0, [16, 16]),
        picture_file("agreement-window", 16, &sky),
        diffuse(0.7),
        varnish(""),
        diffuse(0.5),
        diffuse(0.6),
        varnish(r#"<string name="distribution" value="ggx"/>"#),
    ));
    for (bounces, spp) in [(0..=u32::MAX - 1, 64), (1..=1, 32), (2..=2, 64)] {
        let job = samples(spp).with(PathRules::default().with_bounces(bounces.clone()));
        let alone = replicates(&scene, &PathMis::alone(Heuristic::Power), job);
        for block in 1..=2 {
            let together = replicates(&scene, &PathMis { block, follow: 1.0, ..PathMis::default() }, job.seed(block as u64 + 1));
            agreement(&mut family, &format!("blocks of {}, bounces {bounces:?}", 1 << block), &scene, &together, &alone, 0.3);
        }
    }
    family.must_hold();
}

/// Light of single bounces, too.
#[test]
fn a_room_bounce_by_bounce() {
    let mut family = Family::default();
    let scene = balls();
    for (bounces, effort) in [
        (0..=0, Effort { path: 8, nee: 8, mis: 8, oracle: 8 }),
        (1..=1, Effort { path: 128, nee: 64, mis: 64, oracle: 128 }),
        (2..=3, Effort { path: 256, nee: 512, mis: 256, oracle: 0 }),
    ] {
        let name = format!("bounces {bounces:?}");
        all_agree(&mut family, &name, &scene, PathRules::default().with_bounces(bounces), &effort, 0.4);
    }
    family.must_hold();
}

#[test]
fn a_textured_lamp() {
    let mut family = Family::default();
    let scene = scene(&format!(
        r#"{}
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="4"/></transform>
            <bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.2, 0.5, 0.7"/></bsdf></shape>
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><translate y="1.2"/></transform>{}
            <emitter type="area"><texture type="bitmap" name="radiance"><string name="filename" value="{}"/>
                <boolean name="raw" value="true"/><string name="filter_type" value="nearest"/></texture></emitter></shape>"#,
        camera("0, 1.5, -3", "0, 0.3, 0", "0, 1, 0", 60.0, SIZE),
        diffuse(0.5),
        picture_file("agreement-lamp", 2, &[[0.0; 3], [6.0, 4.0, 1.0], [0.0, 5.0, 0.0], [0.0; 3]])
    ));
    let effort = Effort { path: 256, nee: 128, mis: 64, oracle: 256 };
    all_agree(&mut family, "textured lamp", &scene, PathRules::default(), &effort, 0.3);
    family.must_hold();
}

/// A sky with a bright patch, a lamp besides, rough glass and an instanced, mirrored and squeezed group.
#[test]
fn a_sky_and_instances() {
    let mut family = Family::default();
    let sky: Vec<[f32; 3]> = (0..128)
        .map(|i| if matches!(i, 20 | 21 | 36 | 37) { [20.0, 16.0, 9.0] } else { [0.3, 0.4, 0.1 + 0.005 * i as f32] })
        .collect();
    let scene = scene(&format!(
        r#"{}
            <emitter type="envmap"><string name="filename" value="{}"/></emitter>
            <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="4"/></transform>{}</shape>
            <shape type="shapegroup" id="group">
                <shape type="cube"><transform name="to_world"><scale value="0.3"/></transform>{}</shape>
                <shape type="sphere"><point name="center" value="0, 0.6, 0"/><float name="radius" value="0.3"/>
                    <bsdf type="roughdielectric"><float name="alpha" value="0.4"/></bsdf></shape>
            </shape>
            <shape type="instance"><ref id="group"/><transform name="to_world"><translate x="0.7" y="0.35"/></transform></shape>
            <shape type="instance"><ref id="group"/><transform name="to_world">
                <scale x="-0.7" y="1.2" z="0.5"/><rotate y="1" angle="30"/><translate x="-0.7" y="0.4"/></transform></shape>
            <shape type="disk"><transform name="to_world"><scale value="0.5"/><translate x="1.5" y="0.8" z="0.5"/></transform>{}
                <emitter type="area"><rgb name="radiance" value="2, 3, 4"/></emitter></shape>"#,
        camera("0, 1.5, -3", "0, 0.3, 0", "0, 1, 0", 50.0, SIZE),
        picture_file("agreement-sky", 16, &sky),
        diffuse(0.5),
        diffuse(0.7),
        diffuse(0.3)
    ));
    let effort = Effort { path: 512, nee: 256, mis: 64, oracle: 512 };
    all_agree(&mut family, "sky and instances", &scene, PathRules::default(), &effort, 0.15);
    family.must_hold();
}

/// A cut-out and a null surface between lamp and floor: light passes them straight, in shadows too, whether or not that is an edge.
#[test]
fn masks_and_null_surfaces() {
    let mut family = Family::default();
    let scene = room(
        r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><scale value="0.8"/><translate y="0.2"/></transform>
            <bsdf type="mask"><texture type="checkerboard" name="opacity">
                <rgb name="color0" value="0.2"/><rgb name="color1" value="0.9"/></texture>
                <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.2, 0.6, 0.6"/></bsdf></bsdf></bsdf></shape>
        <shape type="cube"><transform name="to_world"><scale value="0.3"/><translate y="-0.6"/></transform><bsdf type="null"/></shape>"#,
    );
    let effort = Effort { path: 64, nee: 160, mis: 64, oracle: 192 };
    for null_counts in [true, false] {
        for max_edges in [3, 6] {
            let rules = PathRules { null_counts, max_edges, ..PathRules::default() };
            all_agree(&mut family, &format!("masks, {max_edges} edges, null counts: {null_counts}"), &scene, rules, &effort, 0.25);
        }
    }
    family.must_hold();
}

/// Shading normals that lean towards and away from the light.
#[test]
fn bumpy_normals() {
    let mut family = Family::default();
    let bumps: Vec<[f32; 3]> = (0..64)
        .map(|i| {
            let (x, y) = ((i % 8) as f32, (i / 8) as f32);
            let (nx, ny) = (0.6 * (2.1 * x + y).sin(), 0.6 * (1.3 * y - x).cos());
            let nz = (1.0 - nx * nx - ny * ny).sqrt();
            [0.5 + 0.5 * nx, 0.5 + 0.5 * ny, 0.5 + 0.5 * nz]
        })
        .collect();
    let scene = scene(&format!(
        r#"{}
            <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="2"/></transform>
                <bsdf type="normalmap"><texture type="bitmap" name="normalmap"><string name="filename" value="{}"/>
                    <boolean name="raw" value="true"/></texture>
                    <bsdf type="roughplastic"><rgb name="diffuse_reflectance" value="0.5, 0.3, 0.2"/><float name="alpha" value="0.4"/></bsdf>
                </bsdf></shape>
            <shape type="rectangle"><transform name="to_world"><lookat origin="-2, 1.5, 0" target="0, 0, 0" up="0, 1, 0"/></transform>{}
                <emitter type="area"><rgb name="radiance" value="5, 4, 3"/></emitter></shape>"#,
        camera("0, 1.5, -3", "0, 0, 0", "0, 1, 0", 50.0, SIZE),
        picture_file("agreement-bumps", 8, &bumps),
        diffuse(0.5)
    ));
    let effort = Effort { path: 512, nee: 128, mis: 64, oracle: 256 };
    all_agree(&mut family, "bumps", &scene, PathRules::default(), &effort, 0.22);
    family.must_hold();
}

/// Lamps that no walk can hit, beside one that it can: only those that sample lights.
#[test]
fn many_kinds_of_light() {
    let mut family = Family::default();
    let scene = room(
        r#"<emitter type="point"><point name="position" value="0.5, 0.5, 0"/><rgb name="intensity" value="0.6, 0.1, 0.1"/></emitter>
        <emitter type="spot"><transform name="to_world"><lookat origin="-0.5, 0.5, 0" target="0, -1, 0.5" up="0, 0, 1"/></transform>
            <rgb name="intensity" value="0.2, 0.8, 0.2"/><float name="cutoff_angle" value="40"/></emitter>
        <shape type="sphere"><point name="center" value="0.3, -0.3, 0.4"/><float name="radius" value="0.1"/>
            <emitter type="area"><rgb name="radiance" value="1, 1, 9"/></emitter></shape>"#,
    );
    let effort = Effort { path: 0, nee: 256, mis: 128, oracle: 0 };
    all_agree(&mut family, "kinds of light", &scene, PathRules::default().with_bounces(0..=3), &effort, 0.05);
    family.must_hold();
}
