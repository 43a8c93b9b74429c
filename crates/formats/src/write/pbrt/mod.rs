//! pbrt-v4 scenes: what stands before `WorldBegin`, then lights and shapes in the description's order, each material and texture right
//! before the first that names it.
//!
//! This is the reader of `pbrt` the other way round; the tables of what becomes what stand at the heads of both folders' files. pbrt has no words
//! for: one-sided reflection (all materials reflect on both sides), tints of what is specular, Beckmann's distribution, media (they are
//! not rendered here), and more than one camera.

mod camera;
mod colours;
mod glossy;
mod interfaces;
mod lights;
mod list;
mod materials;
mod meshes;
mod shapes;
mod textures;

use super::beside::Beside;
use super::uses::reachable;
use super::{MARK, Notes, WriteOptions};
use etendue_description::{Description, Kind, NodeId};
use list::{List, quoted};
use std::collections::{BTreeMap, BTreeSet};

/// The text of a scene.
pub(super) fn write(d: &Description, options: &WriteOptions, beside: &mut Beside, notes: &mut Notes) -> String {
    let mut writer = Writer {
        d,
        options,
        beside,
        notes,
        out: String::new(),
        depth: 0,
        materials: BTreeMap::new(),
        textures: BTreeMap::new(),
        objects: BTreeMap::new(),
        taken: BTreeSet::new(),
        current: None,
    };
    writer.line(&format!("# {MARK} from {}", options.source.replace(['\n', '\r'], " ")));
    writer.setup();
    writer.out.push_str("\nWorldBegin\n\n");
    for &id in &d.top {
        match d.node(id).kind {
            Kind::Emitter => writer.light(id),
            Kind::Shape => writer.shape(id),
            _ => {}
        }
    }
    writer.tell_the_rest();
    writer.out
}

/// What names must be told apart from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Sort {
    Material,
    Number,
    Colour,
    Object,
}

struct Writer<'a, 'b> {
    d: &'a Description,
    options: &'a WriteOptions,
    beside: &'a mut Beside<'b>,
    notes: &'a mut Notes,
    out: String,
    depth: usize,
    materials: BTreeMap<NodeId, String>,
    /// By node, and whether it is a number.
    textures: BTreeMap<(NodeId, bool), String>,
    objects: BTreeMap<NodeId, String>,
    taken: BTreeSet<(Sort, String)>,
    /// The material in force outside of all blocks.
    current: Option<String>,
}

impl Writer<'_, '_> {
    fn line(&mut self, text: &str) {
        self.out.extend(std::iter::repeat_n("    ", self.depth));
        self.out.push_str(text);
        self.out.push('\n');
    }

    /// A directive with a model's name and parameters.
    fn directive(&mut self, word: &str, model: &str, list: List) {
        for line in list.behind(&format!("{word} {}", quoted(model))) {
            self.line(&line);
        }
    }

    /// A block of directives.
    fn block(&mut self, word: &str, inside: impl FnOnce(&mut Self)) {
        self.line(&format!("{word}Begin"));
        self.depth += 1;
        inside(self);
        self.depth -= 1;
        self.line(&format!("{word}End"));
    }

    /// A name that no other thing of the sort has: the node's own where it has one.
    fn name(&mut self, sort: Sort, id: NodeId, stem: &str) -> String {
        let given = self.d.node(id).id.as_ref().map(|name| name.value.clone());
        self.free_name(sort, given, stem)
    }

    fn free_name(&mut self, sort: Sort, given: Option<String>, stem: &str) -> String {
        let (mut free, stem) = match given {
            Some(name) => (name.clone(), name),
            None => (format!("{stem}-1"), stem.to_owned()),
        };
        let mut n = 1;
        while !self.taken.insert((sort, free.clone())) {
            n += 1;
            free = format!("{stem}-{n}");
        }
        free
    }

    fn approximated(&mut self, id: NodeId, part: &str, how: &str) {
        self.notes.approximated(self.d, id, part, how);
    }

    fn dropped(&mut self, id: NodeId, part: &str, how: &str) {
        self.notes.dropped(self.d, id, part, how);
    }

    /// Everything that came over and of which nothing else was said.
    fn tell_the_rest(&mut self) {
        let d = self.d;
        for id in reachable(d) {
            if d.node(id).kind == Kind::Medium {
                self.dropped(id, "", "media are not rendered, and not written");
            } else {
                self.notes.kept(d, id);
            }
        }
    }
}
