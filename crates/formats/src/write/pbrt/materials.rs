//! Materials. Those that reflect do so on both sides in pbrt.
//!
//! | étendue | pbrt |
//! | --- | --- |
//! | `diffuse`, `conductor`, `dielectric`, `thindielectric`, `null`, `blendbsdf` | `diffuse`, `conductor`, `dielectric`, `thindielectric`, `interface`, `mix` |
//! | `roughconductor`, `roughdielectric` | `conductor`, `dielectric` with α = roughness, GGX with correlated masking |
//! | `plastic`, `roughplastic` | `coateddiffuse`; where not `nonlinear`, with the reflectance d/(1 - F + F d) that lets out as much light |
//! | `principled` | `coateddiffuse`, `conductor`, `dielectric`, or a `mix` by `metallic` |
//! | `principledthin` | `diffusetransmission` |
//! | `phong` | `coateddiffuse` as rough as √(2/(n + 2)) |
//! | `bumpmap`, `normalmap` | `displacement`, `normalmap` |
//! | `mask` | `alpha` of the shape |

use super::list::List;
use super::{Sort, Writer};
use crate::write::look::{child, children, float, get};
use etendue_description::{Kind, NodeId, Value};
use etendue_numerics::spectrum::ior;

/// A material without what is wrapped around it.
pub(super) struct Peeled {
    pub inner: NodeId,
    pub opacity: Option<Value>,
    two_sided: bool,
    /// A height and its factor.
    height: Option<(NodeId, f64)>,
    normals: Option<NodeId>,
}

impl Writer<'_, '_> {
    pub(super) fn peel(&self, id: NodeId) -> Peeled {
        let mut peeled = Peeled { inner: id, opacity: None, two_sided: false, height: None, normals: None };
        loop {
            let node = self.d.node(peeled.inner);
            match node.model.value.as_str() {
                "mask" if peeled.opacity.is_none() => {
                    peeled.opacity = Some(get(node, "opacity").cloned().unwrap_or(Value::Float(0.5)));
                }
                "twosided" => peeled.two_sided = true,
                "bumpmap" if peeled.height.is_none() => {
                    let height = children(self.d, peeled.inner, Kind::Texture).first().copied();
                    peeled.height = height.map(|h| (h, float(node, "scale").unwrap_or(1.0)));
                }
                "normalmap" if peeled.normals.is_none() => peeled.normals = child(node, "normalmap"),
                _ => return peeled,
            }
            match children(self.d, peeled.inner, Kind::Bsdf).first() {
                Some(inner) => peeled.inner = *inner,
                None => return peeled,
            }
        }
    }

    /// The name of a material, which is written where it is first asked for.
    pub(super) fn material(&mut self, id: NodeId) -> String {
        let peeled = self.peel(id);
        // What is the same but for its holes is one material.
        let mut key = id;
        while self.d.node(key).model.value == "mask"
            && let Some(inner) = children(self.d, key, Kind::Bsdf).first()
        {
            key = *inner;
        }
        if let Some(known) = self.materials.get(&key) {
            return known.clone();
        }
        let node = self.d.node(peeled.inner);
        if children(self.d, key, Kind::Bsdf).len() > 1 && self.d.node(key).model.value == "twosided" {
            self.approximated(key, "", "its first material on both sides");
        }
        let reflects = !matches!(
            node.model.value.as_str(),
            "dielectric"
                | "roughdielectric"
                | "thindielectric"
                | "null"
                | "diffusetransmission"
                | "blendbsdf"
                | "principledthin"
                | "hair"
        );
        if reflects && !peeled.two_sided {
            self.approximated(peeled.inner, "", "reflects on its back, too: pbrt's materials have no sides");
        }
        let mut list = List::default();
        self.model(peeled.inner, &mut list);
        if let Some((height, scale)) = peeled.height {
            let texture = self.scaled_texture(height, scale);
            list.texture("displacement", &texture);
        }
        if let Some(normals) = peeled.normals {
            match self.upright_picture(normals) {
                Some(file) => list.string("normalmap", &file),
                None => self.dropped(normals, "", "a normal map of pbrt is a picture"),
            }
        }
        let given = [id, key, peeled.inner].into_iter().find_map(|n| self.d.node(n).id.as_ref().map(|name| name.value.clone()));
        let name = self.free_name(Sort::Material, given, "material");
        self.materials.insert(key, name.clone());
        self.directive("MakeNamedMaterial", &name, list);
        name
    }

