//! Parameter lists: `"type name" [values]`, asked by name, each with its place.
//!
//! | type | values | kept as |
//! | --- | --- | --- |
//! | `integer` | whole numbers of 32 bits | i32 |
//! | `float`, `rgb`, `blackbody` | numbers | f64 |
//! | `point2`, `vector2`, `point3`, `vector3`, `normal3`; `point`, `vector`, `normal` | 2 or 3 numbers each | f32 |
//! | `spectrum` | wavelengths in nm and values in turn, or a name or a file | f64 or text |
//! | `bool` | `true`, `false`, with or without quotes | bool |
//! | `string`, `texture` | texts in quotes | text |
//!
//! One value needs no brackets. What nobody asked for is an error that names the nearest known parameter.

use etendue_description::{Diagnostics, Span};
use glam::{DVec3, Vec2, Vec3};
use std::ops::Range;
use std::sync::Arc;

/// The type of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    Integer,
    Float,
    Point2,
    Vector2,
    Point3,
    Vector3,
    Normal,
    Rgb,
    Blackbody,
    Spectrum,
    Bool,
    Text,
    Texture,
}

const TYPES: [(&str, Type); 17] = [
    ("integer", Type::Integer),
    ("float", Type::Float),
    ("point2", Type::Point2),
    ("vector2", Type::Vector2),
    ("point3", Type::Point3),
    ("point", Type::Point3),
    ("vector3", Type::Vector3),
    ("vector", Type::Vector3),
    ("normal3", Type::Normal),
    ("normal", Type::Normal),
    ("rgb", Type::Rgb),
    ("blackbody", Type::Blackbody),
    ("spectrum", Type::Spectrum),
    ("bool", Type::Bool),
    ("string", Type::Text),
    ("texture", Type::Texture),
    ("color", Type::Rgb),
];

impl Type {
    /// The type of a name; the old `color` is told apart by the caller.
    pub fn named(word: &str) -> Option<Self> {
        TYPES.iter().find(|(name, _)| *name == word).map(|(_, t)| *t)
    }

    pub fn names() -> impl Iterator<Item = &'static str> {
        TYPES.iter().map(|(name, _)| *name).filter(|name| *name != "color")
    }

    pub fn name(self) -> &'static str {
        TYPES.iter().find(|(_, t)| *t == self).map_or("", |(name, _)| name)
    }

    /// An empty list for values of the type; of a spectrum `text` tells whether a name follows.
    pub fn empty(self, text: bool) -> Values {
        match self {
            Self::Integer => Values::Integers(Vec::new()),
            Self::Float | Self::Rgb | Self::Blackbody => Values::Doubles(Vec::new()),
            Self::Spectrum if !text => Values::Doubles(Vec::new()),
            Self::Point2 | Self::Vector2 | Self::Point3 | Self::Vector3 | Self::Normal => Values::Singles(Vec::new()),
            Self::Bool => Values::Bools(Vec::new()),
            Self::Spectrum | Self::Text | Self::Texture => Values::Texts(Vec::new()),
        }
    }

    /// How many numbers make one value.
    pub fn group(self) -> usize {
        match self {
            Self::Point2 | Self::Vector2 => 2,
            Self::Point3 | Self::Vector3 | Self::Normal | Self::Rgb => 3,
            _ => 1,
        }
    }
}

/// Texts, each with its bytes in the file.
pub(super) type Texts = Vec<(String, Range<usize>)>;

/// A list of values.
#[derive(Clone, Debug)]
pub(super) enum Values {
    Singles(Vec<f32>),
    Doubles(Vec<f64>),
    Integers(Vec<i32>),
    Bools(Vec<bool>),
    Texts(Texts),
}

impl Values {
    pub fn len(&self) -> usize {
        match self {
            Self::Singles(v) => v.len(),
            Self::Doubles(v) => v.len(),
            Self::Integers(v) => v.len(),
            Self::Bools(v) => v.len(),
            Self::Texts(v) => v.len(),
        }
    }
}

