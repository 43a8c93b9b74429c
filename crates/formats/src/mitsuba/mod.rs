//! Mitsuba scenes, version 2.x and 3.x.
//!
//! A scene file is a tree of objects (`<shape type="sphere">`), each with named values (`<float name="radius" value="2"/>`) and nested or
//! referenced objects. The reader follows the file from top to bottom, because `<default>` and `<path>` hold for what comes after them;
//! references are tied at the end, so that they may name what comes later. It knows the words of the format and none of the models: which
//! parameters a `sphere` has, the scene compiler decides.
//!
//! Beyond Mitsuba 3 it reads `<rgb value="#rrggbb">` (sRGB, 8 bits, made linear), `<blackbody name temperature scale>`, and aliases of what
//! comes later.
//!
//! Source: Mitsuba 3 documentation, "Scene XML file format".

mod assets;
mod attributes;
mod document;
mod names;
mod parameters;
mod spectrum;
mod text;
mod transform;
mod values;

pub(crate) use text::shortened;

use crate::assets::Wanted;
use crate::files::Files;
use crate::xml::{self, Document, ElementId};
use attributes::Attributes;
use etendue_description::{Description, Diagnostics, Kind, Node, NodeId, Param, SourceId, Span, Spanned, Value, nearest};
use parameters::Parameters;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Elements may be nested this deep over all files that include each other; a single file may [`xml::MAX_DEPTH`].
const MAX_DEPTH: usize = 192;

/// Unknown names beyond this number are told without the nearest known one.
const MAX_SEARCHES: usize = 50;

/// Elements that are not objects.
const OTHER_TAGS: [&str; 21] = [
    "scene",
    "boolean",
    "integer",
    "float",
    "string",
    "point",
    "vector",
    "rgb",
    "spectrum",
    "blackbody",
    "transform",
    "translate",
    "rotate",
    "scale",
    "lookat",
    "matrix",
    "ref",
    "include",
    "alias",
    "default",
    "path",
];

/// The kinds of objects.
const KINDS: [Kind; 12] = [
    Kind::Integrator,
    Kind::Sensor,
    Kind::Film,
    Kind::Filter,
    Kind::Sampler,
    Kind::Shape,
    Kind::Bsdf,
    Kind::Emitter,
    Kind::Texture,
    Kind::Medium,
    Kind::Phase,
    Kind::Volume,
];

/// Reads a scene from its text.
pub(crate) fn read(path: &Path, text: String, files: Files) -> (Description, Diagnostics) {
    let mut reader = Reader {
        files,
        description: Description::default(),
        diagnostics: Diagnostics::default(),
        parameters: Parameters::new(&files.options.defines),
        names: names::Names::default(),
        wanted: Wanted::default(),
        chain: Vec::new(),
        included: 0,
        searches: MAX_SEARCHES,
        depth: 0,
        broken: false,
    };
    if text.len() as u64 > crate::files::MAX_TEXT {
        reader.diagnostics.error(None, format!("`{}` has {} bytes, too many for a scene's text", path.display(), text.len()));
        return (reader.description, reader.diagnostics);
    }
    let source = reader.description.sources.add(path, text);
    let folders = reader.files.options.search_paths.clone();
    reader.file(source, folders, None);
    reader.finish()
}

/// The scene so far.
struct Reader<'a> {
    files: Files<'a>,
    description: Description,
    diagnostics: Diagnostics,
    parameters: Parameters,
    names: names::Names,
    wanted: Wanted,
    /// The files that are being read, each included by the one before.
    chain: Vec<PathBuf>,
    /// How many files were included.
    included: usize,
    /// How many more near names may be searched; each costs a look at all names.
    searches: usize,
    /// Nesting of elements over all of these.
    depth: usize,
    /// Whether parts of a file could not be read at all, so that what they would define is missing.
    broken: bool,
}

/// A file that is being read.
struct File {
    document: Document,
    text: Arc<str>,
    source: SourceId,
    /// Where to look for files, first to last.
    folders: Vec<PathBuf>,
}

impl File {
    fn span(&self, range: &Range<u32>) -> Span {
        Span { source: self.source, start: range.start, end: range.end }
    }

    fn name(&self, id: ElementId) -> &str {
        xml::slice(&self.text, &self.document.element(id).name)
    }

    fn name_span(&self, id: ElementId) -> Span {
        self.span(&self.document.element(id).name)
    }
}

/// Who gets what an element describes.
#[derive(Clone, Copy)]
enum Parent {
    Scene,
    Node(NodeId),
}

