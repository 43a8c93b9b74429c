//! Textures. pbrt's are either numbers or colours; one that is asked for both is written twice.
//!
//! | étendue | pbrt |
//! | --- | --- |
//! | `bitmap`, within `mapped`, `adjusted` | `imagemap`, with its mapping, `scale` and `invert` |
//! | `product`, `mix`, `directionmix`, `bilerp`, `checkerboard`, `dots`, `fbm`, `wrinkled`, `windy`, `marble` | `scale`, and the same |
//! | `mesh_attribute`, and what lies on a surface in another way | its mean |
//!
//! v grows from a picture's lower edge in pbrt, from its upper one here: s v + d becomes (1 - d) - s v.

use super::list::{List, quoted, transform};
use super::{Sort, Writer};
use crate::write::look::{child, flag, float, get, integer, matrix, text, vector};
use crate::write::pictures::{Pixels, baked, mean, of_bitmap};
use etendue_description::{Dialect, Node, NodeId, Value};
use glam::{DMat4, DVec3};
use std::path::Path;

impl Writer<'_, '_> {
    /// The name of a texture, which is written where it is first asked for.
    pub(super) fn texture(&mut self, id: NodeId, number: bool) -> String {
        if let Some(known) = self.textures.get(&(id, number)) {
            return known.clone();
        }
        let mut list = List::default();
        let mut place = DMat4::IDENTITY;
        let model = self.texture_model(id, number, &mut list, &mut place);
        let sort = if number { Sort::Number } else { Sort::Colour };
        let name = self.name(sort, id, "texture");
        self.textures.insert((id, number), name.clone());
        self.texture_directive(&name, number, model, list, place);
        name
    }

    fn texture_directive(&mut self, name: &str, number: bool, model: &str, list: List, place: DMat4) {
        let kind = if number { "float" } else { "spectrum" };
        let lines = list.behind(&format!("Texture {} \"{kind}\" \"{model}\"", quoted(name)));
        let steps = transform(place);
        if steps.is_empty() {
            return lines.iter().for_each(|line| self.line(line));
        }
        self.block("Transform", |this| steps.iter().chain(&lines).for_each(|line| this.line(line)));
    }

    /// A texture of numbers times a factor.
    pub(super) fn scaled_texture(&mut self, id: NodeId, scale: f64) -> String {
        let name = self.texture(id, true);
        if scale == 1.0 {
            return name;
        }
        let mut list = List::default();
        list.texture("tex", &name);
        list.float("scale", scale);
        let name = self.free_name(Sort::Number, Some(format!("{name}-scaled")), "");
        self.texture_directive(&name, true, "scale", list, DMat4::IDENTITY);
        name
    }

    /// A part of a texture, of its own sort.
    fn part(&mut self, list: &mut List, name: &str, node: &Node, ours: &str, default: f64, number: bool) {
        let value = get(node, ours).cloned().unwrap_or(Value::Float(default));
        if number { self.number(list, name, &value) } else { self.colour(list, name, &value) }
    }

