//! Each shape against figures worked out by hand: where it is met, its normals, its texture coordinates, its area.

mod common;

use common::{World, close, close3, direction, transform, translation};
use etendue_check::rng;
use etendue_description::{Attribute, AttributeKind, MeshData};
use etendue_numerics::{Ray, Transform, Vec2, Vec3};
use etendue_scene::shape::{Cylinder, Disk, Geometry, Mesh, SdfGrid, Shape, Sphere};
use glam::{DAffine3, DMat3, DMat4, DVec3};
use std::f32::consts::{PI, TAU};

const ID: Transform = Transform::IDENTITY;

fn sphere(radius: f64) -> Shape {
    Sphere::new(DVec3::new(1.0, 2.0, 3.0), DMat3::from_diagonal(DVec3::splat(radius)), false).expect("a sphere").into()
}

fn cylinder(m: DMat4, flip: bool) -> Shape {
    Cylinder::new(DAffine3::from_mat4(m), flip).expect("a cylinder").into()
}

fn tetrahedron() -> MeshData {
    MeshData {
        positions: vec![Vec3::ZERO, 2.0 * Vec3::X, 2.0 * Vec3::Y, 2.0 * Vec3::Z],
        indices: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ..MeshData::default()
    }
}

#[test]
fn a_sphere_is_met_where_it_is() {
    let world = World::new(vec![sphere(2.0)]);
    let x = world.look(Vec3::new(1.3, -4.0, 2.4), Vec3::Y).expect("a hit");
    // (x - 1, z - 3) = (0.3, -0.6), so y - 2 = -√(4 - 0.45).
    let y = -(4f32 - 0.45).sqrt();
    close3(x.p, Vec3::new(1.3, 2.0 + y, 2.4), 1e-6);
    close(x.t, 6.0 + y, 1e-6);
    close3(x.n, Vec3::new(0.15, 0.5 * y, -0.3), 1e-6);
    let phi = y.atan2(0.3) + TAU;
    close(x.uv.x, phi / TAU, 1e-6);
    close(x.uv.y, (-0.3f32).acos() / PI, 1e-6);
    close3(x.dp_du, Vec3::new(-y, 0.3, 0.0) * TAU, 1e-5);
    close3(x.dp_dv, Vec3::new(-0.6 * phi.cos(), -0.6 * phi.sin(), -(0.09 + y * y).sqrt()) * PI, 1e-5);

    // From within, and with normals turned in, by flag or by a mirror.
    let x = world.look(Vec3::new(1.0, 2.0, 3.0), Vec3::X).expect("a hit");
    close3(x.p, Vec3::new(3.0, 2.0, 3.0), 1e-6);
    close3(x.n, Vec3::X, 1e-6);
    for (m, flip) in [(DVec3::splat(2.0), true), (DVec3::new(-2.0, 2.0, 2.0), false), (DVec3::splat(-2.0), false)] {
        let inward = Sphere::new(DVec3::ZERO, DMat3::from_diagonal(m), flip).expect("a sphere");
        close3(World::new(vec![inward.into()]).look(5.0 * Vec3::X, -Vec3::X).expect("a hit").n, -Vec3::X, 1e-6);
    }
    assert!(Sphere::new(DVec3::ZERO, DMat3::ZERO, false).is_none());
    assert!(Sphere::new(DVec3::NAN, DMat3::IDENTITY, false).is_none());
    close(sphere(2.0).area() as f32, 16.0 * PI, 1e-4);
}

/// From 10⁶ radii away the point met still lies on the sphere, and rays past its edge pass.
#[test]
fn a_sphere_far_away_keeps_its_shape() {
    let far = 1e6f32;
    let world = World::new(vec![Sphere::new(DVec3::ZERO, DMat3::IDENTITY, false).expect("a sphere").into()]);
    let mut rng = rng(3);
    let mut met = 0;
    for _ in 0..20_000 {
        let o = Vec3::new(far, 2.4 * rng.u1() - 1.2, 2.4 * rng.u1() - 1.2);
        let miss = o.y.hypot(o.z);
        let hit = world.look(o, -Vec3::X);
        assert_eq!(hit.is_some(), miss <= 1.0, "{o}");
        if let Some(x) = hit {
            met += 1;
            close(x.p.length(), 1.0, 1e-6);
            // t is rounded to 1/16: the point met lies beside the ray by no more.
            assert!((x.p - o).cross(-Vec3::X).length() - miss < 0.1 && x.n.x > -0.1);
        }
    }
    assert!(met > 1_000);
}

