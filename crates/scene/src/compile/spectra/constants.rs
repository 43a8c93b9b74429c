//! Texture nodes that do not vary: `uniform`, `srgb`, `rawconstant`, `d65`, `regular`, `irregular`, `blackbody`.
//!
//! What they say is read once; what it becomes depends on the role of the parameter that they stand for.

use super::Compiler;
use etendue_description::{Kind, NodeId, Params, SpectrumValue, Value};

/// Texture models that do not vary.
pub(in crate::compile) const CONSTANT_MODELS: &[&str] =
    &["uniform", "srgb", "d65", "regular", "irregular", "blackbody", "rawconstant", "constant"];

/// A spectrum that does not vary, before its role is known.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ConstantSpectrum {
    /// The same number for every role; as emission the illuminant D65.
    Grey(f64),
    /// The same at every wavelength.
    Uniform(f64),
    /// Linear Rec.709; where bounded, a reflectance must lie in [0, 1].
    Rgb { rgb: [f64; 3], bounded: bool },
    /// A spectrum as files write it.
    Spectrum(SpectrumValue),
    /// A node that stands for this texture.
    Texture(NodeId),
}

impl<'a> Compiler<'a> {
    /// What a node of a constant model says, read once.
    pub(in crate::compile) fn constant(&mut self, id: NodeId) -> Option<ConstantSpectrum> {
        if let Some(known) = self.images.constants.get(&id) {
            return known.clone();
        }
        self.images.constants.insert(id, None);
        let mut params = Params::new(self.description, id);
        let constant = match params.node.model.value.as_str() {
            "uniform" => {
                params.ignore(&["wavelength_min", "wavelength_max"]);
                Some(ConstantSpectrum::Uniform(params.float_opt(self.diagnostics, "value").unwrap_or(1.0)))
            }
            "srgb" => {
                let bounded = !params.bool(self.diagnostics, "unbounded", false);
                self.rgb(&mut params, &["color", "value"], bounded)
            }
            "constant" => params.spectrum_opt(self.diagnostics, "value").and_then(|param| match &param.value.value {
                Value::Float(x) => Some(ConstantSpectrum::Grey(*x)),
                Value::Integer(i) => Some(ConstantSpectrum::Grey(*i as f64)),
                Value::Rgb(rgb) => Some(ConstantSpectrum::Rgb { rgb: *rgb, bounded: true }),
                Value::Spectrum(s) => Some(ConstantSpectrum::Spectrum(s.clone())),
                Value::Node(id) => Some(ConstantSpectrum::Texture(*id)),
                _ => None,
            }),
            "rawconstant" => self.rgb(&mut params, &["value"], false),
            "d65" => self.d65(&mut params),
            "regular" => self.regular(&mut params),
            "irregular" => self.irregular(&mut params),
            _ => self.blackbody(&mut params),
        };
        params.finish(self.diagnostics);
        self.images.constants.insert(id, constant.clone());
        constant
    }

