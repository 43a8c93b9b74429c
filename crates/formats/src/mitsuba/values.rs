//! The elements that hold a single value: numbers, texts, points, colours, spectra.

use super::attributes::Attributes;
use super::text::Text;
use super::{File, Parent, Reader};
use etendue_description::{Param, Spanned, Value};
use glam::DVec3;

impl Reader<'_> {
    /// An element whose name is that of a type.
    pub(super) fn value(&mut self, file: &File, mut attributes: Attributes, parent: Parent) {
        let name = attributes.required("name");
        let element = attributes.element.clone();
        let value = match element.as_str() {
            "point" | "vector" => self.point(&mut attributes),
            "spectrum" => self.spectrum(file, &mut attributes),
            "blackbody" => self.blackbody(&mut attributes),
            _ => attributes.required("value").and_then(|text| {
                let value = self.simple(&element, &text)?;
                Some(Spanned::new(value, text.span))
            }),
        };
        attributes.finish(self);
        if let (Some(name), Some(value)) = (name, value) {
            if name.value.is_empty() {
                name.mistake(&mut self.diagnostics, format!("a `<{element}>` needs a name"));
                return;
            }
            self.give(parent, Param { name: Spanned::new(name.value, name.span), value });
        }
    }

    fn simple(&mut self, element: &str, text: &Text) -> Option<Value> {
        let diagnostics = &mut self.diagnostics;
        Some(match element {
            "boolean" => Value::Bool(text.boolean(diagnostics)?),
            "integer" => Value::Integer(text.integer(diagnostics)?),
            // Whether an infinite one makes sense is for its owner to say.
            "float" => Value::Float(text.float(diagnostics, false)?),
            "rgb" => Value::Rgb(rgb(text, diagnostics)?),
            _ => Value::String(text.value.clone()),
        })
    }

    /// `x`, `y` and `z`, or `value` with one or three numbers.
    fn point(&mut self, attributes: &mut Attributes) -> Option<Spanned<Value>> {
        if let Some(text) = attributes.optional("value") {
            let [x, y, z] = text.one_or_three(&mut self.diagnostics)?;
            return Some(Spanned::new(Value::Vector(DVec3::new(x, y, z)), text.span));
        }
        if attributes.has("value") {
            return None;
        }
        let [x, y, z] = ["x", "y", "z"].map(|axis| attributes.required(axis));
        let mut number = |text: &Option<Text>| text.as_ref().and_then(|text| text.float(&mut self.diagnostics, true));
        let (nx, ny, nz) = (number(&x), number(&y), number(&z));
        // The place is that of all three, in whatever order they stand.
        let spans = [&x, &y, &z].into_iter().flatten().map(|text| text.span);
        let start = spans.clone().map(|s| s.start).min()?;
        let span = etendue_description::Span { start, end: spans.map(|s| s.end).max()?, ..attributes.span };
        Some(Spanned::new(Value::Vector(DVec3::new(nx?, ny?, nz?)), span))
    }
}

/// One or three numbers, linear Rec.709; or `#rrggbb`, sRGB.
fn rgb(text: &Text, diagnostics: &mut etendue_description::Diagnostics) -> Option<[f64; 3]> {
    let (word, range) = text.trimmed();
    let Some(hex) = word.strip_prefix('#') else { return text.one_or_three(diagnostics) };
    let digits = u32::from_str_radix(hex, 16).ok().filter(|_| hex.len() == 6 && hex.bytes().all(|b| b.is_ascii_hexdigit()));
    match digits {
        Some(code) => Some([code >> 16, code >> 8 & 0xFF, code & 0xFF].map(|byte| linear(f64::from(byte) / 255.0))),
        None => {
            text.error(diagnostics, range, format!("`{word}` is no colour, expected #rrggbb"));
            None
        }
    }
}

/// The linear value of an sRGB-encoded one [IEC 61966-2-1].
fn linear(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { libm::pow((x + 0.055) / 1.055, 2.4) }
}
