//! What restores the graphics state when it ends: attribute and transform blocks, and objects with their instances.

use super::state::{Scope, ScopeKind, TARGETS};
use super::tokens::Tokens;
use super::{MAX_MISTAKES, Object, Reader, child, param};
use etendue_description::{Kind, SourceId, Span, Value, nearest};
use std::sync::Arc;

/// Blocks may be nested this deep.
const MAX_DEPTH: usize = 1000;

impl Reader<'_> {
    pub(super) fn begin(&mut self, kind: ScopeKind, span: Span) {
        if self.scopes.len() >= MAX_DEPTH {
            // Told once; the blocks beyond are not opened, and neither are they closed.
            if self.scopes.len() == MAX_DEPTH && !self.told.contains(&"depth") {
                self.told.push("depth");
                self.diagnostics.error(span, format!("blocks are nested more than {MAX_DEPTH} deep"));
            }
            self.mistakes += MAX_MISTAKES;
            return;
        }
        self.scopes.push(Scope { kind, state: self.state.clone(), span });
    }

    pub(super) fn end(&mut self, kind: ScopeKind, span: Span) {
        match self.scopes.last() {
            Some(scope) if scope.kind == kind => {
                let Some(scope) = self.scopes.pop() else { return };
                match kind {
                    ScopeKind::Transform => {
                        self.state.ctm = scope.state.ctm;
                        self.state.active = scope.state.active;
                    }
                    ScopeKind::Attribute => self.state = scope.state,
                    ScopeKind::Object => {
                        self.state = scope.state;
                        self.object = None;
                    }
                }
            }
            Some(scope) => {
                let (open, at) = (scope.kind, scope.span);
                self.diagnostics
                    .error(span, format!("`{}` closes nothing: `{}` is open here", kind.end(), open.begin()))
                    .label(at, "opened here");
            }
            None => {
                let text = format!("`{}` closes nothing: no `{}` is open here", kind.end(), kind.begin());
                self.diagnostics.error(span, text);
            }
        }
    }

    pub(super) fn attribute(&mut self, t: &mut Tokens, source: SourceId, span: Span) {
        let Some((target, at)) = self.quoted(t, source, span, "what the defaults are for") else { return };
        let Some(entries) = self.entries(t, source) else { return };
        let Some(i) = TARGETS.iter().position(|name| *name == target) else {
            self.diagnostics
                .error(at, format!("`Attribute` knows no `{target}`"))
                .suggest(&target, TARGETS)
                .help(format!("known: {}", TARGETS.join(", ")));
            return;
        };
        let defaults = Arc::make_mut(&mut self.state.defaults[i]);
        for entry in entries {
            defaults.retain(|known| known.name != entry.name);
            defaults.push(entry);
        }
    }

    pub(super) fn object_begin(&mut self, t: &mut Tokens, source: SourceId, span: Span) {
        let Some((name, at)) = self.quoted(t, source, span, "the name of an object") else { return };
        if self.object.is_some() {
            self.diagnostics.error(span, "an object cannot be defined within another one");
        }
        self.begin(ScopeKind::Object, span);
        let group = self.top(Kind::Shape, "shapegroup", at, Vec::new());
        self.object = Some(group);
        self.description.nodes[group.0 as usize].id = Some(etendue_description::Spanned::new(name.clone(), at));
        match self.objects.get(&name) {
            Some(first) => {
                let first = first.span;
                self.diagnostics.error(at, format!("the object `{name}` is defined twice")).label(first, "first defined here");
            }
            None => drop(self.objects.insert(name, Object { group, span: at })),
        }
    }

    pub(super) fn object_instance(&mut self, t: &mut Tokens, source: SourceId, span: Span) {
        let Some((name, at)) = self.quoted(t, source, span, "the name of an object") else { return };
        if self.object.is_some() {
            self.diagnostics.error(span, "`ObjectInstance` cannot stand within the definition of an object");
            return;
        }
        let Some(Object { group, .. }) = self.objects.get(&name).copied() else {
            let near = nearest(&name, self.objects.keys().map(String::as_str)).map(|n| format!("did you mean `{n}`?"));
            let error = self.diagnostics.error(at, format!("there is no object `{name}`"));
            error.help.extend(near);
            return;
        };
        let Some(to_world) = self.still(at, "this instance") else { return };
        // An object without shapes shows nothing.
        if self.description.node(group).params.is_empty() {
            return;
        }
        let params = vec![param("to_world", Value::Transform(Box::new(to_world)), at), child(group, at)];
        self.top(Kind::Shape, "instance", at, params);
    }
}
