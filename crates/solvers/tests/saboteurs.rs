//! Saboteurs: a path tracer with one deliberate fault at a time. The same checks that the proofs use must hold for it without a fault, and
//! must refute it with each.
//!
//! A check that lets a fault pass is a hole in the proof.

mod common;

use common::checks::{
    agreement, at_point, closed_form, closed_form_by, floor, fresnel, furnace, furnace_scene, polygon_irradiance,
};
use common::*;
use etendue_accel::Hit;
use etendue_film::{Film, FilmShape, Splat};
use etendue_numerics::kernel::Kernel;
use etendue_numerics::{Pdf, Sampler, Spectrum, Vec2};
use etendue_scene::{Interaction, Scene};
use etendue_solvers::PathRules;
use etendue_solvers::path::Path;
use etendue_solvers::transport::{
    Context, Heuristic, PathSolver, PathState, ShadowQuery, Step, Vertex, VertexSample, mis_weight, slot,
};
use std::f64::consts::PI;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    /// The control.
    Faultless,
    /// f Le V / p, without cosθ.
    LostCosine,
    /// The light's density halved: its light doubled.
    HalvedPdf,
    /// One of n lights chosen, without division by the probability of the choice.
    LightWithoutItsProbability,
    /// Light that the walk hits counts in full.
    MisOffForTheWalk,
    /// Light that is sampled counts in full.
    MisOffForTheLight,
    /// Light counts in full twice.
    LeTwice,
    /// A refraction's weight not divided by η².
    EtaSquaredDropped,
    /// Survivors of roulette are not paid.
    RouletteUncompensated,
    /// Lights without extent are not sampled.
    DeltaLightsMissing,
    /// Lamps shine from their backs as well.
    EmissionFromTheBack,
    /// Shadow rays end at null surfaces.
    NullOpaqueInShadows,
    /// Shadow rays are not cast.
    NoShadows,
    /// One bounce too many.
    OneBounceTooMany,
    /// f = ρ instead of ρ/π.
    DiffuseWithoutPi,
    /// The cosine at the surface is taken where the light's is meant, in the density of the walk against the light's.
    MisInTheWrongMeasure,
}

use Fault::*;

const FAULTS: [Fault; 15] = [
    LostCosine,
    HalvedPdf,
    LightWithoutItsProbability,
    MisOffForTheWalk,
    MisOffForTheLight,
    LeTwice,
    EtaSquaredDropped,
    RouletteUncompensated,
    DeltaLightsMissing,
    EmissionFromTheBack,
    NullOpaqueInShadows,
    NoShadows,
    OneBounceTooMany,
    DiffuseWithoutPi,
    MisInTheWrongMeasure,
];

/// path-mis, with a fault.
struct Saboteur(Fault);

impl Saboteur {
    fn is(&self, fault: Fault) -> bool {
        self.0 == fault
    }

    fn le(&self, c: &Context<'_>, state: &PathState, x: Option<&Interaction>) -> (Spectrum, f32) {
        let Some(x) = x else {
            return (c.scene.le_escaped(&state.ray, &state.wl), c.scene.pdf_light_escaped(&state.from, state.ray.d));
        };
        let front = c.scene.le(x, &state.wl);
        if front.is_zero() && self.is(EmissionFromTheBack) {
            return (c.scene.le(&Interaction { wo: -x.wo, ..*x }, &state.wl), 0.0);
        }
        (front, c.scene.pdf_light(&state.from, x))
    }

    fn light(&self, c: &Context<'_>, state: &PathState, vertex: &Vertex, u: &Sampler) -> Option<ShadowQuery> {
        let edges = state.edges + 1;
        if !vertex.is_smooth() || edges > c.rules.max_edges {
            return None;
        }
        let (u_light, u_point) = (u.u1(state.dim(slot::LIGHT)), u.u2(state.dim(slot::LIGHT_POINT)));
        let light = c.scene.sample_light(&vertex.light_reference(), u_light, u_point, &state.wl)?;
        let (mut f_cos, pdf_bsdf) = vertex.eval(light.wi);
        if self.is(LostCosine) {
            f_cos /= vertex.x.shading.to_local(light.wi).z.abs();
        }
        if self.is(DiffuseWithoutPi) {
            f_cos *= std::f32::consts::PI;
        }
        let share = match light.pdf {
            Pdf::Delta(_) if self.is(DeltaLightsMissing) => return None,
            Pdf::Delta(_) => 1.0,
            _ if self.is(MisOffForTheLight) || self.is(LeTwice) => 1.0,
            Pdf::SolidAngle(p) => mis_weight(Heuristic::Power, p, pdf_bsdf),
        };
        let mut contribution = state.beta.carry(f_cos * light.le) * (share / light.pdf.value());
        if self.is(HalvedPdf) {
            contribution *= 2.0;
        }
        if self.is(LightWithoutItsProbability) {
            contribution *= 1.0 / c.scene.emitters.len() as f32;
        }
        let mut ray = light.shadow_ray(&vertex.x)?;
        if self.is(NoShadows) {
            ray.t_max = 1e-6;
        }
        if self.is(NullOpaqueInShadows) && c.scene.transmittance(&ray, u32::MAX, &state.wl).is_some_and(|t| t.passed > 0) {
            return None;
        }
        Some(ShadowQuery { ray, contribution, edges })
    }

