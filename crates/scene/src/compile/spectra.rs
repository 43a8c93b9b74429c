//! Spectrum-valued and number-valued parameters → slots.
//!
//! Files write a colour as `rgb`, a spectrum, a number, or a texture node. What it becomes in linear Rec.709 depends on its [`Role`]:
//!
//! | written | reflectance | emission | unbounded (η, k) |
//! | --- | --- | --- | --- |
//! | number x, `uniform` | (x, x, x) | (x, x, x) | (x, x, x) |
//! | `rgb`, `srgb`, `d65` with a colour | as it is, within [0, 1] | as it is | as it is |
//! | spectrum, one value x | (x, x, x) | x times equal energy | (x, x, x) |
//! | spectrum, samples | under D65, clamped to [0, 1] | as it is | under D65 |
//! | `blackbody` | refused: it is a light | Planck's law | refused |
//!
//! The integrals behind the last three rows are those of [`etendue_numerics::spectrum::cie`].

use super::Compiler;
use crate::texture::{Color, ColorSlot, ScalarSlot, Texture};
use etendue_description::{Kind, NodeId, Param, Params, Span, SpectrumValue, Value};
use etendue_numerics::spectrum::{SampledSpectrum, cie};
use std::ops::RangeInclusive;

/// What a spectrum stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// A fraction of light, in [0, 1].
    Reflectance,
    /// A light's radiance, intensity, irradiance.
    Emission,
    /// A number without bounds.
    Unbounded,
}

/// Texture models that do not vary.
pub(super) const CONSTANT_MODELS: &[&str] = &["uniform", "srgb", "d65", "regular", "irregular", "blackbody", "rawconstant"];

/// A spectrum that does not vary, before its role is known.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ConstantSpectrum {
    /// The same number for every role.
    Grey(f64),
    /// Linear Rec.709; where bounded, a reflectance must lie in [0, 1].
    Rgb { rgb: [f64; 3], bounded: bool },
    /// A spectrum as files write it.
    Spectrum(SpectrumValue),
    /// A node that stands for this texture.
    Texture(NodeId),
}

impl<'a> Compiler<'a> {
    /// A parameter that is a fraction of light, in [0, 1].
    pub(crate) fn reflectance(&mut self, params: &mut Params<'a>, name: &'static str, default: f32) -> ColorSlot {
        self.colour_slot(params, name, default, Role::Reflectance)
    }

    /// A parameter that is emitted light.
    pub(crate) fn emission(&mut self, params: &mut Params<'a>, name: &'static str, default: f32) -> ColorSlot {
        self.colour_slot(params, name, default, Role::Emission)
    }

    /// A parameter without bounds: η or k of a metal.
    pub(crate) fn unbounded(&mut self, params: &mut Params<'a>, name: &'static str, default: f32) -> ColorSlot {
        self.colour_slot(params, name, default, Role::Unbounded)
    }

    fn colour_slot(&mut self, params: &mut Params<'a>, name: &'static str, default: f32, role: Role) -> ColorSlot {
        let param = params.spectrum_opt(self.diagnostics, name);
        let slot = param.and_then(|param| self.slot(param, role));
        slot.unwrap_or(ColorSlot::Constant(Color::grey(default)))
    }

    /// A number that may be textured. Outside `range` it is told and answered by the nearest end, as far as it is constant.
    pub(crate) fn scalar(
        &mut self,
        params: &mut Params<'a>,
        name: &'static str,
        default: f32,
        range: RangeInclusive<f32>,
    ) -> ScalarSlot {
        let Some(param) = params.spectrum_opt(self.diagnostics, name) else { return ScalarSlot::Constant(default) };
        match self.slot(param, Role::Unbounded) {
            None => ScalarSlot::Constant(default),
            Some(ColorSlot::Texture(id)) => ScalarSlot::Texture(id),
            Some(ColorSlot::Constant(color)) => {
                let value = color.average();
                if !range.contains(&value) {
                    let (low, high) = (*range.start(), *range.end());
                    let text = format!("`{name}` of `{}` is {value}, expected {low} to {high}", params.node.model.value);
                    let nearest = value.max(low).min(high);
                    self.diagnostics.warning(param.value.span, text).help(format!("it is taken as {nearest}"));
                    return ScalarSlot::Constant(nearest);
                }
                ScalarSlot::Constant(value)
            }
        }
    }

    fn slot(&mut self, param: &'a Param, role: Role) -> Option<ColorSlot> {
        let span = param.value.span;
        let constant = match &param.value.value {
            Value::Float(x) => ConstantSpectrum::Grey(*x),
            Value::Integer(i) => ConstantSpectrum::Grey(*i as f64),
            Value::Rgb(rgb) => ConstantSpectrum::Rgb { rgb: *rgb, bounded: true },
            Value::Spectrum(s) => ConstantSpectrum::Spectrum(s.clone()),
            Value::Node(id) => return self.node_slot(*id, role, span),
            _ => return None,
        };
        self.color(&constant, role, span).map(ColorSlot::Constant)
    }

