//! Material nodes → [`crate::Material`].

use super::Compiler;
use crate::ids::MaterialId;
use crate::material::{
    Blend, BumpMap, Conductor, Dielectric, Diffuse, Mask, Material, NormalMap, NormalOptions, Null, Phong, Plastic, Principled,
    PrincipledCommon, PrincipledThin, RoughConductor, RoughDielectric, RoughPlastic, Roughness, ThinDielectric, TwoSided,
};
use crate::texture::{Color, ColorSlot, ScalarSlot, Texture};
use etendue_bsdf::{Bsdf, Ndf, lobes};
use etendue_description::{Kind, NodeId, Param, Params, Value};
use etendue_numerics::spectrum::ior;

/// Material models that are rendered.
const MODELS: &[&str] = &[
    "diffuse",
    "dielectric",
    "thindielectric",
    "roughdielectric",
    "conductor",
    "roughconductor",
    "plastic",
    "roughplastic",
    "principled",
    "principledthin",
    "phong",
    "null",
    "mask",
    "blendbsdf",
    "twosided",
    "bumpmap",
    "normalmap",
];

/// Models that Mitsuba knows and that are refused here, with the reason.
const REFUSED: &[(&str, &str)] = &[
    ("hair", "hair fibres cannot be rendered yet"),
    ("measured", "tabulated measurements cannot be rendered yet"),
    ("measured_polarized", "étendue does not track polarisation"),
    ("polarizer", "étendue does not track polarisation"),
    ("circular", "étendue does not track polarisation"),
    ("retarder", "étendue does not track polarisation"),
    ("pplastic", "étendue does not track polarisation; `plastic` and `roughplastic` are its unpolarised kin"),
];

/// A number that must not be negative.
const NOT_NEGATIVE: std::ops::RangeInclusive<f32> = 0.0..=f32::MAX;
/// A fraction.
const FRACTION: std::ops::RangeInclusive<f32> = 0.0..=1.0;

impl<'a> Compiler<'a> {
    /// Compiles a material node; one that cannot be, which has been told, is answered by a diffuse one.
    pub(crate) fn material(&mut self, id: NodeId) -> MaterialId {
        match self.material_of.get(&id) {
            Some(Some(known)) => return *known,
            // It failed before, or it leads back to itself.
            Some(None) => return self.diffuse(0.5),
            None => {}
        }
        self.material_of.insert(id, None);
        let Some(material) = self.new_material(id) else { return self.diffuse(0.5) };
        let compiled = self.push_material(material);
        self.material_of.insert(id, Some(compiled));
        compiled
    }

    /// The material of a shape: its nested one, or diffuse with reflectance 0.5, black where the shape emits.
    pub(crate) fn shape_material(&mut self, params: &mut Params<'a>) -> MaterialId {
        self.check_attributes(params);
        let children = params.children(Kind::Bsdf);
        if let Some((_, second)) = children.get(1) {
            self.diagnostics.error(second.value.span, "a shape has one material; this is a second one");
        }
        if let Some((id, _)) = children.first() {
            return self.material(*id);
        }
        let emits = params.node.params.iter().any(|p| self.kind_of(p) == Some(Kind::Emitter));
        self.diffuse(if emits { 0.0 } else { 0.5 })
    }

    fn kind_of(&self, param: &Param) -> Option<Kind> {
        match param.value.value {
            Value::Node(id) => Some(self.description.node(id).kind),
            _ => None,
        }
    }

    fn push_material(&mut self, material: Material) -> MaterialId {
        self.materials.push(material);
        MaterialId(self.materials.len() as u32 - 1)
    }

    /// A grey diffuse material, the same one for the same reflectance.
    fn diffuse(&mut self, reflectance: f32) -> MaterialId {
        let reflectance = ColorSlot::Constant(Color::grey(reflectance));
        let same = |m: &Material| matches!(m, Material::Diffuse(d) if d.reflectance == reflectance);
        match self.materials.iter().position(same) {
            Some(i) => MaterialId(i as u32),
            None => self.push_material(Diffuse { reflectance }.into()),
        }
    }

    fn new_material(&mut self, id: NodeId) -> Option<Material> {
        let mut params = Params::new(self.description, id);
        let p = &mut params;
        let material = match p.node.model.value.as_str() {
            "diffuse" => Some(Diffuse { reflectance: self.reflectance(p, "reflectance", 0.5) }.into()),
            "dielectric" => Some(self.interface(p).into()),
            "thindielectric" => Some(ThinDielectric(self.interface(p)).into()),
            "roughdielectric" => Some(self.rough_dielectric(p)),
            "conductor" => Some(self.metal(p).into()),
            "roughconductor" => Some(RoughConductor { metal: self.metal(p), roughness: self.roughness(p) }.into()),
            "plastic" => Some(self.plastic(p).into()),
            "roughplastic" => Some(self.rough_plastic(p)),
            "principled" => Some(self.principled(p)),
            "principledthin" => Some(self.principled_thin(p)),
            "phong" => Some(self.phong(p)),
            "null" => Some(Null.into()),
            "mask" => self.mask(p),
            "blendbsdf" => self.blend(p),
            "twosided" => self.two_sided(p),
            "bumpmap" => self.bump_map(p),
            "normalmap" => self.normal_map(p),
            model => {
                self.refuse_material(p, model);
                return None;
            }
        };
        params.finish(self.diagnostics);
        let material = material?;
        if material.lobes() > Bsdf::MAX_LOBES {
            let text = format!("this material is made of up to {} simple ones at once", material.lobes());
            let span = self.description.node(id).model.span;
            self.diagnostics.error(span, text).help(format!("at most {} can be rendered: nest less", Bsdf::MAX_LOBES));
            return None;
        }
        Some(material)
    }

