//! Lamps that shine to both sides: walks from the eye, walks from the lights, both connected, and photons must find the same light.
//!
//! Means of independent scrambles, one family of claims with 1 % of false alarms; photons are held to what their radius blurs.

mod common;

use common::checks;
use common::worlds::{WALLS, eye, room};
use common::*;
use etendue_scene::Scene;

/// A plate that shines up and down in the middle of a room, and a smaller one that stands and shines from its front alone.
fn lamps() -> Scene {
    let lamp = |place: &str, radiance: &str, sides: bool| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world">{place}</transform><bsdf type="twosided">{}</bsdf>
                <emitter type="area"><rgb name="radiance" value="{radiance}"/><boolean name="two_sided" value="{sides}"/></emitter></shape>"#,
            diffuse(0.3)
        )
    };
    let flat = lamp(r#"<scale x="0.4" y="0.3"/><rotate x="1" angle="70"/><translate y="0.2" z="0.2"/>"#, "3, 4, 5", true);
    let standing =
        lamp(r#"<scale x="0.2" y="0.2"/><rotate y="1" angle="40"/><translate x="-0.6" y="-0.6" z="0.3"/>"#, "4, 2, 1", false);
    room(&eye(), WALLS, &(flat + &standing))
}

#[test]
fn solvers_agree() {
    checks::solvers_find_the_same(&lamps(), [128, 160, 256]);
}

#[test]
fn photons_bring_the_same_light() {
    checks::photons_bring_the_same_light(&lamps());
}
