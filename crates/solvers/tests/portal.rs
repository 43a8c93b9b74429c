//! Light through portals, before which a wall casts its shadow: walks that look for it, that run into it and that do both see the same, and so do walks from the light of a
//! single one; of several they refuse.
//!
//! Each is one family of claims with 1 % of false alarms; photons are held to what their radius blurs.

mod common;

use common::*;
use etendue_description::Diagnostics;
use etendue_formats::{ReadOptions, read_str};
use etendue_scene::{CompileOptions, Scene};
use etendue_solvers::Solver;
use etendue_solvers::bidirectional::Bidirectional;
use etendue_solvers::path::Path;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::path_nee::PathNee;

const FIRST: &str = "LightSource \"infinite\" \"rgb L\" [2 2 2] \"point3 portal\" [-1 -1 3  -1 1 3  1 1 3  1 -1 3]\n";
const SECOND: &str = "LightSource \"infinite\" \"rgb L\" [1 1 1] \"point3 portal\" [2 -1 2  2 1 2  2 1 1  2 -1 1]\n";

/// A floor and a ball under an open sky, of which portals show a part.
fn room(portals: &str) -> Scene {
    let text = format!(
        "LookAt 0 -5 2  0 0 .5  0 0 1\nCamera \"perspective\" \"float fov\" 40\n\
         Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4 PixelFilter \"box\"\n\
         WorldBegin\nMaterial \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\n\
         {portals}\
         Shape \"disk\" \"float radius\" 3\nAttributeBegin Translate 0 0 .5 Shape \"sphere\" \"float radius\" .5 AttributeEnd\n\
         AttributeBegin Translate 0.4 0 3.5 Shape \"disk\" \"float radius\" .6 AttributeEnd\n"
    );
    let (description, said) = read_str("room.pbrt", &text, &ReadOptions::default());
    assert!(!said.has_errors(), "{}", said.render(&description.sources));
    let mut diagnostics = Diagnostics::default();
    let scene = etendue_scene::compile(&description, &CompileOptions::default(), &mut diagnostics);
    scene.unwrap_or_else(|| panic!("{}", diagnostics.render(&description.sources)))
}

#[test]
fn walks_from_the_eye_agree() {
    let scene = room(&format!("{FIRST}{SECOND}"));
    let reference = replicates(&scene, &PathMis::default(), samples(64));
    let mut family = Family::default();
    checks::agreement(&mut family, "path-nee", &scene, &replicates(&scene, &PathNee, samples(64).seed(2)), &reference, 0.35);
    checks::agreement(&mut family, "path", &scene, &replicates(&scene, &Path, samples(512).seed(3)), &reference, 0.35);
    let sharing = PathMis { block: 2, ..PathMis::default() };
    checks::agreement(&mut family, "sharing", &scene, &replicates(&scene, &sharing, samples(64).seed(4)), &reference, 0.35);
    family.must_hold();
    assert!(Bidirectional::default().needs().check(&scene).is_err() && PathMis::default().needs().check(&scene).is_ok());
}

#[test]
fn walks_from_the_light_of_one_agree() {
    checks::solvers_find_the_same(&room(FIRST), [128, 128, 1024]);
}

#[test]
fn photons_bring_the_same_light() {
    checks::photons_bring_the_same_light(&room(FIRST));
}
