//! Showing how far a render is: a bar with an ETA on a terminal, a plain line now and then otherwise, or JSON.

use super::output;
use clap::ValueEnum;
use etendue::{Stop, Watch};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Steps of the bar.
const STEPS: u64 = 1000;
/// How often the display looks.
const TICK: Duration = Duration::from_millis(50);

/// How progress is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Style {
    /// A bar on a terminal, lines otherwise.
    #[default]
    Auto,
    /// A bar that is drawn over and over.
    Bar,
    /// A line now and then.
    Lines,
    /// A JSON object a line, on standard output.
    Json,
    /// Nothing.
    None,
}

/// A thread that watches a render until it is dropped.
pub struct Display {
    done: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// The latest noise estimate: passes, and √relMSE in per cent.
pub type NoiseCell = Mutex<Option<(u32, f64)>>;

/// Shows a look at the render, or, at the end, `None`.
type Show = Box<dyn FnMut(Option<&Look>)>;

/// What a display is shown.
struct Look {
    /// How much is done, in [0, 1).
    fraction: f64,
    passes: f64,
    elapsed: Duration,
    /// Seconds left, where that can be told.
    left: Option<f64>,
}

impl Look {
    /// Whole per cent, 99 at the most: 100 is for what has ended.
    fn percent(&self) -> f64 {
        (self.fraction * 100.0).floor()
    }
}

impl Display {
    /// Begins to watch a render whose passes are `pixels` paths each.
    pub fn start(style: Style, watch: Arc<Watch>, stop: Stop, pixels: u64, noise: Arc<NoiseCell>) -> Self {
        let done = Arc::new(AtomicBool::new(false));
        let ended = Arc::clone(&done);
        let thread = std::thread::spawn(move || {
            let mut show: Show = match style {
                Style::Auto if std::io::stderr().is_terminal() => Box::new(bar()),
                Style::Bar => Box::new(bar()),
                Style::Auto | Style::Lines => Box::new(lines()),
                Style::Json => Box::new(json()),
                Style::None => return,
            };
            let begun = Instant::now();
            while !ended.load(Ordering::Relaxed) {
                // Paths count the work of this run alone; passes count that of the run which is resumed, too.
                let worked = watch.progress.paths.load(Ordering::Relaxed) as f64 / pixels.max(1) as f64;
                let passes = watch.progress.fractional_passes();
                let noise = *noise.lock().unwrap_or_else(PoisonError::into_inner);
                show(Some(&look(stop, passes, worked, begun.elapsed(), noise)));
                std::thread::park_timeout(TICK);
            }
            show(None);
        });
        Self { done, thread: Some(thread) }
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        self.done.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // A display that failed must not take the picture with it.
            let _ = thread.join();
        }
    }
}

/// How far a render is after `passes` passes, `worked` of them in this run, which took `elapsed`.
fn look(stop: Stop, passes: f64, worked: f64, elapsed: Duration, noise: Option<(u32, f64)>) -> Look {
    let seconds = elapsed.as_secs_f64();
    let all = match stop {
        Stop::Samples(n) => Some(f64::from(n)),
        Stop::Time(_) => None,
        Stop::Noise { percent, .. } => noise.map(|(at, now)| passes_for_noise(at, now, percent)),
    };
    let fraction = match stop {
        Stop::Time(limit) => seconds / limit.as_secs_f64().max(1e-9),
        _ => all.map_or(0.0, |all| passes / all.max(1.0)),
    };
    let left = match stop {
        Stop::Time(limit) => Some(limit.as_secs_f64() - seconds),
        // The first moments say little about the rest.
        _ if seconds > 0.3 && worked > 0.0 => all.map(|all| (all - passes) * seconds / worked),
        _ => None,
    };
    Look { fraction: fraction.clamp(0.0, 0.999), passes, elapsed, left: left.map(|s| s.max(0.0)) }
}

