//! Many walks at once give the bits of each alone: the batched driver, path-mis and path-guided on lanes against the scalar step, picture by picture.

mod common;

use common::bidirectional::one_by_one;
use common::*;
use etendue_accel::Hit;
use etendue_numerics::warp::square_to_equal_area_sphere;
use etendue_numerics::{Dim, Sampler, SequenceKind, Spectrum, Vec3};
use etendue_scene::Scene;
use etendue_solvers::bidirectional::{Bidirectional, Strategies, worth::Worth};
use etendue_solvers::drivers::PixelSolver;
use etendue_solvers::path_guided::field::{Field, Photon};
use etendue_solvers::path_guided::walk::Guided;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::solver::{CannotGoOn, Needs};
use etendue_solvers::transport::{Context, Crowd, Heuristic, PathSolver, PathState, Step, trace};
use etendue_solvers::{PathRules, Run, Solver, Stop, Work};
use std::sync::LazyLock;

/// path-mis, one walk after the other.
struct OneByOne(PathMis);

impl PixelSolver for OneByOne {
    fn radiance(&self, c: &Context<'_>, eye: PathState, u: &Sampler, rays: &mut u64) -> Spectrum {
        trace(&self.0, c, eye, u, rays)
    }
}

/// path-mis in crowds, but with the scalar step.
struct StepByStep(PathMis);

impl PathSolver for StepByStep {
    fn block(&self) -> u32 {
        PathSolver::block(&self.0)
    }

    fn meet<'a>(&self, c: &Context<'a>, crowd: &mut Crowd<'a>) -> u64 {
        self.0.meet(c, crowd)
    }

    fn scatter(&self, c: &Context<'_>, state: &mut PathState, hit: Option<Hit>, u: &Sampler) -> Step {
        self.0.scatter(c, state, hit, u)
    }
}

/// path-guided in crowds, but with the scalar step.
struct GuidedStepByStep<'a>(Guided<'a>);

impl PathSolver for GuidedStepByStep<'_> {
    fn block(&self) -> u32 {
        PathSolver::block(&self.0)
    }

    fn meet<'a>(&self, c: &Context<'a>, crowd: &mut Crowd<'a>) -> u64 {
        self.0.meet(c, crowd)
    }

    fn scatter(&self, c: &Context<'_>, state: &mut PathState, hit: Option<Hit>, u: &Sampler) -> Step {
        self.0.scatter(c, state, hit, u)
    }
}

fn guide() -> &'static Field {
    static GUIDE: LazyLock<Field> = LazyLock::new(any_guide);
    &GUIDE
}

/// A guide of photons from anywhere to anywhere on four of six sides, more of them from above: right or wrong does not matter here.
fn any_guide() -> Field {
    let photon = |i: u32| {
        let u = Sampler::new(SequenceKind::Independent, 5, 0, i, 1 << 14);
        let at = |d: u32| square_to_equal_area_sphere(u.u2(Dim(d)));
        let n = if i % 4 < 2 { Vec3::X } else { Vec3::Y } * if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        Photon { p: at(0), from: 3.0 * at(1) + Vec3::Y, n, flux: 0.1 + u.u1(Dim(2)) }
    };
    Field::new(&(0..1 << 14).map(photon).collect::<Vec<_>>())
}

const SIZE: [u32; 2] = [40, 24];

