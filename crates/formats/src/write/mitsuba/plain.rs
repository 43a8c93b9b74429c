//! Mitsuba's own words in the place of étendue's, node by node. Every change of what is rendered is noted.
//!
//! | étendue | Mitsuba |
//! | --- | --- |
//! | `trianglemesh` | `ply` |
//! | meshes of pbrt without vertex normals | `face_normals`, turned round where the map mirrors space |
//! | `path` of pbrt, where passing an interface is no edge | `volpath` |
//! | `path-nee`, `random-walk`, `bidirectional`, `metropolis`, `photon-map` | `path` or `volpath`: the same light, found in another way |
//! | `spherical` | `perspective` |
//! | black bodies with a scale | their spectrum at every 5 nm |
//! | textures made of others | pictures of the unit square; where they lie in space, their mean |

use super::super::beside::Beside;
use super::super::constants::folded;
use super::super::look::{children, flag, float, get, is_textured, matrix, nodes_in, param, remove, rename, set, text};
use super::super::pictures::{Pixels, baked, mean, of_bitmap};
use super::super::{Notes, uses};
use etendue_description::{Description, Dialect, Kind, Node, NodeId, Spanned, SpectrumValue, Value};
use etendue_numerics::Transform;
use etendue_numerics::spectrum::cie;
use glam::{DMat3, DMat4, DVec3, Vec3};
use std::collections::BTreeSet;

/// How a picture becomes numbers; one that is made anew holds them as they are.
const DECODED: [&str; 3] = ["raw", "gamma", "number"];

/// What a description is while its words change.
pub(super) struct Plain<'a, 'b> {
    pub d: &'a mut Description,
    /// As it was.
    pub read: &'a Description,
    pub beside: &'a mut Beside<'b>,
    pub notes: &'a mut Notes,
}

/// Changes a description's words; with `own`, only those that mean something else in a Mitsuba file.
pub(super) fn plain(d: &mut Description, own: bool, beside: &mut Beside, notes: &mut Notes) {
    let read = d.clone();
    let reachable = uses::reachable(&read);
    let mut plain = Plain { d, read: &read, beside, notes };
    if read.dialect == Dialect::Pbrt {
        plain.swap_checkerboards();
    }
    for &id in &reachable {
        match read.node(id).kind {
            Kind::Shape => plain.shape(id),
            Kind::Integrator if read.dialect == Dialect::Pbrt && read.node(id).model.value == "path" => plain.model(id, "volpath"),
            Kind::Medium => plain.notes.dropped(&read, id, "", "media are not rendered, and not written"),
            _ => {}
        }
    }
    if own {
        return;
    }
    for &id in &reachable {
        plain.constants(id);
        match read.node(id).kind {
            Kind::Shape => plain.texture_coordinates(id),
            Kind::Bsdf => plain.material(id),
            Kind::Texture => plain.texture(id),
            Kind::Emitter => plain.emitter(id),
            Kind::Integrator => plain.integrator(id),
            Kind::Sensor => plain.sensor(id),
            Kind::Filter => plain.filter(id),
            _ => {}
        }
    }
}

impl Plain<'_, '_> {
    pub fn node(&mut self, id: NodeId) -> &mut Node {
        &mut self.d.nodes[id.0 as usize]
    }

    pub fn model(&mut self, id: NodeId, model: &str) {
        self.node(id).model.value = model.to_owned();
    }

    pub fn approximated(&mut self, id: NodeId, part: &str, how: &str) {
        self.notes.approximated(self.read, id, part, how);
    }

    /// A new node.
    pub fn add(&mut self, like: NodeId, kind: Kind, model: &str, params: &[(&str, Value)]) -> NodeId {
        let span = self.read.node(like).span;
        let params = params.iter().map(|(name, value)| param(name, value.clone(), span)).collect();
        self.d.add(Node { kind, model: Spanned::new(model.to_owned(), span), id: None, params, span })
    }

    fn shape(&mut self, id: NodeId) {
        let media = children(self.d, id, Kind::Medium);
        self.node(id).params.retain(|p| !matches!(p.value.value, Value::Node(child) if media.contains(&child)));
        let Some(Value::Mesh(index)) = get(self.read.node(id), "filename").cloned() else { return };
        let mesh = self.read.assets.meshes[index as usize].clone();
        let model = self.read.node(id).model.value.clone();
        if self.read.dialect == Dialect::Pbrt && mesh.normals.is_empty() && get(self.read.node(id), "face_normals").is_none() {
            // Their front is that of the winding in their own coordinates.
            let flips = DMat3::from_mat4(matrix(self.read.node(id), "to_world")).determinant() < 0.0;
            let flipped = flag(self.read.node(id), "flip_normals", false) ^ flips;
            set(self.node(id), "face_normals", Value::Bool(true));
            remove(self.node(id), &["flip_normals"]);
            if flipped {
                set(self.node(id), "flip_normals", Value::Bool(true));
            }
        }
        let packed = mesh.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
        if model != "trianglemesh" && !packed && Beside::is_on_disk(&mesh.path) {
            set(self.node(id), "filename", Value::Path(mesh.path.clone()));
        } else {
            self.model(id, "ply");
            remove(self.node(id), &["flip_tex_coords", "shape_index"]);
        }
    }

