//! The files that objects name: meshes, grids and measured materials are noted, to be read; others are only found.

use super::Reader;
use crate::assets::Format;
use crate::files::plain;
use etendue_description::{Kind, NodeId, Spanned, Value};
use std::path::PathBuf;

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
            (Kind::Bsdf, "measured") => Some(Format::Measured),
            _ => None,
        };
        let Some(path) = self.find_file(&name, span, folders) else { return };
        self.description.nodes[id.0 as usize].params[at].value.value = Value::Path(path.clone());
        match format {
            Some(format) => self.wanted.note(path, format, id, span),
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
}
