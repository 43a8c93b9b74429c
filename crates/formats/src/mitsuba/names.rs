//! Ids, references and aliases.

use super::attributes::Attributes;
use super::{Parent, Reader};
use etendue_description::{Node, NodeId, Param, Span, Spanned, Value};
use std::collections::{BTreeMap, BTreeSet};

/// Stands for the object of a reference until that is known.
const OPEN: NodeId = NodeId(u32::MAX);
/// References may lead this deep.
const MAX_DEPTH: u32 = 256;

/// What has a name, and who asks for it.
#[derive(Default)]
pub(super) struct Names {
    ids: BTreeMap<String, (NodeId, Span)>,
    aliases: Vec<Alias>,
    references: Vec<Reference>,
}

/// `new` is another name of `old`.
struct Alias {
    old: Spanned<String>,
    new: Spanned<String>,
}

/// A parameter whose object is not known yet.
struct Reference {
    owner: Option<NodeId>,
    param: usize,
    id: Spanned<String>,
}

impl Reader<'_> {
    /// Gives a node a name of its own.
    pub(super) fn define(&mut self, id: Spanned<String>, node: NodeId) {
        if id.value.is_empty() {
            self.diagnostics.error(id.span, "an id needs a name");
            return;
        }
        match self.names.ids.get(&id.value) {
            None => {
                self.names.ids.insert(id.value, (node, id.span));
            }
            Some((_, first)) => {
                let first = *first;
                self.diagnostics.error(id.span, format!("the id `{}` is given twice", id.value)).label(first, "first given here");
            }
        }
    }

    /// `<ref id name?>`
    pub(super) fn reference(&mut self, mut attributes: Attributes, parent: Parent) {
        let id = attributes.required("id").map(|text| Spanned::new(text.value, text.span));
        let name = attributes.optional("name").map(|text| Spanned::new(text.value, text.span));
        let span = attributes.span;
        attributes.finish(self);
        let Some(id) = id else { return };
        let owner = match parent {
            Parent::Scene => None,
            Parent::Node(node) => Some(node),
        };
        let mut param = 0;
        if let Some(owner) = owner {
            let params = &mut self.description.nodes[owner.0 as usize].params;
            param = params.len();
            let name = name.unwrap_or_else(|| Spanned::new(String::new(), span));
            params.push(Param { name, value: Spanned::new(Value::Node(OPEN), id.span) });
        }
        self.names.references.push(Reference { owner, param, id });
    }

    /// `<alias id as>`
    pub(super) fn alias(&mut self, mut attributes: Attributes) {
        let old = attributes.required("id").map(|text| Spanned::new(text.value, text.span));
        let new = attributes.required("as").map(|text| Spanned::new(text.value, text.span));
        attributes.finish(self);
        if let (Some(old), Some(new)) = (old, new) {
            self.names.aliases.push(Alias { old, new });
        }
    }

    /// Ties every reference to its object, and sees that none leads back to where it starts.
    pub(super) fn resolve_references(&mut self) {
        self.resolve_aliases();
        let mut open = false;
        let mut top: BTreeSet<NodeId> = self.description.top.iter().copied().collect();
        for Reference { owner, param, id } in std::mem::take(&mut self.names.references) {
            match (self.names.ids.get(&id.value), owner) {
                (Some((node, _)), Some(owner)) => {
                    self.description.nodes[owner.0 as usize].params[param].value.value = Value::Node(*node);
                }
                (Some((node, _)), None) => {
                    if top.insert(*node) {
                        self.description.top.push(*node);
                    }
                }
                (None, _) => {
                    open = true;
                    self.unknown(&id);
                }
            }
        }
        if open {
            for node in &mut self.description.nodes {
                node.params.retain(|p| p.value.value != Value::Node(OPEN));
            }
        }
        self.check_cycles();
    }

    fn resolve_aliases(&mut self) {
        let mut aliases = std::mem::take(&mut self.names.aliases);
        // An alias of an alias waits for it.
        loop {
            let before = aliases.len();
            for Alias { old, new } in std::mem::take(&mut aliases) {
                match self.names.ids.get(&old.value) {
                    Some((node, _)) => {
                        let node = *node;
                        self.define(new, node);
                    }
                    None => aliases.push(Alias { old, new }),
                }
            }
            if aliases.len() == before {
                break;
            }
        }
        for alias in aliases {
            self.unknown(&alias.old);
        }
    }

    fn unknown(&mut self, id: &Spanned<String>) {
        // What a part that could not be read would have defined is not missed.
        if self.broken {
            return;
        }
        let error = self.diagnostics.error(id.span, format!("nothing has the id `{}`", id.value));
        if self.searches > 0 {
            self.searches -= 1;
            error.suggest(&id.value, self.names.ids.keys().map(String::as_str));
        }
    }

    /// Walks the objects, depth first; a parameter that leads back is an error and is taken out.
    fn check_cycles(&mut self) {
        let count = self.description.nodes.len();
        // How deep the objects below each reach; 0 where that is not known yet.
        let mut depths = vec![0u32; count];
        let mut on_path = vec![false; count];
        let mut bad: Vec<(NodeId, usize)> = Vec::new();
        for start in 0..count as u32 {
            if depths[start as usize] > 0 {
                continue;
            }
            let mut path = vec![(NodeId(start), 0)];
            on_path[start as usize] = true;
            while let Some((node, param)) = path.last_mut() {
                let (owner, at) = (*node, *param);
                *param += 1;
                let Some(child) = self.description.node(owner).params.get(at) else {
                    path.pop();
                    on_path[owner.0 as usize] = false;
                    let below = self.description.node(owner).params.iter().filter_map(|p| match p.value.value {
                        Value::Node(child) => Some(depths[child.0 as usize]),
                        _ => None,
                    });
                    depths[owner.0 as usize] = below.max().unwrap_or(0) + 1;
                    if depths[owner.0 as usize] == MAX_DEPTH {
                        let text = format!("references lead more than {MAX_DEPTH} objects deep from here");
                        self.diagnostics.error(self.description.node(owner).model.span, text);
                    }
                    continue;
                };
                let Value::Node(next) = child.value.value else { continue };
                if on_path[next.0 as usize] {
                    let span = child.value.span;
                    let circle = path.iter().map(|(node, _)| *node).skip_while(|node| *node != next).chain([next]);
                    let names: Vec<String> = circle.map(|node| title(self.description.node(node))).collect();
                    self.diagnostics.error(span, format!("{} contains itself", names[0])).help(names.join(", which contains "));
                    bad.push((owner, at));
                } else if depths[next.0 as usize] == 0 {
                    on_path[next.0 as usize] = true;
                    path.push((next, 0));
                }
            }
        }
        bad.sort_by_key(|&(node, param)| std::cmp::Reverse((node, param)));
        for (node, param) in bad {
            self.description.nodes[node.0 as usize].params.remove(param);
        }
    }
}

/// A node in words.
fn title(node: &Node) -> String {
    match &node.id {
        Some(id) => format!("`{}`", id.value),
        None => format!("{} `{}`", node.kind.name(), node.model.value),
    }
}
