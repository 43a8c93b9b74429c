//! E at a point of space on a plane that faces n, as a light meter lies there.
//!
//! ```text
//! E = Σ_lights Le V cosθ / p  +  π L'(RT(x, w)),      w with density cosθ/π,   L' = light that was reflected at least once
//! ```
//!
//! L' comes from a walk ([`crate::path_mis`]), or from a solution of the radiosity equation. Error bars come from [`REPLICATES`] scramblings.

use crate::path_mis::PathMis;
use crate::radiosity::{Look, Shown};
use crate::transport::{Context, PathRules, PathState, slot, trace};
use etendue_numerics::math::PI;
use etendue_numerics::warp::square_to_cosine_hemisphere;
use etendue_numerics::{Dim, Frame, Ray, Sampler, SequenceKind, Spectrum, Vec3, Wavelengths};
use etendue_scene::interaction::SHADOW_EPSILON;
use etendue_scene::{LightReference, Scene};
use rayon::prelude::*;

/// Independent estimates.
pub const REPLICATES: u32 = 16;

/// Where a meter lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meter {
    /// The point, m.
    pub p: Vec3,
    /// The unit normal of its plane.
    pub n: Vec3,
}

/// Where reflected light comes from.
#[derive(Clone, Copy)]
pub enum Reflected<'a> {
    /// Walks.
    Path,
    /// A solution, made ready with [`crate::radiosity::Show::Gather`].
    Solution(&'a Shown),
}

/// E of every meter, W/m², [`REPLICATES`] times, each of `samples` rays.
pub fn irradiance(scene: &Scene, meters: &[Meter], from: Reflected<'_>, samples: u32, seed: u64) -> Vec<Vec<[f64; 3]>> {
    let of = |k: usize| {
        (0..REPLICATES)
            .map(|r| one(scene, &meters[k], from, samples, seed, k as u64 * u64::from(REPLICATES) + u64::from(r)))
            .collect()
    };
    (0..meters.len()).into_par_iter().map(of).collect()
}

fn one(scene: &Scene, meter: &Meter, from: Reflected<'_>, samples: u32, seed: u64, stream: u64) -> [f64; 3] {
    let rules = PathRules { min_edges: 2, ..PathRules::default() };
    let c = Context { scene, rules };
    let frame = Frame::from_normal(meter.n);
    let mut sum = [0.0; 3];
    for k in 0..samples.max(1) {
        let u = Sampler::new(SequenceKind::Sobol, seed, stream, k, samples.max(1));
        let wl = scene.wavelengths(|| u.u1(Dim::at(0, slot::WAVELENGTHS)));
        let mut e = wl.to_rgb(direct(&c, meter, &u, &wl));
        let w = frame.to_world(square_to_cosine_hemisphere(u.u2(Dim::at(0, slot::BSDF))));
        let eye = PathState::start(Ray::new(meter.p, w), Spectrum::ONE, wl);
        e += match from {
            Reflected::Path => wl.to_rgb(trace(&PathMis::default(), &c, eye, &u, &mut 0) * PI),
            Reflected::Solution(shown) => Look(shown).leaving_towards(scene, eye.ray),
        };
        sum.iter_mut().zip(e.to_rgb()).for_each(|(s, e)| *s += f64::from(e));
    }
    sum.map(|s| s / f64::from(samples.max(1)))
}

/// What a point on a light gives.
fn direct(c: &Context<'_>, meter: &Meter, u: &Sampler, wl: &Wavelengths) -> Spectrum {
    let from = LightReference { p: meter.p, n: meter.n, one_sided: true, shared: false };
    let (u_light, u_point) = (u.u1(Dim::at(0, slot::LIGHT)), u.u2(Dim::at(0, slot::LIGHT_POINT)));
    let Some(light) = c.scene.sample_light(&from, u_light, u_point, wl) else { return Spectrum::ZERO };
    let cos = meter.n.dot(light.wi);
    if cos <= 0.0 {
        return Spectrum::ZERO;
    }
    let ray = Ray::new(meter.p, light.wi);
    let ray = if light.distance.is_finite() { ray.until(light.distance * (1.0 - SHADOW_EPSILON)) } else { ray };
    match c.scene.transmittance(&ray, u32::MAX, wl) {
        Some(through) => light.le * through.value * (cos / light.pdf.value()),
        None => Spectrum::ZERO,
    }
}
