//! Patches fill their surfaces, hits find them, and they know what they reflect and emit.

mod common;

use common::*;
use etendue_numerics::{Ray, Vec2, Vec3};
use etendue_radiosity::{Cutting, PatchSize, Patches, Side, Sides};
use glam::DVec3;
use std::f64::consts::PI;

/// One of everything, apart from each other.
fn zoo() -> String {
    let group = format!(
        r#"<shape type="shapegroup" id="g">{}{}</shape>"#,
        shape("cube", r#"<scale value="0.5"/>"#, ""),
        shape("sphere", r#"<translate x="2"/>"#, "")
    );
    let instance = |transform: &str| {
        format!(r#"<shape type="instance"><transform name="to_world">{transform}</transform><ref id="g"/></shape>"#)
    };
    [
        shape("sphere", r#"<scale value="1.5"/>"#, ""),
        shape("sphere", r#"<translate y="5"/>"#, FLIPPED),
        shape("disk", r#"<rotate x="1" y="2" angle="40"/><translate x="5"/>"#, ""),
        shape("cylinder", r#"<scale value="0.7"/><rotate y="1" angle="30"/><translate x="-5"/>"#, ""),
        shape("cube", r#"<rotate x="1" angle="20"/><translate z="6"/>"#, ""),
        shape("rectangle", r#"<scale x="2"/><translate z="-6"/>"#, r#"<bsdf type="twosided"><bsdf type="diffuse"/></bsdf>"#),
        group,
        instance(r#"<translate x="12"/>"#),
        instance(r#"<scale x="-1" y="2" z="0.5"/><rotate z="1" angle="50"/><translate x="-12" y="3"/>"#),
    ]
    .concat()
}

#[test]
fn a_ray_to_a_point_of_a_patch_finds_the_patch() {
    let scene = scene(&zoo());
    let patches = cut(&scene, PatchSize::Metres(0.4));
    assert!(patches.len() > 500, "{} patches", patches.len());
    let finer = patches.subdivided(&scene, |i| i % 3 == 0);
    assert!(finer.len() > patches.len() * 3 / 2);
    for patches in [&patches, &finer] {
        for i in 0..patches.len() as u32 {
            let patch = patches.get(i);
            for u in [Vec2::new(0.3, 0.6), Vec2::new(0.71, 0.2), Vec2::new(0.05, 0.1)] {
                let x = patches.sample(i, u);
                // From close by, so that nothing else is in the way.
                let n = x.n.as_vec3();
                let ray = Ray::new(x.p.as_vec3() + n * 0.05, -n);
                let hit = scene.intersect(&ray).expect("a hit");
                let place = patches.locate(&ray, &hit).expect("a patch");
                assert_eq!(place.patch, Some(i), "{patch:?} at {u}");
                assert_eq!(place.side, patch.side);
                // The surface is where the patch says, and so is its front.
                let seen = scene.interaction(&ray, &hit);
                assert!((seen.p - x.p.as_vec3()).length() < 1e-4);
                assert!((seen.n.dot(n) - patch.side.sign() as f32).abs() < 1e-3);
                // Rays that leave it are clear of it.
                let leaving = patches.spawn(i, &x, n);
                assert!(leaving.o.distance(x.p.as_vec3()) < 1e-4);
                let again = scene.intersect(&leaving);
                assert!(again.is_none_or(|h| h.t > 0.1), "{patch:?}: met itself at {again:?}");
            }
        }
    }
}

#[test]
fn areas_add_up_and_patches_stay_in_their_balls() {
    let scene = scene(&zoo());
    for (size, tolerance) in [(PatchSize::Whole, 1e-5), (PatchSize::Metres(0.25), 1e-5)] {
        let patches = cut(&scene, size);
        for object in &patches.objects {
            let sum: f64 = object.patches.clone().map(|i| patches.get(i)).filter(|p| p.side == Side::Front).map(|p| p.area).sum();
            if object.instance == etendue_scene::NO_INSTANCE {
                let exact = scene.surface(object.surface).shape.area();
                assert!((sum / exact - 1.0).abs() < tolerance, "{object:?}: {sum} of {exact}");
            }
        }
        for i in 0..patches.len() as u32 {
            let (middle, radius) = patches.ball(i);
            for k in 0..64 {
                let x = patches.sample(i, Vec2::new(k as f32 / 64.0, (k * 37 % 64) as f32 / 64.0));
                assert!(x.p.distance(middle) <= radius * (1.0 + 1e-9) + 1e-9);
            }
        }
    }
}

#[test]
fn samples_are_uniform() {
    // The weighted mean of p over samples is the centroid by area, also where parameters are not in step with area.
    let trapezium = r#"<scale x="1" y="1"/>"#;
    let scene = scene(&(shape("cylinder", r#"<scale x="2" y="1" z="3"/>"#, "") + &shape("rectangle", trapezium, "")));
    let patches = cut(&scene, PatchSize::Metres(0.8));
    for i in 0..patches.len() as u32 {
        let n = 64;
        let (mut sum, mut mean) = (0.0, DVec3::ZERO);
        for k in 0..n * n {
            let x = patches.sample(i, Vec2::new((k % n) as f32 + 0.5, (k / n) as f32 + 0.5) / n as f32);
            sum += x.weight;
            mean += x.p * x.weight;
        }
        assert!((sum / f64::from(n * n) - 1.0).abs() < 1e-3, "weights are one on average");
        assert!((mean / sum).distance(patches.get(i).p) < 0.1);
    }
}

#[test]
fn a_number_of_patches_is_met() {
    let scene = scene(&zoo());
    for n in [500, 2000, 10_000] {
        let found = cut(&scene, PatchSize::Count(n)).len();
        assert!(found <= n && found * 10 > n * 8, "{found} for {n}");
    }
    let few = cut(&scene, PatchSize::Count(1));
    assert_eq!(few.len(), cut(&scene, PatchSize::Whole).len(), "no fewer than the pieces");
    let refused =
        Patches::cut(&scene, &Cutting { size: PatchSize::Metres(1e-4), most: 10_000, ..Cutting::default() }).expect_err("too many");
    assert!(refused.patches > 1_000_000 && refused.size.is_some());
    let fits = Cutting { size: PatchSize::Metres(refused.size.expect("a size")), most: 10_000, ..Cutting::default() };
    assert!(Patches::cut(&scene, &fits).is_ok_and(|p| p.len() > 5000));
}

/// A floor of one piece stayed whole where furniture of many pieces had used up the number, and light of its sunny end was everywhere.
#[test]
fn a_floor_is_cut_however_many_pieces_stand_on_it() {
    let crumb = |i: usize| {
        let (x, y) = (i % 20, i / 20);
        shape("cube", &format!(r#"<scale value="0.02"/><translate x="{x}" y="{y}" z="1"/>"#), "")
    };
    let crumbs: String = (0..400).map(crumb).collect();
    let floor = shape("rectangle", r#"<scale value="10"/><translate x="10" y="10"/>"#, "");
    let scene = scene(&format!("{floor}{crumbs}"));
    // Half of the number on top of the 2,401 pieces; four times as much where they are more than four times the number.
    for (n, more) in [(1000, 500), (500, 2000)] {
        let patches = cut(&scene, PatchSize::Count(n));
        let of_floor = patches.objects[0].patches.len();
        let of_crumbs = patches.len() - of_floor;
        assert!(
            (2400..=2400 + more).contains(&of_crumbs) && of_floor > more / 2 && patches.len() <= 2401 + more,
            "{of_floor} of {} for {n}",
            patches.len()
        );
    }
}

#[test]
fn sides_are_chosen() {
    let bsdf = |inside: &str| {
        format!(
            r#"<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.2, 0.4, 0.6"/></bsdf>{inside}</bsdf>"#
        )
    };
    let one = shape("rectangle", "", r#"<bsdf type="diffuse"/>"#);
    let two = shape("rectangle", r#"<translate z="2"/>"#, &bsdf(""));
    let other =
        shape("rectangle", r#"<translate z="4"/>"#, &bsdf(r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.9"/></bsdf>"#));
    let scene = scene(&(one + &two + &other));
    let patches = cut(&scene, PatchSize::Whole);
    let sides: Vec<_> = patches.patches.iter().map(|p| (p.object, p.side, p.rho.to_rgb())).collect();
    let (grey, blue, white) = ([0.5; 3], [0.2, 0.4, 0.6], [0.9; 3]);
    let expected =
        [(0, Side::Front, grey), (1, Side::Front, blue), (1, Side::Back, blue), (2, Side::Front, blue), (2, Side::Back, white)];
    assert_eq!(sides.len(), expected.len());
    for (found, expected) in sides.iter().zip(expected) {
        assert_eq!((found.0, found.1), (expected.0, expected.1));
        assert!(found.2.iter().zip(expected.2).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?}");
    }
    assert!(patches.not_diffuse.is_empty());
    assert_eq!(sided(&scene, PatchSize::Whole, Sides::Front).len(), 3);
    assert_eq!(sided(&scene, PatchSize::Whole, Sides::Both).len(), 6);
    for p in &patches.patches {
        assert_eq!(p.n, DVec3::Z * p.side.sign());
    }
}

#[test]
fn textures_are_averaged_over_patches() {
    let board = |name: &str, a: &str, b: &str| {
        format!(
            r#"<texture type="checkerboard" name="{name}"><rgb name="color0" value="{a}"/><rgb name="color1" value="{b}"/>
               <transform name="to_uv"><scale x="1" y="1"/></transform></texture>"#
        )
    };
    let bsdf = format!(r#"<bsdf type="diffuse">{}</bsdf>"#, board("reflectance", "0.2", "0.8"));
    let emitter = format!(r#"<emitter type="area">{}</emitter>"#, board("radiance", "0.25", "0.75"));
    let scene = scene(&shape("rectangle", "", &(bsdf + &emitter)));
    let one = cut(&scene, PatchSize::Whole);
    let p = &one.patches[0];
    assert!((p.rho[0] - 0.5).abs() < 1e-5 && (f64::from(p.be[0]) - 0.5 * PI).abs() < 1e-4, "{p:?}");
    // Cut along the squares each patch has one colour.
    let four = cut(&scene, PatchSize::Metres(1.0));
    assert_eq!(four.len(), 4);
    for p in &four.patches {
        let dark = (p.rho[0] - 0.2).abs() < 1e-5;
        assert!(dark || (p.rho[0] - 0.8).abs() < 1e-5);
        assert!((f64::from(p.be[0]) - PI * if dark { 0.25 } else { 0.75 }).abs() < 1e-4);
    }
}

#[test]
fn what_is_not_diffuse_is_told() {
    let glass = shape("sphere", "", r#"<bsdf type="dielectric"><float name="int_ior" value="1.5"/></bsdf>"#);
    let metal = shape(
        "sphere",
        r#"<translate x="3"/>"#,
        r#"<bsdf type="roughconductor"><rgb name="specular_reflectance" value="0.5"/></bsdf>"#,
    );
    let scene = scene(&(glass + &metal));
    let patches = cut(&scene, PatchSize::Whole);
    assert_eq!(patches.not_diffuse.len(), 3, "both sides of the glass, the front of the metal: {:?}", patches.not_diffuse);
    let outside = &patches.not_diffuse[0];
    // Diffuse light on glass of index 1.5: 9.18 % are reflected [Duntley 1942].
    assert!((outside.reflected[0] - 0.0918).abs() < 3e-3 && (outside.transmitted[0] - 0.9082).abs() < 3e-3, "{outside:?}");
    // From within 59.6 %: (1 - 0.0918) / 1.5² leaves.
    let inside = &patches.not_diffuse[1];
    assert!(inside.side == Side::Back && (inside.reflected[0] - 0.5963).abs() < 5e-3, "{inside:?}");
    let metal = &patches.not_diffuse[2];
    assert_eq!((metal.side, metal.material), (Side::Front, "RoughConductor"));
    assert!(metal.reflected[0] > 0.2 && metal.reflected[0] < 0.5 && metal.transmitted.is_zero());
}

#[test]
fn corners_are_shared_where_the_surface_goes_on() {
    // A cube of 2 x 2 patches a face: 9 vertices on each, none shared around the edges.
    let scene_ = scene(&shape("cube", "", ""));
    let patches = cut(&scene_, PatchSize::Metres(1.0));
    let vertices = patches.vertices(&scene_);
    assert_eq!((patches.len(), vertices.points.len(), vertices.hanging.len()), (24, 54, 0));
    let of_normal = |values: &[DVec3]| values.iter().zip(&vertices.normals).all(|(v, n)| v.distance(*n) < 1e-6);
    let normals: Vec<DVec3> = patches.patches.iter().map(|p| p.n).collect();
    assert!(of_normal(&vertices.average(&patches, &normals)), "each face keeps its own value");

    // A sphere is closed: vertices - edges + faces = 2, where T-junctions add an edge for each vertex.
    let ball = scene(&shape("sphere", "", ""));
    let patches = cut(&ball, PatchSize::Metres(0.3));
    let vertices = patches.vertices(&ball);
    let distinct = |i: usize| (0..4).filter(|k| vertices.corners[i][*k] != vertices.corners[i][(k + 1) % 4]).count();
    let half_edges: usize = (0..patches.len()).map(distinct).sum();
    let edges = (half_edges + vertices.hanging.len()) / 2;
    assert!(!vertices.hanging.is_empty());
    assert_eq!((vertices.points.len() + patches.len()) as i64 - edges as i64, 2);
}

#[test]
fn the_interpolation_has_no_cracks_at_t_junctions() {
    // A floor of two rectangles of unlike patches, one of them cut further: an affine field of values at vertices stays affine.
    let left = shape("rectangle", r#"<translate x="-1"/>"#, "");
    let right = shape("rectangle", r#"<scale x="0.7" y="1"/><translate x="0.7"/>"#, "");
    let scene = scene(&(left + &right));
    let coarse = cut(&scene, PatchSize::Metres(0.5));
    let patches = coarse.subdivided(&scene, |i| i % 5 == 0).subdivided(&scene, |i| i % 7 == 0);
    let vertices = patches.vertices(&scene);
    assert!(vertices.hanging.len() > 8);
    // Random values at free vertices; then both sides of every edge see the same.
    let mut values: Vec<DVec3> =
        vertices.points.iter().map(|p| DVec3::splat((p.x * 12.9898 + p.y * 78.233).sin() * 43758.5453 % 1.0)).collect();
    for h in &vertices.hanging {
        values[h.vertex as usize] = values[h.ends[0] as usize].lerp(values[h.ends[1] as usize], h.t);
    }
    let value = |p: Vec3| {
        let ray = Ray::new(p + Vec3::Z, -Vec3::Z);
        let hit = scene.intersect(&ray)?;
        let place = patches.locate(&ray, &hit)?;
        Some(vertices.weights(place.patch?, place.local).iter().map(|(v, w)| values[*v as usize].x * w).sum::<f64>())
    };
    let step = 2e-5;
    for i in 0..200 {
        for j in 0..200 {
            let p = Vec3::new(-1.95 + 3.3 * i as f32 / 200.0, -0.95 + 1.9 * j as f32 / 200.0, 0.0);
            // Slopes are at most a few hundred per metre: a crack would be of order one.
            let (here, x, y) = (value(p), value(p + Vec3::X * step), value(p + Vec3::Y * step));
            for there in [x, y] {
                let (Some(a), Some(b)) = (here, there) else { panic!("a hole at {p}") };
                assert!((a - b).abs() < 5e-3, "{a} and {b} at {p}");
            }
        }
    }
}

/// A wall stands on a floor where patches of either side meet under it: light of one side is not interpolated into the other.
#[test]
fn light_is_not_interpolated_under_a_wall() {
    let wall = shape("cube", r#"<scale x="0.05" y="1.2" z="0.5"/><translate x="0.03" z="0.5"/>"#, "");
    let scene = scene(&(shape("rectangle", "", "") + &wall));
    let patches = cut(&scene, PatchSize::Metres(0.2));
    let vertices = patches.vertices(&scene);
    let lit = |p: DVec3| if p.x < 0.0 { DVec3::ONE } else { DVec3::ZERO };
    let values: Vec<DVec3> = patches.patches.iter().map(|p| lit(p.p)).collect();
    let field = etendue_radiosity::Field::new(&patches, &vertices, &values);
    let floor = patches.objects[0].patches.clone();
    assert_eq!(floor.len(), 100);
    for i in floor {
        for local in [(0.0, 0.0), (1.0, 0.0), (0.5, 0.5), (0.0, 1.0), (1.0, 1.0)] {
            let (found, p) = (field.value(&vertices, i, local.into()), patches.get(i).p);
            assert!((found - lit(p)).length() < 1e-9, "{found} at {local:?} of the patch at {p}");
        }
    }
}
