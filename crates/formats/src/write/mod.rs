//! Descriptions into files: Mitsuba 3 and pbrt-v4 scenes.
//!
//! [`write()`] makes the text of a scene, the files that must lie beside it, and says of each thing whether it was kept, approximated or
//! dropped. What a format cannot say is said by the nearest that it can; with [`WriteOptions::own_words`] a Mitsuba file keeps
//! étendue's own models instead, and then only étendue reads it. The same description gives the same bytes.
//!
//! Numbers are written so that they read back as the same ones. A mesh or picture that lies on the disk in a form that the target reads
//! alike is named by its path; other meshes become binary PLY, and pictures that must be made anew EXR.

mod areas;
mod beside;
mod constants;
mod layers;
mod look;
mod mitsuba;
mod notes;
mod pbrt;
mod pictures;
mod ply;
mod surroundings;
mod text;
mod uses;

pub use notes::{Fate, Note, Notes};

use etendue_description::Description;
use std::path::PathBuf;

/// The first words of a scene that étendue wrote.
pub const MARK: &str = "Written by étendue";

/// A format to write.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Target {
    /// Mitsuba 3, `.xml`.
    #[default]
    Mitsuba,
    /// pbrt-v4, `.pbrt`.
    Pbrt,
}

/// How to write a scene.
#[derive(Clone, Debug, Default)]
pub struct WriteOptions {
    /// The file that the text is meant for; paths are told from its folder.
    pub out: PathBuf,
    /// What the scene was read from, for a line at its head.
    pub source: String,
    /// Keep étendue's own models in Mitsuba files.
    pub own_words: bool,
    /// Copy all files that the scene names beside it.
    pub copy: bool,
}

/// A scene as text.
#[derive(Clone, Debug, Default)]
pub struct Written {
    /// The text.
    pub text: String,
    /// Files that belong beside it: path from the scene's folder, and bytes.
    pub files: Vec<(PathBuf, Vec<u8>)>,
    /// What became of each thing.
    pub notes: Notes,
}

/// Writes a description that compiles; fails in words where a file that must be read cannot be.
pub fn write(description: &Description, target: Target, options: &WriteOptions) -> Result<Written, String> {
    let mut beside = beside::Beside::new(options);
    let mut notes = Notes::default();
    let text = match target {
        Target::Mitsuba => mitsuba::write(description, options, &mut beside, &mut notes),
        Target::Pbrt => pbrt::write(description, options, &mut beside, &mut notes),
    };
    match beside.failed.first() {
        Some(why) => Err(why.clone()),
        None => Ok(Written { text, files: beside.files, notes }),
    }
}
