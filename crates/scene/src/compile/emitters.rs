//! Emitter nodes → [`Emitter`].

use super::Compiler;
use super::sensors::Scales;
use crate::emitter::{
    Area, Constant, Directional, DirectionalArea, Emitter, Environment, Goniometric, Model, Octahedral, Point, Portal, Projector,
    Spot,
};
use crate::ids::{EmitterId, SurfaceId, TextureId};
use crate::material::Material;
use crate::texture::{Color, ColorSlot, Product, Role, ScalarSlot, Texels, Texture};
use etendue_description::{Dialect, NodeId, Params};
use etendue_numerics::{Frame, Vec2, Vec3};
use std::sync::Arc;

/// Lights that are a surface's, and those that stand alone.
const ON_SURFACES: &[&str] = &["area", "directionalarea"];
const ALONE: &[&str] = &["point", "spot", "directional", "envmap", "constant", "projector", "goniometric"];

const SKY: &str = "skies cannot be rendered yet; an `envmap` of a sky can";

const REFUSED: &[(&str, &str)] = &[
    ("sunsky", SKY),
    ("timed_sunsky", SKY),
    ("sky", SKY),
    ("sun", "suns cannot be rendered yet; a `directional` light comes close"),
    ("volumelight", "glowing media cannot be rendered yet"),
];

impl<'a> Compiler<'a> {
    /// Compiles an emitter: of a surface where one is given, or one that stands alone.
    pub(crate) fn emitter(&mut self, id: NodeId, surface: Option<SurfaceId>) {
        let mut params = Params::new(self.description, id);
        let model = params.node.model.value.as_str();
        let (on_surfaces, alone) = (ON_SURFACES.contains(&model), ALONE.contains(&model));
        if !on_surfaces && !alone {
            let known = [ON_SURFACES, ALONE].concat();
            return self.refuse_model(&params, &known, REFUSED);
        }
        if on_surfaces && surface.is_none() {
            let text = format!("emitter `{model}` stands alone: it belongs into a shape, which then shines");
            self.diagnostics.error(params.span(), text);
            return;
        }
        if alone && surface.is_some() {
            let text = format!("emitter `{model}` does not belong to a shape; put it beside the shapes, into the scene");
            self.diagnostics.error(params.span(), text).help("a shape shines by an `area` emitter");
            return;
        }

        let sampling_weight = params.float(self.diagnostics, "sampling_weight", 1.0, 0.0..=1e6) as f32;
        let model = match (model, surface) {
            ("area", Some(surface)) => Some(self.area(&mut params, surface).into()),
            ("directionalarea", Some(surface)) => {
                Some(DirectionalArea { surface, radiance: self.emission(&mut params, "radiance", 1.0) }.into())
            }
            ("point", _) => Some(self.point(&mut params).into()),
            ("spot", _) => self.spot(&mut params).map(Model::from),
            ("directional", _) => self.directional(&mut params).map(Model::from),
            ("constant", _) => {
                let light = Constant { radiance: self.even_emission(&mut params, "radiance") }.into();
                self.behind_portal(&mut params, light)
            }
            ("envmap", _) => {
                let light = self.environment(&mut params);
                light.and_then(|light| self.behind_portal(&mut params, light))
            }
            ("goniometric", _) => self.goniometric(&mut params).map(Model::from),
            _ => self.projector(&mut params).map(Model::from),
        };
        params.finish(self.diagnostics);

        if let Some(model) = model {
            let emitter = EmitterId(self.emitters.len() as u32);
            self.emitters.push(Emitter { model, sampling_weight, node: id, lit: true });
            if let Some(surface) = surface {
                self.surfaces.get_mut(surface).emitter = Some(emitter);
            }
        }
    }

