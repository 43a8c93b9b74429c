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
mod names;
mod parameters;
mod spectrum;
mod text;
mod transform;
mod values;

use crate::files::{Files, plain};
use crate::xml::{self, Document, ElementId};
use attributes::Attributes;
use etendue_description::{Description, Diagnostics, Kind, Node, NodeId, Param, SourceId, Span, Spanned, Value, nearest};
use parameters::Parameters;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Elements may be nested this deep over all files that include each other; a single file may [`xml::MAX_DEPTH`].
const MAX_DEPTH: usize = 192;

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
        wanted: assets::Wanted::default(),
        chain: Vec::new(),
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
    wanted: assets::Wanted,
    /// The files that are being read, each included by the one before.
    chain: Vec<PathBuf>,
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

/// An `<include>` that a file was named by: who gets its content, and the name for a single object.
struct Include {
    parent: Parent,
    name: Option<Spanned<String>>,
}

impl Reader<'_> {
    /// A whole file: a `<scene>`, or, where it is included, a single object.
    fn file(&mut self, source: SourceId, mut folders: Vec<PathBuf>, include: Option<Include>) {
        let path = self.description.sources.path(source).to_path_buf();
        folders.insert(0, path.parent().map(Path::to_path_buf).unwrap_or_default());
        let text = self.description.sources.shared_text(source);
        let before = self.diagnostics.count(etendue_description::Severity::Error);
        let document = xml::parse(source, &text, &mut self.diagnostics);
        self.broken |= self.diagnostics.count(etendue_description::Severity::Error) > before;
        let mut file = File { document, text, source, folders };
        let Some(root) = file.document.root() else { return };

        let name = file.name(root).to_owned();
        let kind = KINDS.into_iter().find(|kind| kind.name() == name);
        let parent = include.as_ref().map_or(Parent::Scene, |include| include.parent);
        self.chain.push(plain(&path));
        if name == "scene" {
            let mut attributes = Attributes::new(self, &file, root);
            let version = attributes.required("version");
            for ignored in ["type", "id", "name"] {
                attributes.optional(ignored);
            }
            attributes.finish(self);
            if version.is_none_or(|version| self.version(&version)) {
                self.children(&mut file, root, parent);
            }
        } else if let (Some(kind), Some(include)) = (kind, include) {
            let mut attributes = Attributes::new(self, &file, root);
            let version = attributes.required("version");
            if version.is_none_or(|version| self.version(&version)) {
                self.object(&mut file, root, kind, attributes, parent, include.name);
            }
        } else {
            self.diagnostics
                .error(file.name_span(root), format!("the outermost element is `<{name}>`, expected `<scene>`"))
                .help("a scene file begins with <scene version=\"3.0.0\">");
        }
        self.chain.pop();
    }

    /// Whether a file of this version is read here; says why not.
    fn version(&mut self, version: &text::Text) -> bool {
        let (word, _) = version.trimmed();
        let parts: Option<Vec<u32>> = word.split('.').map(|part| part.parse().ok()).collect();
        match parts.as_deref() {
            Some([major, ..]) if parts.as_ref().is_some_and(|p| p.len() <= 3) => {
                if *major < 2 {
                    self.diagnostics
                        .error(
                            version.span,
                            format!("version {word} is that of Mitsuba 0.5 and 0.6, which are not read; 2.0.0 and later are"),
                        )
                        .help("upgrade the file: names such as `toWorld` become `to_world`, and the version 3.0.0")
                        .help("Mitsuba 3 does most of it: mitsuba.parser.parse_file, transform_upgrade, write_file");
                    self.broken = true;
                    return false;
                }
                if *major > 3 {
                    self.diagnostics.warning(version.span, format!("version {word} is not known, read as 3.0.0"));
                }
                true
            }
            _ => {
                version.mistake(&mut self.diagnostics, format!("`{word}` is no version, expected such as 3.0.0"));
                true
            }
        }
    }

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

    fn include(&mut self, file: &File, mut attributes: Attributes, parent: Parent) {
        let filename = attributes.required("filename");
        let name = attributes.optional("name").map(|text| Spanned::new(text.value, text.span));
        attributes.finish(self);
        let Some(filename) = filename else { return };
        let Some(path) = self.find_file(&filename.value, filename.span, &file.folders) else {
            self.broken = true;
            return;
        };
        if self.chain.contains(&plain(&path)) {
            let chain = self.chain.iter().map(|p| format!("`{}`", p.display())).chain([format!("`{}`", path.display())]);
            let chain = chain.collect::<Vec<_>>().join(", which includes ");
            self.diagnostics.error(filename.span, format!("`{}` includes itself", filename.value)).help(chain);
            return;
        }
        match self.files.read_text(&path) {
            Ok(text) => {
                let source = self.description.sources.add_included(path, text, filename.span);
                self.file(source, file.folders.clone(), Some(Include { parent, name }));
            }
            Err(why) => {
                self.diagnostics.error(filename.span, format!("`{}` cannot be read: {why}", path.display()));
                self.broken = true;
            }
        }
    }

    fn default(&mut self, mut attributes: Attributes) {
        let (name, value) = (attributes.required("name"), attributes.required("value"));
        attributes.finish(self);
        if let (Some(name), Some(value)) = (name, value) {
            if name.value.is_empty() {
                name.mistake(&mut self.diagnostics, "a parameter needs a name".to_owned());
                return;
            }
            self.parameters.set_default(name.value, value.value);
        }
    }

    fn search_path(&mut self, file: &mut File, mut attributes: Attributes) {
        let value = attributes.required("value");
        attributes.finish(self);
        let Some(value) = value else { return };
        match self.files.resolve_folder(&value.value, &file.folders) {
            Some(folder) => file.folders.insert(0, folder),
            None => {
                let searched = searched(&file.folders);
                value.mistake(&mut self.diagnostics, format!("there is no folder `{}`", value.value)).help(searched);
            }
        }
    }

    /// The path of a file, or a message that names the folders searched and the nearest name there.
    fn find_file(&mut self, name: &str, span: Span, folders: &[PathBuf]) -> Option<PathBuf> {
        if name.trim().is_empty() {
            self.diagnostics.error(span, "a file name must stand here");
            return None;
        }
        match self.files.resolve(name, folders) {
            Ok(path) => Some(path),
            Err(missing) => {
                let error = self.diagnostics.error(span, format!("there is no file `{name}`"));
                if let Some(near) = missing.near {
                    error.help(format!("did you mean `{}`?", near.display()));
                }
                error.help(searched(&missing.folders));
                None
            }
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
        self.load_assets();
        if !self.broken {
            self.parameters.finish(&mut self.diagnostics);
        }
        (self.description, self.diagnostics)
    }
}

fn searched(folders: &[PathBuf]) -> String {
    let names = folders
        .iter()
        .map(|f| if f.as_os_str().is_empty() { "the working folder".to_owned() } else { format!("`{}`", f.display()) });
    format!("looked in {}", names.collect::<Vec<_>>().join(", "))
}
