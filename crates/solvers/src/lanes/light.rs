//! Points on the lights, on lanes where there is but one lamp: `Scene::sample_light`.

use super::vertices::{Lights, Vertices};
use crate::transport::Context;
use etendue_numerics::{Vec2, Wavelengths, wide};
use etendue_scene::emitter::LonePoint;
use etendue_scene::{LightQuery, Lone};

/// Chooses a light point for each vertex.
pub(super) fn sample(c: &Context<'_>, v: &mut Vertices, lone: Option<&Lone>) {
    if let Some(lamp) = lone {
        wide::widest(OfLamp { v, lamp });
        for (i, wl) in v.wl.iter().enumerate() {
            v.light.le.set_spectrum(i, lamp.radiance.at(wl));
        }
    }
    // Those that stand near the lamp, or all.
    let asks = |i: &usize| lone.is_none_or(|lamp| lamp.is_near(v.p.get(*i)));
    let lanes: Vec<usize> = (0..v.count()).filter(asks).collect();
    let query =
        |i: &usize| LightQuery { from: v.from(*i), u_light: v.u_light[*i], u: Vec2::new(v.u_point[0][*i], v.u_point[1][*i]) };
    let queries: Vec<LightQuery> = lanes.iter().map(query).collect();
    let wl: Vec<Wavelengths> = lanes.iter().filter_map(|i| v.wl.get(*i)).copied().collect();
    c.scene.lights.sample_each(c.scene, &queries, &wl, |k, sample| v.set_light(lanes[k], sample.as_ref()));
}

struct OfLamp<'a> {
    v: &'a mut Vertices,
    lamp: &'a Lone,
}

impl wide::Job for OfLamp<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let v = self.v;
        for i in 0..v.lanes() {
            let point = self.lamp.sample(v.p.get(i), Vec2::new(v.u_point[0][i], v.u_point[1][i]));
            put(&mut v.light, i, self.lamp, &point);
        }
    }
}

/// Notes a point on the lamp.
#[inline(always)]
pub(super) fn put(light: &mut Lights, i: usize, lamp: &Lone, point: &LonePoint) {
    light.wi.set(i, point.wi);
    light.p.set(i, point.p);
    light.le.set_spectrum(i, lamp.le);
    light.pdf[i] = point.pdf;
    (light.is_delta[i], light.is_near[i]) = (0, 1);
    light.is_there[i] = u32::from(point.is_there);
}
