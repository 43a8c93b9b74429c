//! Saboteurs: a path tracer with one deliberate fault at a time. The same checks that the proofs use must hold for it without a fault, and
//! must refute it with each.
//!
//! A check that lets a fault pass is a hole in the proof.

#[path = "../common/mod.rs"]
mod common;
#[macro_use]
mod faults;
mod guided;
mod path;

use common::checks::{
    agreement, at_point, closed_form, closed_form_by, floor, fresnel, furnace, furnace_scene, polygon_irradiance,
};
use common::worlds;
use common::*;
use etendue_film::{Film, FilmShape, Splat};
use etendue_numerics::kernel::Kernel;
use etendue_numerics::{Spectrum, Vec2};
use etendue_scene::Scene;
use etendue_solvers::PathRules;
use etendue_solvers::path::Path;
use etendue_solvers::path_guided::walk::Guided;
use etendue_solvers::path_mis::PathMis;
use path::Fault::Faultless;
use path::{FAULTS, Saboteur};
use std::f64::consts::PI;

/// The scenes of the checks, and what holds in them.
struct Checks {
    furnace: Scene,
    quad: Scene,
    from_behind: Scene,
    point: Scene,
    screened: Scene,
    face: Scene,
    two_lamps: Scene,
    reference: Vec<Picture>,
}

