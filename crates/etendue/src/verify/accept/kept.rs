//! Replicates that are kept in a folder, a file for each solver, so that hours can be spread over many runs.
//!
//! They hold for the program that made them: one that was built anew may render other pictures, and replicates of both would be no sample of anything.

use super::super::{Stopped, VerifyOptions};
use super::course::Sums;
use crate::digest::Digest;
use crate::experiment::ExperimentError;
use crate::load::Loaded;
use etendue_solvers::agreement::Trial;
use serde::{Deserialize, Serialize};
use std::io::ErrorKind;
use std::path::PathBuf;

/// The replicates of one solver.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Kept {
    /// Emitters, and light that was scattered.
    pub(super) parts: Vec<Sums>,
}

/// A file.
#[derive(Serialize, Deserialize)]
struct File {
    scene: String,
    solver: String,
    /// Of all that decides the means: scene, size, grid, seed, version.
    digest: u64,
    /// Of the program's own file.
    program: u64,
    #[serde(flatten)]
    kept: Kept,
}

/// A folder of replicates of one scene.
pub(super) struct Keeper {
    folder: PathBuf,
    scene: String,
    digest: u64,
    program: u64,
}

/// The digest of the file that this program is.
fn program() -> Stopped<u64> {
    let bytes = std::env::current_exe().and_then(std::fs::read);
    let bytes = bytes.map_err(|e| ExperimentError::Words(format!("cannot read this program's own file to tell its build: {e}")))?;
    let mut digest = Digest::new();
    digest.bytes(&bytes);
    Ok(digest.finish())
}

impl Keeper {
    /// Of a scene, in the folder that the options name.
    pub(super) fn new(loaded: &Loaded, trial: &Trial<'_>, options: &VerifyOptions) -> Stopped<Option<Self>> {
        let Some(folder) = options.keep.clone() else { return Ok(None) };
        std::fs::create_dir_all(&folder)
            .map_err(|e| ExperimentError::Words(format!("cannot make the folder {}: {e}", folder.display())))?;
        let mut digest = Digest::new();
        digest.word(loaded.digest());
        digest.bytes(format!("{:?} {:?} {:?} {}", trial.rules, trial.shape(), trial.grid(), trial.seed).as_bytes());
        Ok(Some(Self { folder, scene: loaded.name.clone(), digest: digest.finish(), program: program()? }))
    }

    fn path(&self, solver: &str) -> PathBuf {
        self.folder.join(format!("{}.{solver}.json", self.scene))
    }

    /// What is kept of a solver; nothing where there is no file.
    pub(super) fn read(&self, solver: &str, areas: usize) -> Stopped<Option<Kept>> {
        let path = self.path(solver);
        let refused = |why: &str| {
            let help = "name another folder, or remove the file to begin anew";
            ExperimentError::Words(format!("cannot go on from {}: {why}\n  help: {help}", path.display()))
        };
        let bytes = match std::fs::read(&path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(refused(&e.to_string())),
        };
        let file: File = serde_json::from_slice(&bytes).map_err(|e| refused(&format!("it is damaged ({e})")))?;
        if file.digest != self.digest || file.solver != solver {
            return Err(refused("scene, size, blocks, seed or version are not those that it was made with"));
        }
        if file.program != self.program {
            return Err(refused("another build of the program made it, whose pictures may be others"));
        }
        if file.kept.parts.len() != 2 || !file.kept.parts.iter().all(|s| s.fits(areas)) {
            return Err(refused("it is damaged"));
        }
        Ok(Some(file.kept))
    }

    /// Keeps what there is of a solver.
    pub(super) fn write(&self, solver: &str, kept: Kept) -> Stopped<()> {
        let path = self.path(solver);
        let file = File { scene: self.scene.clone(), solver: solver.to_owned(), digest: self.digest, program: self.program, kept };
        let words = |e: &dyn std::fmt::Display| ExperimentError::Words(format!("cannot write {}: {e}", path.display()));
        let json = serde_json::to_vec(&file).map_err(|e| words(&e))?;
        etendue_image::write_atomically(&path, &json).map_err(|e| words(&e))
    }
}
