//! Looking at nodes whose parameters have been checked: what is not there, or of another type, is as if it had not been given.

use etendue_description::{Description, Kind, Node, NodeId, Param, Span, Spanned, SpectrumValue, Value};
use glam::{DMat4, DVec3};

/// The value of a parameter.
pub(super) fn get<'a>(node: &'a Node, name: &str) -> Option<&'a Value> {
    node.params.iter().find(|p| p.name.value == name).map(|p| &p.value.value)
}

pub(super) fn float(node: &Node, name: &str) -> Option<f64> {
    match get(node, name)? {
        Value::Float(x) => Some(*x),
        Value::Integer(i) => Some(*i as f64),
        Value::Spectrum(SpectrumValue::Constant(x)) => Some(*x),
        _ => None,
    }
}

pub(super) fn integer(node: &Node, name: &str) -> Option<i64> {
    if let Value::Integer(i) = get(node, name)? { Some(*i) } else { None }
}

pub(super) fn flag(node: &Node, name: &str, default: bool) -> bool {
    if let Some(Value::Bool(b)) = get(node, name) { *b } else { default }
}

pub(super) fn text<'a>(node: &'a Node, name: &str) -> Option<&'a str> {
    if let Value::String(s) = get(node, name)? { Some(s) } else { None }
}

pub(super) fn vector(node: &Node, name: &str) -> Option<DVec3> {
    if let Value::Vector(v) = get(node, name)? { Some(*v) } else { None }
}

pub(super) fn matrix(node: &Node, name: &str) -> DMat4 {
    if let Some(Value::Transform(t)) = get(node, name) { t.matrix() } else { DMat4::IDENTITY }
}

pub(super) fn child(node: &Node, name: &str) -> Option<NodeId> {
    if let Value::Node(id) = get(node, name)? { Some(*id) } else { None }
}

/// The children of a kind, named or not, in file order.
pub(super) fn children(d: &Description, id: NodeId, kind: Kind) -> Vec<NodeId> {
    nodes_in(d.node(id)).filter(|child| d.node(*child).kind == kind).collect()
}

/// All nodes that a node holds, in file order.
pub(super) fn nodes_in(node: &Node) -> impl Iterator<Item = NodeId> {
    node.params.iter().filter_map(|p| if let Value::Node(child) = p.value.value { Some(child) } else { None })
}

/// Whether a node holds a texture that is laid on by (u, v), at any depth.
pub(super) fn is_textured(d: &Description, id: NodeId) -> bool {
    let node = d.node(id);
    let elsewhere = text(node, "mapping").is_some_and(|m| m != "uv");
    let leaf = ["bitmap", "checkerboard", "bilerp", "dots"].contains(&node.model.value.as_str()) && node.kind == Kind::Texture;
    !elsewhere && (leaf || nodes_in(node).any(|child| is_textured(d, child)))
}

/// Sets a parameter, at its place where it is there.
pub(super) fn set(node: &mut Node, name: &str, value: Value) {
    match node.params.iter_mut().find(|p| p.name.value == name) {
        Some(param) => param.value.value = value,
        None => node.params.push(param(name, value, node.span)),
    }
}

/// Takes parameters out; the answer is whether any was there.
pub(super) fn remove(node: &mut Node, names: &[&str]) -> bool {
    let before = node.params.len();
    node.params.retain(|p| !names.contains(&p.name.value.as_str()));
    node.params.len() < before
}

/// Another name for a parameter.
pub(super) fn rename(node: &mut Node, from: &str, to: &str) {
    for param in node.params.iter_mut().filter(|p| p.name.value == from) {
        param.name.value = to.to_owned();
    }
}

pub(super) fn param(name: &str, value: Value, span: Span) -> Param {
    Param { name: Spanned::new(name.to_owned(), span), value: Spanned::new(value, span) }
}
