//! Light bent by glass, and by normals that are not the surface's own.

use super::*;
use etendue_solvers::path::Path;
use etendue_solvers::path_nee::PathNee;

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
