//! The files of a render: looked at before it begins, written when it has ended.

use super::tonemap::ToneArguments;
use etendue::Rendering;
use etendue_image::{Format, ImageError, Picture, SaveOptions, save, write_atomically};
use std::io;
use std::path::{Path, PathBuf};

/// Whether new files can be made in a folder.
pub fn can_write_in(folder: &Path) -> io::Result<()> {
    let probe = folder.join(format!(".etendue-{}-probe.part", std::process::id()));
    std::fs::File::create_new(&probe)?;
    std::fs::remove_file(&probe)
}

/// Refuses, before anything is rendered, a file that could not be written after it.
pub fn writable(path: &Path) -> Result<(), String> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if path.is_dir() {
        return Err(format!("{}: there is a folder of this name", path.display()));
    }
    if !folder.is_dir() {
        return Err(format!("{}: the folder {} does not exist", path.display(), folder.display()));
    }
    // Pipes and devices are written to as they are.
    if path.exists() && !path.is_file() {
        return Ok(());
    }
    can_write_in(folder).map_err(|e| format!("{}: the folder {} cannot be written to: {e}", path.display(), folder.display()))
}

/// Writes a picture to each file. One that fails does not keep the others from being written; if no file holds the light itself in the
/// end, it is saved to the system's folder for temporary files: hours of rendering are not lost for a full disk.
pub fn write_pictures(files: &[PathBuf], tone: ToneArguments, rendering: &Rendering) -> Result<(), String> {
    let mut failures = Vec::new();
    let mut kept = false;
    for path in files {
        match write(path, &rendering.picture, tone) {
            Ok(()) => kept = true,
            Err(e) => failures.push(e.to_string()),
        }
    }
    if failures.is_empty() {
        return Ok(());
    }
    if !kept {
        let rescue = std::env::temp_dir().join(format!("etendue-{}.exr", std::process::id()));
        if save(&rescue, &rendering.picture, &SaveOptions::default()).is_ok() {
            failures.push(format!("  help: the picture was saved to {}", rescue.display()));
        }
    }
    Err(failures.join("\n"))
}

/// A picture as it is, or shown on a display, as the file's ending says.
fn write(path: &Path, picture: &Picture, tone: ToneArguments) -> Result<(), ImageError> {
    if Format::of_path(path).is_some_and(Format::is_linear) {
        return save(path, picture, &SaveOptions::default());
    }
    let shown = Picture { image: tone.map().image(&picture.image), layers: Vec::new(), attributes: picture.attributes.clone() };
    save(path, &shown, &SaveOptions::default())
}

/// Writes the picture of each light beside those files that hold no layers: NAME.LIGHT.png beside NAME.png.
pub fn write_lights(files: &[PathBuf], tone: ToneArguments, rendering: &Rendering) -> Result<(), String> {
    for path in files.iter().filter(|path| Format::of_path(path) != Some(Format::Exr)) {
        for light in &rendering.stats.lights {
            let Some(image) = rendering.picture.layer(&light.name) else { continue };
            let alone = Picture { image: image.clone(), layers: Vec::new(), attributes: rendering.picture.attributes.clone() };
            let ending = path.extension().unwrap_or_default().to_string_lossy().into_owned();
            write(&path.with_extension(format!("{}.{ending}", light.name)), &alone, tone).map_err(|e| e.to_string())?;
        }
    }
    Ok(())
}

/// Writes the numbers of the render.
pub fn write_stats(path: &Path, rendering: &Rendering) -> Result<(), String> {
    let json = serde_json::to_string_pretty(&rendering.stats).map_err(|e| e.to_string())? + "\n";
    write_atomically(path, json.as_bytes()).map_err(|e| format!("cannot write {}: {e}", path.display()))
}
