//! Texture nodes → [`crate::Texture`], and the pictures that they name.

use super::Compiler;
use super::spectra::{CONSTANT_MODELS, ConstantSpectrum};
use crate::ids::TextureId;
use crate::texture::{
    Adjusted, Bilerp, Bitmap, Chart, Checkerboard, DirectionMix, Dots, FilterMode, Mapped, Mapping, Marble, MeshAttribute, Mix,
    Noise, Product, Role, Space, Texels, Texture, Turbulence, UvMap, WrapMode,
};
use etendue_description::{Description, Dialect, Kind, Node, NodeId, Param, Params, Value};
use etendue_image::{Depth, Encoding, Image, Transfer};
use etendue_numerics::Vec3;
use glam::Affine3A;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Texture models that are rendered, besides the constant ones.
const MODELS: &[&str] = &[
    "bitmap",
    "checkerboard",
    "mesh_attribute",
    "product",
    "mix",
    "directionmix",
    "adjusted",
    "mapped",
    "bilerp",
    "dots",
    "fbm",
    "wrinkled",
    "windy",
    "marble",
];

/// Any number.
const ANY: std::ops::RangeInclusive<f32> = f32::MIN..=f32::MAX;

/// Models that Mitsuba knows and that are refused here, with what to do instead.
const REFUSED: &[(&str, &str)] = &[("volume", "textures over space cannot be rendered yet; use a `bitmap` over the surface")];

/// A picture that could be read, or why not.
type Loaded = Result<Arc<Texels>, String>;

/// How a picture is read: what its numbers stand for where that is not what the file says, and whether a texel is one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Manner {
    raw: bool,
    /// The bits of an exponent.
    gamma: Option<u32>,
    number: bool,
}

/// What is read once however often it is named: pictures by path and manner, constant spectra by node.
#[derive(Debug, Default)]
pub(crate) struct ImageCache {
    /// `None` until the first picture is asked for.
    pictures: Option<BTreeMap<(PathBuf, Manner), Loaded>>,
    pub(super) constants: BTreeMap<NodeId, Option<ConstantSpectrum>>,
}

impl ImageCache {
    /// The texels of a picture. The first question reads every picture of the description, in parallel.
    fn texels(&mut self, description: &Description, path: &Path, manner: Manner) -> Loaded {
        let pictures = self.pictures.get_or_insert_with(|| {
            let named: BTreeSet<_> = description.nodes.iter().filter_map(picture_of).collect();
            named.into_par_iter().map(|(path, manner)| ((path.to_owned(), manner), load(path, manner))).collect()
        });
        pictures.entry((path.to_owned(), manner)).or_insert_with(|| load(path, manner)).clone()
    }
}

/// The picture that a texture node names, and its manner.
fn picture_of(node: &Node) -> Option<(&Path, Manner)> {
    if node.kind != Kind::Texture || node.model.value != "bitmap" {
        return None;
    }
    let value = |name: &str| node.params.iter().find(|p| p.name.value == name).map(|p| &p.value.value);
    match value("filename") {
        Some(Value::Path(path)) => {
            let is = |name| matches!(value(name), Some(Value::Bool(true)));
            let gamma = value("gamma").and_then(|g| if let Value::Float(g) = g { Some((*g as f32).to_bits()) } else { None });
            Some((path, Manner { raw: is("raw"), gamma, number: is("number") }))
        }
        _ => None,
    }
}

fn load(path: &Path, manner: Manner) -> Loaded {
    let image = etendue_image::load(path).map_err(|e| e.to_string())?;
    let channels = image.channels().join(", ");
    let wanted = "expected R, G, B or Y, with or without A";
    let transfer = match manner.gamma {
        _ if manner.raw => Some(Transfer::Linear),
        // Floating-point numbers are light already.
        Some(bits) if matches!(image.encoding().depth, Depth::Unorm8 | Depth::Unorm16) => {
            Some(Transfer::Gamma(f32::from_bits(bits)))
        }
        _ => None,
    };
    let image = if manner.number { one_number(image, transfer) } else { Some(image) };
    image
        .and_then(|image| Texels::new(image, if manner.number { None } else { transfer }))
        .map(Arc::new)
        .ok_or_else(|| format!("{}: channels {channels}; {wanted}", path.display()))
}

