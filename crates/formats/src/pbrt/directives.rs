//! The directives: words that open a line of a scene, and what each does to the graphics state.

use super::state::{ScopeKind, TARGETS};
use super::tokens::{Mistake, Token, Tokens, shortened};
use super::transforms::{look_at, rotation};
use super::values::{Entry, List};
use super::{MAX_MISTAKES, Reader};
use crate::files::plain;
use etendue_description::{SourceId, Span, nearest};
use glam::{DMat4, DVec3};
use std::sync::Arc;

/// Every directive.
pub(super) const DIRECTIVES: [&str; 42] = [
    "Accelerator",
    "ActiveTransform",
    "AreaLightSource",
    "Attribute",
    "AttributeBegin",
    "AttributeEnd",
    "Camera",
    "ColorSpace",
    "ConcatTransform",
    "CoordSysTransform",
    "CoordinateSystem",
    "Film",
    "Identity",
    "Import",
    "Include",
    "Integrator",
    "LightSource",
    "LookAt",
    "MakeNamedMaterial",
    "MakeNamedMedium",
    "Material",
    "MediumInterface",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "Option",
    "PixelFilter",
    "ReverseOrientation",
    "Rotate",
    "Sampler",
    "Scale",
    "Shape",
    "Texture",
    "Transform",
    "TransformBegin",
    "TransformEnd",
    "TransformTimes",
    "Translate",
    "WorldBegin",
    "WorldEnd",
    "SurfaceIntegrator",
];

/// Directives that stand before `WorldBegin` only, and those that stand behind it only.
const BEFORE: [&str; 8] = ["Accelerator", "Camera", "Film", "Integrator", "Option", "PixelFilter", "Sampler", "TransformTimes"];
const BEHIND: [&str; 12] = [
    "AreaLightSource",
    "Import",
    "LightSource",
    "MakeNamedMaterial",
    "Material",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "ReverseOrientation",
    "Shape",
    "Texture",
];

