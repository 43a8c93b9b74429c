//! Texture nodes → [`crate::Texture`], and the pictures that they name.

use super::Compiler;
use super::spectra::{CONSTANT_MODELS, ConstantSpectrum};
use crate::ids::TextureId;
use crate::texture::{Bitmap, Checkerboard, FilterMode, MeshAttribute, Role, Texels, Texture, UvMap, WrapMode};
use etendue_description::{Description, Dialect, Kind, Node, NodeId, Param, Params, Value};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Texture models that are rendered, besides the constant ones.
const MODELS: &[&str] = &["bitmap", "checkerboard", "mesh_attribute"];

/// Models that Mitsuba knows and that are refused here, with what to do instead.
const REFUSED: &[(&str, &str)] = &[("volume", "textures over space cannot be rendered yet; use a `bitmap` over the surface")];

/// A picture that could be read, or why not.
type Loaded = Result<Arc<Texels>, String>;

/// What is read once however often it is named: pictures by path and whether they are raw, constant spectra by node.
#[derive(Debug, Default)]
pub(crate) struct ImageCache {
    /// `None` until the first picture is asked for.
    pictures: Option<BTreeMap<(PathBuf, bool), Loaded>>,
    pub(super) constants: BTreeMap<NodeId, Option<ConstantSpectrum>>,
}

impl ImageCache {
    /// The texels of a picture. The first question reads every picture of the description, in parallel.
    fn texels(&mut self, description: &Description, path: &Path, raw: bool) -> Loaded {
        let pictures = self.pictures.get_or_insert_with(|| {
            let named: BTreeSet<_> = description.nodes.iter().filter_map(picture_of).collect();
            named.into_par_iter().map(|(path, raw)| ((path.to_owned(), raw), load(path, raw))).collect()
        });
        pictures.entry((path.to_owned(), raw)).or_insert_with(|| load(path, raw)).clone()
    }
}

/// The picture that a texture node names, and whether it is raw.
fn picture_of(node: &Node) -> Option<(&Path, bool)> {
    if node.kind != Kind::Texture || node.model.value != "bitmap" {
        return None;
    }
    let value = |name: &str| node.params.iter().find(|p| p.name.value == name).map(|p| &p.value.value);
    match value("filename") {
        Some(Value::Path(path)) => Some((path, matches!(value("raw"), Some(Value::Bool(true))))),
        _ => None,
    }
}

fn load(path: &Path, raw: bool) -> Loaded {
    let image = etendue_image::load(path).map_err(|e| e.to_string())?;
    let channels = image.channels().join(", ");
    let wanted = "expected R, G, B or Y, with or without A";
    Texels::new(image, raw).map(Arc::new).ok_or_else(|| format!("{}: channels {channels}; {wanted}", path.display()))
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
                to_uv: UvMap::from(&params.transform(self.diagnostics, "to_uv")),
                scalar_swaps: self.description.dialect == Dialect::Mitsuba,
            })),
            "mesh_attribute" => self.mesh_attribute(&mut params, role).map(Texture::MeshAttribute),
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
        let wrap = match params.choice(self.diagnostics, "wrap_mode", &["repeat", "mirror", "clamp"]) {
            0 => WrapMode::Repeat,
            1 => WrapMode::Mirror,
            _ => WrapMode::Clamp,
        };
        let raw = params.bool(self.diagnostics, "raw", false);
        let to_uv = UvMap::from(&params.transform(self.diagnostics, "to_uv"));
        // How others store texels; here they are always kept without loss.
        params.ignore(&["accel", "format", "max_anisotropy"]);
        if !params.has("filename") {
            self.diagnostics.error(params.span(), "`bitmap` needs a `filename`");
            return None;
        }
        let path = params.path_opt(self.diagnostics, "filename")?;
        let span = params.span_of("filename");
        match self.images.texels(self.description, path, raw) {
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
