//! Form factors by casting rays: closed forms within three standard errors, and what a repair restores.

mod common;

use common::*;
use etendue_radiosity::PatchSize;
use etendue_radiosity::form_factor::{FormFactors, Hemisphere, Open, Share, hemisphere};
use etendue_radiosity::{Patches, Side, Sides};
use etendue_scene::Scene;
use std::f64::consts::PI;

fn cast(scene: &Scene, patches: &Patches, rays: u32) -> FormFactors {
    hemisphere(scene, patches, &Hemisphere { rays, ..Hemisphere::default() }, &|_, _| true).expect("not cancelled")
}

/// The unit square [0, 1]² at z = 0, moved by a transform.
fn square(transform: &str) -> String {
    shape("rectangle", &format!(r#"<scale value="0.5"/><translate x="0.5" y="0.5"/>{transform}"#), "")
}

/// F between two coaxial discs of radii r1 and r2 at distance h.
fn coaxial(r1: f64, r2: f64, h: f64) -> f64 {
    let (x, y) = (r1 / h, r2 / h);
    let s = 1.0 + (1.0 + y * y) / (x * x);
    0.5 * (s - (s * s - 4.0 * (r2 / r1).powi(2)).sqrt())
}

/// F between unit squares face to face at distance 1, and between two with an edge in common at right angles.
fn facing() -> f64 {
    2.0 / PI * ((2.0 / 3f64.sqrt()).ln() + 2.0 * 2f64.sqrt() * (1.0 / 2f64.sqrt()).atan() - 2.0 * 1f64.atan())
}
fn adjacent() -> f64 {
    1.0 / PI * (0.25 * (0.75f64).ln() * 1.0 + 2.0 * 1f64.atan() - 2f64.sqrt() * (1.0 / 2f64.sqrt()).atan() + 0.0)
}

/// Closed forms with a million rays: within three standard errors, which are small. Eleven claims; with t of 15 degrees of freedom each fails
/// by chance with probability 0.9 %, but the seeds are fixed.
#[test]
fn closed_forms_are_met_within_three_standard_errors() {
    let opposite = square(r#"<rotate y="1" angle="180"/><translate x="1" z="1"/>"#);
    // The plane x = 0, facing +x.
    let wall = square(r#"<rotate y="1" angle="90"/><translate z="1"/>"#);
    let disk = |r: f64, z: f64, up: bool| {
        let turn = if up { "" } else { r#"<rotate y="1" angle="180"/>"# };
        shape("disk", &format!(r#"<scale value="{r}"/>{turn}<translate z="{z}"/>"#), "")
    };
    let tube = |inside: bool| shape("cylinder", r#"<scale x="0.5" y="0.5" z="2"/>"#, if inside { FLIPPED } else { "" });
    let ends = coaxial(0.5, 0.5, 2.0);
    // A sphere of radius 1/2 on the axis of a rectangle's corner: 1/(4π) arcsin(…)-like form by the solid angle seen from its centre.
    let (a, b, d) = (1.0, 1.0, 2.0f64);
    let corner = (a * b / (d * (a * a + b * b + d * d).sqrt())).atan();
    let sphere = shape("sphere", &format!(r#"<scale value="0.5"/><translate z="{d}"/>"#), "");
    let cases: Vec<(&str, String, usize, usize, f64)> = vec![
        ("parallel squares", square("") + &opposite, 0, 1, facing()),
        ("perpendicular squares", square("") + &wall, 0, 1, adjacent()),
        ("coaxial discs", disk(1.0, 0.0, true) + &disk(0.5, 1.5, false), 0, 1, coaxial(1.0, 0.5, 1.5)),
        ("coaxial discs, back", disk(1.0, 0.0, true) + &disk(0.5, 1.5, false), 1, 0, 4.0 * coaxial(1.0, 0.5, 1.5)),
        ("sphere to rectangle", sphere + &square(""), 0, 1, corner / (4.0 * PI)),
        ("inside of a sphere", shape("sphere", "", FLIPPED), 0, 0, 1.0),
        ("inside of a tube", tube(true) + &disk(0.5, 0.0, true), 0, 0, 1.0 - 2.0 * (1.0 - ends) * 0.25 / 2.0),
        ("tube to its end", tube(true) + &disk(0.5, 0.0, true), 0, 1, (1.0 - ends) * 0.25 / 2.0),
        ("end to tube", tube(true) + &disk(0.5, 0.0, true), 1, 0, 1.0 - ends),
    ];
    for (name, text, i, j, exact) in cases {
        let scene = scene(&text);
        let patches = sided(&scene, PatchSize::Whole, Sides::Front);
        let f = cast(&scene, &patches, 1 << 20);
        let (found, error) = (f.get(i, j), f.error(i, j));
        assert!((found - exact).abs() <= 3.0 * error + 1e-7, "{name}: {found} ± {error}, exact {exact}");
        let bound = if exact >= 0.1 { 1e-3 * exact } else { 1e-4 };
        assert!(error <= bound, "{name}: an error of {error}");
    }
}

#[test]
fn a_closed_box_is_repaired_to_double_precision() {
    let scene = scene(&shape("cube", r#"<scale x="1" y="1.5" z="0.7"/>"#, FLIPPED));
    let patches = cut(&scene, PatchSize::Metres(0.35));
    let areas: Vec<f64> = patches.patches.iter().map(|p| p.area).collect();
    let mut f = cast(&scene, &patches, 1024);
    assert!((0..f.len()).all(|i| (f.row_sum(i) - 1.0).abs() < 1e-6), "rows close by construction");
    let before = f.clone();
    let told = f.repair(&areas, Open::WithLosses);
    assert!(told.closed && told.closure_after <= 1e-12 && told.reciprocity_before > 1e-3);
    assert!(told.moved_by_symmetry > 0.0 && told.moved_by_symmetry < 0.3 && told.moved_by_scaling < told.moved_by_symmetry);
    for i in 0..f.len() {
        assert!((f.row_sum(i) - 1.0).abs() <= 1e-12);
        for (j, x) in f.row(i) {
            assert!((0.0..=1.0).contains(&x));
            let back = areas[j] * f.get(j, i);
            assert!((areas[i] * x - back).abs() <= 1e-12 * back, "reciprocity");
        }
    }
    // The first step pools both estimates of a pair, so errors fall; the second moves little.
    let exact = |i: usize, j: usize| before.error(i, j);
    let pooled: f64 = (0..f.len()).flat_map(|i| f.row(i).map(move |(j, _)| (i, j))).map(|(i, j)| f.error(i, j).powi(2)).sum();
    let single: f64 = (0..f.len()).flat_map(|i| before.row(i).map(move |(j, _)| (i, j))).map(|(i, j)| exact(i, j).powi(2)).sum();
    assert!(pooled < 0.7 * single, "{pooled} of {single}");
}

/// Rays by area: a wall of a box in large and small patches. Every row closes as before, pairs are weighted by what their ends know, and the noise that is
/// expected is the noise that is found.
#[test]
fn rays_by_area_close_rows_and_know_their_noise() {
    let small = shape("cube", r#"<scale x="0.1" y="0.1" z="0.1"/><translate x="0.5" y="0.9" z="-0.3"/>"#, "");
    let scene = scene(&(shape("cube", r#"<scale x="1" y="1.5" z="0.7"/>"#, FLIPPED) + &small));
    let patches = cut(&scene, PatchSize::Metres(0.25)).subdivided(&scene, |i| i % 3 == 0);
    let areas: Vec<f64> = patches.patches.iter().map(|p| p.area).collect();
    let whole = areas.iter().copied().fold(0.0, f64::max);
    let method = Hemisphere { rays: 4096, share: Share::ByArea { whole }, errors: false, seed: 3 };
    let mut f = hemisphere(&scene, &patches, &method, &|_, _| true).expect("not cancelled");
    let cast: f64 = f.rays.iter().sum();
    assert!(cast < 0.6 * 4096.0 * areas.len() as f64 && f.rays.iter().all(|n| (256.0..=4096.0).contains(n)), "{cast}");
    let even = cast_evenly(&scene, &patches, 4096);
    let told = f.repair(&areas, Open::WithLosses);
    let ratio = told.moved_by_symmetry / told.moved_by_noise;
    assert!(told.closure_after < 1e-12 && (0.9..1.05).contains(&ratio), "{told:?}, {ratio}");
    // Sums over the large patches: light between them is as well known as by equal rays.
    let large: Vec<usize> = (0..areas.len()).filter(|i| areas[*i] > 0.5 * whole).collect();
    let between = |f: &FormFactors| large.iter().map(|i| large.iter().map(|j| areas[*i] * f.get(*i, *j)).sum::<f64>()).sum::<f64>();
    let (a, b) = (between(&f), between(&even));
    assert!((a / b - 1.0).abs() < 3e-3, "{a} and {b}");
}

/// Equal rays, repaired.
fn cast_evenly(scene: &Scene, patches: &Patches, rays: u32) -> FormFactors {
    let areas: Vec<f64> = patches.patches.iter().map(|p| p.area).collect();
    let mut f = cast(scene, patches, rays);
    f.repair(&areas, Open::WithLosses);
    f
}

/// Where pairs are met by single rays a normal law expects four fifths of what noise moves: 60 % were expected of 100,000 patches that moved 74 %.
#[test]
fn noise_is_expected_as_it_is_found_where_rays_are_few() {
    let scene = scene(&shape("cube", r#"<scale x="1" y="1.5" z="0.7"/>"#, FLIPPED));
    let patches = cut(&scene, PatchSize::Metres(0.2));
    let areas: Vec<f64> = patches.patches.iter().map(|p| p.area).collect();
    for rays in [16, 64, 256] {
        let mut f = hemisphere(&scene, &patches, &Hemisphere { rays, errors: false, ..Hemisphere::default() }, &|_, _| true)
            .expect("not cancelled");
        let told = f.repair(&areas, Open::WithLosses);
        let ratio = told.moved_by_symmetry / told.moved_by_noise;
        assert!((0.9..1.05).contains(&ratio), "{rays} rays: {ratio}");
    }
}

#[test]
fn what_an_open_scene_loses_is_reported() {
    // Two squares face to face: the rest escapes. The back of a card absorbs.
    let opposite = square(r#"<rotate y="1" angle="180"/><translate x="1" z="1"/>"#);
    let open = scene(&(square("") + &opposite));
    let patches = cut(&open, PatchSize::Metres(0.25));
    let areas: Vec<f64> = patches.patches.iter().map(|p| p.area).collect();
    let mut f = cast(&open, &patches, 4096);
    let told = f.repair(&areas, Open::WithLosses);
    assert!(!told.closed && told.closure_after <= 1e-12, "{told:?}");
    let escaped: f64 = f.escaped.iter().zip(&areas).map(|(e, a)| e * a).sum::<f64>() / 2.0;
    assert!((escaped - (1.0 - facing())).abs() < 1e-3, "{escaped}");
    assert!(f.absorbed.iter().all(|a| *a == 0.0));

    let card = scene(&(square("") + &square(r#"<translate z="1"/>"#)));
    let patches = cut(&card, PatchSize::Whole);
    assert!(patches.patches.iter().all(|p| p.side == Side::Front));
    let f = cast(&card, &patches, 1 << 16);
    assert!((f.absorbed[0] - facing()).abs() < 2e-3 && f.get(0, 1) == 0.0 && f.get(1, 0) == 0.0);
    assert!((f.escaped[1] - 1.0).abs() < 1e-6);
}

#[test]
fn the_same_bits_at_any_number_of_threads() {
    let scene = scene(&shape("cube", "", FLIPPED));
    let patches = cut(&scene, PatchSize::Metres(0.3));
    let areas: Vec<f64> = patches.patches.iter().map(|p| p.area).collect();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let mut f = cast(&scene, &patches, 256);
            let told = f.repair(&areas, Open::WithLosses);
            (f.matrix.rows, f.matrix.errors, f.right, f.to_objects.expect("counted").rows, told)
        })
    };
    let one = with(1);
    assert!(one == with(3));
}
