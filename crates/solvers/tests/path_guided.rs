//! Path tracing by a guide: its own partial sums in furnaces, the light of path tracing everywhere else, the same bits always, and path-mis itself
//! where a guide is not worth its time.
//!
//! Each test is one family of claims with 1 % of false alarms, over independent replicates: each has its own guide.

mod common;

use common::checks::{agreement, furnace, furnace_scene, neumann, round_furnace_scene};
use common::interrupted::leaves_no_trace;
use common::worlds::*;
use common::*;
use etendue_scene::Scene;
use etendue_solvers::path_guided::PathGuided;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::transport::Heuristic;
use etendue_solvers::{PathRules, Stop};

/// Guided whatever the trial says, by so few photons that the guide is a poor one; each walk alone, and walks of a block sharing.
const ALONE: PathGuided = PathGuided { photons: 4096, guide: 1, mis: PathMis::alone(Heuristic::Power) };
const ALWAYS: PathGuided = PathGuided { mis: PathMis { block: 2, ..ALONE.mis }, ..ALONE };

/// The ladder of bounces, and light of exactly so many.
#[test]
fn furnaces() {
    let mut family = Family::default();
    for (scene, a) in [(round_furnace_scene([0.5; 3]), 0.5), (furnace_scene([0.8; 3]), 0.8)] {
        for n in (0..=4).map(Some).chain([None]) {
            furnace(&mut family, "path-guided", &ALWAYS, (&scene, a), n, 128, 0.1);
        }
    }
    let scene = round_furnace_scene([0.5; 3]);
    for (from, to) in [(1, 1), (2, 4)] {
        let pictures = replicates(&scene, &ALWAYS, samples(128).with(PathRules::default().with_bounces(from..=to)));
        let want = neumann(0.5, Some(to)) - neumann(0.5, Some(from - 1));
        family.expect(format!("bounces {from} to {to}"), &mean_of(&pictures, 0), want, 0.1);
    }
    family.must_hold();
}

/// Every kind of light, camera and scattering, in red, green and blue and in wavelengths.
#[test]
fn agrees_with_path_mis_everywhere() {
    let mut family = Family::default();
    let mut agrees = |name: &str, scene: &Scene, rules: PathRules| {
        let job = |spp: u32| samples(spp).with(rules);
        let reference = replicates(scene, &PathMis::default(), job(96));
        for (solver, name, seed) in [(ALONE, name.to_owned(), 2), (ALWAYS, format!("{name}, shared"), 3)] {
            agreement(&mut family, &name, scene, &replicates(scene, &solver, job(128).seed(seed)), &reference, 0.9);
        }
    };
    for (name, scene) in &all_scenes() {
        agrees(name, scene, PathRules { max_edges: 5, ..PathRules::default() });
    }
    let mut glass = room(&eye(), WALLS, &(lamp() + GLASS));
    glass.spectral = true;
    agrees("wavelengths", &glass, PathRules { max_edges: 5, ..PathRules::default() });
    for null_counts in [false, true] {
        let rules = PathRules { max_edges: 4, null_counts, hide_emitters: null_counts, ..PathRules::default() };
        agrees(&format!("mask, null counts: {null_counts}"), &room(&eye(), WALLS, &(lamp() + MASK)), rules);
    }
    family.must_hold();
}

/// Light through glass: seldom found without a guide, and neither more nor less of it with one.
#[test]
fn a_caustic_is_found() {
    let scene = scene(&format!(
        r#"{}<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="2"/></transform>{}</shape>
        <shape type="sphere"><point name="center" x="0" y="0.6" z="0"/><float name="radius" value="0.4"/><bsdf type="dielectric"/></shape>
        <shape type="sphere"><point name="center" x="0.5" y="3" z="0.2"/><float name="radius" value="0.15"/>{}</shape>"#,
        camera("0.3, 1, 2.5", "-0.1, 0, -0.1", "0, 1, 0", 30.0, SIZE),
        diffuse(0.7),
        area("40, 30, 20")
    ));
    let mut family = Family::default();
    let guided = replicates(&scene, &PathGuided { photons: 1 << 14, ..ALWAYS }, samples(1024));
    let plain = replicates(&scene, &PathMis::default(), samples(1024).seed(2));
    agreement(&mut family, "caustic", &scene, &guided, &plain, 3.0);
    family.must_hold();
}

/// A room that is lit through the gap beside a wall: the lamp behind it shines at the ceiling.
#[test]
fn light_comes_through_a_gap() {
    let cube = |translate: &str, scale: &str| {
        format!(
            r#"<shape type="cube"><transform name="to_world"><scale value="{scale}"/><translate value="{translate}"/></transform>{}</shape>"#,
            diffuse(0.6)
        )
    };
    let lamp = format!(
        r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="0.3"/><translate value="-0.3, 0, 0.6"/></transform>{}{}</shape>"#,
        diffuse(0.0),
        area("40, 30, 20")
    );
    let scene = room(&eye(), WALLS, &(cube("-0.3, 0, 0.2", "0.8, 1, 0.05") + &lamp));
    let mut family = Family::default();
    let plain = replicates(&scene, &PathMis::default(), samples(256).seed(2));
    for (solver, name, seed) in [(ALONE, "gap", 1), (ALWAYS, "gap, shared", 3)] {
        agreement(&mut family, name, &scene, &replicates(&scene, &solver, samples(256).seed(seed)), &plain, 0.9);
    }
    family.must_hold();
}

#[test]
fn threads_and_interruptions_leave_no_trace() {
    let scene = room(&eye(), WALLS, &(lamp() + GLASS));
    for stop in [Stop::Samples(256), Stop::Noise { percent: 1e-9, limit: 512 }] {
        leaves_no_trace(&scene, &ALWAYS, stop, &[(0, 0), (3, 0), (100, 0)]);
    }
    let at = |threads: usize| picture(&scene, &ALWAYS, Job { threads, ..samples(256) });
    assert!(bits(&at(1)) == bits(&at(3)));
}

/// Where a guide brings nothing all passes are those of path-mis, to the bit; and where there is no time to learn.
#[test]
fn without_a_guide_it_is_path_mis() {
    let scene = furnace_scene([0.5; 3]);
    for spp in [1, 2048] {
        let (ours, theirs) =
            (picture(&scene, &PathGuided::default(), samples(spp)), picture(&scene, &PathGuided::default().mis, samples(spp)));
        assert!(bits(&ours) == bits(&theirs), "{spp} samples");
    }
}
