//! Parameters of the materials that hold no others.

use super::Compiler;
use crate::material::{
    CoatedDiffuse, Conductor, Dielectric, DiffuseTransmission, Hair, LayerGround, LayerRoughness, Layered, Material, Measured,
    Phong, Pigment, Plastic, Principled, PrincipledCommon, PrincipledThin, RoughDielectric, RoughPlastic, Roughness,
};
use crate::texture::{Color, ColorSlot, ScalarSlot};
use etendue_bsdf::{Ndf, lobes, lobes::MeasuredError};
use etendue_description::{Params, SpectrumValue, Value};
use etendue_numerics::spectrum::{Curve, SampledSpectrum, ior};

/// A number that must not be negative.
const NOT_NEGATIVE: std::ops::RangeInclusive<f32> = 0.0..=f32::MAX;
/// A fraction.
pub(super) const FRACTION: std::ops::RangeInclusive<f32> = 0.0..=1.0;

/// An index of refraction as it is written.
enum Index {
    Number(f32),
    Glass(ior::Glass),
    Measured(SampledSpectrum),
}

impl Index {
    /// n at a wavelength, nm; beyond the ends of a table as at its ends.
    fn at(&self, nm: f64) -> f64 {
        match self {
            Self::Number(n) => f64::from(*n),
            Self::Glass(glass) => glass.index(nm),
            Self::Measured(s) => s.eval_clamped(nm),
        }
    }

    /// n at the yellow line of helium.
    fn number(&self) -> f32 {
        match self {
            Self::Number(n) => *n,
            _ => self.at(587.56) as f32,
        }
    }

    /// All that it may be.
    fn values(&self) -> Vec<f64> {
        match self {
            Self::Number(n) => vec![f64::from(*n)],
            Self::Glass(_) => Vec::new(),
            Self::Measured(s) => s.pairs().map(|(_, n)| n).collect(),
        }
    }
}

impl<'a> Compiler<'a> {
    /// An index of refraction: the name of a material, a number above 0, or a spectrum.
    fn ior(&mut self, p: &mut Params<'a>, name: &'static str, default: f32) -> Index {
        let Some(param) = p.raw(name) else { return Index::Number(default) };
        let index = match &param.value.value {
            Value::Float(x) => Index::Number(*x as f32),
            Value::Integer(i) => Index::Number(*i as f32),
            Value::Spectrum(SpectrumValue::Constant(x)) => Index::Number(*x as f32),
            Value::Spectrum(SpectrumValue::Samples(pairs)) if SampledSpectrum::new(pairs).is_some() => {
                SampledSpectrum::new(pairs).map_or(Index::Number(default), Index::Measured)
            }
            Value::String(word) => match (ior::dielectric(word), ior::glass(word)) {
                (Some(ior), _) => Index::Number(ior),
                (_, Some(glass)) => Index::Glass(glass),
                _ => {
                    let text = format!("unknown index of refraction `{word}`");
                    let known = ior::DIELECTRICS.iter().map(|d| d.0).chain(ior::GLASSES.iter().map(|g| g.0));
                    self.diagnostics.error(param.value.span, text).suggest(word, known);
                    return Index::Number(default);
                }
            },
            other => {
                let (model, found) = (&p.node.model.value, other.type_name());
                let text = format!("`{name}` of `{model}` is a {found}, expected a number, a spectrum or the name of a material");
                self.diagnostics.error(param.value.span, text);
                return Index::Number(default);
            }
        };
        let wrong = index.values().into_iter().find(|x| !(*x > 0.0 && x.is_finite()));
        if let Some(value) = wrong {
            self.diagnostics.error(param.value.span, format!("the index of refraction {value} is not a number above 0"));
            return Index::Number(default);
        }
        index
    }

