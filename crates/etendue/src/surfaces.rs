//! Surfaces by their names in the scene, and in words what is wrong with them.

use crate::load::Loaded;
use etendue_description::Value;
use etendue_radiosity::Patches;
use etendue_radiosity::patch::{Facet, Fault, Object, Side};
use etendue_scene::{NO_INSTANCE, SurfaceId};
use serde::Serialize;

/// A surface by the id of its shape in the file, or by its model and place in the scene.
pub(crate) fn name(loaded: &Loaded, id: SurfaceId) -> String {
    let node = loaded.description.node(loaded.scene.surface(id).node);
    node.id.as_ref().map_or_else(|| format!("{}-{}", node.model.value, id.0), |id| id.value.clone())
}

/// A name for each object: its id, the name of its file, or its model; with its number where another one has that name.
pub(crate) fn names(loaded: &Loaded, patches: &Patches) -> Vec<String> {
    let own = |object: &Object| {
        let node = loaded.description.node(loaded.scene.surface(object.surface).node);
        let mesh = node.params.iter().find_map(|p| if let Value::Mesh(i) = p.value.value { Some(i) } else { None });
        let file = mesh.and_then(|i| loaded.description.assets.meshes[i as usize].path.file_stem());
        let id = node.id.as_ref().map(|id| id.value.clone());
        id.or_else(|| file.map(|f| f.to_string_lossy().into_owned())).unwrap_or_else(|| node.model.value.clone())
    };
    let own: Vec<String> = patches.objects.iter().map(own).collect();
    let mut alike = std::collections::HashMap::new();
    own.iter().for_each(|n| *alike.entry(n.as_str()).or_insert(0) += 1);
    let name = |(k, object): (usize, &Object)| {
        let number = if alike.get(own[k].as_str()).is_some_and(|n| *n > 1) { format!("-{k}") } else { String::new() };
        let instance = if object.instance == NO_INSTANCE { String::new() } else { format!("@{}", object.instance) };
        format!("{}{number}{instance}", own[k])
    };
    patches.objects.iter().enumerate().map(name).collect()
}

/// Something that is wrong with surfaces, and what was done about it.
#[derive(Clone, Debug, Serialize)]
pub struct Defect {
    /// `no-area`, `wound-against-each-other`, `open`, `dark-front`, `dark-back`, `touching`, `doubled` or `obstacle`.
    pub kind: &'static str,
    /// The shape, or both of two.
    pub shapes: Vec<String>,
    /// Where in the scene's files each of them stands, where it does.
    pub places: Vec<String>,
    /// The facet of each: a triangle of its mesh, from 0.
    pub facets: Vec<u32>,
    /// Of how many facets or edges this is the first.
    pub count: usize,
    /// The area concerned, m².
    pub area: Option<f64>,
    /// What was done.
    pub done: &'static str,
    /// All of it in words.
    pub words: String,
    /// Shapes, facets and places in words.
    #[serde(skip)]
    who: String,
}

