//! Material nodes → [`crate::Material`].

mod models;
mod nested;

use super::Compiler;
use crate::ids::MaterialId;
use crate::material::{Diffuse, Material, Null, RoughConductor, ThinDielectric};
use crate::texture::{Color, ColorSlot};
use etendue_bsdf::Bsdf;
use etendue_description::{Kind, NodeId, Param, Params, Value};

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
    "coateddiffuse",
    "coatedconductor",
    "diffusetransmission",
    "hair",
    "measured",
    "null",
    "mask",
    "blendbsdf",
    "twosided",
    "bumpmap",
    "normalmap",
];

/// Models that Mitsuba knows and that are refused here, with the reason.
const REFUSED: &[(&str, &str)] = &[
    ("measured_polarized", "étendue does not track polarisation"),
    ("polarizer", "étendue does not track polarisation"),
    ("circular", "étendue does not track polarisation"),
    ("retarder", "étendue does not track polarisation"),
    ("pplastic", "étendue does not track polarisation; `plastic` and `roughplastic` are its unpolarised kin"),
];

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
            "coateddiffuse" => Some(self.coated_diffuse(p)),
            "coatedconductor" => Some(self.coated_conductor(p)),
            "diffusetransmission" => Some(self.diffuse_transmission(p)),
            "hair" => Some(self.hair(p)),
            "measured" => self.measured(p),
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
}