    /// η = `int_ior` / `ext_ior`, and what it is at each wavelength, where that is not the same.
    fn relative(&mut self, p: &mut Params<'a>, interior: f32) -> (f32, Option<Curve>) {
        let (interior, exterior) = (self.ior(p, "int_ior", interior), self.ior(p, "ext_ior", lobes::AIR));
        let curve = match (&interior, &exterior) {
            (Index::Number(_), Index::Number(_)) => None,
            _ => Some(Curve::measured(|nm| interior.at(nm) / exterior.at(nm))),
        };
        (interior.number() / exterior.number(), curve)
    }

    /// η alone.
    fn eta(&mut self, p: &mut Params<'a>, interior: f32) -> f32 {
        self.relative(p, interior).0
    }

    pub(super) fn interface(&mut self, p: &mut Params<'a>) -> Dielectric {
        let (eta, dispersion) = self.relative(p, lobes::BK7);
        Dielectric {
            eta,
            dispersion,
            specular_reflectance: self.reflectance(p, "specular_reflectance", 1.0),
            specular_transmittance: self.reflectance(p, "specular_transmittance", 1.0),
        }
    }

    pub(super) fn rough_dielectric(&mut self, p: &mut Params<'a>) -> Material {
        let (interface, roughness) = (self.interface(p), self.roughness(p));
        if interface.eta == 1.0 {
            let text = "`int_ior` and `ext_ior` are equal: nothing would bend or reflect light";
            self.diagnostics.error(p.span_of("int_ior"), text).help("use `null`");
        }
        RoughDielectric { interface, roughness }.into()
    }

    fn distribution(&mut self, p: &mut Params<'a>) -> Ndf {
        let Some(word) = p.string_opt(self.diagnostics, "distribution") else { return Ndf::Beckmann };
        match word.to_lowercase().as_str() {
            "beckmann" => Ndf::Beckmann,
            "ggx" => Ndf::Ggx,
            _ => {
                let text = format!("unknown `distribution` `{word}`, expected `beckmann` or `ggx`");
                self.diagnostics.error(p.span_of("distribution"), text).suggest(word, ["beckmann", "ggx"]);
                Ndf::Beckmann
            }
        }
    }

    pub(super) fn roughness(&mut self, p: &mut Params<'a>) -> Roughness {
        let mut ndf = self.distribution(p);
        if p.choice(self.diagnostics, "masking", &["separable", "correlated"]) == 1 {
            match ndf {
                Ndf::Beckmann => {
                    let text = "`masking` is `correlated` for `ggx` only";
                    self.diagnostics.error(p.span_of("masking"), text).help("add `distribution` with the value `ggx`");
                }
                Ndf::Ggx | Ndf::GgxCorrelated => ndf = Ndf::GgxCorrelated,
            }
        }
        let remap = p.bool(self.diagnostics, "remap_roughness", false);
        let sample_visible = p.bool(self.diagnostics, "sample_visible", true);
        let (both, axes) = (p.has("alpha"), ["alpha_u", "alpha_v"].map(|name| p.has(name)));
        let alpha = self.scalar(p, "alpha", 0.1, NOT_NEGATIVE);
        let along = ["alpha_u", "alpha_v"].map(|name| self.scalar(p, name, 0.1, NOT_NEGATIVE));
        let alpha = if axes == [false, false] { [alpha; 2] } else { along };
        if axes[0] != axes[1] || (both && axes[0]) {
            let name = if axes[0] { "alpha_u" } else { "alpha_v" };
            self.diagnostics.error(p.span_of(name), "give either `alpha`, or both `alpha_u` and `alpha_v`");
        }
        Roughness { ndf, alpha, sample_visible, remap }
    }

