//! Form factors pair by pair: closed forms, rooms with something in the way, and what is told of bad input.

mod common;

use common::*;
use etendue_radiosity::form_factor::{FormFactors, Hemisphere, Open, Pairs, analytic, by_area, hemisphere};
use etendue_radiosity::patch::Fault;
use etendue_radiosity::{PatchSize, Patches, Sides};
use etendue_scene::Scene;
use std::f64::consts::PI;

fn by_analytic(scene: &Scene, patches: &Patches) -> FormFactors {
    analytic(scene, patches, &Pairs::default(), &|_, _| true).expect("not cancelled")
}

fn by_quadrature(scene: &Scene, patches: &Patches) -> FormFactors {
    by_area(scene, patches, &|_, _| true).expect("not cancelled")
}

fn areas(patches: &Patches) -> Vec<f64> {
    patches.patches.iter().map(|p| p.area).collect()
}

/// A room of 2 x 2 x 2 m about the origin.
fn room() -> String {
    shape("cube", "", FLIPPED)
}

#[test]
fn a_room_closes_without_rays() {
    let scene = scene(&room());
    let patches = cut(&scene, PatchSize::Metres(0.5));
    for (f, bound) in [(by_analytic(&scene, &patches), 1e-6), (by_quadrature(&scene, &patches), 1e-3)] {
        for i in 0..f.len() {
            let sum = f.row_sum(i);
            assert!((sum - 1.0).abs() < bound, "row {i} sums to {sum}");
            assert!(f.row(i).all(|(j, x)| (0.0..=1.0).contains(&x) && f.error(i, j) < 1e-12));
        }
    }
    // The whole of a cube: to the opposite side 0.1998, to each of the others 0.2000.
    let patches = cut(&scene, PatchSize::Whole);
    let f = by_analytic(&scene, &patches);
    let facing = 2.0 / PI * ((2.0 / 3f64.sqrt()).ln() + 2.0 * 2f64.sqrt() * (1.0 / 2f64.sqrt()).atan() - PI / 2.0);
    for i in 0..6 {
        for j in 0..6 {
            let opposite = patches.patches[i].n.dot(patches.patches[j].n) < -0.5;
            let exact = if i == j {
                0.0
            } else if opposite {
                facing
            } else {
                (1.0 - facing) / 4.0
            };
            assert!((f.get(i, j) - exact).abs() < 1e-6, "{i} {j}: {} for {exact}", f.get(i, j));
        }
    }
}

