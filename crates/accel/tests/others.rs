//! Custom shapes and instances: against moved copies, against triangles, and as many as one likes.

mod common;

use common::{Mesh, Random, bits, cast, closed_surface, every_path, soup};
use etendue_accel::{Accel, BuildError, BuildOptions, Builder, CustomHit, CustomShapes, Hit, NoShapes, Path};
use etendue_numerics::{Bounds3, Ray, Transform, Vec3};
use std::sync::Arc;

/// Spheres by centre and radius.
struct Spheres(Vec<(Vec3, f32)>);

impl CustomShapes for Spheres {
    fn intersect(&self, geometry: u32, ray: &Ray) -> Option<CustomHit> {
        let (c, r) = self.0[geometry as usize];
        let (o, d) = ((ray.o - c).as_dvec3(), ray.d.as_dvec3());
        let (a, b, k) = (d.dot(d), o.dot(d), o.dot(o) - f64::from(r * r));
        let root = (b * b - a * k).sqrt();
        let t = [(-b - root) / a, (-b + root) / a].into_iter().map(|t| t as f32).find(|&t| t > 0.0 && t < ray.t_max)?;
        Some(CustomHit { t, u: 0.0, v: 0.0, primitive: 5 })
    }
}

fn sphere_bounds(&(c, r): &(Vec3, f32)) -> Bounds3 {
    Bounds3 { min: c - r, max: c + r }
}

#[test]
fn custom_shapes_among_triangles() {
    let mut random = Random::new(1);
    let mesh = soup(300, &mut random);
    let spheres = Spheres((0..200).map(|_| (random.cube(), 0.2 * random.unit())).collect());
    let mut builder = Builder::new();
    builder.add_mesh(mesh.view(1000));
    for (i, s) in spheres.0.iter().enumerate() {
        builder.add_custom(i as u32, sphere_bounds(s));
    }
    builder.add_custom(77, Bounds3::EMPTY);
    let both = builder.build(&BuildOptions::default()).expect("builds");
    let triangles = mesh.accel(&BuildOptions::default());
    let (mut shapes_hit, mut triangles_hit) = (0, 0);
    for _ in 0..5000 {
        let ray = Ray::new(1.5 * random.cube(), random.direction());
        let triangle = triangles.closest(&ray, &NoShapes);
        let shape = (0..200).filter_map(|g| Some((spheres.intersect(g, &ray)?, g))).min_by(|a, b| a.0.t.total_cmp(&b.0.t));
        let expected = match (triangle, shape) {
            (Some(hit), Some((s, _))) if hit.t <= s.t => Some(Hit { geometry: 1000, ..hit }),
            (_, Some((s, geometry))) => {
                Some(Hit { t: s.t, u: s.u, v: s.v, geometry, primitive: s.primitive, instance: Hit::NO_INSTANCE })
            }
            (hit, None) => hit.map(|hit| Hit { geometry: 1000, ..hit }),
        };
        for accel in every_path(&both) {
            assert_eq!(bits(accel.closest(&ray, &spheres)), bits(expected));
            assert_eq!(accel.occluded(&ray, &spheres), expected.is_some());
        }
        match expected.map(|h| h.geometry) {
            Some(1000) => triangles_hit += 1,
            Some(_) => shapes_hit += 1,
            None => {}
        }
    }
    assert!(shapes_hit > 500 && triangles_hit > 500, "{shapes_hit} {triangles_hit}");
}

fn random_transform(random: &mut Random) -> Transform {
    loop {
        let columns = [random.cube(), random.cube(), random.cube()].map(|c| c.as_dvec3());
        let matrix = glam::DMat4::from_cols(
            columns[0].extend(0.0),
            columns[1].extend(0.0),
            columns[2].extend(0.0),
            (4.0 * random.cube()).as_dvec3().extend(1.0),
        );
        if columns[0].cross(columns[1]).dot(columns[2]).abs() > 0.1
            && let Some(t) = Transform::new(matrix)
        {
            return t;
        }
    }
}

