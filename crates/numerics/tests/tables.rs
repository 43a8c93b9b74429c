//! Tables against their densities and their inverses, with zeros, lopsided weights and u at the ends.

use etendue_check::{ChiSquareTest, Interval, Square, integrate_square, rng};
use etendue_numerics::table::{Bilinear2D, Cells, Sheets, Table1D, Table2D, Warp, sample_linear};
use etendue_numerics::{Vec2, math::ONE_MINUS_EPSILON};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const ALPHA: f64 = 1e-6;

#[test]
fn draws_follow_the_table() {
    let table = Table1D::new(&[0.0, 3.0, 0.0, 0.5, 10.0, 0.0]);
    let report = ChiSquareTest::new(Interval(0.0, 1.0)).run(|u| Some(table.sample(u[0]).0), |x| table.pdf(x));
    assert!(report.passes(ALPHA), "{report}");
    assert!((table.pdf(0.25) - 6.0 * 3.0 / 13.5).abs() < 1e-6 && table.pdf(0.1) == 0.0 && table.pdf(1.0) == 0.0);
    assert_eq!(table.sum(), 13.5);

    let f: Vec<f32> = (0..7 * 5).map(|i| ((i * i) % 11) as f32).collect();
    let table = Table2D::new(&f, 7, 5);
    let report = ChiSquareTest::new(Square).run(|u| Some(table.sample(Vec2::new(u[0], u[1])).0), |p| table.pdf(p));
    assert!(report.passes(ALPHA), "{report}");
    let p = Vec2::new(2.5 / 7.0, 3.5 / 5.0);
    assert!((table.pdf(p) - 35.0 * f[3 * 7 + 2] / f.iter().sum::<f32>()).abs() < 1e-5);

    let table = Bilinear2D::new(&f, 7, 5).unwrap();
    let report = ChiSquareTest::new(Square).run(|u| Some(table.sample(Vec2::new(u[0], u[1])).0), |p| table.pdf(p));
    assert!(report.passes(ALPHA), "{report}");
    // The density is the interpolant over its integral: checked at a node and in the middle of a patch.
    let scale = table.integral() as f32;
    assert!((table.pdf(Vec2::new(3.0 / 6.0 + 1e-6, 2.0 / 4.0 + 1e-6)) * scale - f[2 * 7 + 3]).abs() < 1e-3);
    let middle = (f[8] + f[9] + f[15] + f[16]) / 4.0;
    assert!((table.pdf(Vec2::new(1.5 / 6.0, 1.5 / 4.0)) * scale - middle).abs() < 1e-3);
    let mass = integrate_square(|x, y| f64::from(table.pdf(Vec2::new(x as f32, y as f32))));
    assert!((mass - 1.0).abs() < 1e-4, "{mass}");
}