/// What is wrong with the surfaces of `patches`.
pub(crate) fn defects(loaded: &Loaded, patches: &Patches, names: &[String]) -> Vec<Defect> {
    let name = |id: SurfaceId| patches.objects.iter().position(|o| o.surface == id).map_or("?", |o| names[o].as_str());
    let place = |id: SurfaceId| {
        let node = loaded.description.node(loaded.scene.surface(id).node);
        let place = loaded.description.sources.place(node.span);
        // A plain mesh has no text of its own.
        let mesh = loaded.description.sources.path(node.span.source).extension().is_some_and(|e| e == "obj" || e == "ply");
        (!mesh).then_some(place)
    };
    let new = |kind, facets: &[Facet], count: usize, area: Option<f64>, done| {
        let one = |f: &Facet| {
            let place = place(f.surface).map_or(String::new(), |p| format!(" ({p})"));
            format!("`{}` facet {}{place}", name(f.surface), f.facet)
        };
        let who = facets.iter().map(one).collect::<Vec<_>>().join(" and ");
        let first = if count > 1 { ", this is the first" } else { "" };
        Defect {
            kind,
            shapes: facets.iter().map(|f| name(f.surface).to_owned()).collect(),
            places: facets.iter().filter_map(|f| place(f.surface)).collect(),
            facets: facets.iter().map(|f| f.facet).collect(),
            count,
            area,
            done,
            words: format!("{who}: {}{first}; {done}", what(kind, count, area.unwrap_or(0.0))),
            who,
        }
    };
    let of = |fault: &Fault| match fault {
        Fault::NoArea { first, count } => new("no-area", &[*first], *count, None, "what has none is left out"),
        Fault::AgainstEachOther { first, count } => {
            new("wound-against-each-other", first, *count, None, "each keeps its own front")
        }
        Fault::Open { first, count } => {
            new("open", &[*first], *count, None, "what passes there is counted where it ends, or as escaped")
        }
        Fault::Dark { first, side } => {
            let kind = if *side == Side::Front { "dark-front" } else { "dark-back" };
            new(kind, &[*first], 1, None, "that side is left out")
        }
        Fault::Touching { pair, area } => new("touching", pair, 1, Some(*area), "those parts exchange with each other alone"),
        Fault::Doubled { pair, area } => new("doubled", pair, 1, Some(*area), "rays see one of the two, and both send light"),
    };
    let obstacle = |id: &SurfaceId| {
        let place_of = place(*id).map_or(String::new(), |p| format!(" ({p})"));
        let (who, done) = (format!("`{}`{place_of}", name(*id)), "a black obstacle stands there");
        Defect {
            kind: "obstacle",
            shapes: vec![name(*id).to_owned()],
            places: place(*id).into_iter().collect(),
            facets: Vec::new(),
            count: 1,
            area: None,
            done,
            words: format!("{who}: {}; {done}", what("obstacle", 1, 0.0)),
            who,
        }
    };
    patches.faults.iter().map(of).chain(patches.obstacles.iter().map(obstacle)).collect()
}

/// The words of defects: a line for each kind, which names the first few and tells how many there are. What is as it should be is a note.
pub fn words(defects: &[Defect]) -> Vec<String> {
    /// Names in a line.
    const NAMES: usize = 4;
    let mut kinds: Vec<&str> = Vec::new();
    defects.iter().map(|d| d.kind).for_each(|kind| kinds.extend((!kinds.contains(&kind)).then_some(kind)));
    let line = |kind: &&str| {
        let alike: Vec<&Defect> = defects.iter().filter(|d| d.kind == *kind).collect();
        let weight = if matches!(*kind, "touching" | "dark-front" | "dark-back") { "note" } else { "warning" };
        let one = alike[0];
        if alike.len() == 1 {
            return format!("{weight}: {}", one.words);
        }
        let count = alike.iter().map(|d| d.count).sum();
        let area = alike.iter().filter_map(|d| d.area).sum();
        let named: Vec<&str> = alike.iter().take(NAMES).map(|d| d.who.as_str()).collect();
        let more = if alike.len() > NAMES { format!(", and {} more, all in the JSON", alike.len() - NAMES) } else { String::new() };
        let them = if one.shapes.len() > 1 { "pairs of facets" } else { "surfaces" };
        format!("{weight}: {} {them} {}: {}{more}; {}", alike.len(), what(kind, count, area), named.join(", "), one.done)
    };
    kinds.iter().map(line).collect()
}

/// What is wrong, of one or of many.
fn what(kind: &str, count: usize, area: f64) -> String {
    let number = |one: &str, many: &str| if count == 1 { format!("1 {one}") } else { format!("{count} {many}") };
    match kind {
        "no-area" => format!("{} without area", number("facet", "facets")),
        "wound-against-each-other" => {
            format!("wound against each other along {} (a normal may be inverted)", number("edge", "edges"))
        }
        "open" => format!("open along {}", number("edge", "edges")),
        "dark-front" => "without light on the front".to_owned(),
        "dark-back" => "without light on the back".to_owned(),
        "touching" => format!("touch face to face, {area:.4} m² of them"),
        "doubled" => format!("lie in one place, {area:.4} m² of them"),
        _ => "cannot be cut into patches".to_owned(),
    }
}
