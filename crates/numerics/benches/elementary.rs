//! Our elementary functions beside the standard library's: 1000 arguments each.

use criterion::{Criterion, criterion_group, criterion_main};
use etendue_numerics::math;
use std::hint::black_box;

fn functions(c: &mut Criterion) {
    let arguments: Vec<f32> = (1..=1000).map(|i| (i as f32 * 0.618_034).fract() * 0.999 + 1e-4).collect();
    let mut time = |name: &str, f: &dyn Fn(&[f32]) -> f32| {
        c.bench_function(name, |b| b.iter(|| f(black_box(&arguments))));
    };
    time("sin_cos ours", &|x| x.iter().map(|&x| math::sin_cos(6.3 * x)).map(|(s, c)| s + c).sum());
    time("sin_cos library", &|x| x.iter().map(|&x| (6.3 * x).sin_cos()).map(|(s, c)| s + c).sum());
    time("exp ours", &|x| x.iter().map(|&x| math::exp(-10.0 * x)).sum());
    time("exp library", &|x| x.iter().map(|&x| (-10.0 * x).exp()).sum());
    time("ln ours", &|x| x.iter().map(|&x| math::ln(x)).sum());
    time("ln library", &|x| x.iter().map(|&x| x.ln()).sum());
    time("powf ours", &|x| x.iter().map(|&x| math::powf(x, 2.4)).sum());
    time("powf library", &|x| x.iter().map(|&x| x.powf(2.4)).sum());
    time("acos ours", &|x| x.iter().map(|&x| math::safe_acos(2.0 * x - 1.0)).sum());
    time("acos library", &|x| x.iter().map(|&x| (2.0 * x - 1.0).acos()).sum());
    time("atan2 ours", &|x| x.windows(2).map(|x| math::atan2(x[0] - 0.5, x[1] - 0.5)).sum());
    time("atan2 library", &|x| x.windows(2).map(|x| (x[0] - 0.5).atan2(x[1] - 0.5)).sum());
}

criterion_group!(benches, functions);
criterion_main!(benches);