fn view() -> String {
    camera_with("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, SIZE, r#"<rfilter type="gaussian"/>"#)
}

/// A box whose walls are coloured by `walls`, with `inside` in it.
fn room(walls: &str, inside: &str) -> Scene {
    scene(&format!(r#"{}<shape type="cube"><boolean name="flip_normals" value="true"/>{walls}</shape>{inside}"#, view()))
}

const LAMP: &str = r#"<shape type="rectangle">
    <transform name="to_world"><rotate x="1" angle="90"/><scale x="0.4" z="0.3"/><translate y="0.95"/></transform>
    <bsdf type="diffuse"/><emitter type="area"><rgb name="radiance" value="3, 4, 5"/></emitter></shape>"#;

/// The three ways give one picture, by both heuristics, in RGB and in wavelengths; and walks that share with their neighbours, on lanes and not.
fn must_be_equal(name: &str, scene: &mut Scene, rules: PathRules) {
    for (spectral, heuristic) in [(false, Heuristic::Power), (false, Heuristic::Balance), (true, Heuristic::Power)] {
        scene.spectral = spectral;
        let scene = &*scene;
        let solver = PathMis::alone(heuristic);
        for stop in [Stop::Samples(3), Stop::Noise { percent: 1e-9, limit: 16 }] {
            let job = Job { stop, ..samples(0).with(rules) };
            let bits = |film: etendue_film::Film| film.develop().into_iter().flatten().map(f32::to_bits).collect::<Vec<_>>();
            let alone = bits(render(scene, &OneByOne(solver), job).0);
            assert!(alone.iter().any(|x| *x != 0), "{name} is black");
            assert!(
                bits(render(scene, &StepByStep(solver), job).0) == alone,
                "{name}, {heuristic:?}, {stop:?}, spectral {spectral}: crowds"
            );
            assert!(bits(render(scene, &solver, job).0) == alone, "{name}, {heuristic:?}, {stop:?}, spectral {spectral}: lanes");
        }
        for (block, follow) in [(1, 0.5), (2, 1.0), (2, 2.0)] {
            let (solver, job) = (PathMis { heuristic, block, follow }, samples(3).with(rules));
            let bits = |film: etendue_film::Film| film.develop().into_iter().flatten().map(f32::to_bits).collect::<Vec<_>>();
            let steps = bits(render(scene, &StepByStep(solver), job).0);
            assert!(bits(render(scene, &solver, job).0) == steps, "{name}, {heuristic:?}, spectral {spectral}: blocks of {block}");
        }
        for (block, follow) in [(0, 2.0), (1, 0.5), (2, 2.0)] {
            let job = samples(3).with(rules);
            let guided = || Guided { field: guide(), mis: PathMis { heuristic, block, follow } };
            let bits = |film: etendue_film::Film| film.develop().into_iter().flatten().map(f32::to_bits).collect::<Vec<_>>();
            let steps = bits(render(scene, &GuidedStepByStep(guided()), job).0);
            assert!(bits(render(scene, &guided(), job).0) == steps, "{name}, spectral {spectral}: guided, blocks of {block}");
        }
    }
}

#[test]
fn a_lone_lamp_over_walls_glass_and_gold() {
    let inside = r#"<shape type="sphere"><point name="center" value="-0.45, -0.6, 0.3"/><float name="radius" value="0.38"/>
            <bsdf type="roughconductor"><string name="material" value="Au"/><float name="alpha" value="0.3"/></bsdf></shape>
        <shape type="sphere"><point name="center" value="0.45, -0.6, 0"/><float name="radius" value="0.35"/><bsdf type="dielectric"/></shape>
        <shape type="sphere"><point name="center" value="0, 0.1, 0.5"/><float name="radius" value="0.2"/>
            <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="0.3"/><rotate y="1" angle="160"/><translate y="0.4" z="0.2"/></transform>
            <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.9, 0, 0.2"/></bsdf></bsdf></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="0.2"/><rotate x="1" angle="100"/><translate x="0.5" z="0.2"/></transform>
            <bsdf type="twosided"><bsdf type="diffuse"/><bsdf type="plastic"/></bsdf></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="0.25"/><rotate y="1" angle="200"/><translate x="-0.6" y="0.4" z="0.3"/></transform>
            <bsdf type="twosided"><bsdf type="roughplastic"><string name="distribution" value="ggx"/></bsdf></bsdf></shape>
        <shape type="sphere"><point name="center" value="0.5, 0.2, 0.4"/><float name="radius" value="0.2"/>
            <bsdf type="principled"><float name="spec_trans" value="0.4"/><float name="clearcoat" value="0.6"/><float name="sheen" value="0.5"/></bsdf></shape>
        <shape type="sphere"><point name="center" value="0.1, -0.8, 0.1"/><float name="radius" value="0.2"/>
            <bsdf type="roughconductor"><string name="distribution" value="ggx"/><string name="masking" value="correlated"/>
                <float name="alpha_u" value="0.1"/><float name="alpha_v" value="0.4"/></bsdf></shape>"#;
    let mut scene = room(&diffuse(0.7), &format!("{LAMP}{inside}"));
    must_be_equal("room", &mut scene, PathRules::default());
    must_be_equal("two bounces", &mut scene, PathRules::default().with_bounces(2..=2));
    must_be_equal(
        "early roulette",
        &mut scene,
        PathRules { rr_depth: Some(1), max_edges: 4, hide_emitters: true, ..PathRules::default() },
    );
    must_be_equal("direct light", &mut scene, PathRules { max_edges: 2, ..PathRules::default() });
}

#[test]
fn triangles_alone_in_a_small_tree() {
    must_be_equal("a box", &mut room(&diffuse(0.5), LAMP), PathRules::default());
    must_be_equal("no light but the walls'", &mut room(&format!("{}{}", diffuse(0.5), area("1, 2, 3")), ""), PathRules::default());
}

#[test]
fn textures_masks_and_other_lights() {
    let checks = r#"<bsdf type="twosided"><bsdf type="diffuse"><texture type="checkerboard" name="reflectance">
        <rgb name="color0" value="0.8, 0.3, 0"/><rgb name="color1" value="0.1, 0.2, 0.6"/>
        <transform name="to_uv"><scale value="5"/></transform></texture></bsdf></bsdf>"#;
    let inside = r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><scale value="0.8"/><translate y="0.2"/></transform>
            <bsdf type="mask"><texture type="checkerboard" name="opacity"><rgb name="color0" value="0.2"/><rgb name="color1" value="0.9"/></texture>
                <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.2, 0.6, 0.6"/></bsdf></bsdf></bsdf></shape>
        <shape type="cube"><transform name="to_world"><scale value="0.3"/><translate y="-0.6"/></transform><bsdf type="null"/></shape>
        <emitter type="point"><point name="position" value="0.5, 0.5, 0"/><rgb name="intensity" value="0.6, 0.1, 0.1"/></emitter>
        <shape type="sphere"><point name="center" value="0.3, -0.3, 0.4"/><float name="radius" value="0.1"/>
            <emitter type="area"><rgb name="radiance" value="1, 1, 9"/></emitter></shape>"#;
    let mut scene = room(checks, &format!("{LAMP}{inside}"));
    for null_counts in [true, false] {
        must_be_equal("masks", &mut scene, PathRules { null_counts, max_edges: 6, ..PathRules::default() });
    }
}

#[test]
fn a_sky_instances_and_bent_normals() {
    let sky: Vec<[f32; 3]> = (0..128)
        .map(|i| if matches!(i, 20 | 21 | 36 | 37) { [20.0, 16.0, 9.0] } else { [0.3, 0.4, 0.1 + 0.005 * i as f32] })
        .collect();
    // A pyramid whose vertex normals lean.
    let text = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 1 0\nvn -0.5 0.7 -0.5\nvn 0.5 0.7 -0.5\nvn 0.5 0.7 0.5\nvn -0.5 0.7 0.5\nvn 0 1 0\n\
        vt 0 0\nvt 1 0\nvt 1 1\nvt 0.3 1\nvt 0.5 0.5\nf 1/1/1 5/5/5 2/2/2\nf 2/2/2 5/5/5 3/3/3\nf 3/3/3 5/5/5 4/4/4\nf 4/4/4 5/5/5 1/1/1\n";
    let pyramid = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("lanes-pyramid.obj");
    std::fs::write(&pyramid, text).expect("the folder for temporary files");
    let mut scene = scene(&format!(
        r#"{}
            <emitter type="envmap"><string name="filename" value="{}"/></emitter>
            <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="4"/></transform>{}</shape>
            <shape type="obj"><string name="filename" value="{}"/><transform name="to_world"><scale value="0.5"/></transform>
                <bsdf type="diffuse"><texture type="bitmap" name="reflectance"><string name="filename" value="{}"/></texture></bsdf></shape>
            <shape type="shapegroup" id="group">
                <shape type="cube"><transform name="to_world"><scale value="0.3"/></transform>{}</shape>
                <shape type="sphere"><point name="center" value="0, 0.6, 0"/><float name="radius" value="0.3"/><bsdf type="roughdielectric"/></shape>
            </shape>
            <shape type="instance"><ref id="group"/><transform name="to_world"><translate x="0.9" y="0.35"/></transform></shape>
            <shape type="instance"><ref id="group"/><transform name="to_world">
                <scale x="-0.7" y="1.2" z="0.5"/><rotate y="1" angle="30"/><translate x="-0.9" y="0.4"/></transform></shape>"#,
        camera_with("0, 1.5, -3", "0, 0.3, 0", "0, 1, 0", 50.0, SIZE, r#"<rfilter type="box"/>"#),
        picture_file("lanes-sky", 16, &sky),
        diffuse(0.5),
        pyramid.display(),
        picture_file("lanes-texture", 2, &[[0.9, 0.1, 0.2], [0.2, 0.8, 0.1], [0.3, 0.3, 0.9], [1.0, 0.5, 0.0]]),
        diffuse(0.7),
    ));
    must_be_equal("sky", &mut scene, PathRules::default());
}

/// bidirectional, one sample after the other.
struct SampleBySample(Bidirectional);

impl Solver for SampleBySample {
    type State = Worth;

    fn needs(&self) -> Needs {
        Needs::default()
    }

    fn units(&self, _: [u32; 2]) -> usize {
        1
    }

    fn splats(&self) -> bool {
        true
    }

    fn prepare(&self, scene: &Scene, run: &Run<'_>) -> Worth {
        self.0.prepare(scene, run)
    }

    fn pass(&self, scene: &Scene, run: &Run<'_>, worth: &mut Worth, k: u32, work: &Work<'_>) -> Result<(), CannotGoOn> {
        let all = Strategies { worth: *worth, ..self.0.strategies(scene, run) };
        one_by_one(&all, run, k, work, |f| f.value * f.weight);
        Ok(())
    }
}

/// Bidirectional paths on lanes give the bits of samples one by one: a lone lamp and several, seen through a pinhole and a lens, on flat, round and textured surfaces
/// whose backs are fronts as well or are not.
#[test]
fn bidirectional_paths_of_many_samples_at_once() {
    let pinhole = camera_with("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, SIZE, r#"<rfilter type="box"/>"#);
    let lens = r#""thinlens"><float name="aperture_radius" value="0.1"/><float name="focus_distance" value="1"/>"#;
    let things = r#"<shape type="sphere"><point name="center" value="-0.4, -0.5, 0.3"/><float name="radius" value="0.4"/>
            <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="0.3"/><rotate y="1" angle="160"/><translate y="0.4" z="0.2"/></transform>
            <bsdf type="twosided"><bsdf type="diffuse"><texture type="checkerboard" name="reflectance"/></bsdf></bsdf></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="0.2"/><rotate x="1" angle="100"/><translate x="0.5" z="0.2"/></transform>
            <bsdf type="diffuse"/></shape>"#;
    let second = r#"<shape type="sphere"><point name="center" value="0.5, -0.7, 0.2"/><float name="radius" value="0.1"/>
            <bsdf type="diffuse"/><emitter type="area"><rgb name="radiance" value="1, 1, 9"/></emitter></shape>"#;
    let short = PathRules { rr_depth: Some(1), max_edges: 4, ..PathRules::default() };
    for (lights, name) in [(LAMP.to_owned(), "a lamp"), (format!("{LAMP}{second}"), "two lamps")] {
        for camera in [pinhole.clone(), pinhole.replace(r#""perspective">"#, lens)] {
            let walls = format!(r#"<shape type="cube"><boolean name="flip_normals" value="true"/>{}</shape>"#, diffuse(0.7));
            let scene = scene(&format!("{camera}{walls}{things}{lights}"));
            for rules in [PathRules::default(), short, PathRules::default().with_bounces(1..=2)] {
                for solver in [Bidirectional { exponent: 1, faint: 0.0 }, Bidirectional::default()] {
                    let bits =
                        |film: etendue_film::Film| film.develop().into_iter().flatten().map(f32::to_bits).collect::<Vec<_>>();
                    let job = samples(2).with(rules);
                    let alone = bits(render(&scene, &SampleBySample(solver), job).0);
                    assert!(alone.iter().any(|x| *x != 0), "{name} is black");
                    assert!(bits(render(&scene, &solver, job).0) == alone, "{name}, {rules:?}, {solver:?}");
                }
            }
        }
    }
}
