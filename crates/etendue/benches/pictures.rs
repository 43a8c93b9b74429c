//! Whole pictures on one thread, from camera ray to film: `cargo bench -p etendue --bench pictures`. The unit is a path, so that figures of
//! different sizes compare.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use etendue::{LoadOptions, RenderOptions, Stop, Watch, load, render};

/// Built-in scenes: diffuse walls and one lamp, a choice among many lights, glossy plates.
const SCENES: [&str; 3] = ["cornell-box", "many-lights", "veach-mis"];
const SIZE: [u32; 2] = [64, 48];
const SAMPLES: u32 = 4;

fn pictures(c: &mut Criterion) {
    let mut group = c.benchmark_group("pictures");
    group.sample_size(10).throughput(Throughput::Elements(u64::from(SIZE[0] * SIZE[1] * SAMPLES)));
    for name in SCENES {
        let size = LoadOptions { width: Some(SIZE[0]), height: Some(SIZE[1]), ..LoadOptions::default() };
        let loaded = load(name, &size).unwrap_or_else(|e| panic!("{name}: {e}"));
        let options = RenderOptions { stop: Some(Stop::Samples(SAMPLES)), threads: Some(1), ..RenderOptions::default() };
        group.bench_function(name, |b| {
            b.iter(|| render(&loaded, &options, &Watch::default()).map_or_else(|e| panic!("{name}: {}", e.0), |r| r.mean()));
        });
    }
    group.finish();
}

criterion_group!(benches, pictures);
criterion_main!(benches);
