//! Who uses what.

use super::look::nodes_in;
use etendue_description::{Description, Kind, NodeId};
use std::collections::BTreeSet;

/// Every node that the scene holds, each before what it holds where that is new.
pub(super) fn reachable(d: &Description) -> Vec<NodeId> {
    let (mut order, mut seen) = (Vec::new(), BTreeSet::new());
    let mut open: Vec<NodeId> = d.top.iter().rev().copied().collect();
    while let Some(id) = open.pop() {
        if seen.insert(id) {
            order.push(id);
            let before = open.len();
            open.extend(nodes_in(d.node(id)));
            open[before..].reverse();
        }
    }
    order
}

/// Parameters of materials and textures that are numbers.
pub(super) fn is_number(d: &Description, owner: NodeId, name: &str) -> bool {
    let node = d.node(owner);
    match name {
        "alpha" | "alpha_u" | "alpha_v" | "base_alpha_u" | "base_alpha_v" | "roughness" | "weight" | "opacity" | "amount" => true,
        "anisotropic" | "spec_trans" | "spec_tint" | "sheen" | "sheen_tint" | "flatness" | "metallic" | "clearcoat" => true,
        "clearcoat_gloss" | "diff_trans" | "exponent" => true,
        "b" => node.model.value == "product",
        _ => node.kind == Kind::Bsdf && node.model.value == "bumpmap",
    }
}

/// The textures that are asked for a number, and those that are asked for a colour.
pub(super) fn textures(d: &Description) -> (BTreeSet<NodeId>, BTreeSet<NodeId>) {
    let mut found = [BTreeSet::new(), BTreeSet::new()];
    let mut open = Vec::new();
    for id in reachable(d).into_iter().filter(|id| d.node(*id).kind != Kind::Texture) {
        visit(d, id, None, &mut open);
    }
    while let Some((id, number)) = open.pop() {
        if found[usize::from(!number)].insert(id) {
            visit(d, id, Some(number), &mut open);
        }
    }
    let [numbers, colours] = found;
    (numbers, colours)
}

/// The textures of a node, each with whether it is asked for a number; those of a texture as that is.
fn visit(d: &Description, id: NodeId, inherited: Option<bool>, open: &mut Vec<(NodeId, bool)>) {
    for param in &d.node(id).params {
        if let etendue_description::Value::Node(child) = param.value.value
            && d.node(child).kind == Kind::Texture
        {
            let own = is_number(d, id, &param.name.value);
            open.push((child, own || inherited.unwrap_or(false)));
        }
    }
}
