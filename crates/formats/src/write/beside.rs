//! The files beside a scene's text: those that are there already are named by their path from the scene's folder, others are written into a
//! folder of the scene's name.

use super::WriteOptions;
use crate::files::plain;
use etendue_description::{Description, MeshData};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

/// The files of a scene that is being written.
pub(super) struct Beside<'a> {
    options: &'a WriteOptions,
    /// The folder for new files, from the scene's own.
    folder: String,
    /// Names in it, in small letters, since some disks know no others.
    taken: BTreeSet<String>,
    known: BTreeMap<String, String>,
    /// New files, from the scene's folder.
    pub files: Vec<(PathBuf, Vec<u8>)>,
    /// Files that could not be read.
    pub failed: Vec<String>,
}

impl<'a> Beside<'a> {
    pub fn new(options: &'a WriteOptions) -> Self {
        let name = options.out.file_name().map_or("scene".into(), |s| s.to_string_lossy().into_owned());
        Self {
            options,
            folder: format!("{name}-files"),
            taken: BTreeSet::new(),
            known: BTreeMap::new(),
            files: Vec::new(),
            failed: Vec::new(),
        }
    }

    /// How the scene names a file: by its path, or by that of its copy where it lies on no disk or copies are wanted.
    pub fn refer(&mut self, d: &Description, path: &Path) -> String {
        let key = plain(path).to_string_lossy().into_owned();
        if let Some(known) = self.known.get(&key) {
            return known.clone();
        }
        let carried = d.assets.files.get(path).or_else(|| d.assets.files.get(&plain(path)));
        let name = match (carried, self.options.copy) {
            (Some(bytes), _) => self.add(&file_name(path), bytes.to_vec()),
            (None, false) => relative(path, self.scene_folder()),
            (None, true) => match std::fs::read(path) {
                Ok(bytes) => self.add(&file_name(path), bytes),
                Err(why) => {
                    self.failed.push(format!("`{}` cannot be read: {why}", path.display()));
                    relative(path, self.scene_folder())
                }
            },
        };
        self.known.insert(key, name.clone());
        name
    }

    /// Whether a file lies on the disk, where others can read it.
    pub fn is_on_disk(path: &Path) -> bool {
        !path.as_os_str().is_empty() && path.is_file()
    }

    /// A new file; the answer is how the scene names it.
    pub fn add(&mut self, name: &str, bytes: Vec<u8>) -> String {
        let (stem, ending) = name.rsplit_once('.').unwrap_or((name, ""));
        let dot = if ending.is_empty() { "" } else { "." };
        let mut free = name.to_owned();
        let mut n = 2;
        while !self.taken.insert(free.to_lowercase()) {
            free = format!("{stem}-{n}{dot}{ending}");
            n += 1;
        }
        let path = format!("{}/{free}", self.folder);
        self.files.push((PathBuf::from(&path), bytes));
        path
    }

    /// A new file that is made once for `key`.
    pub fn once(&mut self, key: String, name: &str, make: impl FnOnce() -> Vec<u8>) -> String {
        if let Some(known) = self.known.get(&key) {
            return known.clone();
        }
        let path = self.add(name, make());
        self.known.insert(key, path.clone());
        path
    }

    /// A mesh as a file of its own, named after the file that it came from; `variant` tells apart what was made of one mesh.
    pub fn mesh(&mut self, index: u32, variant: &str, mesh: &MeshData) -> String {
        let stem = mesh.path.file_stem().map_or_else(|| format!("mesh-{index}"), |s| s.to_string_lossy().into_owned());
        self.once(format!("mesh {index} {variant}"), &format!("{stem}.ply"), || super::ply::bytes(mesh))
    }

    fn scene_folder(&self) -> &Path {
        self.options.out.parent().unwrap_or(Path::new(""))
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().map_or("file".to_owned(), |n| n.to_string_lossy().into_owned())
}

/// `path` as seen from `folder`, with slashes; as it is where there is no way from the one to the other.
fn relative(path: &Path, folder: &Path) -> String {
    let whole = |p: &Path| {
        let p = if p.as_os_str().is_empty() { Path::new(".") } else { p };
        p.canonicalize().or_else(|_| std::path::absolute(p)).map_or_else(|_| p.to_owned(), |p| plain(&p))
    };
    let (path, folder) = (whole(path), whole(folder));
    let (a, b): (Vec<Component>, Vec<Component>) = (path.components().collect(), folder.components().collect());
    let common = a.iter().zip(&b).take_while(|(x, y)| x == y).count();
    if common == 0 {
        return path.to_string_lossy().into_owned();
    }
    let up = std::iter::repeat_n("..".to_owned(), b.len() - common);
    let down = a[common..].iter().map(|c| c.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_told_from_the_scenes_folder() {
        assert_eq!(relative(Path::new("/a/b/c.ply"), Path::new("/a/d/e")), "../../b/c.ply");
        assert_eq!(relative(Path::new("/a/b/c.ply"), Path::new("/a/b")), "c.ply");
    }

    #[test]
    fn names_are_told_apart_whatever_their_case() {
        let options = WriteOptions { out: "x/scene.xml".into(), ..WriteOptions::default() };
        let mut beside = Beside::new(&options);
        let names = ["A.png", "a.png", "A.png", "b"].map(|name| beside.add(name, Vec::new()));
        assert_eq!(names, ["A.png", "a-2.png", "A-3.png", "b"].map(|name| format!("scene.xml-files/{name}")));
    }
}
