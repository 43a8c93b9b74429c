//! Rays that leave a surface never meet it again, and never slip through it: from any place, at any scale.

mod common;

use common::{World, direction, transform, translation};
use etendue_check::rng;
use etendue_description::MeshData;
use etendue_numerics::{Ray, Transform, Vec3};
use etendue_scene::Interaction;
use etendue_scene::shape::{Cylinder, Disk, Mesh, Shape, Sphere};
use glam::{DAffine3, DMat3, DMat4, DVec3};

/// Where worlds stand and how large they are.
fn places() -> Vec<Transform> {
    let mut places = Vec::new();
    for scale in [1e-4, 1.0, 3e3] {
        for far in [0.0, 1.0, 1e3, 1e6] {
            let turn = DMat4::from_rotation_x(0.7) * DMat4::from_rotation_y(2.1);
            let shift = DMat4::from_translation(DVec3::new(0.3, -1.0, 0.6) * far);
            // Beyond this f32 cannot tell the shape's sides apart.
            if far < 1e5 * scale {
                places.push(transform(shift * DMat4::from_scale(DVec3::splat(scale)) * turn));
            }
        }
    }
    places
}

/// Whether x lies so near an edge of the cube that `place` carried to the world that f32 may not know on which side of it.
fn on_edge_of_cube(place: &Transform, x: &Interaction) -> bool {
    let mut local = place.matrix().inverse().transform_point3(x.p.as_dvec3()).abs().to_array();
    local.sort_by(f64::total_cmp);
    let error = f64::from(x.p_error.length() / place.vector(Vec3::X).length());
    local[1] > 1.0 - 4.0 * error
}

/// A convex body, closed or flat: what leaves it outwards meets nothing, and what enters a closed one meets its inside.
fn check_convex(
    name: &str,
    world: &World,
    center: Vec3,
    size: f32,
    closed: bool,
    seed: u64,
    near_edge: impl Fn(&Interaction) -> bool,
) {
    let mut rng = rng(seed);
    let mut met = 0;
    for _ in 0..20_000 {
        let o = center + direction(&mut rng) * size * 3.0;
        let aim = center + direction(&mut rng) * size * rng.u1();
        let Some(x) = world.look(o, aim - o) else { continue };
        if near_edge(&x) {
            continue;
        }
        met += 1;
        assert!(x.n.dot(x.wo) != 0.0);
        for _ in 0..4 {
            let w = direction(&mut rng);
            // The side the ray came from is outside.
            let outwards = x.n.dot(w) * x.n.dot(x.wo) > 0.0;
            let again = world.hit(&x.spawn(w));
            if outwards || !closed {
                assert!(again.is_none(), "{name}: hit itself from {} towards {w}: {again:?}", x.p);
            } else {
                let again = again.unwrap_or_else(|| panic!("{name}: leaked from {} towards {w}", x.p));
                let through = world.see(&x.spawn(w)).expect("the same hit");
                assert!(through.n.dot(w) * x.n.dot(x.wo) > 0.0, "{name}: met its front from within at {again:?}");
            }
        }
    }
    assert!(met > 5_000, "{name}: met only {met} times");
}

fn convex_shapes(to_world: &Transform) -> Vec<(&'static str, Shape, bool)> {
    let m = to_world.matrix();
    let affine = DAffine3::from_mat4(m);
    vec![
        ("cube", Mesh::cube(to_world).into(), true),
        ("rectangle", Mesh::rectangle(to_world).into(), false),
        ("disk", Disk::new(to_world, false).expect("a disk").into(), false),
        ("sphere", Sphere::new(affine.translation, DMat3::from_mat4(m), false).expect("a sphere").into(), true),
    ]
}

#[test]
fn rays_leave_convex_shapes_for_good() {
    for (i, place) in places().iter().enumerate() {
        let center = place.point(Vec3::ZERO);
        let size = place.vector(Vec3::X).length();
        for (name, shape, closed) in convex_shapes(place) {
            let on_edge = |x: &Interaction| name == "cube" && on_edge_of_cube(place, x);
            check_convex(&format!("{name} {i}"), &World::new(vec![shape]), center, size, closed, i as u64, on_edge);
        }
    }
}

#[test]
fn rays_leave_instances_for_good() {
    for (i, place) in places().iter().enumerate() {
        let center = place.point(Vec3::ZERO);
        let size = place.vector(Vec3::X).length();
        // The group itself stands away from its origin and has a size of its own.
        let within = transform(DMat4::from_translation(DVec3::new(5.0, 1.0, -2.0)) * DMat4::from_scale(DVec3::splat(0.01)));
        let to_world = transform(place.matrix() * within.matrix().inverse());
        for (name, shape, closed) in convex_shapes(&within) {
            let world = World::instanced(vec![shape], vec![to_world]);
            let on_edge = |x: &Interaction| name == "cube" && on_edge_of_cube(place, x);
            check_convex(&format!("instanced {name} {i}"), &world, center, size, closed, i as u64, on_edge);
        }
    }
}

