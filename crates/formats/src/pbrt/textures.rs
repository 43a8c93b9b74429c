//! Textures → étendue's texture nodes.
//!
//! | pbrt | here |
//! | --- | --- |
//! | `imagemap` | `bitmap`, within `mapped` where it is not laid on by (u, v), within `adjusted` by `scale` and `invert` |
//! | `constant`, `scale`, `mix`, `directionmix` | `constant`, `product`, `mix`, `directionmix` |
//! | `bilerp`, `checkerboard`, `dots` | the same |
//! | `fbm`, `wrinkled`, `windy`, `marble` | the same |
//! | `ptex` | refused |
//!
//! A `float` picture is the mean of its colour's channels, or its alpha where that is not 1 everywhere.
//! A picture's (0, 0) is its lower left corner in pbrt, its upper left one here. Filtering by footprint (`trilinear`, `ewa`) is what many
//! samples a pixel do; a single look-up is bilinear.

use super::spectra::Role;
use super::tokens::Tokens;
use super::values::List;
use super::{Named, Reader, param};
use etendue_description::{Kind, NodeId, Param, SourceId, Span, Value};
use etendue_numerics::Transform;
use glam::{DMat4, DVec3};

const TEXTURES: [&str; 13] = [
    "bilerp",
    "checkerboard",
    "constant",
    "directionmix",
    "dots",
    "fbm",
    "imagemap",
    "marble",
    "mix",
    "scale",
    "windy",
    "wrinkled",
    "uv",
];

/// v counted from the picture's lower edge.
pub(super) fn upright() -> Transform {
    to_uv([1.0, 1.0], [0.0, 0.0], true)
}

/// (s u + d), with v turned round where a picture is looked up.
fn to_uv(scale: [f64; 2], shift: [f64; 2], picture: bool) -> Transform {
    let m = DMat4::from_translation(DVec3::new(shift[0], shift[1], 0.0)) * DMat4::from_scale(DVec3::new(scale[0], scale[1], 1.0));
    let turn = DMat4::from_translation(DVec3::Y) * DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0));
    Transform::new(if picture { turn * m } else { m }).unwrap_or_default()
}

