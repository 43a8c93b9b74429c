//! What the benches share.

use etendue_formats::ReadOptions;
use etendue_scene::{CompileOptions, Scene};

/// CPU seconds of this process, and the most bytes that it held, as far as the system tells.
pub fn usage() -> [f64; 2] {
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let stat = read("/proc/self/stat");
    // Fields 14 and 15, counted from after the name: user and system time in hundredths.
    let after = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    let ticks: f64 = after.skip(11).take(2).filter_map(|t| t.parse::<f64>().ok()).sum();
    let status = read("/proc/self/status");
    let peak = status.lines().find_map(|l| l.strip_prefix("VmHWM:")?.split_whitespace().next()?.parse::<f64>().ok());
    [ticks / 100.0, peak.unwrap_or(f64::NAN) * 1024.0]
}

/// The scene of a text.
pub fn compile(text: &str) -> Scene {
    let (description, mut diagnostics) = etendue_formats::read_str("bench.xml", text, &ReadOptions::default());
    let scene = etendue_scene::compile(&description, &CompileOptions::default(), &mut diagnostics);
    scene.unwrap_or_else(|| panic!("{}", diagnostics.render(&description.sources)))
}
