//! `etendue scenes`: the built-in scenes, a line each.

use super::{Done, output};
use clap::Args;
use etendue::builtin::{FILES, SCENES};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Lists the built-in scenes, or writes one out as files to start from.
#[derive(Debug, Args)]
#[command(after_help = "Example: etendue scenes --export my-scenes")]
pub struct ScenesArguments {
    /// Write all built-in scene files into this folder.
    #[arg(long, value_name = "FOLDER")]
    export: Option<PathBuf>,
}

pub fn run(arguments: &ScenesArguments) -> Done {
    for scene in SCENES {
        output::result(&format!("{:<14}{}", scene.name, scene.summary));
    }
    if let Some(folder) = &arguments.export {
        let scenes = SCENES.iter().map(|s| (format!("{}.xml", s.name), s.text.as_bytes()));
        let files: Vec<_> = scenes.chain(FILES.iter().map(|(name, bytes)| ((*name).to_owned(), *bytes))).collect();
        // All or nothing.
        if let Some((name, _)) = files.iter().find(|(name, _)| folder.join(name).exists()) {
            return Err(format!("{} exists and is not overwritten", folder.join(name).display()));
        }
        for (name, bytes) in files {
            write(&folder.join(name), bytes)?;
        }
        output::message(&format!("wrote the scene files to {}", folder.display()));
    }
    Ok(ExitCode::SUCCESS)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let failed = |e: std::io::Error| format!("cannot write {}: {e}", path.display());
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(failed)?;
    }
    etendue_image::write_atomically(path, bytes).map_err(failed)
}