impl Reader<'_> {
    pub(super) fn texture(&mut self, t: &mut Tokens, source: SourceId, span: Span) {
        let Some((name, at)) = self.quoted(t, source, span, "the texture's name") else { return };
        let Some((kind, kind_at)) = self.quoted(t, source, span, "the texture's type, \"float\" or \"spectrum\"") else { return };
        let Some((model, place)) = self.quoted(t, source, span, "the texture's model") else { return };
        let Some(entries) = self.entries(t, source) else { return };
        let named = match kind.as_str() {
            "float" => Named::FloatTexture,
            "spectrum" => Named::SpectrumTexture,
            _ => {
                let error = self.diagnostics.error(kind_at, format!("a texture is of type `float` or `spectrum`, not `{kind}`"));
                match kind.as_str() {
                    "color" => drop(error.help("`color` is the word of pbrt-v3 for `spectrum`")),
                    _ => drop(error.suggest(&kind, ["float", "spectrum"])),
                }
                return;
            }
        };
        let mut list = List::new(format!("texture `{model}`"), place, entries, &self.state.defaults[4]);
        if let Some(node) = self.texture_node(&model, &mut list, named == Named::FloatTexture) {
            self.define(named, name, at, node);
        } else {
            // Told already; what refers to it is not told again.
            let grey = self.node(Kind::Texture, "constant", at, vec![param("value", Value::Float(0.5), at)]);
            self.define(named, name, at, grey);
        }
        list.finish(&mut self.diagnostics);
    }

    fn texture_node(&mut self, model: &str, list: &mut List, float: bool) -> Option<NodeId> {
        let span = list.span;
        let part = |reader: &mut Self, list: &mut List, name: &'static str, ours: &str, default: f64| -> Param {
            let given = if float { reader.number(list, name) } else { reader.colour(list, name, Role::Reflectance) };
            match given {
                Some(value) => param(ours, value.value, value.span),
                None => param(ours, Value::Float(default), span),
            }
        };
        let (model, params) = match model {
            "constant" => ("constant", vec![part(self, list, "value", "value", 1.0)]),
            "scale" => {
                let tex = part(self, list, "tex", "a", 1.0);
                let scale = self.number(list, "scale").map_or(Value::Float(1.0), |v| v.value);
                ("product", vec![tex, param("b", scale, list.span_of("scale"))])
            }
            "mix" => {
                let (a, b) = (part(self, list, "tex1", "a", 0.0), part(self, list, "tex2", "b", 1.0));
                let amount = self.number(list, "amount").map_or(Value::Float(0.5), |v| v.value);
                ("mix", vec![a, b, param("amount", amount, list.span_of("amount"))])
            }
            "directionmix" => {
                let (a, b) = (part(self, list, "tex1", "a", 0.0), part(self, list, "tex2", "b", 1.0));
                let d = list.point(&mut self.diagnostics, "dir").unwrap_or(DVec3::Y);
                // The direction is told in the texture's coordinates.
                let d = self.state.ctm[0].transform_vector3(d);
                ("directionmix", vec![a, b, param("direction", Value::Vector(d), list.span_of("dir"))])
            }
            "bilerp" => {
                let corners = [("v00", 0.0), ("v01", 1.0), ("v10", 0.0), ("v11", 1.0)];
                let mut params: Vec<Param> = corners.iter().map(|(name, x)| part(self, list, name, name, *x)).collect();
                params.extend(self.mapping(list, 1.0, false));
                ("bilerp", params)
            }
            "checkerboard" => {
                let dimension = list.integer(&mut self.diagnostics, "dimension", 2, 2..=3);
                let mut params = vec![part(self, list, "tex1", "color0", 1.0), part(self, list, "tex2", "color1", 0.0)];
                // A period of ours holds two squares.
                params.extend(if dimension == 3 { self.solid(list, 0.5) } else { self.mapping(list, 0.5, false) });
                ("checkerboard", params)
            }
            "dots" => {
                let mut params = vec![part(self, list, "inside", "inside", 1.0), part(self, list, "outside", "outside", 0.0)];
                params.extend(self.mapping(list, 1.0, false));
                ("dots", params)
            }
            "fbm" | "wrinkled" | "marble" | "windy" => {
                let d = &mut self.diagnostics;
                let mut params = Vec::new();
                if model != "windy" {
                    params.push(param("octaves", Value::Integer(list.integer(d, "octaves", 8, 1..=64)), list.span_of("octaves")));
                    params.push(param("roughness", Value::Float(list.float(d, "roughness", 0.5)), list.span_of("roughness")));
                }
                if model == "marble" {
                    params.push(param("scale", Value::Float(list.float(d, "scale", 1.0)), list.span_of("scale")));
                    params.push(param("variation", Value::Float(list.float(d, "variation", 0.2)), list.span_of("variation")));
                }
                params.extend(self.solid(list, 1.0));
                let model = ["fbm", "wrinkled", "marble", "windy"].into_iter().find(|m| *m == model)?;
                (model, params)
            }
            "imagemap" => return self.image_map(list, float),
            _ => {
                let refused = [("ptex", "textures per face cannot be rendered; unwrap the mesh and use `imagemap`")];
                self.unknown_model(list, "texture", model, &TEXTURES[..12], &refused);
                list.entries.clear();
                return None;
            }
        };
        Some(self.node(Kind::Texture, model, span, params))
    }

    fn image_map(&mut self, list: &mut List, float: bool) -> Option<NodeId> {
        let span = list.span;
        let mut params = Vec::new();
        let wrap = list.choice(&mut self.diagnostics, "wrap", &["repeat", "black", "clamp", "octahedralsphere"]);
        if wrap == "octahedralsphere" {
            self.diagnostics
                .error(list.span_of("wrap"), "`octahedralsphere` is for lights: an `imagemap` repeats, clamps or is black");
        }
        params.push(param("wrap_mode", Value::String(wrap.to_owned()), list.span_of("wrap")));
        let filter = list.choice(&mut self.diagnostics, "filter", &["bilinear", "point", "trilinear", "ewa", "EWA"]);
        if filter == "point" {
            params.push(param("filter_type", Value::String("nearest".to_owned()), list.span_of("filter")));
        }
        list.ignore(&["maxanisotropy"]);
        if let Some((encoding, at)) = list.text_opt(&mut self.diagnostics, "encoding") {
            let mut words = encoding.split_ascii_whitespace();
            match (words.next().map(str::to_lowercase).as_deref(), words.next().map(str::parse::<f64>)) {
                (Some("srgb"), None) => {}
                (Some("linear"), None) => params.push(param("raw", Value::Bool(true), at)),
                (Some("gamma"), Some(Ok(gamma))) if gamma > 0.0 => params.push(param("gamma", Value::Float(gamma), at)),
                _ => {
                    let text = format!("unknown encoding `{encoding}`, expected `sRGB`, `linear` or `gamma` and a number");
                    self.diagnostics.error(at, text);
                }
            }
        }
        let scale = list.float(&mut self.diagnostics, "scale", 1.0);
        let invert = list.bool(&mut self.diagnostics, "invert", false);
        let [uv, mapped] = self.picture_mapping(list);
        params.extend(uv);
        if !list.has("filename") {
            self.diagnostics.error(span, "`imagemap` needs a `filename`");
        }
        let (name, at) = list.text_opt(&mut self.diagnostics, "filename")?;
        let path = self.find(&name, at)?;
        self.keep_bytes(&path);
        params.push(param("filename", Value::Path(path), at));
        if float {
            params.push(param("number", Value::Bool(true), span));
        }
        let mut node = self.node(Kind::Texture, "bitmap", span, params);
        if !mapped.is_empty() {
            let mut params = mapped;
            params.push(param("texture", Value::Node(node), span));
            node = self.node(Kind::Texture, "mapped", span, params);
        }
        if scale != 1.0 || invert {
            let params = vec![
                param("texture", Value::Node(node), span),
                param("scale", Value::Float(scale), list.span_of("scale")),
                param("invert", Value::Bool(invert), list.span_of("invert")),
            ];
            node = self.node(Kind::Texture, "adjusted", span, params);
        }
        Some(node)
    }

    /// How a picture is laid on: parameters of itself, and of `mapped` around it.
    fn picture_mapping(&mut self, list: &mut List) -> [Vec<Param>; 2] {
        let span = list.span;
        let uv = |t: Transform| vec![param("to_uv", Value::Transform(Box::new(t)), span)];
        let params = self.mapping(list, 1.0, true);
        if params.iter().any(|p| p.name.value == "mapping") { [uv(upright()), params] } else { [params, Vec::new()] }
    }

    /// How a texture over two dimensions is laid on; `scale` multiplies both coordinates.
    fn mapping(&mut self, list: &mut List, scale: f64, picture: bool) -> Vec<Param> {
        let d = &mut self.diagnostics;
        let mapping = list.choice(d, "mapping", &["uv", "spherical", "cylindrical", "planar"]);
        let at = list.span_of("mapping");
        let number = |list: &mut List, d: &mut _, name, default| list.float(d, name, default);
        if mapping == "uv" {
            let s = [number(list, d, "uscale", 1.0) * scale, number(list, d, "vscale", 1.0) * scale];
            let shift = [number(list, d, "udelta", 0.0) * scale, number(list, d, "vdelta", 0.0) * scale];
            return vec![param("to_uv", Value::Transform(Box::new(to_uv(s, shift, picture))), at)];
        }
        let mut params = vec![param("mapping", Value::String(mapping.to_owned()), at)];
        if mapping == "planar" {
            let v1 = list.point(d, "v1").unwrap_or(DVec3::X) * scale;
            let v2 = list.point(d, "v2").unwrap_or(DVec3::Y) * scale;
            let shift = DVec3::new(number(list, d, "udelta", 0.0), number(list, d, "vdelta", 0.0), 0.0) * scale;
            params.push(param("v1", Value::Vector(v1), list.span_of("v1")));
            params.push(param("v2", Value::Vector(v2), list.span_of("v2")));
            params.push(param("shift", Value::Vector(shift), at));
        } else if scale != 1.0 {
            params.push(param("repeat", Value::Float(scale), at));
        }
        params.extend(self.world_map(list));
        params
    }

    /// A texture over space.
    fn solid(&mut self, list: &mut List, scale: f64) -> Vec<Param> {
        let at = list.span;
        let mut params = vec![param("mapping", Value::String("solid".to_owned()), at)];
        if scale != 1.0 {
            params.push(param("repeat", Value::Float(scale), at));
        }
        params.extend(self.world_map(list));
        params
    }

    /// From the world into the coordinates of a texture that is made here.
    fn world_map(&mut self, list: &List) -> Option<Param> {
        let to_world = self.still(list.span, "this texture")?;
        Some(param("from_world", Value::Transform(Box::new(to_world.inverse())), list.span))
    }
}
