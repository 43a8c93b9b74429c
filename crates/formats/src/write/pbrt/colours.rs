//! Colours, spectra and numbers as parameters.

use super::Writer;
use super::list::List;
use crate::pbrt::spectra::luminance;
use crate::write::constants::folded;
use crate::write::pictures::mean;
use etendue_description::{NodeId, SpectrumValue, Value};

/// The ends of the visible range, for spectra that are the same all over.
const ENDS: [f64; 2] = [360.0, 830.0];

/// The same at every wavelength.
fn flat(x: f64) -> [(f64, f64); 2] {
    ENDS.map(|nm| (nm, x))
}

impl Writer<'_, '_> {
    /// A reflectance, or another spectrum of a surface.
    pub(super) fn colour(&mut self, list: &mut List, name: &str, value: &Value) {
        match folded(self.d, value) {
            Value::Float(x) => list.rgb(name, [x; 3]),
            Value::Integer(i) => list.rgb(name, [i as f64; 3]),
            Value::Rgb(rgb) => list.rgb(name, rgb),
            Value::Spectrum(SpectrumValue::Constant(x)) => list.spectrum(name, &flat(x)),
            Value::Spectrum(SpectrumValue::Samples(pairs)) => list.spectrum(name, &pairs),
            Value::Node(id) => {
                let texture = self.texture(id, false);
                list.texture(name, &texture);
            }
            _ => list.rgb(name, [0.5; 3]),
        }
    }

    /// A number that may be a texture.
    pub(super) fn number(&mut self, list: &mut List, name: &str, value: &Value) {
        match self.as_number(value) {
            Ok(x) => list.float(name, x),
            Err(id) => {
                let texture = self.texture(id, true);
                list.texture(name, &texture);
            }
        }
    }

    /// A number, or the texture that it is.
    pub(super) fn as_number(&self, value: &Value) -> Result<f64, NodeId> {
        match folded(self.d, value) {
            Value::Float(x) | Value::Spectrum(SpectrumValue::Constant(x)) => Ok(x),
            Value::Integer(i) => Ok(i as f64),
            Value::Node(id) => Err(id),
            other => Ok(f64::from(mean(self.d, &other).element_sum() / 3.0)),
        }
    }

    /// Emitted light that does not vary, times `factor`; what is no `rgb` gets its brightness by `scale`.
    pub(super) fn emission(&mut self, list: &mut List, name: &str, value: &Value, factor: f64) {
        let spectrum = match folded(self.d, value) {
            Value::Float(x) => return list.rgb(name, [x * factor; 3]),
            Value::Integer(i) => return list.rgb(name, [i as f64 * factor; 3]),
            Value::Rgb(rgb) => return list.rgb(name, rgb.map(|x| x * factor)),
            Value::Spectrum(SpectrumValue::Constant(x)) => SpectrumValue::Samples(flat(x).to_vec()),
            Value::Spectrum(s) => s,
            // What a light of one colour cannot be.
            other => return list.rgb(name, (mean(self.d, &other).as_dvec3() * factor).to_array()),
        };
        let y = luminance(&spectrum);
        match spectrum {
            _ if y <= 0.0 => return list.rgb(name, [0.0; 3]),
            SpectrumValue::Blackbody { kelvin, .. } => list.blackbody(name, kelvin),
            SpectrumValue::Samples(pairs) => list.spectrum(name, &pairs),
            SpectrumValue::Constant(x) => list.spectrum(name, &flat(x)),
        }
        list.float("scale", y * factor);
    }
}
