//! Sensor nodes with their films, filters and samplers → [`View`].

mod film;
mod pose;

pub(super) use pose::Scales;

use super::Compiler;
use crate::sensor::{Orthographic, Perspective, Projection, Sensor, Spherical, ThinLens};
use crate::settings::{FilmSettings, SamplerSettings, View};
use etendue_description::{Kind, NodeId, Params};
use etendue_numerics::kernel::Kernel;
use etendue_numerics::{Bounds3, Frame, SequenceKind, Vec2, Vec3};

const MODELS: &[&str] = &["perspective", "thinlens", "orthographic", "spherical"];

const REFUSED: &[(&str, &str)] = &[
    ("batch", "several cameras in one cannot be rendered; give each as a sensor of its own"),
    ("distant", "sensors at infinity cannot be rendered"),
    ("irradiancemeter", "meters on surfaces cannot be rendered"),
    ("radiancemeter", "meters of one ray cannot be rendered; a `perspective` of one pixel comes close"),
];

impl<'a> Compiler<'a> {
    /// Compiles a sensor.
    pub(crate) fn sensor(&mut self, id: NodeId) {
        let mut params = Params::new(self.description, id);
        if !MODELS.contains(&params.node.model.value.as_str()) {
            self.refuse_model(&params, MODELS, REFUSED);
            return;
        }
        let film = self.film(&mut params);
        let sampler = self.sampler(&mut params);
        let sensor = self.camera(&mut params, film.size);
        self.shutter(&mut params);
        for (_, medium) in params.children(Kind::Medium) {
            self.diagnostics.error(medium.value.span, "participating media cannot be rendered yet");
        }
        params.finish(self.diagnostics);
        self.views.extend(sensor.map(|sensor| View { sensor, film, sampler }));
    }

    /// The camera itself; `None` where its place is senseless, which has been told.
    fn camera(&mut self, params: &mut Params<'a>, size: [u32; 2]) -> Option<Sensor> {
        let clip = self.clip(params);
        let pixels = Vec2::new(size[0] as f32, size[1] as f32);
        match params.node.model.value.as_str() {
            "orthographic" => {
                let to_world = params.transform(self.diagnostics, "to_world");
                let camera = if to_world.is_affine() { Orthographic::new(to_world, pixels, clip) } else { None };
                if camera.is_none() {
                    let text =
                        "`to_world` of `orthographic` leaves no picture: its axes must span space, and its last row be 0 0 0 1";
                    self.diagnostics.error(params.span_of("to_world"), text);
                }
                camera.map(Sensor::from)
            }
            "spherical" => {
                let equirectangular = params.choice(self.diagnostics, "mapping", &["equalarea", "equirectangular"]) == 1;
                let (p, axes) = self.pose(params, Scales::Tell)?;
                Some(Spherical { p, axes, size: pixels, equirectangular }.into())
            }
            model => {
                let projection = self.projection(params, pixels, clip)?;
                if model == "perspective" {
                    return Some(Perspective { projection }.into());
                }
                Some(self.thin_lens(params, projection))
            }
        }
    }

    fn projection(&mut self, params: &mut Params<'a>, size: Vec2, clip: [f32; 2]) -> Option<Projection> {
        let aspect = f64::from(size.x) / f64::from(size.y);
        let tan = self.tan_half_fov(params, aspect);
        let tan_half = Vec2::new(tan as f32, (tan / aspect) as f32);
        let offset = ["principal_point_offset_x", "principal_point_offset_y"]
            .map(|name| params.float(self.diagnostics, name, 0.0, -1e3..=1e3) as f32);
        let (p, axes) = self.pose(params, Scales::Tell)?;
        Some(Projection { p, axes, tan_half, offset: offset.into(), size, clip })
    }

    fn thin_lens(&mut self, params: &mut Params<'a>, projection: Projection) -> Sensor {
        let far = f64::from(projection.clip[1]);
        let focus_distance = self.positive(params, "focus_distance", far);
        if !params.has("aperture_radius") {
            self.diagnostics.error(params.span(), "`thinlens` needs an `aperture_radius`");
        }
        let aperture_radius = params.float(self.diagnostics, "aperture_radius", 1.0, 0.0..=1e30) as f32;
        // A lens without an aperture is a pinhole.
        if aperture_radius > 0.0 {
            ThinLens { projection, aperture_radius, focus_distance }.into()
        } else {
            Perspective { projection }.into()
        }
    }

    /// The near and the far plane.
    fn clip(&mut self, params: &mut Params<'a>) -> [f32; 2] {
        // Every camera may say where it is focused; only the lens asks again.
        params.ignore(&["focus_distance"]);
        let near = self.positive(params, "near_clip", 1e-2);
        let far = self.positive(params, "far_clip", 1e4);
        if near >= far {
            let name = if params.has("near_clip") { "near_clip" } else { "far_clip" };
            let text = format!("`near_clip` is {near} and `far_clip` {far}: the near plane must lie before the far one");
            self.diagnostics.error(params.span_of(name), text);
        }
        [near, far]
    }

    fn positive(&mut self, params: &mut Params<'a>, name: &'static str, default: f64) -> f32 {
        let value = params.float_opt(self.diagnostics, name).unwrap_or(default);
        let single = value as f32;
        if single > 0.0 && single.is_finite() {
            return single;
        }
        let text = format!("`{name}` of `{}` is {value}, expected a number above zero", params.node.model.value);
        self.diagnostics.error(params.span_of(name), text);
        default as f32
    }

    fn shutter(&mut self, params: &mut Params<'a>) {
        let open = params.float_opt(self.diagnostics, "shutter_open").unwrap_or(0.0);
        let close = params.float_opt(self.diagnostics, "shutter_close").unwrap_or(0.0);
        if open > close {
            let text = format!("the shutter closes at {close}, before it opens at {open}");
            let name = if params.has("shutter_close") { "shutter_close" } else { "shutter_open" };
            self.diagnostics.error(params.span_of(name), text);
        }
    }
}

impl View {
    /// A view of everything within `bounds`, for scenes without a sensor: a camera of 40° in front of the scene (on its +z side, y upwards),
    /// a little above and to the right.
    pub fn looking_at(bounds: &Bounds3, size: [u32; 2]) -> Self {
        let (center, radius) = bounds.bounding_sphere();
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let pixels = Vec2::new(size[0].max(1) as f32, size[1].max(1) as f32);
        let tan: f32 = 20f32.to_radians().tan();
        // The smaller side sees 40°, and the whole sphere fits into it.
        let tan_half = tan * pixels / pixels.min_element();
        let distance = radius / 20f32.to_radians().sin();
        let back = Vec3::new(0.35, 0.25, 1.0).normalize();
        let left = back.cross(Vec3::Y).normalize();
        let axes = Frame { s: left, t: (-back).cross(left), n: -back };
        let clip = [1e-4 * distance, 1e3 * distance];
        let projection = Projection { p: center + back * distance, axes, tan_half, offset: Vec2::ZERO, size: pixels, clip };
        let size = size.map(|side| side.max(1));
        Self {
            sensor: Perspective { projection }.into(),
            film: FilmSettings {
                size,
                crop_offset: [0, 0],
                crop_size: size,
                filter: Kernel::Gaussian { stddev: 0.5 },
                channels: 3,
            },
            sampler: SamplerSettings { kind: SequenceKind::default(), count: 16, seed: 0 },
        }
    }
}
