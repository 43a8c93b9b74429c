//! Shapes, objects and instances.
//!
//! | étendue | pbrt |
//! | --- | --- |
//! | `rectangle`, `cube` | `trianglemesh` |
//! | `sphere`, `cylinder`, `disk` | the same; what is not about the origin is moved there |
//! | `shapegroup`, `instance`, `merge` | `ObjectBegin`, `ObjectInstance`, the shapes one by one |
//! | `mask` around the material | `alpha` |
//! | `unseen` of a light | `alpha` 0 |
//! | `sdfgrid` | dropped |

use super::list::{List, quoted, transform};
use super::meshes::{Geometry, inline};
use super::{Sort, Writer};
use crate::write::look::{children, flag, float, is_textured, matrix, vector};
use etendue_description::{Dialect, Kind, MeshData, NodeId, Value};
use glam::{DMat3, DMat4, DVec3};

impl Writer<'_, '_> {
    pub(super) fn shape(&mut self, id: NodeId) {
        match self.d.node(id).model.value.as_str() {
            "shapegroup" => drop(self.object(id)),
            "instance" => self.instance(id),
            "merge" => children(self.d, id, Kind::Shape).into_iter().for_each(|shape| self.shape(shape)),
            _ => {
                self.prepare(id);
                self.surface(id);
            }
        }
    }

    /// The name of a group, which is written where it is first asked for.
    fn object(&mut self, id: NodeId) -> String {
        if let Some(known) = self.objects.get(&id) {
            return known.clone();
        }
        let name = self.name(Sort::Object, id, "object");
        self.objects.insert(id, name.clone());
        let shapes = self.members(id);
        shapes.iter().for_each(|shape| self.prepare(*shape));
        self.line(&format!("ObjectBegin {}", quoted(&name)));
        self.depth += 1;
        let outside = self.current.clone();
        shapes.iter().for_each(|shape| self.surface(*shape));
        self.current = outside;
        self.depth -= 1;
        self.line("ObjectEnd");
        name
    }

    /// The shapes of a group, those of merged ones one by one.
    fn members(&self, id: NodeId) -> Vec<NodeId> {
        let shapes = children(self.d, id, Kind::Shape).into_iter();
        shapes.flat_map(|s| if self.d.node(s).model.value == "merge" { self.members(s) } else { vec![s] }).collect()
    }

    fn instance(&mut self, id: NodeId) {
        let Some(group) = children(self.d, id, Kind::Shape).first().copied() else { return };
        let name = self.object(group);
        let steps = transform(matrix(self.d.node(id), "to_world"));
        self.block("Attribute", |this| {
            steps.iter().for_each(|step| this.line(step));
            this.line(&format!("ObjectInstance {}", quoted(&name)));
        });
    }

    /// Writes what a shape names, before the shape.
    fn prepare(&mut self, id: NodeId) {
        if let Some(material) = children(self.d, id, Kind::Bsdf).first() {
            let peeled = self.peel(*material);
            self.material(*material);
            if let Some(Err(texture)) = peeled.opacity.map(|o| self.as_number(&o)) {
                self.texture(texture, true);
            }
        } else {
            self.plain_material(if children(self.d, id, Kind::Emitter).is_empty() { 0.5 } else { 0.0 });
        }
    }

    /// A shape with a surface of its own.
    fn surface(&mut self, id: NodeId) {
        let Some(mut geometry) = self.geometry(id) else { return };
        let emitters = children(self.d, id, Kind::Emitter);
        let material = self.shape_material(id, !emitters.is_empty(), &mut geometry.list);
        let light = emitters.first().and_then(|light| self.area_light(*light));
        if light.is_some() {
            self.alpha_of_light(id, emitters[0], &mut geometry.list);
        }
        let steps = transform(geometry.place);
        let simple = steps.is_empty() && !geometry.reverse && light.is_none();
        if simple {
            if self.current.as_ref() != Some(&material) {
                self.line(&format!("NamedMaterial {}", quoted(&material)));
                self.current = Some(material);
            }
            return self.directive("Shape", geometry.model, geometry.list);
        }
        self.block("Attribute", |this| {
            steps.iter().for_each(|step| this.line(step));
            if geometry.reverse {
                this.line("ReverseOrientation");
            }
            if let Some(list) = light {
                this.directive("AreaLightSource", "diffuse", list);
            }
            if this.current.as_ref() != Some(&material) {
                this.line(&format!("NamedMaterial {}", quoted(&material)));
            }
            this.directive("Shape", geometry.model, geometry.list);
        });
    }

