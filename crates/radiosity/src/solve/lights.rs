//! E: irradiance of patches from lights that are no patches: points, spots, single directions, surroundings, and surfaces that cannot be cut.
//!
//! ```text
//! E_i = 1/A_i ∫_i Σ_lights ∫ Le V cosθ dwi dA  ≈  mean over points of Σ Le V cosθ / p
//! ```
//!
//! | samples a patch and light | |
//! | --- | --- |
//! | a light with one direction to each point | 16 points |
//! | others | 64 points with one direction each |

use super::rgb;
use crate::patch::Patches;
use etendue_numerics::{Dim, Sampler, SequenceKind, Wavelengths};
use etendue_scene::emitter::{Light, LightId, Model};
use etendue_scene::{EmitterId, LightReference, Scene};
use glam::DVec3;
use rayon::prelude::*;

/// Points for a light with one direction to each.
const POINTS: u32 = 16;

/// Points for any other.
const DIRECTIONS: u32 = 64;

/// Lights that are no patches, with the number of samples of each.
fn lights(scene: &Scene, patches: &Patches) -> Vec<(LightId, u32)> {
    let mut is_patch = vec![false; scene.surfaces.len()];
    patches.objects.iter().for_each(|o| is_patch[o.surface.index()] |= !o.patches.is_empty());
    let mut lights = Vec::new();
    for (i, emitter) in scene.emitters.iter().enumerate() {
        if matches!(&emitter.model, Model::Area(area) if is_patch[area.surface.index()]) {
            continue;
        }
        let samples = if emitter.is_delta() && !matches!(emitter.model, Model::Area(_)) { POINTS } else { DIRECTIONS };
        let id = |primitive| LightId { emitter: EmitterId(i as u32), primitive };
        lights.extend((0..emitter.model.primitive_count(scene)).map(|k| (id(k), samples)));
    }
    lights
}

/// E of all patches, W/m².
pub fn irradiance(scene: &Scene, patches: &Patches, seed: u64) -> Vec<DVec3> {
    let lights = lights(scene, patches);
    if lights.is_empty() {
        return vec![DVec3::ZERO; patches.len()];
    }
    let of_patch = |i: u32| -> DVec3 { lights.iter().map(|(id, samples)| of_light(scene, patches, i, *id, *samples, seed)).sum() };
    (0..patches.len() as u32).into_par_iter().with_min_len(16).map(of_patch).collect()
}

/// What one light gives to patch i.
fn of_light(scene: &Scene, patches: &Patches, i: u32, id: LightId, samples: u32, seed: u64) -> DVec3 {
    let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
    let key = u64::from(i) << 32 | u64::from(id.emitter.0) << 8 ^ u64::from(id.primitive);
    for k in 0..samples {
        let u = Sampler::new(SequenceKind::Sobol, seed, key, k, samples);
        let point = patches.sample(i, u.u2(Dim(0)));
        weights += point.weight;
        let x = patches.interaction(scene, i, point.st);
        let from = LightReference { p: x.p, n: point.n.as_vec3(), one_sided: true, shared: false };
        let Some(light) = scene.emitter(id.emitter).model.sample(scene, &from, id, u.u2(Dim(1)), &Wavelengths::Rgb) else {
            continue;
        };
        let cos = point.n.dot(light.wi.as_dvec3());
        if cos <= 0.0 {
            continue;
        }
        let arrives = light.shadow_ray(&x).and_then(|ray| scene.transmittance(&ray, u32::MAX, &Wavelengths::Rgb));
        if let Some(through) = arrives {
            sum += rgb(light.le * through.value) * (cos * point.weight / f64::from(light.pdf.value()));
        }
    }
    if weights > 0.0 { sum / weights } else { DVec3::ZERO }
}
