//! From inside a closed surface every ray hits, above all those aimed at edges and corners. A test that cannot be lucky: each mesh gets
//! tens of thousands of rays whose exact target is shared by two or more triangles.

mod common;

use common::{Mesh, Random, cast, closed_surface, every_path, grid};
use etendue_accel::{BuildOptions, Builder, Hit, NoShapes};
use etendue_numerics::{Ray, Transform, Vec3};
use std::sync::Arc;

/// Rays from `from` at corners, points on edges (computed in f32, so beside them by rounding) and anywhere; none may escape.
fn nothing_escapes(mesh: &Mesh, duplicates: f32, rays: usize, random: &mut Random, from: impl Fn(&mut Random) -> Vec3) {
    let accels = every_path(&mesh.accel(&BuildOptions { duplicates, ..BuildOptions::default() }));
    for k in 0..rays {
        let o = from(random);
        let corners = mesh.corners(random.below(mesh.indices.len()));
        let (a, b) = (corners[random.below(3)], corners[random.below(3)]);
        let target = match k % 4 {
            0 => a,
            1 => 0.5 * (a + b),
            2 => a + (b - a) * random.unit(),
            _ => o + random.direction(),
        };
        let d = match k % 3 {
            0 => target - o,
            1 => (target - o).normalize(),
            _ => (target - o) * 10.0_f32.powf(6.0 * random.unit() - 3.0),
        };
        if d == Vec3::ZERO || !d.is_finite() {
            continue;
        }
        let ray = Ray::new(o, d);
        assert!(cast(&accels, &ray).is_some(), "{ray:?} escapes");
    }
}

#[test]
fn bumpy_sphere_is_tight() {
    let mut random = Random::new(1);
    for (n, bumps) in [(4, 0.0), (16, 0.1), (60, 0.2)] {
        let mesh = closed_surface(n, bumps);
        nothing_escapes(&mesh, 0.0, 10_000, &mut random, |r| 0.2 * r.cube());
        nothing_escapes(&mesh, 1.0, 5_000, &mut random, |_| Vec3::ZERO);
    }
}

/// Needles and plates: the triangles are up to a million times longer than wide.
#[test]
fn stretched_sphere_is_tight() {
    let mut random = Random::new(2);
    for scale in [Vec3::new(1000.0, 1.0, 0.001), Vec3::new(1e-4, 30.0, 1.0), Vec3::new(1.0, 1.0, 1e-6)] {
        let mesh = closed_surface(24, 0.1).map(|p| p * scale);
        nothing_escapes(&mesh, 0.5, 10_000, &mut random, |r| 0.2 * r.cube() * scale);
    }
}

/// Far from the origin, very large, very small.
#[test]
fn moved_and_scaled_sphere_is_tight() {
    let mut random = Random::new(3);
    for (scale, offset) in
        [(1.0, 1e4), (1.0, 3e5), (1e-9, 0.0), (1e-15, 0.0), (1e-20, 0.0), (1e12, 0.0), (1e17, 1e17), (1e25, 0.0), (1e35, 0.0)]
    {
        let offset = Vec3::new(1.0, -0.7, 0.3) * offset;
        let mesh = closed_surface(16, 0.1).map(|p| p * scale + offset);
        nothing_escapes(&mesh, 0.25, 4_000, &mut random, |r| 0.2 * r.cube() * scale + offset);
    }
}

/// A room of axis-aligned walls: flat boxes, directions with zeros, corners that three walls share.
#[test]
fn room_is_tight() {
    let mut room = Mesh::default();
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            let wall = grid(6, 6, false, |u, v| {
                let mut p = Vec3::ZERO;
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, u, v);
                p
            });
            let base = room.positions.len() as u32;
            room.positions.extend(wall.positions);
            // along an edge of the room both walls have the same corners, bit for bit
            room.indices.extend(wall.indices.iter().map(|t| t.map(|i| i + base)));
        }
    }
    let mut random = Random::new(4);
    nothing_escapes(&room, 0.0, 20_000, &mut random, |r| Vec3::splat(0.5) + 0.4 * r.cube());
    nothing_escapes(&room, 0.0, 10_000, &mut random, |_| Vec3::splat(0.5));
    // from a point that shares coordinates with many corners, so that directions have zeros
    nothing_escapes(&room, 1.0, 20_000, &mut random, |r| {
        Vec3::new([1.0 / 6.0, 2.0 / 6.0, 0.5][r.below(3)], [4.0 / 6.0, 0.4, 0.5][r.below(3)], [5.0 / 6.0, 0.6, 0.5][r.below(3)])
    });
}

/// A height field seen straight from above, each ray through a corner exactly; axis-aligned, so half of the tests are 0 · something.
#[test]
fn terrain_is_tight_from_above() {
    let mut random = Random::new(5);
    for axis in 0..3 {
        let turn = |u: f32, v: f32, h: f32| {
            let mut p = Vec3::ZERO;
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (h, u, v);
            p
        };
        let mut heights = Random::new(6);
        let heights: Vec<f32> = (0..65 * 65).map(|_| 0.1 * heights.unit()).collect();
        let mesh = grid(64, 64, false, |u, v| turn(u, v, heights[(v * 64.0).round() as usize * 65 + (u * 64.0).round() as usize]));
        let accels = every_path(&mesh.accel(&BuildOptions::default()));
        for (i, &p) in mesh.positions.iter().enumerate() {
            let up = turn(0.0, 0.0, 1.0);
            let hit = cast(&accels, &Ray::new(p + up, -up)).unwrap_or_else(|| panic!("corner {i} leaks"));
            assert!((hit.t - 1.0).abs() < 1e-6);
            let along = turn(random.unit(), random.unit(), 0.0);
            let ray = Ray::new(turn(along[(axis + 1) % 3], along[(axis + 2) % 3], 1.0), -up);
            assert!(cast(&accels, &ray).is_some(), "{ray:?} leaks");
        }
    }
}

/// The same through an affine map: what the map rounds, it rounds for the whole inner mesh alike.
#[test]
fn instance_is_tight() {
    let mut random = Random::new(7);
    let mesh = closed_surface(24, 0.15);
    let inner = Arc::new(mesh.accel(&BuildOptions::default()));
    for _ in 0..20 {
        let matrix = glam::DMat4::from_cols(
            random.cube().as_dvec3().extend(0.0),
            random.cube().as_dvec3().extend(0.0),
            random.cube().as_dvec3().extend(0.0),
            (100.0 * random.cube()).as_dvec3().extend(1.0),
        );
        let Some(to_outer) = Transform::new(matrix).filter(|_| glam::DMat3::from_mat4(matrix).determinant().abs() > 0.05) else {
            continue;
        };
        let mut builder = Builder::new();
        let tree = builder.add_tree(inner.clone());
        builder.add_instance(tree, &to_outer, 9);
        let accels = every_path(&builder.build(&BuildOptions::default()).expect("builds"));
        for k in 0..2000 {
            let o = to_outer.point(0.2 * random.cube());
            let corners = mesh.corners(random.below(mesh.indices.len()));
            let target = if k % 2 == 0 { corners[0] } else { 0.5 * (corners[0] + corners[1]) };
            let hit = cast(&accels, &Ray::new(o, to_outer.point(target) - o));
            assert_eq!(hit.map(|h| h.instance), Some(9));
        }
    }
    assert_eq!(inner.closest(&Ray::new(Vec3::ZERO, Vec3::X), &NoShapes).map(|h| h.instance), Some(Hit::NO_INSTANCE));
}
