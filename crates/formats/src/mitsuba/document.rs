//! Files: the scene's own and those that it includes, where to look for others, and which versions are read.

use super::attributes::Attributes;
use super::{File, KINDS, Parent, Reader, text};
use crate::files::{plain, searched};
use crate::xml;
use etendue_description::{Severity, SourceId, Span, Spanned};
use std::path::{Path, PathBuf};

/// Files may be included this often; those that include others twice could fill any memory.
const MAX_INCLUDES: usize = 10_000;

/// An `<include>` that a file was named by: who gets its content, and the name for a single object.
pub(super) struct Include {
    parent: Parent,
    name: Option<Spanned<String>>,
}

impl Reader<'_> {
    /// A whole file: a `<scene>`, or, where it is included, a single object.
    pub(super) fn file(&mut self, source: SourceId, mut folders: Vec<PathBuf>, include: Option<Include>) {
        let path = self.description.sources.path(source).to_path_buf();
        folders.insert(0, path.parent().map(Path::to_path_buf).unwrap_or_default());
        let text = self.description.sources.shared_text(source);
        let before = self.diagnostics.count(Severity::Error);
        let document = xml::parse(source, &text, &mut self.diagnostics);
        self.broken |= self.diagnostics.count(Severity::Error) > before;
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

    pub(super) fn include(&mut self, file: &File, mut attributes: Attributes, parent: Parent) {
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
        self.included += 1;
        if self.included > MAX_INCLUDES {
            if self.included == MAX_INCLUDES + 1 {
                self.diagnostics.error(filename.span, format!("more than {MAX_INCLUDES} files are included"));
            }
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

    pub(super) fn default(&mut self, mut attributes: Attributes) {
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

    pub(super) fn search_path(&mut self, file: &mut File, mut attributes: Attributes) {
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
    pub(super) fn find_file(&mut self, name: &str, span: Span, folders: &[PathBuf]) -> Option<PathBuf> {
        self.files.find(name, span, folders, &mut self.searches, &mut self.diagnostics)
    }
}
