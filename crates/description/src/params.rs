//! Asking a node for its parameters. Each question names the parameter and its default in one place; wrong types and values out of
//! range are reported where they stand and answered by the default, and what nobody asked for is reported as unknown.

use crate::diagnostic::Diagnostics;
use crate::node::{Description, Kind, Node, NodeId, Param, Value};
use crate::source::Span;
use etendue_numerics::Transform;
use glam::DVec3;
use std::path::Path;

/// The parameters of one node, being asked for.
pub struct Params<'a> {
    /// The description that the node belongs to.
    pub description: &'a Description,
    /// The node.
    pub node: &'a Node,
    used: Vec<bool>,
    asked: Vec<&'static str>,
}

impl<'a> Params<'a> {
    /// Begins to ask node `id`.
    pub fn new(description: &'a Description, id: NodeId) -> Self {
        let node = description.node(id);
        Self { description, node, used: vec![false; node.params.len()], asked: Vec::new() }
    }

    /// The place of the node's model name, for messages about the node as a whole.
    pub fn span(&self) -> Span {
        self.node.model.span
    }

    /// The parameter itself, if it was given; counts as asked for.
    pub fn raw(&mut self, name: &'static str) -> Option<&'a Param> {
        self.asked.push(name);
        let node = self.node;
        let i = node.params.iter().position(|p| p.name.value == name)?;
        self.used[i] = true;
        Some(&node.params[i])
    }

    /// Whether the parameter was given. Does not count as asking.
    pub fn has(&self, name: &str) -> bool {
        self.node.params.iter().any(|p| p.name.value == name)
    }

    /// The place of a parameter's value, or of the node where it was not given.
    pub fn span_of(&self, name: &str) -> Span {
        self.node.params.iter().find(|p| p.name.value == name).map_or(self.span(), |p| p.value.span)
    }

    fn typed<T>(
        &mut self,
        diagnostics: &mut Diagnostics,
        name: &'static str,
        wanted: &str,
        convert: impl Fn(&'a Value) -> Option<T>,
    ) -> Option<T> {
        let param = self.raw(name)?;
        let value = convert(&param.value.value);
        if value.is_none() {
            let model = &self.node.model.value;
            let found = param.value.value.type_name();
            diagnostics.error(param.value.span, format!("`{name}` of `{model}` is a {found}, expected {wanted}"));
        }
        value
    }

    /// A truth value.
    pub fn bool(&mut self, diagnostics: &mut Diagnostics, name: &'static str, default: bool) -> bool {
        let value = self.typed(diagnostics, name, "a boolean", |v| if let Value::Bool(b) = v { Some(*b) } else { None });
        value.unwrap_or(default)
    }

    /// A whole number, if given.
    pub fn integer_opt(&mut self, diagnostics: &mut Diagnostics, name: &'static str) -> Option<i64> {
        self.typed(diagnostics, name, "an integer", |v| if let Value::Integer(i) = v { Some(*i) } else { None })
    }

    /// A whole number within `range`.
    pub fn integer(
        &mut self,
        diagnostics: &mut Diagnostics,
        name: &'static str,
        default: i64,
        range: std::ops::RangeInclusive<i64>,
    ) -> i64 {
        let value = self.integer_opt(diagnostics, name).unwrap_or(default);
        if range.contains(&value) {
            return value;
        }
        let text = format!("`{name}` of `{}` is {value}, expected {} to {}", self.node.model.value, range.start(), range.end());
        diagnostics.error(self.span_of(name), text);
        default
    }

    /// A real number (whole numbers count), if given; must be finite.
    pub fn float_opt(&mut self, diagnostics: &mut Diagnostics, name: &'static str) -> Option<f64> {
        let value = self.typed(diagnostics, name, "a number", |v| match v {
            Value::Float(x) => Some(*x),
            Value::Integer(i) => Some(*i as f64),
            _ => None,
        })?;
        if value.is_finite() {
            return Some(value);
        }
        diagnostics
            .error(self.span_of(name), format!("`{name}` of `{}` is {value}, expected a finite number", self.node.model.value));
        None
    }

    /// A real number within `range`.
    pub fn float(
        &mut self,
        diagnostics: &mut Diagnostics,
        name: &'static str,
        default: f64,
        range: std::ops::RangeInclusive<f64>,
    ) -> f64 {
        let value = self.float_opt(diagnostics, name).unwrap_or(default);
        if range.contains(&value) {
            return value;
        }
        let text = format!("`{name}` of `{}` is {value}, expected {} to {}", self.node.model.value, range.start(), range.end());
        diagnostics.error(self.span_of(name), text);
        default
    }

    /// A text, if given.
    pub fn string_opt(&mut self, diagnostics: &mut Diagnostics, name: &'static str) -> Option<&'a str> {
        self.typed(diagnostics, name, "a string", |v| if let Value::String(s) = v { Some(s.as_str()) } else { None })
    }

    /// One of a few words; the answer is its position among `choices`, and 0 (the default) where none was given.
    pub fn choice(&mut self, diagnostics: &mut Diagnostics, name: &'static str, choices: &[&str]) -> usize {
        let Some(word) = self.string_opt(diagnostics, name) else { return 0 };
        if let Some(i) = choices.iter().position(|c| *c == word) {
            return i;
        }
        let text = format!("`{name}` of `{}` is `{word}`, expected one of: {}", self.node.model.value, choices.join(", "));
        diagnostics.error(self.span_of(name), text).suggest(word, choices.iter().copied());
        0
    }

    /// A file, if given.
    pub fn path_opt(&mut self, diagnostics: &mut Diagnostics, name: &'static str) -> Option<&'a Path> {
        self.typed(diagnostics, name, "a file name", |v| if let Value::Path(p) = v { Some(p.as_path()) } else { None })
    }

    /// A point or vector, if given.
    pub fn vector_opt(&mut self, diagnostics: &mut Diagnostics, name: &'static str) -> Option<DVec3> {
        self.typed(diagnostics, name, "a point or vector", |v| if let Value::Vector(p) = v { Some(*p) } else { None })
    }

    /// A transform; the identity where none was given.
    pub fn transform(&mut self, diagnostics: &mut Diagnostics, name: &'static str) -> Transform {
        let value = self.typed(diagnostics, name, "a transform", |v| if let Value::Transform(t) = v { Some(**t) } else { None });
        value.unwrap_or_default()
    }

    /// A spectrum-valued parameter as it stands: rgb, spectrum, a number or a texture node. The caller converts.
    pub fn spectrum_opt(&mut self, diagnostics: &mut Diagnostics, name: &'static str) -> Option<&'a Param> {
        let param = self.raw(name)?;
        let ok = match &param.value.value {
            Value::Rgb(_) | Value::Float(_) | Value::Integer(_) | Value::Spectrum(_) => true,
            Value::Node(id) => self.description.node(*id).kind == Kind::Texture,
            _ => false,
        };
        if ok {
            return Some(param);
        }
        let found = param.value.value.type_name();
        let text =
            format!("`{name}` of `{}` is a {found}, expected a colour, a spectrum, a number or a texture", self.node.model.value);
        diagnostics.error(param.value.span, text);
        None
    }

    /// The children of a kind, named or not, in file order; each with its parameter for its name and place.
    pub fn children(&mut self, kind: Kind) -> Vec<(NodeId, &'a Param)> {
        let mut found = Vec::new();
        for (i, param) in self.node.params.iter().enumerate() {
            if let Value::Node(id) = param.value.value
                && self.description.node(id).kind == kind
                && !self.used[i]
            {
                self.used[i] = true;
                found.push((id, param));
            }
        }
        found
    }

    /// Accepts names that étendue understands and has no use for.
    pub fn ignore(&mut self, names: &[&'static str]) {
        for name in names {
            self.raw(name);
        }
    }

    /// Ends the questions: whatever was given and not asked for is an error that names the nearest known parameter.
    pub fn finish(self, diagnostics: &mut Diagnostics) {
        for (param, used) in self.node.params.iter().zip(&self.used) {
            if *used {
                continue;
            }
            let (name, model) = (&param.name.value, &self.node.model.value);
            if name.is_empty() {
                let what = match param.value.value {
                    Value::Node(id) => {
                        let child = self.description.node(id);
                        format!("{} `{}`", child.kind.name(), child.model.value)
                    }
                    _ => param.value.value.type_name().to_owned(),
                };
                diagnostics.error(param.value.span, format!("`{model}` has no place for a nested {what}"));
            } else {
                diagnostics
                    .error(param.name.span, format!("unknown parameter `{name}` of {} `{model}`", self.node.kind.name()))
                    .suggest(name, self.asked.iter().copied());
            }
        }
    }
}