    /// pbrt lays textures on spheres and disks in another way.
    fn texture_coordinates(&mut self, id: NodeId) {
        if !remove(self.node(id), &["pbrt_uv"]) || !is_textured(self.read, id) {
            return;
        }
        if self.read.node(id).model.value == "sphere" {
            // v runs from the other pole: the same sphere, mirrored.
            let place = matrix(self.read.node(id), "to_world") * DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
            let flipped = !flag(self.read.node(id), "flip_normals", false);
            set(self.node(id), "to_world", Value::Transform(Box::new(Transform::new(place).unwrap_or_default())));
            set(self.node(id), "flip_normals", Value::Bool(flipped));
        } else {
            self.approximated(id, "", "textures lie on it by radius and angle, in Mitsuba's order");
        }
    }

    fn integrator(&mut self, id: NodeId) {
        let model = self.read.node(id).model.value.as_str();
        let how = match model {
            "path-nee" | "random-walk" | "bidirectional" | "metropolis" | "photon-map" => {
                "`volpath`: the same light, found in another way"
            }
            _ => return,
        };
        self.model(id, "volpath");
        self.approximated(id, "", how);
    }

    fn sensor(&mut self, id: NodeId) {
        if self.read.node(id).model.value != "spherical" {
            return;
        }
        self.model(id, "perspective");
        remove(self.node(id), &["mapping"]);
        set(self.node(id), "fov", Value::Float(90.0));
        self.approximated(id, "", "`perspective` of 90 degrees: Mitsuba has no camera that sees all around");
    }

    fn filter(&mut self, id: NodeId) {
        let node = self.read.node(id);
        if node.model.value == "box" && float(node, "radius").is_some_and(|r| r != 0.5) {
            self.approximated(id, "radius", "a pixel wide: Mitsuba's box has one width");
        }
        if node.model.value == "box" {
            remove(self.node(id), &["radius"]);
        }
    }

    /// Constants that Mitsuba has no words for, in the parameters of a node.
    fn constants(&mut self, id: NodeId) {
        for i in 0..self.d.node(id).params.len() {
            let name = self.d.node(id).params[i].name.value.clone();
            let new = match &self.d.node(id).params[i].value.value {
                Value::Node(child) if self.read.nodes.get(child.0 as usize).is_some_and(|n| n.model.value == "constant") => {
                    folded(self.read, &Value::Node(*child))
                }
                Value::Spectrum(SpectrumValue::Blackbody { kelvin, scale }) if *scale != 1.0 => {
                    let nm = (0..95).map(|i| cie::LAMBDA_MIN + 5.0 * f64::from(i));
                    let pairs = nm.map(|nm| (nm, cie::blackbody(nm, *kelvin) * scale)).collect();
                    self.approximated(id, &name, "the spectrum of a black body at every 5 nm: Mitsuba's has no `scale`");
                    Value::Spectrum(SpectrumValue::Samples(pairs))
                }
                _ => continue,
            };
            self.node(id).params[i].value.value = new;
        }
    }

    fn texture(&mut self, id: NodeId) {
        let node = self.read.node(id).clone();
        match node.model.value.as_str() {
            "bitmap" => {
                let [number, gamma] = ["number", "gamma"].map(|name| remove(self.node(id), &[name]));
                if gamma || number {
                    self.decode(id, gamma);
                }
                if text(&node, "wrap_mode") == Some("black") {
                    set(self.node(id), "wrap_mode", Value::String("clamp".to_owned()));
                    self.approximated(id, "wrap_mode", "`clamp`: Mitsuba's pictures are not black outside");
                }
            }
            "adjusted" | "product" | "mix" | "bilerp" | "directionmix" | "dots" | "mapped" | "fbm" | "wrinkled" | "windy"
            | "marble" => {
                self.bake(id);
            }
            "checkerboard" if text(&node, "mapping").is_some_and(|m| m != "uv") => {
                remove(self.node(id), &["mapping", "from_world", "repeat", "v1", "v2", "shift"]);
                self.approximated(id, "mapping", "laid on by (u, v): Mitsuba has no other mapping");
            }
            _ => {}
        }
    }

