//! How the samples' walks are joined: which connections there are, and which of them arrive.

use super::super::draw;
use super::super::vertices::LANES;
use super::join::{Inner, NextEvent, OfLamp, OfPinhole, ToLens};
use super::stage::Stage;
use super::{Pairs, Plain, Shadow, rgb};
use crate::bidirectional::light_path::emitting_point;
use crate::bidirectional::walk::{End, Walk};
use crate::transport::{PathState, Throughput, light_slot, slot};
use etendue_accel::Hit;
use etendue_numerics::{Dim, Pdf, Ray, Sampler, Spectrum, Vec2, Wavelengths, wide};
use etendue_scene::{LightQuery, LightSample, Scene};

impl Pairs {
    /// s = 0: the k-th ray, of lane i, hit a light.
    pub(super) fn hit(&mut self, plain: &Plain<'_>, i: usize, k: usize, hit: &Hit, edges: u32) {
        let (all, v) = (plain.all, &self.v);
        let mut beta = Throughput::ONE;
        beta.scatter(v.beta.spectrum(i));
        let x = all.c.scene.interaction(&self.rays[k], hit);
        let start = PathState::start(self.rays[k], Spectrum::ONE, Wavelengths::Rgb);
        let walk = Walk {
            c: &all.c,
            sides: &all.sides,
            heuristic: all.heuristic,
            end: End::Eye,
            state: PathState { beta, edges, vertex: edges, from: v.from(i), ..start },
            start: rgb(self.start.get(i)),
            trail: self.trails.get(i),
            parent: None,
            count: edges,
        };
        if let Some(f) = all.hit(&walk, &x) {
            self.l[i] += f.value * f.weight;
        }
    }

    /// s = 1: light samples at all y.
    pub(super) fn next_event<const SQUARE: bool>(&mut self, plain: &Plain<'_>, y: &Stage, address: u32, samplers: &[Sampler]) {
        let (scene, v, emitting) = (plain.all.c.scene, &mut self.v, &mut self.emitting);
        if !scene.lights.is_alone() {
            Sampler::u1_each(samplers, Dim::at(address, slot::LIGHT), &mut v.u_light);
        }
        draw(samplers, Dim::at(address, slot::LIGHT_POINT), &mut v.u_point);
        if let Some(lamp) = &plain.lone {
            emitting.density = [plain.lone_density; LANES];
            wide::widest(OfLamp { v, lamp, emitting });
        }
        let asks = |i: &usize| y.alive[*i] != 0 && plain.lone.as_ref().is_none_or(|lamp| lamp.is_near(v.p.get(*i)));
        let lanes: Vec<usize> = (0..samplers.len()).filter(asks).collect();
        let query =
            |i: &usize| LightQuery { from: v.from(*i), u_light: v.u_light[*i], u: Vec2::new(v.u_point[0][*i], v.u_point[1][*i]) };
        let queries: Vec<LightQuery> = lanes.iter().map(query).collect();
        let density = |s: &LightSample| {
            let z = emitting_point(scene, s.emitter, s.primitive, s.p, s.n, -s.wi);
            z.map_or(0.0, |z| scene.lights.pdf_emission(scene, &z).position.value())
        };
        scene.lights.sample_each(scene, &queries, &[], |k, sample| {
            let sample = sample.filter(|s| matches!(s.pdf, Pdf::SolidAngle(_)));
            v.set_light(lanes[k], sample.as_ref());
            if let Some(s) = &sample {
                emitting.n.set(lanes[k], s.n);
                emitting.density[lanes[k]] = density(s);
            }
        });
        wide::widest(NextEvent::<SQUARE> { y, light: &self.v.light, emitting: &self.emitting, joints: &mut self.joints });
        self.propose(y, false);
    }

    /// s, t ≥ 2: all y, so many edges from their end, with all z of which each walk has that many.
    pub(super) fn inner<const SQUARE: bool>(
        &mut self,
        plain: &Plain<'_>,
        y: &Stage,
        address: u32,
        lights: &[Box<Stage>],
        samplers: &[Sampler],
    ) {
        let all = plain.all;
        Sampler::u1_each(samplers, Dim::at(address, slot::WORTH), &mut self.u_worth);
        for (z, z_edges) in lights.iter().zip(1..).filter(|(_, z_edges)| all.may_count(address + z_edges + 1)) {
            let (joints, u_worth) = (&mut *self.joints, &*self.u_worth);
            wide::widest(Inner::<SQUARE> { y, z, count: z_edges + 1, u_worth, worth: all.worth, joints });
            self.propose(y, false);
        }
    }

    /// t = 1: all z look at the lens.
    pub(super) fn show<const SQUARE: bool>(&mut self, plain: &Plain<'_>, z: &Stage, address: u32, samplers: &[Sampler]) {
        let (all, lens) = (plain.all, &mut *self.lens);
        Sampler::u1_each(samplers, Dim::at(address, light_slot::WORTH), &mut self.u_worth);
        if let Some(pinhole) = plain.pinhole {
            let film = &all.view.film;
            let crop = [film.crop_offset, film.crop_size].map(|[x, y]| Vec2::new(x as f32, y as f32));
            wide::widest(OfPinhole { z, pinhole, crop, lens });
        } else {
            for (i, u) in samplers.iter().enumerate().filter(|(i, _)| z.alive[*i] != 0) {
                let seen = all.seen(z.p.get(i), address, u);
                lens.is_there[i] = u32::from(seen.is_some());
                if let Some(s) = &seen {
                    lens.wi.set(i, s.wi);
                    lens.p.set(i, s.p);
                    lens.we[i] = s.we / s.pdf.value();
                    (lens.pixel[0][i], lens.pixel[1][i]) = s.pixel.into();
                }
            }
        }
        let (joints, u_worth) = (&mut *self.joints, &*self.u_worth);
        wide::widest(ToLens::<SQUARE> { z, lens, eye: plain.center, u_worth, worth: all.worth, joints });
        self.propose(z, true);
    }

    /// Queues the connections that are there; they may be splats.
    fn propose(&mut self, stage: &Stage, splats: bool) {
        let (j, [x, y]) = (&self.joints, &self.lens.pixel);
        for i in (0..LANES).filter(|i| j.is_there[*i] != 0) {
            let ray = Ray { time: stage.times[i], ..Ray::new(j.shadow.o.get(i), j.shadow.d.get(i)).until(j.end[i]) };
            let pixel = splats.then(|| Vec2::new(x[i], y[i]));
            self.shadows.push(Shadow { ray, lane: i as u32, value: rgb(j.value.get(i)), pixel });
        }
    }

    /// V of all that was queued.
    pub(super) fn connect(&mut self, scene: &Scene, rays: &mut u64) {
        self.rays.clear();
        self.rays.extend(self.shadows.iter().map(|s| s.ray));
        *rays += self.rays.len() as u64;
        scene.occluded_each(&self.rays, &mut self.occluded);
        for (s, occluded) in self.shadows.drain(..).zip(&self.occluded) {
            if *occluded || s.value.is_zero() {
                continue;
            }
            match s.pixel {
                Some(pixel) => self.splats.push((s.lane, pixel, s.value)),
                None => self.l[s.lane as usize] += s.value,
            }
        }
    }
}
