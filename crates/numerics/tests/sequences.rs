//! Point sets: nets are exact, everything else is statistical with fixed seeds.

use etendue_check::{ChiSquareTest, Moments, Square, t_test};
use etendue_numerics::{Dim, Sampler, SequenceKind, Vec2};

const KINDS: [SequenceKind; 3] = [SequenceKind::Independent, SequenceKind::Stratified, SequenceKind::Sobol];

/// Whether each elementary interval 2^-a × 2^-(m - a) holds exactly one of the 2^m points.
fn is_net(points: &[Vec2]) -> bool {
    let m = points.len().ilog2();
    (0..=m).all(|a| {
        let mut hit = vec![false; points.len()];
        points.iter().for_each(|p| {
            let (i, j) = ((p.x * (1u32 << a) as f32) as usize, (p.y * (1u32 << (m - a)) as f32) as usize);
            hit[j << a | i] = true;
        });
        hit.into_iter().all(|h| h)
    })
}

#[test]
fn sobol_points_are_nets() {
    for m in 0..=10 {
        let n = 1u32 << m;
        for dim in [0, 1, 2, 17, 400] {
            for pixel in [0, 1, 77] {
                // The first points, and a later block of as many.
                for start in [0, 5 * n] {
                    let points: Vec<_> =
                        (start..start + n).map(|s| Sampler::new(SequenceKind::Sobol, 3, pixel, s, n).u2(Dim(dim))).collect();
                    assert!(is_net(&points), "{m} {dim} {pixel} {start}");
                }
            }
            // On the screen each pixel has a net, and so has each aligned square of pixels.
            for (side, m_pixels) in [(1u32, 0), (4, 4)] {
                let corner = [8 * side, 3 * side];
                let pixels = (0..side * side).map(|i| [corner[0] + i % side, corner[1] + i / side]);
                let sampler = |pixel, s| Sampler::on_screen(SequenceKind::Sobol, 3, pixel, s, n).u2(Dim(dim));
                let points: Vec<_> = pixels.flat_map(|pixel| (0..n).map(move |s| sampler(pixel, s))).collect();
                assert_eq!(points.len(), 1 << (m + m_pixels));
                assert!(is_net(&points), "{m} {dim} {side}");
            }
        }
    }
    // The test can tell: independent points are no net.
    let points: Vec<_> = (0..64).map(|s| Sampler::new(SequenceKind::Independent, 3, 0, s, 64).u2(Dim(0))).collect();
    assert!(!is_net(&points));
}

/// The parts of a pixel's samples are one point set, whatever they are counted by.
#[test]
fn parts_of_samples_are_nets() {
    for (samples, parts) in [(1u32, 16u32), (4, 4), (8, 64)] {
        let whole = |s| Sampler::new(SequenceKind::Sobol, 3, 9, s, samples);
        let points: Vec<_> = (0..samples).flat_map(|s| (0..parts).map(move |i| whole(s).part(i, parts).u2(Dim(5)))).collect();
        assert!(is_net(&points), "{samples} x {parts}");
        // One sample's parts alone, too.
        assert!(is_net(&points[points.len() - parts as usize..]), "{parts} of {samples}");
    }
    // Strata of the parts: one in each, over all samples.
    let part = |i: u32| Sampler::new(SequenceKind::Stratified, 1, 5, i / 6, 10).part(i % 6, 6);
    let mut cells: Vec<_> = (0..60).map(|i| (f64::from(part(i).u1(Dim(3))) * 60.0) as u32).collect();
    cells.sort_unstable();
    cells.dedup();
    assert!(cells.len() >= 59, "{cells:?}");
    // Where the numbers of parts run over 32 bits another set begins: pixels far apart do not meet in the same points.
    let far = |x| Sampler::on_screen(SequenceKind::Sobol, 3, [x, 0], 0, 4).part(0, 1 << 20).u2(Dim(5));
    assert_ne!(far(3), far(3 + 64));
}

#[test]
fn strata_hold_one_sample_each() {
    for count in [1u32, 2, 7, 16, 100, 1000] {
        for round in 0..2 {
            let mut cells: Vec<_> = (0..count)
                .map(|s| Sampler::new(SequenceKind::Stratified, 1, 5, s + round * count, count).u1(Dim(3)))
                .map(|u| (f64::from(u) * f64::from(count)) as u32)
                .collect();
            cells.sort_unstable();
            cells.dedup();
            // Rounding may carry a sample at the border into the next stratum.
            assert!(cells.len() as u32 + 1 >= count, "{count}");
        }
        let columns = count.isqrt();
        let rows = count.div_ceil(columns);
        let grid = Vec2::new(columns as f32, rows as f32);
        let points = (0..count).map(|s| Sampler::new(SequenceKind::Stratified, 1, 5, s, count).u2(Dim(3)) * grid);
        let mut cells: Vec<_> = points.map(|p| (p.x as u32, p.y as u32)).collect();
        cells.sort_unstable();
        cells.dedup();
        assert!(cells.len() as u32 + 1 >= count, "{count}");
    }
}

/// The same decision over many pixels: uniform and independent, whatever the kind. Chi-square at α = 1e-6 on each of 24 sets.
#[test]
fn numbers_are_uniform_over_pixels() {
    for kind in KINDS {
        for (dim, sample, count) in [(0, 0, 16), (5, 3, 16), (400, 1, 1), (16, 20, 16)] {
            let mut pixel = 0;
            let report = ChiSquareTest::new(Square).run(
                |_| {
                    pixel += 1;
                    Some(Sampler::new(kind, 7, pixel, sample, count).u2(Dim(dim)))
                },
                |_| 1.0,
            );
            assert!(report.passes(1e-6), "{kind:?} {dim} {sample}: {report}");
            let mut pixel = 0;
            let report = ChiSquareTest::new(Square).run(
                |_| {
                    pixel += 1;
                    let s = |dim| Sampler::new(kind, 7, pixel, sample, count).u1(Dim(dim));
                    Some(Vec2::new(s(dim), s(dim + 1)))
                },
                |_| 1.0,
            );
            assert!(report.passes(1e-6), "{kind:?} {dim} {sample}: {report}");
        }
    }
}

