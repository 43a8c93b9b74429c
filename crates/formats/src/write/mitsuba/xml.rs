//! A description as XML, node by node.
//!
//! What several nodes refer to has an id and is printed once, before the first of them that stands in the scene itself; all else
//! stands where it belongs.

use super::super::beside::Beside;
use super::super::constants::is_constant;
use super::super::look::nodes_in;
use super::super::text::{escaped, number, numbers};
use super::super::{MARK, Notes, WriteOptions};
use etendue_description::{Description, Kind, NodeId, Param, SpectrumValue, Value};
use etendue_numerics::Transform;
use glam::{DMat4, DVec3};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// Parameters that are places, not directions.
const POINTS: [&str; 5] = ["center", "p0", "p1", "position", "target"];

/// The text of `d`; `read` is the description before its words were changed, for notes.
pub(super) fn print(d: &Description, read: &Description, options: &WriteOptions, beside: &mut Beside, notes: &mut Notes) -> String {
    let ids = ids(d);
    let is_top = d.top.iter().copied().collect();
    let mut printer = Printer { d, read, beside, notes, ids, is_top, printed: BTreeSet::new(), out: String::new(), depth: 1 };
    let source = escaped(&options.source).replace("--", "- -");
    let _ = write!(printer.out, "<!-- {MARK} from {source} -->\n<scene version=\"3.0.0\">\n");
    let mut before = None;
    for &id in &d.top {
        if printer.printed.contains(&id) {
            continue;
        }
        let mut shared = Vec::new();
        printer.shared_below(id, &mut BTreeSet::new(), &mut shared);
        for id in shared.into_iter().chain([id]) {
            let kind = d.node(id).kind;
            if before.replace(kind).is_some_and(|before| before != kind) {
                printer.out.push('\n');
            }
            printer.node(id, "");
        }
    }
    printer.out.push_str("</scene>\n");
    printer.out
}

/// The ids of nodes that were given one, and of those that several others hold; none is given twice.
fn ids(d: &Description) -> BTreeMap<NodeId, String> {
    let mut holders: BTreeMap<NodeId, usize> = d.top.iter().map(|id| (*id, 0)).collect();
    let (mut order, mut seen) = (Vec::new(), BTreeSet::new());
    let mut open: Vec<NodeId> = d.top.iter().rev().copied().collect();
    while let Some(id) = open.pop() {
        if seen.insert(id) {
            order.push(id);
            for child in nodes_in(d.node(id)) {
                *holders.entry(child).or_default() += 1;
                open.push(child);
            }
        }
    }
    let is_top: BTreeSet<NodeId> = d.top.iter().copied().collect();
    let (mut ids, mut taken) = (BTreeMap::new(), BTreeSet::new());
    // Names of the file come first, lest one that is made takes theirs.
    for given in [true, false] {
        for &id in &order {
            let node = d.node(id);
            let (stem, first) = match &node.id {
                Some(name) if given => (name.value.as_str(), name.value.clone()),
                None if !given && (holders[&id] > 1 || (is_top.contains(&id) && holders[&id] > 0)) => {
                    (node.kind.name(), format!("{}-1", node.kind.name()))
                }
                _ => continue,
            };
            let (mut free, mut n) = (first, 1);
            while !taken.insert(free.clone()) {
                n += 1;
                free = format!("{stem}-{n}");
            }
            ids.insert(id, free);
        }
    }
    ids
}

struct Printer<'a, 'b> {
    d: &'a Description,
    read: &'a Description,
    beside: &'a mut Beside<'b>,
    notes: &'a mut Notes,
    ids: BTreeMap<NodeId, String>,
    is_top: BTreeSet<NodeId>,
    printed: BTreeSet<NodeId>,
    out: String,
    depth: usize,
}

impl Printer<'_, '_> {
    /// Materials and textures below a node that have an id and are not printed yet; what others need comes first.
    fn shared_below(&self, id: NodeId, seen: &mut BTreeSet<NodeId>, found: &mut Vec<NodeId>) {
        for child in nodes_in(self.d.node(id)) {
            if self.printed.contains(&child) || !seen.insert(child) {
                continue;
            }
            self.shared_below(child, seen, found);
            if self.ids.contains_key(&child) && matches!(self.d.node(child).kind, Kind::Bsdf | Kind::Texture) {
                found.push(child);
            }
        }
    }

    fn line(&mut self, text: &str) {
        self.out.extend(std::iter::repeat_n("    ", self.depth));
        self.out.push_str(text);
        self.out.push('\n');
    }