    /// Surroundings as they are, or as they are seen through a rectangle: `portal_corner` with its edges `portal_x` and `portal_y`, whose cross product points
    /// outwards.
    fn behind_portal(&mut self, params: &mut Params<'a>, light: Model) -> Option<Model> {
        let given = ["portal_corner", "portal_x", "portal_y"].map(|name| params.vector_opt(self.diagnostics, name));
        let [corner, x, y] = match given {
            [None, None, None] => return Some(light),
            [Some(corner), Some(x), Some(y)] => [corner, x, y].map(|v| v.as_vec3()),
            _ => {
                self.diagnostics.error(params.span(), "a portal is told by `portal_corner`, `portal_x` and `portal_y`");
                return None;
            }
        };
        let rectangle = x.dot(y).abs() <= 2e-3 * x.length() * y.length();
        let portal = if rectangle { Portal::new(light, corner, [x, y]) } else { None };
        if portal.is_none() {
            self.diagnostics.error(params.span_of("portal_corner"), "a portal is a rectangle: two edges at right angles");
        }
        portal.map(Model::from)
    }

    /// Emission that cannot vary over space, 1 by default.
    fn even_emission(&mut self, params: &mut Params<'a>, name: &'static str) -> Color {
        match self.emission(params, name, 1.0) {
            ColorSlot::Constant(color) => color,
            ColorSlot::Texture(_) => {
                let text = format!("`{name}` of `{}` cannot be a texture: there is no surface for it", params.node.model.value);
                self.diagnostics.error(params.span_of(name), text);
                Color::rgb([1.0; 3], Role::Emission)
            }
        }
    }

    fn area(&mut self, params: &mut Params<'a>, surface: SurfaceId) -> Area {
        let mut radiance = self.emission(params, "radiance", 1.0);
        let mut scale = params.float(self.diagnostics, "scale", 1.0, 0.0..=1e30) as f32;
        let two_sided = params.bool(self.diagnostics, "two_sided", false);
        let unseen = params.bool(self.diagnostics, "unseen", false);
        self.surfaces.get_mut(surface).in_world &= !unseen;
        if params.has("power") {
            let power = params.float(self.diagnostics, "power", 0.0, 0.0..=1e30);
            // Of a mesh each triangle has the power, evenly over all of them. A constant colour multiplies it.
            let shape = &self.surfaces.get(surface).shape;
            let pieces = shape.mesh().map_or(1, |mesh| mesh.indices.len().max(1)) as f64;
            let luminance = match &radiance {
                ColorSlot::Constant(_) => 1.0,
                ColorSlot::Texture(id) => match &self.textures[id.index()] {
                    Texture::Bitmap(bitmap) => bitmap.texels.mean().luminance(),
                    _ => 1.0,
                },
            };
            let sides = if two_sided { 2.0 } else { 1.0 };
            let unit = f64::from(luminance) * sides * std::f64::consts::PI * shape.area();
            scale *= if unit > 0.0 { (power * pieces / unit) as f32 } else { 0.0 };
        }
        // What is missing does not shine. The power is that of the whole.
        if params.bool(self.diagnostics, "masked", false)
            && let Material::Mask(mask) = self.at(self.surfaces.get(surface).material)
        {
            match *mask.opacity() {
                ScalarSlot::Constant(opacity) => scale *= opacity.clamp(0.0, 1.0),
                opacity => {
                    self.textures.push(Texture::Product(Product { a: radiance, b: opacity }));
                    radiance = ColorSlot::Texture(TextureId(self.textures.len() as u32 - 1));
                }
            }
        }
        Area { surface, radiance, scale, two_sided, unseen }
    }

    fn goniometric(&mut self, params: &mut Params<'a>) -> Option<Goniometric> {
        let intensity = self.even_emission(params, "intensity");
        let power = params.float_opt(self.diagnostics, "power");
        let pose = self.pose(params, Scales::TakeOut);
        let texels = self.picture(params)?;
        let (p, axes) = pose?;
        let lamp = Goniometric::new(p, axes, intensity.clone(), 1.0, &texels);
        let unit = 4.0 * std::f64::consts::PI * lamp.mean();
        Some(match power {
            Some(power) if unit > 0.0 => Goniometric::new(p, axes, intensity, (power / unit) as f32, &texels),
            _ => lamp,
        })
    }

