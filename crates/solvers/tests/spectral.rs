//! Walks that carry wavelengths: the furnace, greys against RGB, solvers against each other, and dispersion against Snell's law.
//!
//! Statistical tests are families of claims with 1 % of false alarms each.

mod common;

use common::checks::{self, agreement, furnace_scene, neumann};
use common::interrupted::leaves_no_trace;
use common::worlds::{WALLS, eye, lamp};
use common::*;
use etendue_numerics::spectrum::ior;
use etendue_numerics::{Pdf, Ray, Spectrum, Vec3, Wavelengths};
use etendue_scene::Scene;
use etendue_solvers::light_nee::LightNee;
use etendue_solvers::path::Path;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::path_nee::PathNee;
use etendue_solvers::photon_map::PhotonMap;
use etendue_solvers::transport::{PathState, Throughput};
use etendue_solvers::{PathRules, Stop};

fn spectral(scene: Scene) -> Scene {
    Scene { spectral: true, ..scene }
}

/// A white box loses nothing: walks of the same wavelengths bring n + 1 times the emission after n bounces.
#[test]
fn the_white_furnace_is_white_at_every_wavelength() {
    let scene = spectral(furnace_scene([1.0; 3]));
    let of = |edges| {
        let rules = PathRules { max_edges: edges, rr_depth: Some(u32::MAX), ..PathRules::default() };
        picture(&scene, &Path, samples(1).with(rules))
    };
    let emitted = of(1);
    assert!(emitted.iter().flatten().any(|x| *x < 0.9), "single walks have colours: {:?}", &emitted[..4]);
    for n in 1..=4u32 {
        for (l, le) in of(n + 1).iter().flatten().zip(emitted.iter().flatten()) {
            let want = le * (n + 1) as f32;
            assert!((l - want).abs() < 1e-4 * want.abs().max(1.0) * (n + 1) as f32, "{n} bounces: {l} instead of {want}");
        }
    }
}

#[test]
fn the_furnace_ladder() {
    let mut family = Family::default();
    let albedo = [0.2f32, 0.5, 0.9];
    let grey = spectral(furnace_scene([0.5; 3]));
    for n in [Some(0), Some(1), Some(3), None] {
        let job = samples(64).edges(n.map_or(u32::MAX, |n| n + 1));
        let mut claim = |name: &str, pictures: Vec<Picture>| {
            for channel in 0..3 {
                family.expect(format!("{name}, {n:?}, {channel}"), &mean_of(&pictures, channel), neumann(0.5, n), 0.03);
            }
        };
        claim("path", replicates(&grey, &Path, job));
        claim("path-nee", replicates(&grey, &PathNee, job));
        claim("path-mis", replicates(&grey, &PathMis::default(), job));
    }
    // One bounce of a colour is that colour, as the film sees it under the white of its own light.
    let coloured = spectral(furnace_scene(albedo));
    let pictures = replicates(&coloured, &PathMis::default(), samples(64).edges(2));
    for (channel, a) in albedo.iter().enumerate() {
        family.expect(format!("albedo {a}"), &mean_of(&pictures, channel), neumann(f64::from(*a), Some(1)), 0.03);
    }
    family.must_hold();
}

