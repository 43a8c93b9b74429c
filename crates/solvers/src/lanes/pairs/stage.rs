//! What one vertex of each walk is to connections and to weights, a sample a lane.

use super::super::turn::survive;
use super::super::vertices::{Colours, Flags, LANES, Lane, Lane3, Vertices};
use crate::bidirectional::weights::{LARGE, Trail};
use etendue_numerics::math::FRAC_1_PI;
use etendue_numerics::{Vec3, wide};

/// Vertices of as many walks, all of them as far from their ends: `bidirectional::PathVertex`.
pub(super) struct Stage {
    /// Whether the walk came here.
    pub alive: Flags,
    pub p: Lane3,
    pub p_error: Lane3,
    pub n: Lane3,
    pub ns: Lane3,
    pub wo: Lane3,
    /// `wo` over the shading normal, above zero on a front.
    pub above: Lane,
    /// Whether the back is looked at, which is a front as well.
    pub is_turned: Flags,
    pub rho: Lane3,
    pub beta: Lane3,
    pub times: Lane,
    pub density: Lane,
    pub back: Lane,
    pub connect: Lane,
    pub sums: Lane,
}

impl Stage {
    pub fn new() -> Box<Self> {
        let (three, one, flags) = (Lane3::ZERO, [0.0; LANES], [0; LANES]);
        Box::new(Self {
            alive: flags,
            p: three,
            p_error: three,
            n: three,
            ns: three,
            wo: three,
            above: one,
            is_turned: flags,
            rho: three,
            beta: three,
            times: one,
            density: one,
            back: one,
            connect: one,
            sums: one,
        })
    }

    /// `Link::others` of lane i.
    #[inline(always)]
    pub fn others<const SQUARE: bool>(&self, i: usize, other: f32, way_back: f32) -> f32 {
        power::<SQUARE>(other, self.density[i]) * self.bracket::<SQUARE>(i, way_back)
    }

    /// `Link::bracket` of lane i.
    #[inline(always)]
    pub fn bracket<const SQUARE: bool>(&self, i: usize, way_back: f32) -> f32 {
        smaller(self.connect[i] + power::<SQUARE>(way_back * self.back[i], 1.0) * self.sums[i], LARGE * LARGE)
    }

    /// Height of the unit direction `w` over the front that is looked at.
    #[inline(always)]
    pub fn height(&self, i: usize, w: Vec3) -> f32 {
        let height = self.ns.get(i).dot(w);
        if self.is_turned[i] != 0 { -height } else { height }
    }

    /// Density of the way back along `wo`.
    #[inline(always)]
    pub fn way_back(&self, i: usize) -> f32 {
        self.above[i] * FRAC_1_PI
    }

    /// What turns |cosθ| to the shading normal into that of a particle, `Sides::turn_to_eye`: |wo·ns| |w·n| / |wo·n|; zero where there is none.
    #[inline(always)]
    pub fn adjoint_cos(&self, i: usize, w: Vec3) -> f32 {
        let n = self.n.get(i);
        let from = n.dot(self.wo.get(i)).abs();
        let cos = self.above[i] * n.dot(w).abs() / from;
        if from > 0.0 { cos } else { 0.0 }
    }
}

/// What the walks remember of their last vertices: `weights::Trail`.
pub(super) struct Trails {
    p: Lane3,
    n: Lane3,
    density: Lane,
    pdf_w: Lane,
    connect: Lane,
    sums: Lane,
}

impl Trails {
    pub fn new() -> Box<Self> {
        let (three, one) = (Lane3::ZERO, [0.0; LANES]);
        Box::new(Self { p: three, n: three, density: one, pdf_w: one, connect: one, sums: one })
    }

    pub fn get(&self, i: usize) -> Trail {
        Trail {
            p: self.p.get(i),
            n: self.n.get(i),
            distant: false,
            density: self.density[i],
            pdf_w: self.pdf_w[i],
            connect: self.connect[i],
            sums: self.sums[i],
        }
    }

    pub fn set(&mut self, i: usize, t: &Trail) {
        self.p.set(i, t.p);
        self.n.set(i, t.n);
        (self.density[i], self.pdf_w[i], self.connect[i], self.sums[i]) = (t.density, t.pdf_w, t.connect, t.sums);
    }
}

