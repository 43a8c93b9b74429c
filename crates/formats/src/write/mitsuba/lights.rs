//! Lights that Mitsuba does not know, or knows with fewer parameters.
//!
//! | étendue | Mitsuba |
//! | --- | --- |
//! | `area` with `scale`, `power` | worked into `radiance` |
//! | `area` with `two_sided` | its front only |
//! | `area` with `unseen` | seen |
//! | `area` with `masked` | shines where its mask has holes as well |
//! | `spot` with smooth `falloff` | linear between the same angles |
//! | `envmap` over equal areas, `illuminance` | a polar picture; worked into `scale` |
//! | `projector` without `falloff`, `power` | a picture times cos³θ/π; worked into `scale` |
//! | `goniometric` | `point` of its mean intensity |

use super::super::areas::area;
use super::super::look::{flag, float, get, nodes_in, remove, set, text};
use super::super::pictures::{Pixels, mean, slant};
use super::super::surroundings;
use super::plain::Plain;
use etendue_description::{NodeId, SpectrumValue, Value};
use glam::DVec3;
use std::f64::consts::PI;

impl Plain<'_, '_> {
    pub(super) fn emitter(&mut self, id: NodeId) {
        if remove(self.node(id), &["portal_corner", "portal_x", "portal_y"]) {
            self.approximated(id, "portal", "light comes through every opening");
        }
        match self.read.node(id).model.value.as_str() {
            "area" => self.area_light(id),
            "spot" if remove(self.node(id), &["falloff"]) && text(self.read.node(id), "falloff") == Some("smooth") => {
                self.approximated(id, "falloff", "linear between the same two angles");
            }
            "envmap" if text(self.read.node(id), "mapping") == Some("equal_area") => self.unfold(id),
            "projector" if text(self.read.node(id), "falloff") == Some("none") => self.projector(id),
            "goniometric" => self.goniometric(id),
            _ => {}
        }
    }

    fn area_light(&mut self, id: NodeId) {
        let node = self.read.node(id).clone();
        remove(self.node(id), &["scale", "power", "two_sided", "unseen", "masked"]);
        let two_sided = flag(&node, "two_sided", false);
        if flag(&node, "unseen", false) {
            self.approximated(id, "unseen", "is seen, and stands in the way");
        }
        if flag(&node, "masked", false) {
            self.approximated(id, "masked", "shines where its mask has holes as well");
        }
        if two_sided {
            self.approximated(id, "two_sided", "shines on its front only");
        }
        let mut factor = float(&node, "scale").unwrap_or(1.0);
        if let Some(power) = float(&node, "power") {
            let holder = (0..self.read.nodes.len() as u32)
                .map(NodeId)
                .find(|shape| nodes_in(self.read.node(*shape)).any(|child| child == id));
            let light = match get(&node, "radiance") {
                Some(texture @ Value::Node(_)) => luminance(mean(self.read, texture).as_dvec3()),
                _ => 1.0,
            };
            let sides = if two_sided { 2.0 } else { 1.0 };
            let unit = holder.and_then(|shape| area(self.read, shape)).map(|(a, n)| light * sides * PI * a / n as f64);
            factor *= unit.filter(|unit| *unit > 0.0).map_or(0.0, |unit| power / unit);
        }
        if factor != 1.0 {
            self.scale_emission(id, "radiance", factor);
        }
    }

    /// Multiplies what a parameter of a light holds.
    fn scale_emission(&mut self, id: NodeId, name: &str, factor: f64) {
        let value = get(self.d.node(id), name).cloned().unwrap_or(Value::Float(1.0));
        let new = match scaled(&value, factor) {
            Some(value) => value,
            None => match self.mapped(id, &value, |t| t * factor as f32) {
                Some(node) => {
                    self.approximated(id, name, "a picture of its own, with the light's scale worked in");
                    Value::Node(node)
                }
                None => value,
            },
        };
        set(self.node(id), name, new);
    }

