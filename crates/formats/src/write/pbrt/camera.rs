//! What stands before `WorldBegin`.
//!
//! | étendue | pbrt |
//! | --- | --- |
//! | `perspective`, `thinlens`, `orthographic`, `spherical` (x left) | the same (x right), `screenwindow` for shifted middles and for the size of `orthographic` |
//! | `tent`, `catmullrom`, `lanczos`; `box`, `gaussian`, `mitchell` | `triangle`, `mitchell` with B 0, C 1/2, `sinc`; the same |
//! | `path`, `volpath`, `direct`; `path-nee`, `random-walk`, `ptracer` | `volpath`, `simplepath`, `randomwalk`, `lightpath` |
//! | `bidirectional`, `metropolis`, `photon-map` | `bdpt`, `mlt`, `sppm` |
//! | `aov` | film `gbuffer` |
//! | `max_depth` n; -1 | `maxdepth` n - 1; a million |

use super::Writer;
use super::list::{List, transform};
use crate::write::look::{children, flag, float, integer, matrix, text};
use etendue_description::{Kind, Node, NodeId};
use glam::{DMat4, DVec3};

/// In place of no bound, for walks and for what keeps whole paths.
const UNBOUNDED: [i64; 2] = [1_000_000, 100];
/// The diagonal of the film that focal lengths are told for, 36 × 24 mm.
const FILM_DIAGONAL_MM: f64 = 43.266_615_305_567_87;

impl Writer<'_, '_> {
    pub(super) fn setup(&mut self) {
        let of = |kind: Kind| self.d.top.iter().copied().filter(|id| self.d.node(*id).kind == kind).collect::<Vec<_>>();
        let (integrators, sensors) = (of(Kind::Integrator), of(Kind::Sensor));
        let mut layers = false;
        match integrators.first() {
            Some(id) => self.integrator(*id, &mut layers),
            // Mitsuba's scenes without one have paths of any length.
            None => {
                let mut list = List::default();
                list.integer("maxdepth", if self.d.dialect == etendue_description::Dialect::Pbrt { 5 } else { UNBOUNDED[0] });
                self.directive("Integrator", "volpath", list);
            }
        }
        for id in sensors.iter().skip(1) {
            self.dropped(*id, "", "pbrt's scenes have one camera");
        }
        if let Some(id) = sensors.first() {
            self.sensor(*id, layers);
        }
    }

    fn integrator(&mut self, id: NodeId, layers: &mut bool) {
        let node = self.d.node(id);
        let model = node.model.value.as_str();
        if matches!(model, "aov" | "moment" | "depth") {
            *layers |= model != "moment";
            if model == "depth" {
                self.approximated(id, "", "`volpath` with the layers of a `gbuffer`");
            } else if model == "aov" && text(node, "aovs") != Some(crate::pbrt::camera::GBUFFER) {
                self.approximated(id, "aovs", "the layers that pbrt's `gbuffer` has");
            }
            match children(self.d, id, Kind::Integrator).first() {
                Some(inner) => self.integrator(*inner, layers),
                None => self.directive("Integrator", "volpath", List::default()),
            }
            return;
        }
        let theirs = match model {
            "path-nee" => "simplepath",
            "random-walk" => "randomwalk",
            "ptracer" => "lightpath",
            "bidirectional" => "bdpt",
            "metropolis" => "mlt",
            "photon-map" => "sppm",
            _ => "volpath",
        };
        let mut list = List::default();
        let direct = matches!(model, "direct" | "direct_projective");
        if direct {
            self.approximated(id, "", "`volpath` of one bounce: the same light");
        }
        let depth = if direct { 2 } else { integer(node, "max_depth").unwrap_or(-1) };
        let edges = match depth {
            -1 => UNBOUNDED[usize::from(matches!(theirs, "bdpt" | "mlt"))],
            0 => {
                self.approximated(id, "max_depth", "emitters are seen: pbrt has no paths without edges");
                0
            }
            n => n - 1,
        };
        list.integer("maxdepth", edges);
        if theirs == "mlt" {
            let sampler = self.d.nodes.iter().find(|node| node.kind == Kind::Sampler);
            list.integer("mutationsperpixel", sampler.and_then(|node| integer(node, "sample_count")).unwrap_or(4));
        }
        if flag(node, "hide_emitters", false) {
            self.dropped(id, "hide_emitters", "pbrt shows what emits");
        }
        self.directive("Integrator", theirs, list);
    }

