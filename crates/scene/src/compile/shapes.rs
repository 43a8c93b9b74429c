//! Shape nodes → surfaces, groups and instances.

use super::Compiler;
use crate::ids::SurfaceId;
use crate::shape::{Cylinder, Disk, Mesh, SdfGrid, Shape, Sphere, Surface, load};
use etendue_description::{Dialect, Kind, NodeId, Params, Span, Value};
use etendue_numerics::Transform;
use glam::{DAffine3, DMat3, DVec3};
use std::collections::BTreeMap;

/// What is rendered.
const MODELS: &[&str] = &[
    "cube",
    "cylinder",
    "disk",
    "instance",
    "merge",
    "obj",
    "ply",
    "rectangle",
    "sdfgrid",
    "serialized",
    "shapegroup",
    "sphere",
    "trianglemesh",
];

/// What Mitsuba knows and étendue refuses, with the reason.
const REFUSED: &[(&str, &str)] = &[
    ("blender", "Blender's own memory cannot be read; export the mesh as `ply`"),
    ("bsplinecurve", "curves cannot be rendered yet; convert them to meshes"),
    ("ellipsoids", "clouds of ellipsoids cannot be rendered yet"),
    ("ellipsoidsmesh", "clouds of ellipsoids cannot be rendered yet"),
    ("linearcurve", "curves cannot be rendered yet; convert them to meshes"),
];

/// Shapes of a shape group; each is a surface that stands in the world only through instances.
#[derive(Debug, Default)]
pub(crate) struct Group {
    pub(crate) surfaces: Vec<SurfaceId>,
}

/// An instance: which group, and where.
#[derive(Debug)]
pub(crate) struct Instance {
    pub(crate) group: usize,
    pub(crate) to_world: Transform,
}

/// What shapes remember between nodes.
#[derive(Debug, Default)]
pub(crate) struct ShapeState {
    pub(crate) groups: Vec<Group>,
    pub(crate) instances: Vec<Instance>,
    /// The group of a node, `None` where it failed.
    group_of: BTreeMap<NodeId, Option<usize>>,
    /// Told once for a file.
    medium_refused: bool,
}

impl<'a> Compiler<'a> {
    /// Compiles a shape of the scene itself.
    pub(crate) fn shape(&mut self, id: NodeId) {
        self.shape_in(id, None);
    }

    /// Compiles a shape of the scene, or of a group.
    fn shape_in(&mut self, id: NodeId, group: Option<usize>) {
        let mut params = Params::new(self.description, id);
        let model = params.node.model.value.as_str();
        match model {
            "shapegroup" if group.is_none() => drop(self.group(id)),
            "instance" if group.is_none() => self.instance(params),
            "shapegroup" | "instance" => {
                let text = "instances within a shape group cannot be rendered: one level of instances is all there is";
                self.diagnostics.error(params.span(), text).help("put the nested group's shapes into this group");
            }
            "merge" => {
                for (child, _) in params.children(Kind::Shape) {
                    self.shape_in(child, group);
                }
                params.finish(self.diagnostics);
            }
            _ if MODELS.contains(&model) => self.surface(id, params, group),
            _ => self.refuse_model(&params, MODELS, REFUSED),
        }
    }

    /// A shape with a surface of its own.
    fn surface(&mut self, id: NodeId, mut params: Params<'a>, group: Option<usize>) {
        let shape = self.geometry(&mut params);
        let material = self.shape_material(&mut params);
        params.ignore(&["silhouette_sampling_weight"]);
        self.refuse_media(&mut params);
        let emitters = params.children(Kind::Emitter);

        // Where the geometry failed the emitter is compiled all the same, to hear of its mistakes.
        let surface =
            shape.map(|shape| self.surfaces.push(Surface { shape, material, emitter: None, node: id, in_world: group.is_none() }));
        if let (Some(group), Some(surface)) = (group, surface) {
            self.shapes.groups[group].surfaces.push(surface);
        }
        for (i, (emitter, param)) in emitters.into_iter().enumerate() {
            if group.is_some() {
                let text = "a shape of a shape group cannot emit: emitters cannot be instanced";
                self.diagnostics.error(param.value.span, text).help("take the emitting shape out of the group");
            } else if i > 0 {
                self.diagnostics.error(param.value.span, "a shape has one emitter at the most");
            } else if params.node.model.value == "sdfgrid" {
                self.diagnostics.error(param.value.span, "an `sdfgrid` cannot emit: its area is not known");
            } else if let Some(surface) = surface {
                self.emitter(emitter, Some(surface));
            }
        }
        params.finish(self.diagnostics);
    }

