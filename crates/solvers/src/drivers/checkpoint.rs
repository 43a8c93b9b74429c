//! The state of a render between two passes, as bytes: the fields one after another, and a digest of them, so that a damaged file is not
//! taken for a picture.

use super::ledger::Ledger;
use crate::run::{Run, Stop};
use etendue_film::{Allocation, Film, Replicates, Sums};
use etendue_numerics::sequence::mix;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::{Mutex, PoisonError};

/// First bytes of a checkpoint's encoding, with its version.
const MAGIC: [u8; 8] = *b"etendue4";

/// Everything that a render needs to go on as if it had never stopped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    magic: [u8; 8],
    /// The solver's name.
    pub solver: String,
    /// What the scene and its settings boil down to.
    pub digest: u64,
    /// Seed.
    pub seed: u64,
    /// Whole passes done.
    pub passes: u32,
    planned: u32,
    noise_mode: bool,
    tiles: Vec<bool>,
    state: Vec<u8>,
    sums: Sums,
    replicates: Option<Replicates>,
    allocation: Option<Allocation>,
}

/// Why a checkpoint does not fit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CannotResume(pub String);

impl fmt::Display for CannotResume {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot resume: {}", self.0)
    }
}

impl std::error::Error for CannotResume {}

impl Checkpoint {
    #[expect(clippy::too_many_arguments, reason = "all that a render holds")]
    pub(super) fn take(
        name: &str,
        run: &Run<'_>,
        passes: u32,
        state: &impl Serialize,
        film: &Film,
        tiles: &Ledger,
        replicates: Option<&Mutex<Replicates>>,
        allocation: Option<&Allocation>,
    ) -> Self {
        Self {
            magic: MAGIC,
            solver: name.to_owned(),
            digest: run.digest,
            seed: run.seed,
            passes,
            planned: run.planned_samples(),
            noise_mode: matches!(run.stop, Stop::Noise { .. }),
            tiles: tiles.to_bools(),
            state: postcard::to_stdvec(state).unwrap_or_default(),
            sums: film.sums(),
            replicates: replicates.map(|r| r.lock().unwrap_or_else(PoisonError::into_inner).clone()),
            allocation: allocation.cloned(),
        }
    }

    /// Whether this checkpoint belongs to such a render.
    pub(super) fn check(&self, name: &str, run: &Run<'_>, film: &Film, adaptive: bool) -> Result<(), CannotResume> {
        let differs = |what: &str, theirs: String, ours: String| {
            Err(CannotResume(format!("the checkpoint was made with {what} {theirs}, this render has {ours}")))
        };
        if self.solver != name {
            return differs("solver", self.solver.clone(), name.to_owned());
        }
        if self.seed != run.seed {
            return differs("seed", self.seed.to_string(), run.seed.to_string());
        }
        if self.digest != run.digest {
            return Err(CannotResume("the scene or its settings have changed since the checkpoint was made".to_owned()));
        }
        if self.noise_mode != matches!(run.stop, Stop::Noise { .. }) {
            return Err(CannotResume("of the two renders one has a noise target and the other has none".to_owned()));
        }
        let spread = |adaptive| if adaptive { "an adaptive spread" } else { "a uniform spread" };
        if self.allocation.is_some() != adaptive {
            return differs("a noise target and", spread(!adaptive).to_owned(), spread(adaptive).to_owned());
        }
        if self.planned != run.planned_samples() {
            return differs("a sample count of", self.planned.to_string(), run.planned_samples().to_string());
        }
        if self.sums.size() != film.shape().size {
            return differs("size", format!("{:?}", self.sums.size()), format!("{:?}", film.shape().size));
        }
        Ok(())
    }

    pub(super) fn restore<S: DeserializeOwned>(
        &self,
        film: &Film,
        tiles: &Ledger,
        replicates: Option<&Mutex<Replicates>>,
        allocation: &mut Option<Allocation>,
    ) -> Result<S, CannotResume> {
        let damaged = || CannotResume("the checkpoint is damaged".to_owned());
        let state = postcard::from_bytes(&self.state).map_err(|_| damaged())?;
        let ours = replicates.map(|r| r.lock().unwrap_or_else(PoisonError::into_inner));
        let replicates_fit = match (&ours, &self.replicates) {
            (Some(ours), Some(theirs)) => theirs.fits(ours),
            (None, None) => true,
            _ => false,
        };
        let allocation_fits = self.allocation.as_ref().is_none_or(|a| a.fits(film.shape().size));
        if self.tiles.len() != tiles.len() || !replicates_fit || !allocation_fits || !film.merge(&self.sums) {
            return Err(damaged());
        }
        tiles.set(&self.tiles);
        if let (Some(mut ours), Some(theirs)) = (ours, &self.replicates) {
            ours.clone_from(theirs);
        }
        allocation.clone_from(&self.allocation);
        Ok(state)
    }

    /// The checkpoint as bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        // Plain data has no way to fail; an empty answer would be refused when it is read.
        let mut bytes = postcard::to_stdvec(self).unwrap_or_default();
        bytes.extend(digest(&bytes).to_le_bytes());
        bytes
    }

    /// The checkpoint of bytes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, CannotResume> {
        if !bytes.starts_with(&MAGIC) {
            return Err(CannotResume("the file is no checkpoint of this version".to_owned()));
        }
        let damaged = || CannotResume("the checkpoint is damaged".to_owned());
        let (fields, told) = bytes.split_last_chunk().ok_or_else(damaged)?;
        if digest(fields) != u64::from_le_bytes(*told) {
            return Err(damaged());
        }
        postcard::from_bytes(fields).map_err(|_| damaged())
    }
}

/// A digest of bytes that no single change leaves as it is.
fn digest(bytes: &[u8]) -> u64 {
    let word = |chunk: &[u8]| chunk.iter().rev().fold(0, |w, b| w << 8 | u64::from(*b));
    bytes.chunks(8).fold(bytes.len() as u64, |h, chunk| mix(h ^ word(chunk)))
}