#[test]
fn rays_leave_cylinders_for_good() {
    for (i, place) in places().iter().enumerate() {
        let world = World::new(vec![Cylinder::new(DAffine3::from_mat4(place.matrix()), false).expect("a cylinder").into()]);
        let mut rng = rng(i as u64);
        for _ in 0..20_000 {
            let o = place.point(direction(&mut rng) * 3.0);
            let aim = place.point(direction(&mut rng) * rng.u1());
            let Some(x) = world.look(o, aim - o) else { continue };
            let w = direction(&mut rng);
            if x.n.dot(w) > 0.0 {
                assert!(world.hit(&x.spawn(w)).is_none(), "from {} towards {w}", x.p);
            }
        }
    }
}

/// Triangles with angles down to a ten-thousandth: no ray meets the triangle that it leaves.
#[test]
fn rays_leave_thin_triangles_for_good() {
    for (seed, far) in [(1, 0.0f32), (2, 10.0), (3, 1e4)] {
        let mut rng = rng(seed);
        let mut data = MeshData::default();
        for i in 0..2_000u32 {
            let o = Vec3::from(rng.u3()) * 10.0 + far;
            let long = direction(&mut rng);
            let thin = direction(&mut rng) * 10f32.powf(-4.0 * rng.u1());
            data.positions.extend([o, o + long, o + 0.5 * long + thin]);
            data.indices.push([3 * i, 3 * i + 1, 3 * i + 2]);
        }
        let mesh = Mesh::new(&data, &Transform::IDENTITY, true);
        let world = World::new(vec![mesh.into()]);
        let (mut left, mut failed) = (0, 0);
        for _ in 0..200_000 {
            let o = Vec3::from(rng.u3()) * 10.0 + far;
            let Some(x) = world.look(o, direction(&mut rng)) else { continue };
            let ray = x.spawn(direction(&mut rng));
            left += 1;
            failed += u32::from(world.hit(&ray).is_some_and(|h| h.primitive == x.primitive));
        }
        assert!(left > 20_000, "only {left}");
        assert_eq!(failed, 0, "of {left} at {far}");
    }
}

/// A floor of large triangles: grazing rays, hits near a corner, a camera a hair above.
#[test]
fn grazing_rays_leave_a_large_floor() {
    let to_world = transform(DMat4::from_scale(DVec3::new(1e4, 1e4, 1.0)));
    for place in
        [to_world, translation(0.0, 0.0, 100.3).then(&to_world), transform(DMat4::from_rotation_x(0.4) * to_world.matrix())]
    {
        let world = World::new(vec![Mesh::rectangle(&place).into()]);
        let n = place.normal(Vec3::Z).normalize();
        let mut rng = rng(9);
        for _ in 0..200_000 {
            let near = 10f32.powf(-6.0 * rng.u1());
            let on = place.point(Vec3::new(1.0 - near * rng.u1(), 1.0 - near * rng.u1(), 0.0));
            let slope = 10f32.powf(-5.0 * rng.u1());
            let grazing = |w: Vec3| (w - n * n.dot(w)).normalize() + n * slope;
            let Some(x) = world.look(on + n * 0.01, -n + 0.001 * direction(&mut rng)) else { continue };
            let w = grazing(direction(&mut rng)).normalize();
            let hit = world.hit(&x.spawn(w));
            assert!(hit.is_none(), "from {} towards {w}: {hit:?}", x.p);
        }
    }
}

/// A point that light travels to is seen: the shadow ray stops short of it.
#[test]
fn shadow_rays_between_surfaces_see_what_is_there() {
    let place = translation(1e3, -2e3, 500.0);
    let world = World::new(vec![Mesh::cube(&place).into()]);
    let center = place.point(Vec3::ZERO);
    let mut rng = rng(4);
    for _ in 0..50_000 {
        let mut inside = || center + (Vec3::from(rng.u3()) * 2.0 - 1.0) * 0.99;
        let (a, b) = (inside(), inside());
        let mut look = |from: Vec3| world.look(from, direction(&mut rng)).expect("a closed cube");
        let (x, y) = (look(a), look(b));
        if x.primitive / 2 == y.primitive / 2 || (x.p - y.p).length() < 0.01 {
            continue;
        }
        let ray = x.spawn_between(&y).expect("two points");
        assert!(world.hit(&ray).is_none(), "{} to {}", x.p, y.p);
        let beyond = Ray { t_max: f32::INFINITY, ..ray };
        assert!(world.hit(&beyond).is_some());
    }
}
