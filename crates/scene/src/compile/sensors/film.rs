//! Film, filter and sampler nodes → [`FilmSettings`] and [`SamplerSettings`].

use crate::compile::Compiler;
use crate::settings::{FilmSettings, SamplerSettings};
use etendue_description::{Kind, NodeId, Params};
use etendue_numerics::SequenceKind;
use etendue_numerics::kernel::Kernel;

const FILMS: &[&str] = &["hdrfilm", "ldrfilm"];
const FILMS_REFUSED: &[(&str, &str)] = &[("specfilm", "films of many spectral bands cannot be rendered")];
const FILTERS: &[&str] = &["box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"];
const SAMPLERS: &[&str] = &["independent", "stratified", "multijitter", "orthogonal", "ldsampler", "sobol", "halton", "hammersley"];

/// The default filter, Mitsuba's.
const GAUSSIAN: Kernel = Kernel::Gaussian { stddev: 0.5 };

/// Pixels of a side at the most, and of a film.
const MAX_SIDE: i64 = 1 << 20;
const MAX_PIXELS: u64 = 1 << 28;
/// What a pixel takes while it is rendered, about.
const BYTES_PER_PIXEL: f64 = 64.0;

impl<'a> Compiler<'a> {
    /// The film among a sensor's children, or the default one: 768 × 576 pixels.
    pub(super) fn film(&mut self, sensor: &mut Params<'a>) -> FilmSettings {
        let mut films = sensor.children(Kind::Film).into_iter();
        let film = films.next().map(|(id, _)| self.film_of(id));
        for (_, extra) in films {
            self.diagnostics.error(extra.value.span, "a sensor has one film at the most");
        }
        let size = self.options.film_size([768, 576]);
        film.unwrap_or(FilmSettings { size, crop_offset: [0, 0], crop_size: size, filter: GAUSSIAN, channels: 3 })
    }

    fn film_of(&mut self, id: NodeId) -> FilmSettings {
        let mut params = Params::new(self.description, id);
        if !FILMS.contains(&params.node.model.value.as_str()) {
            self.refuse_model(&params, FILMS, FILMS_REFUSED);
            return FilmSettings { size: [1, 1], crop_offset: [0, 0], crop_size: [1, 1], filter: GAUSSIAN, channels: 3 };
        }
        let named = [("width", 768), ("height", 576)];
        let full = named.map(|(name, default)| params.integer(self.diagnostics, name, default, 1..=MAX_SIDE) as u32);
        let crop = self.crop(&mut params, full);

        // Another size keeps the part that is rendered in proportion.
        let size = self.options.film_size(full).map(|side| side.max(1));
        let scale = |x: u32, i: usize| (f64::from(x) * f64::from(size[i]) / f64::from(full[i])).round() as u32;
        let crop_offset = std::array::from_fn(|i| scale(crop.0[i], i).min(size[i] - 1));
        let crop_size = std::array::from_fn(|i| scale(crop.1[i], i).clamp(1, size[i] - crop_offset[i]));
        let pixels = u64::from(crop_size[0]) * u64::from(crop_size[1]);
        if pixels > MAX_PIXELS {
            let [w, h] = crop_size;
            let gib = pixels as f64 * BYTES_PER_PIXEL / (1u64 << 30) as f64;
            let text = format!("a film of {w} x {h} is {} million pixels and needs about {gib:.0} GiB", pixels / 1_000_000);
            self.diagnostics
                .error(params.span(), text)
                .help(format!("at most {} million pixels can be rendered", MAX_PIXELS / 1_000_000));
        }

        let formats = ["rgb", "rgba", "luminance", "luminance_alpha", "xyz", "xyza"];
        let channels = if (2..=3).contains(&params.choice(self.diagnostics, "pixel_format", &formats)) { 1 } else { 3 };
        // How files are written is the caller's choice; borders need no samples of their own.
        params.ignore(&["file_format", "component_format", "sample_border", "compensate", "banner", "gamma", "exposure"]);

        let filter = self.filter(&mut params);
        params.finish(self.diagnostics);
        FilmSettings { size, crop_offset, crop_size, filter, channels }
    }

