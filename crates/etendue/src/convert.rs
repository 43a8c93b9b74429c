//! A scene in another format, written beside nothing that is not ours.
//!
//! The text is written last, so that a scene which is there has all of its files. What is there already is replaced only where étendue wrote
//! it ([`MARK`] in its first line), or by force.

use crate::{LoadError, LoadOptions, Loaded, load};
use etendue_description::nearest;
use etendue_formats::write::{MARK, Notes, Target, WriteOptions, Written, write};
use std::path::{Path, PathBuf};

/// Where and how a scene is written.
#[derive(Clone, Debug, Default)]
pub struct ConvertOptions {
    /// The file.
    pub out: PathBuf,
    /// Its format; by the file's ending otherwise.
    pub target: Option<Target>,
    /// Keep étendue's own models in Mitsuba files.
    pub own_words: bool,
    /// Copy all files that the scene names.
    pub copy: bool,
    /// Replace files that étendue did not write.
    pub force: bool,
}

/// A scene that was written.
#[derive(Debug)]
pub struct Converted {
    /// The scene as it was read.
    pub loaded: Loaded,
    /// The format.
    pub target: Target,
    /// Every file, the scene's own first.
    pub files: Vec<PathBuf>,
    /// What became of each thing.
    pub notes: Notes,
}

/// Why no scene was written.
#[derive(Debug)]
pub enum ConvertError {
    /// It cannot be loaded.
    Load(LoadError),
    /// What was asked for makes no sense; holds the words to say so.
    Usage(String),
    /// A file cannot be read or written; holds the words to say so.
    File(String),
}

impl std::fmt::Display for ConvertError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Load(why) => why.fmt(f),
            Self::Usage(why) | Self::File(why) => f.write_str(why),
        }
    }
}

impl std::error::Error for ConvertError {}

/// The format of a name: that of a file's ending, or of `--to`.
pub fn target_named(word: &str) -> Option<Target> {
    match word {
        "xml" | "mitsuba" => Some(Target::Mitsuba),
        "pbrt" => Some(Target::Pbrt),
        _ => None,
    }
}

/// Loads a scene and writes it in another format.
pub fn convert(scene: &str, load_options: &LoadOptions, options: &ConvertOptions) -> Result<Converted, ConvertError> {
    let target = target_of(options)?;
    let out = &options.out;
    let same = |a: &Path, b: &Path| matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b);
    if same(Path::new(scene), out) {
        return Err(ConvertError::Usage(format!("{} would be written over itself: give it another name", out.display())));
    }
    let loaded = load(scene, load_options).map_err(ConvertError::Load)?;
    let write_options = WriteOptions {
        out: out.clone(),
        source: Path::new(scene).file_name().map_or_else(|| scene.to_owned(), |n| n.to_string_lossy().into_owned()),
        own_words: options.own_words,
        copy: options.copy,
    };
    let written = write(&loaded.description, target, &write_options).map_err(ConvertError::File)?;
    let files = place(&written, options)?;
    Ok(Converted { loaded, target, files, notes: written.notes })
}

fn target_of(options: &ConvertOptions) -> Result<Target, ConvertError> {
    if let Some(target) = options.target {
        return Ok(target);
    }
    let ending = options.out.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    target_named(&ending).ok_or_else(|| {
        let shown = options.out.display();
        let mut words = match ending.as_str() {
            "" => format!("`{shown}` has no ending to tell its format by"),
            _ => format!("`{shown}`: scenes ending in .{ending} are not written"),
        };
        if let Some(near) = nearest(&ending, ["xml", "pbrt"]) {
            words += &format!("\n  help: did you mean `.{near}`?");
        }
        ConvertError::Usage(
            words + "\n  help: Mitsuba 3 scenes end in .xml, pbrt-v4 scenes in .pbrt; --to names the format of any other name",
        )
    })
}

/// Writes all files, the scene's text last.
fn place(written: &Written, options: &ConvertOptions) -> Result<Vec<PathBuf>, ConvertError> {
    let folder = options.out.parent().unwrap_or(Path::new(""));
    let beside: Vec<(PathBuf, &[u8])> = written.files.iter().map(|(path, bytes)| (folder.join(path), bytes.as_slice())).collect();
    let ours = is_ours(&options.out);
    let foreign = |path: &Path, bytes: &[u8]| !ours && path.exists() && std::fs::read(path).is_ok_and(|there| there != bytes);
    let all =
        || std::iter::once((options.out.as_path(), written.text.as_bytes())).chain(beside.iter().map(|(p, b)| (p.as_path(), *b)));
    if let Some((path, _)) = all().find(|(path, bytes)| !options.force && foreign(path, bytes)) {
        let text = format!("{} is there already and étendue did not write it\n  help: --force replaces it", path.display());
        return Err(ConvertError::File(text));
    }
    for (path, bytes) in all().skip(1).chain(all().take(1)) {
        let failed = |e: std::io::Error| ConvertError::File(format!("cannot write {}: {e}", path.display()));
        if let Some(folder) = path.parent().filter(|f| path != options.out && !f.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder).map_err(failed)?;
        }
        etendue_image::write_atomically(path, bytes).map_err(failed)?;
    }
    Ok(all().map(|(path, _)| path.to_owned()).collect())
}

/// Whether étendue wrote a scene.
fn is_ours(path: &Path) -> bool {
    std::fs::read(path).is_ok_and(|bytes| {
        let head = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
        String::from_utf8_lossy(head).contains(MARK)
    })
}