/// Numbers as bytes of a text.
pub(super) trait Numbers: Copy {
    const WHAT: &'static str;
    /// The number that a text begins with, and its length.
    fn parse(bytes: &[u8]) -> Option<(Self, usize)>;
    fn is_sane(self) -> bool;
}

/// The sign that fast_float2 does not know.
#[inline]
fn plus(bytes: &[u8]) -> (&[u8], usize) {
    match bytes {
        [b'+', rest @ ..] if rest.first() != Some(&b'-') => (rest, 1),
        _ => (bytes, 0),
    }
}

/// Both are kept as f32 in the end: a number beyond its range is none.
macro_rules! real {
    ($($float:ty),*) => {
        $(impl Numbers for $float {
            const WHAT: &'static str = "number";
            #[inline]
            fn parse(bytes: &[u8]) -> Option<(Self, usize)> {
                let (bytes, sign) = plus(bytes);
                fast_float2::parse_partial(bytes).ok().map(|(x, n)| (x, n + sign))
            }
            #[inline]
            fn is_sane(self) -> bool {
                (self as f32).is_finite()
            }
        })*
    };
}

real!(f32, f64);

impl Numbers for i32 {
    const WHAT: &'static str = "whole number";
    #[inline]
    fn parse(bytes: &[u8]) -> Option<(Self, usize)> {
        let (negative, start) = match bytes.first()? {
            b'-' => (true, 1),
            b'+' => (false, 1),
            _ => (false, 0),
        };
        let mut at = start;
        let mut x = 0i64;
        while let Some(digit) = bytes.get(at).map(|b| b.wrapping_sub(b'0')).filter(|d| *d < 10) {
            x = x * 10 + i64::from(digit);
            if x > 1 << 31 {
                return None;
            }
            at += 1;
        }
        let x = i32::try_from(if negative { -x } else { x }).ok()?;
        (at > start).then_some((x, at))
    }
    #[inline]
    fn is_sane(self) -> bool {
        true
    }
}

/// A parameter as it is written.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub kind: Type,
    pub name: String,
    /// The place of `"type name"`.
    pub declared: Span,
    /// The place of the values.
    pub span: Span,
    pub values: Values,
    used: bool,
    /// Whether it comes from an `Attribute` directive: nobody need ask for it.
    pub default: bool,
}

impl Entry {
    pub fn new(kind: Type, name: String, declared: Span, span: Span, values: Values) -> Self {
        Self { kind, name, declared, span, values, used: false, default: false }
    }
}

/// Parameters of pbrt-v3, and what they became.
const OLD: [(&str, &str); 5] =
    [("mapname", "filename"), ("Kd", "reflectance"), ("Kr", "reflectance"), ("Kt", "transmittance"), ("bumpmap", "displacement")];

/// A parameter list.
#[derive(Clone, Debug)]
pub(super) struct List {
    /// Whose parameters: ``shape `sphere` ``.
    pub owner: String,
    /// The place of the owner's name.
    pub span: Span,
    pub entries: Vec<Entry>,
    asked: Vec<&'static str>,
}

impl List {
    pub fn new(owner: String, span: Span, entries: Vec<Entry>, defaults: &Arc<Vec<Entry>>) -> Self {
        let mut list = Self { owner, span, entries, asked: Vec::new() };
        for default in defaults.iter() {
            if !list.has(&default.name) {
                list.entries.push(Entry { default: true, ..default.clone() });
            }
        }
        list
    }

    /// Whether the parameter was given. Does not count as asking.
    pub fn has(&self, name: &str) -> bool {
        self.entries.iter().any(|e| e.name == name)
    }

    /// Whether it was given with this type.
    pub fn has_type(&self, name: &str, kind: Type) -> bool {
        self.entries.iter().any(|e| e.name == name && e.kind == kind)
    }

