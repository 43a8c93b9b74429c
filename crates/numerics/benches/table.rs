//! Drawing from a table as large as an environment map of 4096 × 2048, whose values differ by six orders of magnitude.

use criterion::{Criterion, criterion_group, criterion_main};
use etendue_numerics::sequence::mix;
use etendue_numerics::table::{Bilinear2D, Table2D};
use etendue_numerics::{Dim, Sampler, SequenceKind};

fn tables(c: &mut Criterion) {
    let (width, height) = (4096, 2048);
    let f: Vec<f32> = (0..width * height).map(|i| 10f32.powi((mix(i as u64) % 7) as i32)).collect();
    let mut index = 0;
    let mut u = move || {
        index += 1;
        Sampler::new(SequenceKind::Independent, 1, index, 0, 1).u2(Dim(0))
    };
    let table = Table2D::new(&f, width, height);
    c.bench_function("Table2D sample", |b| b.iter(|| table.sample(u())));
    c.bench_function("Table2D pdf", |b| b.iter(|| table.pdf(u())));
    if let Some(table) = Bilinear2D::new(&f, width, height) {
        c.bench_function("Bilinear2D sample", |b| b.iter(|| table.sample(u())));
        c.bench_function("Bilinear2D pdf", |b| b.iter(|| table.pdf(u())));
    }
    c.bench_function("Table2D build", |b| b.iter(|| Table2D::new(&f, width, height)));
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = tables
}
criterion_main!(benches);
