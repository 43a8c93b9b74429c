//! Parameters of boundaries: metals, indices of refraction, roughness.

use super::Writer;
use super::list::List;
use crate::pbrt::spectra::{GLASSES, METALS};
use crate::write::look::{flag, float, get, text};
use crate::write::pictures::mean;
use etendue_description::{Node, NodeId, SpectrumValue, Value};
use etendue_numerics::spectrum::{SampledSpectrum, cie, ior};
use glam::{DVec3, Vec3};

impl Writer<'_, '_> {
    /// Factors on what is specular that are not 1.
    pub(super) fn tints(&mut self, id: NodeId, names: &[&str]) {
        for name in names {
            let value = get(self.d.node(id), name).cloned();
            if value.is_some_and(|v| (mean(self.d, &v) - 1.0).abs().max_element() > 1e-6) {
                self.dropped(id, name, "what is specular has no tint in pbrt");
            }
        }
    }

    /// `eta` and `k`, or `reflectance`.
    pub(super) fn metal(&mut self, id: NodeId, list: &mut List, prefix: &str) {
        let node = self.d.node(id);
        let names = if prefix.is_empty() { ["eta", "k"] } else { ["conductor.eta", "conductor.k"] };
        let tint = get(node, "specular_reflectance").cloned();
        let mirror = ["eta", "k", "reflectance"].iter().all(|n| get(node, n).is_none())
            && text(node, "material").is_none_or(|name| name == "none");
        if let Some(tint) = tint.as_ref().filter(|_| mirror) {
            // A perfect mirror times a colour is near to a metal that reflects so much at normal incidence.
            self.colour(list, "reflectance", tint);
            return self.approximated(id, "specular_reflectance", "that at normal incidence of a metal");
        }
        if let Some(tint) = tint.as_ref().filter(|tint| (mean(self.d, tint) - 1.0).abs().max_element() > 1e-6) {
            // What it reflects at normal incidence, times the colour.
            let normal = self.normal_reflectance(node);
            let rgb = Value::Rgb((mean(self.d, tint).as_dvec3() * normal).to_array());
            self.colour(list, "reflectance", &rgb);
            return self.approximated(id, "specular_reflectance", "a metal that reflects as much at normal incidence");
        }
        if let Some(r) = get(node, "reflectance") {
            return self.colour(list, "reflectance", r);
        }
        match text(node, "material").filter(|name| *name != "none") {
            Some(metal) if METALS.contains(&metal) => {
                for (name, part) in names.iter().zip(["eta", "k"]) {
                    list.named_spectrum(name, &format!("metal-{metal}-{part}"));
                }
            }
            Some(metal) => {
                if let Some(metal) = ior::Conductor::named(metal) {
                    for (name, s) in names.iter().zip([metal.eta, metal.k]) {
                        list.spectrum(name, &s.pairs().collect::<Vec<_>>());
                    }
                }
            }
            None => {
                for (name, (ours, default)) in names.iter().zip([("eta", 0.0), ("k", 1.0)]) {
                    let value = get(node, ours).cloned().unwrap_or(Value::Float(default));
                    self.colour(list, name, &value);
                }
            }
        }
    }

    /// What a metal reflects at normal incidence: ((η - 1)² + k²) / ((η + 1)² + k²).
    fn normal_reflectance(&self, node: &Node) -> DVec3 {
        if let Some(r) = get(node, "reflectance") {
            return mean(self.d, r).as_dvec3();
        }
        let named = text(node, "material").and_then(ior::Conductor::named).map(|metal| metal.to_rgb());
        let rgb = |name: &str, default: f64| match get(node, name) {
            Some(Value::Spectrum(SpectrumValue::Samples(pairs))) => {
                SampledSpectrum::new(pairs).map_or(DVec3::splat(default), |s| Vec3::from(cie::unbounded_to_rgb(&s)).as_dvec3())
            }
            Some(value) => mean(self.d, value).as_dvec3(),
            None => DVec3::splat(default),
        };
        let (eta, k) = match named {
            Some((eta, k)) => (Vec3::from(eta).as_dvec3(), Vec3::from(k).as_dvec3()),
            None => (rgb("eta", 0.0), rgb("k", 1.0)),
        };
        ((eta - 1.0) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k)
    }

    /// An index of refraction over that outside.
    pub(super) fn index(&mut self, id: NodeId, list: &mut List, name: &str, default: f32) {
        let node = self.d.node(id);
        let outside = match get(node, "ext_ior") {
            Some(Value::String(word)) => ior::dielectric(word).unwrap_or(1.0),
            Some(_) => float(node, "ext_ior").unwrap_or(1.0) as f32,
            None => ior::dielectric("air").unwrap_or(1.000_277),
        };
        let measured = |s: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
            (0..95).map(|i| 360.0 + 5.0 * f64::from(i)).map(|nm| (nm, s(nm) / f64::from(outside))).collect()
        };
        match get(node, "int_ior") {
            Some(Value::String(word)) => match (ior::dielectric(word), ior::glass(word)) {
                (None, Some(glass)) if outside == 1.0 => match GLASSES.iter().find(|theirs| theirs.eq_ignore_ascii_case(word)) {
                    Some(theirs) => list.named_spectrum(name, theirs),
                    None => list.spectrum(name, &measured(&|nm| glass.index(nm))),
                },
                (None, Some(glass)) => list.spectrum(name, &measured(&|nm| glass.index(nm))),
                (index, _) => list.float(name, f64::from(index.unwrap_or(default) / outside)),
            },
            Some(Value::Spectrum(SpectrumValue::Samples(pairs))) => match SampledSpectrum::new(pairs) {
                Some(_) if outside == 1.0 => list.spectrum(name, pairs),
                Some(s) => list.spectrum(name, &measured(&|nm| s.eval_clamped(nm))),
                None => list.float(name, f64::from(default)),
            },
            // In single precision, as it is rendered.
            _ => match float(node, "int_ior") {
                Some(x) if outside == 1.0 => list.float(name, x),
                Some(x) => list.float(name, f64::from(x as f32 / outside)),
                None => list.float(name, f64::from(default / outside)),
            },
        }
    }

    /// α of both directions as roughness; `ours` stands before étendue's names, `prefix` before pbrt's.
    pub(super) fn roughness(&mut self, id: NodeId, list: &mut List, prefix: &str, ours: &str) {
        let node = self.d.node(id);
        let named = |name: &str| get(node, &format!("{ours}{name}")).cloned();
        let is_layer = matches!(node.model.value.as_str(), "coateddiffuse" | "coatedconductor");
        let both = named("alpha").unwrap_or(Value::Float(if is_layer { 0.0 } else { 0.1 }));
        let alpha = ["alpha_u", "alpha_v"].map(|name| named(name).unwrap_or(both.clone()));
        let remap = flag(node, &format!("{ours}remap_roughness"), false);
        if alpha[0] == alpha[1] {
            self.number(list, &format!("{prefix}roughness"), &alpha[0]);
        } else {
            self.number(list, &format!("{prefix}uroughness"), &alpha[0]);
            self.number(list, &format!("{prefix}vroughness"), &alpha[1]);
        }
        // One word for both roughnesses of a coated metal.
        if ours.is_empty() {
            list.bool("remaproughness", remap);
        }
        if is_layer {
            return;
        }
        if text(node, "distribution").unwrap_or("beckmann").eq_ignore_ascii_case("beckmann") {
            self.approximated(id, "distribution", "GGX: pbrt has no other");
        } else if text(node, "masking") != Some("correlated") {
            self.approximated(id, "distribution", "GGX, whose masking and shadowing know of each other in pbrt");
        }
    }
}