    /// The geometry of a shape node, or `None` where it was refused.
    fn geometry(&mut self, params: &mut Params<'a>) -> Option<Shape> {
        let to_world = self.placement(params)?;
        match params.node.model.value.as_str() {
            "sphere" => self.sphere(params, &to_world),
            "cylinder" => self.cylinder(params, &to_world),
            "disk" => {
                let flip = params.bool(self.diagnostics, "flip_normals", false);
                let disk = Disk::new(&to_world, flip).map(|disk| disk.with_pbrt_uv(self.pbrt_uv(params)));
                self.or_degenerate(params.span_of("to_world"), "disk", disk)
            }
            "rectangle" => self.finished(params, Mesh::rectangle(&to_world)),
            "cube" => self.finished(params, Mesh::cube(&to_world)),
            "sdfgrid" => self.sdf_grid(params, &to_world),
            _ => self.mesh_file(params, &to_world),
        }
    }

    /// `to_world`, affine.
    fn placement(&mut self, params: &mut Params<'a>) -> Option<Transform> {
        let to_world = params.transform(self.diagnostics, "to_world");
        if to_world.is_affine() {
            return Some(to_world);
        }
        let text = "`to_world` of a shape has a perspective part: its last row is not (0, 0, 0, 1)";
        self.diagnostics.error(params.span_of("to_world"), text);
        None
    }

    /// Whether texture coordinates are those of pbrt rather than Mitsuba's.
    fn pbrt_uv(&mut self, params: &mut Params<'a>) -> bool {
        params.bool(self.diagnostics, "pbrt_uv", false)
    }

    fn or_degenerate<S: Into<Shape>>(&mut self, span: Span, what: &str, shape: Option<S>) -> Option<Shape> {
        if shape.is_none() {
            self.diagnostics.error(span, format!("this {what} has no area, or one that is not finite, once it is in its place"));
        }
        shape.map(Into::into)
    }

    fn sphere(&mut self, params: &mut Params<'a>, to_world: &Transform) -> Option<Shape> {
        let center = params.vector_opt(self.diagnostics, "center").unwrap_or(DVec3::ZERO);
        let radius = params.float(self.diagnostics, "radius", 1.0, f64::MIN..=f64::MAX);
        let flip = params.bool(self.diagnostics, "flip_normals", false);
        if radius == 0.0 {
            self.diagnostics.error(params.span_of("radius"), "this sphere's `radius` is 0");
            return None;
        }
        let m = DMat3::from_mat4(to_world.matrix()) * radius;
        let round = (m.transpose() * m - DMat3::from_diagonal(DVec3::splat(m.x_axis.length_squared()))).abs();
        if round.to_cols_array().iter().any(|x| *x > 2e-5 * m.x_axis.length_squared()) {
            let text = "`to_world` stretches or shears this sphere: it is rendered as the sphere whose radius is the length of the map's first column";
            self.diagnostics.warning(params.span_of("to_world"), text).help("for an ellipsoid use a mesh");
        }
        let pbrt_uv = self.pbrt_uv(params);
        let sphere = Sphere::new(to_world.point_f64(center), m, flip).map(|sphere| sphere.with_pbrt_uv(pbrt_uv));
        self.or_degenerate(params.span_of("to_world"), "sphere", sphere)
    }

    fn cylinder(&mut self, params: &mut Params<'a>, to_world: &Transform) -> Option<Shape> {
        let p0 = params.vector_opt(self.diagnostics, "p0").unwrap_or(DVec3::ZERO);
        let p1 = params.vector_opt(self.diagnostics, "p1").unwrap_or(DVec3::Z);
        let radius = params.float(self.diagnostics, "radius", 1.0, f64::MIN..=f64::MAX);
        let flip = params.bool(self.diagnostics, "flip_normals", false);
        let axis = p1 - p0;
        let Some(n) = axis.try_normalize() else {
            self.diagnostics.error(params.span_of("p1"), "`p0` and `p1` of this cylinder are the same point");
            return None;
        };
        if radius == 0.0 {
            self.diagnostics.error(params.span_of("radius"), "this cylinder's `radius` is 0");
            return None;
        }
        let (s, t) = load::tangents(n);
        let object = DAffine3::from_mat3_translation(DMat3::from_cols(s * radius, t * radius, axis), p0);
        let cylinder = Cylinder::new(DAffine3::from_mat4(to_world.matrix()) * object, flip);
        self.or_degenerate(params.span_of("to_world"), "cylinder", cylinder)
    }

    fn sdf_grid(&mut self, params: &mut Params<'a>, to_world: &Transform) -> Option<Shape> {
        let smooth = params.choice(self.diagnostics, "normals", &["smooth", "analytic"]) == 0;
        let param = self.asset_param(params)?;
        let Value::Grid(index) = param else {
            self.diagnostics.error(params.span_of("filename"), "`filename` of an `sdfgrid` is no grid of voxels");
            return None;
        };
        let grid = &self.description.assets.grids[*index as usize];
        let span = params.span_of("filename");
        if grid.channels != 1 {
            let text = format!("{} has {} channels; signed distances are one", grid.path.display(), grid.channels);
            self.diagnostics.error(span, text);
            return None;
        }
        let shape = SdfGrid::new(grid.data.clone(), grid.size, to_world, smooth);
        if shape.is_none() {
            let text = format!("{} holds no surface: nowhere do its distances change sign", grid.path.display());
            self.diagnostics.error(span, text);
        }
        shape.map(Into::into)
    }

