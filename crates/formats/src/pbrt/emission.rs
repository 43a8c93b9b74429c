//! How much light a light sends out, by pbrt's rules.
//!
//! | L or I is | radiance or intensity |
//! | --- | --- |
//! | not given | the colour space's white, of luminance `scale` |
//! | `rgb` | `scale` times the colour |
//! | a spectrum, a black body | the spectrum's shape, of luminance `scale`, whatever the numbers |
//!
//! `power` and `illuminance` multiply that so that the whole has the given flux or falls with the given illuminance, both with a luminous
//! efficacy of 1. The film's exposure, ISO · shutter time / 100, multiplies all light.

use super::Reader;
use super::spectra::{Role, luminance};
use super::values::List;
use etendue_description::{Param, Span, SpectrumValue, Value};

/// Emitted light: a value whose luminance is known.
#[derive(Clone, Debug)]
pub(super) struct Emission {
    value: Value,
    span: Span,
}

impl Emission {
    /// The same, `factor` times as bright.
    pub fn scaled(self, factor: f64) -> Self {
        let value = match self.value {
            Value::Rgb(rgb) => Value::Rgb(rgb.map(|x| x * factor)),
            Value::Spectrum(SpectrumValue::Constant(x)) => Value::Spectrum(SpectrumValue::Constant(x * factor)),
            Value::Spectrum(SpectrumValue::Samples(pairs)) => {
                Value::Spectrum(SpectrumValue::Samples(pairs.into_iter().map(|(nm, x)| (nm, x * factor)).collect()))
            }
            Value::Spectrum(SpectrumValue::Blackbody { kelvin, scale }) => {
                Value::Spectrum(SpectrumValue::Blackbody { kelvin, scale: scale * factor })
            }
            other => other,
        };
        Self { value, ..self }
    }

    pub fn param(self, name: &str) -> Param {
        super::param(name, self.value, self.span)
    }
}

impl Reader<'_> {
    /// The light's `scale`, with the film's exposure.
    pub(super) fn light_scale(&mut self, list: &mut List) -> f64 {
        list.float(&mut self.diagnostics, "scale", 1.0) * self.imaging
    }

    /// The parameter `name` of a light, of luminance 1 where it is no `rgb`.
    pub(super) fn emission(&mut self, list: &mut List, name: &'static str) -> Emission {
        let white = Value::Rgb(self.rec709([1.0; 3], Role::Light));
        let Some(given) = self.colour(list, name, Role::Light) else { return Emission { value: white, span: list.span } };
        let span = given.span;
        match given.value {
            Value::Float(x) => Emission { value: white, span }.scaled(x),
            Value::Spectrum(spectrum) => {
                let y = luminance(&spectrum);
                if y > 0.0 {
                    return Emission { value: Value::Spectrum(spectrum), span }.scaled(1.0 / y);
                }
                self.diagnostics.warning(span, format!("this light has no luminance: `{name}` is dark in the visible range"));
                Emission { value: Value::Rgb([0.0; 3]), span }
            }
            value => Emission { value, span },
        }
    }

    /// `power` or `illuminance`, where it is given and above zero, with the film's exposure.
    pub(super) fn flux(&mut self, list: &mut List, name: &'static str) -> Option<f64> {
        list.float_opt(&mut self.diagnostics, name).filter(|x| *x > 0.0)
    }
}