    /// The place of a parameter's values, or of the owner where it was not given.
    pub fn span_of(&self, name: &str) -> Span {
        self.entries.iter().find(|e| e.name == name).map_or(self.span, |e| e.span)
    }

    /// The parameter; counts as asked for.
    pub fn raw(&mut self, name: &'static str) -> Option<&mut Entry> {
        if !self.asked.contains(&name) {
            self.asked.push(name);
        }
        let entry = self.entries.iter_mut().find(|e| e.name == name)?;
        entry.used = true;
        Some(entry)
    }

    /// Accepts names that are understood and have no use here.
    pub fn ignore(&mut self, names: &[&'static str]) {
        for name in names {
            self.raw(name);
        }
    }

    /// The parameter, of one of the `kinds`.
    fn typed(&mut self, d: &mut Diagnostics, name: &'static str, kinds: &[Type]) -> Option<&mut Entry> {
        let owner = self.owner.clone();
        let entry = self.raw(name)?;
        if kinds.contains(&entry.kind) {
            return Some(entry);
        }
        let wanted = kinds.iter().map(|k| k.name()).collect::<Vec<_>>().join(" or ");
        d.error(entry.declared, format!("`{name}` of {owner} is a {}, expected {wanted}", entry.kind.name()));
        None
    }

    /// One value, of as many numbers as its type has.
    fn one(&mut self, d: &mut Diagnostics, name: &'static str, kinds: &[Type]) -> Option<&mut Entry> {
        let owner = self.owner.clone();
        let entry = self.typed(d, name, kinds)?;
        let (found, wanted) = (entry.values.len(), entry.kind.group());
        if found == wanted {
            return Some(entry);
        }
        let numbers = if wanted == 1 { "one value".to_owned() } else { format!("{wanted} numbers") };
        d.error(entry.span, format!("`{name}` of {owner} has {found} values, expected {numbers}"));
        None
    }

    pub fn float_opt(&mut self, d: &mut Diagnostics, name: &'static str) -> Option<f64> {
        match &self.one(d, name, &[Type::Float, Type::Integer])?.values {
            Values::Doubles(v) => Some(v[0]),
            Values::Integers(v) => Some(f64::from(v[0])),
            _ => None,
        }
    }

    pub fn float(&mut self, d: &mut Diagnostics, name: &'static str, default: f64) -> f64 {
        self.float_opt(d, name).unwrap_or(default)
    }

    /// A number above zero.
    pub fn positive(&mut self, d: &mut Diagnostics, name: &'static str, default: f64) -> f64 {
        let x = self.float(d, name, default);
        if x > 0.0 {
            return x;
        }
        d.error(self.span_of(name), format!("`{name}` of {} is {x}, expected a number above 0", self.owner));
        default
    }

    pub fn integer_opt(&mut self, d: &mut Diagnostics, name: &'static str) -> Option<i64> {
        match &self.one(d, name, &[Type::Integer])?.values {
            Values::Integers(v) => Some(i64::from(v[0])),
            _ => None,
        }
    }

    pub fn integer(&mut self, d: &mut Diagnostics, name: &'static str, default: i64, range: std::ops::RangeInclusive<i64>) -> i64 {
        let x = self.integer_opt(d, name).unwrap_or(default);
        if range.contains(&x) {
            return x;
        }
        let text = format!("`{name}` of {} is {x}, expected {} to {}", self.owner, range.start(), range.end());
        d.error(self.span_of(name), text);
        default
    }

    pub fn bool(&mut self, d: &mut Diagnostics, name: &'static str, default: bool) -> bool {
        match self.one(d, name, &[Type::Bool]).map(|e| &e.values) {
            Some(Values::Bools(v)) => v[0],
            _ => default,
        }
    }

    pub fn text_opt(&mut self, d: &mut Diagnostics, name: &'static str) -> Option<(String, Span)> {
        let entry = self.one(d, name, &[Type::Text])?;
        match &entry.values {
            Values::Texts(v) => Some((v[0].0.clone(), entry.span)),
            _ => None,
        }
    }

    /// One of a few words, the first where none was given.
    pub fn choice(&mut self, d: &mut Diagnostics, name: &'static str, choices: &[&'static str]) -> &'static str {
        let Some((word, span)) = self.text_opt(d, name) else { return choices[0] };
        if let Some(found) = choices.iter().find(|c| **c == word) {
            return found;
        }
        let text = format!("`{name}` of {} is `{word}`, expected one of: {}", self.owner, choices.join(", "));
        d.error(span, text).suggest(&word, choices.iter().copied());
        choices[0]
    }

    pub fn texts(&mut self, d: &mut Diagnostics, name: &'static str) -> Option<(Texts, Span)> {
        let entry = self.typed(d, name, &[Type::Text])?;
        match &mut entry.values {
            Values::Texts(v) => Some((std::mem::take(v), entry.span)),
            _ => None,
        }
    }

    pub fn point(&mut self, d: &mut Diagnostics, name: &'static str) -> Option<DVec3> {
        match &self.one(d, name, &[Type::Point3, Type::Vector3, Type::Normal])?.values {
            Values::Singles(v) => Some(DVec3::new(v[0].into(), v[1].into(), v[2].into())),
            _ => None,
        }
    }

    pub fn floats(&mut self, d: &mut Diagnostics, name: &'static str) -> Option<Vec<f64>> {
        match &mut self.typed(d, name, &[Type::Float, Type::Integer])?.values {
            Values::Doubles(v) => Some(std::mem::take(v)),
            Values::Integers(v) => Some(v.iter().map(|i| f64::from(*i)).collect()),
            _ => None,
        }
    }

    pub fn integers(&mut self, d: &mut Diagnostics, name: &'static str) -> Option<Vec<i32>> {
        match &mut self.typed(d, name, &[Type::Integer])?.values {
            Values::Integers(v) => Some(std::mem::take(v)),
            _ => None,
        }
    }

    fn singles(&mut self, d: &mut Diagnostics, name: &'static str, kinds: &[Type]) -> Option<Vec<f32>> {
        let owner = self.owner.clone();
        let entry = self.typed(d, name, kinds)?;
        let (n, group, span) = (entry.values.len(), entry.kind.group(), entry.span);
        if !n.is_multiple_of(group) {
            d.error(span, format!("`{name}` of {owner} has {n} numbers, expected a multiple of {group}"));
            return None;
        }
        match &mut entry.values {
            Values::Singles(v) => Some(std::mem::take(v)),
            _ => None,
        }
    }

    pub fn points(&mut self, d: &mut Diagnostics, name: &'static str) -> Option<Vec<Vec3>> {
        let numbers = self.singles(d, name, &[Type::Point3, Type::Vector3, Type::Normal])?;
        Some(numbers.as_chunks::<3>().0.iter().map(|p| Vec3::from_array(*p)).collect())
    }

    pub fn points2(&mut self, d: &mut Diagnostics, name: &'static str) -> Option<Vec<Vec2>> {
        let numbers = self.singles(d, name, &[Type::Point2, Type::Vector2])?;
        Some(numbers.as_chunks::<2>().0.iter().map(|p| Vec2::from_array(*p)).collect())
    }

    /// Ends the questions.
    pub fn finish(&mut self, d: &mut Diagnostics) {
        for entry in self.entries.iter().filter(|e| !e.used && !e.default) {
            let error = d.error(entry.declared, format!("unknown parameter `{}` of {}", entry.name, self.owner));
            match OLD.iter().find(|(old, new)| *old == entry.name && self.asked.contains(new)) {
                Some((_, new)) => drop(error.help(format!("in pbrt-v4 it is `{new}`"))),
                None => drop(error.suggest(&entry.name, self.asked.iter().copied())),
            }
        }
    }
}
