//! Kinds of lights, surfaces and films; what is refused.

use super::*;
use etendue_solvers::Solver;

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
        let answer = Solver::needs(&LightNee).check(&room(&eye(), &ball(&bsdf)));
        assert_eq!(answer.is_err(), refused, "{bsdf}: {answer:?}");
    }
    let behind = ball(r#"<bsdf type="dielectric"/>"#).replace("0, 0, 0.3", "0, 0, -4");
    assert!(Solver::needs(&LightNee).check(&room(&eye(), &behind)).is_ok());
    assert!(Solver::needs(&Light).check(&room(&lens, &ball(r#"<bsdf type="dielectric"/>"#))).is_ok());
    let refusal = Solver::needs(&Light).check(&room(&eye(), "")).expect_err("a pinhole is never hit");
    assert!(refusal.reason.contains("perspective") && refusal.instead.contains(&"light-nee"), "{refusal:?}");
    assert!(Solver::needs(&Light).check(&room(&orthographic("0, 0, -0.95", "0, 0, 1", 0.8), "")).is_err());
}
