//! What stands before `WorldBegin`: camera, film, filter, sampler, integrator.
//!
//! | directive | here |
//! | --- | --- |
//! | `perspective`, with `lensradius` | `perspective`, `thinlens` |
//! | `orthographic`, `spherical` | `orthographic`, `spherical` |
//! | `realistic` | refused |
//! | films `rgb`, `spectral`; `gbuffer` | `hdrfilm`; with layers |
//! | filters `box`, `triangle`, `gaussian`, `mitchell`, `sinc` | `box`, `tent`, `gaussian`, `mitchell`, `lanczos` |
//! | integrators | by the table in `integrator` below |

use super::state::{CoordinateSystems, State};
use super::values::List;
use super::{Reader, child, param};
use etendue_description::{Diagnostics, Kind, NodeId, Param, Span, Value};
use etendue_numerics::Transform;
use glam::{DMat4, DVec3};

const CAMERAS: [&str; 3] = ["perspective", "orthographic", "spherical"];
const FILMS: [&str; 3] = ["rgb", "gbuffer", "spectral"];
const FILTERS: [&str; 5] = ["box", "gaussian", "mitchell", "sinc", "triangle"];
const SAMPLERS: [&str; 6] = ["halton", "independent", "paddedsobol", "sobol", "stratified", "zsobol"];
const INTEGRATORS: [&str; 9] = ["volpath", "path", "simplevolpath", "simplepath", "randomwalk", "lightpath", "bdpt", "mlt", "sppm"];

/// The layers of a film `gbuffer`.
pub(crate) const GBUFFER: &str = "albedo:albedo,position:position,depth:depth,n:geo_normal,ns:sh_normal,uv:uv";

/// The directives before `WorldBegin`, kept until it comes.
#[derive(Debug, Default)]
pub(super) struct Setup {
    camera: Option<(String, List, [DMat4; 2])>,
    film: Option<(String, List, super::spectra::ColourSpace)>,
    filter: Option<(String, List)>,
    sampler: Option<(String, List)>,
    integrator: Option<(String, List)>,
}

impl Setup {
    /// Keeps a directive; the last of a kind counts.
    pub fn keep(
        &mut self,
        word: &str,
        name: String,
        list: List,
        state: &State,
        systems: &mut CoordinateSystems,
        diagnostics: &mut Diagnostics,
    ) {
        let before = match word {
            "Camera" => {
                systems.insert("camera".to_owned(), state.ctm.map(|m| m.inverse()));
                self.camera.replace((name, list, state.ctm)).map(|c| c.1.span)
            }
            "Film" => self.film.replace((name, list, state.space)).map(|f| f.1.span),
            "PixelFilter" => self.filter.replace((name, list)).map(|f| f.1.span),
            "Sampler" => self.sampler.replace((name, list)).map(|s| s.1.span),
            _ => self.integrator.replace((name, list)).map(|i| i.1.span),
        };
        if let Some(before) = before {
            diagnostics.warning(before, format!("a second `{word}` takes the place of this one"));
        }
    }
}