/// A picture where one number is asked for: the mean of the colour's channels, or alpha where that is not 1 everywhere; `transfer` replaces the
/// file's own. `None` where the channels are neither grey nor a colour.
fn one_number(image: Image, transfer: Option<Transfer>) -> Option<Image> {
    let colour: Option<Vec<usize>> = ["R", "G", "B"].iter().map(|name| image.channel(name)).collect();
    let grey = || Some(vec![image.channel("Y").or((image.channel_count() == 1).then_some(0))?]);
    let colour = colour.or_else(grey)?;
    let alpha = image.channel("A").filter(|a| image.pixels().any(|p| p[*a] != 1.0));
    let places = alpha.map_or(colour, |a| vec![a]);
    let transfer = transfer.unwrap_or(image.encoding().transfer);
    let mean = |p: &[f32]| places.iter().map(|i| transfer.decode(p[*i])).sum::<f32>() / places.len() as f32;
    let data = image.pixels().map(mean).collect();
    Some(Image::from_data(image.width(), image.height(), &["Y"], data).ok()?.with_encoding(Encoding::LINEAR))
}

impl<'a> Compiler<'a> {
    /// Compiles a texture node for what it shall stand for; `None` where it cannot be, which has been told.
    pub(crate) fn texture(&mut self, id: NodeId, role: Role) -> Option<TextureId> {
        if let Some(known) = self.texture_of.get(&(id, role)) {
            return *known;
        }
        // A texture that leads back to itself finds this mark.
        self.texture_of.insert((id, role), None);
        // In another role the same mistakes may have been told already.
        let told = std::mem::take(self.diagnostics);
        let compiled = self.new_texture(id, role).map(|texture| {
            self.textures.push(texture);
            TextureId(self.textures.len() as u32 - 1)
        });
        let new = std::mem::replace(self.diagnostics, told);
        self.diagnostics.append_new(new);
        self.texture_of.insert((id, role), compiled);
        compiled
    }

    fn new_texture(&mut self, id: NodeId, role: Role) -> Option<Texture> {
        let mut params = Params::new(self.description, id);
        let texture = match params.node.model.value.as_str() {
            "bitmap" => self.bitmap(&mut params, role).map(Texture::Bitmap),
            "checkerboard" => Some(Texture::Checkerboard(Checkerboard {
                color: [("color0", 0.4), ("color1", 0.2)].map(|(name, default)| self.colour_slot(&mut params, name, default, role)),
                mapping: self.mapping(&mut params),
                scalar_swaps: self.description.dialect == Dialect::Mitsuba,
            })),
            "mesh_attribute" => self.mesh_attribute(&mut params, role).map(Texture::MeshAttribute),
            "product" => Some(Texture::Product(Product {
                a: self.colour_slot(&mut params, "a", 1.0, role),
                b: self.scalar(&mut params, "b", 1.0, ANY),
            })),
            "mix" => Some(Texture::Mix(Mix {
                parts: [("a", 0.0), ("b", 1.0)].map(|(name, default)| self.colour_slot(&mut params, name, default, role)),
                amount: self.scalar(&mut params, "amount", 0.5, 0.0..=1.0),
            })),
            "directionmix" => Some(Texture::DirectionMix(DirectionMix {
                parts: [("a", 0.0), ("b", 1.0)].map(|(name, default)| self.colour_slot(&mut params, name, default, role)),
                direction: self.vector(&mut params, "direction", Vec3::Y).normalize_or(Vec3::Y),
            })),
            "adjusted" => self.inner_texture(&mut params, role).map(|texture| {
                Texture::Adjusted(Adjusted {
                    texture,
                    scale: params.float(self.diagnostics, "scale", 1.0, -1e30..=1e30) as f32,
                    invert: params.bool(self.diagnostics, "invert", false),
                })
            }),
            "mapped" => {
                let mapping = self.mapping(&mut params);
                self.inner_texture(&mut params, role).map(|texture| Texture::Mapped(Mapped { texture, mapping }))
            }
            "bilerp" => Some(Texture::Bilerp(Bilerp {
                corners: [("v00", 0.0), ("v01", 1.0), ("v10", 0.0), ("v11", 1.0)]
                    .map(|(name, default)| self.colour_slot(&mut params, name, default, role)),
                mapping: self.mapping(&mut params),
            })),
            "dots" => Some(Texture::Dots(Dots {
                parts: [("inside", 1.0), ("outside", 0.0)]
                    .map(|(name, default)| self.colour_slot(&mut params, name, default, role)),
                mapping: self.mapping(&mut params),
            })),
            "fbm" => Some(Texture::Noise(self.noise(&mut params, Turbulence::Fbm))),
            "wrinkled" => Some(Texture::Noise(self.noise(&mut params, Turbulence::Wrinkled))),
            "windy" => Some(Texture::Noise(self.noise(&mut params, Turbulence::Windy))),
            "marble" => Some(Texture::Marble(Marble {
                octaves: params.integer(self.diagnostics, "octaves", 8, 1..=64) as u32,
                roughness: params.float(self.diagnostics, "roughness", 0.5, 0.0..=1e3) as f32,
                scale: params.float(self.diagnostics, "scale", 1.0, -1e9..=1e9) as f32,
                variation: params.float(self.diagnostics, "variation", 0.2, -1e9..=1e9) as f32,
                role,
                mapping: self.mapping(&mut params),
            })),
            model if CONSTANT_MODELS.contains(&model) => {
                return self.constant(id).and_then(|c| self.color(&c, role, params.span())).map(Texture::Color);
            }
            model => {
                self.refuse_texture(&params, model);
                return None;
            }
        };
        params.finish(self.diagnostics);
        texture
    }

