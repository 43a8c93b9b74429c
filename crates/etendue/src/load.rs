//! From a file, or the name of a built-in scene, to a compiled scene.

use crate::builtin;
use etendue_description::{Description, Diagnostics, nearest};
use etendue_formats::ReadOptions;
use etendue_scene::{CompileOptions, Scene};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What the caller changes about a scene.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Values for the file's `<default>` parameters.
    pub defines: Vec<(String, String)>,
    /// Film size, pixels.
    pub size: Option<[u32; 2]>,
    /// Film width, pixels; the height follows the file's aspect unless [`LoadOptions::height`] is given too.
    pub width: Option<u32>,
    /// Film height, pixels.
    pub height: Option<u32>,
}

/// A scene ready to be rendered.
#[derive(Debug)]
pub struct Loaded {
    /// Its name, for files that are named after it.
    pub name: String,
    /// Compiled.
    pub scene: Scene,
    /// As it was described.
    pub description: Description,
    /// Warnings and notes.
    pub diagnostics: Diagnostics,
    /// Time for reading files.
    pub read_time: Duration,
    /// Time for compiling: shapes, lights, acceleration structure.
    pub build_time: Duration,
    /// A digest of all scene texts and of the values given to them.
    pub digest: u64,
}

/// Why there is no scene.
#[derive(Debug)]
pub enum LoadError {
    /// Neither a file nor a built-in scene; holds the words to say so.
    NoSuchScene(String),
    /// The file has errors, each with its place.
    Scene(Description, Diagnostics),
}

impl std::fmt::Display for LoadError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoSuchScene(words) => f.write_str(words),
            Self::Scene(description, diagnostics) => f.write_str(&diagnostics.render(&description.sources)),
        }
    }
}

impl std::error::Error for LoadError {}

/// Loads a scene file, or the built-in scene of that name. Uses the rayon pool that the caller stands in.
pub fn load(scene: &str, options: &LoadOptions) -> Result<Loaded, LoadError> {
    let begun = Instant::now();
    let (name, (description, mut diagnostics)) = read(scene, options)?;
    let read_time = begun.elapsed();
    if diagnostics.has_errors() {
        return Err(LoadError::Scene(description, diagnostics));
    }
    let begun = Instant::now();
    let compile_options = CompileOptions { size: options.size, width: options.width, height: options.height };
    let Some(scene) = etendue_scene::compile(&description, &compile_options, &mut diagnostics) else {
        return Err(LoadError::Scene(description, diagnostics));
    };
    let digest = digest(&description, options);
    Ok(Loaded { name, scene, description, diagnostics, read_time, build_time: begun.elapsed(), digest })
}

fn read(scene: &str, options: &LoadOptions) -> Result<(String, (Description, Diagnostics)), LoadError> {
    let mut read_options = ReadOptions { defines: options.defines.clone(), ..ReadOptions::default() };
    let path = Path::new(scene);
    if let Some(built_in) = builtin::find(scene).filter(|_| !path.is_file()) {
        read_options.files = builtin::FILES.iter().map(|(path, bytes)| (PathBuf::from(path), bytes.to_vec())).collect();
        let read = etendue_formats::read_str(&format!("{scene}.xml"), built_in.text, &read_options);
        return Ok((scene.to_owned(), read));
    }
    if !path.exists() {
        return Err(LoadError::NoSuchScene(no_such_scene(scene)));
    }
    let name = path.file_stem().map_or("scene".to_owned(), |s| s.to_string_lossy().into_owned());
    Ok((name, etendue_formats::read(path, &read_options)))
}

fn no_such_scene(scene: &str) -> String {
    let names = || builtin::SCENES.iter().map(|s| s.name);
    let mut words = format!("no file and no built-in scene is called `{scene}`");
    if let Some(near) = nearest(scene, names()) {
        words += &format!("\n  help: did you mean `{near}`?");
    }
    words += &format!("\n  help: built-in scenes: {}", names().collect::<Vec<_>>().join(", "));
    words
}

/// FNV-1a over everything that decides the picture before the solver does.
fn digest(description: &Description, options: &LoadOptions) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    let mut eat = |bytes: &[u8]| {
        for byte in bytes.iter().chain(&[0xff]) {
            hash = (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    };
    for i in 0..description.sources.len() {
        eat(description.sources.text(etendue_description::SourceId(i as u32)).as_bytes());
    }
    for (name, value) in &options.defines {
        eat(name.as_bytes());
        eat(value.as_bytes());
    }
    eat(format!("{:?}{:?}{:?}", options.size, options.width, options.height).as_bytes());
    hash
}
