//! The lights one by one: where light is a sum over all of them, not one chosen for all.
//!
//! ```text
//! L_direct = Σ_k f cosθ Le(y_k) V / p_k,    p_k = P(primitive | light k) p(wi | primitive)
//! ```
//!
//! A light's primitives (the triangles of a mesh) are chosen with probability ∝ Φ.

use etendue_numerics::math::ONE_MINUS_EPSILON;
use etendue_numerics::table::Table1D;
use etendue_numerics::{Pdf, Vec2, Wavelengths};
use etendue_scene::emitter::{Light, LightId};
use etendue_scene::{EmitterId, LightReference, LightSample, Scene};

/// All lights of a scene.
#[derive(Clone, Debug, Default)]
pub struct EachLight(Vec<OneLight>);

#[derive(Clone, Debug)]
struct OneLight {
    emitter: EmitterId,
    /// The choice of a primitive, where there are several.
    primitives: Option<Table1D>,
}

impl EachLight {
    /// The lights of `scene`.
    pub fn new(scene: &Scene) -> Self {
        let count = |id: EmitterId| scene.emitter(id).primitive_count(scene);
        let ids = (0..scene.emitters.len() as u32).map(EmitterId).filter(|id| count(*id) > 0);
        Self(ids.map(|id| OneLight { emitter: id, primitives: (count(id) > 1).then(|| by_flux(scene, id, count(id))) }).collect())
    }

    /// Number of lights.
    pub fn len(&self) -> u32 {
        self.0.len() as u32
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A point of light number `k`: `u_light` chooses its primitive, `u` the point on it.
    pub fn sample(
        &self,
        scene: &Scene,
        k: u32,
        from: &LightReference,
        u_light: f32,
        u: Vec2,
        wl: &Wavelengths,
    ) -> Option<LightSample> {
        let light = self.0.get(k as usize)?;
        let (primitive, chosen) = match &light.primitives {
            Some(table) => {
                let (i, p, _) = table.sample_discrete(u_light.min(ONE_MINUS_EPSILON));
                (i as u32, p)
            }
            None => (0, 1.0),
        };
        let id = LightId { emitter: light.emitter, primitive };
        let sample = scene.emitter(light.emitter).model.sample(scene, from, id, u, wl)?;
        let pdf = match sample.pdf {
            Pdf::SolidAngle(p) => Pdf::SolidAngle(p * chosen),
            Pdf::Delta(p) => Pdf::Delta(p * chosen),
        };
        Some(LightSample { pdf, ..sample })
    }
}

fn by_flux(scene: &Scene, id: EmitterId, count: u32) -> Table1D {
    let model = &scene.emitter(id).model;
    let flux: Vec<f32> = (0..count).map(|i| model.power_of(scene, i).max_lane()).collect();
    // The flux of textured primitives is known from a few points of each: none is left without its chance.
    let least = 0.02 * flux.iter().sum::<f32>() / count as f32;
    Table1D::new(&flux.iter().map(|x| x.max(least)).collect::<Vec<_>>())
}
