//! The same bits: on any number of threads, again, stopped and resumed, in noise mode, in a crop window. And what is refused.

mod common;

use common::*;
use etendue_film::Film;
use etendue_numerics::SequenceKind;
use etendue_scene::Scene;
use etendue_solvers::agreement::{NoPicture, Trial};
use etendue_solvers::metropolis::bootstrap::ReplayDiffers;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::path_nee::PathNee;
use etendue_solvers::solver::Needs;
use etendue_solvers::{
    CancelToken, CannotGoOn, Checkpoint, Event, Outcome, PathRules, Progress, Run, Solver, Spread, Stop, Stopped, Work,
};
use std::sync::Mutex;
use std::time::Duration;

/// A filter wider than a pixel: samples reach over the borders of tiles.
const GAUSSIAN: &str = r#"<rfilter type="gaussian"/>"#;
const BOX: &str = r#"<rfilter type="box"/>"#;

/// A noise target that is never reached.
const NOISE: Stop = Stop::Noise { percent: 1e-9, limit: 32 };

fn balls(film: &str) -> Scene {
    scene(&format!(
        r#"{}<shape type="cube"><boolean name="flip_normals" value="true"/>{}</shape>
        <shape type="sphere"><point name="center" value="0, -0.5, 0.3"/><float name="radius" value="0.4"/><bsdf type="plastic"/></shape>
        <shape type="sphere"><point name="center" value="0.3, 0.5, 0.3"/><float name="radius" value="0.2"/>{}</shape>"#,
        camera_with("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [24, 20], film),
        diffuse(0.6),
        area("5, 4, 3")
    ))
}

#[test]
fn threads_do_not_matter() {
    let scene = balls(GAUSSIAN);
    for job in [samples(5), Job { stop: NOISE, ..samples(0) }, samples(0).adaptive(1e-9, 80)] {
        let at = |threads: usize| {
            let (film, outcome) = render(&scene, &PathMis::default(), Job { threads, ..job });
            (bits(&film.develop()), outcome.samples, outcome.noise.map(|n| (n.rel_mse.to_bits(), n.half_width.to_bits())))
        };
        let once = at(1);
        assert_eq!(at(1), once, "the second time");
        for threads in [2, 5] {
            assert!(at(threads) == once, "{threads} threads, {job:?}");
        }
    }
}

#[test]
fn seeds_and_solvers_matter() {
    let scene = balls(BOX);
    let first = picture(&scene, &PathMis::default(), samples(2));
    assert_ne!(first, picture(&scene, &PathMis::default(), samples(2).seed(2)));
    assert_ne!(first, picture(&scene, &PathNee, samples(2)));
}

/// A crop is a window of the whole film, to the bit.
#[test]
fn crops_are_windows() {
    let whole = picture(&balls(BOX), &PathMis::default(), samples(4));
    for (x0, y0, width, height) in [(0, 0, 24, 20), (5, 3, 9, 11), (23, 19, 1, 1), (8, 8, 16, 4)] {
        let crop = format!(
            r#"{BOX}<integer name="crop_offset_x" value="{x0}"/><integer name="crop_offset_y" value="{y0}"/>
            <integer name="crop_width" value="{width}"/><integer name="crop_height" value="{height}"/>"#
        );
        let part = picture(&balls(&crop), &PathMis::default(), samples(4));
        let window: Picture = (y0..y0 + height).flat_map(|y| (x0..x0 + width).map(move |x| y * 24 + x)).map(|i| whole[i]).collect();
        assert!(bits(&part) == bits(&window), "the window of {width} × {height} at ({x0}, {y0})");
    }
}

/// A render under a magnifying glass: stopped after so many tiles, resumed, its last checkpoint kept.
struct Attempt<'a> {
    scene: &'a Scene,
    stop: Stop,
    spread: Spread,
    digest: u64,
    seed: u64,
}

