//! The command line.

mod acceptance;
mod bench;
mod compare;
mod convert;
mod diff;
mod doctor;
mod experiment;
mod files;
mod form_factors;
mod info;
mod interrupt;
mod measure;
mod output;
mod parse;
mod progress;
mod radiosity;
mod render;
mod scene;
mod scenes;
mod solvers;
mod strategies;
mod summary;
mod tonemap;
mod verify;

use clap::{Parser, Subcommand};
use etendue::render::panic_words;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// A physically based renderer and light-transport laboratory.
#[derive(Debug, Parser)]
#[command(name = "etendue", version, about, after_help = "Example: etendue render cornell-box --time 10 -o box.exr -o box.png")]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene to pictures.
    Render(Box<render::RenderArguments>),
    /// List the built-in scenes.
    Scenes(scenes::ScenesArguments),
    /// List the solvers and their parameters.
    Solvers(solvers::SolversArguments),
    /// Tell what a scene holds.
    Info(info::InfoArguments),
    /// Write a scene as Mitsuba 3 or pbrt-v4.
    Convert(convert::ConvertArguments),
    /// Measure how far a picture is from a reference.
    Diff(diff::DiffArguments),
    /// Tell what there is on this machine, and whether rendering works.
    Doctor(doctor::DoctorArguments),
    /// Compute form factors (view factors) between patches and between shapes.
    FormFactors(Box<form_factors::FormFactorArguments>),
    /// Render with several solvers and show, as a page, how far each is from a reference.
    Compare(Box<compare::CompareArguments>),
    /// Test whether all solvers find the same light: PASS, FAIL or INCONCLUSIVE.
    Verify(Box<verify::VerifyArguments>),
    /// Show what each strategy of bidirectional path tracing finds, as a pyramid of pictures.
    Strategies(Box<strategies::StrategiesArguments>),
    /// Solve diffuse light between patches: pictures, bounce by bounce, meshes and tables.
    Radiosity(Box<radiosity::RadiosityArguments>),
    /// Measure illuminance and irradiance at points or on a grid.
    Measure(Box<measure::MeasureArguments>),
    /// Measure how fast this machine casts rays and renders.
    Bench(bench::BenchArguments),
    /// Turn a picture of linear light into one for a display.
    Tonemap(tonemap::TonemapArguments),
}

/// Runs the command; messages go to standard error, results to standard output or files.
pub fn run(arguments: Arguments) -> ExitCode {
    let done = match arguments.command {
        Command::Render(a) => render::run(&a),
        Command::Scenes(a) => scenes::run(&a),
        Command::Solvers(a) => solvers::run(&a),
        Command::Info(a) => info::run(&a),
        Command::Convert(a) => convert::run(&a),
        Command::Doctor(a) => doctor::run(&a),
        Command::Diff(a) => diff::run(&a),
        Command::FormFactors(a) => form_factors::run(&a),
        Command::Compare(a) => compare::run(&a),
        Command::Verify(a) => verify::run(&a),
        Command::Strategies(a) => strategies::run(&a),
        Command::Radiosity(a) => radiosity::run(&a),
        Command::Measure(a) => measure::run(&a),
        Command::Bench(a) => bench::run(&a),
        Command::Tonemap(a) => tonemap::run(&a),
    };
    match done {
        Ok(code) => code,
        Err(words) => {
            output::error(&words);
            ExitCode::FAILURE
        }
    }
}

/// What a command ends with: an exit status, or the words of an error.
pub type Done = Result<ExitCode, String>;

/// A panic is a mistake of ours: it is told once, in words that help to mend it.
pub fn speak_of_panics() {
    static TOLD: AtomicBool = AtomicBool::new(false);
    std::panic::set_hook(Box::new(|panic| {
        if !TOLD.swap(true, Ordering::Relaxed) {
            let place = panic.location().map_or("an unknown place".to_owned(), |l| format!("{}:{}", l.file(), l.line()));
            let words = panic_words(panic.payload());
            output::error(&format!(
                "étendue has met a mistake of its own at {place}: {words}\n  help: please report it with the scene and this line"
            ));
        }
    }));
}
