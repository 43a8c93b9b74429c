//! E of patches from lights that are no patches: points, spots, single directions and surroundings, against their laws.

mod common;

use common::*;
use etendue_radiosity::patch::PatchSize;
use etendue_radiosity::solve::lights;
use etendue_radiosity::solved::{Settings, Solved};
use etendue_scene::Scene;
use glam::DVec3;
use std::f64::consts::PI;

#[test]
fn a_point_light_gives_what_its_law_says() {
    // E = I cosθ / r² at the middle of a small patch, and Φ of a closed ball of patches is 4π I.
    let light = r#"<emitter type="point"><rgb name="intensity" value="1, 2, 3"/></emitter>"#;
    let ball = scene(&(shape("sphere", r#"<scale value="2"/>"#, FLIPPED) + light));
    let patches = cut(&ball, PatchSize::Metres(0.5));
    let e = lights::irradiance(&ball, &patches, 7);
    let flux: DVec3 = e.iter().zip(&patches.patches).map(|(e, p)| *e * p.area).sum();
    assert!((flux - 4.0 * PI * DVec3::new(1.0, 2.0, 3.0)).abs().max_element() < 1e-4, "{flux}");
    assert!(e.iter().all(|e| (e.x - 0.25).abs() < 1e-5));
    // Surroundings of radiance L give π L where nothing is in the way, and nothing within a closed ball.
    let sky = r#"<emitter type="constant"><rgb name="radiance" value="2"/></emitter>"#;
    let open = scene(&(shape("sphere", "", "") + sky));
    let patches = cut(&open, PatchSize::Metres(0.5));
    let e = lights::irradiance(&open, &patches, 3);
    let mean = e.iter().zip(&patches.patches).map(|(e, p)| e.x * p.area).sum::<f64>() / (4.0 * PI);
    assert!((mean / (2.0 * PI) - 1.0).abs() < 0.01, "{mean}");
}

/// E of the only patch of a scene, and B = ρ E of its solution.
fn alone(text: &str) -> DVec3 {
    let scene: Scene = scene(text);
    let solved = Solved::new(&scene, &Settings { size: PatchSize::Whole, rays: 64, ..Settings::default() }, &|_| true);
    let solved = solved.expect("a solution");
    let (e, b, patch) = (solved.direct[0], solved.solution.b[0], &solved.patches.patches[0]);
    assert_eq!(solved.patches.len(), 1);
    assert!((b - e * 0.5).abs().max_element() <= 1e-7 * e.max_element(), "B = {b} of E = {e}");
    let books = solved.equation().energy(&solved.solution.b);
    assert!(
        (books.arrived - e * patch.area).abs().max_element() < 1e-12 && books.residual.abs().max_element() <= 1e-6 * patch.area
    );
    e
}

/// A card of 1 cm on the floor, at a place.
fn card(place: &str) -> String {
    shape(
        "rectangle",
        &format!(r#"<scale value="0.005"/>{place}"#),
        r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf>"#,
    )
}

/// E = π L (R/d)² cosθ of a ball that shines unseen, which is no patch, and through which a second card is lit.
#[test]
fn an_unseen_ball_gives_what_its_law_says() {
    let ball = |z: f64| {
        format!(
            r#"<shape type="sphere"><point name="center" x="0" y="0" z="{z}"/><float name="radius" value="0.3"/><emitter type="area">
                <rgb name="radiance" value="1, 2, 3"/><boolean name="unseen" value="true"/></emitter></shape>"#
        )
    };
    let law = |z: f64| PI * (0.3 / z).powi(2) * DVec3::new(1.0, 2.0, 3.0);
    let e = alone(&(card("") + &ball(2.0) + &ball(4.0)));
    let expected = law(2.0) + law(4.0);
    assert!((e / expected - 1.0).abs().max_element() < 2e-3, "{e} instead of {expected}");
}

/// E = I(θ) cosθ' / d²: within the beam I, half of it in the middle of the rim, nothing beyond the cone, nothing from behind.
#[test]
fn a_spot_gives_what_its_law_says() {
    let spot = |from: DVec3, to: DVec3| {
        let words = |p: DVec3| format!("{},{},{}", p.x, p.y, p.z);
        format!(
            r#"<emitter type="spot"><transform name="to_world"><lookat origin="{}" target="{}" up="0,1,0"/></transform>
            <rgb name="intensity" value="3, 2, 1"/><float name="cutoff_angle" value="30"/><float name="beam_width" value="20"/></emitter>"#,
            words(from),
            words(to)
        )
    };
    let (i, from) = (DVec3::new(3.0, 2.0, 1.0), DVec3::new(1.0, 0.5, 2.0));
    // Aimed past the card by an angle.
    let aimed = |degrees: f64| {
        let (w, side) = (-from.normalize(), from.cross(DVec3::Y).normalize());
        let angle = degrees.to_radians();
        from + w * angle.cos() + side * angle.sin()
    };
    let law = i * from.z / from.length().powi(3);
    for (degrees, part) in [(0.0, 1.0), (15.0, 1.0), (25.0, 0.5), (28.0, 0.2), (31.0, 0.0)] {
        let e = alone(&(card("") + &spot(from, aimed(degrees))));
        // Means over 1 cm at 2 m: a few 1e-5 of the whole, and the rim is a tenth of I a degree.
        assert!((e - law * part).abs().max_element() < 1e-3 * law.x, "{degrees}°: {e} for {}", law * part);
    }
    let below = from * DVec3::new(1.0, 1.0, -1.0);
    assert_eq!(alone(&(card("") + &spot(below, DVec3::ZERO))), DVec3::ZERO, "from behind");
}

/// E = E0 cosθ, and none in a shadow.
#[test]
fn a_direction_gives_what_its_law_says() {
    let sun = r#"<emitter type="directional"><vector name="direction" x="0.6" y="0" z="-0.8"/><rgb name="irradiance" value="5, 4, 3"/></emitter>"#;
    let e0 = DVec3::new(5.0, 4.0, 3.0);
    for (turn, cos) in [("", 0.8), (r#"<rotate y="1" angle="-90"/>"#, 0.6), (r#"<rotate y="1" angle="90"/>"#, 0.0)] {
        let e = alone(&(card(turn) + sun));
        assert!((e - e0 * cos).abs().max_element() < 1e-5, "{e} for {}", e0 * cos);
    }
    // The shadow of a sheet of 2 x 2 m at a height of 1 m lies 0.75 m further along x: a quarter of the floor of 8 x 2 m.
    let sheet = shape("rectangle", r#"<translate z="1"/>"#, "");
    let floor = shape("rectangle", r#"<scale x="4"/>"#, "");
    let scene = scene(&(floor + &sheet + sun));
    let patches = cut(&scene, PatchSize::Metres(0.25));
    let e = lights::irradiance(&scene, &patches, 1);
    let floor = || e.iter().zip(&patches.patches).filter(|(_, p)| p.p.z < 0.5);
    for (e, p) in floor() {
        let [low, high] = [-0.25, 1.75].map(|x| p.p.x - x);
        // Fronts alone are patches, and patches end where the shadow does.
        let lit = if low > 0.0 && high < 0.0 { 0.0 } else { 4.0 };
        assert!((e.x - lit).abs() < 1e-5, "{e} at {}", p.p);
    }
    let flux: f64 = floor().map(|(e, p)| e.x * p.area).sum();
    assert!((flux - 4.0 * 12.0).abs() < 1e-3, "{flux} W");
}

/// E = π L under an open sky, whatever the turn; π L (1 - F) beside a black wall; and a picture of a sky whose lower half is dark.
#[test]
fn a_sky_gives_what_its_law_says() {
    let sky = r#"<emitter type="constant"><rgb name="radiance" value="2, 1, 0.5"/></emitter>"#;
    let l = DVec3::new(2.0, 1.0, 0.5);
    for turn in ["", r#"<rotate x="1" y="2" angle="70"/>"#, r#"<rotate x="1" angle="180"/>"#] {
        let e = alone(&(card(turn) + sky));
        // 64 directions of a scrambled set.
        assert!((e / (l * PI) - 1.0).abs().max_element() < 0.02, "{e} for {}", l * PI);
    }
    // Unit squares with an edge in common: F = 0.20004.
    let square = |turn: &str| shape("rectangle", &format!(r#"<scale value="0.5"/><translate x="0.5" y="0.5"/>{turn}"#), "");
    let black = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf>"#;
    let wall = shape(
        "rectangle",
        r#"<scale value="0.5"/><translate x="0.5" y="0.5"/><rotate y="1" angle="90"/><translate z="1"/>"#,
        black,
    );
    let scene = scene(&(square("") + &wall + sky));
    let patches = cut(&scene, PatchSize::Metres(0.05));
    let e = lights::irradiance(&scene, &patches, 2);
    let floor = patches.objects[0].patches.clone();
    let mean = floor.clone().map(|i| e[i as usize].x).sum::<f64>() / floor.len() as f64;
    let f = 1.0 / PI * (0.25 * 0.75f64.ln() + PI / 2.0 - 2f64.sqrt() * (1.0 / 2f64.sqrt()).atan());
    // 400 patches of 64 directions each.
    assert!((mean / (l.x * PI * (1.0 - f)) - 1.0).abs() < 3e-3, "{mean} for {}", l.x * PI * (1.0 - f));
}