#[test]
fn a_disk_is_met_where_it_is() {
    let world = World::new(vec![Disk::new(&ID, false).expect("a disk").into()]);
    let x = world.look(Vec3::new(0.3, 0.6, 4.0), -Vec3::Z).expect("a hit");
    let r = 0.45f32.sqrt();
    close3(x.p, Vec3::new(0.3, 0.6, 0.0), 1e-6);
    close3(x.n, Vec3::Z, 0.0);
    close(x.uv.x, r, 1e-6);
    close(x.uv.y, 2f32.atan() / TAU, 1e-6);
    close3(x.dp_du, Vec3::new(0.3, 0.6, 0.0) / r, 1e-6);
    close3(x.dp_dv, Vec3::new(-0.6, 0.3, 0.0) * TAU, 1e-6);
    assert!(world.look(Vec3::new(0.8, 0.7, 4.0), -Vec3::Z).is_none());
    assert!(world.look(Vec3::new(0.1, 0.1, -4.0), -Vec3::Z).is_none());
    // The centre has a frame too.
    let x = world.look(4.0 * Vec3::Z, -Vec3::Z).expect("a hit");
    assert!(x.shading.s.is_finite() && x.dp_du == Vec3::X);

    // An ellipse; a mirror along x leaves the front in front, one along z does not.
    let ellipse: Shape = Disk::new(&transform(DMat4::from_scale(DVec3::new(-2.0, 1.0, 1.0))), false).expect("a disk").into();
    close(ellipse.area() as f32, 2.0 * PI, 1e-6);
    close3(World::new(vec![ellipse]).look(Vec3::new(1.9, 0.0, 4.0), -Vec3::Z).expect("a hit").n, Vec3::Z, 0.0);
    let behind = Disk::new(&transform(DMat4::from_scale(DVec3::new(1.0, 1.0, -2.0))), false).expect("a disk");
    close3(World::new(vec![behind.into()]).look(4.0 * Vec3::Z, -Vec3::Z).expect("a hit").n, -Vec3::Z, 0.0);
}

/// pbrt: u = φ/2π, v from the pole at -z on a sphere and from the rim on a disk [Pharr, Jakob, Humphreys 2023, §6.2.3, §6.4.3].
#[test]
fn texture_coordinates_of_pbrt_and_their_derivatives() {
    let ball = |pbrt| Sphere::new(DVec3::ZERO, DMat3::IDENTITY, false).expect("a sphere").with_pbrt_uv(pbrt);
    let plate = |pbrt| Disk::new(&ID, false).expect("a disk").with_pbrt_uv(pbrt);
    let sheet = |pbrt_uv| {
        let positions = vec![Vec3::new(-2.0, -2.0, 0.0), Vec3::new(3.0, -2.0, 0.0), Vec3::new(0.0, 3.0, 0.0)];
        let data = MeshData { positions, indices: vec![[0, 1, 2]], ..MeshData::default() };
        let mut mesh = Mesh::new(&data, &ID, true);
        mesh.pbrt_uv = pbrt_uv;
        mesh
    };
    let from = Vec3::new(0.3, 0.2, 4.0);
    for pbrt in [false, true] {
        for shape in [Shape::from(ball(pbrt)), plate(pbrt).into(), sheet(pbrt).into()] {
            let name = format!("{shape:?}");
            let world = World::new(vec![shape]);
            let x = world.look(from, -Vec3::Z).expect("a hit");
            for (along, want) in [(x.dp_du, Vec2::X), (x.dp_dv, Vec2::Y)] {
                let step = 1e-3 / along.length();
                let there = world.look(from + along * step, -Vec3::Z).expect("a hit");
                let moved = (there.uv - x.uv) / step;
                assert!((moved - want).length() < 2e-2, "{pbrt} {name}: {moved} is not {want}");
            }
        }
    }
    let uv = |shape: Shape, from: Vec3, d: Vec3| World::new(vec![shape]).look(from, d).expect("a hit").uv;
    let low = Vec3::new(0.0, 3.0, -0.5);
    assert!((uv(ball(true).into(), low, -Vec3::Y) - Vec2::new(0.25, 1.0 / 3.0)).length() < 1e-6);
    assert!((uv(ball(false).into(), low, -Vec3::Y) - Vec2::new(0.25, 2.0 / 3.0)).length() < 1e-6);
    assert!((uv(plate(true).into(), Vec3::new(0.0, -0.75, 1.0), -Vec3::Z) - Vec2::new(0.75, 0.25)).length() < 1e-6);
    let corner = uv(sheet(true).into(), Vec3::new(0.0, 2.999, 1.0), -Vec3::Z);
    assert!((corner - Vec2::ONE).length() < 1e-3, "{corner}");
}