    fn refuse_material(&mut self, params: &Params, model: &str) {
        if let Some((_, why)) = REFUSED.iter().find(|(name, _)| *name == model) {
            self.diagnostics.error(params.span(), format!("the material `{model}` is refused: {why}"));
        } else {
            let text = format!("unknown material `{model}`");
            self.diagnostics.error(params.span(), text).suggest(model, MODELS.iter().copied());
        }
    }

    /// An index of refraction: the name of a material, or a number above 0.
    fn ior(&mut self, p: &mut Params<'a>, name: &'static str, default: f32) -> f32 {
        let Some(param) = p.raw(name) else { return default };
        let value = match &param.value.value {
            Value::Float(x) => *x as f32,
            Value::Integer(i) => *i as f32,
            Value::String(word) => {
                let Some(ior) = ior::dielectric(word) else {
                    let text = format!("unknown index of refraction `{word}`");
                    let known = ior::DIELECTRICS.iter().map(|d| d.0);
                    self.diagnostics.error(param.value.span, text).suggest(word, known);
                    return default;
                };
                ior
            }
            other => {
                let (model, found) = (&p.node.model.value, other.type_name());
                let text = format!("`{name}` of `{model}` is a {found}, expected a number or the name of a material");
                self.diagnostics.error(param.value.span, text);
                return default;
            }
        };
        if value > 0.0 && value.is_finite() {
            return value;
        }
        self.diagnostics.error(param.value.span, format!("the index of refraction {value} is not a number above 0"));
        default
    }

    /// η = `int_ior` / `ext_ior`.
    fn eta(&mut self, p: &mut Params<'a>, interior: f32) -> f32 {
        let interior = self.ior(p, "int_ior", interior);
        interior / self.ior(p, "ext_ior", lobes::AIR)
    }

    fn interface(&mut self, p: &mut Params<'a>) -> Dielectric {
        Dielectric {
            eta: self.eta(p, lobes::BK7),
            specular_reflectance: self.reflectance(p, "specular_reflectance", 1.0),
            specular_transmittance: self.reflectance(p, "specular_transmittance", 1.0),
        }
    }

