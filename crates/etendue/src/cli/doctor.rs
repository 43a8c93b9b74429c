//! `etendue doctor`: what the program finds on this machine, and whether it works.

use super::{Done, output};
use clap::Args;
use etendue::render::software;
use etendue::{LoadOptions, RenderOptions, Stop, Watch, cores, load, memory, render};
use etendue_accel::Path;
use std::process::ExitCode;

/// Tells what there is on this machine, and renders a scene whose answer is known.
#[derive(Debug, Args)]
#[command(after_help = "Example: etendue doctor")]
pub struct DoctorArguments {}

pub fn run(_: &DoctorArguments) -> Done {
    let row = |name: &str, words: String| output::result(&format!("{name:<12}{words}"));
    let build = if cfg!(debug_assertions) { "built with checks: slow, use --release" } else { "built for speed" };
    row("version", format!("{}, {build}", software()));
    row("system", format!("{}, {}", std::env::consts::OS, std::env::consts::ARCH));
    let rays = match Path::best() {
        Path::Avx512 => "eight boxes or triangles at a time (AVX2), in small scenes sixteen rays (AVX-512)",
        Path::Avx2 => "eight boxes or triangles at a time (AVX2)",
        Path::Plain => "plain code (this processor has no AVX2): same pictures, slower",
    };
    row("rays", rays.to_owned());
    row("threads", cores().to_string());
    let had = memory::available().map_or("not told by the system".to_owned(), |b| format!("{} can be had", memory::human(b)));
    row("memory", had);
    row("folder", folder());

    // In a closed box with emission 1 and albedo 1/2 every ray brings 1 / (1 - 1/2) = 2.
    let options = LoadOptions { width: Some(32), ..LoadOptions::default() };
    let furnace = load("furnace", &options).map_err(|e| output::load_error(&e))?;
    let options = RenderOptions { stop: Some(Stop::Samples(64)), ..RenderOptions::default() };
    let rendering = render(&furnace, &options, &Watch::default()).map_err(|e| e.to_string())?;
    let [r, g, b] = rendering.mean();
    let good = [r, g, b].iter().all(|x| (x - 2.0).abs() < 0.02);
    row("check", format!("a furnace of radiance 2 renders to {r:.4}, {g:.4}, {b:.4}: {}", if good { "good" } else { "WRONG" }));
    if good { Ok(ExitCode::SUCCESS) } else { Err("the furnace is not rendered right on this machine".to_owned()) }
}

fn folder() -> String {
    let here = std::env::current_dir().map_or("this one".to_owned(), |d| d.display().to_string());
    let can = super::files::can_write_in(std::path::Path::new(".")).is_ok();
    format!("{here} {}", if can { "can be written to" } else { "cannot be written to: name files elsewhere with -o" })
}
