//! Finding and reading the files that a scene names.

use crate::ReadOptions;
use etendue_description::{Diagnostics, Span, nearest};
use std::borrow::Cow;
use std::io;
use std::path::{Component, Path, PathBuf};

/// Scene texts beyond this size are refused: places are told in 32 bits, and no scene of this world is so large.
pub(crate) const MAX_TEXT: u64 = 1 << 29;

/// Files that unpack to more than this many bytes are refused.
const MAX_UNPACKED: u64 = 1 << 32;

/// The files of the caller's map, then those of the disk.
#[derive(Clone, Copy)]
pub(crate) struct Files<'a> {
    pub options: &'a ReadOptions,
}

/// A file that is nowhere.
pub(crate) struct Missing {
    /// The folders that were searched.
    pub folders: Vec<PathBuf>,
    /// A file there with a name near the wanted one.
    pub near: Option<PathBuf>,
}

impl Files<'_> {
    /// The file `name` in the first of the folders that has it; where none has, the nearest name if `search` asks for it.
    pub fn resolve(&self, name: &str, folders: &[PathBuf], search: bool) -> Result<PathBuf, Missing> {
        // Scenes written on Windows name files with backslashes.
        let slashed = (!cfg!(windows) && name.contains('\\')).then(|| name.replace('\\', "/"));
        for name in std::iter::once(name).chain(slashed.as_deref()) {
            for folder in folders {
                let path = folder.join(name);
                if self.is_file(&path) {
                    return Ok(path);
                }
            }
        }
        let name = slashed.as_deref().unwrap_or(name);
        let near = folders.iter().filter(|_| search).find_map(|folder| self.near(&folder.join(name)));
        Err(Missing { folders: folders.to_vec(), near })
    }

    /// As [`Files::resolve`], with a message where there is none; nearest names are searched `searches` more times.
    pub fn find(
        &self,
        name: &str,
        span: Span,
        folders: &[PathBuf],
        searches: &mut usize,
        diagnostics: &mut Diagnostics,
    ) -> Option<PathBuf> {
        if name.trim().is_empty() {
            diagnostics.error(span, "a file name must stand here");
            return None;
        }
        match self.resolve(name, folders, *searches > 0) {
            Ok(path) => Some(path),
            Err(missing) => {
                *searches = searches.saturating_sub(1);
                let error = diagnostics.error(span, format!("there is no file `{name}`"));
                if let Some(near) = missing.near {
                    error.help(format!("did you mean `{}`?", near.display()));
                }
                error.help(searched(&missing.folders));
                None
            }
        }
    }

    /// The folder `name` below the first of the folders that has it.
    pub fn resolve_folder(&self, name: &str, folders: &[PathBuf]) -> Option<PathBuf> {
        let has = |path: &PathBuf| path.is_dir() || self.options.files.keys().any(|k| k.starts_with(plain(path)));
        folders.iter().map(|folder| folder.join(name)).find(has)
    }

    fn is_file(&self, path: &Path) -> bool {
        self.options.files.contains_key(&plain(path)) || path.is_file()
    }

    /// The bytes of a file; one whose name ends in `.gz` is unpacked.
    pub fn read(&self, path: &Path) -> io::Result<Cow<'_, [u8]>> {
        let bytes = match self.options.files.get(&plain(path)) {
            Some(bytes) => Cow::Borrowed(&**bytes),
            None => Cow::Owned(std::fs::read(path)?),
        };
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz")) { unpacked(&bytes).map(Cow::Owned) } else { Ok(bytes) }
    }

    /// As [`Files::read`], of a text of reasonable size.
    pub fn read_text(&self, path: &Path) -> Result<String, String> {
        let size = self.options.files.get(&plain(path)).map(|bytes| bytes.len() as u64);
        let size = size.or_else(|| std::fs::metadata(path).ok().map(|m| m.len())).unwrap_or(0);
        if size > MAX_TEXT {
            return Err(format!("it has {size} bytes, more than the {MAX_TEXT} of the largest text read here"));
        }
        let bytes = self.read(path).map_err(|e| reason(&e))?;
        if bytes.len() as u64 > MAX_TEXT {
            return Err(format!("it unpacks to {} bytes, more than the {MAX_TEXT} of the largest text read here", bytes.len()));
        }
        crate::encoding::decode(bytes.into_owned())
    }

    /// The path of a file in the folder of `wanted` whose name is near the wanted one.
    fn near(&self, wanted: &Path) -> Option<PathBuf> {
        const MANY: usize = 10_000;
        let folder = wanted.parent()?;
        let word = wanted.file_name()?.to_str()?;
        let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let on_disk = std::fs::read_dir(here).into_iter().flatten().take(MANY).flatten().map(|entry| entry.file_name());
        let mut names: Vec<String> = on_disk.filter_map(|name| name.into_string().ok()).collect();
        let plain_folder = plain(folder);
        let virtual_names = self.options.files.keys().filter(|k| k.parent() == Some(&plain_folder)).filter_map(|k| k.file_name());
        names.extend(virtual_names.filter_map(|name| name.to_str().map(str::to_owned)));
        names.sort();
        nearest(word, names.iter().map(String::as_str)).map(|name| folder.join(name))
    }
}

/// What gzip packed, of reasonable size: a few bytes may unpack to any number.
fn unpacked(bytes: &[u8]) -> io::Result<Vec<u8>> {
    use io::Read as _;
    let mut out = Vec::new();
    flate2::read::MultiGzDecoder::new(bytes).take(MAX_UNPACKED + 1).read_to_end(&mut out)?;
    if out.len() as u64 > MAX_UNPACKED {
        return Err(io::Error::other(format!("it unpacks to more than {MAX_UNPACKED} bytes")));
    }
    Ok(out)
}

/// Where was searched, in words.
pub(crate) fn searched(folders: &[PathBuf]) -> String {
    let names = folders
        .iter()
        .map(|f| if f.as_os_str().is_empty() { "the working folder".to_owned() } else { format!("`{}`", f.display()) });
    format!("looked in {}", names.collect::<Vec<_>>().join(", "))
}

/// Why a file cannot be read, in plain words.
pub(crate) fn reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file".to_owned(),
        io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
        io::ErrorKind::IsADirectory => "it is a folder".to_owned(),
        _ => error.to_string(),
    }
}

/// The path without `.` and `..`, as the caller's map has it.
pub(crate) fn plain(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if out.file_name().is_some() => {
                out.pop();
            }
            _ => out.push(component),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_become_plain() {
        assert_eq!(plain(Path::new("./a/../b/./c.obj")), Path::new("b/c.obj"));
        assert_eq!(plain(Path::new("../a")), Path::new("../a"));
    }

    #[test]
    fn backslashes_and_near_names() {
        let mut options = ReadOptions::default();
        options.files.insert("meshes/größe 箱.obj".into(), (*b"x").into());
        let files = Files { options: &options };
        let folders = [PathBuf::from("scenes/.."), PathBuf::from("scenes")];
        assert!(files.resolve("meshes/größe 箱.obj", &folders, false).is_ok());
        assert!(cfg!(windows) || files.resolve("meshes\\größe 箱.obj", &folders, false).is_ok());
        let missing = files.resolve("meshes/grösse 箱.obj", &folders, true).map_err(|m| m.near);
        assert_eq!(missing.unwrap_err(), Some(PathBuf::from("scenes/../meshes/größe 箱.obj")));
    }
}