    pub(super) fn metal(&mut self, p: &mut Params<'a>) -> Conductor {
        let specular_reflectance = self.reflectance(p, "specular_reflectance", 1.0);
        let given = p.has("eta") || p.has("k");
        let reflectance = p.has("reflectance").then(|| self.reflectance(p, "reflectance", 1.0));
        if reflectance.is_some() && (given || p.has("material")) {
            let text = "give either `reflectance`, or `material`, or `eta` and `k`";
            self.diagnostics.error(p.span_of("reflectance"), text);
        }
        let (mut eta, mut k) = (self.unbounded(p, "eta", 0.0), self.unbounded(p, "k", 1.0));
        if let Some(name) = p.string_opt(self.diagnostics, "material") {
            let span = p.span_of("material");
            if given {
                self.diagnostics.error(span, "give either `material`, or `eta` and `k`");
            } else if let Some(metal) = ior::Conductor::named(name) {
                let (n, extinction) = metal.to_rgb();
                let slot = |rgb, s: &SampledSpectrum| ColorSlot::Constant(Color::new(rgb, Curve::measured(|nm| s.eval(nm))));
                (eta, k) = (slot(n, &metal.eta), slot(extinction, &metal.k));
            } else if name != "none" {
                let known = ior::conductor_names().chain(["none"]);
                self.diagnostics.error(span, format!("unknown metal `{name}`")).suggest(name, known);
            }
        }
        Conductor { eta, k, reflectance, specular_reflectance }
    }

    pub(super) fn plastic(&mut self, p: &mut Params<'a>) -> Plastic {
        Plastic {
            diffuse_reflectance: self.reflectance(p, "diffuse_reflectance", 0.5),
            specular_reflectance: self.reflectance(p, "specular_reflectance", 1.0),
            eta: self.eta(p, lobes::POLYPROPYLENE),
            nonlinear: p.bool(self.diagnostics, "nonlinear", false),
        }
    }

    pub(super) fn rough_plastic(&mut self, p: &mut Params<'a>) -> Material {
        let plastic = self.plastic(p);
        let Roughness { ndf, alpha: [u, v], sample_visible, .. } = self.roughness(p);
        let alpha = match (u, v) {
            (ScalarSlot::Constant(u), ScalarSlot::Constant(v)) if u == v => u,
            (ScalarSlot::Constant(_), ScalarSlot::Constant(_)) => {
                self.diagnostics.error(p.span_of("alpha_u"), "`roughplastic` has the same `alpha` in all directions");
                0.1
            }
            _ => {
                let name = ["alpha", "alpha_u"].into_iter().find(|n| p.has(n)).unwrap_or("alpha_v");
                self.diagnostics.error(p.span_of(name), "`alpha` of `roughplastic` is a number, not a texture");
                0.1
            }
        };
        RoughPlastic::new(plastic, ndf, alpha, sample_visible).into()
    }

    fn principled_common(&mut self, p: &mut Params<'a>, eta: f32) -> PrincipledCommon {
        PrincipledCommon {
            base_color: self.reflectance(p, "base_color", 0.5),
            roughness: self.scalar(p, "roughness", 0.5, FRACTION),
            anisotropic: self.scalar(p, "anisotropic", 0.0, FRACTION),
            spec_trans: self.scalar(p, "spec_trans", 0.0, FRACTION),
            spec_tint: self.scalar(p, "spec_tint", 0.0, FRACTION),
            sheen: self.scalar(p, "sheen", 0.0, FRACTION),
            sheen_tint: self.scalar(p, "sheen_tint", 0.0, FRACTION),
            flatness: self.scalar(p, "flatness", 0.0, FRACTION),
            eta,
        }
    }

    fn rate(&mut self, p: &mut Params<'a>, name: &'static str) -> f32 {
        p.float(self.diagnostics, name, 1.0, 0.0..=1e6) as f32
    }

