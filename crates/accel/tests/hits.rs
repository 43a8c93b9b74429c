//! Hits against the slow truth, against each other, and where they end.

mod common;

use common::{Random, brute_force, cast, cast_each, every_path, grid, soup};
use etendue_accel::{BuildOptions, Builder, Hit};
use etendue_numerics::{Ray, Vec3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::default() })]

    /// Every ray hits what brute force in f64 says, at that distance; rays that pass an edge within rounding may differ.
    #[test]
    fn soup_agrees_with_brute_force(seed in any::<u64>(), n in 1_usize..300, duplicates in prop_oneof![Just(0.0_f32), Just(0.5)]) {
        let mut random = Random::new(seed);
        let mesh = soup(n, &mut random);
        let accels = every_path(&mesh.accel(&BuildOptions { duplicates, ..BuildOptions::default() }));
        for _ in 0..200 {
            let ray = Ray::new(1.5 * random.cube(), random.direction() * 10.0_f32.powf(4.0 * random.unit() - 2.0));
            let hit = cast(&accels, &ray);
            // well inside some triangle: must be hit, no later than there; hit: some triangle, a little grown, is there
            let inner = brute_force(&mesh, &ray, 1e-4);
            let outer = brute_force(&mesh, &ray, -1e-4);
            // how much t may be off: a few roundings of the coordinates, across the triangle's plane
            let error = |t: f64, i: usize| {
                let [a, b, c] = mesh.corners(i).map(|p| p.as_dvec3());
                1e-4 * t + 1e-6 / (b - a).cross(c - a).normalize().dot(ray.d.as_dvec3()).abs()
            };
            if let Some((t, i)) = inner {
                let hit = hit.expect("a hit");
                prop_assert!(f64::from(hit.t) <= t + error(t, i), "{hit:?} is behind {t}");
            }
            if let Some(hit) = hit {
                let (t, i) = outer.expect("no hit");
                prop_assert!(f64::from(hit.t) >= t - error(t, i), "{hit:?} is before {t}");
                let [a, b, c] = mesh.corners(hit.primitive as usize);
                let p = a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v;
                // grazing rays multiply rounding: measure across the ray, not along it
                let off = (p - ray.o).cross(ray.d.normalize()).length();
                prop_assert!(off < 1e-5, "the point is {off} beside the ray");
                prop_assert!(hit.u >= 0.0 && hit.v >= 0.0 && hit.u + hit.v <= 1.0 + 1e-6);
            }
        }
    }

    /// Many rays at once hit what each hits alone: small trees and large ones, rays of all kinds, some of them no rays at all.
    #[test]
    fn company_does_not_matter(seed in any::<u64>(), n in 1_usize..150, count in 0_usize..300) {
        let mut random = Random::new(seed);
        let accels = every_path(&soup(n, &mut random).accel(&BuildOptions::default()));
        let rays: Vec<Ray> = (0..count)
            .map(|i| {
                let d = if i % 7 == 0 { [Vec3::X, -Vec3::Y, Vec3::Z][i % 3] } else { random.direction() };
                let o = if i % 31 == 0 { Vec3::splat(f32::NAN) } else { random.cube() };
                Ray::new(o, d).until(if i % 5 == 0 { random.unit() } else { f32::INFINITY })
            })
            .collect();
        accels.iter().for_each(|accel| cast_each(accel, &rays));
    }

    /// t_max is where a ray ends: open at the hit itself, and the hit before it does not depend on it.
    #[test]
    fn rays_end_at_t_max(seed in any::<u64>()) {
        let mut random = Random::new(seed);
        let mesh = soup(100, &mut random);
        let accels = every_path(&mesh.accel(&BuildOptions::default()));
        for _ in 0..100 {
            let ray = Ray::new(random.cube(), random.direction());
            let Some(hit) = cast(&accels, &ray) else { continue };
            prop_assert!(hit.t > 0.0);
            prop_assert_eq!(cast(&accels, &ray.until(hit.t)), None);
            prop_assert_eq!(cast(&accels, &ray.until(hit.t.next_up())), Some(hit));
            prop_assert_eq!(cast(&accels, &ray.until(0.5 * hit.t)), None);
        }
    }

    /// Scene and ray scaled by a power of two, in position and in length of the direction: t and barycentrics follow exactly. Beyond
    /// what f32 can square, up to rounding.
    #[test]
    fn scale_does_not_matter(seed in any::<u64>(), position in -80_i32..100, length in -60_i32..60) {
        let mut random = Random::new(seed);
        let (mesh, scale) = (soup(50, &mut random), 2.0_f32.powi(position));
        let accels = every_path(&mesh.accel(&BuildOptions::default()));
        let scaled = every_path(&mesh.map(|p| p * scale).accel(&BuildOptions::default()));
        for _ in 0..50 {
            let ray = Ray::new(random.cube(), random.direction());
            let other = Ray::new(ray.o * scale, ray.d * 2.0_f32.powi(length));
            let (a, b) = (cast(&accels, &ray), cast(&scaled, &other));
            if position - length > 100 {
                continue; // t would leave f32's range
            }
            // the two may take different branches where the ray passes an edge within rounding
            if let (Some(a), Some(b)) = (a, b) && a.primitive == b.primitive {
                let t = f64::from(a.t) * 2.0_f64.powi(position - length);
                prop_assert!((f64::from(b.t) - t).abs() <= 1e-3 * t, "{a:?} {b:?}");
                prop_assert!((a.u - b.u).abs() < 1e-3 && (a.v - b.v).abs() < 1e-3, "{a:?} {b:?}");
            } else if a.is_some() != b.is_some() {
                prop_assert!(brute_force(&mesh, &ray, 1e-4).is_none(), "one of {a:?} {b:?} is missing");
            }
        }
    }
}

