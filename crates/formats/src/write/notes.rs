//! What became of each thing: kept, approximated or dropped.

use etendue_description::{Description, NodeId};

/// How well a thing came over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fate {
    /// It means the same there.
    Kept,
    /// The nearest that the format can say.
    Approximated,
    /// The format cannot say it.
    Dropped,
}

impl Fate {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Kept => "kept",
            Self::Approximated => "approximated",
            Self::Dropped => "dropped",
        }
    }
}

/// The same fate of things of one sort.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// How well.
    pub fate: Fate,
    /// Which: ``bsdf `phong` ``.
    pub what: String,
    /// What it became, and what is lost; empty where nothing is to be said.
    pub how: String,
    /// How many of them.
    pub count: usize,
    /// Which of them: ids, or places in the file that was read.
    pub places: Vec<String>,
}

/// The notes of a conversion, in the order in which they were made; those that say the same are one.
#[derive(Clone, Debug, Default)]
pub struct Notes {
    list: Vec<Note>,
    /// Nodes about which something was said.
    pub(super) told: std::collections::BTreeSet<NodeId>,
}

impl Notes {
    /// Says what became of a node, or of a part of it.
    pub(super) fn of(&mut self, fate: Fate, d: &Description, id: NodeId, part: &str, how: &str) {
        let node = d.node(id);
        let part = if part.is_empty() { String::new() } else { format!(", `{part}`") };
        let what = format!("{} `{}`{part}", node.kind.name(), node.model.value);
        let place = match &node.id {
            Some(name) => name.value.clone(),
            None => {
                // The file's name will do: the folder is that of the scene, mostly.
                let (line, column) = d.sources.line_column(node.span.source, node.span.start);
                let path = d.sources.path(node.span.source);
                let file = path.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned());
                format!("{file}:{line}:{column}")
            }
        };
        self.told.insert(id);
        self.add(fate, what, how, place);
    }

    pub(super) fn approximated(&mut self, d: &Description, id: NodeId, part: &str, how: &str) {
        self.of(Fate::Approximated, d, id, part, how);
    }

    pub(super) fn dropped(&mut self, d: &Description, id: NodeId, part: &str, how: &str) {
        self.of(Fate::Dropped, d, id, part, how);
    }

    fn add(&mut self, fate: Fate, what: String, how: &str, place: String) {
        match self.list.iter_mut().find(|n| n.fate == fate && n.what == what && n.how == how) {
            // A thing that is met twice is told once.
            Some(known) if known.places.last() == Some(&place) => {}
            Some(known) => {
                known.count += 1;
                known.places.push(place);
            }
            None => self.list.push(Note { fate, what, how: how.to_owned(), count: 1, places: vec![place] }),
        }
    }

    /// Counts a node as kept unless something else was said of it.
    pub(super) fn kept(&mut self, d: &Description, id: NodeId) {
        if !self.told.insert(id) {
            return;
        }
        let node = d.node(id);
        let what = format!("{} `{}`", node.kind.name(), node.model.value);
        match self.list.iter_mut().find(|n| n.fate == Fate::Kept && n.what == what) {
            Some(known) => known.count += 1,
            None => self.list.push(Note { fate: Fate::Kept, what, how: String::new(), count: 1, places: Vec::new() }),
        }
    }

    /// All notes, by fate.
    pub fn by_fate(&self, fate: Fate) -> impl Iterator<Item = &Note> {
        self.list.iter().filter(move |n| n.fate == fate)
    }
}