    pub(super) fn principled(&mut self, p: &mut Params<'a>) -> Material {
        if p.has("eta") && p.has("specular") {
            self.diagnostics.error(p.span_of("specular"), "give either `eta` or `specular`, which stands for an index");
        }
        let specular = p.float(self.diagnostics, "specular", 0.5, 0.0..=1.0) as f32;
        let mut common = self.principled_common(p, 1.0);
        let refracts = !matches!(common.spec_trans, ScalarSlot::Constant(s) if s <= 0.0);
        let default = lobes::eta_from_specular(specular, f32::from(u8::from(refracts)));
        common.eta = p.float(self.diagnostics, "eta", f64::from(default), 1e-3..=1e3) as f32;
        Principled {
            common,
            metallic: self.scalar(p, "metallic", 0.0, FRACTION),
            clearcoat: self.scalar(p, "clearcoat", 0.0, FRACTION),
            clearcoat_gloss: self.scalar(p, "clearcoat_gloss", 0.0, FRACTION),
            rates: ["diffuse_reflectance_sampling_rate", "main_specular_sampling_rate", "clearcoat_sampling_rate"]
                .map(|name| self.rate(p, name)),
        }
        .into()
    }

    pub(super) fn principled_thin(&mut self, p: &mut Params<'a>) -> Material {
        let eta = p.float(self.diagnostics, "eta", 1.5, 1e-3..=1e3) as f32;
        PrincipledThin {
            common: self.principled_common(p, eta),
            diff_trans: self.scalar(p, "diff_trans", 0.0, 0.0..=2.0),
            rates: [
                "diffuse_reflectance_sampling_rate",
                "specular_reflectance_sampling_rate",
                "specular_transmittance_sampling_rate",
                "diffuse_transmittance_sampling_rate",
            ]
            .map(|name| self.rate(p, name)),
        }
        .into()
    }

    /// A layer on the ground.
    fn layer(&mut self, p: &mut Params<'a>, ground: LayerGround) -> Layered {
        let params = lobes::LayeredParams {
            eta: self.eta(p, 1.5),
            max_depth: p.integer(self.diagnostics, "max_depth", 10, 1..=1000) as u32,
            samples: p.integer(self.diagnostics, "samples", 1, 1..=1000) as u32,
            ..Default::default()
        };
        Layered {
            ground,
            boundary: self.layer_roughness(p, ["alpha_u", "alpha_v", "remap_roughness"]),
            thickness: self.scalar(p, "thickness", 0.01, 0.0..=1e3),
            albedo: self.reflectance(p, "albedo", 0.0),
            g: self.scalar(p, "g", 0.0, -0.99..=0.99),
            params,
        }
    }

