//! The program: reads arguments, prints, and sets the exit status (0 done, 1 failed, 2 wrong usage, 130 stopped by Ctrl-C).

mod cli;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    cli::speak_of_panics();
    cli::run(cli::Arguments::parse())
}
