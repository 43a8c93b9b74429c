//! What `verify` and `compare` share at the command line.

use super::interrupt::{Words, stop_on_ctrl_c};
use super::output;
use super::scene::SceneArguments;
use clap::Args;
use etendue::experiment::ExperimentError;
use etendue_solvers::CancelToken;
use std::sync::Arc;

/// Options of both.
#[derive(Debug, Args)]
pub struct ExperimentArguments {
    /// Seed of all random decisions.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Show nothing but the result.
    #[arg(short, long)]
    pub quiet: bool,
}

impl ExperimentArguments {
    /// Runs it, telling what goes on; `None` where it was stopped by Ctrl-C, which is told in the words `stopped`.
    pub fn watch<T>(
        &self,
        stopped: &str,
        run: impl FnOnce(&CancelToken, &dyn Fn(&str)) -> Result<T, ExperimentError>,
    ) -> Result<Option<T>, String> {
        let cancel = Arc::new(CancelToken::default());
        stop_on_ctrl_c(&cancel, |token| token, Words::default(), "end the program at once");
        let tell = |words: &str| {
            if !self.quiet {
                output::message(&format!("{words} …"));
            }
        };
        match run(&cancel, &tell) {
            Ok(found) => Ok(Some(found)),
            Err(ExperimentError::Load(e)) => Err(output::load_error(&e)),
            Err(ExperimentError::Words(words)) => Err(words),
            Err(ExperimentError::Cancelled) => {
                output::message(&format!("stopped, as asked; {stopped}"));
                Ok(None)
            }
        }
    }
}