impl Checks {
    fn new() -> Self {
        let lamp = |look: &str, extra: &str| {
            format!(
                r#"<shape type="rectangle">{extra}<transform name="to_world"><lookat {look} up="0, 1, 0"/></transform>{}{}</shape>"#,
                diffuse(0.0),
                area("2")
            )
        };
        let down = r#"origin="0, 0, 2" target="0, 0, 0""#;
        let on_floor = |more: &str| scene(&format!("{}{}{more}", at_point("4, 0, 1.5", "0.3, 0.4, 0"), floor(0.5)));
        let point =
            r#"<emitter type="point"><point name="position" value="0.3, 0.4, 2"/><rgb name="intensity" value="3"/></emitter>"#;
        let null =
            r#"<shape type="rectangle"><transform name="to_world"><translate z="1"/></transform><bsdf type="null"/></shape>"#;
        let face = r#"<shape type="rectangle"><transform name="to_world"><scale value="50"/></transform>
            <bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf></shape>"#;
        let below = r#"<shape type="rectangle"><transform name="to_world"><scale value="50"/><translate z="-3"/></transform>"#;
        let two_lamps = scene(&format!(
            r#"{}
            <shape type="rectangle"><transform name="to_world"><scale value="3"/></transform>{}</shape>
            <shape type="sphere"><point name="center" value="0, 0.3, 0.5"/><float name="radius" value="0.5"/>
                <bsdf type="roughconductor"><float name="alpha" value="0.3"/></bsdf></shape>
            <shape type="sphere"><point name="center" value="-1.2, 0, 1.2"/><float name="radius" value="0.5"/>{}</shape>{}"#,
            camera("0, -4, 3", "0, 0, 0.3", "0, 0, 1", 40.0, [8, 8]),
            diffuse(0.6),
            area("4, 3, 2"),
            lamp(r#"origin="1.5, 0, 2" target="0, 0, 0""#, "")
        ));
        Self {
            furnace: furnace_scene([0.5; 3]),
            quad: on_floor(&lamp(down, "")),
            from_behind: on_floor(&lamp(down, r#"<boolean name="flip_normals" value="true"/>"#)),
            point: on_floor(point),
            screened: on_floor(&format!("{null}{}", lamp(down, ""))),
            face: scene(&format!("{}{face}{below}{}{}</shape>", at_point("0, 0, 5", "0, 0, 0"), diffuse(0.0), area("2"))),
            reference: replicates(&two_lamps, &Path, samples(256).seed(7)),
            two_lamps,
        }
    }

    /// All claims about a solver.
    fn of(&self, solver: &Saboteur) -> Family {
        let mut family = Family::default();
        for bounces in [Some(0), Some(2), None] {
            furnace(&mut family, "furnace", solver, (&self.furnace, 0.5), bounces, 24, 0.05);
        }
        let corners = [[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0]];
        let quad = 0.5 / PI * 2.0 * polygon_irradiance([0.3, 0.4, 0.0], &corners);
        closed_form(&mut family, "quad", &self.quad, solver, quad, 32, 0.1);
        closed_form(&mut family, "quad from behind", &self.from_behind, solver, 0.0, 32, 0.1);
        closed_form(&mut family, "quad behind a null surface", &self.screened, solver, quad, 32, 0.1);
        closed_form(&mut family, "point", &self.point, solver, 0.5 / PI * 3.0 / 4.0, 1, 1e-4);
        let t = 1.0 - fresnel(1.0, 1.5);
        closed_form(&mut family, "glass face", &self.face, solver, 2.0 * t / (1.5 * 1.5), 256, 0.05);
        let pictures = replicates(&self.two_lamps, solver, samples(32));
        agreement(&mut family, "two lamps", &self.two_lamps, &pictures, &self.reference, 0.5);
        family
    }
}

#[test]
fn every_fault_is_caught() {
    let checks = Checks::new();
    checks.of(&Saboteur(Faultless)).must_hold();
    for fault in FAULTS {
        let failures = checks.of(&Saboteur(fault)).failures();
        assert!(!failures.is_empty(), "{fault:?} goes unseen");
    }
}

/// Walks by a guide that knows nothing find the light all the same, and not where their densities are wrong.
#[test]
fn every_fault_of_a_guide_is_caught() {
    let (scene, field) = (worlds::room(&worlds::eye(), worlds::WALLS, &worlds::lamp()), guided::nonsense());
    let reference = replicates(&scene, &Path, samples(256).edges(3).seed(7));
    let of = |solver: &dyn Fn() -> Vec<Picture>| {
        let mut family = Family::default();
        agreement(&mut family, "room", &scene, &solver(), &reference, 0.9);
        family
    };
    of(&|| replicates(&scene, &Guided { field: &field, mis: PathMis::default() }, samples(256).edges(3))).must_hold();
    let (astray, mis) = (guided::astray(), PathMis { block: 2, ..PathMis::default() });
    of(&|| replicates(&scene, &Guided { field: &astray, mis }, samples(256).edges(3))).must_hold();
    let forgetful = guided::Forgetful(Guided { field: &astray, mis });
    let forgotten = of(&|| replicates(&scene, &forgetful, samples(256).edges(3)));
    assert!(!forgotten.failures().is_empty(), "neighbours that forget the guide go unseen");
    let crooked = |fault| {
        let solver = guided::Crooked { fault, field: field.clone() };
        of(&|| replicates(&scene, &solver, samples(256).edges(3)))
    };
    crooked(guided::Fault::Faultless).must_hold();
    for fault in guided::FAULTS {
        assert!(!crooked(fault).failures().is_empty(), "{fault:?} goes unseen");
    }
}

/// Masks with a limited depth: what the walk may pass the shadow ray may pass, to the edge.
#[test]
fn a_null_surface_that_is_no_edge_is_passed_by_the_last_edge_too() {
    // The fault that this check once found: walks whose edges were spent ended at null surfaces, while shadow rays went on.
    let lamp = scene(&format!(
        r#"{}{}<shape type="rectangle"><transform name="to_world"><translate z="1"/></transform><bsdf type="null"/></shape>
        <shape type="rectangle"><transform name="to_world"><lookat origin="0, 0, 2" target="0, 0, 0" up="0, 1, 0"/></transform>{}{}</shape>"#,
        at_point("4, 0, 1.5", "0.3, 0.4, 0"),
        floor(0.5),
        diffuse(0.0),
        area("2")
    ));
    let corners = [[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0]];
    let quad = 0.5 / PI * 2.0 * polygon_irradiance([0.3, 0.4, 0.0], &corners);
    let rules = PathRules { null_counts: false, max_edges: 2, ..PathRules::default() };
    let mut family = Family::default();
    closed_form_by(&mut family, "null", &lamp, &Saboteur(Faultless), quad, samples(64).with(rules), 0.05);
    family.must_hold();
}

/// The light that splats bring: their sum over the particles started.
fn splatted(start: impl Fn(&Film, u64)) -> f64 {
    let film = Film::new(FilmShape { size: [16, 16], kernel: Kernel::Gaussian { stddev: 0.5 } });
    for batch in 0..4u32 {
        let splat = |i: u32| Splat {
            position: Vec2::new(4.0 + (i % 8) as f32, 5.3 + (i / 8) as f32),
            value: Spectrum::splat(8.0),
            particle: u64::from(i),
        };
        film.add_splats(&(batch * 8..batch * 8 + 8).map(splat).collect::<Vec<_>>());
        start(&film, 16);
    }
    film.develop().iter().map(|p| f64::from(p[0])).sum()
}

/// Splats are divided by the particles started, those without a contribution included; neither by those that arrived nor not at all.
#[test]
fn splats_are_normalised() {
    let right = splatted(|film, n| film.start_particles(n));
    assert!((right - 32.0 * 8.0 / 64.0).abs() < 1e-4, "{right}");
    let by_arrived = splatted(|film, _| film.start_particles(8));
    assert!((by_arrived - right).abs() > 1.0);
    let counted_twice = splatted(|film, n| film.start_particles(2 * n));
    assert!((counted_twice - right).abs() > 1.0);
}
