//! Colours and spectra: `rgb` in the current colour space, `spectrum` by pairs, by name or by file, `blackbody`, textures.
//!
//! ```text
//! Rec.709 = M(XYZ → Rec.709) M(space → XYZ) rgb        without adaptation: white stays the space's own
//! ```
//!
//! | colour space | red, green, blue (x, y) | white |
//! | --- | --- | --- |
//! | `srgb`, the default | (0.64, 0.33) (0.30, 0.60) (0.15, 0.06) | D65 |
//! | `dci-p3` | (0.68, 0.32) (0.265, 0.690) (0.15, 0.06) | D65 |
//! | `rec2020` | (0.708, 0.292) (0.170, 0.797) (0.131, 0.046) | D65 |
//! | `aces2065-1` | (0.7347, 0.2653) (0, 1) (0.0001, -0.077) | (0.32168, 0.33767) |

use super::values::{Entry, List, Type, Values};
use super::{Named, Reader};
use etendue_description::{Span, Spanned, SpectrumValue, Value};
use etendue_numerics::spectrum::illuminants::{ILLUMINANTS, illuminant};
use etendue_numerics::spectrum::{SampledSpectrum, cie, ior};
use glam::{DMat3, DVec3};

/// What `rgb` means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum ColourSpace {
    #[default]
    Srgb,
    DciP3,
    Rec2020,
    Aces,
}

const SPACES: [(&str, ColourSpace); 4] = [
    ("srgb", ColourSpace::Srgb),
    ("dci-p3", ColourSpace::DciP3),
    ("rec2020", ColourSpace::Rec2020),
    ("aces2065-1", ColourSpace::Aces),
];

impl ColourSpace {
    /// Linear Rec.709 of a colour.
    pub fn to_rec709(self, rgb: [f64; 3]) -> [f64; 3] {
        let d65 = [0.3127, 0.3290];
        let (r, g, b, white) = match self {
            Self::Srgb => return rgb,
            Self::DciP3 => ([0.68, 0.32], [0.265, 0.690], [0.15, 0.06], d65),
            Self::Rec2020 => ([0.708, 0.292], [0.170, 0.797], [0.131, 0.046], d65),
            Self::Aces => ([0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], [0.32168, 0.33767]),
        };
        let to_xyz = matrix(r, g, b, white);
        let rec709 = matrix([0.64, 0.33], [0.30, 0.60], [0.15, 0.06], d65);
        (rec709.inverse() * (to_xyz * DVec3::from_array(rgb))).to_array()
    }
}

/// (X, Y, Z) of the three primaries, each so bright that together they are the white.
fn matrix(r: [f64; 2], g: [f64; 2], b: [f64; 2], white: [f64; 2]) -> DMat3 {
    let xyz = |[x, y]: [f64; 2]| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    // Of a primary with y = 0 only the direction matters.
    let primaries = DMat3::from_cols(
        DVec3::new(r[0], r[1], 1.0 - r[0] - r[1]),
        DVec3::new(g[0], g[1], 1.0 - g[0] - g[1]),
        DVec3::new(b[0], b[1], 1.0 - b[0] - b[1]),
    );
    primaries * DMat3::from_diagonal(primaries.inverse() * xyz(white))
}

/// What a colour stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Reflectance,
    Unbounded,
    Light,
}

/// The metals whose spectra pbrt names.
pub(crate) const METALS: [&str; 7] = ["Ag", "Al", "Au", "Cu", "CuZn", "MgO", "TiO2"];

/// The glasses whose indices pbrt names. `F5`, `F10` and `F11` are its names for the dense flints SF5, SF10 and SF11.
pub(crate) const GLASSES: [&str; 7] =
    ["glass-BK7", "glass-BAF10", "glass-FK51A", "glass-LASF9", "glass-F5", "glass-F10", "glass-F11"];

/// What names of the responses of cameras begin with.
const CAMERAS: [&str; 4] = ["canon_", "hasselblad_", "nikon_", "sony_"];

/// The metal of `metal-X-eta` or `metal-X-k`, and which of both.
pub(super) fn metal(name: &str) -> Option<(&'static str, &str)> {
    let (metal, part) = name.strip_prefix("metal-")?.rsplit_once('-')?;
    let known = METALS.iter().find(|m| **m == metal)?;
    (part == "eta" || part == "k").then_some((*known, part))
}

fn names() -> impl Iterator<Item = String> {
    let metals = METALS.iter().flat_map(|m| [format!("metal-{m}-eta"), format!("metal-{m}-k")]);
    let lamps = ILLUMINANTS.iter().filter(|name| **name != "D60").map(|name| format!("stdillum-{name}"));
    metals.chain(GLASSES.map(str::to_owned)).chain(lamps).chain(["illum-acesD60".to_owned()])
}

