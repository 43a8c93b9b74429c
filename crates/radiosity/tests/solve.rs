//! All ways to solve end at the same radiosities, and these at the closed form.

mod common;

use common::*;
use etendue_radiosity::form_factor::{FormFactors, Hemisphere, Matrix, Open, Rows, hemisphere};
use etendue_radiosity::patch::PatchSize;
use etendue_radiosity::solve::{Equation, Until, direct, neumann};
use etendue_radiosity::solved::{Carrier, Factors, Method, Settings, Solved};
use etendue_radiosity::{Bounces, Field};
use glam::DVec3;
use std::f64::consts::PI;

/// F between the six sides of a cube: 0.19982490 to the one across, the rest in four equal parts.
fn cube() -> FormFactors {
    let across = 2.0 / PI * ((2.0 / 3f64.sqrt()).ln() + 2.0 * 2f64.sqrt() * (0.5f64.sqrt()).atan() - 2.0 * 1f64.atan());
    let beside = 0.25 * (1.0 - across);
    let (mut columns, mut values) = (Vec::new(), Vec::new());
    for i in 0..6u32 {
        for j in (0..6).filter(|j| *j != i) {
            columns.push(j);
            values.push(if j / 2 == i / 2 { across as f32 } else { beside as f32 });
        }
    }
    let begins = (0..=6).map(|i| 5 * i).collect();
    let mut factors = FormFactors::new(Matrix { rows: Rows::new((6, 6), begins, columns, values), errors: Vec::new() });
    factors.repair(&[1.0; 6], Open::WithLosses);
    factors
}

/// Two patches that found nothing but a third, smaller than both: one of them cannot give all that it has. Scaling went on until it was no number.
#[test]
fn rows_that_cannot_be_closed_are_told_and_lose_what_they_lack() {
    let (columns, values) = (vec![2, 2, 0, 1], vec![1.0, 1.0, 0.5, 0.5]);
    let areas = [1.0, 1.0, 0.1];
    for lost in [0.0, 0.01] {
        let rows = Rows::new((3, 3), vec![0, 1, 2, 4], columns.clone(), values.clone());
        let mut f = FormFactors::new(Matrix { rows, errors: Vec::new() });
        f.escaped = vec![lost; 3];
        let told = f.repair(&areas, Open::WithLosses);
        // A loss takes what is left, however small it was.
        assert!((told.closure_after > 0.5) == (lost == 0.0) && told.sweeps < 1000, "{told:?}");
        for (i, area) in areas.iter().enumerate() {
            let all = f.row_sum(i) + f.escaped[i] + f.absorbed[i];
            assert!((all - 1.0).abs() < 1e-12 && f.row_sum(i) <= 1.0 + 1e-12, "row {i}: {all}");
            for (j, other) in areas.iter().enumerate() {
                assert!((area * f.get(i, j) - other * f.get(j, i)).abs() < 1e-15);
            }
        }
    }
}

fn until(residual: f64) -> Until<'static> {
    Until { residual, sweeps: 10_000, watch: &|_, _| true }
}

fn far(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f64::max)
}

