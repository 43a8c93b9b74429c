//! The rendering equation is linear in Le: each light alone, added up, is the joint picture, for every solver that walks. Lights that are off reflect and stand in the
//! way as before.
//!
//! Each test is one family of claims with 1 % of false alarms, over independent replicates.

mod common;

use common::checks::agreement;
use common::*;
use etendue_scene::{EmitterId, Scene};
use etendue_solvers::agreement::Trial;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::{AnySolver, CancelToken, PathRules, SOLVERS, Stop};

const LENS: &str = r#"<sensor type="thinlens"><float name="fov" value="70"/><float name="aperture_radius" value="0.3"/><float name="focus_distance" value="3"/>
    <transform name="to_world"><lookat origin="0, 1.5, -2.5" target="0, 0.4, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/><rfilter type="box"/></film></sensor>"#;

/// Lamps that are seen and shade each other, a sky, and `more`.
fn lit_by(more: &str) -> Scene {
    let ball = |x: f32, radiance: &str| {
        format!(
            r#"<shape type="sphere"><point name="center" value="{x}, 0.6, 0"/><float name="radius" value="0.4"/>{}{}</shape>"#,
            diffuse(0.7),
            area(radiance)
        )
    };
    scene(&format!(
        r#"{LENS}<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="2"/></transform>{}</shape>
        {}{}<emitter type="constant"><rgb name="radiance" value="0.3, 0.4, 0.5"/></emitter>{more}"#,
        diffuse(0.6),
        ball(-0.6, "4, 2, 1"),
        ball(0.5, "1, 3, 2")
    ))
}

/// Pictures of independent seeds; `stream` is one for each purpose.
fn pictures(scene: &Scene, solver: &AnySolver, rules: PathRules, spp: u32, stream: u64) -> Vec<Picture> {
    let (pool, cancel) = (threads(2), CancelToken::default());
    let trial = Trial { rules, ..Trial::new(scene, &pool, &cancel) };
    let render = |run: &etendue_solvers::Run<'_>, film: &etendue_film::Film| solver.render(scene, run, film, None);
    let shoot = |r| trial.shoot(&render, Stop::Samples(spp), trial.seed_of(stream, r), &|_, _| ()).expect("renders").pixels;
    (0..K as u32).map(shoot).collect()
}

#[test]
fn lights_add_up() {
    let mut family = Family::default();
    let point = r#"<emitter type="point"><point name="position" value="0.3, 2, 0.4"/><rgb name="intensity" value="3"/></emitter>"#;
    let rules = PathRules { max_edges: 4, ..PathRules::default() };
    // Radiosity cuts its patches where light changes: each light alone has patches of its own, and the sum agrees in the limit only.
    for info in SOLVERS.iter().filter(|s| s.name != "radiosity") {
        // Random walks from the eye hit no points, nor do random walks from the lights the lens of this size often.
        let (more, spp) = match info.name {
            "path" => ("", 64),
            "light" => ("", 512),
            "light-nee" | "photon-map" | "metropolis" => (point, 96),
            _ => (point, 32),
        };
        let mut scene = lit_by(more);
        let solver = AnySolver::new(info.name, &scene.integrator).expect("a solver of the list");
        if solver.needs().check(&scene).is_err() {
            continue;
        }
        let joint = pictures(&scene, &solver, rules, spp, 0);
        let mut sum = vec![vec![[0f32; 3]; joint[0].len()]; joint.len()];
        for k in 0..scene.emitters.len() {
            scene.switch(|id| id == EmitterId(k as u32));
            let alone = pictures(&scene, &solver, rules, spp, 1 + k as u64);
            for (sum, alone) in sum.iter_mut().flatten().zip(alone.iter().flatten()) {
                sum.iter_mut().zip(alone).for_each(|(s, a)| *s += a);
            }
        }
        agreement(&mut family, info.name, &scene, &sum, &joint, if info.name == "light" { 1.2 } else { 0.5 });
    }
    family.must_hold();
}

/// A light alone is the scene whose other lights have no radiance; all on again is the scene as it was.
#[test]
fn a_light_that_is_off_is_a_dark_surface() {
    let mut family = Family::default();
    let rules = PathRules { max_edges: 5, ..PathRules::default() };
    let solver = AnySolver::PathMis(PathMis::default());
    let mut scene = lit_by("");
    let before = pictures(&scene, &solver, rules, 4, 0);
    scene.switch(|id| id == EmitterId(1));
    let alone = pictures(&scene, &solver, rules, 64, 1);
    let dark = common::scene(&format!(
        r#"{LENS}<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="2"/></transform>{}</shape>
        <shape type="sphere"><point name="center" value="-0.6, 0.6, 0"/><float name="radius" value="0.4"/>{}</shape>
        <shape type="sphere"><point name="center" value="0.5, 0.6, 0"/><float name="radius" value="0.4"/>{}{}</shape>"#,
        diffuse(0.6),
        diffuse(0.7),
        diffuse(0.7),
        area("1, 3, 2")
    ));
    agreement(&mut family, "alone", &scene, &alone, &pictures(&dark, &solver, rules, 64, 2), 0.3);
    scene.switch(|_| true);
    assert!(pictures(&scene, &solver, rules, 4, 0) == before);
    family.must_hold();
}
