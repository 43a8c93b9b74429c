//! The command line.

mod diff;
mod info;
mod output;
mod progress;
mod render;
mod scenes;
mod tonemap;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

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
    /// Tell what a scene holds.
    Info(info::InfoArguments),
    /// Measure how far a picture is from a reference.
    Diff(diff::DiffArguments),
    /// Turn a picture of linear light into one for a display.
    Tonemap(tonemap::TonemapArguments),
}

/// Runs the command; messages go to standard error, results to standard output or files.
pub fn run(arguments: Arguments) -> ExitCode {
    let done = match arguments.command {
        Command::Render(a) => render::run(&a),
        Command::Scenes(a) => scenes::run(&a),
        Command::Info(a) => info::run(&a),
        Command::Diff(a) => diff::run(&a),
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

/// `NAME=VALUE`.
fn define(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').ok_or_else(|| format!("`{text}` is not of the form NAME=VALUE"))?;
    Ok((name.to_owned(), value.to_owned()))
}
