//! How walks from both ends are joined, on lanes: `bidirectional::connect`.

use super::super::light;
use super::super::vertices::{Flags, LANES, Lane, Lane3, Lights, Rays, Vertices};
use super::stage::{Stage, is_something, power};
use crate::bidirectional::Strategies;
use crate::bidirectional::eye::Center;
use crate::bidirectional::worth::Worth;
use etendue_numerics::math::FRAC_1_PI;
use etendue_numerics::ray::offset_origin;
use etendue_numerics::{Vec2, Vec3, wide};
use etendue_scene::Lone;
use etendue_scene::interaction::SHADOW_EPSILON;
use etendue_scene::sensor::Perspective;

/// Connections, a sample a lane.
pub(super) struct Joints {
    /// Whether there is one that is worth a shadow ray.
    pub is_there: Flags,
    /// w C, were nothing in between; larger where few are cast.
    pub value: Lane3,
    pub shadow: Rays,
    pub end: Lane,
}

impl Joints {
    pub fn new() -> Box<Self> {
        let (three, one) = (Lane3::ZERO, [0.0; LANES]);
        let shadow = Rays { o: three, d: three };
        Box::new(Self { is_there: [0; LANES], value: three, shadow, end: one })
    }

    /// `Interaction::spawn_to`.
    #[inline(always)]
    fn aim(&mut self, i: usize, stage: &Stage, q: Vec3) {
        let p = stage.p.get(i);
        let o = offset_origin(p, stage.p_error.get(i), stage.n.get(i), q - p);
        let d = q - o;
        let distance = d.length();
        self.shadow.o.set(i, o);
        self.shadow.d.set(i, d / distance);
        self.end[i] = distance * (1.0 - SHADOW_EPSILON);
        self.is_there[i] &= u32::from((distance > 0.0) & (distance < f32::INFINITY));
    }
}

/// What the weights know of light samples: normals of the light, and p_E of its points.
pub(super) struct Emitting {
    pub n: Lane3,
    pub density: Lane,
}

/// Points on a lone lamp for all vertices.
pub(super) struct OfLamp<'a> {
    pub v: &'a mut Vertices,
    pub lamp: &'a Lone,
    pub emitting: &'a mut Emitting,
}

impl wide::Job for OfLamp<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let v = self.v;
        for i in 0..LANES {
            let point = self.lamp.sample(v.p.get(i), Vec2::new(v.u_point[0][i], v.u_point[1][i]));
            light::put(&mut v.light, i, self.lamp, &point);
            self.emitting.n.set(i, point.n);
        }
    }
}

/// s = 1: light samples at y.
pub(super) struct NextEvent<'a, const SQUARE: bool> {
    pub y: &'a Stage,
    pub light: &'a Lights,
    pub emitting: &'a Emitting,
    pub joints: &'a mut Joints,
}

impl<const SQUARE: bool> wide::Job for NextEvent<'_, SQUARE> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (y, light, out) = (self.y, self.light, self.joints);
        for i in 0..LANES {
            let (wi, le, pdf) = (light.wi.get(i), light.le.rgb(i), light.pdf[i]);
            let height = y.height(i, wi);
            let f_cos = y.rho.get(i) * FRAC_1_PI * height;
            let contribution = y.beta.get(i) * f_cos * le / pdf;

            let n = self.emitting.n.get(i);
            let leaves = -n.dot(wi);
            let emitted = self.emitting.density[i] * (leaves.max(0.0) * FRAC_1_PI) * y.n.get(i).dot(wi).abs() / leaves.abs();
            let hit = power::<SQUARE>(height * FRAC_1_PI, pdf);
            let others = hit + y.others::<SQUARE>(i, emitted / pdf, y.way_back(i));
            out.value.set(i, contribution * (1.0 / (1.0 + others)));
            let scatters = (y.above[i] > 0.0) & (height > 0.0) & is_something(f_cos);
            out.is_there[i] = y.alive[i] & light.is_there[i] & u32::from(scatters);
        }
        for i in 0..LANES {
            out.aim(i, y, light.p.get(i));
        }
    }
}

/// s, t ≥ 2: y and z.
pub(super) struct Inner<'a, const SQUARE: bool> {
    pub y: &'a Stage,
    pub z: &'a Stage,
    /// s.
    pub count: u32,
    /// The numbers of y that decide which are worth it.
    pub u_worth: &'a Lane,
    pub worth: Worth,
    pub joints: &'a mut Joints,
}

