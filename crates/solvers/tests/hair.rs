//! Hair as tubes: fibres that absorb nothing cannot be seen in front of a white sky, and the darker the pigment the less comes back.
//!
//! The first is one family of claims with 1 % of false alarms.

mod common;

use common::*;
use etendue_description::Diagnostics;
use etendue_formats::{ReadOptions, read_str};
use etendue_scene::{CompileOptions, Scene};
use etendue_solvers::bidirectional::Bidirectional;
use etendue_solvers::path::Path;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::{PathRules, Solver};

/// Two thick fibres that cross, before a sky of radiance 1.
fn fibres(hair: &str, spectral: bool) -> Scene {
    let text = format!(
        "LookAt 0 0 4  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 30\n\
         Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4 PixelFilter \"box\"\n\
         WorldBegin\nLightSource \"infinite\" \"rgb L\" [1 1 1]\nMaterial \"hair\" {hair}\n\
         Shape \"curve\" \"point3 P\" [-2 -.5 0  -1 0 0  0 1 0  2 .5 0] \"float width\" .9\n\
         Shape \"curve\" \"point3 P\" [-1 -2 .9  -.5 0 .7  .5 1 .9  .6 2 .8] \"float width\" .7"
    );
    let (description, said) = read_str("hair.pbrt", &text, &ReadOptions::default());
    assert!(!said.has_errors(), "{}", said.render(&description.sources));
    let mut diagnostics = Diagnostics::default();
    let scene = etendue_scene::compile(&description, &CompileOptions { spectral, ..CompileOptions::default() }, &mut diagnostics);
    scene.unwrap_or_else(|| panic!("{}", diagnostics.render(&description.sources)))
}

#[test]
fn white_hair_is_not_seen_in_a_white_sky() {
    let mut family = Family::default();
    // Roulette from the fourth vertex on; passing a wall from within is no edge in pbrt.
    let rules = PathRules { null_counts: false, rr_depth: Some(4), ..PathRules::default() };
    for spectral in [false, true] {
        let scene = fibres("\"rgb sigma_a\" [0 0 0] \"float beta_m\" .25 \"float alpha\" 3", spectral);
        for (name, pictures) in [
            ("path-mis", replicates(&scene, &PathMis::default(), samples(64).with(rules))),
            ("path", replicates(&scene, &Path, samples(16).with(rules).seed(2))),
        ] {
            for channel in 0..3 {
                family.expect(format!("{name}, {spectral}, {channel}"), &mean_of(&pictures, channel), 1.0, 0.02);
            }
        }
    }
    family.must_hold();
}

#[test]
fn pigment_darkens_and_light_solvers_refuse() {
    let mean = |hair: &str| mean_of(&replicates(&fibres(hair, false), &PathMis::default(), samples(16)), 0).mean;
    let grey = ["\"float eumelanin\" .1", "\"float eumelanin\" 1", "\"float eumelanin\" 8"].map(mean);
    assert!(grey[0] < 1.0 && grey[1] < grey[0] - 0.01 && grey[2] < grey[1] - 0.01, "{grey:?}");
    assert!(Bidirectional::default().needs().check(&fibres("", false)).is_err());
    assert!(PathMis::default().needs().check(&fibres("", false)).is_ok());
}