    fn node_slot(&mut self, id: NodeId, role: Role, span: Span) -> Option<ColorSlot> {
        if CONSTANT_MODELS.contains(&self.description.node(id).model.value.as_str()) {
            return match self.constant(id)? {
                ConstantSpectrum::Texture(nested) => self.node_slot(nested, role, span),
                constant => self.color(&constant, role, span).map(ColorSlot::Constant),
            };
        }
        let texture = self.texture(id)?;
        if role == Role::Reflectance
            && let Texture::Bitmap(bitmap) = &self.textures[texture.index()]
            && let Some(most) = bitmap.texels.exceeds_one()
        {
            let text = format!("this picture holds values up to {most}: as a reflectance above 1 it would create light");
            self.diagnostics.warning(span, text);
        }
        Some(ColorSlot::Texture(texture))
    }

    /// Linear Rec.709 of a constant spectrum in its role; `None` where it cannot have that role, which has been told.
    pub(super) fn color(&mut self, constant: &ConstantSpectrum, role: Role, span: Span) -> Option<Color> {
        let rgb = match constant {
            ConstantSpectrum::Grey(x) => {
                if role == Role::Reflectance && !(0.0..=1.0).contains(x) {
                    self.diagnostics.warning(span, format!("a reflectance of {x} is outside 0 to 1: energy is not conserved"));
                }
                [*x; 3]
            }
            ConstantSpectrum::Rgb { rgb, bounded } => {
                if role == Role::Reflectance && *bounded && !rgb.iter().all(|x| (0.0..=1.0).contains(x)) {
                    let [r, g, b] = rgb;
                    let text = format!("the reflectance ({r}, {g}, {b}) is outside 0 to 1");
                    self.diagnostics.error(span, text);
                    return None;
                }
                *rgb
            }
            ConstantSpectrum::Spectrum(SpectrumValue::Blackbody { .. }) if role != Role::Emission => {
                self.diagnostics.error(span, "a `blackbody` is a light: it cannot be a surface's parameter");
                return None;
            }
            ConstantSpectrum::Spectrum(s) => match rgb_of(s, role) {
                Some(rgb) => {
                    self.check_spectrum(s, role, span);
                    rgb
                }
                None => {
                    self.diagnostics.error(span, "a spectrum needs two or more finite values at rising wavelengths");
                    return None;
                }
            },
            ConstantSpectrum::Texture(_) => return None,
        };
        let [r, g, b] = rgb.map(|x| x as f32);
        if [r, g, b].iter().all(|x| x.is_finite()) {
            return Some(Color::rgb(r, g, b));
        }
        self.diagnostics.error(span, format!("the colour ({r}, {g}, {b}) is not finite"));
        None
    }

    fn check_spectrum(&mut self, spectrum: &SpectrumValue, role: Role, span: Span) {
        let values: Vec<f64> = match spectrum {
            SpectrumValue::Constant(x) => vec![*x],
            SpectrumValue::Samples(pairs) => pairs.iter().map(|p| p.1).collect(),
            SpectrumValue::Blackbody { .. } => return,
        };
        if role == Role::Reflectance && !values.iter().all(|x| (0.0..=1.0).contains(x)) {
            self.diagnostics.warning(span, "a reflectance outside 0 to 1: energy is not conserved");
        }
    }

    /// What a node of a constant model says, read once.
    pub(super) fn constant(&mut self, id: NodeId) -> Option<ConstantSpectrum> {
        if let Some(known) = self.images.constants.get(&id) {
            return known.clone();
        }
        self.images.constants.insert(id, None);
        let mut params = Params::new(self.description, id);
        let constant = match params.node.model.value.as_str() {
            "uniform" => {
                params.ignore(&["wavelength_min", "wavelength_max"]);
                Some(ConstantSpectrum::Grey(params.float_opt(self.diagnostics, "value").unwrap_or(1.0)))
            }
            "srgb" => {
                let bounded = !params.bool(self.diagnostics, "unbounded", false);
                self.rgb(&mut params, &["color", "value"], bounded)
            }
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

/// Linear Rec.709 of a spectrum in its role; `None` where its wavelengths do not rise or its values are not finite.
fn rgb_of(spectrum: &SpectrumValue, role: Role) -> Option<[f64; 3]> {
    let rgb = match (spectrum, role) {
        (SpectrumValue::Constant(x), Role::Emission) => cie::constant_emission_to_rgb(*x),
        (SpectrumValue::Constant(x), _) => return Some([*x; 3]),
        (SpectrumValue::Blackbody { kelvin, scale }, _) => {
            return Some(cie::blackbody_to_rgb(*kelvin).map(|x| f64::from(x) * scale));
        }
        (SpectrumValue::Samples(pairs), role) => {
            let samples = SampledSpectrum::new(pairs)?;
            match role {
                Role::Reflectance => cie::reflectance_to_rgb(&samples),
                Role::Unbounded => cie::unbounded_to_rgb(&samples),
                Role::Emission => cie::emission_to_rgb(&samples),
            }
        }
    };
    Some(rgb.map(f64::from))
}