impl Reader<'_> {
    pub(super) fn world_begin(&mut self, span: Span) {
        if std::mem::replace(&mut self.world, true) {
            self.diagnostics.error(span, "`WorldBegin` stands twice");
            return;
        }
        let setup = std::mem::take(&mut self.setup);
        let empty = |what: &str| List::new(what.to_owned(), span, Vec::new(), &std::sync::Arc::default());
        let (film_name, mut film, _) = setup.film.unwrap_or(("rgb".to_owned(), empty("film `rgb`"), self.state.space));
        let (camera_name, mut camera, ctm) =
            setup.camera.unwrap_or(("perspective".to_owned(), empty("camera `perspective`"), [DMat4::IDENTITY; 2]));

        let shutter =
            camera.float(&mut self.diagnostics, "shutterclose", 1.0) - camera.float(&mut self.diagnostics, "shutteropen", 0.0);
        if shutter <= 0.0 {
            self.diagnostics.error(camera.span_of("shutterclose"), "the shutter closes before it opens");
        } else {
            self.imaging = shutter * film.positive(&mut self.diagnostics, "iso", 100.0) / 100.0;
        }

        let filter = setup.filter.map(|(name, list)| self.filter(&name, list));
        // Chains make mutations, whatever the sampler says.
        let mut integrator = setup.integrator;
        let mutations = match &mut integrator {
            Some((name, list)) if name == "mlt" => Some(list.integer(&mut self.diagnostics, "mutationsperpixel", 100, 1..=1 << 30)),
            _ => None,
        };
        let (name, list) = setup.sampler.unwrap_or_else(|| ("zsobol".to_owned(), empty("sampler `zsobol`")));
        let sampler = self.sampler(&name, list, mutations);
        let (film_node, size, layers) = self.film(&film_name, &mut film, filter.flatten());
        self.sensor(&camera_name, &mut camera, ctm, size, [Some(film_node), sampler]);
        match integrator {
            Some((name, list)) => self.integrator(&name, list, &layers),
            None => self.integrator("volpath", empty("integrator `volpath`"), &layers),
        }

        let ctm = [DMat4::IDENTITY; 2];
        self.state.ctm = ctm;
        self.state.active = [true; 2];
        self.systems.insert("world".to_owned(), ctm);
    }

    /// A model that is none of the `known` ones; `refused` ones come with a reason.
    pub(super) fn unknown_model(&mut self, list: &List, kind: &str, name: &str, known: &[&str], refused: &[(&str, &str)]) {
        if let Some((_, why)) = refused.iter().find(|(refused, _)| *refused == name) {
            self.diagnostics.error(list.span, format!("the {kind} `{name}` is refused: {why}"));
            return;
        }
        let names = known.iter().chain(refused.iter().map(|(name, _)| name)).copied();
        self.diagnostics.error(list.span, format!("unknown {kind} `{name}`")).suggest(name, names);
    }

    fn filter(&mut self, name: &str, mut list: List) -> Option<NodeId> {
        let d = &mut self.diagnostics;
        let span = list.span;
        let default = match name {
            "box" => 0.5,
            "gaussian" => 1.5,
            "mitchell" | "triangle" => 2.0,
            "sinc" => 4.0,
            _ => {
                self.unknown_model(&list, "filter", name, &FILTERS, &[]);
                return None;
            }
        };
        let [x, y] = ["xradius", "yradius"].map(|axis| list.positive(d, axis, default));
        if x != y {
            d.warning(list.span_of("yradius"), format!("filters are as wide as they are high here: {x} by {x} pixels"));
        }
        let (model, params) = match name {
            "box" => ("box", vec![param("radius", Value::Float(x), span)]),
            "triangle" => ("tent", vec![param("radius", Value::Float(x), span)]),
            // pbrt cuts the bell off at its radius; here it ends at four deviations.
            "gaussian" => ("gaussian", vec![param("stddev", Value::Float(list.positive(d, "sigma", 0.5)), span)]),
            "mitchell" => {
                let third = 1.0 / 3.0;
                let params = ["B", "C"].map(|n| param(n, Value::Float(list.float(d, n, third)), span));
                ("mitchell", params.to_vec())
            }
            _ => {
                let lobes = list.positive(d, "tau", 3.0).round().clamp(1.0, 16.0);
                ("lanczos", vec![param("lobes", Value::Integer(lobes as i64), span)])
            }
        };
        list.finish(d);
        Some(self.node(Kind::Filter, model, span, params))
    }

    /// The sampler; `mutations` per pixel take the place of its samples.
    fn sampler(&mut self, name: &str, mut list: List, mutations: Option<i64>) -> Option<NodeId> {
        if !SAMPLERS.contains(&name) {
            self.unknown_model(&list, "sampler", name, &SAMPLERS, &[("02sequence", "in pbrt-v4 it is `paddedsobol`")]);
            return None;
        }
        let d = &mut self.diagnostics;
        let count = if name == "stratified" {
            let [x, y] = ["xsamples", "ysamples"].map(|axis| list.integer(d, axis, 4, 1..=1 << 15));
            x * y
        } else {
            list.integer(d, "pixelsamples", if name == "independent" { 4 } else { 16 }, 1..=1 << 30)
        };
        let count = mutations.unwrap_or(count);
        let seed = list.integer(d, "seed", 0, i64::MIN..=i64::MAX);
        list.ignore(&["randomization", "jitter", "dimensions"]);
        list.finish(d);
        let seed = Value::Integer(i64::from(seed as u32));
        let params = vec![param("sample_count", Value::Integer(count), list.span), param("seed", seed, list.span)];
        Some(self.node(Kind::Sampler, "independent", list.span, params))
    }

    /// The film, its size, and the layers that it asks for.
    fn film(&mut self, name: &str, list: &mut List, filter: Option<NodeId>) -> (NodeId, [f64; 2], String) {
        if !FILMS.contains(&name) {
            self.unknown_model(list, "film", name, &FILMS, &[("image", "in pbrt-v4 it is `rgb`")]);
        }
        let d = &mut self.diagnostics;
        let span = list.span;
        let size = [("xresolution", 1280), ("yresolution", 720)].map(|(name, n)| list.integer(d, name, n, 1..=1 << 20));
        let mut params = vec![
            param("width", Value::Integer(size[0]), list.span_of("xresolution")),
            param("height", Value::Integer(size[1]), list.span_of("yresolution")),
        ];
        // The part that is rendered: x from, x to, y from, y to; as fractions, or in pixels.
        let bounds = match list.integers(d, "pixelbounds") {
            Some(v) => <[i32; 4]>::try_from(v).ok().map(|v| v.map(i64::from)),
            None => list.floats(d, "cropwindow").and_then(|v| <[f64; 4]>::try_from(v).ok()).map(|v| {
                let at = |x: f64, n: i64| ((x.clamp(0.0, 1.0) * n as f64).ceil() as i64).clamp(0, n);
                [at(v[0], size[0]), at(v[1], size[0]), at(v[2], size[1]), at(v[3], size[1])]
            }),
        };
        for name in ["pixelbounds", "cropwindow"] {
            if list.has(name) && bounds.is_none() {
                d.error(list.span_of(name), format!("`{name}` has four numbers: x from, x to, y from, y to"));
            }
        }
        if let Some([x0, x1, y0, y1]) = bounds {
            let place = list.span_of(if list.has("pixelbounds") { "pixelbounds" } else { "cropwindow" });
            let [x0, x1] = [x0, x1].map(|x| x.clamp(0, size[0]));
            let [y0, y1] = [y0, y1].map(|y| y.clamp(0, size[1]));
            if x0 < x1 && y0 < y1 {
                let crop = [("crop_offset_x", x0), ("crop_offset_y", y0), ("crop_width", x1 - x0), ("crop_height", y1 - y0)];
                params.extend(crop.map(|(name, n)| param(name, Value::Integer(n), place)));
            } else {
                d.error(place, "the part that is rendered holds no pixel");
            }
        }
        let sensor = list.text_opt(d, "sensor");
        if let Some((sensor, at)) = sensor.filter(|(name, _)| name != "cie1931") {
            d.warning(at, format!("the sensor `{sensor}` is rendered as `cie1931`: colours differ"));
        }
        if list.float_opt(d, "whitebalance").is_some_and(|kelvin| kelvin != 0.0) {
            d.warning(list.span_of("whitebalance"), "`whitebalance` is not applied: colours are those of the scene");
        }
        if list.float_opt(d, "maxcomponentvalue").is_some_and(|x| x.is_finite()) {
            d.warning(list.span_of("maxcomponentvalue"), "`maxcomponentvalue` is not applied: samples are not cut off");
        }
        // Read before, or for lenses and files alone.
        list.ignore(&[
            "iso",
            "diagonal",
            "filename",
            "savefp16",
            "lambdamin",
            "lambdamax",
            "nbuckets",
            "coordinatesystem",
            "buckets",
        ]);
        list.finish(d);
        params.extend(filter.map(|id| child(id, span)));
        let layers = if name == "gbuffer" { GBUFFER } else { "" };
        (self.node(Kind::Film, "hdrfilm", span, params), size.map(|n| n as f64), layers.to_owned())
    }

    fn sensor(&mut self, name: &str, list: &mut List, ctm: [DMat4; 2], size: [f64; 2], parts: [Option<NodeId>; 2]) {
        if !CAMERAS.contains(&name) {
            let refused = [("realistic", "cameras of many lenses cannot be rendered; `perspective` with `lensradius` comes close")];
            self.unknown_model(list, "camera", name, &CAMERAS, &refused);
            return;
        }
        let span = list.span;
        if ctm[0] != ctm[1] {
            self.diagnostics.error(span, "this camera moves: motion cannot be rendered yet");
        }
        let d = &mut self.diagnostics;
        list.ignore(&["shutteropen", "shutterclose"]);
        // From pbrt's camera, x to the right, to ours, x to the left.
        let mut to_world = ctm[0].inverse() * DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let mut params = Vec::new();
        if name == "spherical" {
            let mapping = list.choice(d, "mapping", &["equalarea", "equirectangular"]);
            params.push(param("mapping", Value::String(mapping.to_owned()), list.span_of("mapping")));
            list.ignore(&["lensradius", "focaldistance", "frameaspectratio", "screenwindow"]);
        } else {
            let [x0, x1, y0, y1] = screen_window(list, d, size);
            let half = [0.5 * (x1 - x0), 0.5 * (y1 - y0)];
            let stretch = half[0] / half[1] * size[1] / size[0];
            if (stretch - 1.0).abs() > 1e-3 {
                d.warning(span, format!("pixels are squares here: the picture shows what its width of {} says", 2.0 * half[0]));
            }
            let middle = [0.5 * (x0 + x1), 0.5 * (y0 + y1)];
            let lens = list.float(d, "lensradius", 0.0);
            let focus = list.positive(d, "focaldistance", 1e6);
            if name == "perspective" {
                let fov = list.float(d, "fov", 90.0);
                if !(fov > 0.0 && fov < 180.0) {
                    d.error(list.span_of("fov"), format!("`fov` is {fov}, expected more than 0 and less than 180 degrees"));
                }
                let tan = (0.5 * fov.clamp(1e-3, 179.999)).to_radians().tan() * half[0];
                params.push(param("fov", Value::Float(2.0 * tan.atan().to_degrees()), list.span_of("fov")));
                params.push(param("fov_axis", Value::String("x".to_owned()), span));
                // The picture's middle lies where the axis does not; o = -middle / width, x to the left.
                for (axis, o) in [
                    ("principal_point_offset_x", 0.5 * middle[0] / half[0]),
                    ("principal_point_offset_y", -0.5 * middle[1] / half[1]),
                ] {
                    if o != 0.0 {
                        params.push(param(axis, Value::Float(o), list.span_of("screenwindow")));
                    }
                }
                if lens > 0.0 {
                    // Both in the camera's own unit of length.
                    let unit = to_world.x_axis.truncate().length();
                    params.push(param("aperture_radius", Value::Float(lens * unit), list.span_of("lensradius")));
                    params.push(param("focus_distance", Value::Float(focus * unit), list.span_of("focaldistance")));
                }
            } else {
                if lens > 0.0 {
                    d.warning(list.span_of("lensradius"), "an `orthographic` camera is rendered without a lens: all is sharp");
                }
                let shift = DMat4::from_translation(DVec3::new(-middle[0], middle[1], 0.0));
                to_world = to_world * shift * DMat4::from_scale(DVec3::new(half[0], half[0], 1.0));
            }
            params.push(param("near_clip", Value::Float(1e-4), span));
            params.push(param("far_clip", Value::Float(1e10), span));
        }
        list.finish(d);
        let model = if params.iter().any(|p| p.name.value == "aperture_radius") { "thinlens" } else { name };
        match Transform::new(unscaled(to_world, name)) {
            Some(t) => params.push(param("to_world", Value::Transform(Box::new(t)), span)),
            None => drop(d.error(span, "the camera's transform flattens space or is not finite")),
        }
        params.extend(parts.into_iter().flatten().map(|id| child(id, span)));
        self.top(Kind::Sensor, model, span, params);
    }

    fn integrator(&mut self, name: &str, mut list: List, layers: &str) {
        let span = list.span;
        let refused = [
            ("ao", "ambient occlusion is no light transport"),
            ("ambientocclusion", "ambient occlusion is no light transport"),
            ("function", "it renders no scene"),
        ];
        // What étendue runs, in the names of the description.
        let model = match name {
            "volpath" | "path" | "simplevolpath" => "path",
            "simplepath" => "path-nee",
            "randomwalk" => "random-walk",
            "lightpath" => "ptracer",
            "bdpt" => "bidirectional",
            "mlt" => "metropolis",
            "sppm" => "photon-map",
            _ => return self.unknown_model(&list, "integrator", name, &INTEGRATORS, &refused),
        };
        let d = &mut self.diagnostics;
        let depth = list.integer(d, "maxdepth", 5, 0..=i64::from(u32::MAX) - 1) + 1;
        if list.bool(d, "regularize", false) {
            d.warning(list.span_of("regularize"), "`regularize` is not obeyed: surfaces stay as sharp as they are");
        }
        // How others choose samples: the picture's mean does not depend on it.
        list.ignore(&["lightsampler", "usemis", "samplelights", "samplebsdf", "visualizestrategies", "visualizeweights"]);
        list.ignore(&["bootstrapsamples", "chains", "mutationsperpixel", "sigma", "largestepprobability"]);
        list.ignore(&["photonsperiteration", "radius", "seed", "imagewritefrequency", "rrthreshold", "pixelbounds"]);
        list.finish(d);
        let params: Vec<Param> = vec![param("max_depth", Value::Integer(depth), list.span_of("maxdepth"))];
        if layers.is_empty() {
            self.top(Kind::Integrator, model, span, params);
        } else {
            let inner = self.node(Kind::Integrator, model, span, params);
            let params = vec![param("aovs", Value::String(layers.to_owned()), span), child(inner, span)];
            self.top(Kind::Integrator, "aov", span, params);
        }
    }
}