#[test]
fn a_cylinder_is_met_where_it_is() {
    let m = DMat4::from_translation(DVec3::new(1.0, 0.0, 0.0)) * DMat4::from_scale(DVec3::new(2.0, 2.0, 3.0));
    let world = World::new(vec![cylinder(m, false)]);
    let x = world.look(Vec3::new(1.3, -4.0, 1.0), Vec3::Y).expect("a hit");
    let y = -(4f32 - 0.09).sqrt();
    close3(x.p, Vec3::new(1.3, y, 1.0), 1e-6);
    close3(x.n, Vec3::new(0.15, 0.5 * y, 0.0), 1e-6);
    close(x.uv.x, (y.atan2(0.3) + TAU) / TAU, 1e-6);
    close(x.uv.y, 1.0 / 3.0, 1e-6);
    close3(x.dp_du, Vec3::new(-y, 0.3, 0.0) * TAU, 1e-5);
    close3(x.dp_dv, 3.0 * Vec3::Z, 1e-6);
    close(cylinder(m, false).area() as f32, TAU * 2.0 * 3.0, 1e-4);
    // Through the open end the far wall is met from within.
    let x = world.look(Vec3::new(1.0, -4.0, 5.0), Vec3::new(0.0, 4.0, -3.0)).expect("a hit");
    close3(x.p, Vec3::new(1.0, 2.0, 0.5), 1e-5);
    close3(x.n, Vec3::Y, 1e-6);
    assert!(world.look(Vec3::new(1.0, 0.0, 5.0), -Vec3::Z).is_none());
    assert!(world.look(Vec3::new(1.0, -4.0, 3.1), Vec3::Y).is_none());
    close3(World::new(vec![cylinder(m, true)]).look(Vec3::new(1.0, -4.0, 1.0), Vec3::Y).expect("a hit").n, Vec3::Y, 1e-6);
    // The perimeter of an ellipse with half axes 2 and 1 is 9.688448220.
    let ellipse = cylinder(DMat4::from_scale(DVec3::new(2.0, 1.0, 5.0)), false);
    close(ellipse.area() as f32, 5.0 * 9.688_448, 1e-4);
}

#[test]
fn a_rectangle_is_met_where_it_is() {
    let rectangle: Shape = Mesh::rectangle(&transform(DMat4::from_scale(DVec3::new(-2.0, 1.0, 1.0)))).into();
    close(rectangle.area() as f32, 8.0, 1e-6);
    assert_eq!(rectangle.primitive_count(), 1);
    let world = World::new(vec![rectangle]);
    for (px, py) in [(0.3, 0.6), (-1.2, 0.5), (1.8, -0.9)] {
        let x = world.look(Vec3::new(px, py, 4.0), -Vec3::Z).expect("a hit");
        // The mirror turns the winding, not the normal.
        close3(x.n, Vec3::Z, 0.0);
        close3(x.shading.n, Vec3::Z, 0.0);
        close(x.uv.x, 0.5 - 0.25 * px, 1e-6);
        close(x.uv.y, 0.5 + 0.5 * py, 1e-6);
        close3(x.dp_du, -4.0 * Vec3::X, 1e-5);
        close3(x.dp_dv, 2.0 * Vec3::Y, 1e-5);
        assert_eq!(x.primitive, 0);
    }
}

