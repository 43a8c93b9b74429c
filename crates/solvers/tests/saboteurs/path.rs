//! A path tracer with one deliberate fault at a time.

use etendue_accel::Hit;
use etendue_numerics::{Pdf, Sampler, Spectrum};
use etendue_scene::Interaction;
use etendue_solvers::transport::{
    Context, Heuristic, PathSolver, PathState, ShadowQuery, Step, Vertex, VertexSample, mis_weight, slot,
};

faults! {
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

/// path-mis, with a fault.
pub struct Saboteur(pub Fault);

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
        state.roulette_scale *= s.eta_scale;
        state.ray = vertex.x.spawn(s.wi);
        if s.is_null {
            state.edges += u32::from(c.rules.null_counts);
        } else {
            state.edges += 1;
            state.pdf = s.pdf;
            state.from = vertex.light_reference();
        }
        let survives = if state.vertex < c.rules.rr_depth() {
            true
        } else {
            let q = (state.beta.max_lane() * state.roulette_scale).min(0.95);
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