#[test]
fn the_furnace_bounce_by_bounce() {
    let factors = cube();
    let (le, a) = (1.5, DVec3::new(0.25, 0.5, 0.9));
    let be = DVec3::splat(PI * le);
    let equation =
        Equation { exchange: &factors, areas: vec![1.0; 6], rho: vec![a; 6], be: vec![be; 6], direct: vec![DVec3::ZERO; 6] };
    let mut sum = vec![DVec3::ZERO; 6];
    for (k, b) in Bounces::new(&equation).take(40).enumerate() {
        sum.iter_mut().zip(&b).for_each(|(s, b)| *s += *b);
        let exact = be * (DVec3::ONE - a.powf(k as f64 + 1.0)) / (DVec3::ONE - a);
        assert!(far(&sum, &[exact; 6]) < 1e-6 * exact.max_element(), "B_{k} = {} of {exact}", sum[0]);
    }
    // And in the limit, by all methods, with the books closed.
    let exact = vec![be / (DVec3::ONE - a); 6];
    for (i, name) in Method::NAMES.iter().enumerate() {
        let solution = Method::nth(i).solve(&equation, &until(1e-9)).expect("few patches");
        assert!(far(&solution.b, &exact) < 1e-6 * exact[0].max_element(), "{name}: {} of {}", solution.b[0], exact[0]);
        assert!(solution.residual() <= 1e-9 && solution.residuals.windows(2).all(|r| r[1] < r[0]), "{name}");
        let energy = equation.energy(&solution.b);
        assert!(energy.residual.abs().max_element() < 1e-6 * energy.emitted.max_element(), "{name}: {energy:?}");
        assert!(energy.escaped == DVec3::ZERO && (energy.emitted - be * 6.0).length() < 1e-9);
    }
}