    /// A node, or a reference to it where it stands elsewhere already.
    fn node(&mut self, id: NodeId, name: &str) {
        let node = self.d.node(id);
        let name = if name.is_empty() { String::new() } else { format!(" name=\"{}\"", escaped(name)) };
        let own = self.ids.get(&id).map(|id| format!(" id=\"{}\"", escaped(id)));
        // What belongs to the scene itself stands there, before or behind.
        let elsewhere = self.depth > 1 && self.is_top.contains(&id);
        if elsewhere || self.printed.contains(&id) {
            self.line(&format!("<ref{}{name}/>", own.unwrap_or_default()));
            return;
        }
        self.printed.insert(id);
        if let Some(read) = self.read.nodes.get(id.0 as usize)
            && !read.model.value.is_empty()
        {
            self.notes.kept(self.read, id);
        }
        let tag = match node.kind {
            Kind::Texture if is_constant(&node.model.value) || node.model.value == "blackbody" => "spectrum",
            kind => kind.name(),
        };
        let open = format!("<{tag} type=\"{}\"{}{name}", escaped(&node.model.value), own.unwrap_or_default());
        if node.params.is_empty() {
            self.line(&format!("{open}/>"));
            return;
        }
        self.line(&format!("{open}>"));
        self.depth += 1;
        for param in &node.params {
            self.param(param);
        }
        self.depth -= 1;
        self.line(&format!("</{tag}>"));
    }

    fn param(&mut self, param: &Param) {
        let name = escaped(&param.name.value);
        let simple = |tag: &str, value: String| format!("<{tag} name=\"{name}\" value=\"{value}\"/>");
        let text = match &param.value.value {
            Value::Node(id) => return self.node(*id, &param.name.value),
            Value::Transform(t) => return self.transform(&name, t),
            Value::Bool(b) => simple("boolean", b.to_string()),
            Value::Integer(i) => simple("integer", i.to_string()),
            Value::Float(x) => simple("float", number(*x)),
            Value::String(s) => simple("string", escaped(s)),
            Value::Rgb(rgb) => simple("rgb", numbers(rgb, ", ")),
            Value::Vector(v) => {
                let tag = if POINTS.contains(&param.name.value.as_str()) { "point" } else { "vector" };
                format!("<{tag} name=\"{name}\" x=\"{}\" y=\"{}\" z=\"{}\"/>", number(v.x), number(v.y), number(v.z))
            }
            Value::Spectrum(s) => match s {
                SpectrumValue::Constant(x) => simple("spectrum", number(*x)),
                SpectrumValue::Samples(pairs) => {
                    let pairs: Vec<String> = pairs.iter().map(|(nm, x)| format!("{}:{}", number(*nm), number(*x))).collect();
                    simple("spectrum", pairs.join(", "))
                }
                SpectrumValue::Blackbody { kelvin, scale } => {
                    self.line(&format!("<spectrum type=\"blackbody\" name=\"{name}\">"));
                    self.depth += 1;
                    self.line(&format!("<float name=\"temperature\" value=\"{}\"/>", number(*kelvin)));
                    if *scale != 1.0 {
                        self.line(&format!("<float name=\"scale\" value=\"{}\"/>", number(*scale)));
                    }
                    self.depth -= 1;
                    "</spectrum>".to_owned()
                }
            },
            Value::Path(path) => simple("string", escaped(&self.beside.refer(self.d, path))),
            Value::Grid(i) => {
                let path = self.d.assets.grids[*i as usize].path.clone();
                simple("string", escaped(&self.beside.refer(self.d, &path)))
            }
            Value::Measured(i) => {
                let path = self.d.assets.measured[*i as usize].path.clone();
                simple("string", escaped(&self.beside.refer(self.d, &path)))
            }
            // One that must become a file of its own; others have been named by their path.
            Value::Mesh(i) => simple("string", escaped(&self.beside.mesh(*i, "", &self.d.assets.meshes[*i as usize]))),
        };
        self.line(&text);
    }

    fn transform(&mut self, name: &str, t: &Transform) {
        let m = t.matrix();
        let steps = steps(m).unwrap_or_else(|| {
            let rows: Vec<String> = (0..4).map(|i| numbers(&m.row(i).to_array(), " ")).collect();
            vec![format!("<matrix value=\"{}\"/>", rows.join("  "))]
        });
        if steps.is_empty() {
            return self.line(&format!("<transform name=\"{name}\"/>"));
        }
        self.line(&format!("<transform name=\"{name}\">"));
        self.depth += 1;
        steps.iter().for_each(|step| self.line(step));
        self.depth -= 1;
        self.line("</transform>");
    }
}

/// A scale and a translation, where the map is made of these alone.
fn steps(m: DMat4) -> Option<Vec<String>> {
    let (scale, shift) = (DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z), m.w_axis.truncate());
    if m != DMat4::from_translation(shift) * DMat4::from_scale(scale) {
        return None;
    }
    let mut steps = Vec::new();
    if scale == DVec3::splat(scale.x) && scale != DVec3::ONE {
        steps.push(format!("<scale value=\"{}\"/>", number(scale.x)));
    } else if scale != DVec3::ONE {
        steps.push(format!("<scale x=\"{}\" y=\"{}\" z=\"{}\"/>", number(scale.x), number(scale.y), number(scale.z)));
    }
    if shift != DVec3::ZERO {
        steps.push(format!("<translate x=\"{}\" y=\"{}\" z=\"{}\"/>", number(shift.x), number(shift.y), number(shift.z)));
    }
    Some(steps)
}
