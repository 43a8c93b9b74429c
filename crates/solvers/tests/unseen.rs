//! Lamps that shine unseen, and lamps with holes: every solver finds their light by the law of a ball, E = π L (R/d)² cosθ, and sees what is behind them.
//!
//! Means of independent scrambles; each test is one family of claims with 1 % of false alarms; photons are held to what their radius blurs.

mod common;

use common::checks::{self, at_point, closed_form, floor};
use common::worlds::{WALLS, eye, room, unseen};
use common::*;
use etendue_description::Diagnostics;
use etendue_formats::{ReadOptions, read_str};
use etendue_scene::Scene;
use etendue_solvers::Solver;
use etendue_solvers::bidirectional::Bidirectional;
use etendue_solvers::direct::Direct;
use etendue_solvers::path::Path;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::path_nee::PathNee;
use std::f64::consts::PI;

/// The point of a floor of albedo 1/2 right under a ball of radius 1/2 and radiance 3, 2 m above it; the eye looks at it through the ball, from above.
fn under_a_ball() -> Scene {
    let ball = r#"<shape type="sphere"><point name="center" x="0" y="0" z="2"/><float name="radius" value="0.5"/>
        <emitter type="area"><rgb name="radiance" value="3"/><boolean name="unseen" value="true"/></emitter></shape>"#;
    scene(&format!("{}{}{ball}", at_point("0, 0, 4", "0, 0, 0"), floor(0.5)))
}

#[test]
fn a_ball_gives_what_its_law_says() {
    let scene = under_a_ball();
    let expected = 0.5 / PI * (PI * 3.0 * (0.5f64 / 2.0).powi(2));
    let mut family = Family::default();
    closed_form(&mut family, "path-mis", &scene, &PathMis::default(), expected, 64, 0.02);
    closed_form(&mut family, "sharing", &scene, &PathMis { block: 2, ..PathMis::default() }, expected, 64, 0.02);
    closed_form(&mut family, "path-nee", &scene, &PathNee, expected, 64, 0.02);
    closed_form(&mut family, "direct", &scene, &Direct { emitter_samples: 1, bsdf_samples: 1 }, expected, 64, 0.02);
    closed_form(&mut family, "bidirectional", &scene, &Bidirectional::default(), expected, 64, 0.02);
    family.must_hold();
    let refusal = Path.needs().check(&scene).expect_err("no walk hits the lamp");
    assert!(refusal.reason.contains("unseen"), "{}", refusal.reason);
}

#[test]
fn solvers_agree() {
    checks::solvers_find_the_same(&room(&eye(), WALLS, &unseen()), [128, 160, 0]);
}

#[test]
fn photons_bring_the_same_light() {
    checks::photons_bring_the_same_light(&room(&eye(), WALLS, &unseen()));
}

/// A pbrt scene: a plate of radiance 1 and of the given `alpha` over a floor, seen from above.
fn plate(alpha: &str) -> Scene {
    let text = format!(
        "LookAt 0 0 4  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" .01\n\
         Film \"rgb\" \"integer xresolution\" 1 \"integer yresolution\" 1 PixelFilter \"box\"\n\
         WorldBegin\nMaterial \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\nShape \"disk\" \"float radius\" 50\n\
         Texture \"holes\" \"float\" \"constant\" \"float value\" .4\n\
         Texture \"none\" \"float\" \"constant\" \"float value\" 0\n\
         Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n\
         AttributeBegin Translate 0 0 2 AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] \"bool twosided\" true\n\
         Shape \"disk\" \"float radius\" 1 {alpha} AttributeEnd\n"
    );
    let (description, said) = read_str("plate.pbrt", &text, &ReadOptions::default());
    assert!(!said.has_errors(), "{}", said.render(&description.sources));
    let mut diagnostics = Diagnostics::default();
    let options = etendue_scene::CompileOptions::default();
    let scene = etendue_scene::compile(&description, &options, &mut diagnostics);
    scene.unwrap_or_else(|| panic!("{}", diagnostics.render(&description.sources)))
}

/// What is missing of a plate does not shine: with the opacity a the eye sees a L, and (1 - a) of the floor, which receives a E of the whole and
/// reflects nothing back to it.
#[test]
fn holes_do_not_shine() {
    // E of a disk over its middle: π sin²θ.
    let lit = 0.5 * (1.0 / 5.0);
    let mut family = Family::default();
    let plates = [("", 1.0), ("\"float alpha\" .4", 0.4), ("\"texture alpha\" \"holes\"", 0.4)];
    for (alpha, a) in plates {
        let expected = a + (1.0 - a) * a * lit;
        let scene = plate(alpha);
        closed_form(&mut family, &format!("{alpha}: path-mis"), &scene, &PathMis::default(), expected, 256, 0.02);
        closed_form(&mut family, &format!("{alpha}: path"), &scene, &Path, expected, 2048, 0.04);
        closed_form(&mut family, &format!("{alpha}: bidirectional"), &scene, &Bidirectional::default(), expected, 256, 0.04);
    }
    for alpha in ["\"float alpha\" 0", "\"texture alpha\" \"none\""] {
        closed_form(&mut family, &format!("{alpha}: path-mis"), &plate(alpha), &PathMis::default(), lit, 64, 0.02);
    }
    family.must_hold();
}
