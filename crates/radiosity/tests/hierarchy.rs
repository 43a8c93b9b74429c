//! Links between clusters: closed forms, the stated bound against a dense factorisation, the books, the same bits whatever the threads.

mod common;

use common::*;
use etendue_radiosity::patch::PatchSize;
use etendue_radiosity::solve::Exchange;
use etendue_radiosity::solved::{Factors, Method, Settings, Solved, Stage};
use etendue_radiosity::{Bounces, Hierarchy};
use etendue_scene::Scene;
use glam::DVec3;
use std::f64::consts::PI;

fn settings(patches: usize) -> Settings {
    Settings { size: PatchSize::Count(patches), adaptive: false, factors: Factors::Hierarchical, ..Settings::default() }
}

fn solved(scene: &Scene, settings: Settings) -> Solved {
    Solved::new(scene, &settings, &|_| true).expect("a solution")
}

fn links(solved: &Solved) -> &Hierarchy {
    solved.exchange.links().expect("links")
}

/// ‖a - b‖ / ‖b - Be‖.
fn far(a: &Solved, b: &Solved) -> f64 {
    let equation = b.equation();
    let less = |x: &[DVec3], y: &[DVec3]| x.iter().zip(y).map(|(x, y)| *x - *y).collect::<Vec<_>>();
    equation.norm(&less(&a.solution.b, &b.solution.b)) / equation.norm(&less(&b.solution.b, &equation.be))
}