    /// `filename`, as the reader left it.
    fn asset_param(&mut self, params: &mut Params<'a>) -> Option<&'a Value> {
        let value = params.raw("filename").map(|p| &p.value.value);
        if value.is_none() {
            let text = format!("`{}` needs a `filename`", params.node.model.value);
            self.diagnostics.error(params.span(), text);
        }
        value
    }

    fn mesh_file(&mut self, params: &mut Params<'a>, to_world: &Transform) -> Option<Shape> {
        // The reader has seen to these.
        params.ignore(&["flip_tex_coords", "shape_index"]);
        // In pbrt, faces without vertex normals are flat.
        let pbrt = self.description.dialect == Dialect::Pbrt;
        let without = |p: &Params| match p.node.params.iter().find(|q| q.name.value == "filename").map(|q| &q.value.value) {
            Some(Value::Mesh(i)) => self.description.assets.meshes[*i as usize].normals.is_empty(),
            _ => false,
        };
        let flat = pbrt && without(params);
        let face_normals = params.bool(self.diagnostics, "face_normals", flat);
        let param = self.asset_param(params)?;
        let Value::Mesh(index) = param else {
            let text = format!("`filename` of `{}` is no mesh", params.node.model.value);
            self.diagnostics.error(params.span_of("filename"), text);
            return None;
        };
        let data = &self.description.assets.meshes[*index as usize];
        if data.indices.is_empty() {
            self.diagnostics.warning(params.span_of("filename"), format!("{} has no triangles", data.path.display()));
        }
        let mut mesh = Mesh::new(data, to_world, face_normals);
        // Its front is that of the winding in its own coordinates.
        mesh.flip_normals = flat && to_world.flips();
        mesh.pbrt_uv = pbrt;
        self.finished(params, mesh)
    }

    /// A mesh in its place: normals turned where asked, places checked.
    fn finished(&mut self, params: &mut Params<'a>, mut mesh: Mesh) -> Option<Shape> {
        mesh.flip_normals ^= params.bool(self.diagnostics, "flip_normals", false);
        if mesh.positions.iter().all(|p| p.is_finite()) {
            return Some(mesh.into());
        }
        let text = "`to_world` carries vertices of this mesh beyond the largest number there is";
        self.diagnostics.error(params.span_of("to_world"), text);
        None
    }

    /// A shape's media are refused.
    fn refuse_media(&mut self, params: &mut Params<'a>) {
        for (_, param) in params.children(Kind::Medium) {
            self.refuse_medium(param.value.span);
        }
    }

    /// A medium is refused, once for a file.
    pub(super) fn refuse_medium(&mut self, span: Span) {
        if std::mem::replace(&mut self.shapes.medium_refused, true) {
            return;
        }
        if self.description.dialect == Dialect::Pbrt {
            let text = "participating media cannot be rendered yet: the scene is rendered as if they were not there";
            self.diagnostics.warning(span, text);
        } else {
            self.diagnostics.error(span, "participating media cannot be rendered yet");
        }
    }

    /// The group of a shape group's node, compiled once.
    fn group(&mut self, id: NodeId) -> Option<usize> {
        if let Some(known) = self.shapes.group_of.get(&id) {
            return *known;
        }
        self.shapes.group_of.insert(id, None);
        let mut params = Params::new(self.description, id);
        let group = self.shapes.groups.len();
        self.shapes.groups.push(Group::default());
        if params.raw("to_world").is_some() {
            let text = "`to_world` of a shape group moves nothing";
            self.diagnostics.warning(params.span_of("to_world"), text).help("put it on the group's shapes, or on its instances");
        }
        for (child, _) in params.children(Kind::Shape) {
            self.shape_in(child, Some(group));
        }
        params.finish(self.diagnostics);
        self.shapes.group_of.insert(id, Some(group));
        Some(group)
    }

    fn instance(&mut self, mut params: Params<'a>) {
        let to_world = self.placement(&mut params);
        let groups = params.children(Kind::Shape);
        match groups[..] {
            [(id, param)] => {
                let model = &self.description.node(id).model.value;
                if model != "shapegroup" {
                    let text = format!("`instance` shows a `shapegroup`, not a `{model}`");
                    self.diagnostics
                        .error(param.value.span, text)
                        .help("wrap the shape in a `shapegroup` with an id and refer to it");
                } else if let (Some(group), Some(to_world)) = (self.group(id), to_world) {
                    self.shapes.instances.push(Instance { group, to_world });
                }
            }
            [] => drop(self.diagnostics.error(params.span(), "`instance` names no `shapegroup`").help("add `<ref id=\"…\"/>`")),
            [_, (_, second), ..] => {
                self.diagnostics.error(second.value.span, "`instance` shows one `shapegroup`, not several");
            }
        }
        params.finish(self.diagnostics);
    }
}