    /// The texture within another one.
    fn inner_texture(&mut self, params: &mut Params<'a>, role: Role) -> Option<TextureId> {
        let Some(Param { value: inner, .. }) = params.raw("texture") else {
            let text = format!("`{}` needs a `texture`", params.node.model.value);
            self.diagnostics.error(params.span(), text);
            return None;
        };
        match inner.value {
            Value::Node(id) if self.description.node(id).kind == Kind::Texture => self.texture(id, role),
            _ => {
                let text = format!("`texture` of `{}` is a {}", params.node.model.value, inner.value.type_name());
                self.diagnostics.error(inner.span, text);
                None
            }
        }
    }

    fn noise(&mut self, params: &mut Params<'a>, kind: Turbulence) -> Noise {
        Noise {
            kind,
            octaves: params.integer(self.diagnostics, "octaves", 8, 1..=64) as u32,
            roughness: params.float(self.diagnostics, "roughness", 0.5, 0.0..=1e3) as f32,
            mapping: self.mapping(params),
        }
    }

    fn vector(&mut self, params: &mut Params<'a>, name: &'static str, default: Vec3) -> Vec3 {
        params.vector_opt(self.diagnostics, name).map_or(default, |v| v.as_vec3())
    }

    /// Where a texture is looked up: `to_uv`, or `mapping` with its own parameters.
    fn mapping(&mut self, params: &mut Params<'a>) -> Mapping {
        let chart = match params.choice(self.diagnostics, "mapping", &["uv", "spherical", "cylindrical", "planar", "solid"]) {
            0 => return Mapping::Uv(UvMap::from(&params.transform(self.diagnostics, "to_uv"))),
            1 => Chart::Spherical,
            2 => Chart::Cylindrical,
            3 => Chart::Planar,
            _ => Chart::Solid,
        };
        Mapping::Space(Space {
            chart,
            from_world: Affine3A::from_mat4(params.transform(self.diagnostics, "from_world").matrix().as_mat4()),
            repeat: params.float(self.diagnostics, "repeat", 1.0, -1e9..=1e9) as f32,
            axes: [self.vector(params, "v1", Vec3::X), self.vector(params, "v2", Vec3::Y)],
            shift: self.vector(params, "shift", Vec3::ZERO).truncate(),
        })
    }

    fn refuse_texture(&mut self, params: &Params, model: &str) {
        if let Some((_, why)) = REFUSED.iter().find(|(name, _)| *name == model) {
            self.diagnostics.error(params.span(), format!("the texture `{model}` is refused: {why}"));
        } else {
            let known = MODELS.iter().chain(CONSTANT_MODELS).copied();
            self.diagnostics.error(params.span(), format!("unknown texture `{model}`")).suggest(model, known);
        }
    }

