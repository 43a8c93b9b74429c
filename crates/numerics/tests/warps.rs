//! Warps against their densities (chi-square at α = 1e-6 each), against their inverses, and solid angles against closed forms.

use etendue_check::{ChiSquare, ChiSquareTest, Disk, Hemisphere, Interval, Rng, Sphere, Square, Triangle, rng};
use etendue_numerics::warp::*;
use etendue_numerics::{Vec2, Vec3, math};

const ALPHA: f64 = 1e-6;

fn check(name: &str, report: ChiSquare) {
    assert!(report.passes(ALPHA), "{name}: {report}");
}

fn u2(u: [f32; 3]) -> Vec2 {
    Vec2::new(u[0], u[1])
}

#[test]
fn densities_belong_to_their_warps() {
    check("disk", ChiSquareTest::new(Disk).run(|u| Some(square_to_disk(u2(u))), |_| disk_pdf()));
    check("hemisphere", ChiSquareTest::new(Hemisphere).run(|u| Some(square_to_hemisphere(u2(u))), |_| hemisphere_pdf()));
    check(
        "cosine",
        ChiSquareTest::new(Hemisphere).run(|u| Some(square_to_cosine_hemisphere(u2(u))), |w| cosine_hemisphere_pdf(w.z)),
    );
    check("sphere", ChiSquareTest::new(Sphere).run(|u| Some(square_to_sphere(u2(u))), |_| sphere_pdf()));
    for h in [2.0f32, 1.3, 0.1, 1e-3, 1e-6] {
        // cosθ loses the border of a narrow cone, so sin²θ = h (2 - h) tells.
        let inside = |w: Vec3| if h >= 1.0 { 1.0 - w.z <= h } else { w.z > 0.0 && w.truncate().length_squared() <= h * (2.0 - h) };
        let pdf = |w: Vec3| if inside(w) { cone_pdf(h) } else { 0.0 };
        check(&format!("cone {h}"), ChiSquareTest::new(Sphere).run(|u| Some(square_to_cone(u2(u), h * 0.999_999)), pdf));
    }
    let triangle = |u: [f32; 3]| Some(Vec2::from_slice(&square_to_triangle(u2(u))[..2]));
    check("triangle", ChiSquareTest::new(Triangle).run(triangle, |_| 2.0));
    check("tent", ChiSquareTest::new(Interval(-1.0, 1.0)).run(|u| Some(sample_tent(u[0])), tent_pdf));
}

#[test]
fn inverses_invert() {
    let mut r = rng(5);
    let close = |name: &str, u: Vec2, back: Vec2, tolerance: f32| {
        let d = (u - back).abs();
        assert!(d.max_element() < tolerance && back.min_element() >= 0.0 && back.max_element() < 1.0, "{name}: {u} became {back}");
    };
    for _ in 0..10_000 {
        let u = r.u2();
        close("disk", u, disk_to_square(square_to_disk(u)), 1e-6);
        close("hemisphere", u, hemisphere_to_square(square_to_hemisphere(u)), 2e-6);
        close("cosine", u, cosine_hemisphere_to_square(square_to_cosine_hemisphere(u)), 1e-6);
        close("cone", u, cone_to_square(square_to_cone(u, 1e-4), 1e-4), 2e-6);
        let [b0, b1, _] = square_to_triangle(u);
        close("triangle", u, triangle_to_square(b0, b1), 1e-6);
        close("tent", Vec2::new(u.x, 0.0), Vec2::new(invert_tent(sample_tent(u.x)), 0.0), 1e-6);
        // Near the poles φ is lost.
        if (0.01..0.99).contains(&u.x) {
            close("sphere", u, sphere_to_square(square_to_sphere(u)), 2e-6);
        }
    }
}

#[test]
fn the_corners_of_the_square_are_fine() {
    for u in [Vec2::ZERO, Vec2::splat(math::ONE_MINUS_EPSILON), Vec2::new(0.0, math::ONE_MINUS_EPSILON), Vec2::splat(0.5)] {
        assert!(square_to_disk(u).length() <= 1.0 + 1e-6);
        for w in [square_to_hemisphere(u), square_to_cosine_hemisphere(u), square_to_sphere(u), square_to_cone(u, 0.3)] {
            assert!((w.length() - 1.0).abs() < 1e-6, "{u} {w}");
        }
        assert!(cosine_hemisphere_pdf(square_to_cosine_hemisphere(u).z) > 0.0);
        let b = square_to_triangle(u);
        assert!(b.iter().all(|&b| (-1e-7..=1.0).contains(&b)) && (b.iter().sum::<f32>() - 1.0).abs() < 1e-6);
    }
}

/// Uniform in area over a flat triangle or parallelogram; the density per steradian of its direction.
fn flat_pdf(area: f32, n: Vec3, p: Vec3) -> f32 {
    let d2 = p.length_squared();
    d2 * d2.sqrt() / (area * n.dot(p).abs())
}