    fn point(&mut self, params: &mut Params<'a>) -> Point {
        let intensity = self.even_emission(params, "intensity");
        let to_world = params.transform(self.diagnostics, "to_world");
        let position = params.vector_opt(self.diagnostics, "position");
        self.one_of(params, "position", "to_world");
        let p = position.map_or_else(|| to_world.point(Vec3::ZERO), |p| p.as_vec3());
        Point { p, intensity }
    }

    fn spot(&mut self, params: &mut Params<'a>) -> Option<Spot> {
        let intensity = self.even_emission(params, "intensity");
        let cutoff = params.float(self.diagnostics, "cutoff_angle", 20.0, 1e-3..=180.0);
        let beam = params.float(self.diagnostics, "beam_width", 0.75 * cutoff, 0.0..=180.0);
        let smooth = params.choice(self.diagnostics, "falloff", &["linear", "smooth"]) == 1;
        let texture = params.has("texture").then(|| self.unbounded(params, "texture", 1.0));
        self.needs_no_surface(params, "texture", texture.as_ref());
        let (p, axes) = self.pose(params, Scales::TakeOut)?;
        let spot = Spot::new(p, axes, intensity, cutoff.to_radians() as f32, beam.to_radians() as f32, texture);
        Some(if smooth { spot.smooth() } else { spot })
    }

    fn directional(&mut self, params: &mut Params<'a>) -> Option<Directional> {
        let irradiance = self.even_emission(params, "irradiance");
        let to_world = params.transform(self.diagnostics, "to_world");
        let given = params.vector_opt(self.diagnostics, "direction");
        self.one_of(params, "direction", "to_world");
        let direction = given.map_or_else(|| to_world.vector(Vec3::Z), |d| d.as_vec3()).try_normalize();
        if direction.is_none() {
            let text = "`direction` of `directional` has no length";
            self.diagnostics.error(params.span_of(if given.is_some() { "direction" } else { "to_world" }), text);
        }
        direction.map(|direction| Directional { direction, irradiance })
    }

    fn environment(&mut self, params: &mut Params<'a>) -> Option<Model> {
        let scale = params.float(self.diagnostics, "scale", 1.0, 0.0..=1e30) as f32;
        let equal_area = params.choice(self.diagnostics, "mapping", &["polar", "equal_area"]) == 1;
        let illuminance = if equal_area { params.float_opt(self.diagnostics, "illuminance") } else { None };
        // Light that the sampler takes away from the table is a matter of noise alone.
        params.ignore(&["mis_compensation"]);
        let pose = self.pose(params, Scales::TakeOut);
        let texels = self.picture(params)?;
        let (_, axes) = pose?;
        if !equal_area {
            let mitsuba = self.description.dialect == Dialect::Mitsuba;
            return Some(Environment::new(Arc::new(texels), scale, axes).with_hue_apart(mitsuba).into());
        }
        if texels.width() != texels.height() {
            let text = format!("this picture has {} x {} pixels: the sphere unfolded is a square", texels.width(), texels.height());
            self.diagnostics.error(params.span_of("filename"), text);
            return None;
        }
        let factor = match illuminance {
            Some(e) => e / Octahedral::illuminance(&texels).max(f64::MIN_POSITIVE),
            None => 1.0,
        };
        Some(Octahedral::new(Arc::new(texels), (f64::from(scale) * factor) as f32, axes).into())
    }

    /// The picture `filename`.
    fn picture(&mut self, params: &mut Params<'a>) -> Option<Texels> {
        if !params.has("filename") {
            self.diagnostics.error(params.span(), format!("`{}` needs a `filename`", params.node.model.value));
        }
        let path = params.path_opt(self.diagnostics, "filename")?;
        let span = params.span_of("filename");
        let texels = match etendue_image::load(path) {
            Ok(image) => Texels::new(image, None),
            Err(error) => {
                self.diagnostics.error(span, error.to_string());
                return None;
            }
        };
        let Some(texels) = texels else {
            let text = format!("{}: expected channels R, G, B or Y, with or without A", path.display());
            self.diagnostics.error(span, text);
            return None;
        };
        if texels.mended > 0 {
            let text = format!("{} numbers of this picture are not finite; they are taken as 0", texels.mended);
            self.diagnostics.warning(span, text);
        }
        Some(texels)
    }

