//! The meshes, grids and measured materials that a scene names: each file is read once, all of them in parallel, with the same result at any number of threads.

use crate::files::{Files, plain, reason};
use crate::mesh::{self, FileError, Loaded, Place};
use etendue_description::{Description, Diagnostics, GridData, MeasuredData, MeshData, NodeId, Span, Value};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The files to read, in the order in which the scene names them.
#[derive(Default)]
pub(crate) struct Wanted {
    list: Vec<Request>,
    known: BTreeMap<(PathBuf, Format), usize>,
}

/// A file and the parameters that name it.
struct Request {
    path: PathBuf,
    format: Format,
    users: Vec<(NodeId, Span)>,
}

/// How to read a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Format {
    Obj { flip_v: bool },
    Ply { flip_v: bool },
    Serialized { index: usize },
    Vol,
    Measured,
}

/// What a file held.
enum Content {
    Mesh(Loaded),
    Grid(GridData),
    Measured(MeasuredData),
}

impl Wanted {
    /// Notes that the parameter `filename` of `user`, written at `span`, names a file that is to be read.
    pub fn note(&mut self, path: PathBuf, format: Format, user: NodeId, span: Span) {
        let known = self.known.len();
        let at = *self.known.entry((plain(&path), format)).or_insert(known);
        if at == self.list.len() {
            self.list.push(Request { path, format, users: Vec::new() });
        }
        self.list[at].users.push((user, span));
    }

    /// Reads all files that were noted, and puts what they hold where it was named.
    pub fn load(self, files: Files, description: &mut Description, diagnostics: &mut Diagnostics) {
        let contents: Vec<Result<Content, Vec<FileError>>> = self.list.par_iter().map(|request| load(request, files)).collect();
        for (request, content) in self.list.into_iter().zip(contents) {
            let Some(&(_, first)) = request.users.first() else { continue };
            match content {
                Ok(Content::Mesh(loaded)) => {
                    for warning in loaded.warnings {
                        diagnostics.warning(first, format!("`{}`: {warning}", request.path.display()));
                    }
                    let i = description.assets.meshes.len() as u32;
                    description.assets.meshes.push(Arc::new(MeshData { path: request.path.clone(), ..loaded.mesh }));
                    request.hand_out(description, &Value::Mesh(i));
                }
                Ok(Content::Grid(grid)) => {
                    let i = description.assets.grids.len() as u32;
                    description.assets.grids.push(Arc::new(GridData { path: request.path.clone(), ..grid }));
                    request.hand_out(description, &Value::Grid(i));
                }
                Ok(Content::Measured(data)) => {
                    let i = description.assets.measured.len() as u32;
                    description.assets.measured.push(Arc::new(MeasuredData { path: request.path.clone(), ..data }));
                    request.hand_out(description, &Value::Measured(i));
                }
                Err(errors) => {
                    for error in errors {
                        tell(&request.path, first, error, description, diagnostics);
                    }
                }
            }
        }
    }
}

impl Request {
    /// Puts what was read where it was named.
    fn hand_out(&self, description: &mut Description, value: &Value) {
        for &(user, _) in &self.users {
            let params = &mut description.nodes[user.0 as usize].params;
            if let Some(param) = params.iter_mut().find(|p| p.name.value == "filename") {
                param.value.value = value.clone();
            }
        }
    }
}

fn tell(path: &Path, named: Span, error: FileError, description: &mut Description, diagnostics: &mut Diagnostics) {
    let FileError { message, place } = error;
    let path = path.display();
    match place {
        Place::File => {
            diagnostics.error(named, format!("`{path}`: {message}"));
        }
        Place::Byte(at) => {
            diagnostics.error(named, format!("`{path}`, byte {at}: {message}"));
        }
        Place::Line { number, text, word } => {
            let source = description.sources.add_excerpt(path.to_string(), text, number);
            let span = Span { source, start: word.start as u32, end: word.end as u32 };
            diagnostics.error(span, message).label(named, "the file is named here");
        }
    }
}

fn load(request: &Request, files: Files) -> Result<Content, Vec<FileError>> {
    let bytes = files.read(&request.path).map_err(|e| vec![FileError::file(format!("the file cannot be read: {}", reason(&e)))])?;
    match request.format {
        Format::Obj { flip_v } => mesh::obj::read(&bytes, flip_v).map(Content::Mesh),
        Format::Ply { flip_v } => mesh::ply::read(&bytes, flip_v).map(Content::Mesh),
        Format::Serialized { index } => mesh::serialized::read(&bytes, index).map(Content::Mesh),
        Format::Vol => mesh::vol::read(&bytes).map(Content::Grid),
        Format::Measured => crate::measured::read(&bytes).map(Content::Measured),
    }
}
