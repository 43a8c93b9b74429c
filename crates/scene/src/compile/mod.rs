//! Description → scene: every node is asked for its parameters once, every mistake is told at its place, and what
//! comes out holds no names.

mod emitters;
mod materials;
mod sensors;
mod settings;
mod shapes;
mod spectra;
mod textures;

use crate::emitter::{Emitter, Lights};
use crate::ids::{MaterialId, SurfaceId, TextureId};
use crate::material::Material;
use crate::scene::Scene;
use crate::settings::{Integrator, View};
use crate::shape::{Geometry, Shape, Surfaces};
use crate::texture::{Role, Texture};
use etendue_accel::{Accel, BuildError, BuildOptions, Builder, TriangleMesh};
use etendue_description::{Description, Diagnostics, Kind, NodeId, Params, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// What the caller changes about the scene before it is compiled.
#[derive(Clone, Debug, Default)]
pub struct CompileOptions {
    /// Film size in place of the file's, pixels.
    pub size: Option<[u32; 2]>,
    /// Film width in place of the file's, pixels; the height follows in proportion unless it is given too.
    pub width: Option<u32>,
    /// Film height in place of the file's, pixels.
    pub height: Option<u32>,
    /// Whether walks carry wavelengths instead of linear Rec.709.
    pub spectral: bool,
}

impl CompileOptions {
    /// The film's size, given the file's.
    pub(crate) fn film_size(&self, [w, h]: [u32; 2]) -> [u32; 2] {
        let in_proportion = |n: u32, a: u32, b: u32| (f64::from(n) * f64::from(a) / f64::from(b.max(1))).round().max(1.0) as u32;
        match (self.size, self.width, self.height) {
            (Some(size), ..) => size,
            (_, Some(w), Some(h)) => [w, h],
            (_, Some(width), None) => [width, in_proportion(width, h, w)],
            (_, None, Some(height)) => [in_proportion(height, w, h), height],
            _ => [w, h],
        }
    }
}

/// The scene that `description` describes, or `None` where `diagnostics` holds errors.
pub fn compile(description: &Description, options: &CompileOptions, diagnostics: &mut Diagnostics) -> Option<Scene> {
    let mut c = Compiler::new(description, options, diagnostics);
    // An emitter that shapes refer to by its id shines from them, not by itself.
    let values = description.nodes.iter().filter(|n| n.kind == Kind::Shape).flat_map(|n| &n.params).map(|p| &p.value.value);
    let of_shapes: BTreeSet<NodeId> = values.filter_map(|v| if let Value::Node(id) = v { Some(*id) } else { None }).collect();
    for &id in &description.top {
        match description.node(id).kind {
            Kind::Integrator => c.integrator(id),
            Kind::Sensor => c.sensor(id),
            Kind::Bsdf => drop(c.material(id)),
            Kind::Texture => drop(c.texture(id, Role::Reflectance)),
            Kind::Shape => c.shape(id),
            Kind::Emitter if of_shapes.contains(&id) => {}
            Kind::Emitter => c.emitter(id, None),
            other => c.refuse_kind(id, other),
        }
    }
    c.finish()
}

/// The scene in the making. Each noun's part of the compiler is in the file of its name.
pub(crate) struct Compiler<'a> {
    pub(crate) description: &'a Description,
    pub(crate) options: &'a CompileOptions,
    pub(crate) diagnostics: &'a mut Diagnostics,
    /// Compiled nodes, so that shared ones are compiled once; `None` marks one that failed or is being compiled.
    pub(crate) texture_of: BTreeMap<(NodeId, Role), Option<TextureId>>,
    pub(crate) material_of: BTreeMap<NodeId, Option<MaterialId>>,
    pub(crate) images: textures::ImageCache,
    pub(crate) surfaces: Surfaces,
    pub(crate) materials: Vec<Material>,
    pub(crate) textures: Vec<Texture>,
    pub(crate) emitters: Vec<Emitter>,
    pub(crate) views: Vec<View>,
    pub(crate) integrator: Option<Integrator>,
    pub(crate) shapes: shapes::ShapeState,
}

impl<'a> Compiler<'a> {
    fn new(description: &'a Description, options: &'a CompileOptions, diagnostics: &'a mut Diagnostics) -> Self {
        Self {
            description,
            options,
            diagnostics,
            texture_of: BTreeMap::new(),
            material_of: BTreeMap::new(),
            images: textures::ImageCache::default(),
            surfaces: Surfaces::default(),
            materials: Vec::new(),
            textures: Vec::new(),
            emitters: Vec::new(),
            views: Vec::new(),
            integrator: None,
            shapes: shapes::ShapeState::default(),
        }
    }

