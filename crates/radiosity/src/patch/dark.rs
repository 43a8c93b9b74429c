//! Sides that no light reaches: the inside of a box of two-sided material, with a bottom or standing on a floor without one, of sheets as of one mesh.
//!
//! ```text
//! a side is dark        walks from all over it, turned back by what reflects and let through by what is transparent, meet no light and never leave the scene
//! ```
//!
//! B of such a side is zero. It is no patch, then, but absorbs like any other back; and the floor inside is covered ([`crate::cover`]). Else a patch of the
//! floor that lies under the rim of the box, half inside and half outside, would have one B for both, and take light of the room into the box and back.
//!
//! A side is taken for dark after [`WALKS`] walks of [`EDGES`] rays each: what enters by an opening that a ray in 10⁴ finds may be missed. Which sides were left out is
//! told ([`Fault::Dark`]).

use super::faults::{Facet, Fault};
use super::{ChartEntry, Object, Patches, Side};
use etendue_bsdf::Event;
use etendue_numerics::sequence::{mix, unit};
use etendue_numerics::warp::square_to_cosine_hemisphere;
use etendue_numerics::{Frame, Vec2, Vec3, Wavelengths};
use etendue_scene::emitter::{Light, LightId};
use etendue_scene::{EmitterId, Interaction, LightReference, NO_INSTANCE, Scene};
use glam::DVec2;
use rayon::prelude::*;

/// Walks from a side; a surface of more pieces is not asked, for some would not be.
const WALKS: usize = 2048;

/// Rays of a walk.
const EDGES: u64 = 16;

impl Patches {
    /// Takes dark sides from those that are patches.
    pub(super) fn leave_out_dark_sides(&mut self, scene: &Scene) {
        if scene.emitters.is_empty() {
            return;
        }
        let points: Vec<EmitterId> =
            (0..scene.emitters.len()).filter(|i| scene.emitters[*i].is_delta()).map(|i| EmitterId(i as u32)).collect();
        let asked = |o: &&Object| {
            o.instance == NO_INSTANCE && scene.surface(o.surface).emitter.is_none() && (1..=WALKS).contains(&o.charts.len())
        };
        let of_object = |o: &Object| {
            let charts = &self.charts[o.charts.start as usize..o.charts.end as usize];
            let sides = [Side::Front, Side::Back].into_iter().zip(self.sides[o.surface.index()]);
            let dark = sides.filter(|(side, is_patch)| *is_patch && self.is_dark(scene, &points, charts, *side));
            dark.map(|(side, _)| (o.surface, side)).collect::<Vec<_>>()
        };
        let objects: Vec<&Object> = self.objects.iter().filter(asked).collect();
        let dark: Vec<_> = objects.into_par_iter().flat_map_iter(of_object).collect();
        for (surface, side) in dark {
            self.sides[surface.index()][usize::from(side == Side::Back)] = false;
            self.faults.push(Fault::Dark { first: Facet { surface, facet: 0 }, side });
        }
    }

    /// Whether no walk from a side finds light.
    fn is_dark(&self, scene: &Scene, points: &[EmitterId], charts: &[ChartEntry], side: Side) -> bool {
        (0..WALKS).all(|k| {
            let number = |i: u64| unit(mix(mix(k as u64 + 1) + i) as u32);
            let entry = &charts[k % charts.len()];
            // Clear of edges, which sheets have in common only to rounding.
            let u = DVec2::new(number(0).into(), number(1).into()) * 0.98 + 0.01;
            let st = if entry.chart.is_triangle() && u.element_sum() > 1.0 { 1.0 - u } else { u };
            let n = entry.chart.normal(st).as_vec3() * side.sign() as f32;
            !finds_light(scene, points, self.look_at(scene, entry, st, side), n, |i| number(2 + i))
        })
    }
}

/// Whether a walk from x on the side of n meets a lamp, sees one of the `points`, or leaves the scene.
fn finds_light(scene: &Scene, points: &[EmitterId], mut x: Interaction, mut n: Vec3, number: impl Fn(u64) -> f32) -> bool {
    let mut through = None;
    for k in 0..EDGES {
        let u = |i: u64| number(5 * k + i);
        let w =
            through.take().unwrap_or_else(|| Frame::from_normal(n).to_world(square_to_cosine_hemisphere(Vec2::new(u(0), u(1)))));
        let point = points.get((u(2) * points.len() as f32) as usize);
        if point.is_some_and(|id| sees(scene, &x, n, *id, Vec2::new(u(3), u(4)))) {
            return true;
        }
        let ray = x.spawn(w);
        let Some(hit) = scene.intersect(&ray) else { return true };
        x = scene.interaction(&ray, &hit);
        let surface = scene.surface(x.surface);
        if surface.emitter.is_some() {
            return true;
        }
        n = if x.n.dot(w) > 0.0 { -x.n } else { x.n };
        if scene.material(surface.material).events().intersects(Event::TRANSMIT.with(Event::NULL)) {
            through = Some(w);
        }
    }
    false
}

/// Whether light of a point, or from a single direction, arrives at x.
fn sees(scene: &Scene, x: &Interaction, n: Vec3, emitter: EmitterId, u: Vec2) -> bool {
    let from = LightReference { p: x.p, n, one_sided: true, shared: false };
    let light = scene.emitter(emitter).model.sample(scene, &from, LightId { emitter, primitive: 0 }, u, &Wavelengths::Rgb);
    let ray = light.filter(|l| l.wi.dot(n) > 0.0).and_then(|l| l.shadow_ray(x));
    ray.is_some_and(|ray| scene.transmittance(&ray, u32::MAX, &Wavelengths::Rgb).is_some())
}