/// A room without a lid, with a lamp, a box in it and a point light.
fn room() -> etendue_scene::Scene {
    let lamp = r#"<emitter type="area"><rgb name="radiance" value="5, 4, 3"/></emitter>"#;
    let red = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.8, 0.2, 0.1"/></bsdf>"#;
    let wall = |transform: &str| shape("rectangle", transform, red);
    scene(&[
        wall(r#"<translate z="-1"/>"#),
        wall(r#"<rotate x="1" angle="90"/><translate y="1"/>"#),
        wall(r#"<rotate x="1" angle="-90"/><translate y="-1"/>"#),
        wall(r#"<rotate y="1" angle="90"/><translate x="-1"/>"#),
        shape("cube", r#"<scale value="0.3"/><translate x="0.2" z="-0.7"/>"#, ""),
        shape("rectangle", r#"<scale value="0.3"/><rotate y="1" angle="180"/><translate x="0.3" z="0.8"/>"#, lamp),
        r#"<emitter type="point"><point name="position" x="-0.3" y="0.1" z="0.2"/><rgb name="intensity" value="1, 1, 2"/></emitter>"#
            .to_owned(),
    ].concat())
}

#[test]
fn all_methods_agree_and_the_books_close() {
    let scene = room();
    let settings = Settings { size: PatchSize::Count(700), rays: 256, method: Method::Direct, ..Settings::default() };
    let judge = Solved::new(&scene, &settings, &|_| true).expect("a solution");
    let Carrier::Matrix(factors) = &judge.exchange else { panic!("a matrix was asked for") };
    let factors: &FormFactors = factors;
    let equation = Equation::new(&judge.patches, factors, judge.direct.clone());
    assert!(judge.solution.residual() < 1e-12, "{}", judge.solution.residual());
    let scale = judge.solution.b.iter().map(|b| b.max_element()).fold(0.0, f64::max);
    for (i, name) in Method::NAMES.iter().enumerate() {
        let solution = Method::nth(i).solve(&equation, &until(1e-10)).expect("few enough");
        assert!(far(&solution.b, &judge.solution.b) < 1e-8 * scale, "{name}");
        assert!(equation.residual(&solution.b) <= 1e-10, "{name}");
        let e = equation.energy(&solution.b);
        let all = (e.emitted + e.arrived).element_sum();
        assert!(e.escaped.min_element() > 0.0 && e.arrived.min_element() > 0.0);
        assert!(e.residual.abs().element_sum() < 1e-9 * all, "{name}: {e:?}");
    }
    // Gathering from what is newest is faster than bounces, and who stops early has the ambient estimate.
    let sweeps = |m: Method| m.solve(&equation, &until(1e-6)).expect("few").sweeps();
    assert!(sweeps(Method::GaussSeidel) < sweeps(Method::Neumann));
    let early = Until { residual: 1e-12, sweeps: 1, watch: &|_, _| true };
    let off = |m: Method| far(&m.solve(&equation, &early).expect("few").b, &judge.solution.b);
    assert!(off(Method::Shooting) < off(Method::Neumann));
    // The same bits at any number of threads.
    let with = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads");
        pool.install(|| Solved::new(&scene, &Settings { method: Method::Neumann, ..settings }, &|_| true).expect("solved").solution)
    };
    assert_eq!(with(1), with(3));
}

/// Why `radiosity` counts what rays found lost as an exchange of its own: a room with a slit under its lid, bright walls, and few rays. Scaled by
/// reciprocity alone, rows that noise makes too large are cut and those that it makes too small are left, so light is lost at every bounce. Both are reciprocal to the last bit.
#[test]
fn open_rooms_keep_their_light() {
    let bright = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.9"/></bsdf><emitter type="area"><rgb name="radiance" value="1"/></emitter>"#;
    let turns = [
        "",
        r#"<rotate x="1" angle="90"/>"#,
        r#"<rotate x="1" angle="-90"/>"#,
        r#"<rotate y="1" angle="90"/>"#,
        r#"<rotate y="1" angle="-90"/>"#,
    ];
    let walls = turns.map(|turn| shape("rectangle", &format!(r#"<translate z="-1"/>{turn}"#), bright)).concat();
    let lid = shape("rectangle", r#"<scale x="1" y="0.97"/><rotate x="1" angle="180"/><translate z="1"/>"#, bright);
    let scene = scene(&(walls + &lid));
    let patches = cut(&scene, PatchSize::Metres(0.25));
    let escaped = |rays: u32, open: Open| {
        let mut f =
            hemisphere(&scene, &patches, &Hemisphere { rays, errors: false, seed: 5, ..Hemisphere::default() }, &|_, _| true)
                .expect("not cancelled");
        let areas: Vec<f64> = patches.patches.iter().map(|p| p.area).collect();
        let told = f.repair(&areas, open);
        assert!(!told.closed && told.closure_after < 1e-12, "{told:?}");
        for i in 0..f.len() {
            for (j, x) in f.row(i) {
                assert!((areas[i] * x - areas[j] * f.get(j, i)).abs() <= 1e-12 * areas[i] * x, "reciprocity");
            }
        }
        let equation = Equation::new(&patches, &f, vec![DVec3::ZERO; f.len()]);
        let energy = equation.energy(&neumann::solve(&equation, &until(1e-9)).b);
        assert!(energy.residual.abs().max_element() < 1e-6 * energy.emitted.x, "{energy:?}");
        energy.escaped.x / energy.emitted.x
    };
    // 1 % of F is lost; nine tenths are reflected, so nearly a tenth of all light gets out.
    let truth = escaped(1 << 15, Open::WithLosses);
    let [with_losses, reciprocal] = [Open::WithLosses, Open::Reciprocal].map(|open| escaped(256, open) / truth - 1.0);
    assert!(
        with_losses.abs() < 0.03 && reciprocal > 5.0 * with_losses.abs().max(0.02),
        "{truth}: {with_losses} and {reciprocal} off"
    );
}

/// What rows of an open scene are brought to is asked for; closed ones are the same either way, and links know losses alone.
#[test]
fn open_scenes_are_closed_as_asked() {
    let with = |scene: &etendue_scene::Scene, open: Open, factors: Factors| {
        let settings = Settings {
            size: PatchSize::Count(300),
            adaptive: false,
            rays: 64,
            factors,
            open,
            residual: 1e-9,
            ..Settings::default()
        };
        Solved::new(scene, &settings, &|_| true)
    };
    let escaped = |open: Open| {
        let solved = with(&room(), open, Factors::Hemisphere).expect("a solution");
        let energy = solved.equation().energy(&solved.solution.b);
        assert!(!solved.repair.closed && solved.repair.open == open, "{:?}", solved.repair);
        assert!(energy.residual.abs().element_sum() < 1e-6 * energy.emitted.element_sum(), "{energy:?}");
        energy.escaped.element_sum() / (energy.emitted + energy.arrived).element_sum()
    };
    let [losses, reciprocal] = [Open::WithLosses, Open::Reciprocal].map(escaped);
    assert!((reciprocal / losses - 1.0).abs() > 1e-3, "{losses} and {reciprocal}");
    let closed = scene(&shape("cube", "", &(FLIPPED.to_owned() + r#"<emitter type="area"/>"#)));
    let [a, b] = [Open::WithLosses, Open::Reciprocal].map(|open| with(&closed, open, Factors::Hemisphere).expect("a solution"));
    assert!(a.repair.closed && a.solution == b.solution);
    // Without rays there are no losses to count.
    let by_pairs = with(&room(), Open::WithLosses, Factors::Analytic).expect("a solution");
    assert_eq!(by_pairs.repair.open, Open::Reciprocal);
    let told = with(&room(), Open::Reciprocal, Factors::Hierarchical).expect_err("refused").to_string();
    assert!(told.contains("`hemisphere`"), "{told}");
}

/// Three ways to find factors, one solution: 250 patches, a box among them, and noise of the rays; the books close whichever it is.
#[test]
fn factors_of_all_methods_give_the_same_light() {
    let scene = room();
    let with = |factors: Factors| {
        let settings = Settings {
            size: PatchSize::Count(400),
            adaptive: false,
            factors,
            rays: 1 << 12,
            residual: 1e-9,
            ..Settings::default()
        };
        let solved = Solved::new(&scene, &settings, &|_| true).expect("a solution");
        let energy = solved.equation().energy(&solved.solution.b);
        assert!(energy.residual.abs().element_sum() < 1e-6 * energy.emitted.element_sum(), "{factors:?}: {energy:?}");
        energy
    };
    let judge = with(Factors::Hemisphere);
    for factors in [Factors::Analytic, Factors::Area] {
        let energy = with(factors);
        for (x, y) in [(energy.absorbed, judge.absorbed), (energy.escaped, judge.escaped)] {
            assert!((x / y - 1.0).abs().max_element() < 0.02, "{factors:?}: {x} and {y}");
        }
    }
    let many = Settings { size: PatchSize::Count(40_000), factors: Factors::Analytic, ..Settings::default() };
    let told = Solved::new(&scene, &many, &|_| true).expect_err("too many").to_string();
    assert!(told.contains("800 million") && told.contains("`hemisphere` and `hierarchical` fit"), "{told}");
}

#[test]
fn too_large_is_told_with_the_figure_and_what_fits() {
    let equation_size = direct::TooLarge { patches: 100_000 }.to_string();
    assert!(equation_size.contains("149.0 GiB") && equation_size.contains("gauss-seidel"), "{equation_size}");
    let settings = Settings { size: PatchSize::Count(20_000), method: Method::Direct, ..Settings::default() };
    assert!(Solved::new(&room(), &settings, &|_| true).is_err());
    let memory = Settings { size: PatchSize::Count(20_000), memory: 1 << 20, ..Settings::default() };
    let told = Solved::new(&room(), &memory, &|_| true).expect_err("no memory").to_string();
    assert!(told.contains("patches fit"), "{told}");
}

#[test]
fn fields_keep_means_and_linear_functions() {
    let floor = scene(&shape("rectangle", "", ""));
    let patches = cut(&floor, PatchSize::Metres(0.25));
    let vertices = patches.vertices(&floor);
    // x + 2 at the middles of the patches: vertices at the rim would lack half a patch's slope.
    let values: Vec<DVec3> = patches.patches.iter().map(|p| DVec3::splat(p.p.x + 2.0)).collect();
    let field = Field::new(&patches, &vertices, &values);
    for (v, p) in field.at_vertices().iter().zip(&vertices.points) {
        assert!((v.x - (p.x + 2.0)).abs() < 0.08, "{v} at {p}");
    }
    let even = Field::new(&patches, &vertices, &vec![DVec3::ONE; patches.len()]);
    assert!(even.at_vertices().iter().all(|v| (*v - DVec3::ONE).length() < 1e-12));
}
