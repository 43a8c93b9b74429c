//! Closed forms: what a point, a sphere, a polygon, parallel light, a cone and the sky give on a plane, and what mirrors and glass pass on.
//! Units exact.
//!
//! ```text
//! L = ρ E/π       E = I cosθ/r²    E = π L (R/d)² cosθ    E = L/2 |Σ θ_i Γ_i·n|    E = E⊥ cosθ    E = π L
//! ```
//!
//! Each test is one family of claims with 1 % of false alarms.

mod common;

use common::checks::{at_point, closed_form, closed_form_by, floor, fresnel, polygon_irradiance};
use common::*;
use etendue_scene::Scene;
use etendue_solvers::PathRules;
use etendue_solvers::direct::Direct;
use etendue_solvers::oracle::{Directions, Oracle};
use etendue_solvers::path::Path;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::path_nee::PathNee;
use etendue_solvers::transport::Heuristic;
use std::f64::consts::PI;

const RHO: f64 = 0.5;

/// All solvers that sample lights.
fn with_light_samples(family: &mut Family, name: &str, scene: &Scene, expected: f64, spp: u32, bound: f64) {
    closed_form(family, &format!("path-nee, {name}"), scene, &PathNee, expected, spp, bound);
    closed_form(family, &format!("path-mis, {name}"), scene, &PathMis::default(), expected, spp, bound);
    let balance = PathMis { heuristic: Heuristic::Balance, ..PathMis::default() };
    closed_form(family, &format!("path-mis (balance), {name}"), scene, &balance, expected, spp, bound);
    let direct = Direct { emitter_samples: 2, bsdf_samples: 1 };
    closed_form(family, &format!("direct, {name}"), scene, &direct, expected, spp, bound);
}

/// And those that only meet them.
fn all(family: &mut Family, name: &str, scene: &Scene, expected: f64, spp: u32, bound: f64) {
    with_light_samples(family, name, scene, expected, spp, bound);
    closed_form(family, &format!("path, {name}"), scene, &Path, expected, 8 * spp, 1.5 * bound);
}

fn oracles(family: &mut Family, name: &str, scene: &Scene, expected: f64, spp: u32, bound: f64) {
    for directions in [Directions::Uniform, Directions::Cosine, Directions::Bsdf] {
        let oracle = Oracle { directions, ..Oracle::default() };
        closed_form(family, &format!("oracle ({directions:?}), {name}"), scene, &oracle, expected, spp, bound);
    }
}

#[test]
fn a_point_light() {
    let mut family = Family::default();
    let scene = scene(&format!(
        r#"{}{}<emitter type="point"><point name="position" value="0, 0, 2"/><rgb name="intensity" value="3"/></emitter>"#,
        at_point("1, 0.2, 3", "0.5, 0.25, 0"),
        floor(0.5)
    ));
    let r2: f64 = 0.25 + 0.0625 + 4.0;
    let e = 3.0 * (2.0 / r2.sqrt()) / r2;
    with_light_samples(&mut family, "point", &scene, RHO * e / PI, 1, 1e-5);
    family.must_hold();
}

#[test]
fn parallel_light() {
    let mut family = Family::default();
    let angle = 40f64.to_radians();
    let scene = scene(&format!(
        r#"{}{}<emitter type="directional"><vector name="direction" x="{}" y="0" z="{}"/><rgb name="irradiance" value="2"/></emitter>"#,
        at_point("1, 0, 3", "0.5, 0, 0"),
        floor(0.5),
        angle.sin(),
        -angle.cos()
    ));
    with_light_samples(&mut family, "directional", &scene, RHO * 2.0 * angle.cos() / PI, 1, 1e-5);
    family.must_hold();
}