#[test]
fn closed_form_on_one_triangle() {
    let mesh = common::Mesh { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y], indices: vec![[0, 1, 2]] };
    let accels = every_path(&mesh.accel(&BuildOptions::default()));
    for (u, v) in [(0.25, 0.25), (0.5, 0.125), (0.125, 0.5), (0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (0.0, 0.5)] {
        for side in [1.0, -1.0] {
            let ray = Ray::new(Vec3::new(u, v, 2.0 * side), Vec3::new(0.0, 0.0, -4.0 * side));
            let hit = Hit { t: 0.5, u, v, geometry: 0, primitive: 0, instance: Hit::NO_INSTANCE };
            assert_eq!(cast(&accels, &ray), Some(hit));
        }
    }
    for (u, v) in [(-0.01, 0.5), (0.5, -0.01), (0.51, 0.5), (2.0, 2.0)] {
        assert_eq!(cast(&accels, &Ray::new(Vec3::new(u, v, 1.0), -Vec3::Z)), None);
    }
    // behind, beside, in the plane
    assert_eq!(cast(&accels, &Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::Z)), None);
    assert_eq!(cast(&accels, &Ray::new(Vec3::new(0.25, 0.25, 0.0), Vec3::Z)), None);
    assert_eq!(cast(&accels, &Ray::new(Vec3::new(-1.0, 0.25, 0.0), Vec3::X)), None);
}

/// Near a large wall the distance is right to the last digits, whatever the distance of the wall's corners.
#[test]
fn distance_to_a_large_wall_is_accurate() {
    let wall = grid(1, 1, false, |u, v| Vec3::new(3.0, 2000.0 * u - 1000.0, 2000.0 * v - 1000.0));
    let accels = every_path(&wall.accel(&BuildOptions::default()));
    let mut random = Random::new(4);
    for _ in 0..10_000 {
        let ray = Ray::new(Vec3::new(3.0 - 0.01 * random.unit() - 1e-6, 1.0 + random.unit(), -random.unit()), random.direction());
        let exact = (3.0 - f64::from(ray.o.x)) / f64::from(ray.d.x);
        match cast(&accels, &ray) {
            Some(hit) => assert!((f64::from(hit.t) / exact - 1.0).abs() < 1e-6, "{hit:?} {exact}"),
            None => assert!(!(0.0..=900.0).contains(&exact), "{ray:?} {exact}"),
        }
    }
}

/// Of a hundred thousand triangles in one place the first is hit, and the build neither hangs nor overflows.
#[test]
fn duplicates_are_fine() {
    let one = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let mesh = common::Mesh { positions: one.to_vec(), indices: vec![[0, 1, 2]; 100_000] };
    let accels = every_path(&mesh.accel(&BuildOptions::default()));
    let hit = cast(&accels, &Ray::new(Vec3::new(0.2, 0.2, 1.0), -Vec3::Z)).expect("a hit");
    assert_eq!((hit.t, hit.primitive), (1.0, 0));
}

