//! Renders that stop in the middle of a pass and go on from bytes.

use super::*;
use etendue_solvers::solver::{CannotGoOn, Needs};
use etendue_solvers::{Balance, Checkpoint, Event, Stopped, Work};
use std::sync::Mutex;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

/// A solver that asks for its own cancellation in a pass, once so many of its units are done.
struct Interrupted<'a, S> {
    solver: &'a S,
    cancel: &'a CancelToken,
    at: Option<(u32, u64)>,
}

impl<S: Solver> Solver for Interrupted<'_, S> {
    type State = S::State;

    fn needs(&self) -> Needs {
        self.solver.needs()
    }

    fn splats(&self) -> bool {
        self.solver.splats()
    }

    fn units(&self, size: [u32; 2]) -> usize {
        self.solver.units(size)
    }

    fn books(&self, state: &S::State) -> Option<Balance> {
        self.solver.books(state)
    }

    fn prepare(&self, scene: &Scene, run: &Run<'_>) -> S::State {
        self.solver.prepare(scene, run)
    }

    fn pass(&self, scene: &Scene, run: &Run<'_>, state: &mut S::State, k: u32, work: &Work<'_>) -> Result<(), CannotGoOn> {
        let stop_now = || {
            if self.at.is_some_and(|(pass, units)| k == pass && work.progress.tiles.load(Relaxed) >= units) {
                self.cancel.cancel();
            }
            (work.stop_now)()
        };
        self.solver.pass(scene, run, state, k, &Work { stop_now: &stop_now, ..*work })
    }
}

/// The picture's bits, how the render ended, and its last checkpoint as bytes.
type Session = (Vec<u32>, Outcome, Vec<u8>);

fn session<S: Solver>(scene: &Scene, solver: &S, stop: Stop, at: Option<(u32, u64)>, resume: Option<&[u8]>) -> Session {
    let (cancel, last) = (CancelToken::default(), Mutex::new(Vec::new()));
    let events = |event: Event<'_>| {
        if let Event::Checkpoint(checkpoint) = event {
            *last.lock().expect("unpoisoned") = checkpoint.to_bytes();
        }
    };
    let run = Run {
        view: 0,
        seed: 3,
        sequence: SequenceKind::Sobol,
        stop,
        spread: Spread::Uniform,
        rules: PathRules::default(),
        digest: 9,
        pool: pool(),
        cancel: &cancel,
        progress: &Progress::default(),
        events: &events,
        checkpoint_every: Some(Duration::MAX),
    };
    let checkpoint = resume.map(|bytes| Checkpoint::from_bytes(bytes).expect("a checkpoint"));
    let film = blank(scene);
    let solver = Interrupted { solver, cancel: &cancel, at };
    let outcome = etendue_solvers::render(&solver, "test", scene, &run, &film, checkpoint.as_ref()).expect("resumes");
    (bits(&film.develop()), outcome, last.into_inner().expect("unpoisoned"))
}

/// Stopped at each of `places` (pass, and units of it that are done) and resumed from bytes, a render ends as if undisturbed: the same bits, the same
/// noise, the same books.
pub fn leaves_no_trace<S: Solver>(scene: &Scene, solver: &S, stop: Stop, places: &[(u32, u64)]) {
    let (undisturbed, whole, _) = session(scene, solver, stop, None, None);
    let mut bytes = None;
    for at in places {
        let (partial, stopped, saved) = session(scene, solver, stop, Some(*at), bytes.as_deref());
        assert_eq!((stopped.stopped, stopped.passes), (Stopped::Cancelled, at.0));
        assert!(partial != undisturbed);
        bytes = Some(saved);
    }
    let (finished, end, _) = session(scene, solver, stop, None, bytes.as_deref());
    assert_eq!((end.stopped, end.passes, end.noise, end.books), (whole.stopped, whole.passes, whole.noise, whole.books));
    assert!(finished == undisturbed, "{stop:?}");
}
