//! Files that a scene names, and its options.

use super::Reader;
use super::tokens::Tokens;
use super::values::Values;
use crate::files::plain;
use etendue_description::{SourceId, Span};
use std::path::PathBuf;

/// Files may include each other this deep, and this often in all.
const MAX_INCLUDES: usize = 64;

/// What `Option` knows.
const OPTIONS: [&str; 12] = [
    "disablepixeljitter",
    "disabletexturefiltering",
    "disablewavelengthjitter",
    "displacementedgescale",
    "forcediffuse",
    "msereferenceimage",
    "msereferenceout",
    "pixelstats",
    "rendercoordsys",
    "seed",
    "wavefront",
    "writepartialimages",
];

/// Those of them that would change the picture, and what happens instead.
const DISOBEYED: [(&str, &str); 3] = [
    ("disablepixeljitter", "samples lie anywhere in their pixels"),
    ("disablewavelengthjitter", "every sample has wavelengths of its own"),
    ("forcediffuse", "materials stay what they are"),
];

impl Reader<'_> {
    pub(super) fn include(&mut self, t: &mut Tokens, source: SourceId, span: Span, import: bool) {
        let Some((name, at)) = self.quoted(t, source, span, "the name of a file") else { return };
        let Some(path) = self.find(&name, at) else {
            self.broken = true;
            return;
        };
        if self.chain.contains(&plain(&path)) {
            let chain = self.chain.iter().map(|p| format!("`{}`", p.display())).chain([format!("`{}`", path.display())]);
            let chain = chain.collect::<Vec<_>>().join(", which includes ");
            self.diagnostics.error(at, format!("`{name}` includes itself")).help(chain);
            return;
        }
        if self.chain.len() >= MAX_INCLUDES {
            self.diagnostics.error(at, format!("files include each other more than {MAX_INCLUDES} deep"));
            return;
        }
        match self.files.read_text(&path) {
            Ok(text) => {
                let included = self.description.sources.add_included(path, text, at);
                // What an imported file does to the state ends with it.
                let before = import.then(|| self.state.clone());
                self.file(included);
                before.into_iter().for_each(|state| self.state = state);
            }
            Err(why) => {
                self.diagnostics.error(at, format!("`{}` cannot be read: {why}", path.display()));
                self.broken = true;
            }
        }
    }

    /// The path of a file that the scene names.
    pub(super) fn find(&mut self, name: &str, span: Span) -> Option<PathBuf> {
        let including = self.chain.last().and_then(|p| p.parent()).map(PathBuf::from).unwrap_or_default();
        let mut folders = vec![self.folder.clone()];
        if plain(&including) != plain(&self.folder) {
            folders.push(including);
        }
        folders.extend(self.files.options.search_paths.iter().cloned());
        self.files.find(name, span, &folders, &mut self.searches, &mut self.diagnostics)
    }

    pub(super) fn option(&mut self, t: &mut Tokens, source: SourceId) {
        for entry in self.entries(t, source).unwrap_or_default() {
            // pbrt drops capitals and underscores.
            let name: String = entry.name.chars().filter(|c| *c != '_').collect::<String>().to_lowercase();
            if !OPTIONS.contains(&name.as_str()) {
                self.diagnostics.error(entry.declared, format!("unknown option `{}`", entry.name)).suggest(&name, OPTIONS);
            } else if let Some((_, why)) = DISOBEYED.iter().find(|(option, _)| *option == name)
                && matches!(&entry.values, Values::Bools(v) if v.first() == Some(&true))
            {
                self.diagnostics.warning(entry.declared, format!("`{}` is not obeyed: {why}", entry.name));
            }
        }
    }
}