/// x from, x to, y from, y to: what the film shows, the shorter side from -1 to 1 by default.
fn screen_window(list: &mut List, d: &mut Diagnostics, size: [f64; 2]) -> [f64; 4] {
    let aspect = list.positive(d, "frameaspectratio", size[0] / size[1]);
    let default = if aspect > 1.0 { [-aspect, aspect, -1.0, 1.0] } else { [-1.0, 1.0, -1.0 / aspect, 1.0 / aspect] };
    let Some(given) = list.floats(d, "screenwindow") else { return default };
    match <[f64; 4]>::try_from(given) {
        Ok(w) if w[0] < w[1] && w[2] < w[3] => w,
        _ => {
            d.error(list.span_of("screenwindow"), "`screenwindow` has four numbers: x from, x to, y from, y to");
            default
        }
    }
}

/// A camera's map without one scale for all axes, which pbrt's scenes often hold and which changes nothing for a pinhole.
fn unscaled(m: DMat4, name: &str) -> DMat4 {
    if name == "orthographic" {
        return m;
    }
    let lengths = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.truncate().length());
    let scale = lengths[0];
    if scale > 0.0 && lengths.iter().all(|l| (l / scale - 1.0).abs() < 1e-3) {
        return DMat4::from_cols(m.x_axis / scale, m.y_axis / scale, m.z_axis / scale, m.w_axis);
    }
    m
}
