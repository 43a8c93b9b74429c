//! What is said before and after a render.

use super::output::message;
use super::progress::clock;
use etendue::{Loaded, Rendering, Stop, Stopped, memory};
use std::path::PathBuf;

/// What is about to be rendered, in a line.
pub fn headline(loaded: &Loaded, view: usize, solver: &str, stop: Stop, threads: usize) -> String {
    let scene = &loaded.scene;
    let [w, h] = scene.views.get(view).map_or([0, 0], |v| v.film.crop_size);
    let until = match stop {
        Stop::Samples(n) => format!("{n} spp"),
        Stop::Time(limit) => clock(limit.as_secs_f64()),
        Stop::Noise { percent, .. } => format!("until the noise is {percent} %"),
    };
    let loading = (loaded.read_time + loaded.build_time).as_secs_f64();
    let name = &loaded.name;
    let (triangles, emitters) = (plural(scene.triangles, "triangle"), plural(scene.emitters.len() as u64, "emitter"));
    let threads = plural(threads as u64, "thread");
    format!("{name}: {triangles}, {emitters}, loaded in {}; {w} x {h} pixels, {until}, {solver}, {threads}", clock(loading))
}

fn plural(n: u64, word: &str) -> String {
    if n == 1 { format!("1 {word}") } else { format!("{n} {word}s") }
}

/// Where the files are, how long it took, and whatever should be known about the picture.
pub fn tell(rendering: &Rendering, files: &[PathBuf], target: Option<f64>) {
    let s = &rendering.stats;
    let names: Vec<_> = files.iter().map(|f| f.display().to_string()).collect();
    message(&format!("wrote {}", names.join(" and ")));
    let per_second = |n: u64| n as f64 / s.render_seconds.max(1e-9) / 1e6;
    message(&format!(
        "{} x {} pixels, {} spp by {} in {}: {:.2} M paths/s, {:.2} M rays/s, peak memory {}",
        s.width,
        s.height,
        s.spp,
        s.solver,
        clock(s.render_seconds),
        per_second(s.paths),
        per_second(s.rays),
        memory::human(s.peak_memory_bytes)
    ));
    let luminance = |[r, g, b]: [f64; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let share = |mean: [f64; 3]| 100.0 * luminance(mean) / luminance(s.mean).max(1e-300);
    let lights: Vec<_> = s.lights.iter().map(|l| format!("{} {:.1} %", l.name, share(l.mean))).collect();
    if !lights.is_empty() {
        message(&format!("of the light in the picture: {}", lights.join(", ")));
    }
    if let (Some([value, low, high]), Some(target)) = (s.noise_percent, target) {
        let verdict = if rendering.stopped == Stopped::Noise { "reached" } else { "not reached" };
        message(&format!("noise target {target} % {verdict}: √relMSE is {value:.3} % (95 % interval {low:.3} to {high:.3} %)"));
    }
    if let Some([least, most]) = s.samples.filter(|[least, most]| least < most) {
        message(&format!("from {least} to {most} samples a pixel, {} on average: more where there was noise", s.spp));
    }
    if rendering.stopped == Stopped::Cancelled && rendering.failure.is_none() {
        message("stopped before the end, as asked");
    }
    if s.nonfinite_samples > 0 {
        let which: Vec<_> = s.nonfinite_first.iter().map(|[x, y, n]| format!("sample {n} of pixel ({x}, {y})")).collect();
        message(&format!("warning: {} samples were not finite and were dropped: {}", s.nonfinite_samples, which.join(", ")));
    }
    if s.mean == [0.0; 3] {
        message("warning: the picture is black");
        for reason in &rendering.black {
            message(&format!("  help: {reason}"));
        }
    }
}