impl<const SQUARE: bool> wide::Job for Inner<'_, SQUARE> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (y, z, out) = (self.y, self.z, self.joints);
        for i in 0..LANES {
            let d = z.p.get(i) - y.p.get(i);
            let r2 = d.length_squared();
            let w = d / r2.sqrt();
            let (up_y, up_z) = (y.height(i, w), z.height(i, -w));
            let at_y = y.rho.get(i) * FRAC_1_PI * up_y;
            let at_z = z.rho.get(i) * FRAC_1_PI * z.adjoint_cos(i, -w);
            let contribution = (y.beta.get(i) * at_y) * (z.beta.get(i) * at_z) / r2;

            let (to_y, to_z) = (y.n.get(i).dot(w).abs() / r2, z.n.get(i).dot(w).abs() / r2);
            let more_light = y.others::<SQUARE>(i, up_z * FRAC_1_PI * to_y, y.way_back(i));
            let more_eye = z.others::<SQUARE>(i, up_y * FRAC_1_PI * to_z, z.way_back(i));
            let weight = 1.0 / (1.0 + (more_light + more_eye));
            let (grown, is_worth_it) =
                self.worth.decide_at_once(contribution * weight, Strategies::number_of_worth(self.u_worth[i], self.count));
            out.value.set(i, contribution * grown * weight);
            let faces = (y.above[i] > 0.0) & (z.above[i] > 0.0) & (up_y > 0.0) & (up_z > 0.0);
            out.is_there[i] = y.alive[i] & z.alive[i] & u32::from(faces & is_something(at_y) & is_something(at_z) & is_worth_it);
        }
        for i in 0..LANES {
            let q = offset_origin(z.p.get(i), z.p_error.get(i), z.n.get(i), y.p.get(i) - z.p.get(i));
            out.aim(i, y, q);
        }
    }
}

/// The lens as the vertices see it: `SensorSample`.
pub(super) struct Lens {
    pub is_there: Flags,
    pub wi: Lane3,
    pub p: Lane3,
    /// We / p.
    pub we: Lane,
    /// Where on the full film, in pixels.
    pub pixel: [Lane; 2],
}

/// A pinhole as the vertices see it: `Strategies::seen`.
pub(super) struct OfPinhole<'a> {
    pub z: &'a Stage,
    pub pinhole: &'a Perspective,
    /// First pixel of the crop, and its size.
    pub crop: [Vec2; 2],
    pub lens: &'a mut Lens,
}

impl wide::Job for OfPinhole<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (lens, [corner, size]) = (self.lens, self.crop);
        for i in 0..LANES {
            let (seen, is_seen) = self.pinhole.seen_from(self.z.p.get(i));
            let own = seen.pixel - corner;
            let within = (own.x >= 0.0) & (own.y >= 0.0) & (own.x < size.x) & (own.y < size.y);
            lens.is_there[i] = u32::from(is_seen & within);
            lens.wi.set(i, seen.wi);
            lens.p.set(i, seen.p);
            lens.we[i] = seen.we;
            (lens.pixel[0][i], lens.pixel[1][i]) = (seen.pixel.x, seen.pixel.y);
        }
    }
}

/// t = 1: z looks at the lens.
pub(super) struct ToLens<'a, const SQUARE: bool> {
    pub z: &'a Stage,
    pub lens: &'a Lens,
    pub eye: Center,
    /// The numbers that decide which are worth it.
    pub u_worth: &'a Lane,
    pub worth: Worth,
    pub joints: &'a mut Joints,
}

impl<const SQUARE: bool> wide::Job for ToLens<'_, SQUARE> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (z, lens, eye, out) = (self.z, self.lens, self.eye, self.joints);
        let own = power::<SQUARE>(eye.rho, 1.0);
        for i in 0..LANES {
            let wi = lens.wi.get(i);
            let up = z.height(i, wi);
            let f_cos = z.rho.get(i) * FRAC_1_PI * z.adjoint_cos(i, wi);
            let contribution = z.beta.get(i) * f_cos * lens.we[i];

            let depth = eye.axis.dot(z.p.get(i) - eye.p);
            let density = z.n.get(i).dot(wi).abs() / (eye.area * -eye.axis.dot(wi) * depth * depth);
            let weight = 1.0 / (1.0 + z.others::<SQUARE>(i, density, z.way_back(i)) / own);
            let (grown, is_worth_it) = self.worth.decide_splat_at_once(contribution * weight, self.u_worth[i]);
            out.value.set(i, contribution * grown * weight);
            let faces = (up > 0.0) & (z.above[i] > 0.0) & is_something(f_cos);
            out.is_there[i] = z.alive[i] & lens.is_there[i] & u32::from(faces & is_worth_it);
        }
        for i in 0..LANES {
            out.aim(i, z, lens.p.get(i));
        }
    }
}
