//! From a file, or the name of a built-in scene, to a compiled scene.

use crate::render::RenderError;
use crate::{bare_mesh, builtin, digest, mistakes, pool};
use etendue_description::{Description, Diagnostics, Dialect, nearest};
use etendue_formats::ReadOptions;
use etendue_scene::{CompileOptions, Scene};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What the caller changes about a scene.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Values for the file's `<default>` parameters.
    pub defines: Vec<(String, String)>,
    /// Film width, pixels; the height follows the file's aspect unless [`LoadOptions::height`] is given too.
    pub width: Option<u32>,
    /// Film height, pixels.
    pub height: Option<u32>,
    /// Whether walks carry wavelengths instead of linear Rec.709; as the file's format has it otherwise.
    pub spectral: Option<bool>,
    /// Threads for reading and building; all cores otherwise. The scene is the same for any number.
    pub threads: Option<usize>,
    /// Whether a plain `.obj` or `.ply` is a scene: its facets, flat, with a front by their winding, grey; each group of an OBJ a shape.
    pub bare_meshes: bool,
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
    options: LoadOptions,
}

impl Loaded {
    /// A digest of all scene texts, of the files that they name, and of the values given to them.
    pub fn digest(&self) -> u64 {
        digest::scene(&self.description, &self.options)
    }
}

/// Why there is no scene.
#[derive(Debug)]
pub enum LoadError {
    /// Neither a file nor a built-in scene; holds the words to say so.
    NoSuchScene(String),
    /// There are no threads to load it with.
    NoThreads(RenderError),
    /// The file has errors, each with its place.
    Scene(Box<(Description, Diagnostics)>),
}

impl std::fmt::Display for LoadError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoSuchScene(words) => f.write_str(words),
            Self::NoThreads(why) => why.fmt(f),
            Self::Scene(told) => f.write_str(&told.1.render(&told.0.sources)),
        }
    }
}

impl std::error::Error for LoadError {}

/// Loads a scene file, or the built-in scene of that name.
pub fn load(scene: &str, options: &LoadOptions) -> Result<Loaded, LoadError> {
    let pool = pool::pool(options.threads).map_err(LoadError::NoThreads)?;
    pool.install(|| load_here(scene, options))
}

fn load_here(scene: &str, options: &LoadOptions) -> Result<Loaded, LoadError> {
    let begun = Instant::now();
    let (name, (description, mut diagnostics)) = read(scene, options)?;
    let read_time = begun.elapsed();
    let compile_options = CompileOptions {
        size: None,
        width: options.width,
        height: options.height,
        spectral: options.spectral.unwrap_or(description.dialect == Dialect::Pbrt),
    };
    if diagnostics.has_errors() {
        mistakes::add_those_of_the_compiler(&description, &compile_options, &mut diagnostics);
        return Err(LoadError::Scene(Box::new((description, diagnostics))));
    }
    let begun = Instant::now();
    let Some(scene) = etendue_scene::compile(&description, &compile_options, &mut diagnostics) else {
        return Err(LoadError::Scene(Box::new((description, diagnostics))));
    };
    Ok(Loaded { name, scene, description, diagnostics, read_time, build_time: begun.elapsed(), options: options.clone() })
}

fn read(scene: &str, options: &LoadOptions) -> Result<(String, (Description, Diagnostics)), LoadError> {
    let mut read_options = ReadOptions { defines: options.defines.clone(), ..ReadOptions::default() };
    let path = Path::new(scene);
    if let Some(built_in) = builtin::find(scene).filter(|_| !path.is_file()) {
        read_options.files = builtin::FILES.iter().map(|(path, bytes)| (PathBuf::from(path), Arc::from(*bytes))).collect();
        let read = etendue_formats::read_str(&format!("{scene}.xml"), built_in.text, &read_options);
        return Ok((scene.to_owned(), read));
    }
    if !path.exists() {
        return Err(LoadError::NoSuchScene(no_such_scene(scene)));
    }
    let name = path.file_stem().map_or("scene".to_owned(), |s| s.to_string_lossy().into_owned());
    if options.bare_meshes
        && let Some(text) = bare_mesh::text(path)
    {
        let mut read = etendue_formats::read_str(scene, &text, &read_options);
        bare_mesh::split(&mut read.0);
        return Ok((name, read));
    }
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