#[test]
fn a_cube_has_its_textures_upright() {
    let shape: Shape = Mesh::cube(&ID).into();
    close(shape.area() as f32, 24.0, 1e-5);
    let world = World::new(vec![shape]);
    let cases = [
        (Vec3::new(0.3, 0.6, 4.0), -Vec3::Z, [0.8, 0.65]),
        (Vec3::new(0.3, 0.6, -4.0), Vec3::Z, [0.2, 0.65]),
        (Vec3::new(0.3, 4.0, 0.6), -Vec3::Y, [0.35, 0.2]),
        (Vec3::new(0.3, -4.0, 0.6), Vec3::Y, [0.8, 0.65]),
        (Vec3::new(4.0, 0.3, 0.6), -Vec3::X, [0.65, 0.2]),
        (Vec3::new(-4.0, 0.3, 0.6), Vec3::X, [0.65, 0.8]),
    ];
    for (o, d, [u, v]) in cases {
        let x = world.look(o, d).expect("a hit");
        close(x.t, 3.0, 1e-6);
        close3(x.n, -d, 0.0);
        close(x.uv.x, u, 1e-6);
        close(x.uv.y, v, 1e-6);
    }
}

#[test]
fn meshes_without_normals_get_smooth_ones() {
    let data = tetrahedron();
    let smooth = Mesh::new(&data, &ID, false);
    // At the origin three right angles: the mean of -x, -y, -z.
    close3(smooth.normals[0], -Vec3::ONE.normalize(), 1e-6);
    // At (2, 0, 0): two faces with an angle of 45° and the slanted one with 60°.
    let expected = (-(Vec3::Y + Vec3::Z) * PI / 4.0 + Vec3::ONE.normalize() * PI / 3.0).normalize();
    close3(smooth.normals[1], expected, 1e-6);

    let flat = World::new(vec![Mesh::new(&data, &ID, true).into()]);
    let x = flat.look(Vec3::new(0.3, 0.4, -4.0), Vec3::Z).expect("a hit");
    close3(x.shading.n, -Vec3::Z, 0.0);
    // Without texture coordinates u and v run along the edges.
    close(x.uv.x, 0.2, 1e-6);
    close(x.uv.y, 0.15, 1e-6);
    close3(x.dp_du, 2.0 * Vec3::Y, 0.0);
    close3(x.dp_dv, 2.0 * Vec3::X, 0.0);

    let shaded = World::new(vec![smooth.into()]).look(Vec3::new(0.3, 0.4, -4.0), Vec3::Z).expect("a hit");
    close3(shaded.n, -Vec3::Z, 0.0);
    assert!(shaded.shading.n.dot(shaded.n) < 0.99);
    let mut turned = Mesh::new(&data, &ID, true);
    turned.flip_normals = true;
    let turned = World::new(vec![turned.into()]);
    close3(turned.look(Vec3::new(0.3, 0.4, -4.0), Vec3::Z).expect("a hit").n, Vec3::Z, 0.0);
}

