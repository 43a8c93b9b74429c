//! Showing how far a render is: a bar with an ETA on a terminal, a plain line now and then otherwise.

use super::output::message;
use etendue::{Stop, Watch};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Steps of the bar.
const STEPS: u64 = 1000;

/// A thread that watches a render until it is dropped.
pub struct Display {
    done: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// The latest noise estimate, per cent, for the display.
#[derive(Default)]
pub struct NoiseCell(AtomicU64);

impl NoiseCell {
    /// Notes √relMSE in per cent.
    pub fn set(&self, percent: f64) {
        self.0.store(percent.to_bits(), Ordering::Relaxed);
    }

    fn get(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }
}

impl Display {
    /// Begins to watch.
    pub fn start(watch: Arc<Watch>, stop: Stop, noise: Arc<NoiseCell>) -> Self {
        let done = Arc::new(AtomicBool::new(false));
        let ended = Arc::clone(&done);
        let thread = std::thread::spawn(move || {
            let mut view: Box<dyn FnMut(f64, Duration, &str)> =
                if std::io::stderr().is_terminal() { Box::new(bar()) } else { Box::new(lines()) };
            let begun = Instant::now();
            let mut first = None;
            while !ended.load(Ordering::Relaxed) {
                let passes = watch.progress.fractional_passes();
                let first = *first.get_or_insert(passes);
                let fraction = fraction(stop, passes, begun.elapsed(), noise.get());
                let eta = eta(stop, fraction, passes - first, passes, begun.elapsed());
                view(fraction, begun.elapsed(), &format!("{passes:.0} spp, {eta}"));
                std::thread::sleep(Duration::from_millis(50));
            }
            view(f64::NAN, begun.elapsed(), "");
        });
        Self { done, thread: Some(thread) }
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        self.done.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A display that failed must not take the picture with it.
            let _ = thread.join();
        }
    }
}

/// How much is done, in [0, 1).
fn fraction(stop: Stop, passes: f64, elapsed: Duration, noise: f64) -> f64 {
    let fraction = match stop {
        Stop::Samples(n) => passes / f64::from(n.max(1)),
        Stop::Time(limit) => elapsed.as_secs_f64() / limit.as_secs_f64().max(1e-9),
        // Error falls with the square root of the work.
        Stop::Noise { percent, .. } if noise > 0.0 => (percent / noise).powi(2),
        Stop::Noise { .. } => 0.0,
    };
    fraction.clamp(0.0, 0.999)
}

/// The time left, from the work of this run alone, so that it is right after a resume too.
fn eta(stop: Stop, fraction: f64, worked: f64, passes: f64, elapsed: Duration) -> String {
    let seconds = elapsed.as_secs_f64();
    let left = match stop {
        Stop::Time(limit) => limit.as_secs_f64() - seconds,
        Stop::Samples(n) if worked > 0.0 => (f64::from(n) - passes) * seconds / worked,
        Stop::Noise { .. } if fraction > 0.0 => seconds / fraction - seconds,
        _ => f64::INFINITY,
    };
    if left.is_finite() && seconds > 0.3 { format!("ETA {}", clock(left.max(0.0))) } else { "ETA --".to_owned() }
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

fn bar() -> impl FnMut(f64, Duration, &str) {
    let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{bar:40.cyan/blue} {percent:>3} % · {msg}") {
        bar.set_style(style);
    }
    move |fraction, elapsed, words| {
        if fraction.is_nan() {
            bar.finish_and_clear();
        } else {
            bar.set_position((fraction * STEPS as f64) as u64);
            bar.set_message(format!("{} · {words}", clock(elapsed.as_secs_f64())));
        }
    }
}

fn lines() -> impl FnMut(f64, Duration, &str) {
    let mut next = Duration::from_secs(2);
    move |fraction, elapsed, words| {
        if !fraction.is_nan() && elapsed >= next {
            message(&format!("{:3.0} % after {}, {words}", fraction * 100.0, clock(elapsed.as_secs_f64())));
            next = elapsed.mul_f64(1.5).max(elapsed + Duration::from_secs(2));
        }
    }
}