/// Full within the beam, linear in the angle up to the cutoff, nothing beyond; and nothing but numbers at the very edges.
#[test]
fn a_spot() {
    let mut family = Family::default();
    let spot = |angle: f64, beam: f64| {
        scene(&format!(
            r#"{}{}<emitter type="spot">
                <transform name="to_world"><lookat origin="0, 0, 2" target="0, 0, 0" up="0, 1, 0"/></transform>
                <rgb name="intensity" value="3"/><float name="cutoff_angle" value="30"/><float name="beam_width" value="{beam}"/>
            </emitter>"#,
            at_point(&format!("{}, 0, 3", 2.0 * angle.to_radians().tan()), &format!("{}, 0, 0", 2.0 * angle.to_radians().tan())),
            floor(0.5)
        ))
    };
    for (angle, share) in [(0.0, 1.0), (10.0, 1.0), (25.0, 0.5), (27.5, 0.25), (35.0, 0.0), (80.0, 0.0)] {
        let cos = f64::to_radians(angle).cos();
        let e = share * 3.0 * cos * cos * cos / 4.0;
        // (The falloff's slope, 1/10°, magnifies what rounding does to the angle.)
        with_light_samples(&mut family, &format!("spot at {angle}°"), &spot(angle, 20.0), RHO * e / PI, 1, 1e-3);
    }
    family.must_hold();
    for (angle, beam) in [(30.0, 20.0), (20.0, 20.0), (30.0, 30.0), (29.999_999, 30.0)] {
        let value = picture(&spot(angle, beam), &PathMis::default(), samples(16))[0][0];
        assert!((0.0..=0.12).contains(&value), "spot at its edge of {angle}° with beam {beam}°: {value}");
    }
}

/// A sphere wholly above the horizon acts as a point at its centre: E = π L (R/d)² cosθ.
#[test]
fn a_sphere_light() {
    let mut family = Family::default();
    for (x, d2) in [(0.0, 9.0), (1.5, 11.25)] {
        let scene = scene(&format!(
            r#"{}{}<shape type="sphere"><point name="center" value="0, 0, 3"/>{}{}</shape>"#,
            at_point("4, 0, 2", &format!("{x}, 0, 0")),
            floor(0.5),
            diffuse(0.0),
            area("2")
        ));
        let expected = RHO * 2.0 / d2 * 3.0 / f64::sqrt(d2);
        all(&mut family, &format!("sphere light, {x} m off"), &scene, expected, 64, 0.06);
        oracles(&mut family, &format!("sphere light, {x} m off"), &scene, expected, 1024, 0.15);
    }
    family.must_hold();
}

