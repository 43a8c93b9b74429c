//! `LightSource`, `AreaLightSource` and media.

use super::emission::Emission;
use super::shapes::Opacity;
use super::spectra::Role;
use super::values::List;
use super::{Named, Reader, child, param};
use etendue_description::{Kind, NodeId, Param, Span, Value};
use etendue_numerics::Transform;
use glam::{DMat4, DVec3, Vec3};
use std::f64::consts::PI;
use std::path::PathBuf;

const LIGHTS: [&str; 6] = ["point", "spot", "goniometric", "projection", "distant", "infinite"];

impl Reader<'_> {
    pub(super) fn light(&mut self, name: &str, mut list: List) {
        let Some(to_world) = self.still(list.span, "this light") else { return };
        let list = &mut list;
        match name {
            "point" => self.point_light(list, &to_world),
            "spot" => self.spot_light(list, &to_world),
            "distant" => self.distant_light(list, &to_world),
            "goniometric" => self.goniometric_light(list, &to_world),
            "projection" => self.projection_light(list, &to_world),
            "infinite" => self.infinite_light(list, &to_world),
            "exinfinite" | "diffuse" => {
                self.unknown_model(list, "light", name, &LIGHTS, &[("diffuse", "it is an `AreaLightSource`")]);
            }
            _ => self.unknown_model(list, "light", name, &LIGHTS, &[]),
        }
        list.finish(&mut self.diagnostics);
    }

    /// Light of a point or a direction: the emission, scaled to `flux` by what a unit of it has.
    fn scaled_emission(&mut self, list: &mut List, name: &'static str, flux: &'static str, unit: f64) -> Emission {
        let scale = self.light_scale(list);
        let emission = self.emission(list, name);
        let factor = self.flux(list, flux).map_or(1.0, |flux| flux / unit);
        emission.scaled(scale * factor)
    }

    fn point_light(&mut self, list: &mut List, to_world: &Transform) {
        let intensity = self.scaled_emission(list, "I", "power", 4.0 * PI);
        let from = list.point(&mut self.diagnostics, "from").unwrap_or(DVec3::ZERO);
        let position = param("position", Value::Vector(to_world.point_f64(from)), list.span);
        self.top(Kind::Emitter, "point", list.span, vec![intensity.param("intensity"), position]);
    }

    /// The map of a light at `from` that looks at `to` along its z.
    fn aimed(&mut self, list: &mut List, to_world: &Transform) -> Option<Transform> {
        let d = &mut self.diagnostics;
        let from = list.point(d, "from").unwrap_or(DVec3::ZERO);
        let to = list.point(d, "to").unwrap_or(DVec3::Z);
        let Some(z) = (to - from).try_normalize() else {
            d.error(list.span_of("to"), format!("`from` and `to` of {} are the same point", list.owner));
            return None;
        };
        let (x, y) = z.any_orthonormal_pair();
        let aim = DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), from.extend(1.0));
        // The axes of a light are orthonormal, whatever the map does to them.
        let m = to_world.matrix();
        let ahead = m.transform_vector3(aim.z_axis.truncate()).try_normalize()?;
        let (x, y) = ahead.any_orthonormal_pair();
        let place = m.transform_point3(from);
        Transform::new(DMat4::from_cols(x.extend(0.0), y.extend(0.0), ahead.extend(0.0), place.extend(1.0)))
    }

    fn spot_light(&mut self, list: &mut List, to_world: &Transform) {
        let d = &mut self.diagnostics;
        let cutoff = list.float(d, "coneangle", 30.0);
        let delta = list.float(d, "conedeltaangle", 5.0);
        if !(cutoff > 0.0 && cutoff <= 180.0) {
            d.error(list.span_of("coneangle"), format!("`coneangle` is {cutoff}, expected more than 0 and at most 180 degrees"));
            return;
        }
        let beam = (cutoff - delta).clamp(0.0, cutoff);
        let [start, end] = [beam, cutoff].map(|degrees| degrees.to_radians().cos());
        let unit = 2.0 * PI * ((1.0 - start) + 0.5 * (start - end));
        let intensity = self.scaled_emission(list, "I", "power", unit);
        let Some(pose) = self.aimed(list, to_world) else { return };
        let span = list.span;
        let params = vec![
            intensity.param("intensity"),
            param("cutoff_angle", Value::Float(cutoff), list.span_of("coneangle")),
            param("beam_width", Value::Float(beam), list.span_of("conedeltaangle")),
            param("falloff", Value::String("smooth".to_owned()), span),
            param("to_world", Value::Transform(Box::new(pose)), span),
        ];
        self.top(Kind::Emitter, "spot", span, params);
    }

    fn distant_light(&mut self, list: &mut List, to_world: &Transform) {
        let irradiance = self.scaled_emission(list, "L", "illuminance", 1.0);
        let d = &mut self.diagnostics;
        let from = list.point(d, "from").unwrap_or(DVec3::ZERO);
        let to = list.point(d, "to").unwrap_or(DVec3::Z);
        let direction = to_world.matrix().transform_vector3(to - from);
        let direction = param("direction", Value::Vector(direction), list.span);
        self.top(Kind::Emitter, "directional", list.span, vec![irradiance.param("irradiance"), direction]);
    }

    /// The picture that a light names.
    fn picture(&mut self, list: &mut List) -> Option<(PathBuf, Span)> {
        let (name, span) = list.text_opt(&mut self.diagnostics, "filename")?;
        let path = self.find(&name, span)?;
        self.keep_bytes(&path);
        Some((path, span))
    }

    /// Whoever opens a file later will not know the caller's map.
    pub(super) fn keep_bytes(&mut self, path: &std::path::Path) {
        if let Some(bytes) = self.files.options.files.get(&crate::files::plain(path)) {
            self.description.assets.files.insert(path.to_path_buf(), bytes.clone());
        }
    }

    fn goniometric_light(&mut self, list: &mut List, to_world: &Transform) {
        let scale = self.light_scale(list);
        let emission = self.emission(list, "I").scaled(scale);
        let power = self.flux(list, "power");
        let Some((path, at)) = self.picture(list) else {
            if !list.has("filename") {
                // An even light, as pbrt has it.
                let emission = emission.scaled(power.map_or(1.0, |power| power / (4.0 * PI)));
                let position = param("position", Value::Vector(to_world.point_f64(DVec3::ZERO)), list.span);
                self.top(Kind::Emitter, "point", list.span, vec![emission.param("intensity"), position]);
            }
            return;
        };
        let span = list.span;
        let mut params = vec![
            emission.param("intensity"),
            param("filename", Value::Path(path), at),
            // The picture's pole is the light's y.
            param("to_world", Value::Transform(Box::new(swapped(to_world))), span),
        ];
        params.extend(power.map(|power| param("power", Value::Float(power), list.span_of("power"))));
        self.top(Kind::Emitter, "goniometric", span, params);
    }

    fn projection_light(&mut self, list: &mut List, to_world: &Transform) {
        let scale = self.light_scale(list);
        let power = self.flux(list, "power");
        let fov = list.float(&mut self.diagnostics, "fov", 90.0);
        if !(fov > 0.0 && fov < 180.0) {
            let text = format!("`fov` is {fov}, expected more than 0 and less than 180 degrees");
            self.diagnostics.error(list.span_of("fov"), text);
            return;
        }
        let Some((path, at)) = self.picture(list) else {
            if !list.has("filename") {
                self.diagnostics.error(list.span, "a `projection` light needs a `filename`");
            }
            return;
        };
        let span = list.span;
        let texture =
            vec![param("filename", Value::Path(path), at), param("filter_type", Value::String("nearest".to_owned()), span)];
        let texture = self.node(Kind::Texture, "bitmap", span, texture);
        // pbrt's picture has its first row on the side of y.
        let pose = to_world.matrix() * DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let Some(pose) = Transform::new(pose) else { return };
        let mut params = vec![
            param("irradiance", Value::Node(texture), at),
            param("scale", Value::Float(scale), list.span_of("scale")),
            param("fov", Value::Float(fov), list.span_of("fov")),
            param("fov_axis", Value::String("smaller".to_owned()), span),
            param("falloff", Value::String("none".to_owned()), span),
            param("to_world", Value::Transform(Box::new(pose)), span),
        ];
        params.extend(power.map(|power| param("power", Value::Float(power), list.span_of("power"))));
        self.top(Kind::Emitter, "projector", span, params);
    }

    fn infinite_light(&mut self, list: &mut List, to_world: &Transform) {
        let span = list.span;
        let scale = self.light_scale(list);
        let illuminance = self.flux(list, "illuminance");
        let given = list.has("L");
        let radiance = self.emission(list, "L");
        let portal = self.portal(list);
        let Some((path, at)) = self.picture(list) else {
            if !list.has("filename") {
                let radiance = radiance.scaled(scale * illuminance.map_or(1.0, |e| e / PI));
                let params = std::iter::once(radiance.param("radiance")).chain(portal).collect();
                self.top(Kind::Emitter, "constant", span, params);
            }
            return;
        };
        if given {
            self.diagnostics.error(list.span_of("L"), "an `infinite` light has either `L` or `filename`");
        }
        let mut params = vec![
            param("filename", Value::Path(path), at),
            param("mapping", Value::String("equal_area".to_owned()), span),
            param("scale", Value::Float(scale), list.span_of("scale")),
            param("to_world", Value::Transform(Box::new(*to_world)), span),
        ];
        let e = illuminance.map(|e| param("illuminance", Value::Float(e), list.span_of("illuminance")));
        params.extend(e);
        params.extend(portal);
        self.top(Kind::Emitter, "envmap", span, params);
    }

    /// The corners of a rectangle in the world, whatever the current transform is.
    fn portal(&mut self, list: &mut List) -> Vec<Param> {
        let Some(corners) = list.points(&mut self.diagnostics, "portal") else { return Vec::new() };
        let span = list.span_of("portal");
        let Ok([a, b, c, d]) = <[Vec3; 4]>::try_from(corners.as_slice()).map(|p| p.map(|p| p.as_dvec3())) else {
            self.diagnostics.error(span, format!("a `portal` has four corners, not {}", corners.len()));
            return Vec::new();
        };
        // Opposite edges are the same.
        if (b - a - (c - d)).length() > 1e-3 * (b - a).length() {
            self.diagnostics.error(span, "a `portal` is a rectangle, told around its edge");
            return Vec::new();
        }
        let vectors = [("portal_corner", a), ("portal_x", d - a), ("portal_y", b - a)];
        vectors.map(|(name, v)| param(name, Value::Vector(v), span)).to_vec()
    }

    /// The emitter of a shape under the current area light.
    pub(super) fn area_light(&mut self, opacity: Opacity) -> Option<NodeId> {
        let light = self.state.area_light.clone()?;
        let mut list = (*light).clone();
        let list = &mut list;
        let span = list.span;
        if list.owner != "area light `diffuse`" {
            let name = list.owner.split('`').nth(1).unwrap_or_default().to_owned();
            self.unknown_model(list, "area light", &name, &["diffuse"], &[]);
            self.state.area_light = None;
            return None;
        }
        let scale = self.light_scale(list);
        let power = self.flux(list, "power");
        let two_sided = list.bool(&mut self.diagnostics, "twosided", false);
        let given = list.has("L");
        let radiance = self.emission(list, "L");
        let mut params = Vec::new();
        match self.picture(list) {
            Some((path, at)) => {
                if given {
                    self.diagnostics.error(list.span_of("L"), "a `diffuse` light has either `L` or `filename`");
                }
                let bitmap = vec![
                    param("filename", Value::Path(path), at),
                    param("filter_type", Value::String("nearest".to_owned()), span),
                    param("wrap_mode", Value::String("clamp".to_owned()), span),
                    param("to_uv", Value::Transform(Box::new(super::textures::upright())), span),
                ];
                let bitmap = self.node(Kind::Texture, "bitmap", span, bitmap);
                params.push(param("radiance", Value::Node(bitmap), at));
                params.push(param("scale", Value::Float(scale), list.span_of("scale")));
            }
            None => params.push(radiance.scaled(scale).param("radiance")),
        }
        if two_sided {
            params.push(param("two_sided", Value::Bool(true), list.span_of("twosided")));
        }
        match opacity {
            Opacity::Full => {}
            Opacity::Partial => params.push(param("masked", Value::Bool(true), span)),
            // Of samples of such a light nobody else has a share; rays pass through.
            Opacity::None => params.push(param("unseen", Value::Bool(true), span)),
        }
        if let Some(power) = power {
            // pbrt gives each of a mesh's triangles the whole of it; the light's own scale and colour multiply that.
            params.push(param("power", Value::Float(power), list.span_of("power")));
        }
        list.finish(&mut self.diagnostics);
        Some(self.node(Kind::Emitter, "area", span, params))
    }

    // ---- media

    pub(super) fn make_named_medium(&mut self, name: String, at: Span, mut list: List) {
        let model = list.text_opt(&mut self.diagnostics, "type").map_or("homogeneous".to_owned(), |(name, _)| name);
        let known = ["homogeneous", "uniformgrid", "rgbgrid", "cloud", "nanovdb"];
        if !known.contains(&model.as_str()) {
            let span = list.span_of("type");
            self.diagnostics.error(span, format!("unknown medium `{model}`")).suggest(&model, known);
        }
        // Kept for the day when media are rendered; none of its numbers is used yet.
        let mut params = Vec::new();
        for name in ["sigma_a", "sigma_s", "Le"] {
            if let Some(value) = self.colour(&mut list, name, if name == "Le" { Role::Light } else { Role::Unbounded }) {
                params.push(param(name, value.value, value.span));
            }
        }
        for name in ["scale", "g", "Lescale"] {
            if let Some(x) = list.float_opt(&mut self.diagnostics, name) {
                params.push(param(name, Value::Float(x), list.span_of(name)));
            }
        }
        if let Some((preset, span)) = list.text_opt(&mut self.diagnostics, "preset") {
            params.push(param("preset", Value::String(preset), span));
        }
        let node = self.node(Kind::Medium, &model, at, params);
        self.define(Named::Medium, name, at, node);
    }

    pub(super) fn medium_interface(&mut self, t: &mut super::tokens::Tokens, source: etendue_description::SourceId, span: Span) {
        let (names, at) = self.names(t, source, span);
        match names.len() {
            1 | 2 => {
                let outside = names.last().cloned().unwrap_or_default();
                let both = [names[0].clone(), outside];
                let any = both.iter().any(|name| !name.is_empty());
                self.state.media = any.then(|| std::sync::Arc::new((both, at)));
            }
            n => {
                self.mistakes += 1;
                self.diagnostics.error(span, format!("`MediumInterface` is followed by one or two names, not {n}"));
            }
        }
    }

    /// The media of a shape as its children.
    pub(super) fn shape_media(&mut self) -> Vec<Param> {
        let Some(media) = self.state.media.clone() else { return Vec::new() };
        let (names, span) = &*media;
        let sides = ["interior", "exterior"].into_iter().zip(names).filter(|(_, name)| !name.is_empty());
        let sides: Vec<_> = sides.map(|(side, name)| (side, self.named(Named::Medium, name, *span))).collect();
        sides
            .into_iter()
            .map(|(side, node)| Param { name: param(side, Value::Bool(true), *span).name, ..child(node, *span) })
            .collect()
    }
}

/// y and z of the light's coordinates change places.
fn swapped(to_world: &Transform) -> Transform {
    let swap = DMat4::from_cols_array(&[1., 0., 0., 0., 0., 0., 1., 0., 0., 1., 0., 0., 0., 0., 0., 1.]);
    Transform::new(to_world.matrix() * swap).unwrap_or(*to_world)
}
