//! What a uniform number costs: ten dimensions of one sample after the other, as a path draws them.

use criterion::{Criterion, criterion_group, criterion_main};
use etendue_numerics::{Dim, Sampler, SequenceKind};
use std::hint::black_box;

fn numbers(c: &mut Criterion) {
    for kind in [SequenceKind::Independent, SequenceKind::Stratified, SequenceKind::Sobol] {
        let mut sample = 0;
        c.bench_function(&format!("{kind:?} u2, 10 dimensions"), |b| {
            b.iter(|| {
                sample += 1;
                let sampler = Sampler::on_screen(kind, 1, [black_box(37), 21], sample & 255, 256);
                (0..10).map(|d| sampler.u2(Dim(black_box(d))).x).sum::<f32>()
            })
        });
    }
}

criterion_group!(benches, numbers);
criterion_main!(benches);