    fn sensor(&mut self, id: NodeId, layers: bool) {
        let node = self.d.node(id);
        let film = children(self.d, id, Kind::Film).first().copied();
        let of_film = |name, default| film.and_then(|f| integer(self.d.node(f), name)).unwrap_or(default);
        let size = [of_film("width", 768), of_film("height", 576)];
        self.filter(film);
        self.film(film, size, layers);
        self.sampler(children(self.d, id, Kind::Sampler).first().copied());

        let m = matrix(node, "to_world");
        let aspect = size[0] as f64 / size[1] as f64;
        // Half of what the film shows, with the shorter side from -1 to 1.
        let half = if aspect > 1.0 { [aspect, 1.0] } else { [1.0, 1.0 / aspect] };
        let mut list = List::default();
        let mut place = m;
        let model = node.model.value.as_str();
        match model {
            "orthographic" => {
                let scale = [m.x_axis, m.y_axis, m.z_axis].map(|a| a.truncate().length());
                let [x, y] = [scale[0], scale[1] / aspect];
                if [x, y] != half {
                    list.floats("screenwindow", &[-x, x, -y, y]);
                }
                place = m * DMat4::from_scale(DVec3::from(scale.map(f64::recip)));
            }
            "spherical" => {
                list.string("mapping", text(node, "mapping").unwrap_or("equalarea"));
            }
            _ => {
                let tan = tan_half_fov(node, aspect);
                list.float("fov", 2.0 * (tan / half[0]).atan().to_degrees());
                let offset = ["x", "y"].map(|a| float(node, &format!("principal_point_offset_{a}")).unwrap_or(0.0));
                if offset != [0.0; 2] {
                    let (x, y) = (2.0 * offset[0] * half[0], -2.0 * offset[1] * half[1]);
                    list.floats("screenwindow", &[x - half[0], x + half[0], y - half[1], y + half[1]]);
                }
                if model == "thinlens" {
                    let far = float(node, "far_clip").unwrap_or(1e4);
                    list.float("lensradius", float(node, "aperture_radius").unwrap_or(1.0));
                    list.float("focaldistance", float(node, "focus_distance").unwrap_or(far));
                }
            }
        }
        // What pbrt's own cameras are read with means nothing to it.
        let clips = [("near_clip", 1e-4), ("far_clip", 1e10)];
        if clips.iter().any(|(name, theirs)| float(node, name).is_some_and(|x| x != *theirs)) {
            self.dropped(id, "near_clip, far_clip", "pbrt's cameras see at every distance");
        }
        let to_camera = (place * DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0))).inverse();
        transform(to_camera).iter().for_each(|line| self.line(line));
        let theirs = if model == "thinlens" { "perspective" } else { model };
        self.directive("Camera", theirs, list);
    }

    fn film(&mut self, film: Option<NodeId>, size: [i64; 2], layers: bool) {
        let mut list = List::default();
        let stem = self.options.out.file_stem().map_or("scene".into(), |s| s.to_string_lossy().into_owned());
        list.string("filename", &format!("{stem}.exr"));
        list.integer("xresolution", size[0]);
        list.integer("yresolution", size[1]);
        if let Some(id) = film {
            let node = self.d.node(id);
            let crop = ["crop_offset_x", "crop_width", "crop_offset_y", "crop_height"].map(|name| integer(node, name));
            if crop.iter().any(Option::is_some) {
                let [x, y] = [crop[0], crop[2]].map(|o| o.unwrap_or(0));
                list.integers("pixelbounds", [x, x + crop[1].unwrap_or(size[0]), y, y + crop[3].unwrap_or(size[1])]);
            }
            if text(node, "pixel_format").is_some_and(|f| f.starts_with("luminance")) {
                self.dropped(id, "pixel_format", "pbrt's films are in colour");
            }
        }
        self.directive("Film", if layers { "gbuffer" } else { "rgb" }, list);
    }

    fn filter(&mut self, film: Option<NodeId>) {
        let given = film.and_then(|f| children(self.d, f, Kind::Filter).first().copied());
        let node = given.map(|id| self.d.node(id));
        let number = |name, default| node.and_then(|n| float(n, name)).unwrap_or(default);
        let mut list = List::default();
        let radius = |list: &mut List, r: f64| ["xradius", "yradius"].iter().for_each(|name| list.float(name, r));
        let model = match node.map_or("gaussian", |n| n.model.value.as_str()) {
            "box" => {
                radius(&mut list, number("radius", 0.5));
                "box"
            }
            "tent" => {
                radius(&mut list, number("radius", 1.0));
                "triangle"
            }
            "mitchell" => {
                radius(&mut list, 2.0);
                ["B", "C"].iter().for_each(|name| list.float(name, number(name, 1.0 / 3.0)));
                "mitchell"
            }
            "catmullrom" => {
                radius(&mut list, 2.0);
                list.float("B", 0.0);
                list.float("C", 0.5);
                "mitchell"
            }
            "lanczos" => {
                let lobes = node.and_then(|n| integer(n, "lobes")).unwrap_or(3) as f64;
                radius(&mut list, lobes);
                list.float("tau", lobes);
                "sinc"
            }
            _ => {
                let sigma = number("stddev", 0.5);
                // The bell ends at four deviations here.
                radius(&mut list, 4.0 * sigma);
                list.float("sigma", sigma);
                "gaussian"
            }
        };
        self.directive("PixelFilter", model, list);
    }

    fn sampler(&mut self, sampler: Option<NodeId>) {
        let node = sampler.map(|id| self.d.node(id));
        let count = node.and_then(|n| integer(n, "sample_count")).unwrap_or(4);
        let seed = node.and_then(|n| integer(n, "seed")).unwrap_or(0);
        let mut list = List::default();
        list.integer("pixelsamples", count);
        if seed != 0 {
            list.integer("seed", seed.rem_euclid(1 << 31));
        }
        let model = match node.map_or("independent", |n| n.model.value.as_str()) {
            "independent" => "independent",
            "sobol" | "ldsampler" => "sobol",
            _ => "halton",
        };
        self.directive("Sampler", model, list);
    }
}

/// tan(fov_x / 2) of a camera, or of a projector whose picture has this aspect.
pub(super) fn tan_half_fov(node: &Node, aspect: f64) -> f64 {
    let Some(fov) = float(node, "fov") else {
        let mm = text(node, "focal_length").unwrap_or("50mm").trim().trim_end_matches("mm").trim_end();
        let tan = 0.5 * FILM_DIAGONAL_MM / mm.parse::<f64>().unwrap_or(50.0);
        return tan / (1.0 + 1.0 / (aspect * aspect)).sqrt();
    };
    let tan = (0.5 * fov.to_radians()).tan();
    match text(node, "fov_axis").unwrap_or("x") {
        "y" => tan * aspect,
        "diagonal" => tan / (1.0 + 1.0 / (aspect * aspect)).sqrt(),
        "smaller" if aspect > 1.0 => tan * aspect,
        "larger" if aspect <= 1.0 => tan * aspect,
        _ => tan,
    }
}
