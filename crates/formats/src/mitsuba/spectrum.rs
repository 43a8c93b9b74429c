//! Spectra: a constant, wavelengths with values, a `.spd` file, a blackbody.

use super::attributes::Attributes;
use super::text::{Text, shortened};
use super::{File, Reader};
use etendue_description::{Diagnostics, Kind, NodeId, Params, Spanned, SpectrumValue, Value};

impl Reader<'_> {
    /// `<spectrum name value>` or `<spectrum name filename>`.
    pub(super) fn spectrum(&mut self, file: &File, attributes: &mut Attributes) -> Option<Spanned<Value>> {
        let (has_value, has_filename) = (attributes.has("value"), attributes.has("filename"));
        let (value, filename) = (attributes.optional("value"), attributes.optional("filename"));
        if has_value == has_filename {
            let text = "a `<spectrum>` has either a `value` or a `filename`";
            self.diagnostics
                .error(attributes.span, text)
                .help("such as value=\"0.5\", value=\"400:0.1, 700:0.2\" or filename=\"gold.spd\"");
            return None;
        }
        if let Some(text) = value {
            let spectrum = inline(&text, &mut self.diagnostics)?;
            return Some(Spanned::new(Value::Spectrum(spectrum), text.span));
        }
        let filename = filename?;
        let path = self.find_file(&filename.value, filename.span, &file.folders)?;
        match self.files.read_text(&path) {
            Ok(text) => {
                let samples = crate::spd::read(&path, &text, filename.span, &mut self.description.sources, &mut self.diagnostics)?;
                Some(Spanned::new(Value::Spectrum(SpectrumValue::Samples(samples)), filename.span))
            }
            Err(why) => {
                self.diagnostics.error(filename.span, format!("`{}` cannot be read: {why}", path.display()));
                None
            }
        }
    }

    /// `<blackbody name temperature scale?>`
    pub(super) fn blackbody(&mut self, attributes: &mut Attributes) -> Option<Spanned<Value>> {
        let temperature = attributes.required("temperature");
        let scale = match attributes.optional("scale") {
            Some(text) => text.float(&mut self.diagnostics, true),
            None => Some(1.0),
        };
        let temperature = temperature?;
        let (word, range) = temperature.trimmed();
        let number = word.strip_suffix(['K', 'k']).unwrap_or(word).trim_end();
        let kelvin = temperature.number(&mut self.diagnostics, number, range.start..range.start + number.len(), true)?;
        if kelvin <= 0.0 {
            temperature.error(&mut self.diagnostics, range, format!("a temperature of {kelvin} K, expected more than 0"));
            return None;
        }
        Some(Spanned::new(Value::Spectrum(SpectrumValue::Blackbody { kelvin, scale: scale? }), temperature.span))
    }

    /// Replaces `<spectrum type="blackbody">` objects by the value that they mean.
    pub(super) fn fold_blackbodies(&mut self) {
        let is_one = |id: NodeId| {
            let node = self.description.node(id);
            node.kind == Kind::Texture && node.model.value == "blackbody"
        };
        let count = self.description.nodes.len() as u32;
        let spectra: Vec<Option<SpectrumValue>> = (0..count)
            .map(|i| {
                let mut params = is_one(NodeId(i)).then(|| Params::new(&self.description, NodeId(i)))?;
                let diagnostics = &mut self.diagnostics;
                if !params.has("temperature") {
                    diagnostics.error(params.span(), "a `blackbody` lacks its `temperature`");
                }
                let kelvin = params.float(diagnostics, "temperature", 5000.0, f64::MIN_POSITIVE..=f64::MAX);
                let scale = params.float(diagnostics, "scale", 1.0, f64::MIN..=f64::MAX);
                params.ignore(&["wavelength_min", "wavelength_max"]);
                params.finish(diagnostics);
                Some(SpectrumValue::Blackbody { kelvin, scale })
            })
            .collect();
        for param in self.description.nodes.iter_mut().flat_map(|node| &mut node.params) {
            if let Value::Node(id) = param.value.value
                && let Some(spectrum) = &spectra[id.0 as usize]
            {
                param.value.value = Value::Spectrum(spectrum.clone());
            }
        }
    }
}

/// A number, or `wavelength:value` pairs in nm.
fn inline(text: &Text, diagnostics: &mut Diagnostics) -> Option<SpectrumValue> {
    if !text.value.contains(':') {
        let count = text.words().count();
        if count > 1 {
            text.mistake(diagnostics, format!("{count} numbers are no spectrum"))
                .help("expected one number, or wavelength:value pairs such as 400:0.1, 700:0.2");
            return None;
        }
        return text.float(diagnostics, true).map(SpectrumValue::Constant);
    }
    let mut samples: Vec<(f64, f64)> = Vec::new();
    let mut sound = true;
    for (word, range) in text.words() {
        let Some((nm, value)) = word.split_once(':') else {
            text.error(diagnostics, range, format!("`{}` is no wavelength:value pair", shortened(word)));
            sound = false;
            continue;
        };
        let colon = range.start + nm.len();
        let wavelength = text.number(diagnostics, nm, range.start..colon, true);
        let value = text.number(diagnostics, value, colon + 1..range.end, true);
        let (Some(nm), Some(value)) = (wavelength, value) else {
            sound = false;
            continue;
        };
        if let Some(&(before, _)) = samples.last()
            && nm <= before
        {
            text.error(diagnostics, range, format!("wavelengths must rise: {nm} nm follows {before} nm"));
            sound = false;
        }
        samples.push((nm, value));
    }
    if sound && samples.len() < 2 {
        text.mistake(diagnostics, "a spectrum of pairs has at least two".to_owned());
        return None;
    }
    sound.then_some(SpectrumValue::Samples(samples))
}