    fn bitmap(&mut self, params: &mut Params<'a>, role: Role) -> Option<Bitmap> {
        let filter = match params.choice(self.diagnostics, "filter_type", &["bilinear", "nearest"]) {
            0 => FilterMode::Bilinear,
            _ => FilterMode::Nearest,
        };
        let wrap = match params.choice(self.diagnostics, "wrap_mode", &["repeat", "mirror", "clamp", "black"]) {
            0 => WrapMode::Repeat,
            1 => WrapMode::Mirror,
            2 => WrapMode::Clamp,
            _ => WrapMode::Black,
        };
        let raw = params.bool(self.diagnostics, "raw", false);
        let gamma = params.has("gamma").then(|| params.float(self.diagnostics, "gamma", 1.0, 0.01..=100.0) as f32);
        let number = params.bool(self.diagnostics, "number", false);
        let manner = Manner { raw, gamma: gamma.map(f32::to_bits), number };
        let to_uv = UvMap::from(&params.transform(self.diagnostics, "to_uv"));
        // How others store texels; here they are always kept without loss.
        params.ignore(&["accel", "format", "max_anisotropy"]);
        if !params.has("filename") {
            self.diagnostics.error(params.span(), "`bitmap` needs a `filename`");
            return None;
        }
        let path = params.path_opt(self.diagnostics, "filename")?;
        let span = params.span_of("filename");
        match self.images.texels(self.description, path, manner) {
            Ok(texels) => {
                if texels.mended > 0 {
                    let text = format!("this picture holds values that are not finite ({} of them)", texels.mended);
                    self.diagnostics.warning(span, text).help("they are taken as 0");
                }
                Some(Bitmap { texels, filter, wrap, to_uv, role })
            }
            Err(why) => {
                self.diagnostics.error(span, why);
                None
            }
        }
    }

    fn mesh_attribute(&mut self, params: &mut Params<'a>, role: Role) -> Option<MeshAttribute> {
        let scale = params.float(self.diagnostics, "scale", 1.0, f64::from(f32::MIN)..=f64::from(f32::MAX)) as f32;
        if !params.has("name") {
            self.diagnostics.error(params.span(), "`mesh_attribute` needs a `name`");
        }
        let name = params.string_opt(self.diagnostics, "name")?;
        if !name.starts_with("vertex_") && !name.starts_with("face_") {
            let text = format!("the mesh attribute `{name}` must be named `vertex_…` or `face_…`");
            self.diagnostics.error(params.span_of("name"), text);
            return None;
        }
        Some(MeshAttribute::new(name, scale, role))
    }

    /// Tells which mesh attributes the material and the emitter of a shape ask for that the shape does not have.
    pub(super) fn check_attributes(&mut self, shape: &Params<'a>) {
        let meshes = &self.description.assets.meshes;
        let mesh = shape.node.params.iter().find_map(|p| match p.value.value {
            Value::Mesh(i) => meshes.get(i as usize),
            _ => None,
        });
        let known: Vec<&str> = mesh.map_or(Vec::new(), |m| m.attributes.iter().map(|a| a.name.as_str()).collect());
        let (mut seen, mut open) = (BTreeSet::new(), children_of(shape.node));
        while let Some(id) = open.pop() {
            let node = self.description.node(id);
            if node.kind == Kind::Shape || !seen.insert(id) {
                continue;
            }
            open.extend(children_of(node));
            let name = node.params.iter().find(|p| p.name.value == "name").map(|p| &p.value);
            if let Some((Value::String(name), span)) = name.map(|v| (&v.value, v.span))
                && node.model.value == "mesh_attribute"
                && (name.starts_with("vertex_") || name.starts_with("face_"))
                && !known.contains(&name.as_str())
            {
                let text = format!("this `{}` has no attribute `{name}`", shape.node.model.value);
                let told = self.diagnostics.error(span, text);
                told.suggest(name, known.iter().copied());
                if !known.is_empty() {
                    told.help(format!("it has: {}", known.join(", ")));
                }
            }
        }
    }
}

/// The nodes that a node holds.
fn children_of(node: &Node) -> Vec<NodeId> {
    let child = |p: &Param| if let Value::Node(id) = p.value.value { Some(id) } else { None };
    node.params.iter().filter_map(child).collect()
}