/// Sheets for two parameters, one of them a sheet without weight: between them the density is what is drawn, and the inverse leads back.
#[test]
fn sheets_are_mixed_exactly() {
    let (w, h) = (5, 4);
    let axes = [vec![-1.0, 0.5], vec![0.0, 1.0, 3.0]];
    let nodes: Vec<f32> = (0..6 * w * h).map(|i| if i / (w * h) == 4 { 0.0 } else { ((i * i) % 13) as f32 }).collect();
    let sheets = Sheets::new([w, h], axes.clone(), nodes.clone()).expect("a table");
    // At a node of a sheet, halfway between two of the second parameter.
    let around = sheets.around([-1.0, 2.0]);
    let mean = 0.5 * (nodes[w * h + 7] + nodes[2 * w * h + 7]);
    assert!((sheets.eval(Vec2::new(0.5, 1.0 / 3.0), &around) - mean).abs() < 1e-5);

    let warp = Warp::new(sheets);
    for parameters in [[-0.3, 0.4], [0.5, 1.0], [9.0, 9.0], [-9.0, -9.0], [0.1, 2.5]] {
        let around = warp.around(parameters);
        let report =
            ChiSquareTest::new(Square).run(|u| Some(warp.sample(Vec2::new(u[0], u[1]), &around).0), |p| warp.pdf(p, &around));
        assert!(report.passes(ALPHA), "{parameters:?}: {report}");
        let mass = integrate_square(|x, y| f64::from(warp.pdf(Vec2::new(x as f32, y as f32), &around)));
        assert!((mass - 1.0).abs() < 1e-4, "{parameters:?}: {mass}");
        let mut r = rng(4);
        for _ in 0..2_000 {
            let u = r.u2();
            let (p, density) = warp.sample(u, &around);
            let (back, again) = warp.invert(p, &around);
            assert!((back - u).abs().max_element() < 1e-4 && (density - again).abs() < 1e-3 * density.max(1.0), "{u} {back}");
        }
        for u in [Vec2::ZERO, Vec2::splat(ONE_MINUS_EPSILON)] {
            let (p, density) = warp.sample(u, &around);
            assert!(p.min_element() >= 0.0 && p.max_element() < 1.0 && density.is_finite(), "{u} {p} {density}");
        }
    }
    assert!(Sheets::new([1, 4], [], vec![0.0; 4]).is_none() && Sheets::new([2, 2], [], vec![0.0; 3]).is_none());
    assert!(Sheets::new([2, 2], [vec![0.0, 0.0]], vec![0.0; 8]).is_none() && Sheets::new([2, 2], [vec![]], vec![]).is_none());
}

#[test]
fn discrete_draws_leave_a_fresh_uniform_number() {
    let table = Table1D::new(&[1.0, 0.0, 7.0, 2.0]);
    let mut counts = [0usize; 4];
    let report = ChiSquareTest::new(Interval(0.0, 1.0)).run(
        |u| {
            let (i, p, rest) = table.sample_discrete(u[0]);
            counts[i] += 1;
            assert_eq!(p, table.probability(i));
            Some(rest)
        },
        |_| 1.0,
    );
    assert!(report.passes(ALPHA), "{report}");
    let n = counts.iter().sum::<usize>() as f64;
    for (count, p) in counts.iter().zip([0.1, 0.0, 0.7, 0.2]) {
        // Six standard deviations.
        assert!((*count as f64 - n * p).abs() <= 6.0 * (n * p * (1.0 - p)).sqrt(), "{counts:?}");
    }
    assert_eq!(table.probability(4), 0.0);
}

#[test]
fn tables_without_weight_are_uniform() {
    for f in [&[][..], &[0.0, 0.0, 0.0], &[f32::NAN, -1.0, f32::INFINITY]] {
        let table = Table1D::new(f);
        assert_eq!(table.sum(), 0.0);
        assert!((table.sample(0.7).0 - 0.7).abs() < 1e-6 && (table.pdf(0.7) - 1.0).abs() < 1e-6);
    }
    assert!((Table2D::new(&[0.0; 12], 4, 3).pdf(Vec2::splat(0.4)) - 1.0).abs() < 1e-6);
    assert!((Bilinear2D::new(&[0.0; 12], 4, 3).unwrap().pdf(Vec2::splat(0.4)) - 1.0).abs() < 1e-6);
    assert!(Bilinear2D::new(&[0.0; 11], 4, 3).is_none() && Bilinear2D::new(&[0.0; 3], 1, 3).is_none());
    assert_eq!(sample_linear(0.3, 0.0, 0.0), 0.3);
    // Values whose sum overflows f32.
    assert!((Table2D::new(&[3e38; 12], 4, 3).pdf(Vec2::splat(0.4)) - 1.0).abs() < 1e-6);
}

