//! How the equation is made and solved, as arguments; and solving it with a bar.

use super::super::interrupt::{Words, stop_on_ctrl_c};
use super::super::{output, parse};
use super::tell::tell;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use etendue::Loaded;
use etendue::radiosity::{Report, solve};
use etendue_radiosity::Solved;
use etendue_radiosity::form_factor::Open;
use etendue_radiosity::patch::PatchSize;
use etendue_radiosity::solved::{Factors, Method, Settings, Stage};
use etendue_solvers::CancelToken;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How the equation is made and solved.
#[derive(Debug, Args)]
pub struct SolutionArguments {
    /// Size of patches in metres.
    #[arg(long, value_name = "METRES", value_parser = parse::positive)]
    patch_size: Option<f64>,
    /// About so many patches, smaller where the light changes.
    #[arg(long, value_name = "N", conflicts_with = "patch_size", default_value_t = 12_000, value_parser = clap::value_parser!(u32).range(1..=4_000_000))]
    patches: u32,
    /// Patches of one size, also where the light changes.
    #[arg(long)]
    even: bool,
    /// How form factors are found.
    #[arg(long, value_name = "METHOD", default_value = Factors::NAMES[0], value_parser = factors())]
    method: Factors,
    /// Form-factor rays a patch.
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(16..=1 << 24))]
    samples: u32,
    /// Of `hierarchical`: bound on the error of B, in parts of all reflected light, down to which links are refined.
    #[arg(long, value_name = "E", default_value_t = Settings::default().error, value_parser = parse::positive)]
    error: f64,
    /// How the equation is solved.
    #[arg(long, value_name = "METHOD", default_value = Method::NAMES[0], value_parser = methods())]
    solve: Method,
    /// What the rows of an open scene are brought to.
    #[arg(long, value_name = "ROWS", default_value = Open::NAMES[0], value_parser = open())]
    open: Open,
    /// Relative residual at which it is.
    #[arg(long, value_name = "R", default_value_t = 1e-4, value_parser = parse::positive)]
    residual: f64,
    /// Seed of all rays.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
}

impl SolutionArguments {
    /// As the library takes it.
    pub fn settings(&self) -> Settings {
        let size = self.patch_size.map_or(PatchSize::Count(self.patches as usize), PatchSize::Metres);
        Settings {
            size,
            adaptive: !self.even,
            factors: self.method,
            rays: self.samples,
            error: self.error,
            method: self.solve,
            open: self.open,
            residual: self.residual,
            seed: self.seed,
            ..Settings::default()
        }
    }
}

/// Names with their help.
fn choice<T: Copy>(all: &[T], name: fn(T) -> &'static str, help: fn(T) -> &'static str) -> PossibleValuesParser {
    PossibleValuesParser::new(all.iter().map(|x| PossibleValue::new(name(*x)).help(help(*x).trim_end_matches('.'))))
}

fn factors() -> impl TypedValueParser<Value = Factors> {
    choice(Factors::ALL, Factors::name, Factors::help).map(|name| Factors::named(&name).unwrap_or_default())
}

fn methods() -> impl TypedValueParser<Value = Method> {
    choice(Method::ALL, Method::name, Method::help).map(|name| Method::named(&name).unwrap_or_default())
}

fn open() -> impl TypedValueParser<Value = Open> {
    choice(Open::ALL, Open::name, Open::help).map(|name| Open::named(&name).unwrap_or_default())
}

/// How far a solution is: a bar on a terminal, a line now and then otherwise.
struct Stages {
    bar: ProgressBar,
    /// When the last line was written; none where no lines are.
    last: Option<Mutex<Instant>>,
}

impl Stages {
    fn new(quiet: bool) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(1) };
        let style = ProgressStyle::with_template("{msg} {bar:30} {pos} of {len}, {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.set_message("form factors");
        let last = (!quiet && !std::io::stderr().is_terminal()).then(|| Mutex::new(Instant::now()));
        Self { bar, last }
    }

    fn tell(&self, stage: Stage) {
        /// Between lines.
        const PAUSE: Duration = Duration::from_secs(2);
        let words = match stage {
            Stage::Rows(done, of) => {
                self.bar.set_length(of as u64);
                self.bar.set_position(done as u64);
                format!("form factors: {done} of {of} rows")
            }
            Stage::Sweep(k, residual) => {
                let words = format!("sweep {k}, residual {residual:.1e}");
                self.bar.set_message(words.clone());
                words
            }
            Stage::Links(rays, bound) => {
                let words = format!("links of {rays} rays a patch, error below {:.1} %", 100.0 * bound);
                self.bar.set_message(words.clone());
                words
            }
            Stage::Patches(_) | Stage::Repaired => return,
        };
        let Some(last) = &self.last else { return };
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.elapsed() >= PAUSE {
            *last = Instant::now();
            output::message(&words);
        }
    }
}

/// Solves with a bar; the first Ctrl-C ends the sweeps.
pub fn solved(
    loaded: &Loaded,
    a: &SolutionArguments,
    threads: Option<usize>,
    quiet: bool,
) -> Result<(Solved, Report, Arc<CancelToken>), String> {
    let cancel = Arc::new(CancelToken::default());
    let words = Words {
        asked: Some("stopping after this sweep (Ctrl-C again to quit at once)"),
        ended: Some("stopped at once; nothing was written"),
    };
    stop_on_ctrl_c(&cancel, |c| c, words, "not keep the last sweep");
    let shown = Stages::new(quiet);
    let told = |stage: Stage| {
        shown.tell(stage);
        !cancel.is_cancelled()
    };
    let found = solve(loaded, &a.settings(), threads, &told);
    shown.bar.finish_and_clear();
    let (solved, report) = found.map_err(|e| e.to_string())?;
    if !quiet {
        tell(&report);
    }
    Ok((solved, report, cancel))
}
