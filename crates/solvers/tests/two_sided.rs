//! Lamps that shine to both sides: walks from the eye, walks from the lights, both connected, and photons must find the same light.
//!
//! Means of independent scrambles, one family of claims with 1 % of false alarms; photons are held to what their radius blurs.

mod common;

use common::checks::agreement;
use common::worlds::{WALLS, eye, room};
use common::*;
use etendue_scene::Scene;
use etendue_solvers::bidirectional::Bidirectional;
use etendue_solvers::light_nee::LightNee;
use etendue_solvers::metropolis::Metropolis;
use etendue_solvers::path::Path;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::path_nee::PathNee;
use etendue_solvers::photon_map::PhotonMap;

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
    let scene = lamps();
    let reference = replicates(&scene, &PathMis::default(), samples(128));
    let mut family = Family::default();
    let mut compare = |name: &str, pictures: Vec<Picture>| agreement(&mut family, name, &scene, &pictures, &reference, 0.6);
    compare("path-nee", replicates(&scene, &PathNee, samples(160).seed(2)));
    compare("path", replicates(&scene, &Path, samples(256).seed(3)));
    compare("light-nee", replicates(&scene, &LightNee, samples(192).seed(4)));
    compare("bidirectional", replicates(&scene, &Bidirectional::default(), samples(64).seed(5)));
    compare("metropolis", replicates(&scene, &Metropolis::default(), samples(192).seed(6)));
    family.must_hold();
}

#[test]
fn photons_bring_the_same_light() {
    let scene = lamps();
    let solver = PhotonMap { photons: 4096, radius: 0.15, ..PhotonMap::default() };
    let reference = replicates(&scene, &PathMis::default(), samples(128));
    let photons = replicates(&scene, &solver, samples(32).seed(2));
    for channel in 0..3 {
        let (a, b) = (mean_of(&photons, channel), mean_of(&reference, channel));
        assert!((a.mean / b.mean - 1.0).abs() < 0.04, "channel {channel}: {} instead of {}", a.mean, b.mean);
    }
}
