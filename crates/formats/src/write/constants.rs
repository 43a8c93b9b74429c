//! Texture nodes that do not vary, as the values that they stand for.

use super::look::{float, get};
use etendue_description::{Description, Node, SpectrumValue, Value};
use etendue_numerics::spectrum::{SampledSpectrum, cie};

const MODELS: [&str; 7] = ["uniform", "srgb", "d65", "regular", "irregular", "rawconstant", "constant"];

/// Whether the model is one of those that do not vary.
pub(super) fn is_constant(model: &str) -> bool {
    MODELS.contains(&model)
}

/// What a value means where it is a node that does not vary; other values as they are.
pub(super) fn folded(d: &Description, value: &Value) -> Value {
    let Value::Node(id) = value else { return value.clone() };
    let node = d.node(*id);
    let folded = match node.model.value.as_str() {
        "constant" => get(node, "value").map(|inner| folded(d, inner)),
        "uniform" => Some(Value::Spectrum(SpectrumValue::Constant(float(node, "value").unwrap_or(1.0)))),
        "srgb" => colour(node, &["color", "value"]).map(Value::Rgb),
        "rawconstant" => colour(node, &["value"]).map(Value::Rgb),
        "d65" => Some(d65(d, node)),
        "regular" => regular(node),
        "irregular" => irregular(node),
        _ => None,
    };
    folded.unwrap_or_else(|| value.clone())
}

/// The linear Rec.709 of a reflectance that does not vary; `None` of a texture, of light and of what is no colour.
pub(super) fn rgb(value: &Value) -> Option<[f64; 3]> {
    match value {
        Value::Float(x) | Value::Spectrum(SpectrumValue::Constant(x)) => Some([*x; 3]),
        Value::Integer(i) => Some([*i as f64; 3]),
        Value::Rgb(rgb) => Some(*rgb),
        Value::Spectrum(SpectrumValue::Samples(pairs)) => {
            Some(cie::reflectance_to_rgb(&SampledSpectrum::new(pairs)?).map(f64::from))
        }
        _ => None,
    }
}

fn colour(node: &Node, names: &[&str]) -> Option<[f64; 3]> {
    names.iter().find_map(|name| match get(node, name)? {
        Value::Rgb(rgb) => Some(*rgb),
        Value::Vector(v) => Some(v.to_array()),
        Value::Float(x) => Some([*x; 3]),
        Value::Integer(i) => Some([*i as f64; 3]),
        _ => None,
    })
}

fn d65(d: &Description, node: &Node) -> Value {
    let scale = float(node, "scale").unwrap_or(1.0);
    if let Some(inner) = super::look::nodes_in(node).next() {
        return folded(d, &Value::Node(inner));
    }
    match colour(node, &["color", "value"]) {
        Some(rgb) => Value::Rgb(rgb.map(|x| x * scale)),
        None => Value::Float(scale),
    }
}

fn list(node: &Node, names: &[&str]) -> Option<Vec<f64>> {
    let text = names.iter().find_map(|name| super::look::text(node, name))?;
    text.split([',', ' ', '\t', '\n', '\r']).filter(|w| !w.is_empty()).map(|w| w.parse().ok()).collect()
}

fn regular(node: &Node) -> Option<Value> {
    let (from, to) = (float(node, "wavelength_min")?, float(node, "wavelength_max")?);
    let values = list(node, &["values", "value"])?;
    let step = (to - from) / (values.len().max(2) - 1) as f64;
    let pairs = values.iter().enumerate().map(|(i, v)| (from + step * i as f64, *v)).collect();
    Some(Value::Spectrum(SpectrumValue::Samples(pairs)))
}

fn irregular(node: &Node) -> Option<Value> {
    let pairs = list(node, &["wavelengths"])?.into_iter().zip(list(node, &["values", "value"])?).collect();
    Some(Value::Spectrum(SpectrumValue::Samples(pairs)))
}