#[test]
fn round_shapes_have_closed_forms_too() {
    let disk = |r: f64, z: f64, turn: &str| shape("disk", &format!(r#"<scale value="{r}"/>{turn}<translate z="{z}"/>"#), "");
    let down = r#"<rotate y="1" angle="180"/>"#;
    let (a, b, d) = (1.0, 1.0, 2.0f64);
    let corner = (a * b / (d * (a * a + b * b + d * d).sqrt())).atan();
    let sphere = shape("sphere", &format!(r#"<scale value="0.5"/><translate z="{d}"/>"#), "");
    let square = shape("rectangle", r#"<scale value="0.5"/><translate x="0.5" y="0.5"/>"#, "");
    let (x, y) = (1.0 / 1.5, 0.5 / 1.5);
    let s = 1.0 + (1.0 + y * y) / (x * x);
    let discs = 0.5 * (s - (s * s - 4.0 * 0.25f64).sqrt());
    for (text, exact, tolerance) in [
        (disk(1.0, 0.0, "") + &disk(0.5, 1.5, down), discs, 2e-4),
        (sphere + &square, corner / (4.0 * PI), 2e-5),
        (shape("sphere", "", FLIPPED), 1.0, 1e-6),
    ] {
        let scene = scene(&text);
        let patches = sided(&scene, PatchSize::Whole, Sides::Front);
        for f in [by_analytic(&scene, &patches), by_quadrature(&scene, &patches)] {
            let found = f.get(0, f.len() - 1);
            assert!((found - exact).abs() < tolerance + 4.0 * f.error(0, f.len() - 1), "{found} for {exact}");
        }
    }
}

/// A room with a box in it: every row closes before any repair, the three methods agree, and a repair closes all rows.
#[test]
fn a_room_with_a_box_closes() {
    let hovering =
        shape("cube", r#"<scale x="0.5" y="0.4" z="0.3"/><rotate z="1" angle="20"/><translate x="0.2" y="-0.1" z="-0.4"/>"#, "");
    let scene = scene(&(room() + &hovering));
    let patches = cut(&scene, PatchSize::Metres(0.9));
    let areas = areas(&patches);
    let total: f64 = areas.iter().sum();
    let rays = Hemisphere { rays: 1 << 14, ..Hemisphere::default() };
    let mut cast = hemisphere(&scene, &patches, &rays, &|_, _| true).expect("not cancelled");
    let n = patches.len();
    for (name, mut f) in [("analytic", by_analytic(&scene, &patches)), ("area", by_quadrature(&scene, &patches))] {
        let worst = (0..n).map(|i| (f.row_sum(i) - 1.0).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-3, "{name}: a row is {worst} off");
        // Against rays: all entries together, a part of 1e-3 of all light at most beyond what the errors of both explain.
        let mut off = 0.0;
        for (i, area) in areas.iter().enumerate() {
            for j in 0..n {
                let error = (f.error(i, j).powi(2) + cast.error(i, j).powi(2)).sqrt();
                off += area * ((f.get(i, j) - cast.get(i, j)).abs() - 3.0 * error).max(0.0);
            }
        }
        assert!(off / total < 1e-3, "{name}: {} of all light goes elsewhere", off / total);
        let told = f.repair(&areas, Open::WithLosses);
        assert!(told.closed && told.closure_after <= 1e-12 && told.closure_before < 1e-3, "{told:?}");
        assert!((0..n).all(|i| f.row(i).all(|(_, x)| (0.0..=1.0).contains(&x))));
    }

    // Rays by themselves: z = (A_i F_ij - A_j F_ji) / SE over all pairs, whose squares follow chi-square where counts are large.
    let mut sum = 0.0;
    let mut count = 0.0;
    for i in 0..n {
        for j in 0..i {
            let (a, b) = (areas[i] * cast.get(i, j), areas[j] * cast.get(j, i));
            let variance = (areas[i] * cast.error(i, j)).powi(2) + (areas[j] * cast.error(j, i)).powi(2);
            if a > 2e-3 * areas[i] && b > 2e-3 * areas[j] {
                sum += (a - b).powi(2) / variance;
                count += 1.0;
            }
        }
    }
    // t of about 30 degrees of freedom: the mean square is 30/28, its own spread 1.5 / √count; five of them.
    assert!(count > 200.0 && (sum / count - 1.07f64).abs() < 7.5 / f64::sqrt(count), "chi² {sum} of {count} pairs");
    let told = cast.repair(&areas, Open::WithLosses);
    assert!(told.closed && told.closure_after <= 1e-12, "{told:?}");
}

/// Before any repair every row closes to 1e-3, whatever stands in the way and however large the patches are. Row sums have standard errors of
/// 3e-4 at most, mostly of half that: a chance of one in a thousand for the worst row, and seeds are fixed.
#[test]
fn rows_close_in_several_rooms() {
    let stand = |inside: &str| room() + &shape("cube", inside, "");
    let leaning = r#"<scale x="0.3" y="0.35" z="0.7"/><rotate x="1" angle="35"/><translate x="-0.4" y="0.3" z="0.1"/>"#;
    for text in [
        stand(r#"<scale x="0.3" y="0.4" z="0.45"/><rotate z="1" angle="20"/><translate x="0.2" y="-0.1" z="-0.55"/>"#),
        stand(r#"<scale x="0.6" y="0.4" z="0.03"/><rotate z="1" angle="20"/><translate x="0.2" y="-0.1" z="-0.4"/>"#),
        stand(leaning) + &shape("sphere", r#"<scale value="0.3"/><translate x="0.5" y="-0.5" z="-0.5"/>"#, ""),
    ] {
        let scene = scene(&text);
        let patches = cut(&scene, PatchSize::Metres(2.0));
        for (name, f) in [("analytic", by_analytic(&scene, &patches)), ("area", by_quadrature(&scene, &patches))] {
            let worst = (0..f.len()).map(|i| (f.row_sum(i) - 1.0).abs()).fold(0.0, f64::max);
            let error = |i: usize| (0..f.len()).map(|j| f.error(i, j).powi(2)).sum::<f64>().sqrt();
            assert!((0..f.len()).all(|i| error(i) < 3e-4), "{name}: errors {:?}", (0..f.len()).map(error).collect::<Vec<_>>());
            assert!(worst < 1e-3, "{name}: a row is {worst} off");
        }
    }
}

#[test]
fn a_box_on_the_floor_touches_it() {
    // The bottom of the box lies on the floor: the two see each other alone.
    let standing = shape("cube", r#"<scale x="0.5" y="0.5" z="0.3"/><translate z="-0.7"/>"#, "");
    let scene = scene(&(room() + &standing));
    let patches = cut(&scene, PatchSize::Metres(0.7));
    let touching: Vec<_> = patches.faults.iter().filter(|f| matches!(f, Fault::Touching { .. })).collect();
    assert!(matches!(touching[..], [Fault::Touching { area, .. }] if (area - 1.0).abs() < 1e-5), "{:?}", patches.faults);
    let rays = Hemisphere { rays: 1 << 12, ..Hemisphere::default() };
    let cast = hemisphere(&scene, &patches, &rays, &|_, _| true).expect("not cancelled");
    assert!(cast.absorbed.iter().all(|a| *a < 2e-3), "{:?}", cast.absorbed);
    let f = by_analytic(&scene, &patches);
    let worst = (0..f.len()).map(|i| (f.row_sum(i) - 1.0).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-3, "a row is {worst} off");
    // Two rooms back to back share a plane too, and do not touch.
    let rooms = room() + &shape("cube", r#"<translate x="2"/>"#, FLIPPED);
    let patches = cut(&common::scene(&rooms), PatchSize::Whole);
    assert!(matches!(patches.faults[..], [Fault::Doubled { .. }]), "{:?}", patches.faults);
}

/// A box of two-sided material on a floor: what it covers of the floor sees the bottom of the box alone, from whichever side the floor is wound, and no
/// light of the floor gets into the box. Row sums have standard errors below 3e-4.
#[test]
fn a_box_of_two_sides_covers_the_floor() {
    let two = r#"<bsdf type="twosided"><bsdf type="diffuse"/></bsdf>"#;
    let room = shape("cube", "", &(FLIPPED.to_owned() + two));
    let wall = |turn: &str| shape("rectangle", turn, two);
    // Six sheets, with fronts inside and outside.
    let sheets = |turned: &str| {
        [
            format!(r#"{turned}<translate z="-1"/>"#),
            format!(r#"{turned}<translate z="-1"/><rotate x="1" angle="180"/>"#),
            format!(r#"{turned}<translate z="-1"/><rotate x="1" angle="90"/>"#),
            format!(r#"{turned}<translate z="-1"/><rotate x="1" angle="-90"/>"#),
            format!(r#"{turned}<translate z="-1"/><rotate y="1" angle="90"/>"#),
            format!(r#"{turned}<translate z="-1"/><rotate y="1" angle="-90"/>"#),
        ]
        .map(|t| wall(&t))
        .concat()
    };
    let standing = shape("cube", r#"<scale x="0.5" y="0.5" z="0.3"/><translate z="-0.7"/>"#, two);
    for around in [room, sheets(""), sheets(r#"<rotate x="1" angle="180"/>"#)] {
        let scene = scene(&(around + &standing));
        let patches = cut(&scene, PatchSize::Metres(0.7));
        let touching: f64 = patches.faults.iter().map(|f| if let Fault::Touching { area, .. } = f { *area } else { 0.0 }).sum();
        assert!((touching - 1.0).abs() < 1e-5, "{:?}", patches.faults);
        let open = etendue_radiosity::cover::open(&scene, &patches, |_| etendue_radiosity::cover::POINTS, 0);
        let inside_room = |i: usize| {
            let p = patches.patches[i].p;
            let n = patches.patches[i].n;
            p.abs().max_element() < 1.0 - 1e-6 || n.dot(p) < 0.0
        };
        // On the floor and under the box: 1 m² each. Of 64 points a patch, 1.5 % of the area is a third of a row of points.
        let covered: f64 = (0..patches.len()).map(|i| (1.0 - open[i]) * patches.patches[i].area).sum();
        assert!((covered - 2.0).abs() < 0.03, "{covered} m² are covered");

        // What is within the box: fronts of it are outside.
        let within = |i: usize| {
            let (p, n) = (patches.patches[i].p, patches.patches[i].n);
            let middle = glam::DVec3::new(0.0, 0.0, -0.7);
            (p - middle).abs().cmple(glam::DVec3::new(0.5 + 1e-6, 0.5 + 1e-6, 0.3 + 1e-6)).all()
                && n.dot(p - middle) < 0.0
                && patches.patches[i].side == etendue_radiosity::Side::Back
                && patches.objects[patches.patches[i].object as usize].surface.index() + 1 == scene.surfaces.len()
        };
        assert_eq!((0..patches.len()).filter(|i| within(*i)).count() * 2, {
            let last = patches.objects.last().expect("the box");
            last.patches.len()
        });
        let rays = Hemisphere { rays: 1 << 12, ..Hemisphere::default() };
        let cast = hemisphere(&scene, &patches, &rays, &|_, _| true).expect("not cancelled");
        for (name, f, most) in [("rays", cast, 2e-3), ("analytic", by_analytic(&scene, &patches), 1e-4)] {
            let leak: f64 = (0..f.len())
                .filter(|i| within(*i))
                .map(|i| f.row(i).filter(|(j, _)| !within(*j)).map(|(_, x)| x).sum::<f64>())
                .fold(0.0, f64::max);
            assert!(leak <= most, "{name}: {leak} leaves the inside of the box");
            let off = |i: usize| (f.row_sum(i) + f.escaped[i] + f.absorbed[i] - 1.0).abs();
            let worst = (0..f.len()).filter(|i| inside_room(*i)).map(off).fold(0.0, f64::max);
            assert!(worst < 1e-3, "{name}: a row is {worst} off");
        }
    }
}

#[test]
fn bad_meshes_are_told() {
    let ply = |vertices: &[[f32; 3]], faces: &[[u32; 3]]| {
        let path = std::env::temp_dir().join(format!("etendue-radiosity-{}-{}.ply", std::process::id(), faces.len()));
        let mut text = format!(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
            vertices.len(),
            faces.len()
        );
        vertices.iter().for_each(|[x, y, z]| text += &format!("{x} {y} {z}\n"));
        faces.iter().for_each(|[a, b, c]| text += &format!("3 {a} {b} {c}\n"));
        std::fs::write(&path, text).expect("a file");
        let shape = format!(
            r#"<shape type="ply"><string name="filename" value="{}"/><boolean name="face_normals" value="true"/></shape>"#,
            path.display()
        );
        let scene = scene(&shape);
        std::fs::remove_file(path).expect("the file");
        cut(&scene, PatchSize::Whole).faults
    };
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let whole = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    assert!(ply(&corners, &whole).is_empty());
    let facet = |f: &etendue_radiosity::patch::Facet| f.facet;
    let faults = ply(&corners, &whole[..3]);
    assert!(matches!(&faults[..], [Fault::Open { first, count: 3 }] if facet(first) < 3), "{faults:?}");
    let turned = [whole[0], whole[1], [1, 3, 2], whole[3]];
    let faults = ply(&corners, &turned);
    assert!(
        matches!(&faults[..], [Fault::AgainstEachOther { first, count: 3 }] if first.iter().any(|f| f.facet == 2)),
        "{faults:?}"
    );
    // So far away that single precision cannot tell the corners apart along x.
    let far = cut(&scene(&shape("cube", r#"<translate x="1e9"/>"#, "")), PatchSize::Whole).faults;
    assert!(matches!(&far[0], Fault::NoArea { first, count: 8 } if facet(first) == 0), "{far:?}");
    let twice = [whole[0], whole[1], whole[2], whole[3], whole[0], whole[0]];
    let faults = ply(&corners, &twice);
    assert!(
        faults.iter().filter(|f| matches!(f, Fault::Doubled { area, .. } if (area - 0.5).abs() < 1e-6)).count() == 3,
        "{faults:?}"
    );
}
