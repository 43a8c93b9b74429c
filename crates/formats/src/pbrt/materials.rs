//! Materials → étendue's models. What reflects does so on both sides in pbrt, and stands within `twosided` here.
//!
//! | pbrt | here |
//! | --- | --- |
//! | `diffuse`, `coateddiffuse`, `coatedconductor`, `hair` | the same, `twosided` (`hair` has no sides) |
//! | `conductor`, `dielectric` | `conductor`, `dielectric` below α = 0.001, else `roughconductor`, `roughdielectric` |
//! | `thindielectric`, `diffusetransmission` | the same |
//! | `interface`, `mix` | `null`, `blendbsdf` |
//! | `displacement`, `normalmap` | `bumpmap`, `normalmap` around the model |
//! | `measured` | the same, `twosided` |
//! | `subsurface` | refused |

use super::spectra::{Role, metal};
use super::values::{List, Type, Values};
use super::{Named, Reader, child, param};
use crate::assets::Format;
use etendue_description::{Kind, NodeId, Param, Span, Spanned, Value};
use etendue_numerics::spectrum::ior;

const MATERIALS: [&str; 11] = [
    "diffuse",
    "coateddiffuse",
    "coatedconductor",
    "conductor",
    "dielectric",
    "thindielectric",
    "diffusetransmission",
    "interface",
    "mix",
    "hair",
    "measured",
];

const REFUSED: [(&str, &str); 12] = [
    ("subsurface", "light that travels within surfaces cannot be rendered; `coateddiffuse` comes near its look"),
    ("matte", "in pbrt-v4 it is `diffuse` with `reflectance`"),
    ("plastic", "in pbrt-v4 it is `coateddiffuse`"),
    ("substrate", "in pbrt-v4 it is `coateddiffuse`"),
    ("metal", "in pbrt-v4 it is `conductor`"),
    ("mirror", "in pbrt-v4 it is `conductor` with `reflectance`"),
    ("glass", "in pbrt-v4 it is `dielectric`"),
    ("translucent", "in pbrt-v4 it is `diffusetransmission`"),
    ("uber", "pbrt-v4 has no such material; `coateddiffuse` comes near"),
    ("disney", "pbrt-v4 has no such material"),
    ("kdsubsurface", "light that travels within surfaces cannot be rendered"),
    ("fourier", "pbrt-v4 has no such material"),
];

/// Surfaces smoother than this are mirrors.
const SMOOTH: f64 = 1e-3;

/// α of an interface, in both directions.
struct Roughness {
    alpha: [Spanned<Value>; 2],
    /// Whether the values are pbrt's roughness, whose square root is α; textures only.
    remap: bool,
}

impl Roughness {
    fn is_smooth(&self) -> bool {
        self.alpha.iter().all(|a| matches!(a.value, Value::Float(x) if x < SMOOTH))
    }

    /// Parameters of a rough model.
    fn params(self, prefix: &str) -> Vec<Param> {
        let span = self.alpha[0].span;
        let mut params: Vec<Param> = ["alpha_u", "alpha_v"]
            .into_iter()
            .zip(self.alpha)
            .map(|(name, a)| param(&format!("{prefix}{name}"), a.value, a.span))
            .collect();
        if self.remap {
            params.push(param(&format!("{prefix}remap_roughness"), Value::Bool(true), span));
        }
        params
    }
}

/// GGX, with masking and shadowing that know of each other.
fn ggx(span: Span) -> [Param; 2] {
    [param("distribution", Value::String("ggx".to_owned()), span), param("masking", Value::String("correlated".to_owned()), span)]
}

