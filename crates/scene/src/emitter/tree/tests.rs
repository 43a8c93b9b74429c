//! The light tree held to sums, counts and reachability.

use super::{Descent, LightTree, NONE, TINTED, WIDTH};
use crate::emitter::LightBounds;
use crate::emitter::record::LightReference;
use etendue_check::{Rng, chi_square_p, family_wise, rng};
use etendue_numerics::warp::square_to_sphere;
use etendue_numerics::wide::Width;
use etendue_numerics::{Bounds3, Vec3};

/// Triangles strewn about the unit cube, as bounds, some of them spots and points.
fn strewn(n: usize, seed: u64) -> Vec<LightBounds> {
    let mut r = rng(seed);
    let light = |_| {
        let corner = Vec3::from(r.u3());
        let size = 0.05 * r.u1() * r.u1();
        let corners = [Vec3::ZERO, square_to_sphere(r.u2()) * size, square_to_sphere(r.u2()) * size].map(|d| corner + d);
        let (axis, intensity) = (square_to_sphere(r.u2()), 0.1 + 10.0 * r.u1().powi(4));
        let triangle =
            LightBounds { bounds: Bounds3::of(corners), center: corner, axis, cos_o: 1.0, cos_e: 0.0, intensity, even: 0.0 };
        match r.below(10) {
            0 => LightBounds::of_point(corner, intensity),
            1 => LightBounds { axis, cos_o: 1.0, cos_e: 0.8, ..LightBounds::of_point(corner, intensity) },
            _ => triangle,
        }
    };
    (0..n).map(light).collect()
}

/// A tree over lights of five tints in turn.
fn grown(lights: &[LightBounds]) -> LightTree {
    let tints: Vec<f32> = (0..lights.len()).map(|i| (i % 5) as f32 / 5.0).collect();
    LightTree::new(lights, &tints)
}

impl LightTree {
    /// One descent: a light and its probability.
    fn sample(&self, from: &LightReference, u: f64, tint: &mut f32) -> Option<(usize, f32)> {
        let mut descent = [self.descent(from, u, *tint, 1.0)];
        self.descend(&mut descent);
        *tint = descent[0].tint;
        descent[0].light().map(|i| (i, descent[0].probability))
    }
}

fn reference(r: &mut Rng) -> LightReference {
    let p = Vec3::from(r.u3()) * 1.4 - 0.2;
    match r.below(3) {
        0 => LightReference::point(p),
        kind => LightReference { p, n: square_to_sphere(r.u2()), one_sided: kind == 1, shared: false },
    }
}

#[test]
fn probabilities_sum_to_one() {
    // Where every light reaches every place nothing is lost; else a branch may promise light that none of its lights gives.
    let mut r = rng(2);
    for n in [1, 2, 3, 4, 5, 17, 300, 5000] {
        let lights = strewn(n, n as u64);
        let everywhere: Vec<_> = lights.iter().map(|l| LightBounds { cos_o: -1.0, cos_e: 0.0, even: l.intensity, ..*l }).collect();
        let (tree, complete) = (grown(&lights), grown(&everywhere));
        for _ in 0..20 {
            let from = reference(&mut r);
            let sum = |tree: &LightTree| (0..n).map(|i| f64::from(tree.probability(&from, i))).sum::<f64>();
            assert!(sum(&tree) < 1.0 + 1e-5, "{n} lights: {} at {from:?}", sum(&tree));
            if !from.one_sided {
                assert!((sum(&complete) - 1.0).abs() < 1e-5, "{n} lights: {} at {from:?}", sum(&complete));
            }
        }
    }
}

#[test]
fn lights_are_drawn_as_often_as_their_probability_says() {
    // Chi-square over the lights at each of 12 places; a false alarm in 1000 runs over all of them.
    let n = 200;
    let tree = grown(&strewn(n, 9));
    let (mut r, draws) = (rng(4), 100_000);
    let alpha = family_wise(1e-3, 12);
    for _ in 0..12 {
        let from = reference(&mut r);
        let (mut counts, mut none) = (vec![0f64; n], 0.0);
        for _ in 0..draws {
            match tree.sample(&from, r.u1_f64(), &mut r.u1()) {
                Some((i, p)) => {
                    counts[i] += 1.0;
                    let probability = tree.probability(&from, i);
                    assert!((p / probability - 1.0).abs() < 1e-4, "{p} and {probability}");
                }
                None => none += 1.0,
            }
        }
        let mut expected: Vec<f64> = (0..n).map(|i| f64::from(tree.probability(&from, i)) * f64::from(draws)).collect();
        expected.push(f64::from(draws) - expected.iter().sum::<f64>());
        counts.push(none);
        // Rare lights share a cell.
        let (mut x2, mut cells, mut rare) = (0.0, 0, (0.0, 0.0));
        for (o, e) in counts.iter().zip(&expected) {
            if *e < 10.0 {
                rare = (rare.0 + o, rare.1 + e);
            } else {
                x2 += (o - e) * (o - e) / e;
                cells += 1;
            }
        }
        x2 += (rare.0 - rare.1).powi(2) / rare.1.max(10.0);
        assert!(chi_square_p(x2, f64::from(cells)) > alpha, "{x2} over {cells} cells at {from:?}");
    }
}

