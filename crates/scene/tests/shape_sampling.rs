//! Points drawn on shapes: uniform by area, or with the density by direction that they state.
//!
//! Each row is held at significance 10⁻⁴ with a fixed seed; with some 20 rows a sound table would fail one time in 500.

mod common;

use common::{World, transform, translation};
use etendue_check::{ChiSquareTest, Moments, Sphere as Directions, Square, rng};
use etendue_description::MeshData;
use etendue_numerics::{Transform, Vec2, Vec3};
use etendue_scene::shape::{Cylinder, Disk, Geometry, Mesh, Shape, Sphere};
use glam::{DAffine3, DMat3, DMat4, DVec3};

const ALPHA: f64 = 1e-4;

fn triangle(corners: [Vec3; 3]) -> Shape {
    let data = MeshData { positions: corners.to_vec(), indices: vec![[0, 1, 2]], ..MeshData::default() };
    Mesh::new(&data, &Transform::IDENTITY, true).into()
}

fn shapes() -> Vec<(&'static str, Shape)> {
    let tilt = DMat4::from_rotation_x(0.5) * DMat4::from_rotation_y(-0.3);
    let place = transform(tilt);
    let stretched = transform(tilt * DMat4::from_scale(DVec3::new(2.0, 0.5, 1.5)));
    let kite = MeshData {
        positions: vec![Vec3::ZERO, Vec3::new(2.0, 0.3, 0.0), Vec3::new(1.5, 1.0, 0.0), Vec3::new(-0.2, 0.7, 0.0)],
        indices: vec![[0, 1, 2], [3, 0, 2]],
        ..MeshData::default()
    };
    vec![
        ("triangle", triangle([Vec3::new(-1.0, -0.5, 0.0), Vec3::new(1.0, -0.7, 0.2), Vec3::new(0.1, 1.0, -0.2)])),
        ("thin triangle", triangle([Vec3::new(-1.0, -0.02, 0.0), Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.3, 0.02, 0.0)])),
        ("rectangle", Mesh::rectangle(&stretched).into()),
        ("kite", Mesh::new(&kite, &place, true).into()),
        ("disk", Disk::new(&stretched, false).expect("a disk").into()),
        ("cylinder", Cylinder::new(DAffine3::from_mat4(place.matrix()), false).expect("a cylinder").into()),
        ("elliptic cylinder", Cylinder::new(DAffine3::from_mat4(stretched.matrix()), true).expect("a cylinder").into()),
        (
            "sphere",
            Sphere::new(DVec3::new(0.1, 0.2, 0.0), DMat3::from_diagonal(DVec3::splat(0.8)), false).expect("a sphere").into(),
        ),
    ]
}

/// Places to look from: ordinary, close by, grazing, far away.
const FROM: [Vec3; 4] =
    [Vec3::new(0.4, 0.3, 2.5), Vec3::new(0.2, 0.1, 0.9), Vec3::new(4.0, 1.0, 0.3), Vec3::new(-20.0, 30.0, 60.0)];

/// Points are uniform by area: the share of those within a cell of directions is that of the surface within.
#[test]
fn points_are_uniform_by_area() {
    for (name, shape) in shapes() {
        let area = shape.area();
        assert_eq!(shape.primitive_count(), 1, "{name}");
        let mut rng = rng(11);
        // E[g / pdf_a] = ∫ g dA for a few g; and the stated density integrates to one over the area.
        let mut sums = [Moments::default(); 4];
        for _ in 0..40_000 {
            let s = shape.sample_area(0, rng.u2());
            assert!(s.pdf_a > 0.0 && (s.n.length() - 1.0).abs() < 1e-5);
            let weight = 1.0 / f64::from(s.pdf_a);
            sums[0].add(weight / area);
            for axis in 0..3 {
                sums[axis + 1].add(weight * f64::from(s.p[axis]) / area);
            }
        }
        assert!((sums[0].mean - 1.0).abs() < 6.0 * (sums[0].variance() / 40_000.0).sqrt() + 1e-5, "{name}: {}", sums[0].mean);
        // The centroid from a lattice over the square, which is exact in the limit.
        let n = 400;
        let lattice = |i: usize| {
            let s = shape.sample_area(0, Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32);
            s.p.as_dvec3() / f64::from(s.pdf_a)
        };
        let centroid = (0..n * n).map(lattice).sum::<DVec3>() / ((n * n) as f64 * area);
        for axis in 0..3 {
            let error = (sums[axis + 1].variance() / 40_000.0).sqrt();
            assert!((sums[axis + 1].mean - centroid[axis]).abs() < 6.0 * error + 1e-3, "{name}, axis {axis}");
        }
    }
}

/// A uniform point of a triangle or rectangle, folded back onto the square, is uniform there.
#[test]
fn points_of_meshes_fill_them_evenly() {
    let rectangle: Shape = Mesh::rectangle(&Transform::IDENTITY).into();
    let on_square = |[a, b, _]: [f32; 3]| Some(rectangle.sample_area(0, Vec2::new(a, b)).uv.min(Vec2::splat(1.0 - 6e-8)));
    let report = ChiSquareTest::new(Square).run(on_square, |_| 1.0);
    assert!(report.passes(ALPHA), "{report}");

    let half = triangle([Vec3::ZERO, Vec3::X, Vec3::Y]);
    let folded = |[a, b, flip]: [f32; 3]| {
        let p = half.sample_area(0, Vec2::new(a, b)).p.truncate();
        // Half of the points go to the other half of the square, point by point.
        let p = if flip < 0.5 { p } else { Vec2::ONE - p };
        Some(p.clamp(Vec2::ZERO, Vec2::splat(1.0 - 6e-8)))
    };
    let report = ChiSquareTest::new(Square).run(folded, |_| 1.0);
    assert!(report.passes(ALPHA), "{report}");
}

