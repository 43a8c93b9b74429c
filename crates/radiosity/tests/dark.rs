//! Boxes of two-sided material on a floor: no light gets into them, none of the floor is dimmed by what is under them, and a lamp within is no mistake.

mod common;

use common::*;
use etendue_radiosity::patch::{Fault, PatchSize};
use etendue_radiosity::solved::{Settings, Solved};
use etendue_radiosity::{Patches, Side};

const GREY: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.6"/></bsdf>"#;
const TWO: &str = r#"<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.6"/></bsdf></bsdf>"#;

/// A room with a lamp under its ceiling, and more in it.
fn room(inside: &str) -> String {
    let lamp = r#"<scale value="0.4"/><rotate x="1" angle="180"/><translate z="0.9"/>"#;
    let glow = format!(r#"{GREY}<emitter type="area"><rgb name="radiance" value="3"/></emitter>"#);
    shape("cube", "", &(FLIPPED.to_owned() + GREY)) + &shape("rectangle", lamp, &glow) + inside
}

/// Sheets of two sides around a box of 0.8 x 0.8 x 0.6 m that stands in the middle of the floor; `turned`, with their backs outside.
fn sheets(bottom: bool, turned: bool) -> String {
    let turn = if turned { r#"<rotate x="1" angle="180"/>"# } else { "" };
    let sides = ["", r#"<rotate x="1" angle="90"/>"#, r#"<rotate x="1" angle="-90"/>"#, r#"<rotate y="1" angle="90"/>"#]
        .into_iter()
        .chain([r#"<rotate y="1" angle="-90"/>"#, r#"<rotate x="1" angle="180"/>"#]);
    let place = r#"<scale x="0.4" y="0.4" z="0.3"/><translate z="-0.7"/>"#;
    let sheet = |side: &str| shape("rectangle", &format!(r#"{turn}<translate z="1"/>{side}{place}"#), TWO);
    sides.take(if bottom { 6 } else { 5 }).map(sheet).collect()
}

fn solved(inside: &str) -> Solved {
    let settings = Settings { size: PatchSize::Metres(0.22), rays: 1024, ..Settings::default() };
    Solved::new(&scene(&room(inside)), &settings, &|_| true).expect("a solution")
}

/// How many patches lie within the box and look inwards.
fn inside(patches: &Patches) -> usize {
    let middle = glam::DVec3::new(0.0, 0.0, -0.7);
    let within = |p: &&etendue_radiosity::patch::Patch| {
        let d = p.p - middle;
        d.abs().cmple(glam::DVec3::new(0.401, 0.401, 0.301)).all() && p.n.dot(d) < 0.0 && p.p.z > -0.999
    };
    patches.patches.iter().filter(within).count()
}

/// A solid box, one of two sides, and boxes of sheets leave the same light in the room: patch by patch within the noise of 1024 rays, in the books within 1 %.
#[test]
fn all_boxes_are_alike() {
    let place = r#"<scale x="0.4" y="0.4" z="0.3"/><translate z="-0.7"/>"#;
    let judge = solved(&shape("cube", place, GREY));
    let floor = judge.patches.objects[0].patches.clone();
    for (name, text, dark) in [
        ("a cube of two sides", shape("cube", place, TWO), 1),
        ("six sheets", sheets(true, false), 6),
        ("six sheets, turned", sheets(true, true), 6),
        ("five sheets", sheets(false, false), 5),
        ("five sheets, turned", sheets(false, true), 5),
    ] {
        let found = solved(&text);
        let told = found.patches.faults.iter().filter(|f| matches!(f, Fault::Dark { .. })).count();
        assert_eq!((told, inside(&found.patches)), (dark, 0), "{name}: {:?}", found.patches.faults);
        let (mut worst, mut sum) = (0.0f64, 0.0);
        for i in floor.clone().map(|i| i as usize) {
            let (a, b) = (&judge.patches.patches[i], &found.patches.patches[i]);
            assert!(a.p == b.p && (a.area - b.area).abs() < 0.05 * 0.22 * 0.22, "{name}: {} and {} m²", a.area, b.area);
            // What is covered has next to no area.
            if a.area > 0.2 * 0.22 * 0.22 {
                let off = found.solution.b[i].x / judge.solution.b[i].x - 1.0;
                (worst, sum) = (worst.max(off.abs()), sum + off.abs());
            }
        }
        assert!(
            worst < 0.06 && sum / (floor.len() as f64) < 0.008,
            "{name}: {worst} at most, {} on the whole",
            sum / floor.len() as f64
        );
        let [e, j] = [&found, &judge].map(|s| s.equation().energy(&s.solution.b));
        assert!((e.absorbed.x / j.absorbed.x - 1.0).abs() < 1e-2 && e.escaped.x < 1e-3 * e.emitted.x, "{name}: {e:?} {j:?}");
    }
}

/// A lamp in the box, of a surface or a point, and a hole in it: its inside is lit, and stays.
#[test]
fn what_is_lit_within_stays() {
    let lamp = shape(
        "rectangle",
        r#"<scale value="0.1"/><translate z="-0.8"/>"#,
        r#"<emitter type="area"><rgb name="radiance" value="1"/></emitter>"#,
    );
    let point =
        r#"<emitter type="point"><point name="position" x="0.1" y="0" z="-0.7"/><rgb name="intensity" value="1"/></emitter>"#;
    let holed = sheets(false, false).replacen(r#"<scale x="0.4""#, r#"<scale x="0.36""#, 1);
    for (name, text) in [("a lamp", sheets(false, false) + &lamp), ("a point", sheets(false, false) + point), ("a slit", holed)] {
        let patches = cut(&scene(&room(&text)), PatchSize::Metres(0.4));
        assert!(!patches.faults.iter().any(|f| matches!(f, Fault::Dark { .. })), "{name}: {:?}", patches.faults);
        assert!(inside(&patches) > 5, "{name}");
    }
    // Without any light nothing is known to be dark.
    let unlit = scene(&(shape("cube", "", FLIPPED) + &sheets(false, false)));
    let backs = cut(&unlit, PatchSize::Whole).patches.iter().filter(|p| p.side == Side::Back).count();
    assert_eq!(backs, 5);
}
