//! The directives: words that open a line of a scene, and what each does to the graphics state.

use super::state::{Scope, ScopeKind, TARGETS};
use super::tokens::{Mistake, Token, Tokens, shortened};
use super::values::{Entry, List, Type};
use super::{MAX_MISTAKES, Object, Reader, child, param};
use crate::files::plain;
use etendue_description::{Kind, SourceId, Span, Value, nearest};
use etendue_numerics::Transform;
use glam::{DMat4, DVec3};
use std::path::PathBuf;
use std::sync::Arc;

/// Blocks may be nested this deep.
const MAX_DEPTH: usize = 1000;
/// Files may include each other this deep, and this often in all.
const MAX_INCLUDES: usize = 64;

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

/// What `Option` knows.
const OPTIONS: [&str; 12] = [
    "disablepixeljitter",
    "disabletexturefiltering",
    "disablewavelengthjitter",
    "displacementedgescale",
    "forcediffuse",
    "msereferenceimage",
    "msereferenceout",
    "pixelstats",
    "rendercoordsys",
    "seed",
    "wavefront",
    "writepartialimages",
];

/// Those of them that would change the picture, and what happens instead.
const DISOBEYED: [(&str, &str); 3] = [
    ("disablepixeljitter", "samples lie anywhere in their pixels"),
    ("disablewavelengthjitter", "every sample has wavelengths of its own"),
    ("forcediffuse", "materials stay what they are"),
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
    fn stray(&mut self, source: SourceId, mistake: Mistake) {
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

    // ---- words behind a directive

    /// A quoted string.
    pub(super) fn quoted(&mut self, t: &mut Tokens, source: SourceId, directive: Span, what: &str) -> Option<(String, Span)> {
        match t.peek() {
            Ok(Token::Quoted(r)) => {
                let _ = t.next();
                let span = self.span(source, r.clone());
                match super::tokens::unescaped(&t.text[r]) {
                    Ok(text) => Some((text, span)),
                    Err(why) => {
                        self.diagnostics.error(span, why);
                        None
                    }
                }
            }
            Err(mistake) => {
                let _ = t.next();
                self.stray(source, mistake);
                None
            }
            Ok(_) => {
                self.mistakes += 1;
                self.diagnostics.error(directive, format!("{what} must follow"));
                None
            }
        }
    }

    /// All quoted strings that follow, and the place of the last.
    pub(super) fn names(&mut self, t: &mut Tokens, source: SourceId, directive: Span) -> (Vec<String>, Span) {
        let (mut names, mut place) = (Vec::new(), directive);
        while let Ok(Token::Quoted(_)) = t.peek() {
            let Some((name, at)) = self.quoted(t, source, directive, "a name") else { break };
            names.push(name);
            place = at;
        }
        (names, place)
    }

    /// `N` numbers, with or without brackets.
    fn numbers<const N: usize>(&mut self, t: &mut Tokens, source: SourceId, directive: Span) -> Option<[f64; N]> {
        let mut values = Type::Float.empty(false);
        let bracketed = matches!(t.peek(), Ok(Token::Open(_)));
        for _ in 0..if bracketed { 1 } else { N } {
            if matches!(t.peek(), Ok(Token::Word(r)) if t.text[r.clone()].starts_with(|c: char| c.is_ascii_uppercase())) {
                break;
            }
            if let Err(mistake) = t.values(&mut values) {
                let _ = t.next();
                self.stray(source, mistake);
                return None;
            }
        }
        let super::values::Values::Doubles(list) = values else { return None };
        let found = list.len();
        let numbers = list.try_into().ok();
        if numbers.is_none() {
            self.mistakes += 1;
            self.diagnostics.error(directive, format!("{N} numbers must follow, found {found}"));
        }
        numbers
    }

    /// Parameters, as many as follow; `None` where the values of one could not be read, which is told and is enough about their owner.
    pub(super) fn entries(&mut self, t: &mut Tokens, source: SourceId) -> Option<Vec<Entry>> {
        let mut entries: Vec<Entry> = Vec::new();
        let mut sound = true;
        loop {
            let declaration = match t.peek() {
                Ok(Token::Quoted(r)) => {
                    let _ = t.next();
                    r
                }
                Err(mistake) => {
                    let _ = t.next();
                    self.stray(source, mistake);
                    return None;
                }
                Ok(_) => return sound.then_some(entries),
            };
            let declared = self.span(source, declaration.clone());
            let text = &t.text[declaration];
            let mut words = text.split_ascii_whitespace();
            let kind = match (words.next(), words.next(), words.next()) {
                (Some(kind), Some(name), None) => match Type::named(kind) {
                    Some(found) => {
                        if kind == "color" {
                            self.diagnostics.error(declared, "the type `color` is one of pbrt-v3").help("in pbrt-v4 it is `rgb`");
                        }
                        Some((found, name))
                    }
                    None => {
                        let error = self.diagnostics.error(declared, format!("unknown type `{}` of a parameter", shortened(kind)));
                        match kind {
                            "xyz" => drop(error.help("pbrt-v4 has no XYZ colours: give `rgb` or `spectrum`")),
                            _ => drop(error.suggest(kind, Type::names())),
                        }
                        None
                    }
                },
                _ => {
                    let text = format!("\"{}\" declares no parameter", shortened(text));
                    self.diagnostics
                        .error(declared, text)
                        .help("a parameter is declared by \"type name\", such as \"float radius\"");
                    None
                }
            };
            let is_text = matches!(kind, Some((Type::Spectrum, _))) && spectrum_is_text(t);
            let mut values = match kind {
                Some((kind, _)) => kind.empty(is_text),
                None if spectrum_is_text(t) => Type::Text.empty(false),
                None => Type::Float.empty(false),
            };
            match t.values(&mut values) {
                Ok(range) => {
                    let Some((kind, name)) = kind else { continue };
                    if let Some(first) = entries.iter().find(|e| e.name == name) {
                        let first = first.declared;
                        self.diagnostics
                            .error(declared, format!("parameter `{name}` is given twice"))
                            .label(first, "first given here");
                        continue;
                    }
                    let span = self.span(source, range);
                    entries.push(Entry::new(kind, name.to_owned(), declared, span, values));
                }
                Err(mistake) => {
                    // The rest of this list is lost, and the directive goes on behind it.
                    sound = false;
                    if kind.is_some() {
                        self.broken = true;
                        let span = self.span(source, mistake.range);
                        self.diagnostics.error(span, mistake.message);
                        self.mistakes += usize::from(!skip_list(t));
                    } else {
                        skip_list(t);
                    }
                    if self.mistakes >= MAX_MISTAKES {
                        return None;
                    }
                }
            }
        }
    }

    // ---- transforms

    fn step<const N: usize>(&mut self, t: &mut Tokens, source: SourceId, span: Span, make: impl Fn([f64; N]) -> Option<DMat4>) {
        let Some(numbers) = self.numbers::<N>(t, source, span) else { return };
        match make(numbers).filter(|m| Transform::new(*m).is_some()) {
            Some(m) => self.state.apply(m),
            None => {
                self.diagnostics
                    .error(span, "this step flattens space, has no direction, or is not finite")
                    .help("a transform must have an inverse");
            }
        }
    }

    fn set_transform(&mut self, m: DMat4) {
        for i in 0..2 {
            if self.state.active[i] {
                self.state.ctm[i] = m;
            }
        }
    }

    fn active_transform(&mut self, t: &mut Tokens, source: SourceId, span: Span) {
        let word = match t.peek() {
            Ok(Token::Word(r)) => {
                let _ = t.next();
                t.text[r].to_owned()
            }
            _ => String::new(),
        };
        self.state.active = match word.as_str() {
            "StartTime" => [true, false],
            "EndTime" => [false, true],
            "All" => [true, true],
            _ => {
                self.mistakes += 1;
                let _ = source;
                self.diagnostics.error(span, "`ActiveTransform` is followed by StartTime, EndTime or All");
                return;
            }
        };
    }

    /// The transform in force, of something that cannot move; `None` where it has no inverse, which is told.
    pub(super) fn still(&mut self, span: Span, what: &str) -> Option<Transform> {
        if self.state.moves() {
            let text = format!("{what} moves: motion cannot be rendered yet");
            self.diagnostics.error(span, text).help("take out `ActiveTransform`, and it stands still");
        }
        let transform = Transform::new(self.state.ctm[0]);
        if transform.is_none() {
            self.diagnostics.error(span, format!("the transform of {what} flattens space or is not finite"));
        }
        transform
    }

    // ---- blocks

    fn begin(&mut self, kind: ScopeKind, span: Span) {
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

    fn end(&mut self, kind: ScopeKind, span: Span) {
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

    fn attribute(&mut self, t: &mut Tokens, source: SourceId, span: Span) {
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

    fn object_begin(&mut self, t: &mut Tokens, source: SourceId, span: Span) {
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

    fn object_instance(&mut self, t: &mut Tokens, source: SourceId, span: Span) {
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

    // ---- files and options

    fn include(&mut self, t: &mut Tokens, source: SourceId, span: Span, import: bool) {
        let Some((name, at)) = self.quoted(t, source, span, "the name of a file") else { return };
        let Some(path) = self.find(&name, at) else {
            self.broken = true;
            return;
        };
        if self.chain.contains(&plain(&path)) {
            let chain = self.chain.iter().map(|p| format!("`{}`", p.display())).chain([format!("`{}`", path.display())]);
            let chain = chain.collect::<Vec<_>>().join(", which includes ");
            self.diagnostics.error(at, format!("`{name}` includes itself")).help(chain);
            return;
        }
        if self.chain.len() >= MAX_INCLUDES {
            self.diagnostics.error(at, format!("files include each other more than {MAX_INCLUDES} deep"));
            return;
        }
        match self.files.read_text(&path) {
            Ok(text) => {
                let included = self.description.sources.add_included(path, text, at);
                // What an imported file does to the state ends with it.
                let before = import.then(|| self.state.clone());
                self.file(included);
                before.into_iter().for_each(|state| self.state = state);
            }
            Err(why) => {
                self.diagnostics.error(at, format!("`{}` cannot be read: {why}", path.display()));
                self.broken = true;
            }
        }
    }

    /// The path of a file that the scene names.
    pub(super) fn find(&mut self, name: &str, span: Span) -> Option<PathBuf> {
        let including = self.chain.last().and_then(|p| p.parent()).map(PathBuf::from).unwrap_or_default();
        let mut folders = vec![self.folder.clone()];
        if plain(&including) != plain(&self.folder) {
            folders.push(including);
        }
        folders.extend(self.files.options.search_paths.iter().cloned());
        self.files.find(name, span, &folders, &mut self.searches, &mut self.diagnostics)
    }

    fn option(&mut self, t: &mut Tokens, source: SourceId) {
        for entry in self.entries(t, source).unwrap_or_default() {
            // pbrt drops capitals and underscores.
            let name: String = entry.name.chars().filter(|c| *c != '_').collect::<String>().to_lowercase();
            if !OPTIONS.contains(&name.as_str()) {
                self.diagnostics.error(entry.declared, format!("unknown option `{}`", entry.name)).suggest(&name, OPTIONS);
            } else if let Some((_, why)) = DISOBEYED.iter().find(|(option, _)| *option == name)
                && matches!(&entry.values, super::values::Values::Bools(v) if v.first() == Some(&true))
            {
                self.diagnostics.warning(entry.declared, format!("`{}` is not obeyed: {why}", entry.name));
            }
        }
    }
}

fn stray_words(text: &str) -> String {
    format!("the string \"{}\" belongs to no directive", shortened(text))
}

/// Whether the values that follow begin with a string.
fn spectrum_is_text(t: &mut Tokens) -> bool {
    let at = t.at;
    let mut token = t.next();
    if matches!(token, Ok(Token::Open(_))) {
        token = t.next();
    }
    t.at = at;
    matches!(token, Ok(Token::Quoted(_)))
}

/// Behind a broken list: past its closing bracket. `false` where a directive comes first.
fn skip_list(t: &mut Tokens) -> bool {
    loop {
        match t.peek() {
            Ok(Token::End) => return false,
            Ok(Token::Close(_)) => {
                let _ = t.next();
                return true;
            }
            Ok(Token::Word(r)) if DIRECTIVES.contains(&&t.text[r.clone()]) => return false,
            Ok(Token::Quoted(r)) if t.text[r.clone()].split_ascii_whitespace().next().and_then(Type::named).is_some() => {
                return true;
            }
            _ => drop(t.next()),
        }
    }
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

/// Rodrigues' rotation around a unit axis.
fn rotation(axis: DVec3, angle: f64) -> DMat4 {
    DMat4::from_axis_angle(axis, angle)
}

/// From the world into the coordinates of a camera (x right, y up, z ahead) at `eye` that looks at `at`.
fn look_at(eye: DVec3, at: DVec3, up: DVec3) -> Option<DMat4> {
    let ahead = (at - eye).try_normalize()?;
    let right = up.try_normalize()?.cross(ahead).try_normalize()?;
    let up = ahead.cross(right);
    let to_world = DMat4::from_cols(right.extend(0.0), up.extend(0.0), ahead.extend(0.0), eye.extend(1.0));
    Some(to_world.inverse())
}
