//! Materials that Mitsuba does not know, or knows with fewer parameters.
//!
//! | étendue | Mitsuba |
//! | --- | --- |
//! | `coateddiffuse` | `plastic`, `roughplastic`, `nonlinear`: the same layers with all bounces between them |
//! | `coatedconductor` | `roughconductor`, without its coat |
//! | `diffusetransmission` | `principledthin`, rough and without gloss |
//! | `phong` | `roughplastic` with α = √(2/(n + 2)) |
//! | `conductor` by `reflectance` r | η = 1, k = 2 √(r/(1 - r)); textured: a perfect mirror times r |
//! | GGX with correlated masking | GGX with separable masking |
//! | glasses that disperse | their index at 587.56 nm |

use super::super::constants::{folded, rgb};
use super::super::layers::without_coat;
use super::super::look::{flag, float, get, remove, rename, set, text};
use super::super::pictures::mean;
use super::plain::Plain;
use etendue_description::{NodeId, SpectrumValue, Value};
use etendue_numerics::Spectrum;
use etendue_numerics::spectrum::{SampledSpectrum, ior, pigment::absorption_of};
use glam::Vec3;

impl Plain<'_, '_> {
    pub(super) fn material(&mut self, id: NodeId) {
        self.glass(id);
        match self.read.node(id).model.value.as_str() {
            "conductor" | "roughconductor" | "roughdielectric" => {
                self.metal(id);
                self.roughness(id);
            }
            "coateddiffuse" => self.coated_diffuse(id),
            "coatedconductor" => self.coated_conductor(id),
            "diffusetransmission" => self.diffuse_transmission(id),
            "phong" => self.phong(id),
            "hair" => self.hair(id),
            _ => {}
        }
    }

    /// Indices that Mitsuba takes as numbers and names only.
    fn glass(&mut self, id: NodeId) {
        for name in ["int_ior", "ext_ior"] {
            let index = match get(self.read.node(id), name) {
                Some(Value::String(word)) => ior::glass(word).map(|glass| glass.index(587.56)),
                Some(Value::Spectrum(SpectrumValue::Constant(x))) => Some(*x),
                Some(Value::Spectrum(SpectrumValue::Samples(pairs))) => SampledSpectrum::new(pairs).map(|s| s.eval_clamped(587.56)),
                _ => None,
            };
            if let Some(index) = index {
                // As étendue has it in a scene of red, green and blue.
                set(self.node(id), name, Value::Float(f64::from(index as f32)));
                if !matches!(get(self.read.node(id), name), Some(Value::Spectrum(SpectrumValue::Constant(_)))) {
                    self.approximated(id, name, "its index at 587.56 nm: Mitsuba's glass does not disperse");
                }
            }
        }
    }

    fn metal(&mut self, id: NodeId) {
        let Some(given) = get(self.read.node(id), "reflectance").map(|r| folded(self.read, r)) else { return };
        remove(self.node(id), &["reflectance"]);
        match rgb(&given) {
            Some(rgb) => {
                let k = |r: f64| 2.0 * (r.clamp(0.0, 0.9999) / (1.0 - r.clamp(0.0, 0.9999))).sqrt();
                set(self.node(id), "eta", Value::Rgb([1.0; 3]));
                set(self.node(id), "k", Value::Rgb(rgb.map(k)));
            }
            None => {
                set(self.node(id), "material", Value::String("none".to_owned()));
                set(self.node(id), "specular_reflectance", given);
                self.approximated(id, "reflectance", "the same at every angle: Mitsuba's metals have no textured index");
            }
        }
    }

    fn roughness(&mut self, id: NodeId) {
        if remove(self.node(id), &["masking"]) && text(self.read.node(id), "masking") == Some("correlated") {
            self.approximated(id, "masking", "GGX, whose masking and shadowing do not know of each other in Mitsuba");
        }
        if remove(self.node(id), &["remap_roughness"]) && flag(self.read.node(id), "remap_roughness", false) {
            for name in ["alpha", "alpha_u", "alpha_v"] {
                let Some(value) = get(self.read.node(id), name).cloned() else { continue };
                let new =
                    match (float(self.read.node(id), name), self.mapped(id, &value, |t| Vec3::from(t.to_array().map(f32::sqrt)))) {
                        (Some(x), _) => Value::Float(x.sqrt()),
                        (_, Some(node)) => Value::Node(node),
                        _ => Value::Float(f64::from(mean(self.read, &value).x.sqrt())),
                    };
                set(self.node(id), name, new);
            }
            self.approximated(id, "alpha", "a picture of its own: Mitsuba takes no root of a texture");
        }
    }

    /// One α of both directions, as a number.
    fn even_alpha(&self, id: NodeId, names: [&str; 2], remap: &str) -> f64 {
        let node = self.read.node(id);
        let alpha = names.map(|name| match get(node, name) {
            Some(value) => float(node, name).unwrap_or_else(|| f64::from(mean(self.read, value).x)),
            None => 0.0,
        });
        let alpha = if flag(node, remap, false) { alpha.map(f64::sqrt) } else { alpha };
        (alpha[0] * alpha[1]).sqrt()
    }