/// A box of the house, with `inside`.
fn room(walls: &str, lamp: &str, inside: &str) -> Scene {
    scene(&format!(r#"{}<shape type="cube"><boolean name="flip_normals" value="true"/>{walls}</shape>{lamp}{inside}"#, eye()))
}

#[test]
fn greys_are_those_of_rgb() {
    let grey = lamp().replace("3, 4, 5", "4, 4, 4");
    let inside = r#"<shape type="sphere"><point name="center" value="0.2, -0.4, 0.2"/><float name="radius" value="0.45"/>
        <bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.4"/></bsdf></shape>"#;
    let rgb = room(&diffuse(0.6), &grey, inside);
    let reference = replicates(&rgb, &PathMis::default(), samples(64));
    let waves = spectral(room(&diffuse(0.6), &grey, inside));
    let mut family = Family::default();
    agreement(&mut family, "spectral", &waves, &replicates(&waves, &PathMis::default(), samples(64).seed(2)), &reference, 0.2);
    family.must_hold();
}

const DISPERSIVE: &str = r#"<shape type="sphere"><point name="center" value="0.2, -0.4, 0.2"/><float name="radius" value="0.45"/>
        <bsdf type="roughdielectric"><string name="int_ior" value="glass-sf11"/><float name="alpha" value="0.5"/></bsdf></shape>
    <shape type="sphere"><point name="center" value="-0.5, -0.5, 0.3"/><float name="radius" value="0.4"/>
        <bsdf type="roughconductor"><string name="material" value="Au"/><float name="alpha" value="0.5"/></bsdf></shape>"#;

/// Coloured walls, gold, and glass that lets walks go on with one wavelength: by several ways of finding light.
#[test]
fn solvers_agree() {
    checks::solvers_find_the_same(&spectral(room(WALLS, &lamp(), DISPERSIVE)), [192, 256, 384]);
}

#[test]
fn photons_bring_the_same_light() {
    checks::photons_bring_the_same_light(&spectral(room(WALLS, &lamp(), DISPERSIVE)));
}

#[test]
fn bits_do_not_depend_on_threads() {
    let scene = spectral(room(WALLS, &lamp(), DISPERSIVE));
    for stop in [Stop::Samples(3), Stop::Noise { percent: 1e-9, limit: 16 }] {
        let at = |threads| bits(&picture(&scene, &PathMis::default(), Job { stop, threads, ..samples(0) }));
        assert!(at(1) == at(3), "{stop:?}");
    }
    let of_photons =
        |threads| bits(&picture(&scene, &PhotonMap { photons: 2048, ..PhotonMap::default() }, Job { threads, ..samples(3) }));
    assert!(of_photons(1) == of_photons(3), "photons");
}

#[test]
fn interruptions_leave_no_trace() {
    let scene = spectral(room(WALLS, &lamp(), DISPERSIVE));
    leaves_no_trace(&scene, &PathMis::default(), Stop::Samples(3), &[(1, 0), (2, 0)]);
    leaves_no_trace(&scene, &LightNee, Stop::Samples(3), &[(1, 0), (2, 0)]);
    leaves_no_trace(&scene, &PhotonMap { photons: 2048, ..PhotonMap::default() }, Stop::Samples(3), &[(1, 0)]);
    let noise = Stop::Noise { percent: 1e-9, limit: 16 };
    leaves_no_trace(&scene, &PathMis::default(), noise, &[(3, 0)]);
}

/// A walk through a prism of 60° leaves it where Snell's law says, at its own wavelength, and goes on with that alone.
#[test]
fn a_prism_deflects_as_snell_says() {
    let apex = 60f64.to_radians();
    let (x, z) = (((apex / 2.0).tan()), 1.0);
    let text = format!(
        "v {x} -2 0\nv 0 -2 {z}\nv -{x} -2 0\nv {x} 2 0\nv 0 2 {z}\nv -{x} 2 0\nf 1 4 5\nf 1 5 2\nf 2 5 6\nf 2 6 3\nf 3 6 4\nf 3 4 1\nf 1 2 3\nf 4 6 5\n"
    );
    let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("prism.obj");
    std::fs::write(&file, text).expect("the folder for temporary files");
    let scene = spectral(scene(&format!(
        r#"{}<shape type="obj"><string name="filename" value="{}"/><boolean name="face_normals" value="true"/>
            <bsdf type="dielectric"><string name="int_ior" value="glass-sf11"/><float name="ext_ior" value="1"/></bsdf></shape>"#,
        eye(),
        file.display()
    )));
    let glass = ior::glass("glass-sf11").expect("a glass");
    // Onto the face on the +x side, at an angle of 60° to its normal.
    let (incidence, lean) = (60f64.to_radians(), apex / 2.0);
    let normal = [lean.cos(), lean.sin()];
    let turned = |[x, z]: [f64; 2], a: f64| [x * a.cos() - z * a.sin(), x * a.sin() + z * a.cos()];
    let towards = turned(normal, -incidence).map(|x| -x);
    let target = [x / 2.0, 0.5];
    let origin = [target[0] - 3.0 * towards[0], target[1] - 3.0 * towards[1]];
    let vector = |[x, z]: [f64; 2]| Vec3::new(x as f32, 0.0, z as f32);
    for k in 0..64 {
        let wl = Wavelengths::hero((k as f32 + 0.5) / 64.0);
        let Wavelengths::Hero(hero) = &wl else { unreachable!("wavelengths") };
        let n = glass.index(f64::from(hero.nm()[0]));
        let first = (incidence.sin() / n).asin();
        let inner = n * (apex - first).sin();
        let mut walk = PathState::start(Ray::new(vector(origin), vector(towards)), Spectrum::ONE, wl);
        for _ in 0..2 {
            let hit = scene.intersect(&walk.ray).expect("the prism");
            let vertex = walk.vertex(&scene, scene.interaction(&walk.ray, &hit));
            let mut refracted = None;
            vertex.diracs(|s| {
                if s.wi.dot(vertex.x.n) * vertex.x.wo.dot(vertex.x.n) < 0.0 {
                    refracted = Some(s);
                }
            });
            let Some(s) = refracted.filter(|s| !s.weight.is_zero()) else { break };
            assert_eq!(s.pdf, Pdf::Delta(1.0));
            assert!(walk.turn(&PathRules::default(), &vertex, Some(s), 0.0));
        }
        assert!(walk.wl.is_alone());
        assert!(walk.beta != Throughput::ONE && walk.beta.carry(Spectrum::ONE).0.truncate().y == 0.0, "{:?}", walk.beta);
        if inner < 1.0 {
            let deflection = incidence + inner.asin() - apex;
            let got = f64::from(walk.ray.d.dot(vector(towards))).acos();
            assert!((got - deflection).abs() < 2e-4, "{} nm: {got} instead of {deflection}", hero.nm()[0]);
        }
    }
}