/// The spectrum of a name.
fn named(name: &str) -> Option<SpectrumValue> {
    if let Some((metal, part)) = metal(name) {
        let metal = ior::Conductor::named(metal)?;
        let spectrum = if part == "eta" { metal.eta } else { metal.k };
        return Some(SpectrumValue::Samples(spectrum.pairs().collect()));
    }
    if let Some(glass) = ior::glass(name) {
        let nm = (0..=50).map(|i| 350.0 + 10.0 * f64::from(i));
        return Some(SpectrumValue::Samples(nm.map(|nm| (nm, glass.index(nm))).collect()));
    }
    let lamp = name.strip_prefix("stdillum-").or_else(|| name.strip_prefix("illum-aces"))?;
    Some(SpectrumValue::Samples(illuminant(lamp)?.pairs().collect()))
}

/// Y of a spectrum, equal energy having 1.
pub(crate) fn luminance(spectrum: &SpectrumValue) -> f64 {
    match spectrum {
        SpectrumValue::Constant(x) => *x,
        SpectrumValue::Samples(pairs) => SampledSpectrum::new(pairs).map_or(0.0, |s| cie::spectrum_to_xyz(|nm| s.eval(nm))[1]),
        SpectrumValue::Blackbody { kelvin, scale } => scale * cie::spectrum_to_xyz(|nm| cie::blackbody(nm, *kelvin))[1],
    }
}

