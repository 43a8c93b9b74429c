//! Next event estimation: one light point sampled at a vertex.
//!
//! ```text
//! f(wi, x, wo) |cosθ| Le(y → x) V(x, y) / p(wi)
//! ```

use super::{Context, PathState, Vertex, slot};
use etendue_numerics::{Pdf, Ray, Sampler, Spectrum};
use etendue_scene::LightSample;

/// A segment whose transmittance decides what arrives.
#[derive(Clone, Copy, Debug)]
pub struct ShadowQuery {
    /// From the vertex to just before the light.
    pub ray: Ray,
    /// What is added to the picture if nothing is in between, throughput included.
    pub contribution: Spectrum,
    /// Edges of the whole path, null surfaces in between not counted.
    pub edges: u32,
}

/// The connection to a sampled light point; `weight(p_light, p_bsdf)` is its share against a walk that hits the same point
/// (1 where no walk counts it).
#[inline]
pub fn next_event(
    c: &Context<'_>,
    state: &PathState,
    vertex: &Vertex,
    u: &Sampler,
    weight: impl Fn(f32, f32) -> f32,
) -> Option<ShadowQuery> {
    if !vertex.is_smooth() || state.edges >= c.rules.max_edges {
        return None;
    }
    let from = vertex.light_reference();
    let u_light = if c.scene.lights.is_alone() { 0.0 } else { u.u1(state.dim(slot::LIGHT)) };
    let u_point = u.u2(state.dim(slot::LIGHT_POINT));
    let light = c.scene.sample_light(&from, u_light, u_point, &state.wl);
    connection(state, vertex, light.as_ref()?, weight)
}

/// The connection to the light point `light`; `weight` as in [`next_event`].
#[inline]
pub fn connection(
    state: &PathState,
    vertex: &Vertex,
    light: &LightSample,
    weight: impl Fn(f32, f32) -> f32,
) -> Option<ShadowQuery> {
    connection_of(state, vertex, light, vertex.eval(light.wi), weight)
}

/// The same where f cosθ and p of the BSDF are known.
#[inline]
pub fn connection_of(
    state: &PathState,
    vertex: &Vertex,
    light: &LightSample,
    (f_cos, pdf_bsdf): (Spectrum, f32),
    weight: impl Fn(f32, f32) -> f32,
) -> Option<ShadowQuery> {
    if f_cos.is_zero() || light.le.is_zero() {
        return None;
    }
    let share = match light.pdf {
        Pdf::Delta(_) => 1.0,
        Pdf::SolidAngle(p) => weight(p, pdf_bsdf),
    };
    let contribution = state.beta.carry(f_cos * light.le) * (share / light.pdf.value());
    Some(ShadowQuery { ray: light.shadow_ray(&vertex.x)?, contribution, edges: state.edges + 1 })
}
