//! The books, the oracle, threads, stopping and resuming.

use super::*;
use etendue_numerics::{Sampler, SequenceKind};
use etendue_solvers::drivers::ParticleSolver;
use etendue_solvers::oracle_light::LightOracle;
use etendue_solvers::transport::{LightContext, Tally};
use etendue_solvers::{CancelToken, Checkpoint, Event, Progress, Run, Stop, Stopped};
use std::sync::Mutex;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

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

fn bits(film: &etendue_film::Film) -> Vec<u32> {
    film.develop().iter().flatten().map(|x| x.to_bits()).collect()
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
            (bits(&nee), bits(&light), a.books, b.books, a.noise.map(|n| n.rel_mse.to_bits()))
        };
        let once = at(1);
        for threads in [2, 5] {
            assert!(at(threads) == once, "{threads} threads, {stop:?}");
        }
    }
}

/// Light tracing that asks for its own cancellation in the middle of a pass.
struct Interrupted<'a> {
    run: (&'a CancelToken, &'a Progress),
    at: Option<(u32, u64)>,
}

impl ParticleSolver for Interrupted<'_> {
    fn shoot(&self, c: &LightContext<'_>, u: &Sampler, tally: &mut Tally) {
        let (cancel, progress) = self.run;
        if let Some((pass, units)) = self.at
            && progress.passes.load(Relaxed) >= u64::from(pass)
            && progress.tiles.load(Relaxed) >= units
        {
            cancel.cancel();
        }
        LightNee.shoot(c, u, tally);
    }

    fn reach(&self, max_edges: u32) -> u32 {
        LightNee.reach(max_edges)
    }
}

etendue_solvers::solve_by_particles!(Interrupted<'_>);

/// Stopped within a pass and resumed from bytes, twice: the same picture and the same books.
#[test]
fn stopped_and_resumed_is_undisturbed() {
    let scene = room(&camera("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [72, 60]), "");
    let pool = threads(2);
    let session = |at: Option<(u32, u64)>, resume: Option<&[u8]>| {
        let (cancel, progress) = (CancelToken::default(), Progress::default());
        let last = Mutex::new(Vec::new());
        let events = |event: Event<'_>| {
            if let Event::Checkpoint(checkpoint) = event {
                *last.lock().expect("unpoisoned") = checkpoint.to_bytes();
            }
        };
        let run = Run {
            view: 0,
            seed: 3,
            sequence: SequenceKind::Sobol,
            stop: Stop::Samples(4),
            rules: PathRules::default(),
            digest: 9,
            pool: &pool,
            cancel: &cancel,
            progress: &progress,
            events: &events,
            checkpoint_every: Some(Duration::from_secs(3600)),
        };
        let checkpoint = resume.map(|bytes| Checkpoint::from_bytes(bytes).expect("a checkpoint"));
        let film = blank(&scene);
        let solver = Interrupted { run: (&cancel, &progress), at };
        let outcome = etendue_solvers::render(&solver, "test", &scene, &run, &film, checkpoint.as_ref()).expect("runs");
        let bytes = last.lock().expect("unpoisoned").clone();
        (bits(&film), outcome, bytes)
    };
    let (undisturbed, whole, _) = session(None, None);
    let (first, stopped, bytes) = session(Some((0, 2)), None);
    assert_eq!((stopped.stopped, stopped.passes), (Stopped::Cancelled, 0));
    assert!(first != undisturbed);
    let (_, stopped, bytes) = session(Some((2, 1)), Some(&bytes));
    assert_eq!((stopped.stopped, stopped.passes), (Stopped::Cancelled, 2));
    let (finished, end, _) = session(None, Some(&bytes));
    assert_eq!((end.stopped, end.passes, end.books), (Stopped::Samples, 4, whole.books));
    assert!(finished == undisturbed);
}
