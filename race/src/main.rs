//! Rays per second of étendue's tree and of Embree 3.13, on the same rays, in turns, on one thread.
//!
//! ```text
//! cargo run --release --manifest-path race/Cargo.toml                  procedural meshes of 1 to 2 million triangles, 10,000 instances
//! cargo run --release --manifest-path race/Cargo.toml -- --big         and one of 10 million
//! cargo run --release --manifest-path race/Cargo.toml -- a.xml b.pbrt  and the triangles of these scenes
//! ```
//!
//! Embree builds with `RTC_BUILD_QUALITY_HIGH` and is asked ray by ray (`rtcIntersect1`, `rtcOccluded1`), with denormals flushed as it recommends. étendue is watertight,
//! so it races `RTC_SCENE_FLAG_ROBUST`; the second table is Embree without, for information. Rates are per CPU second of the
//! thread, medians of seven rounds. All hits are compared: distances within 1e-5 and two roundings of the coordinates, and the triangle where the ray does not graze it.

mod embree;
#[path = "../../crates/accel/benches/meshes/mod.rs"]
mod meshes;

use cpu_time::{ProcessTime, ThreadTime};
use embree::Embree;
use etendue::{LoadOptions, bench, load};
use etendue_accel::{Accel, BuildOptions, Builder, NoShapes};
use etendue_numerics::{DVec3, Ray, Transform, Vec3};
use meshes::{Mesh, Random, rays};
use std::hint::black_box;
use std::sync::Arc;

const ROUNDS: usize = 7;