#[test]
fn directions_have_the_density_that_is_stated() {
    for (name, shape) in shapes() {
        let world = World::new(vec![shape]);
        let shape = &world.surfaces.iter().next().expect("a surface").1.shape;
        for (i, from) in FROM.into_iter().enumerate() {
            let seen = |w: Vec3| world.look(from, w).map_or(0.0, |x| shape.pdf_direction(x.primitive, from, &x));
            let sample =
                |[a, b, _]: [f32; 3]| shape.sample_direction(0, from, Vec2::new(a, b)).map(|(s, _)| (s.p - from).normalize());
            // An open cylinder shows its inside and its outside in one direction, of which only the nearer is seen: it is tested below. Of the
            // shapes that are drawn by area one place to look from tells enough.
            if name.contains("cylinder") || (i > 0 && !["triangle", "rectangle", "sphere"].contains(&name)) {
                continue;
            }
            let test = ChiSquareTest::new(Directions).samples(20_000).seed(i as u64 + 1);
            let report = test.run(sample, seen);
            assert!(report.p_value >= ALPHA && report.outside == 0 && report.invalid == 0, "{name} from {from}: {report}");
        }
    }
}

/// ∫ g dω over the directions of a shape, by its own samples and by casting rays into all directions alike.
#[test]
fn samples_by_direction_integrate_as_all_directions_do() {
    for (name, shape) in shapes() {
        let world = World::new(vec![shape]);
        let shape = &world.surfaces.iter().next().expect("a surface").1.shape;
        for (i, from) in FROM.into_iter().enumerate().take(3) {
            let mut rng = rng(21 + i as u64);
            let g = |w: Vec3| f64::from(1.0 + 0.5 * w.x - 0.3 * w.y);
            let (mut drawn, mut cast, mut met) = (Moments::default(), Moments::default(), 0);
            for _ in 0..30_000 {
                let value = shape.sample_direction(0, from, rng.u2()).map_or(0.0, |(s, pdf_w)| {
                    let w = (s.p - from).normalize();
                    // Only what is in front counts: a cylinder hides part of itself.
                    let x = world.look(from, w);
                    let hidden = x.as_ref().is_none_or(|x| (x.p - s.p).length() > 1e-3 * (s.p - from).length());
                    if let Some(x) = x.filter(|_| !hidden && !name.contains("thin")) {
                        let again = shape.pdf_direction(x.primitive, from, &x);
                        let grazing = x.n.dot(w).abs() < 0.05;
                        assert!(grazing || (again - pdf_w).abs() < 2e-2 * pdf_w, "{name}: {again} is not {pdf_w}");
                    }
                    if hidden { 0.0 } else { g(w) / f64::from(pdf_w) }
                });
                drawn.add(value);
                let w = common::direction(&mut rng);
                let seen = world.look(from, w).is_some();
                met += u32::from(seen);
                cast.add(if seen { g(w) * 4.0 * std::f64::consts::PI } else { 0.0 });
            }
            // Too small to be found by chance: the comparison would say nothing.
            if met < 100 {
                continue;
            }
            let error = (drawn.variance() / 30_000.0 + cast.variance() / 30_000.0).sqrt();
            let difference = (drawn.mean - cast.mean).abs();
            assert!(
                difference < 5.0 * error + 2e-3 * cast.mean,
                "{name} from {from}: {} ± {error} is not {}",
                drawn.mean,
                cast.mean
            );
        }
    }
}

/// The sphere's cone, from within, from afar; the far side is never drawn.
#[test]
fn a_sphere_is_drawn_as_the_cone_that_it_fills() {
    let radius = 0.5;
    let sphere: Shape = Sphere::new(DVec3::ZERO, DMat3::from_diagonal(DVec3::splat(radius)), false).expect("a sphere").into();
    let world = World::new(vec![sphere]);
    let shape = &world.surfaces.iter().next().expect("a surface").1.shape;
    for distance in [0.500_1f32, 0.6, 3.0, 1e3, 1e5] {
        let from = Vec3::new(0.0, 0.0, distance);
        let sin2 = (0.5 / f64::from(distance)).powi(2);
        let solid_angle = std::f64::consts::TAU * sin2 / (1.0 + (1.0 - sin2).sqrt());
        let mut rng = rng(2);
        for _ in 0..2_000 {
            let (s, pdf_w) = shape.sample_direction(0, from, rng.u2()).expect("a point");
            assert!((f64::from(pdf_w) * solid_angle - 1.0).abs() < 1e-3, "{pdf_w} {solid_angle}");
            assert!((s.p.length() - 0.5).abs() < 1e-6 && s.p.dot(from - s.p) > -1e-4 * distance);
        }
    }
    let x = world.look(Vec3::ZERO, -Vec3::Z).expect("a hit");
    assert_eq!(shape.pdf_direction(0, Vec3::new(0.0, 0.0, 3.0), &x), 0.0);
}

#[test]
fn nothing_is_drawn_where_nothing_is_seen() {
    let rectangle: Shape = Mesh::rectangle(&translation(0.0, 0.0, 1.0)).into();
    // In its plane, on it, and at its corner.
    for from in [Vec3::new(3.0, 0.0, 1.0), Vec3::new(0.2, 0.1, 1.0), Vec3::new(1.0, 1.0, 1.0)] {
        for u in [Vec2::ZERO, Vec2::splat(0.5), Vec2::splat(1.0 - 6e-8)] {
            if let Some((s, pdf_w)) = rectangle.sample_direction(0, from, u) {
                assert!(s.p.is_finite() && pdf_w.is_finite() && pdf_w > 0.0, "{from} {u}: {pdf_w}");
            }
        }
    }
}