#[test]
fn a_polygon_light() {
    let mut family = Family::default();
    let lamp = |extra: &str| {
        format!(
            r#"<shape type="rectangle">{extra}<transform name="to_world"><lookat origin="0, 0, 2" target="0, 0, 0" up="0, 1, 0"/></transform>{}{}</shape>"#,
            diffuse(0.0),
            area("2")
        )
    };
    let here = |lamp: &str| scene(&format!("{}{}{lamp}", at_point("4, 0, 2", "0.3, 0.4, 0"), floor(0.5)));
    let corners = [[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0]];
    let expected = RHO / PI * 2.0 * polygon_irradiance([0.3, 0.4, 0.0], &corners);
    all(&mut family, "quad light", &here(&lamp("")), expected, 64, 0.04);
    oracles(&mut family, "quad light", &here(&lamp("")), expected, 1024, 0.06);
    // Its back is dark: a lamp that looks away lights nothing.
    let away = here(&lamp(r#"<boolean name="flip_normals" value="true"/>"#));
    all(&mut family, "quad light from behind", &away, 0.0, 16, 1e-6);
    oracles(&mut family, "quad light from behind", &away, 0.0, 16, 1e-6);
    family.must_hold();
}

#[test]
fn the_sky() {
    let mut family = Family::default();
    let sky = r#"<emitter type="constant"><rgb name="radiance" value="2"/></emitter>"#;
    let plane = scene(&format!("{}{}{sky}", at_point("4, 0, 2", "0.3, 0.4, 0"), floor(0.5)));
    all(&mut family, "plane under the sky", &plane, RHO * 2.0, 64, 0.02);
    oracles(&mut family, "plane under the sky", &plane, RHO * 2.0, 1024, 0.04);
    let empty = scene(&format!("{}{}{sky}", at_point("0, 0, 2", "1, 1, 7"), floor(0.5)));
    all(&mut family, "the sky itself", &empty, 2.0, 1, 1e-6);
    // A glass ball passes on all that comes: before the uniform sky it vanishes.
    let camera = camera("0, 0, 5", "0, 0, 0", "0, 1, 0", 25.0, [4, 4]);
    let ball = scene(&format!(r#"{camera}{sky}<shape type="sphere"><bsdf type="dielectric"/></shape>"#));
    closed_form(&mut family, "path, glass ball", &ball, &Path, 2.0, 64, 0.03);
    closed_form(&mut family, "path-nee, glass ball", &ball, &PathNee, 2.0, 64, 0.03);
    closed_form(&mut family, "path-mis, glass ball", &ball, &PathMis::default(), 2.0, 64, 0.03);
    family.must_hold();
}

/// A lamp z = -3 that shines upwards, with something in front of it at z = 0.
fn before_a_lamp(from: &str, to: &str, what: &str) -> Scene {
    scene(&format!(
        r#"{}{what}<shape type="rectangle"><transform name="to_world"><scale value="60"/><translate z="-3"/></transform>{}{}</shape>"#,
        at_point(from, to),
        diffuse(0.0),
        area("2")
    ))
}

#[test]
fn a_mirror() {
    let mut family = Family::default();
    let mirror = r#"<shape type="rectangle"><transform name="to_world"><lookat origin="0, 0, 1" target="0, 0, 0" up="0, 1, 0"/></transform>
        <bsdf type="conductor"><string name="material" value="none"/></bsdf></shape>"#;
    let scene = before_a_lamp("1, 0, 0", "0, 0, 1", mirror);
    all(&mut family, "mirror", &scene, 2.0, 1, 1e-6);
    closed_form(&mut family, "oracle, mirror", &scene, &Oracle::default(), 2.0, 256, 0.1);
    family.must_hold();
}

/// A slab reflects to and fro within: T = (1 - R)²/(1 - R²) = (1 - R)/(1 + R). What radiance gains at one face it loses at the other.
#[test]
fn a_glass_slab() {
    let mut family = Family::default();
    let slab = r#"<shape type="cube"><transform name="to_world"><scale x="50" y="50" z="0.5"/></transform>
        <bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf></shape>"#;
    for degrees in [0.0, 45.0, 70.0] {
        let angle = f64::to_radians(degrees);
        let from = format!("{}, 0, {}", 5.0 * angle.sin(), 5.0 * angle.cos());
        let r = fresnel(angle.cos(), 1.5);
        let scene = before_a_lamp(&from, "0, 0, 0", slab);
        let expected = 2.0 * (1.0 - r) / (1.0 + r);
        // The direct solver sees one vertex only.
        closed_form(&mut family, &format!("path, slab at {degrees}°"), &scene, &Path, expected, 1024, 0.02);
        closed_form(&mut family, &format!("path-nee, slab at {degrees}°"), &scene, &PathNee, expected, 1024, 0.02);
        closed_form(&mut family, &format!("path-mis, slab at {degrees}°"), &scene, &PathMis::default(), expected, 1024, 0.02);
        // The series, bounce by bounce: two passages without reflection are 3 edges.
        let job = samples(1024).with(PathRules::default().with_bounces(2..=2));
        let first = 2.0 * (1.0 - r) * (1.0 - r);
        closed_form_by(&mut family, &format!("path, first term at {degrees}°"), &scene, &Path, first, job, 0.02);
    }
    family.must_hold();
}

/// A single face: radiance over η² is kept, so light that leaves glass is spread, and light that enters is concentrated.
#[test]
fn a_glass_face() {
    let mut family = Family::default();
    let face = |z: i32| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><scale value="50"/><lookat origin="0, 0, 0" target="0, 0, {z}" up="0, 1, 0"/></transform>
            <bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf></shape>"#
        )
    };
    let angle = 30f64.to_radians();
    let from = format!("{}, 0, {}", 5.0 * angle.sin(), 5.0 * angle.cos());
    // From air into glass, where the lamp is; and the other way round.
    let r = fresnel(angle.cos(), 1.5);
    let lamp_in_glass = 2.0 * (1.0 - r) / (1.5 * 1.5);
    let r = fresnel(angle.cos(), 1.0 / 1.5);
    let lamp_in_air = 2.0 * (1.0 - r) * (1.5 * 1.5);
    for (z, expected) in [(1, lamp_in_glass), (-1, lamp_in_air)] {
        let scene = before_a_lamp(&from, "0, 0, 0", &face(z));
        for (name, pictures) in [
            ("path", replicates(&scene, &Path, samples(1024))),
            ("path-nee", replicates(&scene, &PathNee, samples(1024))),
            ("path-mis", replicates(&scene, &PathMis::default(), samples(1024))),
        ] {
            family.expect(format!("{name}, face towards {z}"), &mean_of(&pictures, 0), expected, 0.02);
        }
    }
    family.must_hold();
}

/// Half of a mask's light goes on, in the shadow as well as to the eye; a null surface is not there.
#[test]
fn masks_and_nothing() {
    let mut family = Family::default();
    let screen = |bsdf: &str| {
        scene(&format!(
            r#"{}{}<emitter type="point"><point name="position" value="0, 0, 2"/><rgb name="intensity" value="3"/></emitter>
            <shape type="rectangle"><transform name="to_world"><translate z="1"/></transform>{bsdf}</shape>"#,
            at_point("4, 0, 1.5", "0, 0, 0"),
            floor(0.5)
        ))
    };
    let unhindered = RHO * 3.0 / 4.0 / PI;
    // A black screen sends nothing back.
    let half = screen(&format!(r#"<bsdf type="mask"><float name="opacity" value="0.25"/>{}</bsdf>"#, diffuse(0.0)));
    let null = screen(r#"<bsdf type="null"/>"#);
    for null_counts in [true, false] {
        let job = samples(4).with(PathRules { null_counts, ..PathRules::default() });
        for (name, scene, share) in [("mask", &half, 0.75), ("null", &null, 1.0)] {
            let name = format!("{name}, null counts: {null_counts}");
            closed_form_by(&mut family, &format!("path-nee, {name}"), scene, &PathNee, share * unhindered, job, 1e-5);
            closed_form_by(&mut family, &format!("path-mis, {name}"), scene, &PathMis::default(), share * unhindered, job, 1e-5);
            // Two edges reach the light only if the screen's crossing is none of them.
            let reached = if null_counts { 0.0 } else { share * unhindered };
            closed_form_by(
                &mut family,
                &format!("path-mis, 2 edges, {name}"),
                scene,
                &PathMis::default(),
                reached,
                job.edges(2),
                1e-5,
            );
            // `direct` counts crossings always.
            closed_form_by(
                &mut family,
                &format!("direct, {name}"),
                scene,
                &Direct { emitter_samples: 1, bsdf_samples: 1 },
                0.0,
                job,
                1e-5,
            );
        }
    }
    family.must_hold();
}

/// What lies behind null surfaces is seen with one edge where they are none, whatever the solver.
#[test]
fn a_lamp_behind_nothing() {
    let mut family = Family::default();
    let scene = before_a_lamp("0, 0, 5", "0, 0, 0", r#"<shape type="rectangle"><bsdf type="null"/></shape>"#);
    for (null_counts, edges, expected) in [(true, 1, 0.0), (true, 2, 2.0), (false, 1, 2.0)] {
        let job = samples(1).with(PathRules { null_counts, max_edges: edges, ..PathRules::default() });
        let name = format!("{edges} edges, null counts: {null_counts}");
        closed_form_by(&mut family, &format!("path, {name}"), &scene, &Path, expected, job, 1e-6);
        closed_form_by(&mut family, &format!("path-nee, {name}"), &scene, &PathNee, expected, job, 1e-6);
        closed_form_by(&mut family, &format!("path-mis, {name}"), &scene, &PathMis::default(), expected, job, 1e-6);
        let oracle = Oracle { absorption: 0.0, ..Oracle::default() };
        closed_form_by(&mut family, &format!("oracle, {name}"), &scene, &oracle, expected, job, 1e-6);
    }
    family.must_hold();
}