impl Reader<'_> {
    /// All elements inside another one.
    fn children(&mut self, file: &mut File, id: ElementId, parent: Parent) {
        if self.depth >= MAX_DEPTH {
            let text = format!("elements are nested more than {MAX_DEPTH} deep, over all included files");
            self.diagnostics.error(file.name_span(id), text);
            return;
        }
        self.depth += 1;
        let children: Vec<ElementId> = file.document.children(id).collect();
        for child in children {
            self.element(file, child, parent);
        }
        self.stray_text(file, id);
        self.depth -= 1;
    }

    fn element(&mut self, file: &mut File, id: ElementId, parent: Parent) {
        let attributes = Attributes::new(self, file, id);
        let name = attributes.element.clone();
        if let Some(kind) = KINDS.into_iter().find(|kind| kind.name() == name) {
            self.object(file, id, kind, attributes, parent, None);
            return;
        }
        if name == "spectrum" && attributes.has("type") {
            self.object(file, id, Kind::Texture, attributes, parent, None);
            return;
        }
        match name.as_str() {
            "include" => self.include(file, attributes, parent),
            "default" => self.default(attributes),
            "path" => self.search_path(file, attributes),
            "alias" => self.alias(attributes),
            "ref" => self.reference(attributes, parent),
            "transform" => self.transform(file, id, attributes, parent),
            "translate" | "rotate" | "scale" | "lookat" | "matrix" => {
                self.diagnostics.error(attributes.span, format!("`<{name}>` belongs inside a `<transform>`"));
                return;
            }
            "scene" => {
                self.diagnostics.error(attributes.span, "a `<scene>` cannot stand inside another element");
                return;
            }
            _ if OTHER_TAGS.contains(&name.as_str()) => self.value(file, attributes, parent),
            _ => {
                let known = OTHER_TAGS.into_iter().chain(KINDS.map(Kind::name));
                let error = self.diagnostics.error(attributes.span, format!("unknown element `<{name}>`"));
                if let Some(near) = nearest(&name, known) {
                    error.help(format!("did you mean `<{near}>`?"));
                }
                return;
            }
        }
        if name != "transform" {
            self.no_children(file, id);
        }
    }

    /// An object: its node, and everything inside.
    fn object(
        &mut self,
        file: &mut File,
        id: ElementId,
        kind: Kind,
        mut attributes: Attributes,
        parent: Parent,
        given_name: Option<Spanned<String>>,
    ) {
        let spanned = |text: text::Text| Spanned::new(text.value, text.span);
        let model = attributes.required("type").map(spanned);
        let node_id = attributes.optional("id").map(spanned);
        let name = attributes.optional("name").map(spanned);
        let tag = attributes.span;
        attributes.finish(self);

        let element = file.document.element(id);
        let span = file.span(&(element.tag.start..element.end));
        let model = model.unwrap_or_else(|| Spanned::new(String::new(), tag));
        let value_span = model.span;
        if model.value.is_empty() && value_span != tag {
            self.diagnostics.error(value_span, format!("a `<{}>` needs a type", kind.name()));
        }
        let node = self.description.add(Node { kind, model, id: node_id.clone(), params: Vec::new(), span });
        if let Some(node_id) = node_id {
            self.define(node_id, node);
        }
        let name = given_name.or(name).unwrap_or_else(|| Spanned::new(String::new(), tag));
        self.give(parent, Param { name, value: Spanned::new(Value::Node(node), value_span) });

        self.children(file, id, Parent::Node(node));
        self.check_doubles(node);
        self.file_parameter(node, &file.folders);
    }

    /// Hands a parameter to its owner; the scene takes objects only.
    fn give(&mut self, parent: Parent, param: Param) {
        match (parent, &param.value.value) {
            (Parent::Node(node), _) => self.description.nodes[node.0 as usize].params.push(param),
            (Parent::Scene, Value::Node(node)) => self.description.top.push(*node),
            (Parent::Scene, _) => {
                let text = format!("`{}` stands directly in the scene, which has no parameters", param.name.value);
                self.diagnostics.error(param.name.span, text).help("did it slip out of an object?");
            }
        }
    }

    /// A parameter may be given once.
    fn check_doubles(&mut self, node: NodeId) {
        let params = &self.description.node(node).params;
        let mut named: Vec<&Spanned<String>> = params.iter().map(|p| &p.name).filter(|name| !name.value.is_empty()).collect();
        named.sort_by(|a, b| a.value.cmp(&b.value));
        let doubles = named.windows(2).filter(|pair| pair[0].value == pair[1].value);
        let doubles: Vec<_> = doubles.map(|pair| (pair[0].span, pair[1].clone())).collect();
        for (first, second) in doubles {
            self.diagnostics
                .error(second.span, format!("parameter `{}` is given twice", second.value))
                .label(first, "first given here");
        }
    }

    /// Values have nothing inside.
    fn no_children(&mut self, file: &File, id: ElementId) {
        if let Some(child) = file.document.children(id).next() {
            let text = format!("`<{}>` cannot stand inside `<{}>`", file.name(child), file.name(id));
            self.diagnostics.error(file.name_span(child), text).help(format!("end `<{}>` with `/>`", file.name(id)));
        }
        self.stray_text(file, id);
    }

    fn stray_text(&mut self, file: &File, id: ElementId) {
        if let Some(range) = &file.document.element(id).stray_text {
            self.diagnostics
                .warning(file.span(range), format!("text inside `<{}>` means nothing", file.name(id)))
                .help("values stand in attributes: value=\"...\"");
        }
    }

    /// Ties what was left open, and loads the files.
    fn finish(mut self) -> (Description, Diagnostics) {
        self.resolve_references();
        self.fold_blackbodies();
        self.wanted.load(self.files, &mut self.description, &mut self.diagnostics);
        if !self.broken {
            self.parameters.finish(&mut self.diagnostics);
        }
        (self.description, self.diagnostics)
    }
}