fn grey(rho: f64) -> String {
    format!(r#"<bsdf type="diffuse"><rgb name="reflectance" value="{rho}"/></bsdf>"#)
}

fn glow(le: f64) -> String {
    format!(r#"<emitter type="area"><rgb name="radiance" value="{le}"/></emitter>"#)
}

/// A closed grey room with a lamp, and twelve boxes and balls in it.
fn room() -> Scene {
    let mut text = shape("cube", "", &(FLIPPED.to_owned() + &grey(0.7)));
    text += &shape("cube", r#"<scale x="0.3" y="0.3" z="0.02"/><translate z="0.9"/>"#, &glow(4.0));
    for k in 0..12 {
        let (x, y, z) = (k % 3 - 1, k / 3 % 2, k / 6);
        let place = format!(
            r#"<scale value="{}"/><rotate z="1" angle="{}"/><translate x="{}" y="{}" z="{}"/>"#,
            0.11 + 0.01 * f64::from(k),
            25 * k,
            0.6 * f64::from(x),
            f64::from(y) - 0.5,
            0.75 * f64::from(z) - 0.6
        );
        text += &shape(if k % 2 == 0 { "cube" } else { "sphere" }, &place, &grey(0.3 + 0.05 * f64::from(k)));
    }
    scene(&text)
}

#[test]
fn the_bound_holds_against_a_dense_factorisation() {
    let scene = room();
    let judge = solved(&scene, Settings { factors: Factors::Hemisphere, rays: 2048, method: Method::Direct, ..settings(3000) });
    assert!(judge.patches.len() > 2800 && judge.solution.residual() < 1e-12);
    for error in [0.5, 0.08] {
        let found = solved(&scene, Settings { error, residual: 1e-6, ..settings(3000) });
        let (bound, off) = (links(&found).bound, far(&found, &judge));
        assert!(links(&found).reached && bound <= error, "{bound} for {error}");
        // The judge has noise of its own, which is in `off`; and a bound that is far from what there is would tell nothing.
        assert!(off <= bound && off > 0.1 * bound, "{off} under a bound of {bound}");
        assert!(found.solution.residual() <= 1e-6);
        let e = found.equation().energy(&found.solution.b);
        assert!(e.residual.abs().element_sum() < 1e-5 * e.emitted.element_sum(), "{e:?}");
        assert!(e.escaped == DVec3::ZERO && found.repair.closed && found.repair.closure_after <= 1e-7);
    }
}

#[test]
fn the_furnace_bounce_by_bounce() {
    let (le, a) = (1.5, 0.6);
    let scene = scene(&shape("cube", "", &(FLIPPED.to_owned() + &grey(a) + &glow(le))));
    let solved = solved(&scene, settings(600));
    let equation = solved.equation();
    let mut sum = vec![DVec3::ZERO; equation.len()];
    for (k, b) in Bounces::new(&equation).take(30).enumerate() {
        sum.iter_mut().zip(&b).for_each(|(s, b)| *s += *b);
        let exact = PI * le * (1.0 - a.powf(k as f64 + 1.0)) / (1.0 - a);
        let off = sum.iter().map(|s| (s.x - exact).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6 * exact, "B_{k} is {off} off {exact}");
    }
}

#[test]
fn parallel_unit_squares() {
    let below = shape("rectangle", r#"<scale value="0.5"/>"#, &grey(0.5));
    let above = |inside: &str| shape("rectangle", r#"<scale value="0.5"/><rotate x="1" angle="180"/><translate z="1"/>"#, inside);
    let exact = 2.0 / PI * ((2.0 / 3f64.sqrt()).ln() + 2.0 * 2f64.sqrt() * 0.5f64.sqrt().atan() - PI / 2.0);
    // By rays that are sorted, and by rays to a lamp.
    for (inside, near) in [(grey(0.5), 0.02), (glow(1.0), 0.005)] {
        let scene = scene(&(below.clone() + &above(&inside)));
        let solved = solved(&scene, settings(800));
        let areas: Vec<f64> = solved.patches.patches.iter().map(|p| p.area).collect();
        let half = areas.len() / 2;
        let one: Vec<DVec3> = (0..areas.len()).map(|i| if i >= half { DVec3::ONE } else { DVec3::ZERO }).collect();
        let h = solved.exchange.multiply(&one);
        let f: f64 = h[..half].iter().zip(&areas).map(|(h, a)| h.x * a).sum();
        assert!((f / exact - 1.0).abs() < near, "{f} for {exact}");
        let escaped: f64 = (0..half).map(|i| solved.exchange.lost(i)[0] * areas[i]).sum();
        assert!((escaped + f - 1.0).abs() < 1e-6, "{escaped} and {f}");
        assert!(h[half..].iter().all(|h| *h == DVec3::ZERO), "a square does not see itself");
    }
}

#[test]
fn it_agrees_with_a_matrix_where_light_escapes_and_boxes_stand_on_floors() {
    let lamp = r#"<emitter type="area"><rgb name="radiance" value="5, 4, 3"/></emitter>"#;
    let red = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.8, 0.2, 0.1"/></bsdf>"#;
    let wall = |transform: &str| shape("rectangle", transform, red);
    let scene = scene(
        &[
            wall(r#"<translate z="-1"/>"#),
            wall(r#"<rotate x="1" angle="90"/><translate y="1"/>"#),
            wall(r#"<rotate y="1" angle="90"/><translate x="-1"/>"#),
            shape("cube", r#"<scale value="0.3"/><translate x="0.2" z="-0.7"/>"#, ""),
            shape("rectangle", r#"<scale value="0.3"/><rotate y="1" angle="180"/><translate x="0.3" z="0.8"/>"#, lamp),
            r#"<emitter type="point"><point name="position" x="-0.3" y="0.1" z="0.2"/><rgb name="intensity" value="1, 1, 2"/></emitter>"#
                .to_owned(),
        ]
        .concat(),
    );
    let judge = solved(&scene, Settings { factors: Factors::Hemisphere, rays: 4096, ..settings(1200) });
    let found = solved(&scene, settings(1200));
    let off = far(&found, &judge);
    assert!(off <= links(&found).bound, "{off} under a bound of {}", links(&found).bound);
    let [e, j] = [&found, &judge].map(|s| s.equation().energy(&s.solution.b));
    for (x, y) in [(e.absorbed, j.absorbed), (e.escaped, j.escaped)] {
        assert!((x / y - 1.0).abs().max_element() < 0.02, "{x} and {y}");
    }
    assert!(e.residual.abs().element_sum() < 1e-3 * e.emitted.element_sum(), "{e:?}");
}

#[test]
fn same_bits_and_a_stop_keeps_the_last_sweep() {
    let scene = room();
    let with = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads");
        pool.install(|| solved(&scene, Settings { error: 0.5, ..settings(900) }).solution)
    };
    let whole = with(1);
    assert_eq!(whole, with(3));
    let few = Settings { error: 0.1, ..settings(900) };
    let stopped = Solved::new(&scene, &few, &|stage| !matches!(stage, Stage::Links(..) | Stage::Sweep(..)));
    let stopped = stopped.expect("what there was");
    assert!(!links(&stopped).reached && stopped.solution.sweeps() == 0 && stopped.solution.residual() < 0.02);
    assert!(Solved::new(&scene, &few, &|stage| !matches!(stage, Stage::Rows(..))).is_err(), "nothing to keep");
}

#[test]
fn what_does_not_fit_is_told_with_what_does() {
    let told = |settings: Settings| Solved::new(&room(), &settings, &|_| true).expect_err("refused").to_string();
    let no_rows = told(Settings { method: Method::Shooting, ..settings(900) });
    assert!(no_rows.contains("`shooting`") && no_rows.contains("`neumann` fits"), "{no_rows}");
    let memory = told(Settings { factors: Factors::Hemisphere, memory: 1 << 26, ..settings(50_000) });
    assert!(memory.contains("`hierarchical` fits, or `hemisphere` of 32 rays a patch fits, or 1562 patches fit"), "{memory}");
    let least = told(Settings { memory: 1 << 20, ..settings(50_000) });
    assert!(
        least.contains("cannot be had; ") && least.contains(" patches fit") && !least.contains("`hierarchical` fits"),
        "{least}"
    );
    let pairs = told(Settings { factors: Factors::Analytic, memory: 1 << 30, ..settings(50_000) });
    assert!(pairs.contains("`hierarchical` fits, or `hemisphere` of 512 rays a patch fits, or "), "{pairs}");
    assert!(told(Settings { factors: Factors::Hemisphere, method: Method::Direct, ..settings(9000) }).contains("`hierarchical`"));
}
