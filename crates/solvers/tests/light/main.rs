//! Light tracing against path tracing: the same light from either end.
//!
//! ```text
//! I = ⟨We, L⟩ = ⟨W, Le⟩
//! ```
//!
//! Each test is one family of claims with 1 % of false alarms, over independent replicates.

mod bent;
#[path = "../common/mod.rs"]
mod common;
mod kinds;
mod machinery;

use common::checks::{agreement, neumann};
use common::*;
use etendue_scene::Scene;
use etendue_solvers::PathRules;
use etendue_solvers::light::Light;
use etendue_solvers::light_nee::LightNee;
use etendue_solvers::path_mis::PathMis;

const SIZE: [u32; 2] = [8, 8];

/// A camera with a lens.
fn lens(origin: &str, target: &str, fov: f32, radius: f32, focus: f32, [width, height]: [u32; 2], film: &str) -> String {
    format!(
        r#"<sensor type="thinlens"><float name="fov" value="{fov}"/>
            <float name="aperture_radius" value="{radius}"/><float name="focus_distance" value="{focus}"/>
            <transform name="to_world"><lookat origin="{origin}" target="{target}" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><integer name="width" value="{width}"/><integer name="height" value="{height}"/>{film}</film></sensor>"#
    )
}

const BOX: &str = r#"<rfilter type="box"/>"#;

fn orthographic(origin: &str, target: &str, scale: f32) -> String {
    format!(
        r#"<sensor type="orthographic">
            <transform name="to_world"><scale x="{scale}" y="{scale}"/><lookat origin="{origin}" target="{target}" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/>{BOX}</film></sensor>"#
    )
}

/// The furnace seen by a camera: a closed diffuse box with Le = 1.
fn furnace_seen_by(camera: &str, shape: &str, a: f32) -> Scene {
    scene(&format!(
        r#"{camera}<shape type="{shape}"><boolean name="flip_normals" value="true"/>{}{}</shape>"#,
        diffuse(a),
        area("1")
    ))
}

fn depths() -> impl Iterator<Item = Option<u32>> {
    (0..=5).map(Some).chain([None])
}

#[test]
fn furnace_light_nee() {
    let mut family = Family::default();
    let cameras = [
        camera("0, 0, -0.5", "0.1, 0.2, 1", "0, 1, 0", 70.0, [4, 4]),
        lens("0, 0, -0.5", "0.1, 0.2, 1", 70.0, 0.1, 0.7, [4, 4], BOX),
    ];
    for a in [0.2, 0.9] {
        for (camera, shape) in cameras.iter().zip(["cube", "sphere"]) {
            let scene = furnace_seen_by(camera, shape, a);
            for n in depths() {
                let job = samples(256).edges(n.map_or(u32::MAX, |n| n + 1));
                let pictures = replicates(&scene, &LightNee, job);
                let want = neumann(f64::from(a), n);
                family.expect(format!("light-nee, {shape}, albedo {a}, {n:?}"), &mean_of(&pictures, 0), want, 0.1);
            }
        }
    }
    family.must_hold();
}

#[test]
fn furnace_light() {
    let mut family = Family::default();
    for a in [0.2, 0.9] {
        let scene = furnace_seen_by(&lens("0, 0, -0.5", "0, 0, 1", 90.0, 0.4, 0.7, [4, 4], BOX), "sphere", a);
        for n in depths() {
            let job = samples(512).edges(n.map_or(u32::MAX, |n| n + 1));
            let pictures = replicates(&scene, &Light, job);
            family.expect(format!("light, albedo {a}, {n:?}"), &mean_of(&pictures, 0), neumann(f64::from(a), n), 0.13);
        }
    }
    family.must_hold();
}

/// Claims that light tracing agrees with path-mis.
fn agrees(family: &mut Family, name: &str, scene: &Scene, rules: PathRules, [nee, light, mis]: [u32; 3], bound: f64) {
    let job = |spp: u32| samples(spp).with(rules);
    let reference = replicates(scene, &PathMis::default(), job(mis));
    if nee > 0 {
        agreement(family, &format!("light-nee, {name}"), scene, &replicates(scene, &LightNee, job(nee).seed(2)), &reference, bound);
    }
    if light > 0 {
        agreement(family, &format!("light, {name}"), scene, &replicates(scene, &Light, job(light).seed(3)), &reference, bound);
    }
}

/// A box with coloured walls and a lamp under its ceiling.
fn room(camera: &str, inside: &str) -> Scene {
    scene(&format!(
        r#"{camera}
        <shape type="cube"><boolean name="flip_normals" value="true"/>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.5, 0.3"/></bsdf></shape>
        <shape type="rectangle">
            <transform name="to_world"><rotate x="1" angle="90"/><scale x="0.7" z="0.7"/><translate y="0.95"/></transform>
            {}<emitter type="area"><rgb name="radiance" value="3, 4, 5"/></emitter></shape>{inside}"#,
        diffuse(0.2)
    ))
}

fn eye() -> String {
    camera("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, SIZE)
}

#[test]
fn a_diffuse_box() {
    let mut family = Family::default();
    for (name, camera) in [("pinhole", eye()), ("orthographic", orthographic("0, 0, -0.95", "0, 0, 1", 0.8))] {
        for bounces in [0..=0, 1..=1, 2..=5] {
            let rules = PathRules::default().with_bounces(bounces.clone());
            agrees(&mut family, &format!("{name}, {bounces:?}"), &room(&camera, ""), rules, [512, 0, 64], 0.5);
        }
    }
    family.must_hold();
}

#[test]
fn a_box_through_a_lens() {
    let mut family = Family::default();
    let camera = lens("0, 0, -0.9", "0, 0, 1", 80.0, 0.4, 1.0, SIZE, BOX);
    for bounces in [0..=0, 1..=1, 2..=4] {
        let rules = PathRules::default().with_bounces(bounces.clone());
        agrees(&mut family, &format!("lens, {bounces:?}"), &room(&camera, ""), rules, [256, 1024, 64], 0.6);
    }
    family.must_hold();
}

/// A floor under a lamp, seen from above; `inside` stands out of view.
fn floor_scene(camera: &str, floor: &str, inside: &str) -> Scene {
    scene(&format!(
        r#"{camera}
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="3"/></transform>{floor}</shape>{inside}"#
    ))
}
