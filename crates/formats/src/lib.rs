//! Files into descriptions: Mitsuba 3 and pbrt-v4 scenes, and the meshes and grids that they name.
//!
//! [`read`] takes a scene file and gives its [`Description`] and everything that should be said about it. It never panics on what a file
//! holds, goes on after a mistake so that all of them are told in one go, and reads meshes in parallel on the caller's thread pool
//! with the same result at any number of threads. A description that comes with errors is incomplete and must not be rendered.
//!
//! | format | what | where |
//! | --- | --- | --- |
//! | `.xml` | Mitsuba scenes, version 2.x and 3.x | `mitsuba` |
//! | `.pbrt`, `.pbrt.gz` | pbrt-v4 scenes | `pbrt` |
//! | `.obj`, `.ply`, `.serialized` | triangle meshes that a scene names | [`mesh`] |
//! | `.vol` | voxel grids that a scene names | [`mesh::vol`] |
//! | `.bsdf` | measured materials that a scene names | [`measured`] |
//! | `.spd` | spectra that a scene names | `spd` |
//!
//! [`mod@write`] goes the other way, from a description to Mitsuba's and pbrt's texts.
//!
//! Scenes, their includes and meshes may be packed by gzip; their names then end in `.gz`.

mod assets;
mod encoding;
mod files;
pub mod measured;
pub mod mesh;
mod mitsuba;
mod pbrt;
mod spd;
mod tensor;
pub mod write;
pub mod xml;

use etendue_description::{Description, Diagnostics};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How to read a scene.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// Values for the scene's parameters (`$name`), before its own defaults; of two with one name the latter counts.
    pub defines: Vec<(String, String)>,
    /// Folders to search for files, after those that the scene names and the scene's own.
    pub search_paths: Vec<PathBuf>,
    /// Files that lie on no disk, by path; they are found before those that do. Paths are relative to the working folder.
    pub files: BTreeMap<PathBuf, Arc<[u8]>>,
}

/// Reads the scene file at `path`; the name's ending tells the format.
pub fn read(path: &Path, options: &ReadOptions) -> (Description, Diagnostics) {
    let mut diagnostics = Diagnostics::default();
    if !check_ending(path, &mut diagnostics) {
        return (Description::default(), diagnostics);
    }
    let files = files::Files { options };
    match files.read_text(path) {
        Ok(text) => dispatch(path, text, files),
        Err(why) => {
            let error = diagnostics.error(None, format!("`{}` cannot be read: {why}", path.display()));
            let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
            let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
            if !path.exists()
                && let Err(missing) = files.resolve(&name, &[folder], true)
                && let Some(near) = missing.near
            {
                error.help(format!("did you mean `{}`?", near.display()));
            }
            (Description::default(), diagnostics)
        }
    }
}

/// Reads a scene from a text. `name` is its path in messages, and the files that it names are looked for in the folder of `name`, first
/// among [`ReadOptions::files`].
pub fn read_str(name: &str, text: &str, options: &ReadOptions) -> (Description, Diagnostics) {
    dispatch(Path::new(name), text.to_owned(), files::Files { options })
}

/// Reads a text by the reader of its name's ending.
fn dispatch(path: &Path, text: String, files: files::Files) -> (Description, Diagnostics) {
    if ending(path) == "pbrt" { pbrt::read(path, text, files) } else { mitsuba::read(path, text, files) }
}

/// The ending of a file's name in small letters, without a `.gz` behind it.
fn ending(path: &Path) -> String {
    let ending = |path: &Path| path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    match ending(path).as_str() {
        "gz" => ending(&path.with_extension("")),
        other => other.to_owned(),
    }
}

/// Whether the ending is that of a scene file; says what else it is if not.
fn check_ending(path: &Path, diagnostics: &mut Diagnostics) -> bool {
    let ending = ending(path);
    let shown = path.display();
    match ending.as_str() {
        "xml" | "pbrt" => return true,
        "gltf" | "glb" => {
            diagnostics
                .error(None, format!("`{shown}`: glTF scenes are not read yet"))
                .help("Mitsuba 3 scenes (.xml) and pbrt-v4 scenes (.pbrt) are");
        }
        "obj" | "ply" | "serialized" => {
            diagnostics.error(None, format!("`{shown}` is a mesh without a scene around it")).help(format!(
                "name it in a scene: <shape type=\"{ending}\"><string name=\"filename\" value=\"{shown}\"/></shape>"
            ));
        }
        "" => {
            diagnostics
                .error(None, format!("`{shown}` has no ending to tell its format by"))
                .help("Mitsuba 3 scenes end in .xml, pbrt-v4 scenes in .pbrt");
        }
        _ => {
            diagnostics
                .error(None, format!("`{shown}`: files ending in .{ending} are no scenes that étendue reads"))
                .help("Mitsuba 3 scenes end in .xml, pbrt-v4 scenes in .pbrt");
        }
    }
    false
}
