//! Lights.
//!
//! | étendue | pbrt |
//! | --- | --- |
//! | `area` | `diffuse`; textured, with a picture |
//! | `point`, `spot`, `directional`, `constant`, `goniometric` | `point`, `spot`, `distant`, `infinite`, `goniometric` |
//! | `spot` with linear falloff; with a texture | smooth between the same angles; without it |
//! | `envmap` | `infinite` with a square picture |
//! | `projector` | `projection` with a picture times π/cos³θ |
//! | `directionalarea` | dropped |

use super::Writer;
use super::camera::tan_half_fov;
use super::list::{List, transform};
use crate::write::look::{flag, float, get, matrix, text, vector};
use crate::write::pictures::{Pixels, of_bitmap, slant};
use crate::write::surroundings::to_equal_area;
use etendue_description::{NodeId, Value};
use glam::{DMat4, DVec3};
use std::f64::consts::PI;

impl Writer<'_, '_> {
    /// A light that stands alone.
    pub(super) fn light(&mut self, id: NodeId) {
        let node = self.d.node(id);
        let even = |name: &str| get(node, name).cloned().unwrap_or(Value::Float(1.0));
        let mut list = List::default();
        let mut place = matrix(node, "to_world");
        let model = match node.model.value.as_str() {
            "point" => {
                self.emission(&mut list, "I", &even("intensity"), 1.0);
                let at = vector(node, "position").unwrap_or_else(|| place.transform_point3(DVec3::ZERO));
                place = DMat4::from_translation(at);
                "point"
            }
            "spot" => {
                self.emission(&mut list, "I", &even("intensity"), 1.0);
                let cutoff = float(node, "cutoff_angle").unwrap_or(20.0);
                let beam = float(node, "beam_width").unwrap_or(0.75 * cutoff);
                list.float("coneangle", cutoff);
                list.float("conedeltaangle", cutoff - beam);
                if text(node, "falloff") != Some("smooth") {
                    self.approximated(id, "falloff", "smooth between the same two angles");
                }
                if get(node, "texture").is_some() {
                    self.dropped(id, "texture", "pbrt's spots have no picture");
                }
                "spot"
            }
            "directional" => {
                self.emission(&mut list, "L", &even("irradiance"), 1.0);
                let z = vector(node, "direction").unwrap_or_else(|| place.transform_vector3(DVec3::Z));
                let (x, y) = z.normalize_or(DVec3::Z).any_orthonormal_pair();
                place = DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), glam::DVec4::W);
                "distant"
            }
            "constant" => {
                self.emission(&mut list, "L", &even("radiance"), 1.0);
                place = DMat4::IDENTITY;
                "infinite"
            }
            "envmap" => {
                let Some(Value::Path(path)) = get(node, "filename") else { return };
                let file = if text(node, "mapping") == Some("equal_area") {
                    self.beside.refer(self.d, path)
                } else {
                    let Some(polar) = Pixels::read(self.d, path) else { return };
                    self.approximated(id, "filename", "unfolded anew, onto a square");
                    self.picture_file(path, &to_equal_area(&polar))
                };
                list.string("filename", &file);
                self.factors(id, &mut list, "illuminance");
                "infinite"
            }
            "goniometric" => {
                let Some(Value::Path(path)) = get(node, "filename") else { return };
                list.string("filename", &self.beside.refer(self.d, path));
                self.emission(&mut list, "I", &even("intensity"), 1.0);
                self.factors(id, &mut list, "power");
                // y and z change places.
                place *= DMat4::from_cols_array(&[1., 0., 0., 0., 0., 0., 1., 0., 0., 1., 0., 0., 0., 0., 0., 1.]);
                "goniometric"
            }
            "projector" => {
                if self.projection(id, &mut list).is_none() {
                    return self.dropped(id, "", "a projection of pbrt throws a picture");
                }
                place *= DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
                "projection"
            }
            _ => return self.dropped(id, "", "pbrt has no such light"),
        };
        if let [Some(a), Some(x), Some(y)] = ["portal_corner", "portal_x", "portal_y"].map(|name| vector(node, name)) {
            list.points("point3", "portal", &[a, a + y, a + x + y, a + x].map(|p| p.as_vec3()));
        }
        let steps = transform(place);
        if steps.is_empty() {
            return self.directive("LightSource", model, list);
        }
        self.block("Attribute", |this| {
            steps.iter().for_each(|step| this.line(step));
            this.directive("LightSource", model, list);
        });
    }

    /// `scale` and what the light is scaled to.
    fn factors(&mut self, id: NodeId, list: &mut List, flux: &str) {
        let node = self.d.node(id);
        if let Some(scale) = float(node, "scale").filter(|s| *s != 1.0) {
            list.float("scale", scale);
        }
        if let Some(x) = float(node, flux) {
            list.float(flux, x);
        }
    }

    fn projection(&mut self, id: NodeId, list: &mut List) -> Option<()> {
        let node = self.d.node(id);
        let Some(Value::Node(texture)) = get(node, "irradiance") else { return None };
        let (path, picture) = (of_bitmap(self.d, *texture)?, Pixels::of(self.d, *texture)?);
        let (w, h) = (picture.width, picture.height);
        let aspect = w as f64 / h as f64;
        let tan = tan_half_fov(node, aspect);
        let half = [tan, tan / aspect];
        let file = if text(node, "falloff") == Some("none") {
            self.beside.refer(self.d, path)
        } else {
            self.approximated(id, "", "a picture of its own, brighter at its edges");
            let brighter = |x: usize, y: usize| (PI * slant([w, h], half, x, y).powi(3)) as f32;
            let new = Pixels::make(w, h, |x, y| picture.texel(x, y) * brighter(x, y));
            self.picture_file(path, &new)
        };
        list.string("filename", &file);
        // The angle is that of the smaller side.
        list.float("fov", 2.0 * half[0].min(half[1]).atan().to_degrees());
        self.factors(id, list, "power");
        Some(())
    }

    /// The parameters of a shape's light.
    pub(super) fn area_light(&mut self, id: NodeId) -> Option<List> {
        let node = self.d.node(id);
        if node.model.value != "area" {
            self.dropped(id, "", "pbrt has no such light");
            return None;
        }
        let mut list = List::default();
        let radiance = get(node, "radiance").cloned().unwrap_or(Value::Float(1.0));
        let scale = float(node, "scale").unwrap_or(1.0);
        match crate::write::constants::folded(self.d, &radiance) {
            Value::Node(texture) => match self.upright_picture(texture) {
                Some(file) => {
                    list.string("filename", &file);
                    if scale != 1.0 {
                        list.float("scale", scale);
                    }
                }
                None => {
                    self.emission(&mut list, "L", &radiance, scale);
                    self.approximated(texture, "", "its mean: pbrt's lights have pictures over (u, v) only");
                }
            },
            even => self.emission(&mut list, "L", &even, scale),
        }
        if flag(node, "two_sided", false) {
            list.bool("twosided", true);
        }
        if let Some(power) = float(node, "power") {
            list.float("power", power);
        }
        Some(list)
    }
}