/// Within one pixel, pairs of coordinates from different dimensions look like independent uniform numbers: correlation and a 4 × 4 table.
#[test]
fn dimensions_and_pixels_are_independent() {
    let n = 1024u32;
    for kind in KINDS {
        let (mut correlation, mut table, mut pixels) = (Moments::default(), Moments::default(), Moments::default());
        for key in 0..400 {
            let u = |pixel: u64, dim: u32, s: u32| Sampler::new(kind, 11, pixel, s, n).u2(Dim(dim)).as_dvec2() - 0.5;
            let (mut sum, mut other) = (0.0, 0.0);
            let mut cells = [0.0f64; 16];
            for s in 0..n {
                let (a, b, c) = (u(key, 4, s), u(key, 5, s), u(key + 1000, 4, s));
                sum += a.x * b.x;
                other += a.x * c.x;
                cells[((a.y + 0.5) * 4.0) as usize * 4 + ((b.x + 0.5) * 4.0) as usize] += 1.0;
            }
            correlation.add(sum * 12.0 / f64::from(n).sqrt());
            pixels.add(other * 12.0 / f64::from(n).sqrt());
            table.add(cells.iter().map(|c| (c - 64.0).powi(2) / 64.0).sum());
        }
        // Mean zero at 1e-6. The variance is 1 for independent numbers, 1.6 for exact nested shuffles (they keep samples 2k and 2k + 1 in different
        // halves of every dimension, by chance the same or opposite ones); of 400, it is known to 7 %.
        let variance = if kind == SequenceKind::Sobol { 1.2..2.0 } else { 0.7..1.3 };
        for m in [correlation, pixels] {
            assert!(t_test(&m, 0.0).p_value > 1e-6 && variance.contains(&m.variance()), "{kind:?} {m:?}");
        }
        // χ² with 9 (margins fixed) to 15 degrees of freedom, its variance 18 to 30; greater where pairs are kept.
        assert!((8.0..16.0).contains(&table.mean) && table.variance() < 110.0, "{kind:?} {table:?}");
    }
}

/// E(mean of f) is right at any number of samples, and the variance of a smooth integrand falls like N^-3 where it should.
#[test]
fn variance_falls_as_it_should() {
    let f = |u: Vec2| f64::from((3.0 * u.x).sin() * (u.y * u.y + 0.3));
    let exact = (1.0 - 3f64.cos()) / 3.0 * (1.0 / 3.0 + 0.3);
    let study = |kind: SequenceKind, n: u32| -> Moments {
        let mean = |pixel: u64| (0..n).map(|s| f(Sampler::new(kind, 1, pixel, s, n).u2(Dim(9)))).sum::<f64>() / f64::from(n);
        (0..600).map(mean).collect()
    };
    for kind in KINDS {
        for n in [1, 3, 16, 37, 256] {
            let m = study(kind, n);
            assert!(t_test(&m, exact).p_value > 1e-6, "{kind:?} {n}: {}", t_test(&m, exact));
        }
        let (few, many) = (study(kind, 16).variance(), study(kind, 256).variance());
        let exponent = -(many / few).ln() / 16f64.ln();
        // Variances of 600 are known to 6 %, so exponents to 0.03. Jittered strata: N^-2. Owen's: N^-3 but for a logarithm.
        let expected = match kind {
            SequenceKind::Independent => 0.9..1.1,
            SequenceKind::Stratified => 1.85..2.15,
            SequenceKind::Sobol => 2.6..3.2,
        };
        assert!(expected.contains(&exponent), "{kind:?}: variance falls like N^-{exponent:.2}");
    }
}

/// Neighbouring pixels share a net on the screen: the mean over 4 × 4 pixels is much better than that of 16 independent pixels.
#[test]
fn errors_of_neighbours_cancel_on_the_screen() {
    let f = |u: Vec2| f64::from(u.x * u.x + u.y);
    let block = |seed: u64, screen: bool| {
        let pixel = |i: u32| match screen {
            true => Sampler::on_screen(SequenceKind::Sobol, seed, [4 + i % 4, 8 + i / 4], 0, 1),
            false => Sampler::new(SequenceKind::Sobol, seed, u64::from(i), 0, 1),
        };
        (0..16).map(|i| f(pixel(i).u2(Dim(2)))).sum::<f64>() / 16.0
    };
    let variance = |screen: bool| (0..500).map(|seed| block(seed, screen)).collect::<Moments>().variance();
    assert!(variance(true) < 0.05 * variance(false), "{} {}", variance(true), variance(false));
}

#[test]
fn numbers_stay_below_one() {
    for kind in KINDS {
        for count in [0, 1, 3, u32::MAX] {
            for s in [0, 1, u32::MAX] {
                for sampler in
                    [Sampler::new(kind, u64::MAX, u64::MAX, s, count), Sampler::on_screen(kind, 0, [u32::MAX; 2], s, count)]
                {
                    let u = (0..100).map(|d| sampler.u2(Dim(d))).fold(Vec2::ZERO, Vec2::max);
                    assert!(u.max_element() < 1.0 && u.min_element() >= 0.0 && sampler.u1(Dim(7)) < 1.0);
                }
            }
        }
    }
}
