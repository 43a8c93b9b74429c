//! Materials of several layers, and those that are made of several.

use super::list::List;
use super::{Sort, Writer};
use crate::write::constants::folded;
use crate::write::layers::nonlinear;
use crate::write::look::{flag, float, get};
use crate::write::pictures::mean;
use etendue_description::{Node, NodeId, Value};
use etendue_numerics::spectrum::ior;

impl Writer<'_, '_> {
    pub(super) fn coat(&mut self, node: &Node, list: &mut List) {
        for name in ["thickness", "g"] {
            if let Some(x) = get(node, name) {
                self.number(list, name, x);
            }
        }
        for (name, theirs) in [("max_depth", "maxdepth"), ("samples", "nsamples")] {
            if let Some(n) = float(node, name) {
                list.integer(theirs, n as i64);
            }
        }
        if let Some(albedo) = get(node, "albedo") {
            self.colour(list, "albedo", albedo);
        }
    }

    pub(super) fn plastic(&mut self, id: NodeId, list: &mut List) {
        let node = self.d.node(id);
        let d = get(node, "diffuse_reflectance").cloned().unwrap_or(Value::Float(0.5));
        list.string("type", "coateddiffuse");
        let eta = self.relative_index(node, "polypropylene");
        let mut how = "`coateddiffuse`";
        let even = folded(self.d, &d);
        let d = match &even {
            _ if flag(node, "nonlinear", false) => d,
            Value::Node(_) => {
                how = "`coateddiffuse`, whose colours are fuller than without `nonlinear`";
                d
            }
            _ => {
                let rgb = mean(self.d, &d).as_dvec3().to_array();
                Value::Rgb(rgb.map(|x| nonlinear(x, f64::from(eta))))
            }
        };
        self.colour(list, "reflectance", &d);
        list.float("eta", f64::from(eta));
        let alpha = match node.model.value.as_str() {
            "plastic" => 0.0,
            _ => float(node, "alpha").or_else(|| float(node, "alpha_u")).unwrap_or(0.1),
        };
        list.float("roughness", alpha);
        list.bool("remaproughness", false);
        // Mitsuba's layer has no thickness, and light bounces in it without end.
        list.float("thickness", 1e-4);
        list.integer("maxdepth", 100);
        self.tints(id, &["specular_reflectance"]);
        self.approximated(id, "", how);
    }

    /// Fibres, by étendue's names or by Mitsuba's.
    pub(super) fn hair(&mut self, id: NodeId, list: &mut List) {
        let node = self.d.node(id);
        list.string("type", "hair");
        for name in ["sigma_a", "reflectance"] {
            if let Some(value) = get(node, name) {
                self.colour(list, name, value);
            }
        }
        let numbers = [
            ("eumelanin", "eumelanin"),
            ("pheomelanin", "pheomelanin"),
            ("beta_m", "longitudinal_roughness"),
            ("beta_n", "azimuthal_roughness"),
            ("alpha", "scale_tilt"),
        ];
        for (name, mitsuba) in numbers {
            if let Some(value) = get(node, name).or_else(|| get(node, mitsuba)) {
                self.number(list, name, value);
            }
        }
        self.index(id, list, "eta", 1.55);
    }

    fn relative_index(&self, node: &Node, default: &str) -> f32 {
        let of = |name: &str, default: &str| match get(node, name) {
            Some(Value::String(word)) => ior::dielectric(word).unwrap_or(1.5),
            Some(_) => float(node, name).unwrap_or(1.5) as f32,
            None => ior::dielectric(default).unwrap_or(1.5),
        };
        of("int_ior", default) / of("ext_ior", "air")
    }

    pub(super) fn phong(&mut self, id: NodeId, list: &mut List) {
        let node = self.d.node(id);
        list.string("type", "coateddiffuse");
        let d = get(node, "diffuse_reflectance").cloned().unwrap_or(Value::Float(0.5));
        self.colour(list, "reflectance", &d);
        let n =
            get(node, "exponent").map_or(30.0, |value| self.as_number(value).unwrap_or_else(|_| f64::from(mean(self.d, value).x)));
        list.float("roughness", (2.0 / (n + 2.0)).sqrt());
        list.bool("remaproughness", false);
        self.approximated(id, "", "`coateddiffuse` as rough as the exponent says");
    }

    pub(super) fn principled(&mut self, id: NodeId, list: &mut List) {
        let node = self.d.node(id);
        let of = |name: &str, default: f64| match get(node, name) {
            Some(value) => self.as_number(value).unwrap_or_else(|_| f64::from(mean(self.d, value).element_sum() / 3.0)),
            None => default,
        };
        let (metallic, through) = (of("metallic", 0.0), of("spec_trans", 0.0));
        let alpha = of("roughness", 0.5).powi(2);
        let specular = of("specular", 0.5);
        let eta = float(node, "eta").unwrap_or_else(|| 2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0);
        let colour = get(node, "base_color").cloned().unwrap_or(Value::Float(0.5));
        let metal = |this: &mut Self, list: &mut List| {
            list.string("type", "conductor");
            this.colour(list, "reflectance", &colour);
            list.float("roughness", alpha);
            list.bool("remaproughness", false);
        };
        let coated = |this: &mut Self, list: &mut List| {
            list.string("type", "coateddiffuse");
            this.colour(list, "reflectance", &colour);
            list.float("eta", eta);
            list.float("roughness", alpha);
            list.bool("remaproughness", false);
        };
        if through > 0.5 && metallic <= 0.5 {
            list.string("type", "dielectric");
            list.float("eta", eta);
            list.float("roughness", alpha);
            list.bool("remaproughness", false);
            self.approximated(id, "", "`dielectric`, without its colour");
        } else if metallic >= 1.0 {
            metal(self, list);
            self.approximated(id, "", "`conductor`");
        } else if metallic > 0.0 {
            let mut lists = [List::default(), List::default()];
            coated(self, &mut lists[0]);
            metal(self, &mut lists[1]);
            let names = lists.map(|part| {
                let name = self.name(Sort::Material, id, "material");
                self.directive("MakeNamedMaterial", &name, part);
                name
            });
            list.string("type", "mix");
            list.strings("materials", &names);
            match get(node, "metallic") {
                Some(value) => self.number(list, "amount", &value.clone()),
                None => list.float("amount", metallic),
            }
            self.approximated(id, "", "a `mix` of `coateddiffuse` and `conductor`");
        } else {
            coated(self, list);
            self.approximated(id, "", "`coateddiffuse`");
        }
    }

    pub(super) fn principled_thin(&mut self, id: NodeId, list: &mut List) {
        let node = self.d.node(id);
        // Of 2, how much of what is diffuse goes through.
        let through = get(node, "diff_trans").map_or(0.0, |value| f64::from(mean(self.d, value).x)) / 2.0;
        let rgb = get(node, "base_color").map_or([0.5; 3], |value| mean(self.d, value).as_dvec3().to_array());
        list.string("type", "diffusetransmission");
        list.rgb("reflectance", rgb.map(|x| x * (1.0 - through)));
        list.rgb("transmittance", rgb.map(|x| x * through));
        self.approximated(id, "", "`diffusetransmission`, without gloss");
    }
}