    fn coated_diffuse(&mut self, id: NodeId) {
        let alpha = self.even_alpha(id, ["alpha_u", "alpha_v"], "remap_roughness");
        let node = self.node(id);
        remove(node, &["alpha_u", "alpha_v", "remap_roughness", "thickness", "g", "max_depth", "samples", "albedo"]);
        rename(node, "reflectance", "diffuse_reflectance");
        self.thin_layer(id);
        let node = self.node(id);
        set(node, "nonlinear", Value::Bool(true));
        // Mitsuba's polypropylene and air are not the defaults here.
        if get(node, "int_ior").is_none() {
            set(node, "int_ior", Value::Float(1.5));
        }
        if alpha < 1e-3 {
            self.model(id, "plastic");
            self.approximated(id, "", "`plastic`, whose layer has no thickness");
            return;
        }
        self.model(id, "roughplastic");
        set(self.node(id), "distribution", Value::String("ggx".to_owned()));
        set(self.node(id), "alpha", Value::Float(alpha));
        self.approximated(id, "", "`roughplastic`, whose layer has no thickness and is equally rough in all directions");
    }

    /// The reflectance, where it is constant, that makes up for the layer's thickness and for bounces that are not counted.
    fn thin_layer(&mut self, id: NodeId) {
        let node = self.read.node(id);
        let given = get(node, "reflectance").map_or(Value::Float(0.5), |r| folded(self.read, r));
        let eta = float(node, "int_ior").unwrap_or(1.5) / float(node, "ext_ior").unwrap_or(1.0);
        let thickness = float(node, "thickness").unwrap_or(0.01);
        let depth = float(node, "max_depth").unwrap_or(10.0) as i64;
        if let Some(rgb) = rgb(&given) {
            let rgb = rgb.map(|rho| without_coat(rho, eta, thickness, depth));
            set(self.node(id), "diffuse_reflectance", Value::Rgb(rgb));
        }
    }

    fn coated_conductor(&mut self, id: NodeId) {
        let alpha = self.even_alpha(id, ["base_alpha_u", "base_alpha_v"], "base_remap_roughness");
        let node = self.node(id);
        remove(node, &["alpha_u", "alpha_v", "remap_roughness", "base_alpha_u", "base_alpha_v", "base_remap_roughness"]);
        remove(node, &["thickness", "g", "max_depth", "samples", "albedo", "int_ior", "ext_ior"]);
        self.metal(id);
        if alpha < 1e-3 {
            self.model(id, "conductor");
        } else {
            self.model(id, "roughconductor");
            set(self.node(id), "distribution", Value::String("ggx".to_owned()));
            set(self.node(id), "alpha", Value::Float(alpha));
        }
        self.approximated(id, "", "the metal without its coat");
    }

    fn diffuse_transmission(&mut self, id: NodeId) {
        let node = self.read.node(id).clone();
        let scale = float(&node, "scale").unwrap_or(1.0) as f32;
        let part = |name| get(&node, name).map_or(Vec3::splat(0.25), |value| mean(self.read, value)) * scale;
        let (r, t) = (part("reflectance"), part("transmittance"));
        let sum = (r + t).min(Vec3::ONE);
        let through = t.element_sum() / (r + t).element_sum().max(f32::MIN_POSITIVE);
        self.model(id, "principledthin");
        self.node(id).params.clear();
        let set_it = |this: &mut Self, name, value| set(this.node(id), name, value);
        set_it(self, "base_color", Value::Rgb(sum.as_dvec3().to_array()));
        set_it(self, "diff_trans", Value::Float(f64::from(2.0 * through)));
        set_it(self, "roughness", Value::Float(1.0));
        set_it(self, "eta", Value::Float(1.0001));
        self.approximated(id, "", "`principledthin` of one colour on both sides");
    }

    fn hair(&mut self, id: NodeId) {
        let given = get(self.read.node(id), "reflectance").map(|r| mean(self.read, r));
        let node = self.node(id);
        let names = [("beta_m", "longitudinal_roughness"), ("beta_n", "azimuthal_roughness"), ("alpha", "scale_tilt")];
        names.iter().for_each(|(ours, theirs)| rename(node, ours, theirs));
        let beta = float(node, "azimuthal_roughness").unwrap_or(0.3);
        if let Some(c) = given {
            remove(node, &["reflectance"]);
            let sigma = absorption_of(Spectrum::rgb(c.x, c.y, c.z), beta as f32).to_rgb();
            set(node, "sigma_a", Value::Rgb(sigma.map(f64::from)));
        }
        self.approximated(id, "", "Mitsuba's `hair`, made for curves and not for tubes");
    }

    fn phong(&mut self, id: NodeId) {
        let node = self.read.node(id).clone();
        let n = match get(&node, "exponent") {
            Some(value) => float(&node, "exponent").unwrap_or_else(|| f64::from(mean(self.read, value).x)),
            None => 30.0,
        };
        self.model(id, "roughplastic");
        remove(self.node(id), &["exponent"]);
        for (name, default) in [("diffuse_reflectance", 0.5), ("specular_reflectance", 0.2)] {
            if get(&node, name).is_none() {
                set(self.node(id), name, Value::Float(default));
            }
        }
        set(self.node(id), "alpha", Value::Float((2.0 / (n + 2.0)).sqrt()));
        self.approximated(id, "", "`roughplastic` as rough as the exponent says");
    }
}