    fn unfold(&mut self, id: NodeId) {
        let node = self.read.node(id).clone();
        remove(self.node(id), &["mapping", "illuminance"]);
        let Some(Value::Path(path)) = get(&node, "filename") else { return };
        let Some(square) = Pixels::read(self.read, path) else { return };
        if let Some(e) = float(&node, "illuminance") {
            let unit = surroundings::illuminance(&square).max(f64::MIN_POSITIVE);
            set(self.node(id), "scale", Value::Float(float(&node, "scale").unwrap_or(1.0) * e / unit));
        }
        let stem = path.file_stem().map_or("sky".into(), |s| s.to_string_lossy().into_owned());
        let file = self.beside.add(&format!("{stem}.exr"), surroundings::to_polar(&square).exr());
        set(self.node(id), "filename", Value::String(file));
        self.approximated(id, "filename", "unfolded anew, in latitude and longitude");
    }

    fn projector(&mut self, id: NodeId) {
        let node = self.read.node(id).clone();
        remove(self.node(id), &["falloff", "power"]);
        let Some(Value::Node(texture)) = get(&node, "irradiance") else {
            self.approximated(id, "falloff", "falls evenly on a plane");
            return;
        };
        let Some(picture) = Pixels::of(self.read, *texture) else { return };
        let (w, h) = (picture.width, picture.height);
        let aspect = w as f64 / h as f64;
        let tan = (0.5 * float(&node, "fov").unwrap_or(90.0)).to_radians().tan();
        // The angle is that of the smaller side.
        let half = if aspect > 1.0 { [tan * aspect, tan] } else { [tan, tan / aspect] };
        let cos = |x: usize, y: usize| 1.0 / slant([w, h], half, x, y);
        let cell = 4.0 * half[0] * half[1] / (w * h) as f64;
        if let Some(power) = float(&node, "power") {
            let light = |i: usize| luminance(picture.texels[i].as_dvec3()) * cos(i % w, i / w).powi(3) * cell;
            let unit: f64 = (0..w * h).map(light).sum();
            let scale = float(&node, "scale").unwrap_or(1.0) * if unit > 0.0 { power / unit } else { 0.0 };
            set(self.node(id), "scale", Value::Float(scale));
        }
        let new = Pixels::make(w, h, |x, y| picture.texel(x, y) * (cos(x, y).powi(3) / PI) as f32);
        let like = self.read.node(*texture).clone();
        let bitmap = self.add(id, etendue_description::Kind::Texture, "bitmap", &[]);
        let file = self.beside.add(&format!("projection-{}.exr", bitmap.0), new.exr());
        self.node(bitmap).params = like.params;
        remove(self.node(bitmap), &["raw"]);
        set(self.node(bitmap), "filename", Value::String(file));
        set(self.node(id), "irradiance", Value::Node(bitmap));
        self.approximated(id, "falloff", "a picture of its own, darker at its edges as a plane would have it");
    }

    fn goniometric(&mut self, id: NodeId) {
        let node = self.read.node(id).clone();
        let picture = match get(&node, "filename") {
            Some(Value::Path(path)) => Pixels::read(self.read, path),
            _ => None,
        };
        let even = match float(&node, "power") {
            Some(power) => power / (4.0 * PI),
            None => picture.map_or(1.0, |p| luminance(p.mean())),
        };
        self.model(id, "point");
        remove(self.node(id), &["filename", "power"]);
        self.scale_emission(id, "intensity", even);
        self.approximated(id, "", "`point` of the same flux, equally bright in all directions");
    }
}

pub(super) fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// A constant emission times a factor.
fn scaled(value: &Value, factor: f64) -> Option<Value> {
    Some(match value {
        Value::Float(x) => Value::Float(x * factor),
        Value::Integer(i) => Value::Float(*i as f64 * factor),
        Value::Rgb(rgb) => Value::Rgb(rgb.map(|x| x * factor)),
        Value::Spectrum(SpectrumValue::Constant(x)) => Value::Spectrum(SpectrumValue::Constant(x * factor)),
        Value::Spectrum(SpectrumValue::Samples(pairs)) => {
            Value::Spectrum(SpectrumValue::Samples(pairs.iter().map(|(nm, x)| (*nm, x * factor)).collect()))
        }
        Value::Spectrum(SpectrumValue::Blackbody { kelvin, scale }) => {
            Value::Spectrum(SpectrumValue::Blackbody { kelvin: *kelvin, scale: scale * factor })
        }
        _ => return None,
    })
}