/// Instances hit what moved copies would, at the same t in the outer direction's units.
#[test]
fn instances_agree_with_moved_copies() {
    let mut random = Random::new(2);
    let mesh = closed_surface(12, 0.2);
    let inner = Arc::new(mesh.accel(&BuildOptions::default()));
    let transforms: Vec<Transform> = (0..40).map(|_| random_transform(&mut random)).collect();
    let copies: Vec<Mesh> = transforms.iter().map(|t| mesh.map(|p| t.point(p))).collect();

    let (mut instanced, mut merged) = (Builder::new(), Builder::new());
    let tree = instanced.add_tree(inner);
    for (i, (t, copy)) in transforms.iter().zip(&copies).enumerate() {
        instanced.add_instance(tree, t, 100 + i as u32);
        merged.add_mesh(copy.view(i as u32));
    }
    let instanced = every_path(&instanced.build(&BuildOptions::default()).expect("builds"));
    let merged = every_path(&merged.build(&BuildOptions::default()).expect("builds"));
    // the box holds the copies and is not much larger
    let (outer, tight) = (instanced[0].bounds(), merged[0].bounds());
    assert!(outer.contains(tight.min) && outer.contains(tight.max) && (outer.size() - tight.size()).max_element() < 1.5);

    let (mut hits, mut odd) = (0, 0);
    for _ in 0..10_000 {
        let ray = Ray::new(8.0 * random.cube(), 3.0 * random.direction());
        match (cast(&instanced, &ray), cast(&merged, &ray)) {
            (Some(a), Some(b)) => {
                hits += 1;
                let same = (a.t - b.t).abs() <= 1e-4 * b.t && a.instance == 100 + b.geometry;
                odd += usize::from(!same);
                if same && a.primitive == b.primitive {
                    // barycentrics survive the map
                    assert!((a.u - b.u).abs() < 1e-2 && (a.v - b.v).abs() < 1e-2, "{a:?} {b:?}");
                }
            }
            (None, None) => {}
            _ => odd += 1,
        }
    }
    // silhouettes may fall to either side by rounding: a few in ten thousand
    assert!(hits > 1000 && odd <= 5, "{hits} hits, {odd} odd ones");
}

/// Custom shapes inside of instances meet the ray in the inner space.
#[test]
fn custom_shapes_inside_of_instances() {
    let spheres = Spheres(vec![(Vec3::ZERO, 1.0)]);
    let mut inner = Builder::new();
    inner.add_custom(0, sphere_bounds(&spheres.0[0]));
    let inner = Arc::new(inner.build(&BuildOptions::default()).expect("builds"));
    let mut outer = Builder::new();
    let tree = outer.add_tree(inner);
    let double =
        Transform::new(glam::DMat4::from_translation(glam::DVec3::X * 10.0) * glam::DMat4::from_scale(glam::DVec3::splat(2.0)));
    outer.add_instance(tree, &double.expect("regular"), 3);
    for accel in every_path(&outer.build(&BuildOptions::default()).expect("builds")) {
        let hit = accel.closest(&Ray::new(Vec3::ZERO, Vec3::X * 0.5), &spheres).expect("a hit");
        assert_eq!((hit.t, hit.geometry, hit.primitive, hit.instance), (16.0, 0, 5, 3));
        assert!(!accel.occluded(&Ray::new(Vec3::ZERO, Vec3::X * 0.5).until(15.9), &spheres));
    }
}

#[test]
fn what_cannot_be_built_is_told() {
    let cube = Arc::new(closed_surface(4, 0.0).accel(&BuildOptions::default()));
    let mut one = Builder::new();
    let tree = one.add_tree(cube);
    one.add_instance(tree, &Transform::IDENTITY, 0);
    let one = Arc::new(one.build(&BuildOptions::default()).expect("builds"));
    let mut two = Builder::new();
    let tree = two.add_tree(one);
    two.add_instance(tree, &Transform::IDENTITY, 0);
    assert_eq!(two.build(&BuildOptions::default()).err(), Some(BuildError::NestedInstance));
    let mut stranger = Builder::new();
    stranger.add_instance(tree, &Transform::IDENTITY, 0);
    assert_eq!(stranger.build(&BuildOptions::default()).err(), Some(BuildError::UnknownTree));
}

/// An instance of nothing, and one that is squashed flat, are no trouble.
#[test]
fn odd_instances_are_fine() {
    let nothing = Arc::new(Builder::new().build(&BuildOptions::default()).expect("builds"));
    let mesh = closed_surface(4, 0.0);
    let ball = Arc::new(mesh.accel(&BuildOptions::default()));
    let mut builder = Builder::new();
    let (empty, ball) = (builder.add_tree(nothing), builder.add_tree(ball));
    builder.add_instance(empty, &Transform::IDENTITY, 1);
    let flat = Transform::new(glam::DMat4::from_scale(glam::DVec3::new(1.0, 1.0, 1e-30))).expect("regular");
    builder.add_instance(ball, &flat, 2);
    let accels = every_path(&builder.build(&BuildOptions::default()).expect("builds"));
    let hit = cast(&accels, &Ray::new(Vec3::new(0.1, 0.2, 1.0), -Vec3::Z)).expect("a hit");
    assert_eq!(hit.instance, 2);
    assert!((hit.t - 1.0).abs() < 1e-6);
}