    /// The material's name; its holes become the shape's `alpha`.
    fn shape_material(&mut self, id: NodeId, emits: bool, list: &mut List) -> String {
        let Some(material) = children(self.d, id, Kind::Bsdf).first().copied() else {
            return self.plain_material(if emits { 0.0 } else { 0.5 });
        };
        if let Some(opacity) = self.peel(material).opacity {
            self.number(list, "alpha", &opacity);
        }
        self.material(material)
    }

    /// A light that shines unseen has no `alpha`; what shines where it is not there has no like in pbrt.
    fn alpha_of_light(&mut self, shape: NodeId, light: NodeId, list: &mut List) {
        let node = self.d.node(light);
        if flag(node, "unseen", false) {
            list.float("alpha", 0.0);
        } else if !flag(node, "masked", false)
            && children(self.d, shape, Kind::Bsdf).first().is_some_and(|m| self.peel(*m).opacity.is_some())
        {
            self.approximated(light, "", "does not shine where its surface's mask has holes");
        }
    }

    fn geometry(&mut self, id: NodeId) -> Option<Geometry> {
        let node = self.d.node(id);
        let (mut place, mut reverse) = (matrix(node, "to_world"), flag(node, "flip_normals", false));
        let laid_otherwise = self.d.dialect == Dialect::Mitsuba && !flag(node, "pbrt_uv", false) && is_textured(self.d, id);
        let radius = float(node, "radius").unwrap_or(1.0);
        let mut list = List::default();
        let model = match node.model.value.as_str() {
            "rectangle" | "cube" => {
                let is_cube = node.model.value == "cube";
                inline(&mut list, &if is_cube { MeshData::cube() } else { MeshData::rectangle() });
                "trianglemesh"
            }
            "sphere" => {
                list.float("radius", radius.abs());
                place *= DMat4::from_translation(vector(node, "center").unwrap_or(DVec3::ZERO));
                if radius < 0.0 {
                    place *= DMat4::from_scale(DVec3::splat(-1.0));
                }
                if laid_otherwise {
                    // v runs from the other pole.
                    place *= DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
                    reverse ^= true;
                }
                "sphere"
            }
            "cylinder" => {
                let [p0, p1] = [("p0", DVec3::ZERO), ("p1", DVec3::Z)].map(|(name, p)| vector(node, name).unwrap_or(p));
                let axis = p1 - p0;
                let mut ends = [p0.z, p1.z];
                if p0.truncate() != p1.truncate() || p0.truncate() != glam::DVec2::ZERO || axis.z < 0.0 {
                    let z = axis.normalize_or(DVec3::Z);
                    let (x, y) = z.any_orthonormal_pair();
                    place *= DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), p0.extend(1.0));
                    ends = [0.0, axis.length()];
                }
                list.float("radius", radius.abs());
                list.float("zmin", ends[0]);
                list.float("zmax", ends[1]);
                "cylinder"
            }
            "disk" => {
                if DMat3::from_mat4(place).determinant() < 0.0 {
                    // The same disk by a map that keeps handedness, which pbrt would turn the normal by.
                    place *= DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
                }
                if laid_otherwise {
                    self.approximated(id, "", "textures lie on it by angle and radius, in pbrt's order");
                }
                "disk"
            }
            "sdfgrid" => {
                self.dropped(id, "", "pbrt has no shapes of signed distances");
                return None;
            }
            _ => return self.mesh(id),
        };
        Some(Geometry { model, list, place, reverse })
    }

    /// A grey material that no node describes.
    fn plain_material(&mut self, reflectance: f64) -> String {
        let name = if reflectance == 0.0 { "black" } else { "grey" };
        let key = NodeId(u32::MAX - u32::from(reflectance == 0.0));
        if let Some(known) = self.materials.get(&key) {
            return known.clone();
        }
        let name = self.free_name(Sort::Material, Some(name.to_owned()), "");
        self.materials.insert(key, name.clone());
        let mut list = List::default();
        list.string("type", "diffuse");
        self.colour(&mut list, "reflectance", &Value::Float(reflectance));
        self.directive("MakeNamedMaterial", &name, list);
        name
    }
}
