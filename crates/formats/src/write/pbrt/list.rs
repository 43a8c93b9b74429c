//! Directives with their parameter lists, as text.

use super::super::text::{number, numbers, single};
use glam::{DMat4, DVec3, Vec2, Vec3};

/// Parameters, each a line of its own.
#[derive(Clone, Debug, Default)]
pub(super) struct List(Vec<String>);

impl List {
    fn push(&mut self, kind: &str, name: &str, value: String) {
        self.0.push(format!("\"{kind} {name}\" {value}"));
    }

    pub fn float(&mut self, name: &str, x: f64) {
        self.push("float", name, number(x));
    }

    pub fn floats(&mut self, name: &str, list: &[f64]) {
        self.push("float", name, format!("[ {} ]", numbers(list, " ")));
    }

    pub fn integer(&mut self, name: &str, x: i64) {
        self.push("integer", name, x.to_string());
    }

    pub fn integers(&mut self, name: &str, list: impl IntoIterator<Item = i64>) {
        self.push("integer", name, listed(list.into_iter().map(|i| i.to_string())));
    }

    pub fn bool(&mut self, name: &str, x: bool) {
        self.push("bool", name, x.to_string());
    }

    pub fn string(&mut self, name: &str, text: &str) {
        self.push("string", name, quoted(text));
    }

    pub fn strings(&mut self, name: &str, texts: &[String]) {
        self.push("string", name, format!("[ {} ]", texts.iter().map(|t| quoted(t)).collect::<Vec<_>>().join(" ")));
    }

    pub fn texture(&mut self, name: &str, texture: &str) {
        self.push("texture", name, quoted(texture));
    }

    pub fn rgb(&mut self, name: &str, rgb: [f64; 3]) {
        self.push("rgb", name, format!("[ {} ]", numbers(&rgb, " ")));
    }

    pub fn blackbody(&mut self, name: &str, kelvin: f64) {
        self.push("blackbody", name, number(kelvin));
    }

    /// A spectrum by wavelengths and values.
    pub fn spectrum(&mut self, name: &str, pairs: &[(f64, f64)]) {
        let list: Vec<f64> = pairs.iter().flat_map(|(nm, x)| [*nm, *x]).collect();
        self.push("spectrum", name, format!("[ {} ]", numbers(&list, " ")));
    }

    /// A spectrum by its name.
    pub fn named_spectrum(&mut self, name: &str, spectrum: &str) {
        self.push("spectrum", name, quoted(spectrum));
    }

    pub fn vector(&mut self, name: &str, v: DVec3) {
        self.push("vector3", name, format!("[ {} ]", numbers(&v.to_array(), " ")));
    }

    pub fn points(&mut self, kind: &str, name: &str, list: &[Vec3]) {
        self.push(kind, name, listed(list.iter().map(|p| p.to_array().map(single).join(" "))));
    }

    pub fn points2(&mut self, name: &str, list: &[Vec2]) {
        self.push("point2", name, listed(list.iter().map(|p| p.to_array().map(single).join(" "))));
    }

    /// All lines, behind the words of a directive.
    pub fn behind(self, head: &str) -> Vec<String> {
        match &self.0[..] {
            [only] if head.len() + only.len() < 100 => vec![format!("{head} {only}")],
            _ => std::iter::once(head.to_owned()).chain(self.0.iter().map(|line| format!("    {line}"))).collect(),
        }
    }
}

/// A list in brackets.
fn listed(items: impl Iterator<Item = String>) -> String {
    format!("[ {} ]", items.collect::<Vec<_>>().join("  "))
}

/// A text in quotes.
pub(super) fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            '\t' => out.push_str("\\t"),
            '\r' => out.push_str("\\r"),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// The directives that set a map.
pub(super) fn transform(m: DMat4) -> Vec<String> {
    let (scale, shift) = (DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z), m.w_axis.truncate());
    if m != DMat4::from_translation(shift) * DMat4::from_scale(scale) {
        let columns: Vec<String> = m.to_cols_array_2d().iter().map(|c| numbers(c, " ")).collect();
        return vec![format!("Transform [ {} ]", columns.join("  "))];
    }
    let mut steps = Vec::new();
    if shift != DVec3::ZERO {
        steps.push(format!("Translate {}", numbers(&shift.to_array(), " ")));
    }
    if scale != DVec3::ONE {
        steps.push(format!("Scale {}", numbers(&scale.to_array(), " ")));
    }
    steps
}