/// Rays of one kind: its name, whether any hit will do, the rays.
type Kind = (&'static str, bool, Vec<Ray>);

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.iter().any(|a| a == "--help") {
        println!("etendue-race [--big] [SCENE]...");
        return;
    }
    embree3::enable_ftz_and_daz();
    println!(
        "| scene | rays | étendue M/s | Embree robust M/s | ratio | Embree fast M/s | ratio |\n| --- | --- | --- | --- | --- | --- | --- |"
    );
    let mut builds = Vec::new();
    let mut ratios: Vec<(&'static str, f64)> = Vec::new();
    for name in arguments.iter().filter(|a| !a.starts_with("--")) {
        let (mesh, kinds) = scene(name);
        race(name, &mesh, Some(kinds), &mut builds, &mut ratios);
    }
    race("spheres", &Mesh::spheres(5, 63), None, &mut builds, &mut ratios);
    race("terrain", &Mesh::terrain(250, 2000), None, &mut builds, &mut ratios);
    race("soup", &Mesh::soup(1_000_000), None, &mut builds, &mut ratios);
    if arguments.iter().any(|a| a == "--big") {
        race("big spheres", &Mesh::spheres(5, 141), None, &mut builds, &mut ratios);
    }
    instances(&mut builds, &mut ratios);

    println!("\n| | geometric mean | least |\n| --- | --- | --- |");
    for kind in ["camera", "bounce", "occlusion", "shadow"] {
        let of: Vec<f64> = ratios.iter().filter(|(k, _)| *k == kind).map(|(_, r)| *r).collect();
        let mean = (of.iter().map(|r| r.ln()).sum::<f64>() / of.len() as f64).exp();
        println!("| {kind} | {mean:.2} | {:.2} |", of.iter().copied().fold(f64::INFINITY, f64::min));
    }
    println!(
        "\n| build | triangles | étendue CPU s | Embree CPU s | ratio | étendue bytes a triangle | Embree | ratio |\n| --- | --- | --- | --- | --- | --- | --- | --- |"
    );
    builds.iter().for_each(|row| println!("{row}"));
}

/// The triangles of a scene file, and its rays.
fn scene(name: &str) -> (Mesh, Vec<Kind>) {
    let loaded = load(name, &LoadOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
    let kinds = bench::rays::kinds(&loaded.scene, &loaded.scene.views[0]).map(|k| (k.name, k.any, k.rays));
    let mut all = Mesh { positions: Vec::new(), indices: Vec::new() };
    let (mut taken, mut left) = (0, 0);
    for (_, surface) in loaded.scene.surfaces.iter() {
        let Some(mesh) = surface.shape.mesh().filter(|_| surface.in_world) else {
            left += 1;
            continue;
        };
        let base = all.positions.len() as u32;
        all.positions.extend(&mesh.positions);
        all.indices.extend(mesh.indices.iter().map(|corners| corners.map(|i| base + i)));
        taken += 1;
    }
    eprintln!("{name}: {taken} meshes of {} triangles; {left} other shapes left out", all.indices.len());
    (all, kinds.into())
}

fn race(name: &str, mesh: &Mesh, kinds: Option<Vec<Kind>>, builds: &mut Vec<String>, ratios: &mut Vec<(&'static str, f64)>) {
    let (embree, plain) = (Embree::new(), Embree::new());
    let start = ProcessTime::now();
    let ours = mesh.build(BuildOptions::default().duplicates);
    let our_build = start.elapsed().as_secs_f64();
    let start = ProcessTime::now();
    let robust = embree.mesh(mesh, true);
    let their_build = start.elapsed().as_secs_f64();
    let fast = plain.mesh(mesh, false);
    let n = mesh.indices.len() as f64;
    let [our_bytes, their_bytes] = [ours.stats().bytes as f64 / n, embree.bytes() as f64 / n];
    builds.push(format!(
        "| {name} | {n} | {our_build:.3} | {their_build:.3} | {:.2} | {our_bytes:.1} | {their_bytes:.1} | {:.2} |",
        our_build / their_build,
        our_bytes / their_bytes
    ));
    let kinds = kinds
        .unwrap_or_else(|| rays(mesh, &ours).0.into_iter().enumerate().map(|(i, (kind, rays))| (kind, i >= 2, rays)).collect());
    let same = |hit: &etendue_accel::Hit, other: &embree::Nearest| hit.primitive == other.primitive;
    let exact = |ray: &Ray, hit: Place| distance(ray, mesh.indices[hit.1 as usize].map(|i| mesh.positions[i as usize].as_dvec3()));
    compare(name, [&robust, &fast], &ours, &kinds, Judge { same: &same, exact: &exact }, ratios);
}

/// Ten thousand instances of one bumpy sphere.
fn instances(builds: &mut Vec<String>, ratios: &mut Vec<(&'static str, f64)>) {
    let mesh = Mesh::spheres(1, 32);
    let mut random = Random(3);
    let maps: Vec<Transform> = (0..10_000)
        .map(|i| {
            let at = DVec3::new(f64::from(i % 100), f64::from(random.unit()), f64::from(i / 100));
            let turn = glam::DQuat::from_rotation_y(f64::from(random.unit()) * 6.0);
            Transform::new(glam::DMat4::from_scale_rotation_translation(DVec3::ONE, turn, at)).unwrap_or_default()
        })
        .collect();
    let ball = Arc::new(mesh.build(BuildOptions::default().duplicates));
    let start = ProcessTime::now();
    let mut builder = Builder::new();
    let tree = builder.add_tree(ball);
    for (i, map) in maps.iter().enumerate() {
        builder.add_instance(tree, map, i as u32);
    }
    let ours = builder.build(&BuildOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let our_build = start.elapsed().as_secs_f64();

    let embree = Embree::new();
    let [robust_ball, fast_ball] = [true, false].map(|robust| embree.mesh(&mesh, robust));
    let start = ProcessTime::now();
    let robust = embree.instances(&robust_ball, &maps, true);
    let their_build = start.elapsed().as_secs_f64();
    let fast = embree.instances(&fast_ball, &maps, false);
    builds.push(format!("| 10,000 instances | | {our_build:.3} | {their_build:.3} | {:.2} | | | |", our_build / their_build));

    let mut random = Random(5);
    let eye = Vec3::new(50.0, 20.0, -20.0);
    let camera: Vec<Ray> = (0..1 << 16)
        .map(|_| Ray::new(eye, (Vec3::new(100.0 * random.unit(), 0.0, 100.0 * random.unit()) - eye).normalize()))
        .collect();
    let light = Vec3::new(50.0, 40.0, 50.0);
    let (mut bounce, mut shadow, mut occlusion) = (Vec::new(), Vec::new(), Vec::new());
    for ray in &camera {
        let Some(hit) = ours.closest(ray, &NoShapes) else { continue };
        let p = ray.at(hit.t);
        let n = (p - maps[hit.instance as usize].matrix().w_axis.truncate().as_vec3()).normalize();
        let p = p + 1e-3 * n;
        let away = |random: &mut Random| (n + 0.999 * random.direction()).normalize();
        bounce.push(Ray::new(p, away(&mut random)));
        occlusion.push(Ray::new(p, away(&mut random)).until(2.0));
        shadow.push(Ray::new(p, light + random.direction() - p).until(0.999));
    }
    let kinds = [("camera", false, camera), ("bounce", false, bounce), ("occlusion", true, occlusion), ("shadow", true, shadow)];
    let same =
        |hit: &etendue_accel::Hit, other: &embree::Nearest| hit.instance == other.instance && hit.primitive == other.primitive;
    let exact = |ray: &Ray, (instance, triangle): Place| {
        let map = &maps[instance as usize];
        distance(ray, mesh.indices[triangle as usize].map(|i| map.point_f64(mesh.positions[i as usize].as_dvec3())))
    };
    compare("10,000 instances", [&robust, &fast], &ours, &kinds, Judge { same: &same, exact: &exact }, ratios);
}

/// An instance, and the triangle within.
type Place = (u32, u32);

/// What is known of hits.
#[derive(Clone, Copy)]
struct Judge<'a> {
    /// Whether both are of one triangle.
    same: &'a dyn Fn(&etendue_accel::Hit, &embree::Nearest) -> bool,
    /// The distance to the plane of a triangle, as f64 has it.
    exact: &'a dyn Fn(&Ray, Place) -> f64,
}

/// t = (a - o)·n / d·n.
fn distance(ray: &Ray, [a, b, c]: [DVec3; 3]) -> f64 {
    let n = (b - a).cross(c - a);
    (a - ray.o.as_dvec3()).dot(n) / ray.d.as_dvec3().dot(n)
}

fn compare(
    name: &str,
    [robust, fast]: [&embree3::Scene<'_>; 2],
    ours: &Accel,
    kinds: &[Kind],
    judge: Judge<'_>,
    ratios: &mut Vec<(&'static str, f64)>,
) {
    for (kind, any, rays) in kinds {
        let mut rates = [const { Vec::new() }; 3];
        for _ in 0..ROUNDS {
            rates[0]
                .push(rate(rays, |ray| if *any { ours.occluded(ray, &NoShapes) } else { ours.closest(ray, &NoShapes).is_some() }));
            for (rates, theirs) in rates[1..].iter_mut().zip([robust, fast]) {
                rates.push(rate(
                    rays,
                    |ray| if *any { embree::occluded(theirs, ray) } else { embree::closest(theirs, ray).is_some() },
                ));
            }
        }
        let [a, b, c] = rates.map(median);
        println!("| {name} | {kind} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} |", a / 1e6, b / 1e6, a / b, c / 1e6, a / c);
        ratios.push((kind, a / b));
        agreement(&format!("{name}, {kind}"), *any, ours, robust, rays, judge);
    }
}

/// Rays per CPU second.
fn rate(rays: &[Ray], hit: impl Fn(&Ray) -> bool) -> f64 {
    let start = ThreadTime::now();
    black_box(rays.iter().filter(|ray| hit(ray)).count());
    rays.len() as f64 / start.elapsed().as_secs_f64()
}

fn median(mut x: Vec<f64>) -> f64 {
    x.sort_by(f64::total_cmp);
    x[x.len() / 2]
}

/// What f32 leaves open of a distance to `p`, with a matrix in between.
fn rounding(p: Vec3) -> f32 {
    2.0 * f32::EPSILON * p.abs().max_element()
}

/// Tells every way in which the hits differ.
fn agreement(name: &str, any: bool, ours: &Accel, theirs: &embree3::Scene<'_>, rays: &[Ray], judge: Judge<'_>) {
    let (mut missed, mut more, mut far, mut nearer, mut other) = (0, 0, 0, 0, 0);
    let mut worst = [0.0f64; 2];
    for ray in rays {
        if any {
            match (ours.occluded(ray, &NoShapes), embree::occluded(theirs, ray)) {
                (false, true) => missed += 1,
                (true, false) => more += 1,
                _ => {}
            }
            continue;
        }
        match (ours.closest(ray, &NoShapes), embree::closest(theirs, ray)) {
            (None, Some(_)) => missed += 1,
            (Some(_), None) => more += 1,
            (Some(a), Some(b)) => {
                let places = [(a.instance, a.primitive), (b.instance, b.primitive)];
                let exact = places.map(|place| (judge.exact)(ray, place));
                let errors = [0, 1].map(|i| (f64::from([a.t, b.t][i]) / exact[i] - 1.0).abs());
                worst = [0, 1].map(|i| worst[i].max(errors[i]));
                if (a.t - b.t).abs() > 1e-5 * b.t + rounding(ray.at(b.t)) {
                    far += 1;
                    nearer += u32::from(errors[0] < errors[1]);
                } else {
                    other += u32::from(!(judge.same)(&a, &b));
                }
            }
            _ => {}
        }
    }
    if missed + more + far + other > 0 {
        eprintln!(
            "{name}: of {} rays {missed} hit in Embree only, {more} in étendue only, {far} at another distance (in f64 étendue is nearer for {nearer}; worst errors \
             {:.1e} and {:.1e}), {other} another triangle",
            rays.len(),
            worst[0],
            worst[1]
        );
    }
}