    fn texture_model(&mut self, id: NodeId, number: bool, list: &mut List, place: &mut DMat4) -> &'static str {
        let d = self.d;
        let node = d.node(id);
        match node.model.value.as_str() {
            "bitmap" | "mapped" | "adjusted" => {
                if let Some(model) = self.image_map(id, list, place) {
                    return model;
                }
            }
            "product" => {
                self.part(list, "tex", node, "a", 1.0, number);
                self.part(list, "scale", node, "b", 1.0, true);
                return "scale";
            }
            model @ ("mix" | "directionmix") => {
                self.part(list, "tex1", node, "a", 0.0, number);
                self.part(list, "tex2", node, "b", 1.0, number);
                if model == "mix" {
                    self.part(list, "amount", node, "amount", 0.5, true);
                    return "mix";
                }
                list.vector("dir", vector(node, "direction").unwrap_or(DVec3::Y));
                return "directionmix";
            }
            "bilerp" => {
                for (name, default) in [("v00", 0.0), ("v01", 1.0), ("v10", 0.0), ("v11", 1.0)] {
                    self.part(list, name, node, name, default, number);
                }
                self.mapping(id, list, place, 1.0, false);
                return "bilerp";
            }
            "dots" => {
                self.part(list, "inside", node, "inside", 1.0, number);
                self.part(list, "outside", node, "outside", 0.0, number);
                self.mapping(id, list, place, 1.0, false);
                return "dots";
            }
            "checkerboard" => {
                // As a number Mitsuba's has its values the other way round.
                let swap = number && d.dialect == Dialect::Mitsuba;
                let names = if swap { ["tex2", "tex1"] } else { ["tex1", "tex2"] };
                self.part(list, names[0], node, "color0", 0.4, number);
                self.part(list, names[1], node, "color1", 0.2, number);
                if text(node, "mapping") == Some("solid") {
                    list.integer("dimension", 3);
                }
                // A period here holds two squares.
                self.mapping(id, list, place, 0.5, false);
                return "checkerboard";
            }
            model @ ("fbm" | "wrinkled" | "windy" | "marble") => {
                if model != "windy" {
                    list.integer("octaves", integer(node, "octaves").unwrap_or(8));
                    list.float("roughness", float(node, "roughness").unwrap_or(0.5));
                }
                if model == "marble" {
                    list.float("scale", float(node, "scale").unwrap_or(1.0));
                    list.float("variation", float(node, "variation").unwrap_or(0.2));
                }
                self.mapping(id, list, place, 1.0, false);
                return ["fbm", "wrinkled", "windy", "marble"].into_iter().find(|m| *m == model).unwrap_or("fbm");
            }
            _ => {}
        }
        let value = mean(d, &Value::Node(id));
        if number {
            list.float("value", f64::from(value.element_sum() / 3.0));
        } else {
            list.rgb("value", value.as_dvec3().to_array());
        }
        self.approximated(id, "", "its mean: pbrt has no such texture");
        "constant"
    }

    /// `bitmap`, maybe within `mapped`, maybe within `adjusted`.
    fn image_map(&mut self, id: NodeId, list: &mut List, place: &mut DMat4) -> Option<&'static str> {
        let d = self.d;
        let (mut bitmap, mut mapped) = (id, None);
        if d.node(bitmap).model.value == "adjusted" {
            let node = d.node(bitmap);
            if let Some(scale) = float(node, "scale").filter(|s| *s != 1.0) {
                list.float("scale", scale);
            }
            if flag(node, "invert", false) {
                list.bool("invert", true);
            }
            bitmap = child(node, "texture")?;
        }
        if d.node(bitmap).model.value == "mapped" {
            mapped = Some(bitmap);
            bitmap = child(d.node(bitmap), "texture")?;
        }
        let node = d.node(bitmap);
        if node.model.value != "bitmap" {
            return None;
        }
        let file = match get(node, "filename") {
            Some(Value::Path(path)) => self.beside.refer(d, path),
            _ => return None,
        };
        list.string("filename", &file);
        if flag(node, "raw", false) {
            list.string("encoding", "linear");
        } else if let Some(gamma) = float(node, "gamma") {
            list.string("encoding", &format!("gamma {gamma}"));
        }
        if text(node, "filter_type") == Some("nearest") {
            list.string("filter", "point");
        }
        match text(node, "wrap_mode").unwrap_or("repeat") {
            "repeat" => {}
            "mirror" => self.approximated(bitmap, "wrap_mode", "`repeat`: pbrt's pictures are not mirrored"),
            wrap => list.string("wrap", wrap),
        }
        match mapped {
            Some(outer) => self.mapping(outer, list, place, 1.0, true),
            None => self.mapping(bitmap, list, place, 1.0, true),
        }
        Some("imagemap")
    }

    /// How a texture is laid on; `unit` is what pbrt's coordinates are multiplied by here.
    fn mapping(&mut self, id: NodeId, list: &mut List, place: &mut DMat4, unit: f64, picture: bool) {
        let node = self.d.node(id);
        match text(node, "mapping").unwrap_or("uv") {
            "uv" => {
                let m = matrix(node, "to_uv");
                if m.x_axis.y != 0.0 || m.y_axis.x != 0.0 {
                    self.approximated(id, "to_uv", "without its turn: pbrt's pictures are only scaled and moved");
                }
                let (mut s, mut shift) = ([m.x_axis.x / unit, m.y_axis.y / unit], [m.w_axis.x / unit, m.w_axis.y / unit]);
                if picture {
                    (s[1], shift[1]) = (-s[1], 1.0 - shift[1]);
                }
                for (name, x, default) in
                    [("uscale", s[0], 1.0), ("vscale", s[1], 1.0), ("udelta", shift[0], 0.0), ("vdelta", shift[1], 0.0)]
                {
                    if x != default {
                        list.float(name, x);
                    }
                }
                return;
            }
            "solid" => {}
            mapping => {
                list.string("mapping", mapping);
                if mapping == "planar" {
                    list.vector("v1", vector(node, "v1").unwrap_or(DVec3::X) / unit);
                    list.vector("v2", vector(node, "v2").unwrap_or(DVec3::Y) / unit);
                    let shift = vector(node, "shift").unwrap_or(DVec3::ZERO) / unit;
                    list.float("udelta", shift.x);
                    list.float("vdelta", shift.y);
                }
            }
        }
        *place = matrix(node, "from_world").inverse();
    }

    /// A file that holds what a texture shows when v grows from the picture's lower edge over the unit square.
    pub(super) fn upright_picture(&mut self, id: NodeId) -> Option<String> {
        let d = self.d;
        if let Some(path) = of_bitmap(d, id) {
            let m = matrix(d.node(id), "to_uv");
            let turn = DMat4::from_translation(DVec3::Y) * DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0));
            if m == turn {
                return Some(self.beside.refer(d, path));
            }
            if m == DMat4::IDENTITY {
                let pixels = Pixels::of(d, id)?;
                self.approximated(id, "filename", "a copy that is upside down, as pbrt looks at it");
                return Some(self.picture_file(path, &pixels.turned()));
            }
        }
        let pixels = baked(d, id)?;
        self.approximated(id, "", "a picture of it over the unit square");
        Some(self.picture_file(Path::new("texture.exr"), &pixels.turned()))
    }

    /// A new picture, named after another.
    pub(super) fn picture_file(&mut self, like: &Path, pixels: &Pixels) -> String {
        let stem = like.file_stem().map_or("picture".into(), |s| s.to_string_lossy().into_owned());
        self.beside.add(&format!("{stem}.exr"), pixels.exr())
    }
}