    /// Offset and size of the part that is rendered.
    fn crop(&mut self, params: &mut Params<'a>, full: [u32; 2]) -> ([u32; 2], [u32; 2]) {
        let offsets = ["crop_offset_x", "crop_offset_y"];
        let sizes = ["crop_width", "crop_height"];
        let whole = full.map(i64::from);
        let offset: [i64; 2] = std::array::from_fn(|i| params.integer(self.diagnostics, offsets[i], 0, 0..=whole[i] - 1));
        let rest: [i64; 2] = std::array::from_fn(|i| params.integer(self.diagnostics, sizes[i], whole[i], 1..=whole[i]));
        for i in 0..2 {
            if offset[i] + rest[i] > whole[i] {
                let given = if params.has(sizes[i]) { sizes[i] } else { offsets[i] };
                let (o, s, w) = (offset[i], rest[i], whole[i]);
                let text =
                    format!("the crop window does not fit: `{}` {o} and `{}` {s} pass the film's {w} pixels", offsets[i], sizes[i]);
                self.diagnostics.error(params.span_of(given), text);
                return ([0, 0], full);
            }
        }
        (offset.map(|x| x as u32), rest.map(|x| x as u32))
    }

    fn filter(&mut self, film: &mut Params<'a>) -> Kernel {
        let mut filters = film.children(Kind::Filter).into_iter();
        let Some((id, _)) = filters.next() else { return GAUSSIAN };
        for (_, extra) in filters {
            self.diagnostics.error(extra.value.span, "a film has one reconstruction filter at the most");
        }
        let mut params = Params::new(self.description, id);
        // Wide filters cost time without end and blur the picture away.
        let mut number = |name, default, range| params.float(self.diagnostics, name, default, range) as f32;
        let third = 1.0 / 3.0;
        let kernel = match self.description.node(id).model.value.as_str() {
            "box" => Kernel::Box { radius: number("radius", 0.5, 0.01..=32.0) },
            "tent" => Kernel::Tent { radius: number("radius", 1.0, 0.01..=32.0) },
            "gaussian" => Kernel::Gaussian { stddev: number("stddev", 0.5, 0.01..=8.0) },
            "mitchell" => Kernel::Mitchell { b: number("B", third, -10.0..=10.0), c: number("C", third, -10.0..=10.0) },
            "catmullrom" => Kernel::CatmullRom,
            "lanczos" => Kernel::Lanczos { lobes: params.integer(self.diagnostics, "lobes", 3, 1..=16) as f32 },
            _ => {
                self.refuse_model(&params, FILTERS, &[]);
                return GAUSSIAN;
            }
        };
        params.finish(self.diagnostics);
        kernel
    }

    /// The sampler among a sensor's children. Every model is answered by étendue's own point set, which is at least as even as all of them.
    pub(super) fn sampler(&mut self, sensor: &mut Params<'a>) -> SamplerSettings {
        let default = SamplerSettings { kind: SequenceKind::default(), count: 4, seed: 0 };
        let mut samplers = sensor.children(Kind::Sampler).into_iter();
        let Some((id, _)) = samplers.next() else { return default };
        for (_, extra) in samplers {
            self.diagnostics.error(extra.value.span, "a sensor has one sampler at the most");
        }
        let mut params = Params::new(self.description, id);
        if !SAMPLERS.contains(&params.node.model.value.as_str()) {
            self.refuse_model(&params, SAMPLERS, &[]);
            return default;
        }
        let count = params.integer(self.diagnostics, "sample_count", 4, 1..=1 << 30) as u32;
        let seed = params.integer(self.diagnostics, "seed", 0, 0..=i64::MAX) as u64;
        params.ignore(&["jitter", "scramble", "dimension"]);
        params.finish(self.diagnostics);
        SamplerSettings { count, seed, ..default }
    }
}