/// Ten thousand instances build at once, and rays through them find the nearest.
#[test]
fn ten_thousand_instances() {
    let ball = Arc::new(closed_surface(16, 0.1).accel(&BuildOptions::default()));
    let mut builder = Builder::new();
    let tree = builder.add_tree(ball);
    for i in 0..10_000_u32 {
        let at = glam::DVec3::new(f64::from(i % 100), f64::from(i / 100), 0.0) * 3.0;
        builder.add_instance(tree, &Transform::new(glam::DMat4::from_translation(at)).expect("regular"), i);
    }
    let accel: Accel = builder.build(&BuildOptions::default()).expect("builds");
    assert!(accel.stats().build_seconds < 1.0, "{}", accel.stats().build_seconds);
    for i in (0..10_000).step_by(37) {
        let above = Vec3::new((i % 100) as f32 * 3.0, (i / 100) as f32 * 3.0, 10.0);
        let hit = accel.closest(&Ray::new(above, -Vec3::Z), &NoShapes).expect("a hit");
        assert_eq!(hit.instance, i as u32);
    }
    assert_eq!(accel.path(), Path::best());
}

/// Rays that stay together, from an eye and towards a lamp, hit what each hits alone: triangles, custom shapes two of which stand in the same place,
/// instances of both, and some of the rays along an axis, short or none at all.
#[test]
fn rays_that_stay_together_hit_what_each_hits_alone() {
    let mut random = Random::new(7);
    let spheres =
        Spheres((0..60).map(|i| if i % 2 == 0 { (random.cube(), 0.2 * random.unit()) } else { (Vec3::ZERO, 0.3) }).collect());
    let scene = |random: &mut Random, triangles: usize, children: &[Arc<Accel>]| {
        let mesh = soup(triangles, random);
        let mut builder = Builder::new();
        builder.add_mesh(mesh.view(1000));
        for (i, s) in spheres.0.iter().enumerate() {
            builder.add_custom(i as u32, sphere_bounds(s));
        }
        for (i, child) in children.iter().enumerate() {
            let tree = builder.add_tree(child.clone());
            for k in 0..4 {
                builder.add_instance(tree, &random_transform(random), (4 * i + k) as u32);
            }
        }
        builder.build(&BuildOptions::default()).expect("builds")
    };
    let children: Vec<_> = [30, 2000].iter().map(|n| Arc::new(scene(&mut random, *n, &[]))).collect();
    let (mut hit, mut instanced) = (0, 0);
    for triangles in [100, 3000] {
        let accels = every_path(&scene(&mut random, triangles, &children));
        for view in 0..24 {
            let (eye, towards, width) = (2.0 * random.cube(), random.direction(), 0.3 * random.unit());
            let rays: Vec<Ray> = (0..100)
                .map(|i| {
                    let o = if i % 37 == 0 { Vec3::splat(f32::NAN) } else { eye };
                    let d = if i % 29 == 0 { Vec3::Y } else { towards + width * random.cube() };
                    let end = if i % 5 == 0 { random.unit() } else { f32::INFINITY };
                    // Every other view is a lamp's: the rays end there, and begin next to each other.
                    if view % 2 == 0 { Ray::new(o, d).until(end) } else { Ray::new(eye + 0.05 * random.cube() - d, d).until(1.0) }
                })
                .collect();
            for accel in &accels {
                let (mut hits, mut occluded) = (Vec::new(), Vec::new());
                accel.closest_each(&rays, &spheres, &mut hits);
                accel.occluded_each(&rays, &spheres, &mut occluded);
                for ((ray, each), occluded) in rays.iter().zip(hits).zip(occluded) {
                    let alone = accels[0].closest(ray, &spheres);
                    assert_eq!(bits(each), bits(alone), "{:?}: {ray:?}", accel.path());
                    assert_eq!(occluded, alone.is_some(), "any-hit, {:?}: {ray:?}", accel.path());
                    hit += usize::from(each.is_some());
                    instanced += usize::from(each.is_some_and(|hit| hit.instance != Hit::NO_INSTANCE));
                }
            }
        }
    }
    assert!(hit > 2000 && instanced > 500, "{hit} {instanced}");
}
