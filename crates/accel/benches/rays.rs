//! Rays per second and build time: `cargo bench -p etendue-accel`.
//!
//! Three procedural meshes: bumpy spheres (1 M small, even triangles), terrain (1 M thin ones), soup (0.5 M of every size, overlapping).
//! Rays: camera (coherent, nearest), bounce (diffuse directions from where those hit, nearest), shadow (from there to a small light,
//! any hit), occlusion (short diffuse ones, any hit); and 10,000 instances of one sphere.
#![allow(missing_docs)]

mod meshes;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use etendue_accel::{Accel, BuildOptions, Builder, NoShapes, Path};
use etendue_numerics::{DVec3, Ray, Transform, Vec3};
use meshes::{Mesh, Random, Rays, rays};
use std::hint::black_box;
use std::sync::Arc;

fn cast(c: &mut Criterion, scene: &str, accel: &Accel, rays: &Rays) {
    let mut group = c.benchmark_group(scene);
    for (i, (kind, rays)) in rays.0.iter().enumerate() {
        group.throughput(Throughput::Elements(rays.len() as u64));
        group.bench_function(*kind, |b| {
            b.iter(|| {
                if i < 2 {
                    rays.iter().filter(|r| black_box(accel.closest(r, &NoShapes)).is_some()).count()
                } else {
                    rays.iter().filter(|r| accel.occluded(r, &NoShapes)).count()
                }
            });
        });
    }
    group.finish();
}

fn meshes(c: &mut Criterion) {
    for (scene, mesh) in [("spheres", Mesh::spheres(5, 63)), ("terrain", Mesh::terrain(250, 2000)), ("soup", Mesh::soup(500_000))] {
        let mut group = c.benchmark_group(format!("build/{scene}"));
        group.sample_size(10).throughput(Throughput::Elements(mesh.indices.len() as u64));
        for duplicates in [0.0, 0.25] {
            group.bench_function(format!("duplicates-{duplicates}"), |b| {
                b.iter_batched(|| (), |()| mesh.build(duplicates), BatchSize::PerIteration);
            });
        }
        group.finish();
        let accel = mesh.build(BuildOptions::default().duplicates);
        let rays = rays(&mesh, &accel);
        cast(c, scene, &accel, &rays);
        if scene == "soup"
            && let Some(plain) = accel.with_path(Path::Plain)
        {
            cast(c, "soup-plain", &plain, &rays);
        }
    }
}

fn instances(c: &mut Criterion) {
    let ball = Arc::new(Mesh::spheres(1, 32).build(0.25));
    let scene = || {
        let mut builder = Builder::new();
        let tree = builder.add_tree(ball.clone());
        let mut random = Random(3);
        for i in 0..10_000 {
            let at = DVec3::new(f64::from(i % 100), f64::from(random.unit()), f64::from(i / 100));
            let turn = glam::DQuat::from_rotation_y(f64::from(random.unit()) * 6.0);
            let map = glam::DMat4::from_scale_rotation_translation(DVec3::ONE, turn, at);
            builder.add_instance(tree, &Transform::new(map).unwrap_or_default(), i);
        }
        builder.build(&BuildOptions::default()).unwrap_or_else(|e| panic!("{e}"))
    };
    let mut group = c.benchmark_group("build/instances");
    group.sample_size(10).throughput(Throughput::Elements(10_000));
    group.bench_function("10000", |b| b.iter(&scene));
    group.finish();

    let accel = scene();
    let mut random = Random(5);
    let camera: Vec<Ray> = (0..1 << 16)
        .map(|_| {
            let target = Vec3::new(100.0 * random.unit(), 0.0, 100.0 * random.unit());
            let eye = Vec3::new(50.0, 20.0, -20.0);
            Ray::new(eye, (target - eye).normalize())
        })
        .collect();
    let bounce: Vec<Ray> = camera
        .iter()
        .filter_map(|r| Some(Ray::new(r.at(0.999 * accel.closest(r, &NoShapes)?.t), (random.direction() + Vec3::Y).normalize())))
        .collect();
    let occlusion = bounce.iter().map(|r| r.until(2.0)).collect();
    let rays = Rays([("camera", camera), ("bounce", bounce.clone()), ("shadow", bounce), ("occlusion", occlusion)]);
    cast(c, "instances", &accel, &rays);
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).measurement_time(std::time::Duration::from_secs(2)).warm_up_time(std::time::Duration::from_millis(500));
    targets = meshes, instances
}
criterion_main!(benches);