    /// Trees over the surfaces, and the light sampler over the emitters; `None` where anything was wrong before.
    fn finish(self) -> Option<Scene> {
        if self.views.is_empty() && !self.diagnostics.has_errors() {
            let text = "the scene has no sensor: it is shown by one of étendue's own";
            self.diagnostics.warning(None, text).help("add a `sensor` to the scene");
        }
        if self.diagnostics.has_errors() {
            return None;
        }
        let accel = match self.build() {
            Ok(accel) => accel,
            Err(error) => {
                self.diagnostics.error(None, format!("the scene is too large: {error}"));
                return None;
            }
        };
        let triangles = self.surfaces.iter().filter_map(|(_, s)| s.shape.mesh()).map(|m| m.indices.len() as u64).sum();
        let has_transparent = self.surfaces.iter().any(|(_, s)| self.materials[s.material.index()].may_be_transparent());
        let groups: Vec<Arc<[SurfaceId]>> = self.shapes.groups.iter().map(|g| g.surfaces.as_slice().into()).collect();
        let mut scene = Scene {
            bounds: accel.bounds(),
            accel,
            surfaces: self.surfaces,
            instances: self.shapes.instances.iter().map(|i| i.to_world).collect(),
            instance_surfaces: self.shapes.instances.iter().map(|i| groups[i.group].clone()).collect(),
            materials: self.materials,
            textures: self.textures,
            emitters: self.emitters,
            lights: Lights::default(),
            views: self.views,
            integrator: self.integrator.unwrap_or_default(),
            has_transparent,
            triangles,
            spectral: self.options.spectral,
        };
        if scene.views.is_empty() {
            scene.views.push(View::looking_at(&scene.bounds, self.options.film_size([768, 576])));
        }
        scene.lights = Lights::new(&scene);
        Some(scene)
    }

    /// One tree for each group that an instance shows, and one over the world.
    fn build(&self) -> Result<Accel, BuildError> {
        let options = BuildOptions::default();
        let mut world = Builder::new();
        let mut trees = BTreeMap::new();
        for (i, instance) in self.shapes.instances.iter().enumerate() {
            let tree = match trees.get(&instance.group) {
                Some(tree) => *tree,
                None => {
                    let mut builder = Builder::new();
                    for id in &self.shapes.groups[instance.group].surfaces {
                        add(&mut builder, *id, &self.surfaces.get(*id).shape);
                    }
                    let tree = world.add_tree(Arc::new(builder.build(&options)?));
                    trees.insert(instance.group, tree);
                    tree
                }
            };
            world.add_instance(tree, &instance.to_world, i as u32);
        }
        for (id, surface) in self.surfaces.iter().filter(|(_, s)| s.in_world) {
            add(&mut world, id, &surface.shape);
        }
        world.build(&options)
    }

    /// A node that stands where its kind has no place.
    fn refuse_kind(&mut self, id: NodeId, kind: Kind) {
        let node = self.description.node(id);
        let place = match kind {
            Kind::Film => "a film belongs into a sensor",
            Kind::Filter => "a reconstruction filter belongs into a film",
            Kind::Sampler => "a sampler belongs into a sensor",
            Kind::Medium | Kind::Phase | Kind::Volume => return self.refuse_medium(node.model.span),
            _ => "it has no place in the scene itself",
        };
        self.diagnostics.error(node.model.span, format!("{} `{}`: {place}", kind.name(), node.model.value));
    }

    /// A model that is not among the `known` ones: one of those that étendue `refused` with a reason, or a misspelt one.
    pub(crate) fn refuse_model(&mut self, params: &Params, known: &[&str], refused: &[(&str, &str)]) {
        let (kind, model) = (params.node.kind.name(), params.node.model.value.as_str());
        if let Some((_, reason)) = refused.iter().find(|(name, _)| *name == model) {
            self.diagnostics.error(params.span(), format!("{kind} `{model}`: {reason}"));
            return;
        }
        let error = self.diagnostics.error(params.span(), format!("unknown {kind} `{model}`"));
        let names = known.iter().chain(refused.iter().map(|(name, _)| name)).copied();
        error.suggest(model, names).help(format!("known: {}", known.join(", ")));
    }
}

/// Puts a shape into a tree under the number of its surface.
fn add<'a>(builder: &mut Builder<'a>, id: SurfaceId, shape: &'a Shape) {
    match shape.mesh() {
        Some(mesh) => builder.add_mesh(TriangleMesh { positions: &mesh.positions, indices: &mesh.indices, geometry: id.0 }),
        None => builder.add_custom(id.0, shape.bounds()),
    };
}