#[test]
fn large_tables_are_searched_right() {
    // Weights over twelve orders of magnitude: the guide and the search must agree with a walk over the steps.
    let mut r = rng(9);
    let f: Vec<f32> = (0..20_000).map(|_| 10f32.powf(12.0 * r.u1() - 6.0) * f32::from(u8::from(r.u1() > 0.3))).collect();
    let table = Table1D::new(&f);
    for _ in 0..20_000 {
        let u = r.u1();
        let (i, p, rest) = table.sample_discrete(u);
        let walked: f32 = table.invert((i as f32 + 0.5) / f.len() as f32);
        assert!(p > 0.0 && f[i] > 0.0 && (0.0..1.0).contains(&rest), "{u} {i}");
        assert!((walked - u).abs() <= 0.5 * p + 1e-6, "{u} {i} {walked} {p}");
    }
}

/// Draws of many at once are those of each alone; cells of zero, long runs of them, and rows without weight are never drawn.
#[test]
fn many_draws_at_once_are_those_of_each() {
    const N: usize = 64;
    let mut r = rng(8);
    for (width, height, share) in [(1, 1, 1.0), (3, 2, 0.5), (200, 40, 0.9), (200, 40, 0.02), (1, 300, 0.1)] {
        let f: Vec<f32> = (0..width * height).map(|_| if r.u1() < share { r.u1() } else { 0.0 }).collect();
        let table = Table2D::new(&f, width, height);
        let mut cells = Cells::<N>::default();
        for count in [0, 1, 17, N] {
            let mut u = [[0.0; N]; 2];
            u.iter_mut().flatten().for_each(|u| *u = r.u1());
            (u[0][0], u[1][0]) = (0.0, ONE_MINUS_EPSILON);
            table.sample_discrete_each(count, &u, &mut cells);
            for (i, (x, y)) in u[0].iter().zip(&u[1]).enumerate().take(count) {
                let alone = table.sample_discrete(Vec2::new(*x, *y));
                let (column, row) = (cells.column[i] as usize, cells.row[i] as usize);
                assert_eq!((column, row, cells.probability[i], Vec2::new(cells.rest[0][i], cells.rest[1][i])), alone);
                assert!(table.sum() == 0.0 || f[row * width + column] > 0.0, "{column} {row}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn draws_have_the_density_they_say(f in prop::collection::vec(prop_oneof![Just(0.0f32), 0.0f32..1e-6, 0.0f32..1e6], 1..60), u in 0.0f32..1.0, v in 0.0f32..1.0) {
        let table = Table1D::new(&f);
        for u in [u, 0.0, ONE_MINUS_EPSILON] {
            let (x, p) = table.sample(u);
            prop_assert!((0.0..1.0).contains(&x) && p > 0.0, "{} {}", x, p);
            prop_assert_eq!(p, table.pdf(x));
            // Where the density is low, x cannot tell many u apart.
            prop_assert!((table.invert(x) - u).abs() <= 1e-6 + 2e-7 * p, "{} {}", u, table.invert(x));
        }
        let width = f.len().min(7);
        let table = Table2D::new(&f, width, f.len() / width);
        for u in [Vec2::new(u, v), Vec2::ZERO, Vec2::splat(ONE_MINUS_EPSILON)] {
            let (x, p) = table.sample(u);
            prop_assert!(p > 0.0 && x.min_element() >= 0.0 && x.max_element() < 1.0);
            prop_assert_eq!(p, table.pdf(x));
        }
        if let Some(table) = Bilinear2D::new(&f, width, f.len() / width) {
            for u in [Vec2::new(u, v), Vec2::splat(ONE_MINUS_EPSILON)] {
                let (x, p) = table.sample(u);
                prop_assert!(p >= 0.0 && x.min_element() >= 0.0 && x.max_element() < 1.0);
                // Patches may differ by 12 orders of magnitude; within one, rounding of x moves p by little.
                prop_assert!((p - table.pdf(x)).abs() <= 1e-4 * p.max(1.0), "{} {}", p, table.pdf(x));
            }
        }
    }
}