/// The walks arrive at the surfaces of `v`: `Walk::vertex`.
pub(super) struct Arrive<'a> {
    pub v: &'a Vertices,
    pub trails: &'a Trails,
    /// What the walks started with.
    pub start: &'a Lane3,
    pub stage: &'a mut Stage,
}

impl wide::Job for Arrive<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (v, t, s) = (self.v, self.trails, self.stage);
        for i in 0..LANES {
            let (p, n, wo) = (v.p.get(i), v.n.get(i), v.wo.get(i));
            let r2 = (t.p.get(i) - p).length_squared();
            s.density[i] = t.pdf_w[i] * (n.dot(wo).abs() / r2);
            let back = smaller(t.n.get(i).dot(wo).abs() / r2 / t.density[i], LARGE * LARGE);
            s.back[i] = if (t.sums[i] > 0.0) & (t.density[i] > 0.0) { back } else { 0.0 };
            (s.connect[i], s.sums[i]) = (t.connect[i], t.sums[i]);
            s.p.set(i, p);
            s.p_error.set(i, v.p_error.get(i));
            s.n.set(i, n);
            s.wo.set(i, wo);
        }
        for i in 0..LANES {
            let ns = v.ns.get(i);
            let cos = ns.dot(v.wo.get(i));
            s.ns.set(i, ns);
            s.is_turned[i] = v.is_turned[i];
            s.above[i] = if v.is_turned[i] != 0 { -cos } else { cos };
            s.rho.set(i, v.rho.rgb(i));
            s.beta.set(i, v.beta.rgb(i) * self.start.get(i));
            s.times[i] = v.times[i];
        }
    }
}

/// The walks leave along the rays of `v`: `Walk::leave`.
pub(super) struct Leave<'a, const SQUARE: bool> {
    pub v: &'a Vertices,
    pub trails: &'a mut Trails,
    pub stage: &'a Stage,
}

impl<const SQUARE: bool> wide::Job for Leave<'_, SQUARE> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (v, t, s) = (self.v, self.trails, self.stage);
        for i in 0..LANES {
            t.sums[i] = s.bracket::<SQUARE>(i, s.way_back(i));
            t.p.set(i, s.p.get(i));
            t.n.set(i, s.n.get(i));
            (t.density[i], t.pdf_w[i], t.connect[i]) = (s.density[i], v.pdf[i], 1.0);
        }
    }
}

/// What walks from lights carry into the directions in `v`, drawn by cosine: `Sides::sample_to_eye`, `PathState::turn`.
pub(super) struct TurnToEye<'a> {
    pub v: &'a mut Vertices,
    pub stage: &'a Stage,
    /// β before.
    pub carried: &'a Colours,
    pub roulette: bool,
}

impl wide::Job for TurnToEye<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (v, s) = (self.v, self.stage);
        for i in 0..LANES {
            let wi = v.ray.d.get(i);
            let weight = s.rho.get(i) * FRAC_1_PI * s.adjoint_cos(i, wi) / v.pdf[i];
            let beta = self.carried.rgb(i) * weight;
            let there = (s.height(i, wi) >= 0.0) & (s.above[i] > 0.0) & (weight.x + weight.y + weight.z < f32::INFINITY);
            v.beta.set(i, [beta.x, beta.y, beta.z, 0.0]);
            v.goes_on[i] = u32::from(there & is_something(beta));
        }
        if self.roulette {
            survive(v);
        }
    }
}

/// `weights::power`, without branches.
#[inline(always)]
pub(super) fn power<const SQUARE: bool>(numerator: f32, denominator: f32) -> f32 {
    let r = if denominator > 0.0 { smaller(numerator / denominator, LARGE) } else { LARGE };
    let r = if SQUARE { r * r } else { r };
    if numerator <= 0.0 { 0.0 } else { r }
}

#[inline(always)]
pub(super) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Whether any lane of a colour is not zero.
#[inline(always)]
pub(super) fn is_something(c: Vec3) -> bool {
    (c.x != 0.0) | (c.y != 0.0) | (c.z != 0.0)
}