impl Reader<'_> {
    pub(super) fn colour_space(&mut self, name: &str, span: Span) {
        match SPACES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)) {
            Some((_, space)) => self.state.space = *space,
            None => {
                let known = SPACES.iter().map(|(name, _)| *name);
                self.diagnostics
                    .error(span, format!("unknown colour space `{name}`"))
                    .suggest(name, known.clone())
                    .help(format!("known: {}", known.collect::<Vec<_>>().join(", ")));
            }
        }
    }

    /// A colour, a spectrum or a texture, if given.
    pub(super) fn colour(&mut self, list: &mut List, name: &'static str, role: Role) -> Option<Spanned<Value>> {
        let owner = list.owner.clone();
        let entry = list.raw(name)?;
        let value = self.colour_of(entry, &owner, role)?;
        Some(Spanned::new(value, entry.span))
    }

    fn colour_of(&mut self, entry: &Entry, owner: &str, role: Role) -> Option<Value> {
        let (name, span, found) = (&entry.name, entry.span, entry.values.len());
        match (&entry.kind, &entry.values) {
            (Type::Rgb, Values::Doubles(v)) => {
                let Ok(rgb) = <[f64; 3]>::try_from(v.as_slice()) else {
                    self.diagnostics.error(span, format!("`{name}` of {owner} has {found} values, a colour has three"));
                    return None;
                };
                Some(Value::Rgb(self.rec709(rgb, role)))
            }
            (Type::Float, Values::Doubles(v)) if v.len() == 1 => Some(Value::Float(v[0])),
            (Type::Blackbody, Values::Doubles(v)) => match v[..] {
                [kelvin] if kelvin > 0.0 => Some(Value::Spectrum(SpectrumValue::Blackbody { kelvin, scale: 1.0 })),
                [kelvin] => {
                    self.diagnostics.error(span, format!("a temperature of {kelvin} K is not above 0"));
                    None
                }
                _ => {
                    self.diagnostics.error(span, format!("a `blackbody` has one value, its temperature in kelvin, not {found}"));
                    None
                }
            },
            (Type::Spectrum, Values::Doubles(v)) => self.pairs(v, span).map(Value::Spectrum),
            (Type::Spectrum, Values::Texts(v)) if v.len() == 1 => self.spectrum_named(&v[0].0, span).map(Value::Spectrum),
            (Type::Texture, Values::Texts(v)) if v.len() == 1 => {
                if role == Role::Light {
                    self.diagnostics.error(span, format!("`{name}` of {owner} cannot be a texture"));
                    return None;
                }
                Some(Value::Node(self.named(Named::SpectrumTexture, &v[0].0, span)))
            }
            _ => {
                let text = format!("`{name}` of {owner} is a {}, expected rgb, spectrum or texture", entry.kind.name());
                self.diagnostics.error(entry.declared, text);
                None
            }
        }
    }

    /// A colour of the current space; a reflectance that was within [0, 1] stays there.
    pub(super) fn rec709(&self, rgb: [f64; 3], role: Role) -> [f64; 3] {
        let out = self.state.space.to_rec709(rgb);
        let bounded = role == Role::Reflectance && rgb.iter().all(|x| (0.0..=1.0).contains(x));
        if bounded { out.map(|x| x.clamp(0.0, 1.0)) } else { out }
    }

    /// Wavelengths and values in turn.
    fn pairs(&mut self, numbers: &[f64], span: Span) -> Option<SpectrumValue> {
        if numbers.len() < 2 || !numbers.len().is_multiple_of(2) {
            let text = format!("{} numbers are no spectrum: wavelengths and values stand in turn", numbers.len());
            self.diagnostics.error(span, text);
            return None;
        }
        let pairs: Vec<(f64, f64)> = numbers.as_chunks::<2>().0.iter().map(|[nm, x]| (*nm, *x)).collect();
        if let [(_, x)] = pairs[..] {
            return Some(SpectrumValue::Constant(x));
        }
        if let Some(i) = (1..pairs.len()).find(|i| pairs[*i].0 <= pairs[i - 1].0) {
            let text = format!("wavelengths must rise: {} nm follows {} nm", pairs[i].0, pairs[i - 1].0);
            self.diagnostics.error(span, text);
            return None;
        }
        Some(SpectrumValue::Samples(pairs))
    }

    /// A spectrum by name, or else by file.
    fn spectrum_named(&mut self, name: &str, span: Span) -> Option<SpectrumValue> {
        if let Some(spectrum) = named(name) {
            return Some(spectrum);
        }
        let begins = |starts: &[&str]| starts.iter().any(|start| name.starts_with(start));
        if begins(&CAMERAS) && ["_r", "_g", "_b"].iter().any(|end| name.ends_with(end)) {
            let text = format!("`{name}` is how a camera's sensor answers: what cameras see is not rendered, light is");
            self.diagnostics.error(span, text).help("give its wavelengths and values instead");
            return None;
        }
        if begins(&["metal-", "glass-", "stdillum-", "illum-"]) {
            let known: Vec<String> = names().collect();
            self.diagnostics
                .error(span, format!("the spectrum `{name}` is not known here"))
                .suggest(name, known.iter().map(String::as_str))
                .help(format!("known: {}; or give wavelengths and values", known.join(", ")));
            return None;
        }
        let path = self.find(name, span)?;
        let content = match self.files.read_text(&path) {
            Ok(content) => content,
            Err(why) => {
                self.diagnostics.error(span, format!("`{}` cannot be read: {why}", path.display()));
                return None;
            }
        };
        let sources = &mut self.description.sources;
        crate::spd::read(&path, &content, span, sources, &mut self.diagnostics).map(SpectrumValue::Samples)
    }

    /// A number or a float texture, if given.
    pub(super) fn number(&mut self, list: &mut List, name: &'static str) -> Option<Spanned<Value>> {
        if let Some(entry) = list.raw(name)
            && entry.kind == Type::Texture
        {
            let span = entry.span;
            let Values::Texts(v) = &entry.values else { return None };
            let [(texture, _)] = &v[..] else { return None };
            let texture = texture.clone();
            return Some(Spanned::new(Value::Node(self.named(Named::FloatTexture, &texture, span)), span));
        }
        let x = list.float_opt(&mut self.diagnostics, name)?;
        Some(Spanned::new(Value::Float(x), list.span_of(name)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_white_and_spaces_hold_each_other() {
        for (name, space) in SPACES {
            let white = space.to_rec709([1.0; 3]);
            let d60 = space == ColourSpace::Aces;
            assert!(white.iter().all(|x| (x - 1.0).abs() < if d60 { 0.12 } else { 1e-3 }), "{name}: {white:?}");
            let y = 0.2126 * white[0] + 0.7152 * white[1] + 0.0722 * white[2];
            assert!((y - 1.0).abs() < 1e-3, "{name}: {y}");
        }
        // The red of Rec.2020 lies beyond Rec.709: less than nothing of green [ITU-R BT.2087].
        let [r, g, b] = ColourSpace::Rec2020.to_rec709([1.0, 0.0, 0.0]);
        assert!((r - 1.6605).abs() < 2e-3 && (g + 0.1246).abs() < 2e-3 && (b + 0.0182).abs() < 2e-3, "{r} {g} {b}");
    }

    #[test]
    fn every_name_has_a_spectrum() {
        for name in names() {
            assert!(luminance(&named(&name).unwrap()) > 0.0, "{name}");
        }
        assert!(named("metal-Ag").is_none() && named("metal-Ag-n").is_none() && named("stdillum-S0").is_none());
    }
}