    fn rough_dielectric(&mut self, p: &mut Params<'a>) -> Material {
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

    fn roughness(&mut self, p: &mut Params<'a>) -> Roughness {
        let ndf = self.distribution(p);
        let sample_visible = p.bool(self.diagnostics, "sample_visible", true);
        let (both, axes) = (p.has("alpha"), ["alpha_u", "alpha_v"].map(|name| p.has(name)));
        let alpha = self.scalar(p, "alpha", 0.1, NOT_NEGATIVE);
        let along = ["alpha_u", "alpha_v"].map(|name| self.scalar(p, name, 0.1, NOT_NEGATIVE));
        let alpha = if axes == [false, false] { [alpha; 2] } else { along };
        if axes[0] != axes[1] || (both && axes[0]) {
            let name = if axes[0] { "alpha_u" } else { "alpha_v" };
            self.diagnostics.error(p.span_of(name), "give either `alpha`, or both `alpha_u` and `alpha_v`");
        }
        Roughness { ndf, alpha, sample_visible }
    }

    fn metal(&mut self, p: &mut Params<'a>) -> Conductor {
        let specular_reflectance = self.reflectance(p, "specular_reflectance", 1.0);
        let given = p.has("eta") || p.has("k");
        let (mut eta, mut k) = (self.unbounded(p, "eta", 0.0), self.unbounded(p, "k", 1.0));
        if let Some(name) = p.string_opt(self.diagnostics, "material") {
            let span = p.span_of("material");
            if given {
                self.diagnostics.error(span, "give either `material`, or `eta` and `k`");
            } else if let Some(metal) = ior::Conductor::named(name) {
                let (n, extinction) = metal.to_rgb();
                (eta, k) = (ColorSlot::from(n), ColorSlot::from(extinction));
            } else if name != "none" {
                let known = ior::conductor_names().chain(["none"]);
                self.diagnostics.error(span, format!("unknown metal `{name}`")).suggest(name, known);
            }
        }
        Conductor { eta, k, specular_reflectance }
    }

    fn plastic(&mut self, p: &mut Params<'a>) -> Plastic {
        Plastic {
            diffuse_reflectance: self.reflectance(p, "diffuse_reflectance", 0.5),
            specular_reflectance: self.reflectance(p, "specular_reflectance", 1.0),
            eta: self.eta(p, lobes::POLYPROPYLENE),
            nonlinear: p.bool(self.diagnostics, "nonlinear", false),
        }
    }

    fn rough_plastic(&mut self, p: &mut Params<'a>) -> Material {
        let plastic = self.plastic(p);
        let Roughness { ndf, alpha: [u, v], sample_visible } = self.roughness(p);
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

    fn principled(&mut self, p: &mut Params<'a>) -> Material {
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

    fn principled_thin(&mut self, p: &mut Params<'a>) -> Material {
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

    fn phong(&mut self, p: &mut Params<'a>) -> Material {
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

    /// The nested materials, at least `least` and at most `most`; `None` where that is not so, which has been told.
    fn nested(&mut self, p: &mut Params<'a>, least: usize, most: usize) -> Option<Vec<MaterialId>> {
        let children = p.children(Kind::Bsdf);
        let wanted = match (least, most) {
            (1, 1) => "one nested material",
            (2, 2) => "two nested materials",
            _ => "one or two nested materials",
        };
        if !(least..=most).contains(&children.len()) {
            let span = children.get(most).map_or(p.span(), |(_, param)| param.value.span);
            let text = format!("`{}` needs {wanted}, not {}", p.node.model.value, children.len());
            self.diagnostics.error(span, text);
            return None;
        }
        children
            .iter()
            .map(|(id, _)| {
                let material = self.material(*id);
                // A nested material that failed has been told.
                self.material_of.get(id).copied().flatten().map(|_| material)
            })
            .collect()
    }

    fn at(&self, id: MaterialId) -> &Material {
        &self.materials[id.index()]
    }

    fn mask(&mut self, p: &mut Params<'a>) -> Option<Material> {
        let opacity = self.scalar(p, "opacity", 0.5, FRACTION);
        let nested = self.nested(p, 1, 1)?[0];
        Some(Mask::new(opacity, nested, self.at(nested)).into())
    }

    fn blend(&mut self, p: &mut Params<'a>) -> Option<Material> {
        if !p.has("weight") {
            self.diagnostics.error(p.span(), "`blendbsdf` needs a `weight`");
        }
        let weight = self.scalar(p, "weight", 0.5, FRACTION);
        let nested = self.nested(p, 2, 2)?;
        let nested = [nested[0], nested[1]];
        Some(Blend::new(weight, nested, nested.map(|id| self.at(id))).into())
    }

    fn two_sided(&mut self, p: &mut Params<'a>) -> Option<Material> {
        let nested = self.nested(p, 1, 2)?;
        let nested = [nested[0], *nested.get(1).unwrap_or(&nested[0])];
        if nested.iter().any(|id| self.at(*id).events().transmits()) {
            self.diagnostics.error(p.span(), "`twosided` cannot hold a material that lets light through");
            return None;
        }
        Some(TwoSided::new(nested, nested.map(|id| self.at(id))).into())
    }

    fn normal_options(&mut self, p: &mut Params<'a>) -> Option<NormalOptions> {
        let flip = p.bool(self.diagnostics, "flip_invalid_normals", true);
        let soften = p.bool(self.diagnostics, "use_shadowing_function", true);
        let nested = self.nested(p, 1, 1)?[0];
        Some(NormalOptions::new(nested, self.at(nested), flip, soften))
    }

    fn bump_map(&mut self, p: &mut Params<'a>) -> Option<Material> {
        let scale = p.float(self.diagnostics, "scale", 1.0, f64::from(f32::MIN)..=f64::from(f32::MAX)) as f32;
        let options = self.normal_options(p);
        let textures = p.children(Kind::Texture);
        let [(height, _)] = textures[..] else {
            let span = textures.get(1).map_or(p.span(), |(_, param)| param.value.span);
            self.diagnostics.error(span, format!("`bumpmap` needs one nested texture, not {}", textures.len()));
            return None;
        };
        Some(BumpMap { height: self.texture(height)?, scale, options: options? }.into())
    }

    fn normal_map(&mut self, p: &mut Params<'a>) -> Option<Material> {
        let options = self.normal_options(p);
        if !p.has("normalmap") {
            self.diagnostics.error(p.span(), "`normalmap` needs a texture named `normalmap`");
            return None;
        }
        let span = p.span_of("normalmap");
        let normals = self.unbounded(p, "normalmap", 1.0);
        if let ColorSlot::Texture(id) = normals
            && let Texture::Bitmap(bitmap) = &self.textures[id.index()]
        {
            if bitmap.texels.is_grey() {
                self.diagnostics.error(span, "a normal map needs three channels; this picture is grey");
            } else if bitmap.texels.is_decoded() {
                let text = "the normals of this picture are decoded from sRGB before use";
                self.diagnostics.note(span, text).help("most normal maps want `raw` to be true");
            }
        }
        Some(NormalMap { normals, options: options? }.into())
    }
}