impl Reader<'_> {
    /// A whole file.
    pub(super) fn file(&mut self, source: SourceId) {
        let path = self.description.sources.path(source).to_path_buf();
        let text = self.description.sources.shared_text(source);
        self.chain.push(plain(&path));
        let mut tokens = Tokens::new(&text);
        let before = self.mistakes;
        loop {
            let told = self.mistakes;
            match tokens.next() {
                Ok(Token::End) => break,
                Ok(Token::Word(range)) => {
                    let span = self.span(source, range.clone());
                    self.directive(&mut tokens, source, &text[range], span);
                }
                Ok(Token::Quoted(r)) => self.stray(source, Mistake { range: r.clone(), message: stray_words(&text[r]) }),
                Ok(Token::Open(at) | Token::Close(at)) => {
                    self.stray(source, Mistake { range: at..at + 1, message: "a directive must stand here".to_owned() });
                }
                Err(mistake) => self.stray(source, mistake),
            }
            if self.mistakes > told {
                self.broken = true;
                resynchronise(&mut tokens);
            }
            if self.mistakes - before >= MAX_MISTAKES {
                let at = tokens.at.min(text.len());
                let span = self.span(source, at..at);
                self.diagnostics.error(span, format!("{MAX_MISTAKES} mistakes in the words of this file: the rest is not read"));
                break;
            }
        }
        self.chain.pop();
    }

    /// A mistake in the words: reading goes on at the next directive.
    pub(super) fn stray(&mut self, source: SourceId, mistake: Mistake) {
        self.mistakes += 1;
        let span = self.span(source, mistake.range);
        self.diagnostics.error(span, mistake.message);
    }

    fn directive(&mut self, t: &mut Tokens, source: SourceId, word: &str, span: Span) {
        if BEFORE.contains(&word) && self.world {
            self.diagnostics.error(span, format!("`{word}` belongs before `WorldBegin`"));
        }
        if BEHIND.contains(&word) && !self.world {
            self.diagnostics.error(span, format!("`{word}` belongs behind `WorldBegin`"));
        }
        match word {
            "Identity" => self.set_transform(DMat4::IDENTITY),
            "Translate" => self.step(t, source, span, |[x, y, z]| Some(DMat4::from_translation(DVec3::new(x, y, z)))),
            "Scale" => self.step(t, source, span, |[x, y, z]| Some(DMat4::from_scale(DVec3::new(x, y, z)))),
            "Rotate" => self
                .step(t, source, span, |[angle, x, y, z]| Some(rotation(DVec3::new(x, y, z).try_normalize()?, angle.to_radians()))),
            "LookAt" => self.step(t, source, span, |n: [f64; 9]| {
                let at = |i: usize| DVec3::new(n[i], n[i + 1], n[i + 2]);
                look_at(at(0), at(3), at(6))
            }),
            "Transform" => {
                if let Some(m) = self.numbers::<16>(t, source, span) {
                    self.set_transform(DMat4::from_cols_array(&m));
                }
            }
            "ConcatTransform" => self.step(t, source, span, |m: [f64; 16]| Some(DMat4::from_cols_array(&m))),
            "CoordinateSystem" => {
                if let Some((name, _)) = self.quoted(t, source, span, "the name of a coordinate system") {
                    self.systems.insert(name, self.state.ctm);
                }
            }
            "CoordSysTransform" => {
                if let Some((name, at)) = self.quoted(t, source, span, "the name of a coordinate system") {
                    match self.systems.get(&name) {
                        Some(ctm) => self.state.ctm = *ctm,
                        None => {
                            let known = self.systems.keys().map(String::as_str);
                            let near = nearest(&name, known).map(|n| format!("did you mean `{n}`?"));
                            let error = self.diagnostics.error(at, format!("there is no coordinate system `{name}`"));
                            error.help.extend(near);
                        }
                    }
                }
            }
            "ActiveTransform" => self.active_transform(t, source, span),
            "TransformTimes" => drop(self.numbers::<2>(t, source, span)),
            "ReverseOrientation" => self.state.reverse_orientation ^= true,
            "ColorSpace" => {
                if let Some((name, at)) = self.quoted(t, source, span, "the name of a colour space") {
                    self.colour_space(&name, at);
                }
            }
            "AttributeBegin" => self.begin(ScopeKind::Attribute, span),
            "AttributeEnd" => self.end(ScopeKind::Attribute, span),
            "TransformBegin" => self.begin(ScopeKind::Transform, span),
            "TransformEnd" => self.end(ScopeKind::Transform, span),
            "Attribute" => self.attribute(t, source, span),
            "ObjectBegin" => self.object_begin(t, source, span),
            "ObjectEnd" => self.end(ScopeKind::Object, span),
            "ObjectInstance" => self.object_instance(t, source, span),
            "Include" => self.include(t, source, span, false),
            "Import" => self.include(t, source, span, true),
            "WorldBegin" => self.world_begin(span),
            "WorldEnd" => drop(self.diagnostics.warning(span, "`WorldEnd` is a word of pbrt-v3; it has no meaning here")),
            "Option" => self.option(t, source),
            "Accelerator" => {
                let _ = self.quoted(t, source, span, "the name of an accelerator");
                self.entries(t, source);
            }
            "MediumInterface" => self.medium_interface(t, source, span),
            "NamedMaterial" => {
                if let Some((name, at)) = self.quoted(t, source, span, "the name of a material") {
                    self.state.material = Some(self.named(super::Named::Material, &name, at));
                }
            }
            "Texture" => self.texture(t, source, span),
            "MakeNamedMaterial" | "MakeNamedMedium" => {
                let Some((name, at)) = self.quoted(t, source, span, "a name") else { return };
                let Some(entries) = self.entries(t, source) else { return };
                let target = if word == "MakeNamedMaterial" { 2 } else { 3 };
                let list = List::new(format!("{} `{name}`", TARGETS[target]), at, entries, &self.state.defaults[target]);
                if target == 2 { self.make_named_material(name, at, list) } else { self.make_named_medium(name, at, list) }
            }
            "Shape" | "LightSource" | "AreaLightSource" | "Material" | "Camera" | "Film" | "PixelFilter" | "Sampler"
            | "Integrator" => {
                let Some((name, at)) = self.quoted(t, source, span, "the name of a model in quotes") else { return };
                let Some(entries) = self.entries(t, source) else { return };
                self.model(word, name, at, entries);
            }
            _ => {
                self.mistakes += 1;
                let error = self.diagnostics.error(span, format!("unknown directive `{}`", shortened(word)));
                match word {
                    "SurfaceIntegrator" | "VolumeIntegrator" | "Volume" | "Renderer" => {
                        error.help("this is a scene of pbrt-v2; pbrt-v4 scenes are read");
                    }
                    _ => drop(error.suggest(word, DIRECTIVES.into_iter().filter(|d| *d != "SurfaceIntegrator"))),
                }
            }
        }
    }

    /// A model with its parameters.
    fn model(&mut self, word: &str, name: String, at: Span, entries: Vec<Entry>) {
        let none = Arc::new(Vec::new());
        let defaults = match word {
            "Shape" => self.state.defaults[0].clone(),
            "LightSource" | "AreaLightSource" => self.state.defaults[1].clone(),
            "Material" => self.state.defaults[2].clone(),
            _ => none,
        };
        let kind = match word {
            "LightSource" => "light".to_owned(),
            "AreaLightSource" => "area light".to_owned(),
            "PixelFilter" => "filter".to_owned(),
            _ => word.to_lowercase(),
        };
        let list = List::new(format!("{kind} `{name}`"), at, entries, &defaults);
        match word {
            "Shape" => self.shape(&name, list),
            "LightSource" => self.light(&name, list),
            "AreaLightSource" => self.state.area_light = Some(Arc::new(list)),
            "Material" => self.state.material = Some(self.material(&name, list)),
            _ => self.setup.keep(word, name, list, &self.state, &mut self.systems, &mut self.diagnostics),
        }
    }
}

fn stray_words(text: &str) -> String {
    format!("the string \"{}\" belongs to no directive", shortened(text))
}

/// To the next word that is a directive.
fn resynchronise(t: &mut Tokens) {
    loop {
        match t.peek() {
            Ok(Token::End) => return,
            Ok(Token::Word(r)) if DIRECTIVES.contains(&&t.text[r.clone()]) => return,
            _ => drop(t.next()),
        }
    }
}