/// Files wind their faces as they like: where they give normals, those say what is outside.
#[test]
fn the_geometric_normal_follows_the_vertex_normals() {
    let data = MeshData {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        normals: vec![Vec3::new(0.0, 0.6, -0.8), -Vec3::Z, Vec3::new(0.6, 0.0, -0.8)],
        uvs: vec![Vec2::new(0.5, 0.5); 3],
        indices: vec![[0, 1, 2]],
        attributes: vec![
            Attribute {
                name: "vertex_color".into(),
                kind: AttributeKind::Vertex,
                channels: 3,
                data: (0..9).map(|i| i as f32).collect(),
            },
            Attribute { name: "face_id".into(), kind: AttributeKind::Face, channels: 1, data: vec![7.0] },
        ],
        ..MeshData::default()
    };
    let mesh = Mesh::new(&data, &ID, false);
    let index = mesh.attribute_index("vertex_color").expect("an attribute");
    // (0, 1, 2) / 4 + (3, 4, 5) / 2 + (6, 7, 8) / 4
    assert_eq!(mesh.attribute(index, 0, Vec2::new(0.5, 0.25)), [3.0, 4.0, 5.0]);
    assert_eq!(mesh.attribute(1, 0, Vec2::ZERO), [7.0; 3]);
    let world = World::new(vec![mesh.into()]);
    let x = world.look(Vec3::new(0.2, 0.2, 3.0), -Vec3::Z).expect("a hit");
    close3(x.n, -Vec3::Z, 0.0);
    assert!(x.shading.n.dot(x.n) > 0.0);
    // Texture coordinates that do not span the plane still give a frame.
    assert!(x.dp_du.is_finite() && x.shading.s.is_finite() && x.dp_du.dot(x.n).abs() < 1e-6);
}

/// Seeing a shape through an instance is seeing its moved copy.
#[test]
fn an_instance_is_a_moved_copy() {
    let m = DMat4::from_translation(DVec3::new(1.0, -2.0, 0.5))
        * DMat4::from_rotation_y(0.8)
        * DMat4::from_scale(DVec3::new(-1.5, 0.7, 2.0));
    let to_world = transform(m);
    let pairs: Vec<(Shape, Shape)> = vec![
        (Mesh::cube(&ID).into(), Mesh::cube(&to_world).into()),
        (Mesh::rectangle(&ID).into(), Mesh::rectangle(&to_world).into()),
        (Mesh::new(&tetrahedron(), &translation(0.0, 0.0, 0.1), true).into(), {
            let mut copy = Mesh::new(&tetrahedron(), &translation(0.0, 0.0, 0.1).then(&to_world), true);
            // Flat faces follow the winding, which a mirror turns; an instance keeps its group's front.
            copy.flip_normals = true;
            copy.into()
        }),
        (Disk::new(&ID, false).expect("a disk").into(), Disk::new(&to_world, false).expect("a disk").into()),
        (cylinder(DMat4::IDENTITY, false), cylinder(m, false)),
    ];
    let mut rng = rng(8);
    for (shape, copy) in pairs {
        let name = format!("{shape:.0?}").chars().take(10).collect::<String>();
        let (instance, copy) = (World::instanced(vec![shape], vec![ID, to_world]), World::new(vec![copy]));
        let mut met = 0;
        for _ in 0..2_000 {
            let target = to_world.point(direction(&mut rng) * 0.8);
            let ray = Ray::new(target + 20.0 * direction(&mut rng), Vec3::ZERO);
            let ray = Ray { d: (target - ray.o).normalize(), ..ray };
            let Some(expected) = copy.see(&ray) else { continue };
            let Some(hit) = instance.hit(&ray) else { continue };
            if hit.instance != 1 {
                continue;
            }
            met += 1;
            let x = instance.see(&ray).expect("the same hit");
            close(x.t, expected.t, 1e-4);
            close3(x.p, expected.p, 1e-4);
            close3(x.wo, expected.wo, 1e-6);
            assert!((x.n - expected.n).length() < 1e-3, "{name}: {} {}", x.n, expected.n);
            assert!((x.shading.n - expected.shading.n).length() < 1e-3, "{name}");
            assert!((x.uv - expected.uv).length() < 1e-3, "{name}: {} {}", x.uv, expected.uv);
            assert!((x.dp_du - expected.dp_du).length() < 1e-2 && (x.dp_dv - expected.dp_dv).length() < 1e-2, "{name}");
        }
        assert!(met > 100, "{name}: {met}");
    }
}

