//! Files that are there whole or not at all: written under another name in the same folder, flushed to the disk, and
//! moved into place [POSIX.1-2024, rename]. A crash leaves the old file as it was.

use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Tells apart the files that this process is writing.
static COUNT: AtomicU32 = AtomicU32::new(0);

/// Puts `bytes` at `path`, replacing what was there.
///
/// A symbolic link is followed, and something that is no file (a pipe, a device) is written to directly.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    match fs::metadata(&target) {
        Ok(meta) if meta.is_dir() => return Err(io::Error::new(io::ErrorKind::IsADirectory, "there is a folder of this name")),
        Ok(meta) if !meta.is_file() => return OpenOptions::new().write(true).open(&target)?.write_all(bytes),
        Ok(meta) if meta.permissions().readonly() => {
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, "the file there is read-only"));
        }
        _ => {}
    }
    let folder = match target.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let mut partial = Partial::create(folder)?;
    partial.fill(bytes)?;
    fs::rename(&partial.path, &target)?;
    partial.placed = true;
    sync_folder(folder);
    Ok(())
}

/// A file on its way, removed if it does not arrive.
struct Partial {
    path: PathBuf,
    file: fs::File,
    placed: bool,
}

impl Partial {
    /// A new, empty, hidden file. Its name does not build on the target's, which may be as long as names can be.
    fn create(folder: &Path) -> io::Result<Self> {
        loop {
            let n = COUNT.fetch_add(1, Ordering::Relaxed);
            let path = folder.join(format!(".etendue-{}-{n}.part", std::process::id()));
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok(Partial { path, file, placed: false }),
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err(e),
            }
        }
    }

    /// All bytes, down to the disk.
    fn fill(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all(bytes)?;
        self.file.sync_all()
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        if !self.placed {
            // Nothing better can be done about a file that will not go.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Makes the new name itself last. Not every system lets folders be flushed; the picture is complete all the same.
fn sync_folder(folder: &Path) {
    if cfg!(unix)
        && let Ok(folder) = fs::File::open(folder)
    {
        let _ = folder.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_content_gives_way_and_nothing_is_left_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("zwei Wörter 画像.txt");
        write_atomically(&path, b"old and long").unwrap();
        write_atomically(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn failures_leave_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        assert!(write_atomically(&folder.path().join("missing/a"), b"x").is_err());
        let inner = folder.path().join("inner");
        fs::create_dir(&inner).unwrap();
        assert!(write_atomically(&inner, b"x").is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        let long = "l".repeat(251) + ".exr";
        write_atomically(&folder.path().join(long), b"x").unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed() {
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        fs::write(&real, b"old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        write_atomically(&link, b"new").unwrap();
        assert_eq!(fs::read(&real).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    }
}
