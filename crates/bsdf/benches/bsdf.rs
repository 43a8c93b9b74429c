//! What a hit costs: `cargo bench -p etendue-bsdf`.

use criterion::{Criterion, criterion_group, criterion_main};
use etendue_bsdf::{Bsdf, Lobe, Ndf, Scatter, lobes::*};
use etendue_numerics::{Spectrum, Vec2, Vec3};
use std::hint::black_box;

fn bsdf(c: &mut Criterion) {
    let mut group = c.benchmark_group("bsdf");
    let (wo, wi, u) = (Vec3::new(0.36, -0.48, 0.8), Vec3::new(-0.3, 0.5, 0.81).normalize(), Vec2::new(0.3, 0.7));
    group.bench_function("make diffuse", |b| {
        b.iter(|| Bsdf::from(Diffuse::new(DiffuseParams { reflectance: black_box(Spectrum::splat(0.5)) })).len());
    });
    let plastic = RoughPlasticParams::default();
    let lobes: [(&str, Lobe); 7] = [
        ("diffuse", Diffuse::new(Default::default()).into()),
        ("dielectric", Dielectric::new(Default::default()).into()),
        ("rough conductor, ggx", RoughConductor::new(RoughConductorParams { ndf: Ndf::Ggx, ..Default::default() }).into()),
        ("rough conductor, beckmann", RoughConductor::new(Default::default()).into()),
        ("rough dielectric, ggx", RoughDielectric::new(RoughDielectricParams { ndf: Ndf::Ggx, ..Default::default() }).into()),
        ("rough plastic", RoughPlastic::new(plastic, &plastic.transmittance()).into()),
        (
            "principled",
            Principled::new(PrincipledParams { spec_trans: 0.3, clearcoat: 0.5, sheen: 0.2, ..Default::default() }).into(),
        ),
    ];
    for (name, lobe) in lobes {
        let f = Bsdf::from(lobe);
        group.bench_function(format!("{name}: eval"), |b| b.iter(|| black_box(&f).eval(black_box(wo), black_box(wi))));
        group.bench_function(format!("{name}: pdf"), |b| b.iter(|| black_box(&f).pdf(black_box(wo), black_box(wi))));
        group.bench_function(format!("{name}: sample"), |b| {
            b.iter(|| black_box(&f).sample(black_box(wo), black_box(0.4), black_box(u)))
        });
    }
    let mut blend = Bsdf::from(lobes[0].1).scaled(0.5);
    blend.push(0.5, lobes[2].1);
    group.bench_function("blend: sample", |b| b.iter(|| black_box(&blend).sample(black_box(wo), black_box(0.4), black_box(u))));
    group.finish();
}

criterion_group!(benches, bsdf);
criterion_main!(benches);