    fn turn(&self, c: &Context<'_>, state: &mut PathState, vertex: &Vertex, sample: Option<VertexSample>, u: f32) -> bool {
        let Some(s) = sample else { return false };
        state.beta.scatter(s.weight);
        if self.is(EtaSquaredDropped) {
            state.beta.scatter(Spectrum::splat(s.eta_scale));
        }
        state.eta_scale *= s.eta_scale;
        state.ray = vertex.x.spawn(s.wi);
        if s.is_null {
            state.edges += u32::from(c.rules.null_counts);
        } else {
            state.edges += 1;
            state.pdf = s.pdf;
            state.from = vertex.light_reference();
        }
        let survives = if state.vertex < c.rules.rr_depth {
            true
        } else {
            let q = (state.beta.max_lane() * state.eta_scale).min(0.95);
            if u < q && !self.is(RouletteUncompensated) {
                state.beta.divide(q);
            }
            u < q
        };
        state.vertex += 1;
        survives && !state.beta.is_zero() && state.edges <= c.rules.max_edges
    }
}

impl PathSolver for Saboteur {
    fn scatter(&self, c: &Context<'_>, state: &mut PathState, hit: Option<Hit>, u: &Sampler) -> Step {
        let mut c = *c;
        if self.is(OneBounceTooMany) {
            c.rules.max_edges = c.rules.max_edges.saturating_add(1);
        }
        let x = hit.map(|hit| c.scene.interaction(&state.ray, &hit));
        let (le, pdf_light) = self.le(&c, state, x.as_ref());
        let share = match state.pdf {
            Pdf::Delta(_) => 1.0,
            _ if self.is(MisOffForTheWalk) || self.is(LeTwice) => 1.0,
            // Per area instead of per solid angle.
            Pdf::SolidAngle(p) if self.is(MisInTheWrongMeasure) => {
                let per_area = x.map_or(1.0, |x| x.n.dot(x.wo).abs() / (x.t * x.t));
                mis_weight(Heuristic::Power, p * per_area, pdf_light)
            }
            Pdf::SolidAngle(p) => mis_weight(Heuristic::Power, p, pdf_light),
        };
        state.collect(&c.rules, le * share);
        let Some(x) = x.filter(|_| !c.ends(state)) else { return Step::END };
        let vertex = Vertex::new(c.scene, x, &state.wl);
        let shadow = self.light(&c, state, &vertex, u);
        let u_lobe = u.u2(state.dim(slot::LOBE));
        let sample = vertex.sample(u_lobe.x, u.u2(state.dim(slot::BSDF)));
        Step { shadow, goes_on: self.turn(&c, state, &vertex, sample, u_lobe.y) }
    }
}

/// The scenes of the checks, and what holds in them.
struct Checks {
    furnace: Scene,
    quad: Scene,
    from_behind: Scene,
    point: Scene,
    screened: Scene,
    face: Scene,
    two_lamps: Scene,
    reference: Vec<Picture>,
}