/// Concentric triangles: all centroids equal, all boxes different.
#[test]
fn equal_centroids_are_fine() {
    let mut mesh = common::Mesh::default();
    for k in 0..2000_u32 {
        let s = 1.0 + k as f32;
        mesh.positions.extend([Vec3::new(-s, -s, s), Vec3::new(s, -s, -s), Vec3::new(0.0, s, 0.0)]);
        mesh.indices.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    let accels = every_path(&mesh.accel(&BuildOptions::default()));
    let mut random = Random::new(5);
    for _ in 0..200 {
        let ray = Ray::new(3000.0 * random.cube(), random.direction());
        let hit = cast(&accels, &ray);
        if let Some((t, _)) = brute_force(&mesh, &ray, 1e-4) {
            assert!(f64::from(hit.expect("a hit").t) <= 1.0001 * t);
        }
    }
}

#[test]
fn nothing_is_never_hit() {
    let empty = every_path(&Builder::new().build(&BuildOptions::default()).expect("builds"));
    assert_eq!(cast(&empty, &Ray::new(Vec3::ZERO, Vec3::X)), None);
    assert!(empty[0].bounds().is_empty());

    // no area, corners that are not finite, indices that point nowhere
    let (inf, nan) = (Vec3::splat(f32::INFINITY), Vec3::splat(f32::NAN));
    let positions = vec![Vec3::ZERO, Vec3::X, 2.0 * Vec3::X, inf, nan, Vec3::ZERO, Vec3::Y];
    let indices = vec![[0, 1, 2], [0, 0, 1], [1, 1, 1], [0, 1, 3], [0, 4, 1], [0, 5, 1], [0, 1, 99]];
    let mut mesh = common::Mesh { positions, indices };
    let accels = every_path(&mesh.accel(&BuildOptions::default()));
    let mut random = Random::new(6);
    let rays: Vec<Ray> = (0..500).map(|_| Ray::new(3.0 * random.cube(), random.direction())).collect();
    let through = |p: Vec3| Ray::new(p + Vec3::Z, -Vec3::Z);
    for ray in rays.iter().chain([&through(Vec3::ZERO), &through(Vec3::X), &through(0.5 * Vec3::X)]) {
        assert_eq!(cast(&accels, ray), None);
    }
    assert_eq!(accels[0].stats().triangles, 0);

    // among them one that is sound
    mesh.indices.push([0, 1, 6]);
    let accels = every_path(&mesh.accel(&BuildOptions::default()));
    assert_eq!(cast(&accels, &through(Vec3::new(0.25, 0.25, 0.0))).map(|h| h.primitive), Some(7));
}

/// Rays that are none, and rays at the ends of the number range: an answer, at once.
#[test]
fn odd_rays_are_fine() {
    let mut random = Random::new(7);
    let mesh = soup(1000, &mut random);
    let accels = every_path(&mesh.accel(&BuildOptions::default()));
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    for x in odd {
        for axis in 0..3 {
            let mut broken = Vec3::new(0.1, 0.2, 0.3);
            broken[axis] = x;
            assert_eq!(cast(&accels, &Ray::new(broken, Vec3::X)), None);
            assert_eq!(cast(&accels, &Ray::new(Vec3::ZERO, broken)), None);
        }
    }
    assert_eq!(cast(&accels, &Ray::new(Vec3::ZERO, Vec3::ZERO)), None);
    assert_eq!(cast(&accels, &Ray::new(Vec3::ZERO, Vec3::X).until(f32::NAN)), None);
    assert_eq!(cast(&accels, &Ray::new(Vec3::ZERO, Vec3::X).until(0.0)), None);
    assert_eq!(cast(&accels, &Ray::new(Vec3::ZERO, Vec3::X).until(-1.0)), None);

    // a wall that no ray along x can miss, hit from near and far, slow and fast
    let wall = grid(3, 3, false, |u, v| Vec3::new(1.0, 2.0 * u - 1.0, 2.0 * v - 1.0));
    let accels = every_path(&wall.accel(&BuildOptions::default()));
    for length in [1e-44_f32, 1e-38, 1e-30, 1e-20, 1.0, 1e20, 1e30, 3e38] {
        let hit = cast(&accels, &Ray::new(Vec3::new(0.0, 0.1, 0.2), length * Vec3::X));
        let t = 1.0 / f64::from(length);
        if t < 1e38 {
            let hit = hit.expect("a hit");
            assert!((f64::from(hit.t) / t - 1.0).abs() < 1e-6, "{hit:?} {t}");
        }
    }
    for far in [1e10_f32, 1e19, 1e30] {
        let hit = cast(&accels, &Ray::new(Vec3::new(-far, 0.1, 0.2), Vec3::X)).expect("a hit");
        assert!((hit.t / far - 1.0).abs() < 1e-6);
    }
}

/// Directions with zero components, and origins on the planes of boxes: slabs that are touched count.
#[test]
fn axis_aligned_rays_meet_flat_boxes() {
    for axis in 0..3 {
        // a checkerboard in the plane x[axis] = 0.5
        let turn = |a: f32, b: f32, c: f32| {
            let mut p = Vec3::ZERO;
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (a, b, c);
            p
        };
        let mesh = grid(16, 16, false, |u, v| turn(0.5, u, v));
        let accels = every_path(&mesh.accel(&BuildOptions::default()));
        for i in 0..=64 {
            for j in 0..=64 {
                let (b, c) = (i as f32 / 64.0, j as f32 / 64.0);
                for (from, d) in [(-1.0, 1.0), (2.0, -1.0), (0.5_f32.next_down(), 1.0), (0.5_f32.next_up(), -0.25)] {
                    let ray = Ray::new(turn(from, b, c), turn(d, 0.0, -0.0));
                    let hit = cast(&accels, &ray).unwrap_or_else(|| panic!("{ray:?} slips through"));
                    assert_eq!(hit.t, (0.5 - from) / d);
                }
            }
        }
    }
}