impl Attempt<'_> {
    /// Cancelled from within once `tiles` tiles of pass `pass` are done; the bytes of the last checkpoint.
    fn run(&self, cancel_at: Option<(u32, u64)>, resume: Option<&[u8]>) -> Result<(Picture, Outcome, Vec<u8>), String> {
        let (cancel, progress) = (CancelToken::default(), Progress::default());
        let last = Mutex::new(Vec::new());
        let events = |event: Event<'_>| {
            if let Event::Checkpoint(checkpoint) = event {
                *last.lock().expect("unpoisoned") = checkpoint.to_bytes();
            }
        };
        let pool = threads(2);
        let run = Run {
            view: 0,
            seed: self.seed,
            sequence: SequenceKind::Sobol,
            stop: self.stop,
            spread: self.spread,
            rules: PathRules::default(),
            digest: self.digest,
            pool: &pool,
            cancel: &cancel,
            progress: &progress,
            events: &events,
            checkpoint_every: Some(Duration::from_secs(3600)),
        };
        let checkpoint = resume.map(Checkpoint::from_bytes).transpose().map_err(|e| e.to_string())?;
        let film: Film = blank(self.scene);
        let solver = Saboteur { cancel: &cancel, progress: &progress, at: cancel_at };
        let outcome =
            etendue_solvers::render(&solver, "test", self.scene, &run, &film, checkpoint.as_ref()).map_err(|e| e.to_string())?;
        let bytes = last.lock().expect("unpoisoned").clone();
        Ok((film.develop(), outcome, bytes))
    }
}

/// path-mis that asks for its own cancellation in the middle of a pass.
struct Saboteur<'a> {
    cancel: &'a CancelToken,
    progress: &'a Progress,
    at: Option<(u32, u64)>,
}

impl etendue_solvers::drivers::PixelSolver for Saboteur<'_> {
    fn radiance(
        &self,
        c: &etendue_solvers::transport::Context<'_>,
        eye: etendue_solvers::transport::PathState,
        u: &etendue_numerics::Sampler,
        rays: &mut u64,
    ) -> etendue_numerics::Spectrum {
        use std::sync::atomic::Ordering::Relaxed;
        if let Some((pass, tiles)) = self.at
            && self.progress.passes.load(Relaxed) >= u64::from(pass)
            && self.progress.tiles.load(Relaxed) >= tiles
        {
            self.cancel.cancel();
        }
        PathMis::default().radiance(c, eye, u, rays)
    }
}

#[test]
fn stopped_and_resumed_is_undisturbed() {
    let scene = balls(GAUSSIAN);
    let adaptive = Stop::Noise { percent: 1e-9, limit: 64 };
    for (stop, spread) in [(Stop::Samples(6), Spread::Uniform), (NOISE, Spread::Uniform), (adaptive, Spread::Adaptive)] {
        let attempt = Attempt { scene: &scene, stop, spread, digest: 9, seed: 3 };
        let (undisturbed, outcome, _) = attempt.run(None, None).expect("runs");
        let mut bytes: Option<Vec<u8>> = None;
        // Interruptions: in the middle of the first pass, of a later one, and right at a pass's beginning; and where pixels are no longer sampled alike.
        for at in [(0, 2), (3, 4), (5, 0), (40, 3)].into_iter().filter(|at| at.0 < outcome.passes) {
            let (partial, stopped, saved) = attempt.run(Some(at), bytes.as_deref()).expect("resumes");
            assert_eq!(stopped.stopped, Stopped::Cancelled);
            assert_eq!(stopped.passes, at.0);
            assert_ne!(partial, undisturbed);
            bytes = Some(saved);
        }
        let (finished, end, _) = attempt.run(None, bytes.as_deref()).expect("resumes");
        assert_eq!((end.stopped, end.passes), (outcome.stopped, outcome.passes));
        assert_eq!((end.noise, end.samples), (outcome.noise, outcome.samples));
        assert!(bits(&finished) == bits(&undisturbed), "{stop:?}");
    }
}

/// `path-nee`, which finds out in its third pass that it cannot go on.
struct Unsure;

const DIFFERS: CannotGoOn = CannotGoOn::Replay(ReplayDiffers { edges: 3, path: 7, drawn: 1.0, replayed: 2.0 });

impl Solver for Unsure {
    type State = ();

    fn needs(&self) -> Needs {
        Needs::default()
    }

    fn splats(&self) -> bool {
        false
    }