#[test]
fn every_light_that_reaches_a_place_has_its_chance() {
    // A point of each light, seen exactly: wherever the cosines are above zero the probability must be.
    let lights = strewn(400, 11);
    let tree = grown(&lights);
    let mut r = rng(12);
    for _ in 0..60 {
        let from = reference(&mut r);
        for (i, light) in lights.iter().enumerate() {
            let d = (from.p - light.center).normalize();
            let leaves = light.cos_o < 0.0 || light.axis.dot(d) > light.cos_e + 1e-4;
            let arrives = from.n == Vec3::ZERO || if from.one_sided { from.n.dot(d) < -1e-4 } else { true };
            assert!(!(leaves && arrives) || tree.probability(&from, i) > 0.0, "light {i} {light:?} at {from:?}");
        }
    }
}

#[test]
fn near_and_bright_lights_are_preferred() {
    let at = |x: f32, intensity: f32| LightBounds::of_point(Vec3::new(x, 0.0, 0.0), intensity);
    let tree = grown(&[at(1.0, 1.0), at(3.0, 1.0), at(3.0, 9.0)]);
    let from = LightReference::point(Vec3::ZERO);
    let p: Vec<f32> = (0..3).map(|i| tree.probability(&from, i)).collect();
    // Points: exactly by I/d².
    let total = 1.0 + 1.0 / 9.0 + 1.0;
    for (p, share) in p.iter().zip([1.0, 1.0 / 9.0, 1.0]) {
        assert!((p - share / total).abs() < 1e-5, "{p} and {}", share / total);
    }
}

#[test]
fn dark_lights_are_never_drawn_and_odd_numbers_do_no_harm() {
    let mut lights = strewn(50, 3);
    lights[7].intensity = 0.0;
    lights[8].intensity = f32::NAN;
    lights[9].intensity = f32::INFINITY;
    let tree = grown(&lights);
    let from = LightReference::point(Vec3::splat(0.5));
    assert!([7, 8, 9, 50].iter().all(|i| tree.probability(&from, *i) == 0.0));
    // Where a light is, and the ends of the unit interval.
    for light in &lights {
        let from = LightReference::point(light.bounds.min);
        for u in [0.0, 0.5, 1.0 - f64::EPSILON] {
            let Some((i, p)) = tree.sample(&from, u, &mut 0.5) else { continue };
            assert!(p > 0.0 && p <= 1.0 && ![7, 8, 9].contains(&i), "{i}: {p}");
        }
    }
    assert!(grown(&[]).is_empty());
    assert!(grown(&lights[7..10]).sample(&from, 0.5, &mut 0.5).is_none());
}

#[test]
fn lights_in_one_place_or_one_line_make_a_shallow_tree() {
    let one_place = vec![LightBounds::of_point(Vec3::ONE, 1.0); 20_000];
    let shrinking: Vec<_> = (0..20_000).map(|i| LightBounds::of_point(Vec3::X * 0.999f32.powi(i), 1.0)).collect();
    for lights in [one_place, shrinking] {
        let tree = grown(&lights);
        let depth = |mut place: u32| {
            let mut n = 0;
            while place != NONE {
                (place, n) = (tree.parent[place as usize / WIDTH], n + 1);
            }
            n
        };
        let deepest = tree.place.iter().map(|p| depth(*p)).max();
        assert!(deepest < Some(40), "{deepest:?}");
    }
}

#[test]
fn every_tint_gets_its_share_of_a_few_stratified_draws() {
    // 200 lights in one place, five tints in turn: 20 strata of the tint's number bring four of each, whatever the other number is.
    let mut r = rng(7);
    let tree =
        grown(&strewn(200, 1).iter().map(|l| LightBounds { intensity: 1.0, even: 1.0, cos_o: -1.0, ..*l }).collect::<Vec<_>>());
    assert!(tree.root & TINTED != 0);
    let from = LightReference::point(Vec3::splat(40.0));
    let mut counts = [0; 5];
    for i in 0..20 {
        let mut tint = (i as f32 + 0.5) / 20.0;
        let (light, _) = tree.sample(&from, r.u1_f64(), &mut tint).expect("a light");
        assert!((0.0..1.0).contains(&tint));
        counts[light % 5] += 1;
    }
    assert!(counts.iter().all(|n| (3..=5).contains(n)), "{counts:?}");
}

#[test]
fn descents_are_the_same_at_every_width_and_in_any_company() {
    let tree = grown(&strewn(3000, 21));
    let mut r = rng(22);
    let places: Vec<(LightReference, f64, f32)> = (0..500).map(|_| (reference(&mut r), r.u1_f64(), r.u1())).collect();
    let descents = || -> Vec<_> { places.iter().map(|(from, u, tint)| tree.descent(from, *u, *tint, 1.0)).collect() };
    let found = |d: &Descent<'_>| (d.light(), d.u.to_bits(), d.tint.to_bits(), d.probability.to_bits());
    let mut alone = descents();
    alone.chunks_mut(1).for_each(|d| tree.descend_at(Width::Plain, d));
    assert!(alone.iter().filter(|d| d.light().is_some()).count() > 400);
    for width in Width::available() {
        let mut together = descents();
        tree.descend_at(width, &mut together);
        assert!(together.iter().map(found).eq(alone.iter().map(found)), "{width:?}");
    }
}