#[test]
fn octants_and_faces_have_their_solid_angles() {
    let octant = SphericalTriangle::new(Vec3::X, Vec3::Y * 3.0, Vec3::Z * 0.2).unwrap();
    assert!((octant.solid_angle() - math::FRAC_PI_2).abs() < 1e-6);
    let face = SphericalRectangle::new(Vec3::new(-1.0, -1.0, 1.0), 2.0 * Vec3::X, 2.0 * Vec3::Y).unwrap();
    assert!((face.solid_angle() - 4.0 * math::PI / 6.0).abs() < 1e-6);
    // A small far square: Ω = A/r².
    let far = SphericalRectangle::new(Vec3::new(-0.5, -0.5, -1e3), Vec3::X, Vec3::Y).unwrap();
    assert!((far.solid_angle() * 1e6 - 1.0).abs() < 1e-5, "{}", far.solid_angle());
    let far = SphericalTriangle::new(Vec3::new(-0.5, -0.5, -1e3), Vec3::new(0.5, -0.5, -1e3), Vec3::new(0.5, 0.5, -1e3)).unwrap();
    assert!((far.solid_angle() * 2e6 - 1.0).abs() < 1e-5, "{}", far.solid_angle());
    assert!(SphericalTriangle::new(Vec3::X, Vec3::X, Vec3::Y).is_none());
    assert!(SphericalTriangle::new(Vec3::X, Vec3::Y, Vec3::X + Vec3::Y).is_none());
    assert!(SphericalTriangle::new(Vec3::ZERO, Vec3::Y, Vec3::X).is_none());
    assert!(SphericalRectangle::new(Vec3::X, Vec3::X, Vec3::Y).is_none());
}

/// Directions mapped back to where they meet the flat shape, whose density per area is the one per steradian times cosθ/r².
#[test]
fn spherical_triangles_are_sampled_uniformly() {
    let shapes = [
        [Vec3::new(1.0, 0.0, 1.0), Vec3::new(-0.5, 1.0, 1.0), Vec3::new(-0.5, -1.0, 1.2)],
        [Vec3::new(0.0, 0.0, 0.05), Vec3::new(3.0, 0.1, 0.3), Vec3::new(-1.0, 2.0, -0.01)],
        [Vec3::new(20.0, 0.0, 1.0), Vec3::new(20.0, 0.5, 1.0), Vec3::new(20.0, 0.1, 1.3)],
        [Vec3::new(400.0, 0.0, 1.0), Vec3::new(400.0, 0.2, 1.0), Vec3::new(401.0, 0.1, 1.3)],
        [Vec3::new(5.0, 0.0, 0.01), Vec3::new(6.0, 4.0, 0.02), Vec3::new(9.0, 1.0, 0.01)],
    ];
    for [a, b, c] in shapes {
        let triangle = SphericalTriangle::new(a, b, c).unwrap();
        let (e1, e2) = ((b - a).as_dvec3(), (c - a).as_dvec3());
        let n = e1.cross(e2);
        let meet = |w: Vec3| {
            let w = w.as_dvec3();
            let t = n.dot(a.as_dvec3()) / n.dot(w);
            let d = w * t - a.as_dvec3();
            let (b1, b2) = (d.cross(e2).dot(n) / n.dot(n), e1.cross(d).dot(n) / n.dot(n));
            // Rounding of the direction may leave the border by a little.
            let (b1, b2) = (b1.max(0.0), b2.max(0.0));
            let s = (b1 + b2).max(1.0);
            Vec2::new((b1 / s) as f32, (b2 / s) as f32)
        };
        let pdf = |b: Vec2| {
            let p = a + (e1 * f64::from(b.x) + e2 * f64::from(b.y)).as_vec3();
            // Per unit of (b₁, b₂): the area element is |n|.
            triangle.pdf() * 2.0 / flat_pdf(0.5 * n.length() as f32, n.normalize().as_vec3(), p)
        };
        check(&format!("{triangle:?}"), ChiSquareTest::new(Triangle).run(|u| Some(meet(triangle.sample(u2(u)))), pdf));
    }
}

#[test]
fn spherical_rectangles_are_sampled_uniformly() {
    let shapes = [
        (Vec3::new(-1.0, -1.0, 1.0), 2.0, 2.0),
        (Vec3::new(0.3, -4.0, -0.1), 5.0, 1.0),
        (Vec3::new(-3.0, -4.0, 0.001), 5.0, 7.0),
        (Vec3::new(100.0, -40.0, 30.0), 0.5, 0.2),
        (Vec3::new(0.0, 0.0, -1e3), 0.5, 0.2),
    ];
    let (x, y, z) = (Vec3::new(0.6, 0.0, 0.8), Vec3::Y, Vec3::new(-0.8, 0.0, 0.6));
    for (corner, lx, ly) in shapes {
        let corner = x * corner.x + y * corner.y + z * corner.z;
        let rect = SphericalRectangle::new(corner, x * lx, y * ly).unwrap();
        let meet = |p: Vec3| (Vec2::new(x.dot(p - corner) / lx, y.dot(p - corner) / ly)).clamp(Vec2::ZERO, Vec2::ONE);
        let pdf = |s: Vec2| rect.pdf() / flat_pdf(lx * ly, z, corner + x * (lx * s.x) + y * (ly * s.y));
        check(&format!("{rect:?}"), ChiSquareTest::new(Square).run(|u| Some(meet(rect.sample(u2(u)))), pdf));
    }
}

#[test]
fn random_triangles_stay_within_their_edges() {
    let mut r: Rng = rng(11);
    for _ in 0..2000 {
        let corner = |r: &mut Rng| Vec3::new(r.u1() - 0.5, r.u1() - 0.5, r.u1() - 0.5);
        let (a, b, c) = (corner(&mut r), corner(&mut r), corner(&mut r));
        let Some(triangle) = SphericalTriangle::new(a, b, c) else { continue };
        let side = a.dot(b.cross(c)).signum();
        for u in [Vec2::ZERO, Vec2::splat(math::ONE_MINUS_EPSILON), r.u2(), r.u2(), r.u2()] {
            let w = triangle.sample(u);
            let margin = |p: Vec3, q: Vec3| side * w.dot(p.cross(q).normalize());
            assert!((w.length() - 1.0).abs() < 1e-5);
            assert!(margin(a, b).min(margin(b, c)).min(margin(c, a)) > -2e-5, "{triangle:?} {u} {w}");
        }
    }
}
