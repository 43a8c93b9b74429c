//! pbrt-v4 scenes.
//!
//! A scene file is a list of directives that change a graphics state (transform, material, colour space, medium) or make something in that
//! state (a shape, a light). The reader obeys them from top to bottom and writes what they make as nodes in étendue's vocabulary:
//!
//! | pbrt | here |
//! | --- | --- |
//! | `diffuse`, `conductor`, `coateddiffuse`, … reflect on both sides | the model within `twosided` |
//! | roughness r | α = √r where `remaproughness` holds; GGX with correlated masking, and smooth models below α = 0.001 |
//! | `alpha` of a shape | `mask` around the material; its light is `masked`, with `alpha` 0 `unseen` |
//! | L, I with `scale`, `power`, `illuminance` | light of luminance `scale` for a spectrum, of `scale` times the colour for `rgb` |
//! | camera (x right, y up, z ahead) | sensor (x left) |
//! | object instances | `shapegroup` and `instance` |
//! | `maxdepth` n | `max_depth` n + 1 |
//!
//! Colours become linear Rec.709 whatever their colour space; spectra stay spectra. Media are kept as nodes and not rendered; what moves is
//! refused. Every mistake is told at its place, and reading goes on at the next directive.
//!
//! Source: the pbrt-v4 input file format, <https://pbrt.org/fileformat-v4>, and [Pharr, Jakob, Humphreys 2023].

mod blocks;
pub(crate) mod camera;
mod curves;
mod directives;
mod emission;
mod inclusion;
mod lights;
mod lists;
mod materials;
mod quadrics;
mod shapes;
pub(crate) mod spectra;
mod state;
mod subdivision;
mod textures;
mod tokens;
mod transforms;
mod values;

use crate::assets::Wanted;
use crate::files::Files;
use etendue_description::{
    Description, Diagnostics, Dialect, Kind, MeshData, Node, NodeId, Param, SourceId, Span, Spanned, Value, nearest,
};
use state::{CoordinateSystems, Scope, State};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Unknown names beyond this number are told without the nearest known one.
const MAX_SEARCHES: usize = 50;
/// Mistakes in the words of one file beyond this number end its reading: it is no scene.
const MAX_MISTAKES: usize = 100;

/// Reads a scene from its text.
pub(crate) fn read(path: &Path, text: String, files: Files) -> (Description, Diagnostics) {
    let mut reader = Reader {
        files,
        description: Description { dialect: Dialect::Pbrt, ..Description::default() },
        diagnostics: Diagnostics::default(),
        wanted: Wanted::default(),
        state: State::default(),
        scopes: Vec::new(),
        systems: CoordinateSystems::default(),
        named: BTreeMap::new(),
        objects: BTreeMap::new(),
        object: None,
        setup: camera::Setup::default(),
        world: false,
        imaging: 1.0,
        default_material: None,
        masks: BTreeMap::new(),
        chain: Vec::new(),
        folder: path.parent().map(Path::to_path_buf).unwrap_or_default(),
        searches: MAX_SEARCHES,
        mistakes: 0,
        told: Vec::new(),
        broken: false,
    };
    if text.len() as u64 > crate::files::MAX_TEXT {
        reader.diagnostics.error(None, format!("`{}` has {} bytes, too many for a scene's text", path.display(), text.len()));
        return (reader.description, reader.diagnostics);
    }
    let source = reader.description.sources.add(path, text);
    reader.file(source);
    reader.finish(source)
}

/// What has a name of its own kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Named {
    Material,
    FloatTexture,
    SpectrumTexture,
    Medium,
}

impl Named {
    fn words(self) -> &'static str {
        match self {
            Self::Material => "material",
            Self::FloatTexture => "float texture",
            Self::SpectrumTexture => "spectrum texture",
            Self::Medium => "medium",
        }
    }
}

/// A node that a name stands for.
#[derive(Clone, Copy, Debug)]
struct Definition {
    node: NodeId,
    /// Where it was defined; none while it was only asked for.
    defined: Option<Span>,
    /// Where it was first asked for.
    asked: Option<Span>,
}

/// An object that instances may show.
#[derive(Clone, Copy, Debug)]
struct Object {
    group: NodeId,
    span: Span,
}

/// The scene so far.
struct Reader<'a> {
    files: Files<'a>,
    description: Description,
    diagnostics: Diagnostics,
    wanted: Wanted,
    state: State,
    scopes: Vec<Scope>,
    systems: CoordinateSystems,
    named: BTreeMap<(Named, String), Definition>,
    objects: BTreeMap<String, Object>,
    /// The object that is being defined.
    object: Option<NodeId>,
    /// What stands before `WorldBegin`.
    setup: camera::Setup,
    world: bool,
    /// What the film's exposure multiplies all light by.
    imaging: f64,
    default_material: Option<NodeId>,
    /// Materials with holes, by material and alpha.
    masks: BTreeMap<(NodeId, u64), NodeId>,
    /// The files that are being read, each included by the one before.
    chain: Vec<PathBuf>,
    /// The scene's own folder, where files are looked for.
    folder: PathBuf,
    searches: usize,
    mistakes: usize,
    /// What is told once for a scene.
    told: Vec<&'static str>,
    /// Whether parts of a file could not be read at all, so that what they would define is missing.
    broken: bool,
}