impl Checks {
    fn new() -> Self {
        let lamp = |look: &str, extra: &str| {
            format!(
                r#"<shape type="rectangle">{extra}<transform name="to_world"><lookat {look} up="0, 1, 0"/></transform>{}{}</shape>"#,
                diffuse(0.0),
                area("2")
            )
        };
        let down = r#"origin="0, 0, 2" target="0, 0, 0""#;
        let on_floor = |more: &str| scene(&format!("{}{}{more}", at_point("4, 0, 1.5", "0.3, 0.4, 0"), floor(0.5)));
        let point =
            r#"<emitter type="point"><point name="position" value="0.3, 0.4, 2"/><rgb name="intensity" value="3"/></emitter>"#;
        let null =
            r#"<shape type="rectangle"><transform name="to_world"><translate z="1"/></transform><bsdf type="null"/></shape>"#;
        let face = r#"<shape type="rectangle"><transform name="to_world"><scale value="50"/></transform>
            <bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf></shape>"#;
        let below = r#"<shape type="rectangle"><transform name="to_world"><scale value="50"/><translate z="-3"/></transform>"#;
        let two_lamps = scene(&format!(
            r#"{}
            <shape type="rectangle"><transform name="to_world"><scale value="3"/></transform>{}</shape>
            <shape type="sphere"><point name="center" value="0, 0.3, 0.5"/><float name="radius" value="0.5"/>
                <bsdf type="roughconductor"><float name="alpha" value="0.3"/></bsdf></shape>
            <shape type="sphere"><point name="center" value="-1.2, 0, 1.2"/><float name="radius" value="0.5"/>{}</shape>{}"#,
            camera("0, -4, 3", "0, 0, 0.3", "0, 0, 1", 40.0, [8, 8]),
            diffuse(0.6),
            area("4, 3, 2"),
            lamp(r#"origin="1.5, 0, 2" target="0, 0, 0""#, "")
        ));
        Self {
            furnace: furnace_scene([0.5; 3]),
            quad: on_floor(&lamp(down, "")),
            from_behind: on_floor(&lamp(down, r#"<boolean name="flip_normals" value="true"/>"#)),
            point: on_floor(point),
            screened: on_floor(&format!("{null}{}", lamp(down, ""))),
            face: scene(&format!("{}{face}{below}{}{}</shape>", at_point("0, 0, 5", "0, 0, 0"), diffuse(0.0), area("2"))),
            reference: replicates(&two_lamps, &Path, samples(256).seed(7)),
            two_lamps,
        }
    }

    /// All claims about a solver.
    fn of(&self, solver: &Saboteur) -> Family {
        let mut family = Family::default();
        for bounces in [Some(0), Some(2), None] {
            furnace(&mut family, "furnace", solver, (&self.furnace, 0.5), bounces, 24, 0.05);
        }
        let corners = [[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0]];
        let quad = 0.5 / PI * 2.0 * polygon_irradiance([0.3, 0.4, 0.0], &corners);
        closed_form(&mut family, "quad", &self.quad, solver, quad, 32, 0.1);
        closed_form(&mut family, "quad from behind", &self.from_behind, solver, 0.0, 32, 0.1);
        closed_form(&mut family, "quad behind a null surface", &self.screened, solver, quad, 32, 0.1);
        closed_form(&mut family, "point", &self.point, solver, 0.5 / PI * 3.0 / 4.0, 1, 1e-4);
        let t = 1.0 - fresnel(1.0, 1.5);
        closed_form(&mut family, "glass face", &self.face, solver, 2.0 * t / (1.5 * 1.5), 256, 0.05);
        let pictures = replicates(&self.two_lamps, solver, samples(32));
        agreement(&mut family, "two lamps", &self.two_lamps, &pictures, &self.reference, 0.5);
        family
    }
}

#[test]
fn every_fault_is_caught() {
    let checks = Checks::new();
    checks.of(&Saboteur(Faultless)).must_hold();
    for fault in FAULTS {
        let failures = checks.of(&Saboteur(fault)).failures();
        assert!(!failures.is_empty(), "{fault:?} goes unseen");
    }
}

/// Masks with a limited depth: what the walk may pass the shadow ray may pass, to the edge.
#[test]
fn a_null_surface_that_is_no_edge_is_passed_by_the_last_edge_too() {
    // The fault that this check once found: walks whose edges were spent ended at null surfaces, while shadow rays went on.
    let lamp = scene(&format!(
        r#"{}{}<shape type="rectangle"><transform name="to_world"><translate z="1"/></transform><bsdf type="null"/></shape>
        <shape type="rectangle"><transform name="to_world"><lookat origin="0, 0, 2" target="0, 0, 0" up="0, 1, 0"/></transform>{}{}</shape>"#,
        at_point("4, 0, 1.5", "0.3, 0.4, 0"),
        floor(0.5),
        diffuse(0.0),
        area("2")
    ));
    let corners = [[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0]];
    let quad = 0.5 / PI * 2.0 * polygon_irradiance([0.3, 0.4, 0.0], &corners);
    let rules = PathRules { null_counts: false, max_edges: 2, ..PathRules::default() };
    let mut family = Family::default();
    closed_form_by(&mut family, "null", &lamp, &Saboteur(Faultless), quad, samples(64).with(rules), 0.05);
    family.must_hold();
}

/// The light that splats bring: their sum over the particles started.
fn splatted(start: impl Fn(&Film, u64)) -> f64 {
    let film = Film::new(FilmShape { size: [16, 16], kernel: Kernel::Gaussian { stddev: 0.5 } });
    for batch in 0..4u32 {
        let splat = |i: u32| Splat {
            position: Vec2::new(4.0 + (i % 8) as f32, 5.3 + (i / 8) as f32),
            value: Spectrum::splat(8.0),
            particle: u64::from(i),
        };
        film.add_splats(&(batch * 8..batch * 8 + 8).map(splat).collect::<Vec<_>>());
        start(&film, 16);
    }
    film.develop().iter().map(|p| f64::from(p[0])).sum()
}

/// Splats are divided by the particles started, those without a contribution included; neither by those that arrived nor not at all.
#[test]
fn splats_are_normalised() {
    let right = splatted(|film, n| film.start_particles(n));
    assert!((right - 32.0 * 8.0 / 64.0).abs() < 1e-4, "{right}");
    let by_arrived = splatted(|film, _| film.start_particles(8));
    assert!((by_arrived - right).abs() > 1.0);
    let counted_twice = splatted(|film, n| film.start_particles(2 * n));
    assert!((counted_twice - right).abs() > 1.0);
}