/// Passes for √relMSE to fall from `now` to `target`: error falls with the square root of the work, and is tested whenever that has doubled.
fn passes_for_noise(at: u32, now: f64, target: f64) -> f64 {
    let factor = (now / target).powi(2).max(1.0);
    f64::from(at) * factor.log2().ceil().exp2()
}

/// Seconds as people read them.
pub fn clock(seconds: f64) -> String {
    let s = seconds.round() as u64;
    match s {
        0..=9 => format!("{seconds:.1} s"),
        10..=99 => format!("{s} s"),
        100..=5_999 => format!("{}:{:02} min", s / 60, s % 60),
        _ => format!("{}:{:02} h", s / 3600, s / 60 % 60),
    }
}

fn eta(look: &Look) -> String {
    look.left.map_or("ETA --".to_owned(), |s| format!("ETA {}", clock(s)))
}

fn bar() -> impl FnMut(Option<&Look>) {
    let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{bar:40.cyan/blue} {msg}") {
        bar.set_style(style);
    }
    output::bar_is_shown(true);
    move |look| match look {
        Some(look) => {
            bar.set_position((look.fraction * STEPS as f64) as u64);
            let seconds = clock(look.elapsed.as_secs_f64());
            bar.set_message(format!("{:3.0} % · {seconds} · {:.0} spp · {}", look.percent(), look.passes, eta(look)));
        }
        None => {
            bar.finish_and_clear();
            output::bar_is_shown(false);
        }
    }
}

/// Every so often, and ever less often: a long render fills no log.
fn rhythm() -> impl FnMut(Duration) -> bool {
    let mut next = Duration::from_secs(2);
    move |elapsed| {
        let due = elapsed >= next;
        if due {
            next = elapsed.mul_f64(1.5).min(elapsed + Duration::from_secs(300)).max(elapsed + Duration::from_secs(2));
        }
        due
    }
}

fn lines() -> impl FnMut(Option<&Look>) {
    let mut due = rhythm();
    move |look| {
        if let Some(look) = look.filter(|l| due(l.elapsed)) {
            let seconds = clock(look.elapsed.as_secs_f64());
            output::message(&format!("{:3.0} % after {seconds}, {:.0} spp, {}", look.percent(), look.passes, eta(look)));
        }
    }
}

fn json() -> impl FnMut(Option<&Look>) {
    let mut next = Duration::ZERO;
    move |look| {
        if let Some(look) = look.filter(|l| l.elapsed >= next) {
            next = look.elapsed + Duration::from_millis(500);
            let line = serde_json::json!({
                "event": "progress", "fraction": look.fraction, "passes": look.passes,
                "seconds": look.elapsed.as_secs_f64(), "seconds_left": look.left,
            });
            output::result(&line.to_string());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_resumed_render_tells_the_time_that_is_left() {
        // 900 of 1000 passes came from a checkpoint; this run has done 50 in 10 s: 50 are left.
        let look = look(Stop::Samples(1000), 950.0, 50.0, Duration::from_secs(10), None);
        assert_eq!((look.fraction, look.left), (0.95, Some(10.0)));
    }

    #[test]
    fn never_all_before_the_end() {
        for (stop, passes) in [(Stop::Samples(4), 4.0), (Stop::Time(Duration::from_secs(1)), 9.0)] {
            let look = look(stop, passes, passes, Duration::from_secs(2), None);
            assert!(look.fraction < 1.0 && look.percent() == 99.0 && look.left == Some(0.0));
        }
    }

    #[test]
    fn noise_needs_a_doubling_at_least() {
        assert_eq!(passes_for_noise(16, 8.0, 4.0), 64.0);
        assert_eq!(passes_for_noise(16, 5.0, 4.0), 32.0);
        assert_eq!(passes_for_noise(32, 4.0, 4.0), 32.0);
    }

    #[test]
    fn clocks() {
        assert_eq!([3.21, 42.0, 125.0, 7322.0].map(clock), ["3.2 s", "42 s", "2:05 min", "2:02 h"]);
    }
}