/// Distances to a sphere of radius 0.3 around the middle of [0, 1]³.
fn ball(n: usize, smooth: bool) -> SdfGrid {
    let mut samples = Vec::new();
    let step = 1.0 / (n - 1) as f32;
    for k in 0..n {
        for j in 0..n {
            for i in 0..n {
                samples.push((Vec3::new(i as f32, j as f32, k as f32) * step - 0.5).length() - 0.3);
            }
        }
    }
    SdfGrid::new(samples, [n; 3], &ID, smooth).expect("a surface")
}

#[test]
fn a_plane_of_distances_is_a_plane() {
    // f = z - 0.4 sampled 2 × 3 × 4: the trilinear interpolant is exact.
    let samples = (0..24).map(|i| (i / 6) as f32 / 3.0 - 0.4).collect();
    let grid =
        SdfGrid::new(samples, [2, 3, 4], &transform(DMat4::from_scale(DVec3::new(1.0, 1.0, 2.0))), false).expect("a surface");
    let world = World::new(vec![grid.into()]);
    let x = world.look(Vec3::new(0.1, 0.9, 5.0), Vec3::new(0.1, -0.05, -1.0)).expect("a hit");
    close(x.p.z, 0.8, 1e-6);
    close3(x.n, Vec3::Z, 1e-6);
    close3(x.shading.n, Vec3::Z, 1e-6);
    let x = world.look(Vec3::new(0.5, 0.5, -5.0), Vec3::Z).expect("from below");
    close(x.p.z, 0.8, 1e-6);
    assert!(world.look(Vec3::new(1.1, 0.5, 5.0), -Vec3::Z).is_none());
    assert!(SdfGrid::new(vec![1.0; 8], [2; 3], &ID, false).is_none());
    assert!(SdfGrid::new(vec![1.0; 7], [2; 3], &ID, false).is_none());
}

#[test]
fn a_ball_of_distances_is_watertight() {
    for smooth in [false, true] {
        let world = World::new(vec![ball(17, smooth).into()]);
        let mut rng = rng(5);
        for i in 0..20_000 {
            // From within every ray meets the surface, and what leaves outwards meets nothing more but the ball's own bulges.
            let o = Vec3::splat(0.5) + 0.2 * direction(&mut rng);
            let d = if i % 4 == 0 { [Vec3::X, -Vec3::Y, Vec3::Z][i % 3] } else { direction(&mut rng) };
            let x = world.look(o, d).expect("a closed surface");
            close((x.p - 0.5).length(), 0.3, 0.01);
            assert!(x.n.dot((x.p - 0.5).normalize()) > 0.95 && x.shading.n.dot((x.p - 0.5).normalize()) > 0.97);
            let away = world.hit(&x.spawn(x.n));
            assert!(away.is_none(), "{away:?}");
            let back = world.see(&x.spawn(-x.n)).expect("the other side");
            assert!(back.t > 0.3, "{}", back.t);
        }
    }
}

/// Rays that make no sense meet nothing, or something finite; they never hang and never panic.
#[test]
fn senseless_rays_do_no_harm() {
    let disk = Disk::new(&ID, false).expect("a disk");
    let mesh = Mesh::new(&tetrahedron(), &ID, false);
    let world = World::new(vec![sphere(1.0), disk.into(), cylinder(DMat4::IDENTITY, false), mesh.into(), ball(9, true).into()]);
    let numbers = [0.0, -0.0, 1.0, -1e-40, 1e38, -1e38, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    let mut rng = rng(1);
    for _ in 0..100_000 {
        let mut pick = || Vec3::from(std::array::from_fn(|_| numbers[rng.below(numbers.len())]));
        let ray = Ray::new(pick(), pick()).until(pick().x);
        if let Some(x) = world.see(&ray) {
            assert!(x.t > 0.0 && x.t < ray.t_max, "{ray:?}");
        }
        for (_, surface) in world.surfaces.iter() {
            if let Some(hit) = surface.shape.intersect(&ray) {
                assert!(hit.t > 0.0 && hit.t < ray.t_max, "{ray:?}");
            }
        }
    }
}