impl Reader<'_> {
    pub(super) fn make_named_material(&mut self, name: String, at: Span, mut list: List) {
        let Some((model, place)) = list.text_opt(&mut self.diagnostics, "type") else {
            if !list.has("type") {
                self.diagnostics.error(at, format!("{} has no `type`", list.owner)).help("such as \"string type\" \"diffuse\"");
            }
            return;
        };
        list.span = place;
        list.owner = format!("material `{model}`");
        let node = self.material(&model, list);
        self.define(Named::Material, name, at, node);
    }

    /// The material where a scene names none.
    pub(super) fn default_material(&mut self, span: Span) -> NodeId {
        if let Some(known) = self.default_material {
            return known;
        }
        let diffuse = self.node(Kind::Bsdf, "diffuse", span, vec![param("reflectance", Value::Float(0.5), span)]);
        let node = self.node(Kind::Bsdf, "twosided", span, vec![child(diffuse, span)]);
        self.default_material = Some(node);
        node
    }

    /// The node of a material; one that cannot be made is told and answered by the default one.
    pub(super) fn material(&mut self, name: &str, mut list: List) -> NodeId {
        let span = list.span;
        let list = &mut list;
        list.ignore(&["type"]);
        let reflects = |reader: &mut Self, model: &str, params| {
            let inner = reader.node(Kind::Bsdf, model, span, params);
            (inner, true)
        };
        let (inner, two_sided) = match name {
            "diffuse" => {
                let params = self.reflectance(list, "reflectance", "reflectance", 0.5);
                reflects(self, "diffuse", params)
            }
            "conductor" => {
                let mut params = self.metal(list, "");
                let roughness = self.roughness(list, "", 0.0);
                if roughness.is_smooth() {
                    reflects(self, "conductor", params)
                } else {
                    params.extend(roughness.params("").into_iter().chain(ggx(span)));
                    reflects(self, "roughconductor", params)
                }
            }
            "dielectric" => {
                let mut params = self.index(list, "eta", 1.5);
                let roughness = self.roughness(list, "", 0.0);
                let even = matches!(params[0].value.value, Value::Float(x) if x == 1.0);
                if roughness.is_smooth() || even {
                    (self.node(Kind::Bsdf, "dielectric", span, params), false)
                } else {
                    params.extend(roughness.params("").into_iter().chain(ggx(span)));
                    (self.node(Kind::Bsdf, "roughdielectric", span, params), false)
                }
            }
            "thindielectric" => {
                let params = self.index(list, "eta", 1.5);
                (self.node(Kind::Bsdf, "thindielectric", span, params), false)
            }
            "coateddiffuse" => {
                let mut params = self.reflectance(list, "reflectance", "reflectance", 0.5);
                params.extend(self.index(list, "eta", 1.5));
                params.extend(self.roughness(list, "", 0.0).params(""));
                params.extend(self.coat(list));
                reflects(self, "coateddiffuse", params)
            }
            "coatedconductor" => {
                let mut params = self.metal(list, "conductor.");
                params.extend(self.index(list, "interface.eta", 1.5));
                params.extend(self.roughness(list, "interface.", 0.0).params(""));
                params.extend(self.roughness(list, "conductor.", 0.0).params("base_"));
                params.extend(self.coat(list));
                reflects(self, "coatedconductor", params)
            }
            "diffusetransmission" => {
                let mut params = self.reflectance(list, "reflectance", "reflectance", 0.25);
                params.extend(self.reflectance(list, "transmittance", "transmittance", 0.25));
                if let Some(scale) = list.float_opt(&mut self.diagnostics, "scale") {
                    params.push(param("scale", Value::Float(scale), list.span_of("scale")));
                }
                (self.node(Kind::Bsdf, "diffusetransmission", span, params), false)
            }
            "hair" => {
                let params = self.hair(list);
                (self.node(Kind::Bsdf, "hair", span, params), false)
            }
            "interface" | "" | "none" => (self.node(Kind::Bsdf, "null", span, Vec::new()), false),
            "mix" => {
                let Some(node) = self.mix(list) else {
                    list.finish(&mut self.diagnostics);
                    return self.default_material(span);
                };
                (node, false)
            }
            "measured" => {
                let Some((file, at)) = list.text_opt(&mut self.diagnostics, "filename") else {
                    if !list.has("filename") {
                        self.diagnostics.error(span, "a `measured` material needs the `filename` of what was measured");
                    }
                    return self.default_material(span);
                };
                let Some(path) = self.find(&file, at) else { return self.default_material(span) };
                let params = vec![param("filename", Value::Path(path.clone()), at)];
                let (inner, two_sided) = reflects(self, "measured", params);
                self.wanted.note(path, Format::Measured, inner, at);
                (inner, two_sided)
            }
            _ => {
                self.unknown_model(list, "material", name, &MATERIALS, &REFUSED);
                return self.default_material(span);
            }
        };
        let inner = self.bent(list, inner);
        list.finish(&mut self.diagnostics);
        if two_sided { self.node(Kind::Bsdf, "twosided", span, vec![child(inner, span)]) } else { inner }
    }

    /// `displacement` and `normalmap` around a material.
    fn bent(&mut self, list: &mut List, mut inner: NodeId) -> NodeId {
        let plain = |span| ["flip_invalid_normals", "use_shadowing_function"].map(|name| param(name, Value::Bool(false), span));
        if let Some(height) = self.number(list, "displacement")
            && let Value::Node(height_node) = height.value
        {
            let span = height.span;
            let mut params = vec![child(height_node, span), child(inner, span)];
            params.extend(plain(span));
            inner = self.node(Kind::Bsdf, "bumpmap", span, params);
        }
        if let Some((name, span)) = list.text_opt(&mut self.diagnostics, "normalmap")
            && let Some(path) = self.find(&name, span)
        {
            self.keep_bytes(&path);
            let texture = vec![
                param("filename", Value::Path(path), span),
                param("raw", Value::Bool(true), span),
                param("to_uv", Value::Transform(Box::new(super::textures::upright())), span),
            ];
            let texture = self.node(Kind::Texture, "bitmap", span, texture);
            let mut params = vec![param("normalmap", Value::Node(texture), span), child(inner, span)];
            params.extend(plain(span));
            inner = self.node(Kind::Bsdf, "normalmap", span, params);
        }
        inner
    }

    fn reflectance(&mut self, list: &mut List, name: &'static str, ours: &str, default: f64) -> Vec<Param> {
        match self.colour(list, name, Role::Reflectance) {
            Some(value) => vec![param(ours, value.value, value.span)],
            None => vec![param(ours, Value::Float(default), list.span)],
        }
    }

    /// An index of refraction against vacuum: `int_ior` and `ext_ior`.
    fn index(&mut self, list: &mut List, name: &'static str, default: f64) -> Vec<Param> {
        let span = list.span_of(name);
        let exterior = param("ext_ior", Value::Float(1.0), list.span);
        let named = match list.entries.iter().find(|e| e.name == name).map(|e| (e.kind, &e.values)) {
            Some((Type::Spectrum, Values::Texts(v))) if v.len() == 1 => Some(v[0].0.clone()),
            _ => None,
        };
        if let Some(glass) = named.filter(|name| ior::glass(name).is_some()) {
            list.raw(name);
            return vec![param("int_ior", Value::String(glass), span), exterior];
        }
        let value = if list.has_type(name, Type::Float) || list.has_type(name, Type::Texture) {
            self.number(list, name).map(|v| v.value)
        } else {
            self.colour(list, name, Role::Unbounded).map(|v| v.value)
        };
        let value = match value {
            None => Value::Float(default),
            Some(Value::Spectrum(etendue_description::SpectrumValue::Constant(x))) => Value::Float(x),
            Some(Value::Rgb([r, g, b])) => Value::Float(0.2126 * r + 0.7152 * g + 0.0722 * b),
            Some(Value::Node(_)) => {
                self.diagnostics.error(span, format!("`{name}` of {} cannot be a texture", list.owner));
                Value::Float(default)
            }
            Some(other) => other,
        };
        vec![param("int_ior", value, span), exterior]
    }

    /// α by `roughness`, or by `uroughness` and `vroughness`.
    fn roughness(&mut self, list: &mut List, prefix: &str, default: f64) -> Roughness {
        let [both, u, v] = match prefix {
            "interface." => ["interface.roughness", "interface.uroughness", "interface.vroughness"],
            "conductor." => ["conductor.roughness", "conductor.uroughness", "conductor.vroughness"],
            _ => ["roughness", "uroughness", "vroughness"],
        };
        let remap = list.bool(&mut self.diagnostics, "remaproughness", true);
        let both = self.number(list, both).unwrap_or(Spanned::new(Value::Float(default), list.span));
        let mut textured = false;
        let alpha = [u, v].map(|name| {
            let given = self.number(list, name).unwrap_or(both.clone());
            let value = match given.value {
                Value::Float(x) if x < 0.0 => {
                    self.diagnostics.error(given.span, format!("a roughness of {x} is below 0"));
                    Value::Float(0.0)
                }
                Value::Float(x) if remap => Value::Float(x.sqrt()),
                other => other,
            };
            textured |= matches!(value, Value::Node(_));
            Spanned::new(value, given.span)
        });
        // Constants beside a texture are roughness again, since both are remapped.
        let alpha = if textured && remap {
            alpha.map(|a| match a.value {
                Value::Float(x) => Spanned::new(Value::Float(x * x), a.span),
                _ => a,
            })
        } else {
            alpha
        };
        Roughness { alpha, remap: remap && textured }
    }

    /// `eta` and `k`, or `reflectance`; copper where nothing is said.
    fn metal(&mut self, list: &mut List, prefix: &str) -> Vec<Param> {
        let [eta, k] = if prefix.is_empty() { ["eta", "k"] } else { ["conductor.eta", "conductor.k"] };
        if list.has("reflectance") {
            for name in [eta, k] {
                if list.has(name) {
                    let text = format!("{} has either `reflectance`, or `{eta}` and `{k}`", list.owner);
                    self.diagnostics.error(list.span_of(name), text);
                }
                list.raw(name);
            }
            return self.reflectance(list, "reflectance", "reflectance", 0.5);
        }
        list.ignore(&["reflectance"]);
        let named = |list: &List, name: &str| match list.entries.iter().find(|e| e.name == name).map(|e| &e.values) {
            Some(Values::Texts(v)) if v.len() == 1 => metal(&v[0].0).map(|(metal, _)| metal),
            None => Some("Cu"),
            _ => None,
        };
        if let (Some(a), Some(b)) = (named(list, eta), named(list, k))
            && a == b
        {
            let span = list.span_of(eta);
            list.ignore(&[eta, k]);
            return vec![param("material", Value::String(a.to_owned()), span)];
        }
        let mut params = Vec::new();
        for (name, ours) in [(eta, "eta"), (k, "k")] {
            let value = self.colour(list, name, Role::Unbounded);
            let value = value.map_or_else(|| Value::Rgb(copper(ours)), |v| v.value);
            params.push(param(ours, value, list.span_of(name)));
        }
        params
    }

    /// What both coated models have.
    fn coat(&mut self, list: &mut List) -> Vec<Param> {
        let thickness = match self.number(list, "thickness").map(|v| v.value) {
            None => Value::Float(0.01),
            Some(Value::Float(x)) => Value::Float(x.max(f64::from(f32::MIN_POSITIVE))),
            Some(texture) => texture,
        };
        let g = self.number(list, "g").map_or(Value::Float(0.0), |v| v.value);
        let d = &mut self.diagnostics;
        let mut params = vec![
            param("thickness", thickness, list.span_of("thickness")),
            param("g", g, list.span_of("g")),
            param("max_depth", Value::Integer(list.integer(d, "maxdepth", 10, 1..=1000)), list.span_of("maxdepth")),
            param("samples", Value::Integer(list.integer(d, "nsamples", 1, 1..=1000)), list.span_of("nsamples")),
        ];
        if let Some(albedo) = self.colour(list, "albedo", Role::Reflectance) {
            params.push(param("albedo", albedo.value, albedo.span));
        }
        params
    }

    fn hair(&mut self, list: &mut List) -> Vec<Param> {
        let mut params = Vec::new();
        for (name, role) in [("sigma_a", Role::Unbounded), ("reflectance", Role::Reflectance), ("color", Role::Reflectance)] {
            if let Some(value) = self.colour(list, name, role) {
                let ours = if name == "color" { "reflectance" } else { name };
                params.push(param(ours, value.value, value.span));
            }
        }
        for name in ["eumelanin", "pheomelanin", "beta_m", "beta_n", "alpha"] {
            if let Some(value) = self.number(list, name) {
                params.push(param(name, value.value, value.span));
            }
        }
        params.extend(self.index(list, "eta", 1.55));
        params
    }

    fn mix(&mut self, list: &mut List) -> Option<NodeId> {
        let span = list.span;
        let amount = self.number(list, "amount").unwrap_or(Spanned::new(Value::Float(0.5), span));
        let Some((names, at)) = list.texts(&mut self.diagnostics, "materials") else {
            if !list.has("materials") {
                self.diagnostics.error(span, "a `mix` needs the names of two `materials`");
            }
            return None;
        };
        let [(first, _), (second, _)] = &names[..] else {
            self.diagnostics.error(at, format!("a `mix` is made of two `materials`, not {}", names.len()));
            return None;
        };
        let parts = [first, second].map(|name| self.named(Named::Material, name, at));
        let params = vec![param("weight", amount.value, amount.span), child(parts[0], at), child(parts[1], at)];
        Some(self.node(Kind::Bsdf, "blendbsdf", span, params))
    }
}

/// η or k of copper as linear Rec.709.
fn copper(part: &str) -> [f64; 3] {
    let metal = ior::Conductor::named("Cu").map(|m| m.to_rgb()).unwrap_or_default();
    (if part == "eta" { metal.0 } else { metal.1 }).map(f64::from)
}