impl Reader<'_> {
    fn span(&self, source: SourceId, range: Range<usize>) -> Span {
        Span { source, start: range.start as u32, end: range.end as u32 }
    }

    /// Adds a node.
    fn node(&mut self, kind: Kind, model: &str, span: Span, params: Vec<Param>) -> NodeId {
        self.description.add(Node { kind, model: Spanned::new(model.to_owned(), span), id: None, params, span })
    }

    /// Adds a node to the scene itself.
    fn top(&mut self, kind: Kind, model: &str, span: Span, params: Vec<Param>) -> NodeId {
        let id = self.node(kind, model, span, params);
        self.description.top.push(id);
        id
    }

    /// Adds a mesh.
    fn mesh(&mut self, mesh: MeshData) -> Value {
        self.description.assets.meshes.push(Arc::new(mesh));
        Value::Mesh(self.description.assets.meshes.len() as u32 - 1)
    }

    /// A warning that is told once.
    fn once(&mut self, span: Span, message: &'static str) {
        if !self.told.contains(&message) {
            self.told.push(message);
            self.diagnostics.warning(span, message);
        }
    }

    /// The node that `name` stands for, perhaps one that is defined later.
    fn named(&mut self, kind: Named, name: &str, span: Span) -> NodeId {
        if let Some(known) = self.named.get_mut(&(kind, name.to_owned())) {
            known.asked.get_or_insert(span);
            return known.node;
        }
        let node = self.node(Kind::Bsdf, "", span, Vec::new());
        self.named.insert((kind, name.to_owned()), Definition { node, defined: None, asked: Some(span) });
        node
    }

    /// Defines what `name` stands for: `node` takes the place that was kept for it, if any.
    fn define(&mut self, kind: Named, name: String, span: Span, node: NodeId) {
        let spanned = Spanned::new(name.clone(), span);
        self.description.nodes[node.0 as usize].id = Some(spanned);
        let key = (kind, name);
        match self.named.get_mut(&key) {
            None => drop(self.named.insert(key, Definition { node, defined: Some(span), asked: None })),
            Some(Definition { defined: Some(first), .. }) => {
                let first = *first;
                self.diagnostics
                    .error(span, format!("the {} `{}` is defined twice", kind.words(), key.1))
                    .label(first, "first defined here");
            }
            Some(kept) => {
                kept.defined = Some(span);
                let place = kept.node;
                self.description.nodes[place.0 as usize] = self.description.node(node).clone();
            }
        }
    }

    /// Ties what was left open, and loads the files.
    fn finish(mut self, source: SourceId) -> (Description, Diagnostics) {
        while let Some(scope) = self.scopes.pop() {
            let word = scope.kind.begin();
            self.diagnostics.error(scope.span, format!("`{word}` is never closed")).help(format!("add `{}`", scope.kind.end()));
        }
        if !self.world && !self.broken {
            let end = self.description.sources.text(source).len();
            let span = self.span(source, end..end);
            self.diagnostics.error(span, "the scene has no `WorldBegin`: nothing is in it");
        }
        if !self.broken {
            let open = self.named.iter().filter(|(_, d)| d.defined.is_none());
            let open: Vec<_> = open.filter_map(|((kind, name), d)| Some((*kind, name.clone(), d.asked?))).collect();
            for (kind, name, span) in open {
                let known = self.named.iter().filter(|((k, _), d)| *k == kind && d.defined.is_some()).map(|((_, n), _)| n.as_str());
                let near = if self.searches > 0 { nearest(&name, known).map(str::to_owned) } else { None };
                self.searches = self.searches.saturating_sub(1);
                let error = self.diagnostics.error(span, format!("there is no {} `{name}`", kind.words()));
                if let Some(near) = near {
                    error.help(format!("did you mean `{near}`?"));
                }
            }
        }
        self.wanted.load(self.files, &mut self.description, &mut self.diagnostics);
        (self.description, self.diagnostics)
    }
}

/// A parameter of a node.
fn param(name: &str, value: Value, span: Span) -> Param {
    Param { name: Spanned::new(name.to_owned(), span), value: Spanned::new(value, span) }
}

/// A nested node.
fn child(node: NodeId, span: Span) -> Param {
    param("", Value::Node(node), span)
}
