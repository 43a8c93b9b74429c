//! Light tracing against path tracing: the same light from either end.
//!
//! ```text
//! I = ⟨We, L⟩ = ⟨W, Le⟩
//! ```
//!
//! Each test is one family of claims with 1 % of false alarms, over independent replicates.

mod common;

use common::checks::{agreement, neumann};
use common::*;
use etendue_numerics::{Sampler, SequenceKind};
use etendue_scene::Scene;
use etendue_solvers::drivers::{Books, ParticleSolver, particles};
use etendue_solvers::light::Light;
use etendue_solvers::light_nee::LightNee;
use etendue_solvers::oracle_light::LightOracle;
use etendue_solvers::path::Path;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::path_nee::PathNee;
use etendue_solvers::solver::Needs;
use etendue_solvers::transport::{LightContext, Tally};
use etendue_solvers::{Balance, CancelToken, Checkpoint, Event, PathRules, Progress, Run, Solver, Stop, Stopped, Work};
use std::sync::Mutex;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

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

fn from_above() -> String {
    camera("0, 0.4, 0", "0, 0, 0", "0, 0, 1", 100.0, SIZE)
}

/// Light focused by smooth and rough glass: refraction's 1/η² is the eye's alone.
#[test]
fn caustics_of_glass() {
    let mut family = Family::default();
    let lamp = format!(
        r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><scale value="0.6"/><translate y="2"/></transform>{}</shape>"#,
        area("9, 8, 7")
    );
    let rules = PathRules { max_edges: 7, ..PathRules::default() };
    for (name, glass) in [
        ("smooth", r#"<bsdf type="dielectric"/>"#),
        ("rough", r#"<bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf>"#),
        ("a mirror", r#"<bsdf type="conductor"><string name="material" value="Au"/></bsdf>"#),
    ] {
        let ball = format!(
            r#"<shape type="sphere"><point name="center" value="0, 0.9, 0"/><float name="radius" value="0.35"/>{glass}</shape>"#
        );
        let scene = floor_scene(&from_above(), &diffuse(0.6), &format!("{lamp}{ball}"));
        agrees(&mut family, name, &scene, rules, [192, 0, 256], 0.4);
    }
    family.must_hold();
}

/// A tank of glass with a lamp above: a diffuse floor seen through a rough interface, inside which flux is not radiance over η².
#[test]
fn light_within_glass() {
    let mut family = Family::default();
    let scene = scene(&format!(
        r#"{}
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="2"/></transform>
            <bsdf type="roughdielectric"><float name="alpha" value="0.4"/><float name="int_ior" value="1.5"/></bsdf></shape>
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="2"/><translate y="-0.5"/></transform>{}</shape>
        <shape type="sphere"><point name="center" value="-1, 1, 0.3"/><float name="radius" value="0.3"/>{}</shape>"#,
        camera("0, 1.5, -1.5", "0, 0, 0", "0, 1, 0", 45.0, SIZE),
        diffuse(0.8),
        area("8, 9, 5")
    ));
    let rules = PathRules { max_edges: 6, ..PathRules::default() };
    agrees(&mut family, "tank", &scene, rules, [768, 0, 512], 0.5);
    family.must_hold();
}

fn bumps(name: &str, strength: f32) -> String {
    let bumps: Vec<[f32; 3]> = (0..64)
        .map(|i| {
            let (x, y) = ((i % 8) as f32, (i / 8) as f32);
            let (nx, ny) = (strength * (2.1 * x + y).sin(), strength * (1.3 * y - x).cos());
            let nz = (1.0 - nx * nx - ny * ny).sqrt();
            [0.5 + 0.5 * nx, 0.5 + 0.5 * ny, 0.5 + 0.5 * nz]
        })
        .collect();
    picture_file(name, 8, &bumps)
}

/// Shading normals of every origin: textures on reflecting and refracting surfaces, and vertices.
#[test]
fn bent_normals() {
    let mut family = Family::default();
    let lamp = format!(
        r#"<shape type="rectangle"><transform name="to_world"><lookat origin="-2, 1.5, 0" target="0, 0, 0" up="0, 1, 0"/></transform>{}{}</shape>"#,
        diffuse(0.3),
        area("5, 4, 3")
    );
    let camera = camera("0, 1.5, -3", "0, 0, 0", "0, 1, 0", 50.0, SIZE);
    let map = |inner: &str| {
        format!(
            r#"<bsdf type="normalmap"><texture type="bitmap" name="normalmap"><string name="filename" value="{}"/>
                <boolean name="raw" value="true"/></texture>{inner}</bsdf>"#,
            bumps("light-bumps", 0.4)
        )
    };
    let plastic = r#"<bsdf type="roughplastic"><rgb name="diffuse_reflectance" value="0.5, 0.3, 0.2"/><float name="alpha" value="0.4"/></bsdf>"#;
    let glass = r#"<bsdf type="roughdielectric"><float name="alpha" value="0.4"/></bsdf>"#;
    let rules = PathRules { max_edges: 4, ..PathRules::default() };
    let ball = |bsdf: &str| {
        format!(
            r#"<shape type="sphere"><point name="center" value="0.8, 0.6, 0"/><float name="radius" value="0.5"/>{bsdf}</shape>"#
        )
    };
    for (name, floor, inside) in [
        ("plastic floor", map(plastic), String::new()),
        ("glass ball", diffuse(0.5), ball(&map(glass))),
        (
            "mirror over the floor",
            diffuse(0.5),
            format!(
                r#"<shape type="rectangle"><transform name="to_world"><scale value="1"/><rotate y="1" angle="180"/><translate y="0.5" z="4"/></transform>{}</shape>"#,
                map(plastic)
            ),
        ),
    ] {
        agrees(&mut family, name, &floor_scene(&camera, &floor, &format!("{lamp}{inside}")), rules, [256, 0, 128], 0.4);
    }
    family.must_hold();
}

/// Rough glass with bent normals before a lamp: hit by walks, found by light samples, and from the lamp. Once light samples took the cosine to the
/// bent normal on the eye's side of it, and lost 6 %.
#[test]
fn bent_rough_glass_from_both_ends() {
    let scene = scene(&format!(
        r#"{}<shape type="rectangle"><transform name="to_world"><scale value="2"/></transform>
            <bsdf type="normalmap"><texture type="bitmap" name="normalmap"><string name="filename" value="{}"/><boolean name="raw" value="true"/></texture>
            <bsdf type="roughdielectric"><float name="alpha" value="0.4"/></bsdf></bsdf></shape>
        <shape type="rectangle"><transform name="to_world"><lookat origin="0.5, 0.3, -1.5" target="0, 0, 0" up="0, 1, 0"/></transform>{}</shape>"#,
        camera("0, 0, 3", "0, 0, 0", "0, 1, 0", 40.0, SIZE),
        bumps("light-glass", 0.5),
        area("5, 4, 3")
    ));
    let job = |spp: u32| samples(spp).edges(2);
    let mut family = Family::default();
    let reference = replicates(&scene, &PathNee, job(512));
    agreement(&mut family, "path", &scene, &replicates(&scene, &Path, job(512).seed(2)), &reference, 0.3);
    agreement(&mut family, "light-nee", &scene, &replicates(&scene, &LightNee, job(1024).seed(3)), &reference, 0.3);
    family.must_hold();
}

#[test]
fn every_kind_of_light() {
    let mut family = Family::default();
    let sky: Vec<[f32; 3]> = (0..128)
        .map(|i| if matches!(i, 20 | 21 | 36 | 37) { [20.0, 16.0, 9.0] } else { [0.3, 0.4, 0.1 + 0.005 * i as f32] })
        .collect();
    let stripes = picture_file("light-stripes", 2, &[[0.0; 3], [6.0, 4.0, 1.0], [0.0, 5.0, 0.0], [0.0; 3]]);
    let texture = |name: &str| {
        format!(
            r#"<texture type="bitmap" name="{name}"><string name="filename" value="{stripes}"/>
                <boolean name="raw" value="true"/><string name="filter_type" value="nearest"/></texture>"#
        )
    };
    let down = r#"<transform name="to_world"><lookat origin="0.3, 1.5, 0" target="0, 0, 0.1" up="0, 0, 1"/></transform>"#;
    let lights = [
        ("point", r#"<emitter type="point"><point name="position" value="0.3, 1, 0"/></emitter>"#.to_owned()),
        ("spot", format!(r#"<emitter type="spot">{down}<float name="cutoff_angle" value="30"/></emitter>"#)),
        (
            "projector",
            format!(
                r#"<emitter type="projector">{down}<float name="fov" value="70"/><float name="scale" value="9"/>{}</emitter>"#,
                texture("irradiance")
            ),
        ),
        ("directional", r#"<emitter type="directional"><vector name="direction" value="0.3, -1, 0.2"/></emitter>"#.to_owned()),
        ("constant", r#"<emitter type="constant"><rgb name="radiance" value="0.5, 1, 2"/></emitter>"#.to_owned()),
        (
            "envmap",
            format!(
                r#"<emitter type="envmap"><string name="filename" value="{}"/></emitter>"#,
                picture_file("light-sky", 16, &sky)
            ),
        ),
        (
            "textured lamp",
            format!(
                r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><scale value="0.7"/><translate y="1.2"/></transform>
                <emitter type="area">{}</emitter></shape>"#,
                texture("radiance")
            ),
        ),
        (
            "mesh lamp",
            format!(
                r#"<shape type="cube"><transform name="to_world"><scale value="0.2"/><translate y="1" x="0.5"/></transform>{}</shape>"#,
                area("4, 5, 6")
            ),
        ),
    ];
    let things = format!(
        r#"<shape type="sphere"><point name="center" value="-0.4, 0.4, 0"/><float name="radius" value="0.3"/>{}</shape>"#,
        diffuse(0.7)
    );
    let rules = PathRules { max_edges: 5, ..PathRules::default() };
    // The cameras stand within and without the sphere around the scene, whose surroundings set out from it.
    let near = camera("0, 1.5, -2.5", "0, 0.4, 0", "0, 1, 0", 60.0, SIZE);
    let far = lens("0, 4, -9", "0, 0.4, 0", 40.0, 0.7, 9.0, SIZE, BOX);
    for (name, light) in &lights {
        let at = |camera: &str| floor_scene(camera, &diffuse(0.6), &format!("{light}{things}"));
        agrees(&mut family, &format!("{name}, near"), &at(&near), rules, [192, 0, 64], 0.6);
        agrees(&mut family, &format!("{name}, far"), &at(&far), rules, [192, 0, 64], 0.9);
    }
    family.must_hold();
}

/// Cut-outs and null surfaces, before the lamp and before the lens; hidden emitters.
#[test]
fn masks_and_hidden_emitters() {
    let mut family = Family::default();
    let inside = r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><scale value="0.8"/><translate y="0.2"/></transform>
            <bsdf type="mask"><texture type="checkerboard" name="opacity">
                <rgb name="color0" value="0.2"/><rgb name="color1" value="0.9"/></texture>
                <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.2, 0.6, 0.6"/></bsdf></bsdf></bsdf></shape>
        <shape type="cube"><transform name="to_world"><scale value="0.3"/><translate y="-0.6"/></transform><bsdf type="null"/></shape>"#;
    let lens = lens("0, 0, -0.9", "0, 0, 1", 80.0, 0.4, 1.0, SIZE, BOX);
    for (hide_emitters, null_counts, max_edges) in [(false, true, 3), (false, false, 3), (true, true, 6), (true, false, 3)] {
        let rules = PathRules { null_counts, max_edges, hide_emitters, ..PathRules::default() };
        let name = format!("masks, {max_edges} edges, null counts: {null_counts}, hidden: {hide_emitters}");
        agrees(&mut family, &name, &room(&eye(), inside), rules, [256, 0, 64], 0.9);
        agrees(&mut family, &name, &room(&lens, inside), rules, [0, 512, 64], 1.5);
    }
    family.must_hold();
}

/// A window of the film, and a filter wider than a pixel: the border loses nothing.
#[test]
fn crops_and_filters() {
    let mut family = Family::default();
    let film = r#"<integer name="crop_offset_x" value="3"/><integer name="crop_offset_y" value="5"/>
        <integer name="crop_width" value="8"/><integer name="crop_height" value="8"/><rfilter type="gaussian"/>"#;
    let crop = camera_with("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [16, 16], film);
    let lens = lens("0, 0, -0.9", "0, 0, 1", 80.0, 0.4, 1.0, [16, 16], film);
    let rules = PathRules { max_edges: 3, ..PathRules::default() };
    agrees(&mut family, "crop", &room(&crop, ""), rules, [1024, 0, 64], 0.6);
    agrees(&mut family, "crop, lens", &room(&lens, ""), rules, [0, 2048, 64], 0.9);
    let sky = floor_scene(
        &camera_with("0, 1.5, -2.5", "0, 0.4, 0", "0, 1, 0", 60.0, [16, 16], film),
        &diffuse(0.6),
        r#"<emitter type="constant"/>"#,
    );
    agrees(&mut family, "crop, sky", &sky, rules, [256, 0, 64], 0.9);
    family.must_hold();
}

/// What the eye sees in mirrors cannot be connected to the lens; without a lens nothing passes it.
#[test]
fn refusals() {
    let ball = |bsdf: &str| {
        format!(r#"<shape type="sphere"><point name="center" value="0, 0, 0.3"/><float name="radius" value="0.3"/>{bsdf}</shape>"#)
    };
    let lens = lens("0, 0, -0.9", "0, 0, 1", 80.0, 0.4, 1.0, SIZE, BOX);
    let masked = |inner: &str| format!(r#"<bsdf type="mask"><float name="opacity" value="0.5"/>{inner}</bsdf>"#);
    for (bsdf, refused) in [
        (r#"<bsdf type="dielectric"/>"#.to_owned(), true),
        (r#"<bsdf type="conductor"/>"#.to_owned(), true),
        (r#"<bsdf type="plastic"/>"#.to_owned(), true),
        (masked(r#"<bsdf type="conductor"/>"#), true),
        (masked(&diffuse(0.5)), false),
        (r#"<bsdf type="null"/>"#.to_owned(), false),
        (r#"<bsdf type="roughconductor"/>"#.to_owned(), false),
    ] {
        let answer = LightNee.needs().check(&room(&eye(), &ball(&bsdf)));
        assert_eq!(answer.is_err(), refused, "{bsdf}: {answer:?}");
    }
    let behind = ball(r#"<bsdf type="dielectric"/>"#).replace("0, 0, 0.3", "0, 0, -4");
    assert!(LightNee.needs().check(&room(&eye(), &behind)).is_ok());
    assert!(Light.needs().check(&room(&lens, &ball(r#"<bsdf type="dielectric"/>"#))).is_ok());
    let refusal = Light.needs().check(&room(&eye(), "")).expect_err("a pinhole is never hit");
    assert!(refusal.reason.contains("perspective") && refusal.instead.contains(&"light-nee"), "{refusal:?}");
    assert!(Light.needs().check(&room(&orthographic("0, 0, -0.95", "0, 0, 1", 0.8), "")).is_err());
}

/// In a closed box what is emitted is absorbed; roulette and its survivors cancel.
#[test]
fn the_books_are_balanced() {
    let close = |a: [f64; 3], b: f64, within: f64, what: &str| {
        assert!(a.iter().all(|a| (a - b).abs() <= within), "{what}: {a:?}, expected {b}");
    };
    for a in [0.2f32, 0.9] {
        let scene = furnace_seen_by(&camera("0, 0, -0.5", "0.1, 0.2, 1", "0, 1, 0", 70.0, [16, 16]), "sphere", a);
        let flux = 4.0 * std::f64::consts::PI.powi(2);
        // Every bounce absorbs 1 - a of what arrives; after three edges a walk of four is cut.
        for (max_edges, absorbed, cut) in [(u32::MAX, 1.0, 0.0), (4, 1.0 - f64::from(a).powi(3), f64::from(a).powi(3))] {
            let (_, outcome) = render(&scene, &LightNee, samples(128).edges(max_edges));
            let books = outcome.books.expect("books");
            close(books.emitted, flux, 1e-4 * flux, "emitted");
            close(books.absorbed, absorbed * flux, 2e-2 * flux, "absorbed");
            close(books.cut, cut * flux, 2e-2 * flux, "cut");
            close(books.escaped, 0.0, 1e-9, "escaped");
            close(books.residual, 0.0, 1e-4, "residual");
        }
    }
    let open = scene(&format!(
        r#"{}<shape type="rectangle">{}</shape><emitter type="point"><point name="position" value="0, 0, 3"/></emitter>"#,
        eye(),
        diffuse(0.5)
    ));
    let books = render(&open, &LightNee, samples(256)).1.books.expect("books");
    close(books.emitted, 4.0 * std::f64::consts::PI, 1e-6, "emitted");
    // A square of side 2 seen from 3 away: Ω = 4 asin(1/10) [a rectangle's solid angle, from above its centre].
    close(books.absorbed, 0.5 * 4.0 * (0.1f64).asin(), 2e-2, "absorbed");
    close(books.escaped, 4.0 * std::f64::consts::PI - 0.5 * 4.0 * (0.1f64).asin(), 2e-2, "escaped");
}

/// The textbook's particles arrive at the same picture, bounce by bounce.
#[test]
fn the_oracle_agrees() {
    let mut family = Family::default();
    for bounces in [0..=0, 1..=1, 2..=3] {
        let job = |spp: u32| samples(spp).with(PathRules::default().with_bounces(bounces.clone()));
        let scene = room(&eye(), "");
        let reference = replicates(&scene, &LightNee, job(256).seed(4));
        let oracle = replicates(&scene, &LightOracle { absorption: 0.2 }, job(512).seed(5));
        agreement(&mut family, &format!("oracle, {bounces:?}"), &scene, &oracle, &reference, 0.6);
    }
    family.must_hold();
}

fn bits(film: &etendue_film::Film) -> Vec<u32> {
    film.develop().iter().flatten().map(|x| x.to_bits()).collect()
}

/// Films of several chunks and bands, a wide filter, a crop: the same bits on any number of threads.
#[test]
fn threads_do_not_matter() {
    let film = r#"<integer name="crop_offset_x" value="3"/><integer name="crop_offset_y" value="5"/>
        <integer name="crop_width" value="61"/><integer name="crop_height" value="50"/><rfilter type="gaussian"/>"#;
    let scene = room(&lens("0, 0, -0.9", "0, 0, 1", 80.0, 0.4, 1.0, [80, 60], film), "");
    for stop in [Stop::Samples(3), Stop::Noise { percent: 1e-9, limit: 16 }] {
        let at = |threads: usize| {
            let job = Job { stop, threads, ..samples(0) };
            let ((nee, a), (light, b)) = (render(&scene, &LightNee, job), render(&scene, &Light, job));
            (bits(&nee), bits(&light), a.books, b.books, a.noise.map(|n| n.rel_mse.to_bits()))
        };
        let once = at(1);
        for threads in [2, 5] {
            assert!(at(threads) == once, "{threads} threads, {stop:?}");
        }
    }
}

/// Light tracing that asks for its own cancellation in the middle of a pass.
struct Interrupted<'a> {
    run: (&'a CancelToken, &'a Progress),
    at: Option<(u32, u64)>,
}

impl ParticleSolver for Interrupted<'_> {
    fn shoot(&self, c: &LightContext<'_>, u: &Sampler, tally: &mut Tally) {
        let (cancel, progress) = self.run;
        if let Some((pass, units)) = self.at
            && progress.passes.load(Relaxed) >= u64::from(pass)
            && progress.tiles.load(Relaxed) >= units
        {
            cancel.cancel();
        }
        LightNee.shoot(c, u, tally);
    }

    fn reach(&self, max_edges: u32) -> u32 {
        LightNee.reach(max_edges)
    }
}

impl Solver for Interrupted<'_> {
    type State = Books;

    fn needs(&self) -> Needs {
        LightNee.needs()
    }

    fn units(&self, size: [u32; 2]) -> usize {
        particles::units(size)
    }

    fn prepare(&self, _: &Scene, _: &Run<'_>) -> Books {
        Books::default()
    }

    fn pass(&self, scene: &Scene, run: &Run<'_>, books: &mut Books, k: u32, work: &Work<'_>) {
        particles::pass(self, scene, run, books, k, work);
    }

    fn books(&self, books: &Books) -> Option<Balance> {
        Some(books.balance())
    }
}

/// Stopped within a pass and resumed from bytes, twice: the same picture and the same books.
#[test]
fn stopped_and_resumed_is_undisturbed() {
    let scene = room(&camera("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [72, 60]), "");
    let pool = threads(2);
    let session = |at: Option<(u32, u64)>, resume: Option<&[u8]>| {
        let (cancel, progress) = (CancelToken::default(), Progress::default());
        let last = Mutex::new(Vec::new());
        let events = |event: Event<'_>| {
            if let Event::Checkpoint(checkpoint) = event {
                *last.lock().expect("unpoisoned") = checkpoint.to_bytes();
            }
        };
        let run = Run {
            view: 0,
            seed: 3,
            sequence: SequenceKind::Sobol,
            stop: Stop::Samples(4),
            rules: PathRules::default(),
            digest: 9,
            pool: &pool,
            cancel: &cancel,
            progress: &progress,
            events: &events,
            checkpoint_every: Some(Duration::from_secs(3600)),
        };
        let checkpoint = resume.map(|bytes| Checkpoint::from_bytes(bytes).expect("a checkpoint"));
        let film = blank(&scene);
        let solver = Interrupted { run: (&cancel, &progress), at };
        let outcome = etendue_solvers::render(&solver, "test", &scene, &run, &film, checkpoint.as_ref()).expect("runs");
        let bytes = last.lock().expect("unpoisoned").clone();
        (bits(&film), outcome, bytes)
    };
    let (undisturbed, whole, _) = session(None, None);
    let (first, stopped, bytes) = session(Some((0, 2)), None);
    assert_eq!((stopped.stopped, stopped.passes), (Stopped::Cancelled, 0));
    assert!(first != undisturbed);
    let (_, stopped, bytes) = session(Some((2, 1)), Some(&bytes));
    assert_eq!((stopped.stopped, stopped.passes), (Stopped::Cancelled, 2));
    let (finished, end, _) = session(None, Some(&bytes));
    assert_eq!((end.stopped, end.passes, end.books), (Stopped::Samples, 4, whole.books));
    assert!(finished == undisturbed);
}