    fn projector(&mut self, params: &mut Params<'a>) -> Option<Projector> {
        let scale = params.float(self.diagnostics, "scale", 1.0, 0.0..=1e30) as f32;
        let plain = params.choice(self.diagnostics, "falloff", &["even", "none"]) == 1;
        let power = if plain { params.float_opt(self.diagnostics, "power") } else { None };
        let irradiance = self.emission(params, "irradiance", 1.0);
        self.needs_no_surface(params, "irradiance", Some(&irradiance));
        let aspect = match &irradiance {
            ColorSlot::Texture(id) => match &self.textures[id.index()] {
                Texture::Bitmap(bitmap) => bitmap.texels.width() as f64 / bitmap.texels.height() as f64,
                _ => 1.0,
            },
            ColorSlot::Constant(_) => 1.0,
        };
        let tan = self.tan_half_fov(params, aspect);
        let (p, axes): (Vec3, Frame) = self.pose(params, Scales::TakeOut)?;
        let half = Vec2::new(tan as f32, (tan / aspect) as f32);
        if !plain {
            return Some(Projector::new(p, axes, half, irradiance, scale));
        }
        let scale = power.map_or(scale, |power| {
            let unit = match &irradiance {
                ColorSlot::Texture(id) => self.flux_of_picture(&self.textures[id.index()], half),
                ColorSlot::Constant(_) => 0.0,
            };
            if unit > 0.0 { (f64::from(scale) * power / unit) as f32 } else { 0.0 }
        });
        Some(Projector::new(p, axes, half, irradiance, scale).plain())
    }

    /// ∫ Y dw of a picture that is thrown into a pyramid of these half sizes at distance 1.
    fn flux_of_picture(&self, texture: &Texture, half: Vec2) -> f64 {
        let Texture::Bitmap(bitmap) = texture else { return 0.0 };
        let (w, h) = (bitmap.texels.width(), bitmap.texels.height());
        let cell = 4.0 * f64::from(half.x * half.y) / (w * h) as f64;
        let mut sum = 0.0;
        for i in 0..w * h {
            let uv = Vec2::new((i % w) as f32 + 0.5, (i / w) as f32 + 0.5) / Vec2::new(w as f32, h as f32);
            let cos = 1.0 / ((Vec2::ONE - 2.0 * uv) * half).extend(1.0).length();
            sum += f64::from(bitmap.texels.texel(i % w, i / w).luminance() * cos * cos * cos) * cell;
        }
        sum
    }

    /// Two parameters of which one may be given.
    fn one_of(&mut self, params: &Params<'a>, a: &str, b: &str) {
        if params.has(a) && params.has(b) {
            let text = format!("both `{a}` and `{b}` of `{}` are given: they say the same thing", params.node.model.value);
            self.diagnostics.error(params.span_of(b), text);
        }
    }

    /// Refuses a picture that looks at the surface which it lies on, for there is none.
    fn needs_no_surface(&mut self, params: &Params<'a>, name: &str, slot: Option<&ColorSlot>) {
        if slot.is_some_and(|slot| self.looks_at_surfaces(slot)) {
            let text = format!("`{name}` of `{}` cannot be a mesh attribute: there is no mesh", params.node.model.value);
            self.diagnostics.error(params.span_of(name), text);
        }
    }

    fn looks_at_surfaces(&self, slot: &ColorSlot) -> bool {
        let ColorSlot::Texture(id) = slot else { return false };
        match &self.textures[id.index()] {
            Texture::MeshAttribute(_) => true,
            Texture::Mapped(_) | Texture::DirectionMix(_) | Texture::Noise(_) | Texture::Marble(_) => true,
            Texture::Checkerboard(board) => board.color.iter().any(|c| self.looks_at_surfaces(c)),
            _ => false,
        }
    }
}