    /// A picture with an exponent of its own, or one whose alpha is asked for, as a picture of light.
    fn decode(&mut self, id: NodeId, gamma: bool) {
        let Some(pixels) = Pixels::of(self.read, id) else { return };
        let plain = of_bitmap(self.read, id).and_then(|path| Pixels::read(self.read, path));
        let raw = flag(self.read.node(id), "raw", false);
        if gamma || (!raw && plain.is_some_and(|plain| plain.texels != pixels.texels)) {
            let mut like = self.read.node(id).clone();
            remove(&mut like, &DECODED);
            self.become_picture(id, pixels, like);
            self.approximated(id, "filename", "a picture of its own, of the numbers that it is read as");
        }
    }

    /// A texture as a picture, or as its mean.
    fn bake(&mut self, id: NodeId) {
        let node = self.read.node(id).clone();
        if let Some((inner, pixels)) = adjusted_picture(self.read, id) {
            // The picture keeps its own way of being laid on.
            let mut bitmap = self.read.node(inner).clone();
            remove(&mut bitmap, &DECODED);
            self.become_picture(id, pixels, bitmap);
            self.approximated(id, "", "a picture of its own, with scale and inversion worked in");
        } else if let Some(pixels) = baked(self.read, id) {
            self.become_picture(id, pixels, Node { params: Vec::new(), ..node });
            self.approximated(id, "", "a picture of it over the unit square");
        } else {
            let rgb = mean(self.read, &Value::Node(id)).as_dvec3().to_array();
            self.model(id, "rawconstant");
            let span = node.span;
            self.node(id).params = vec![param("value", Value::Rgb(rgb), span)];
            self.approximated(id, "", "its mean colour: Mitsuba has no such texture");
        }
    }

    /// Makes a texture a `bitmap` of these pixels, otherwise like `like`.
    pub fn become_picture(&mut self, id: NodeId, pixels: Pixels, like: Node) {
        let name = self.read.node(id).id.as_ref().map_or_else(|| format!("texture-{}", id.0), |n| file_name(&n.value));
        let file = self.beside.add(&format!("{name}.exr"), pixels.exr());
        let node = self.node(id);
        node.model.value = "bitmap".to_owned();
        node.params = like.params;
        set(node, "filename", Value::String(file));
    }

    /// A new picture from each texel of what a parameter holds, for what Mitsuba does not do to textures by itself.
    pub fn mapped(&mut self, owner: NodeId, value: &Value, f: impl Fn(Vec3) -> Vec3) -> Option<NodeId> {
        let Value::Node(texture) = value else { return None };
        let (pixels, like) = match of_bitmap(self.read, *texture) {
            Some(_) => (Pixels::of(self.read, *texture)?, self.read.node(*texture).clone()),
            None => (baked(self.read, *texture)?, Node { params: Vec::new(), ..self.read.node(*texture).clone() }),
        };
        let new = self.add(owner, Kind::Texture, "bitmap", &[]);
        let file = self.beside.add(&format!("texture-{}.exr", new.0), pixels.map(f).exr());
        self.node(new).params = like.params;
        remove(self.node(new), &DECODED);
        set(self.node(new), "filename", Value::String(file));
        Some(new)
    }

    /// Where a number is asked for, Mitsuba takes the two values of a checkerboard the other way round.
    fn swap_checkerboards(&mut self) {
        let (numbers, colours) = uses::textures(self.read);
        let boards: BTreeSet<NodeId> = numbers.into_iter().filter(|id| self.read.node(*id).model.value == "checkerboard").collect();
        for id in boards {
            if colours.contains(&id) {
                self.approximated(id, "", "its values are swapped where it is a number and not a colour");
                continue;
            }
            let node = self.node(id);
            rename(node, "color0", "first");
            rename(node, "color1", "color0");
            rename(node, "first", "color1");
        }
    }
}

/// The picture within `adjusted`, with scale and inversion worked in.
fn adjusted_picture(d: &Description, id: NodeId) -> Option<(NodeId, Pixels)> {
    let node = d.node(id);
    let inner = nodes_in(node).next().filter(|_| node.model.value == "adjusted")?;
    let (scale, invert) = (float(node, "scale").unwrap_or(1.0) as f32, flag(node, "invert", false));
    let adjust = |t: Vec3| if invert { (1.0 - t * scale).max(Vec3::ZERO) } else { (t * scale).max(Vec3::ZERO) };
    Some((inner, Pixels::of(d, inner)?.map(adjust)))
}

/// An id as the name of a file.
fn file_name(id: &str) -> String {
    id.chars().map(|c| if c.is_alphanumeric() || "-_ .".contains(c) { c } else { '_' }).collect()
}
