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
//!
//! Walks that carry wavelengths take spectra as they are, whatever they stand for; colours become smooth spectra
//! ([`etendue_numerics::spectrum::upsample`]), and numbers the same at each wavelength, times D65 where they are emission. `uniform` is never times D65.

mod constants;

pub(super) use constants::{CONSTANT_MODELS, ConstantSpectrum};

use super::Compiler;
use crate::texture::{Color, ColorSlot, Role, ScalarSlot, Texture};
use etendue_description::{NodeId, Param, Params, Span, SpectrumValue, Value};
use etendue_numerics::spectrum::{Curve, SampledSpectrum, cie};
use std::ops::RangeInclusive;

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

    pub(super) fn colour_slot(&mut self, params: &mut Params<'a>, name: &'static str, default: f32, role: Role) -> ColorSlot {
        let param = params.spectrum_opt(self.diagnostics, name);
        let slot = param.and_then(|param| self.slot(param, role));
        slot.unwrap_or_else(|| ColorSlot::Constant(Color::rgb([default; 3], role)))
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
        let texture = self.texture(id, role)?;
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
        let (rgb, curve) = match constant {
            ConstantSpectrum::Grey(x) | ConstantSpectrum::Uniform(x) => {
                if role == Role::Reflectance && !(0.0..=1.0).contains(x) {
                    self.diagnostics.warning(span, format!("a reflectance of {x} is outside 0 to 1: energy is not conserved"));
                }
                let lit = role == Role::Emission && matches!(constant, ConstantSpectrum::Grey(_));
                let x32 = *x as f32;
                ([*x; 3], Some(if lit { Curve::emission([x32; 3]) } else { Curve::flat(x32) }))
            }
            ConstantSpectrum::Rgb { rgb, bounded } => {
                if role == Role::Reflectance && *bounded && !rgb.iter().all(|x| (0.0..=1.0).contains(x)) {
                    let [r, g, b] = rgb;
                    let text = format!("the reflectance ({r}, {g}, {b}) is outside 0 to 1");
                    self.diagnostics.error(span, text);
                    return None;
                }
                (*rgb, None)
            }
            ConstantSpectrum::Spectrum(SpectrumValue::Blackbody { .. }) if role != Role::Emission => {
                self.diagnostics.error(span, "a `blackbody` is a light: it cannot be a surface's parameter");
                return None;
            }
            ConstantSpectrum::Spectrum(s) => match rgb_of(s, role) {
                Some(rgb) => {
                    self.check_spectrum(s, role, span);
                    (rgb, Some(curve_of(s)))
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
            return Some(Color::new([r, g, b], curve.unwrap_or_else(|| role.curve([r, g, b]))));
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
}

/// A spectrum as walks with wavelengths have it: as it is, whatever its role.
fn curve_of(spectrum: &SpectrumValue) -> Curve {
    match spectrum {
        SpectrumValue::Constant(x) => Curve::flat(*x as f32),
        SpectrumValue::Samples(pairs) => {
            SampledSpectrum::new(pairs).map_or(Curve::flat(0.0), |s| Curve::measured(|nm| s.eval(nm).max(0.0)))
        }
        SpectrumValue::Blackbody { kelvin, scale } => Curve::measured(|nm| cie::blackbody(nm, *kelvin) * scale),
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
