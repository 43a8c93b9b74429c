//! `etendue solvers`: the ways to solve a scene, with the parameters of each.

use super::{Done, output};
use clap::Args;
use etendue_scene::Integrator;
use etendue_solvers::{AnySolver, SOLVERS};
use std::process::ExitCode;

/// Lists the solvers, each with its parameters and their defaults.
#[derive(Debug, Args)]
#[command(after_help = "Example: etendue render cornell-box --solver distribution --param shadow_samples=16")]
pub struct SolversArguments {
    /// One JSON array instead of words.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &SolversArguments) -> Done {
    let solvers = SOLVERS.iter().filter_map(|info| Some((info, AnySolver::new(info.name, &Integrator::default())?.parameters())));
    if arguments.json {
        let list: Vec<_> = solvers
            .map(|(info, parameters)| {
                let parameters: Vec<_> = parameters
                    .iter()
                    .map(|p| serde_json::json!({ "name": p.name, "summary": p.summary, "domain": p.domain, "default": p.value }))
                    .collect();
                serde_json::json!({ "name": info.name, "summary": info.summary.trim(), "parameters": parameters })
            })
            .collect();
        output::result(&serde_json::to_string_pretty(&list).map_err(|e| e.to_string())?);
        return Ok(ExitCode::SUCCESS);
    }
    for (info, parameters) in solvers {
        output::result(&format!("{:<14}{}", info.name, info.summary.trim()));
        for p in parameters {
            output::result(&format!("{:<14}  --param {}={}: {}; {}", "", p.name, p.value, p.summary, p.domain));
        }
    }
    Ok(ExitCode::SUCCESS)
}