    fn rgb(&mut self, params: &mut Params<'a>, names: &[&'static str], bounded: bool) -> Option<ConstantSpectrum> {
        for &name in names {
            let Some(param) = params.raw(name) else { continue };
            let rgb = match &param.value.value {
                Value::Rgb(rgb) => *rgb,
                Value::Vector(v) => v.to_array(),
                Value::Float(x) => [*x; 3],
                Value::Integer(i) => [*i as f64; 3],
                other => {
                    let (model, found) = (&params.node.model.value, other.type_name());
                    self.diagnostics.error(param.value.span, format!("`{name}` of `{model}` is a {found}, expected a colour"));
                    return None;
                }
            };
            return Some(ConstantSpectrum::Rgb { rgb, bounded });
        }
        let text = format!("`{}` needs a `{}`", params.node.model.value, names[0]);
        self.diagnostics.error(params.span(), text);
        None
    }

    fn d65(&mut self, params: &mut Params<'a>) -> Option<ConstantSpectrum> {
        let scale = params.float_opt(self.diagnostics, "scale").unwrap_or(1.0);
        if let Some((nested, param)) = params.children(Kind::Texture).into_iter().next() {
            if scale == 1.0 {
                return Some(ConstantSpectrum::Texture(nested));
            }
            self.diagnostics.error(param.value.span, "`d65` cannot scale a texture; scale the light instead");
            return None;
        }
        if !params.has("color") && !params.has("value") {
            return Some(ConstantSpectrum::Grey(scale));
        }
        match self.rgb(params, &["color", "value"], false)? {
            ConstantSpectrum::Rgb { rgb, bounded } => Some(ConstantSpectrum::Rgb { rgb: rgb.map(|x| x * scale), bounded }),
            other => Some(other),
        }
    }

    fn regular(&mut self, params: &mut Params<'a>) -> Option<ConstantSpectrum> {
        let from = params.float_opt(self.diagnostics, "wavelength_min");
        let to = params.float_opt(self.diagnostics, "wavelength_max");
        let values = self.numbers(params, &["values", "value"])?;
        let (Some(from), Some(to)) = (from, to) else {
            self.diagnostics.error(params.span(), "`regular` needs `wavelength_min` and `wavelength_max`");
            return None;
        };
        let step = (to - from) / (values.len().max(2) - 1) as f64;
        self.samples(params, values.iter().enumerate().map(|(i, v)| (from + step * i as f64, *v)).collect())
    }

    fn irregular(&mut self, params: &mut Params<'a>) -> Option<ConstantSpectrum> {
        let wavelengths = self.numbers(params, &["wavelengths"]);
        let values = self.numbers(params, &["values", "value"]);
        let (wavelengths, values) = (wavelengths?, values?);
        if wavelengths.len() != values.len() {
            let text = format!("{} wavelengths, but {} values", wavelengths.len(), values.len());
            self.diagnostics.error(params.span_of("wavelengths"), text);
            return None;
        }
        self.samples(params, wavelengths.into_iter().zip(values).collect())
    }

    fn blackbody(&mut self, params: &mut Params<'a>) -> Option<ConstantSpectrum> {
        params.ignore(&["wavelength_min", "wavelength_max"]);
        let scale = params.float_opt(self.diagnostics, "scale").unwrap_or(1.0);
        if !params.has("temperature") {
            self.diagnostics.error(params.span(), "`blackbody` needs a `temperature` in kelvin");
        }
        let kelvin = params.float_opt(self.diagnostics, "temperature")?;
        if kelvin > 0.0 {
            return Some(ConstantSpectrum::Spectrum(SpectrumValue::Blackbody { kelvin, scale }));
        }
        self.diagnostics.error(params.span_of("temperature"), format!("a temperature of {kelvin} K is not above 0"));
        None
    }

    /// Samples at rising wavelengths, at least two.
    fn samples(&mut self, params: &Params<'a>, samples: Vec<(f64, f64)>) -> Option<ConstantSpectrum> {
        if samples.len() < 2 || !samples.is_sorted_by(|a, b| a.0 < b.0) {
            let text = format!("`{}` needs two values or more, at rising wavelengths", params.node.model.value);
            self.diagnostics.error(params.span(), text);
            return None;
        }
        Some(ConstantSpectrum::Spectrum(SpectrumValue::Samples(samples)))
    }

    /// A text of numbers, separated by commas or blanks.
    fn numbers(&mut self, params: &mut Params<'a>, names: &[&'static str]) -> Option<Vec<f64>> {
        let Some(name) = names.iter().copied().find(|name| params.has(name)) else {
            let text = format!("`{}` needs `{}`", params.node.model.value, names[0]);
            self.diagnostics.error(params.span(), text);
            return None;
        };
        let text = params.string_opt(self.diagnostics, name)?;
        let words = text.split([',', ' ', '\t', '\n', '\r']).filter(|w| !w.is_empty());
        let mut numbers = Vec::new();
        for word in words {
            match word.parse::<f64>() {
                Ok(x) if x.is_finite() => numbers.push(x),
                _ => {
                    self.diagnostics.error(params.span_of(name), format!("`{word}` in `{name}` is not a number"));
                    return None;
                }
            }
        }
        Some(numbers)
    }
}