    fn units(&self, size: [u32; 2]) -> usize {
        Solver::units(&PathNee, size)
    }

    fn prepare(&self, _: &Scene, _: &Run<'_>) {}

    fn pass(&self, scene: &Scene, run: &Run<'_>, state: &mut (), k: u32, work: &Work<'_>) -> Result<(), CannotGoOn> {
        if k == 2 { Err(DIFFERS) } else { Solver::pass(&PathNee, scene, run, state, k, work) }
    }
}

/// What was rendered before is kept, and whoever asked is told why there is no more.
#[test]
fn a_solver_that_cannot_go_on_ends_the_render_with_what_it_has() {
    let scene = balls(BOX);
    let (film, outcome) = render(&scene, &Unsure, samples(5));
    assert_eq!((outcome.stopped, outcome.passes), (Stopped::Failed(DIFFERS), 2));
    assert!(film.develop().iter().all(|p| *p != [0.0; 3]), "the passes before are there");

    let cancel = CancelToken::default();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
    let trial = Trial::new(&scene, &pool, &cancel);
    let replicate = trial.replicate(&*trial.renderer(&Unsure), 4, 0, 0);
    assert_eq!(replicate.map(|shot| shot.dropped), Err(NoPicture::Failed(DIFFERS)));
    assert!(DIFFERS.to_string().contains("metropolis cannot go on"));
}

/// The first pass is finished whatever the clock says.
#[test]
fn no_time_is_time_for_one_pass() {
    let scene = balls(BOX);
    let (film, outcome) = render(&scene, &PathMis::default(), Job { stop: Stop::Time(Duration::ZERO), ..samples(0) });
    assert_eq!((outcome.stopped, outcome.passes), (Stopped::Time, 1));
    assert!(film.develop().iter().all(|p| *p != [0.0; 3]), "no picture has holes");
}

#[test]
fn foreign_and_damaged_checkpoints_are_refused() {
    let scene = balls(BOX);
    let attempt = |digest, seed, stop| Attempt { scene: &scene, stop, spread: Spread::Uniform, digest, seed };
    let of = attempt(9, 3, Stop::Samples(6));
    let (_, _, bytes) = of.run(Some((2, 1)), None).expect("runs");
    assert!(of.run(None, Some(&bytes)).is_ok());

    let refused = |attempt: Attempt<'_>, bytes: &[u8], words: &str| match attempt.run(None, Some(bytes)) {
        Ok(_) => panic!("went on, should have said: {words}"),
        Err(said) => assert!(said.contains(words), "said: {said}"),
    };
    refused(attempt(8, 3, Stop::Samples(6)), &bytes, "scene or its settings have changed");
    refused(attempt(9, 4, Stop::Samples(6)), &bytes, "seed 3");
    refused(attempt(9, 3, Stop::Samples(7)), &bytes, "sample count of 6");
    refused(attempt(9, 3, Stop::Noise { percent: 1.0, limit: 96 }), &bytes, "noise target");
    let (_, _, even) = attempt(9, 3, NOISE).run(Some((2, 1)), None).expect("runs");
    refused(
        Attempt { spread: Spread::Adaptive, ..attempt(9, 3, NOISE) },
        &even,
        "a uniform spread, this render has an adaptive spread",
    );
    let smaller = scene_of_another_size();
    refused(Attempt { scene: &smaller, ..attempt(9, 3, Stop::Samples(6)) }, &bytes, "size");

    // Cut short, lengthened, nothing at all, something else, and every place with a flipped bit (every 97th, to save time).
    for damaged in
        [&bytes[..bytes.len() - 1], &bytes[..bytes.len() / 2], &[], b"PNG and the like", &[bytes.as_slice(), &[0]].concat()]
    {
        refused(attempt(9, 3, Stop::Samples(6)), damaged, "checkpoint");
    }
    for i in (0..bytes.len()).step_by(97) {
        let mut damaged = bytes.clone();
        damaged[i] ^= 0x10;
        refused(attempt(9, 3, Stop::Samples(6)), &damaged, "checkpoint");
    }
}

fn scene_of_another_size() -> Scene {
    scene(&camera("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [24, 16]))
}
