//! Integrator nodes → [`Integrator`]: which of étendue's solvers answers to which name.
//!
//! | the file says | étendue runs |
//! | --- | --- |
//! | `path`, `volpath`, `volpathmis`, `prb`, `prb_basic`, `prb_projective`, `prbvolpath` | `path-mis` |
//! | `direct`, `direct_projective` | `direct` |
//! | `ptracer` | `light-nee` |
//! | `depth`, `aov` | `aov`, or the nested integrator with layers beside its picture |
//! | `moment` | the nested integrator |
//! | `path-nee`, `path-guided`, `random-walk`, `bidirectional`, `metropolis`, `photon-map` | the same; `random-walk` is `path` |

use super::Compiler;
use crate::settings::Integrator;
use etendue_description::{Dialect, Kind, NodeId, Params, nearest};

const MODELS: &[&str] = &[
    "aov",
    "bidirectional",
    "depth",
    "direct",
    "direct_projective",
    "metropolis",
    "moment",
    "path",
    "path-guided",
    "path-nee",
    "photon-map",
    "prb",
    "prb_basic",
    "prb_projective",
    "prbvolpath",
    "ptracer",
    "random-walk",
    "volpath",
    "volpathmis",
];

const REFUSED: &[(&str, &str)] = &[("stokes", "polarised light cannot be rendered")];

/// What a layer of `aov` may hold.
const LAYERS: &[&str] = &[
    "albedo",
    "depth",
    "position",
    "uv",
    "geo_normal",
    "sh_normal",
    "dp_du",
    "dp_dv",
    "duv_dx",
    "duv_dy",
    "prim_index",
    "shape_index",
    "boundary_test",
];

impl<'a> Compiler<'a> {
    /// Compiles the scene's integrator.
    pub(crate) fn integrator(&mut self, id: NodeId) {
        let integrator = self.integrator_of(id);
        if self.integrator.is_some() {
            let span = self.description.node(id).span;
            self.diagnostics.error(span, "a scene has one integrator at the most");
        }
        self.integrator = Some(integrator);
    }

    fn integrator_of(&mut self, id: NodeId) -> Integrator {
        let mut params = Params::new(self.description, id);
        params.ignore(&["samples_per_pass", "block_size", "timeout"]);
        let integrator = match params.node.model.value.as_str() {
            "path" | "prb" | "prb_basic" | "prb_projective" => self.path(&mut params, "path-mis", true),
            "volpath" | "volpathmis" | "prbvolpath" => self.path(&mut params, "path-mis", false),
            "ptracer" => self.path(&mut params, "light-nee", true),
            "path-guided" => self.path(&mut params, "path-guided", false),
            "path-nee" => self.path(&mut params, "path-nee", false),
            "random-walk" => self.path(&mut params, "path", false),
            "bidirectional" => self.path(&mut params, "bidirectional", false),
            "metropolis" => self.path(&mut params, "metropolis", false),
            "photon-map" => self.path(&mut params, "photon-map", false),
            "direct" | "direct_projective" => self.direct(&mut params),
            "depth" => {
                let aovs = vec![("depth".to_owned(), "depth".to_owned())];
                Integrator { solver: "aov".to_owned(), aovs, ..Integrator::default() }
            }
            "aov" => {
                let aovs = self.layers(&mut params);
                let inner = self.inner_integrator(&mut params);
                let plain = || Integrator { solver: "aov".to_owned(), ..Integrator::default() };
                let mut integrator = inner.unwrap_or_else(plain);
                integrator.aovs.splice(0..0, aovs);
                integrator
            }
            "moment" => self.inner_integrator(&mut params).unwrap_or_else(|| {
                self.diagnostics.error(params.span(), "`moment` needs a nested integrator");
                Integrator::default()
            }),
            _ => {
                self.refuse_model(&params, MODELS, REFUSED);
                return Integrator::default();
            }
        };
        params.finish(self.diagnostics);
        integrator
    }

    /// The parameters that path tracers share. `null_counts`: whether passing a null or mask surface makes a path longer; in pbrt it never does.
    fn path(&mut self, params: &mut Params<'a>, solver: &str, null_counts: bool) -> Integrator {
        let max_depth = params.integer(self.diagnostics, "max_depth", -1, -1..=i64::from(u32::MAX));
        let asks = params.has("rr_depth");
        let rr_depth = params.integer(self.diagnostics, "rr_depth", 5, 1..=i64::from(u32::MAX)) as u32;
        Integrator {
            solver: solver.to_owned(),
            max_depth: u32::try_from(max_depth).ok(),
            rr_depth: asks.then_some(rr_depth),
            hide_emitters: params.bool(self.diagnostics, "hide_emitters", false),
            null_counts: null_counts && self.description.dialect == Dialect::Mitsuba,
            ..Integrator::default()
        }
    }

    fn direct(&mut self, params: &mut Params<'a>) -> Integrator {
        const MOST: i64 = 1 << 20;
        let given = params.has("shading_samples");
        if given && (params.has("emitter_samples") || params.has("bsdf_samples")) {
            let text = "`shading_samples` stands for both `emitter_samples` and `bsdf_samples`: give either it or them";
            self.diagnostics.error(params.span_of("shading_samples"), text);
        }
        let shading = params.integer(self.diagnostics, "shading_samples", 1, 1..=MOST);
        let emitter_samples = params.integer(self.diagnostics, "emitter_samples", shading, 0..=MOST) as u32;
        let bsdf_samples = params.integer(self.diagnostics, "bsdf_samples", shading, 0..=MOST) as u32;
        if emitter_samples + bsdf_samples == 0 {
            self.diagnostics.error(params.span(), "`direct` needs `emitter_samples` or `bsdf_samples` above zero");
        }
        Integrator {
            solver: "direct".to_owned(),
            max_depth: Some(2),
            hide_emitters: params.bool(self.diagnostics, "hide_emitters", false),
            emitter_samples,
            bsdf_samples,
            ..Integrator::default()
        }
    }

    /// The integrator within another.
    fn inner_integrator(&mut self, params: &mut Params<'a>) -> Option<Integrator> {
        let children = params.children(Kind::Integrator);
        if let Some((_, second)) = children.get(1) {
            let text = format!("`{}` renders the first of its integrators only", params.node.model.value);
            self.diagnostics.warning(second.value.span, text);
        }
        children.first().map(|(id, _)| self.integrator_of(*id))
    }

    /// `aovs`: layers as `name:quantity`, with commas between.
    fn layers(&mut self, params: &mut Params<'a>) -> Vec<(String, String)> {
        let text = params.string_opt(self.diagnostics, "aovs").unwrap_or_default();
        let mut layers = Vec::new();
        for item in text.split(',').map(str::trim).filter(|item| !item.is_empty()) {
            let span = params.span_of("aovs");
            match item.split_once(':').map(|(name, quantity)| (name.trim(), quantity.trim())) {
                Some((name, quantity)) if LAYERS.contains(&quantity) => layers.push((name.to_owned(), quantity.to_owned())),
                Some((_, quantity)) => {
                    let error = self.diagnostics.error(span, format!("unknown quantity `{quantity}` in `aovs`"));
                    if let Some(near) = nearest(quantity, LAYERS.iter().copied()) {
                        error.help(format!("did you mean `{near}`?"));
                    }
                    error.help(format!("known: {}", LAYERS.join(", ")));
                }
                None => drop(self.diagnostics.error(span, format!("`{item}` in `aovs` is not of the form `name:quantity`"))),
            }
        }
        layers
    }
}
