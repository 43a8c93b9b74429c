//! Patches cut finer where the light changes: where they are, how many, and what that is worth.

mod common;

use common::*;
use etendue_radiosity::Patches;
use etendue_radiosity::form_factor::polygon::from_point;
use etendue_radiosity::patch::PatchSize;
use etendue_radiosity::refine::finer;
use etendue_radiosity::solved::{Factors, Settings, Solved};
use etendue_scene::Scene;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

const GREY: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf>"#;

/// Half the floor is lit: what is cut are the patches along the border, into four, as many as there is room for; the area stays.
#[test]
fn the_border_of_a_shadow_is_cut() {
    let floor = scene(&shape("rectangle", "", GREY));
    let patches = cut(&floor, PatchSize::Metres(0.125));
    let (n, area) = (patches.len(), |p: &Patches| p.patches.iter().map(|p| p.area).sum::<f64>());
    assert_eq!(n, 256);
    let h: Vec<DVec3> = patches.patches.iter().map(|p| if p.p.x < 0.0 { DVec3::ONE } else { DVec3::ZERO }).collect();
    let cut = finer(&floor, &patches, &h, 10_000);
    // Two columns of 16, on either side of x = 0: the corners of the next are the same all over.
    assert_eq!(cut.len(), n + 3 * 32);
    assert!((area(&cut) - area(&patches)).abs() < 1e-12);
    for p in &cut.patches {
        let wanted = if p.p.x.abs() < 0.125 { 0.125f64.powi(2) / 4.0 } else { 0.125f64.powi(2) };
        assert!((p.area - wanted).abs() < 1e-12, "{p:?}");
    }
    assert_eq!(finer(&floor, &patches, &h, n + 32).len(), n + 30, "as many as there is room for");
    assert_eq!(finer(&floor, &patches, &vec![DVec3::ONE; n], 10_000).len(), n, "nothing where nothing changes");
}

/// A floor, and a black lamp that hangs low over a corner of it. No light comes twice, so B of the floor is known at every point: π Le ρ F.
fn lamp_over_a_corner() -> Scene {
    let lamp = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf><emitter type="area"><rgb name="radiance" value="1"/></emitter>"#;
    let hangs = r#"<scale value="0.1"/><rotate y="1" angle="180"/><translate x="-0.6" y="-0.6" z="0.15"/>"#;
    scene(&(shape("rectangle", "", GREY) + &shape("rectangle", hangs, lamp)))
}

/// ∫ |B - B(x)| / ∫ B(x) over the floor, of light that patches hold as constants, and the mean size of patches under the lamp and in the far corner, m.
fn off(solved: &Solved) -> (f64, [f64; 2]) {
    let (x0, x1, y0, y1) = (-0.7, -0.5, -0.7, -0.5);
    // Counter-clockwise from below.
    let lamp = [(x0, y0), (x0, y1), (x1, y1), (x1, y0)].map(|(x, y)| DVec3::new(x, y, 0.15));
    let (mut sum, mut all) = (0.0, 0.0);
    let mut sizes = [(0.0, 0); 2];
    let floor = solved.patches.objects[0].patches.clone();
    for i in floor {
        let patch = solved.patches.get(i);
        let (span, chart) = solved.patches.geometry(i);
        const SIDE: u32 = 8;
        for k in 0..SIDE * SIDE {
            let local = (DVec2::new((k % SIDE).into(), (k / SIDE).into()) + 0.5) / f64::from(SIDE);
            let exact = PI * 0.5 * from_point(chart.point(span.global(local)), DVec3::Z, &lamp);
            let weight = patch.area / f64::from(SIDE * SIDE);
            sum += (solved.solution.b[i as usize].x - exact).abs() * weight;
            all += exact * weight;
        }
        let place = [DVec2::splat(-0.6), DVec2::splat(0.6)].map(|p| patch.p.truncate().distance(p) < 0.3);
        for (of, (sum, count)) in place.into_iter().zip(&mut sizes) {
            (*sum, *count) = if of { (*sum + patch.area.sqrt(), *count + 1) } else { (*sum, *count) };
        }
    }
    (sum / all, sizes.map(|(sum, count)| sum / f64::from(count)))
}

/// At equal numbers of patches less than half of the error, by patches that are at most a third as wide under the lamp as far from it; factors without rays.
#[test]
fn equal_numbers_of_patches_go_further() {
    let scene = lamp_over_a_corner();
    let with = |adaptive: bool| {
        let settings = Settings { size: PatchSize::Count(1200), adaptive, factors: Factors::Analytic, ..Settings::default() };
        let solved = Solved::new(&scene, &settings, &|_| true).expect("a solution");
        assert!((1000..=1200).contains(&solved.patches.len()), "{}", solved.patches.len());
        off(&solved)
    };
    let ((even, sizes), (adaptive, finer)) = (with(false), with(true));
    assert!((sizes[0] / sizes[1] - 1.0).abs() < 0.1, "{sizes:?}");
    assert!(finer[0] < 0.4 * finer[1], "{finer:?}");
    assert!(adaptive < 0.5 * even, "{adaptive} and {even}");
}
