//! The files that objects name: meshes and grids are read, each once and all in parallel; others are only found.

use super::Reader;
use crate::files::{Files, plain, reason};
use crate::mesh::{self, FileError, Loaded, Place};
use etendue_description::{GridData, Kind, MeshData, NodeId, Span, Spanned, Value};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The files to read, in the order in which the scene names them.
#[derive(Default)]
pub(super) struct Wanted {
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
enum Format {
    Obj { flip_v: bool },
    Ply { flip_v: bool },
    Serialized { index: usize },
    Vol,
}

/// What a file held.
enum Content {
    Mesh(Loaded),
    Grid(GridData),
}

impl Reader<'_> {
    /// Finds the file that a node's `filename` names; one that is read here is noted for later.
    pub(super) fn file_parameter(&mut self, id: NodeId, folders: &[PathBuf]) {
        let node = self.description.node(id);
        if matches!(node.kind, Kind::Film | Kind::Integrator | Kind::Sampler | Kind::Filter) {
            return; // what these name is written, if anything
        }
        let Some(at) = node.params.iter().position(|p| p.name.value == "filename") else { return };
        let span = node.params[at].value.span;
        let Value::String(name) = &node.params[at].value.value else { return };
        let (name, kind, model) = (name.clone(), node.kind, node.model.value.clone());
        let format = match (kind, model.as_str()) {
            (Kind::Shape, "obj") => Some(Format::Obj { flip_v: self.flag(id, "flip_tex_coords", true) }),
            (Kind::Shape, "ply") => Some(Format::Ply { flip_v: self.flag(id, "flip_tex_coords", false) }),
            (Kind::Shape, "serialized") => Some(Format::Serialized { index: self.shape_index(id) }),
            (Kind::Shape, "sdfgrid") | (Kind::Volume, "gridvolume") => Some(Format::Vol),
            _ => None,
        };
        let Some(path) = self.find_file(&name, span, folders) else { return };
        self.description.nodes[id.0 as usize].params[at].value.value = Value::Path(path.clone());
        match format {
            Some(format) => {
                let known = self.wanted.known.len();
                let at = *self.wanted.known.entry((plain(&path), format)).or_insert(known);
                if at == self.wanted.list.len() {
                    self.wanted.list.push(Request { path, format, users: Vec::new() });
                }
                self.wanted.list[at].users.push((id, span));
            }
            None => {
                // Whoever opens the file later will not know the caller's map.
                if let Some(bytes) = self.files.options.files.get(&plain(&path)) {
                    self.description.assets.files.insert(path, bytes.clone());
                }
            }
        }
    }

    /// A truth value that decides how a file is read.
    fn flag(&mut self, id: NodeId, name: &str, default: bool) -> bool {
        let node = self.description.node(id);
        match node.params.iter().find(|p| p.name.value == name).map(|p| &p.value) {
            None => default,
            Some(Spanned { value: Value::Bool(b), .. }) => *b,
            Some(other) => {
                let text = format!("`{name}` of `{}` is a {}, expected a boolean", node.model.value, other.value.type_name());
                self.diagnostics.error(other.span, text);
                default
            }
        }
    }

    fn shape_index(&mut self, id: NodeId) -> usize {
        let node = self.description.node(id);
        match node.params.iter().find(|p| p.name.value == "shape_index").map(|p| &p.value) {
            None => 0,
            Some(Spanned { value: Value::Integer(i), .. }) if *i >= 0 => *i as usize,
            Some(other) => {
                self.diagnostics.error(other.span, "`shape_index` of `serialized` must be a whole number from 0");
                0
            }
        }
    }

    /// Reads all files that were noted.
    pub(super) fn load_assets(&mut self) {
        let wanted = std::mem::take(&mut self.wanted.list);
        let files = self.files;
        let contents: Vec<Result<Content, Vec<FileError>>> = wanted.par_iter().map(|request| load(request, files)).collect();
        for (request, content) in wanted.into_iter().zip(contents) {
            let Some(&(_, first)) = request.users.first() else { continue };
            match content {
                Ok(Content::Mesh(loaded)) => self.mesh(&request, loaded),
                Ok(Content::Grid(grid)) => {
                    let i = self.description.assets.grids.len() as u32;
                    self.description.assets.grids.push(Arc::new(GridData { path: request.path.clone(), ..grid }));
                    self.hand_out(&request, &Value::Grid(i));
                }
                Err(errors) => {
                    for error in errors {
                        self.tell(&request.path, first, error);
                    }
                }
            }
        }
    }

    fn mesh(&mut self, request: &Request, loaded: Loaded) {
        for warning in loaded.warnings {
            let at = request.users[0].1;
            self.diagnostics.warning(at, format!("`{}`: {warning}", request.path.display()));
        }
        let i = self.description.assets.meshes.len() as u32;
        self.description.assets.meshes.push(Arc::new(MeshData { path: request.path.clone(), ..loaded.mesh }));
        self.hand_out(request, &Value::Mesh(i));
    }

    /// Puts what was read where it was named.
    fn hand_out(&mut self, request: &Request, value: &Value) {
        for &(user, _) in &request.users {
            let params = &mut self.description.nodes[user.0 as usize].params;
            if let Some(param) = params.iter_mut().find(|p| p.name.value == "filename") {
                param.value.value = value.clone();
            }
        }
    }

    fn tell(&mut self, path: &Path, named: Span, error: FileError) {
        let FileError { message, place } = error;
        let path = path.display();
        match place {
            Place::File => {
                self.diagnostics.error(named, format!("`{path}`: {message}"));
            }
            Place::Byte(at) => {
                self.diagnostics.error(named, format!("`{path}`, byte {at}: {message}"));
            }
            Place::Line { number, text, word } => {
                let source = self.description.sources.add_excerpt(path.to_string(), text, number);
                let span = Span { source, start: word.start as u32, end: word.end as u32 };
                self.diagnostics.error(span, message).label(named, "the file is named here");
            }
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
    }
}