    /// The type and the parameters of a material.
    fn model(&mut self, id: NodeId, list: &mut List) {
        let node = self.d.node(id);
        let grey = |x: f64| Value::Float(x);
        let of = |name: &str, default: f64| get(node, name).cloned().unwrap_or(grey(default));
        match node.model.value.as_str() {
            "diffuse" => {
                list.string("type", "diffuse");
                self.colour(list, "reflectance", &of("reflectance", 0.5));
            }
            "conductor" | "roughconductor" => {
                list.string("type", "conductor");
                self.metal(id, list, "");
                if node.model.value == "roughconductor" {
                    self.roughness(id, list, "", "");
                }
            }
            "dielectric" | "roughdielectric" => {
                list.string("type", "dielectric");
                self.index(id, list, "eta", ior::dielectric("bk7").unwrap_or(1.5046));
                if node.model.value == "roughdielectric" {
                    self.roughness(id, list, "", "");
                }
                self.tints(id, &["specular_reflectance", "specular_transmittance"]);
            }
            "thindielectric" => {
                list.string("type", "thindielectric");
                self.index(id, list, "eta", ior::dielectric("bk7").unwrap_or(1.5046));
                self.tints(id, &["specular_reflectance", "specular_transmittance"]);
            }
            "plastic" | "roughplastic" => self.plastic(id, list),
            "phong" => self.phong(id, list),
            "principled" => self.principled(id, list),
            "principledthin" => self.principled_thin(id, list),
            "coateddiffuse" => {
                list.string("type", "coateddiffuse");
                self.colour(list, "reflectance", &of("reflectance", 0.5));
                self.index(id, list, "eta", 1.5);
                self.roughness(id, list, "", "");
                self.coat(node, list);
            }
            "coatedconductor" => {
                list.string("type", "coatedconductor");
                self.metal(id, list, "conductor.");
                self.index(id, list, "interface.eta", 1.5);
                self.roughness(id, list, "interface.", "");
                self.roughness(id, list, "conductor.", "base_");
                self.coat(node, list);
            }
            "diffusetransmission" => {
                list.string("type", "diffusetransmission");
                self.colour(list, "reflectance", &of("reflectance", 0.25));
                self.colour(list, "transmittance", &of("transmittance", 0.25));
                if let Some(scale) = float(node, "scale") {
                    list.float("scale", scale);
                }
            }
            "blendbsdf" => {
                let parts: Vec<NodeId> = children(self.d, id, Kind::Bsdf);
                for part in &parts {
                    if self.peel(*part).opacity.is_some() {
                        self.dropped(*part, "opacity", "holes of a part of a mixture: pbrt has those of a shape only");
                    }
                }
                let names: Vec<String> = parts.iter().map(|part| self.material(*part)).collect();
                list.string("type", "mix");
                list.strings("materials", &names);
                self.number(list, "amount", &of("weight", 0.5));
            }
            "null" => list.string("type", "interface"),
            "hair" => self.hair(id, list),
            "measured" => self.measured(id, list),
            _ => {
                list.string("type", "diffuse");
                self.approximated(id, "", "`diffuse`, grey");
            }
        }
    }

    fn measured(&mut self, id: NodeId, list: &mut List) {
        let Some(Value::Measured(index)) = get(self.d.node(id), "filename") else { return };
        let data = &self.d.assets.measured[*index as usize];
        if data.wavelengths.is_empty() {
            list.string("type", "diffuse");
            self.approximated(id, "", "`diffuse`, grey: pbrt reads measurements by wavelength only");
            return;
        }
        list.string("type", "measured");
        let file = self.beside.refer(self.d, &data.path);
        list.string("filename", &file);
    }
}