    fn layer_roughness(&mut self, p: &mut Params<'a>, [u, v, remap]: [&'static str; 3]) -> LayerRoughness {
        let remap = p.bool(self.diagnostics, remap, false);
        LayerRoughness { alpha: [u, v].map(|name| self.scalar(p, name, 0.0, NOT_NEGATIVE)), remap }
    }

    pub(super) fn coated_diffuse(&mut self, p: &mut Params<'a>) -> Material {
        let reflectance = self.reflectance(p, "reflectance", 0.5);
        let layered = self.layer(p, LayerGround::Diffuse(reflectance.clone()));
        let clear = matches!(&layered.albedo, ColorSlot::Constant(c) if c.to_rgb() == [0.0; 3]);
        // A clear layer that is even all over has a sum that is known.
        match (&layered.boundary.alpha, &layered.thickness) {
            ([ScalarSlot::Constant(u), ScalarSlot::Constant(v)], ScalarSlot::Constant(thickness))
                if u == v && clear && !layered.boundary.remap =>
            {
                let coated = lobes::CoatedDiffuseParams {
                    eta: layered.params.eta,
                    alpha: (*u >= 1e-3).then_some(*u),
                    thickness: *thickness,
                    bounces: layered.params.max_depth.div_ceil(2),
                    ..Default::default()
                };
                CoatedDiffuse::new(reflectance, coated).into()
            }
            _ => layered.into(),
        }
    }

    pub(super) fn coated_conductor(&mut self, p: &mut Params<'a>) -> Material {
        let metal = self.metal(p);
        let base = self.layer_roughness(p, ["base_alpha_u", "base_alpha_v", "base_remap_roughness"]);
        self.layer(p, LayerGround::Metal(Box::new(metal), base)).into()
    }

    pub(super) fn diffuse_transmission(&mut self, p: &mut Params<'a>) -> Material {
        DiffuseTransmission {
            reflectance: self.reflectance(p, "reflectance", 0.25),
            transmittance: self.reflectance(p, "transmittance", 0.25),
            scale: p.float(self.diagnostics, "scale", 1.0, 0.0..=1e6) as f32,
        }
        .into()
    }

    /// Mitsuba's names are understood beside the others.
    pub(super) fn measured(&mut self, p: &mut Params<'a>) -> Option<Material> {
        let span = p.span_of("filename");
        let Some(Value::Measured(index)) = p.raw("filename").map(|param| &param.value.value) else {
            self.diagnostics.error(span, "`measured` needs the `filename` of a measured material").help("a `.bsdf` file");
            return None;
        };
        let data = &self.description.assets.measured[*index as usize];
        match Measured::new(data, self.options.spectral) {
            Ok(material) => Some(material.into()),
            Err(MeasuredError(what)) => {
                self.diagnostics.error(span, format!("`{}`: what stands there of `{what}` is no table", data.path.display()));
                None
            }
        }
    }

    pub(super) fn hair(&mut self, p: &mut Params<'a>) -> Material {
        let melanin = [("eumelanin", 1.3), ("pheomelanin", 0.0)];
        let given = melanin.map(|(name, _)| p.has(name));
        let default = |i: usize| if given[1 - i] { 0.0 } else { melanin[i].1 };
        let concentrations = [0, 1].map(|i| self.scalar(p, melanin[i].0, default(i), NOT_NEGATIVE));
        let (absorbs, coloured) = (p.has("sigma_a"), p.has("reflectance"));
        if [absorbs, coloured, given != [false; 2]].into_iter().filter(|x| *x).count() > 1 {
            let text = "give one of `sigma_a`, `reflectance`, or `eumelanin` and `pheomelanin`";
            self.diagnostics.error(p.span(), text);
        }
        let (sigma_a, reflectance) = (self.unbounded(p, "sigma_a", 0.0), self.reflectance(p, "reflectance", 0.5));
        let pigment = match (absorbs, coloured) {
            (true, _) => Pigment::Absorption(sigma_a),
            (_, true) => Pigment::Reflectance(reflectance),
            _ => Pigment::Melanin(concentrations),
        };
        let mut either = |ours: &'static str, theirs: &'static str, default, range| {
            let name = if p.has(theirs) { theirs } else { ours };
            self.scalar(p, name, default, range)
        };
        let beta = [("beta_m", "longitudinal_roughness"), ("beta_n", "azimuthal_roughness")]
            .map(|(ours, theirs)| either(ours, theirs, 0.3, FRACTION));
        let alpha = either("alpha", "scale_tilt", 2.0, -45.0..=45.0);
        Hair { pigment, beta, alpha, eta: self.eta(p, 1.55) }.into()
    }

    pub(super) fn phong(&mut self, p: &mut Params<'a>) -> Material {
        let diffuse_reflectance = self.reflectance(p, "diffuse_reflectance", 0.5);
        let specular_reflectance = self.reflectance(p, "specular_reflectance", 0.2);
        if let (ColorSlot::Constant(d), ColorSlot::Constant(s)) = (&diffuse_reflectance, &specular_reflectance) {
            let most = d.to_rgb().iter().zip(s.to_rgb()).map(|(d, s)| d + s).fold(0.0, f32::max);
            if most > 1.0 {
                let text = format!("`diffuse_reflectance` + `specular_reflectance` is {most}: both are scaled down to a sum of 1");
                self.diagnostics.warning(p.span_of("specular_reflectance"), text);
            }
        }
        Phong { diffuse_reflectance, specular_reflectance, exponent: self.scalar(p, "exponent", 30.0, 0.0..=1e6) }.into()
    }
}
