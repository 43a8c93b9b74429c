//! The books, the oracle, threads, stopping and resuming.

use super::*;
use common::interrupted::leaves_no_trace;
use etendue_solvers::Stop;
use etendue_solvers::oracle_light::LightOracle;

/// In a closed box what is emitted is absorbed; roulette and its survivors cancel.
#[test]
fn the_books_are_balanced() {
    let close = |a: [f64; 3], b: f64, within: f64, what: &str| {
        assert!(a.iter().all(|a| (a - b).abs() <= within), "{what}: {a:?}, expected {b}");
    };
    for a in [0.2f32, 0.9] {
        let scene = furnace_seen_by(&camera("0, 0, -0.5", "0.1, 0.2, 1", "0, 1, 0", 70.0, [16, 16]), "sphere", a);
        let flux = 4.0 * std::f64::consts::PI.powi(2);
        // Every bounce absorbs 1 - a of what arrives; after three edges a walk of four is cut.
        for (max_edges, absorbed, cut) in [(u32::MAX, 1.0, 0.0), (4, 1.0 - f64::from(a).powi(3), f64::from(a).powi(3))] {
            let (_, outcome) = render(&scene, &LightNee, samples(128).edges(max_edges));
            let books = outcome.books.expect("books");
            close(books.emitted, flux, 1e-4 * flux, "emitted");
            close(books.absorbed, absorbed * flux, 2e-2 * flux, "absorbed");
            close(books.cut, cut * flux, 2e-2 * flux, "cut");
            close(books.escaped, 0.0, 1e-9, "escaped");
            close(books.residual, 0.0, 1e-4, "residual");
        }
    }
    let open = scene(&format!(
        r#"{}<shape type="rectangle">{}</shape><emitter type="point"><point name="position" value="0, 0, 3"/></emitter>"#,
        eye(),
        diffuse(0.5)
    ));
    let books = render(&open, &LightNee, samples(256)).1.books.expect("books");
    close(books.emitted, 4.0 * std::f64::consts::PI, 1e-6, "emitted");
    // A square of side 2 seen from 3 away: Ω = 4 asin(1/10) [a rectangle's solid angle, from above its centre].
    close(books.absorbed, 0.5 * 4.0 * (0.1f64).asin(), 2e-2, "absorbed");
    close(books.escaped, 4.0 * std::f64::consts::PI - 0.5 * 4.0 * (0.1f64).asin(), 2e-2, "escaped");
}

/// The textbook's particles arrive at the same picture, bounce by bounce.
#[test]
fn the_oracle_agrees() {
    let mut family = Family::default();
    for bounces in [0..=0, 1..=1, 2..=3] {
        let job = |spp: u32| samples(spp).with(PathRules::default().with_bounces(bounces.clone()));
        let scene = room(&eye(), "");
        let reference = replicates(&scene, &LightNee, job(256).seed(4));
        let oracle = replicates(&scene, &LightOracle { absorption: 0.2 }, job(512).seed(5));
        agreement(&mut family, &format!("oracle, {bounces:?}"), &scene, &oracle, &reference, 0.6);
    }
    family.must_hold();
}

/// Films of several chunks and bands, a wide filter, a crop: the same bits on any number of threads.
#[test]
fn threads_do_not_matter() {
    let film = r#"<integer name="crop_offset_x" value="3"/><integer name="crop_offset_y" value="5"/>
        <integer name="crop_width" value="61"/><integer name="crop_height" value="50"/><rfilter type="gaussian"/>"#;
    let scene = room(&lens("0, 0, -0.9", "0, 0, 1", 80.0, 0.4, 1.0, [80, 60], film), "");
    for stop in [Stop::Samples(3), Stop::Noise { percent: 1e-9, limit: 16 }] {
        let at = |threads: usize| {
            let job = Job { stop, threads, ..samples(0) };
            let ((nee, a), (light, b)) = (render(&scene, &LightNee, job), render(&scene, &Light, job));
            (bits(&nee.develop()), bits(&light.develop()), a.books, b.books, a.noise.map(|n| n.rel_mse.to_bits()))
        };
        let once = at(1);
        for threads in [2, 5] {
            assert!(at(threads) == once, "{threads} threads, {stop:?}");
        }
    }
}

/// Stopped within a pass, twice.
#[test]
fn stopped_and_resumed_is_undisturbed() {
    let scene = room(&camera("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [72, 60]), "");
    leaves_no_trace(&scene, &LightNee, Stop::Samples(4), &[(0, 2), (2, 1)]);
}
