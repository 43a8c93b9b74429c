//! Facets side by side, one a lane: normals drawn, and what is between two directions. The loops over lanes of [`crate::Together`].

use super::beckmann::{self, Search};
use super::facet::Facet;
use super::{Microfacets, Ndf};
use crate::lobes::faceted::upwards;
use etendue_numerics::{Vec2, Vec3, wide};

/// Facets that are worked on together.
pub const LANES: usize = 64;
const _: () = assert!(LANES.is_multiple_of(wide::PAD));

type Lane = [f32; LANES];
type Lane3 = [Lane; 3];

/// Facets side by side.
#[derive(Debug)]
pub struct Facets {
    pub alpha: [Lane; 2],
    pub eta: Lane,
    pub wo: Lane3,
    pub wi: Lane3,
    pub u: [Lane; 2],
    /// Normals drawn, or found; and which are known.
    pub m: Lane3,
    pub is_known: [u32; LANES],
    pub cos_o: Lane,
    pub jacobian: Lane,
    pub f: Lane,
    pub dg: Lane,
    pub pdf: Lane,
    pub reflects: [u32; LANES],
    pub is_there: [u32; LANES],
}

impl Default for Facets {
    fn default() -> Self {
        let (one, three, flags) = ([0.0; LANES], [[0.0; LANES]; 3], [0; LANES]);
        Self {
            alpha: [one; 2],
            eta: one,
            wo: three,
            wi: three,
            u: [one; 2],
            m: three,
            is_known: flags,
            cos_o: one,
            jacobian: one,
            f: one,
            dg: one,
            pdf: one,
            reflects: flags,
            is_there: flags,
        }
    }
}

#[inline(always)]
pub fn get(v: &Lane3, i: usize) -> Vec3 {
    Vec3::new(v[0][i], v[1][i], v[2][i])
}

#[inline(always)]
pub fn set(v: &mut Lane3, i: usize, x: Vec3) {
    (v[0][i], v[1][i], v[2][i]) = (x.x, x.y, x.z);
}

impl Facets {
    #[inline(always)]
    fn surface(&self, i: usize, ndf: Ndf) -> Microfacets {
        Microfacets::of_visible(ndf, Vec2::new(self.alpha[0][i], self.alpha[1][i]))
    }

    /// The facet of lane i, where there is one.
    #[inline(always)]
    pub fn facet(&self, i: usize) -> Option<Facet> {
        (self.is_there[i] != 0).then(|| Facet {
            m: get(&self.m, i),
            cos_o: self.cos_o[i],
            jacobian: self.jacobian[i],
            f: self.f[i],
            dg: self.dg[i],
            pdf: self.pdf[i],
            reflects: self.reflects[i] != 0,
            is_there: true,
        })
    }
}

/// Draws normals.
pub struct Normals<'a> {
    pub facets: &'a mut Facets,
    pub count: usize,
    pub ndf: Ndf,
}

impl wide::Job for Normals<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (x, n) = (self.facets, self.count.next_multiple_of(wide::PAD).min(LANES));
        if self.ndf == Ndf::Beckmann {
            return search(x, self.count, n);
        }
        for i in 0..n {
            let m = x.surface(i, Ndf::Ggx).sample_ggx(upwards(get(&x.wo, i)), Vec2::new(x.u[0][i], x.u[1][i]));
            set(&mut x.m, i, m);
        }
    }
}

/// Beckmann's normals, all searched for until the last is found.
#[inline(always)]
fn search(x: &mut Facets, count: usize, n: usize) {
    let [mut cos, mut sin, mut target, mut low, mut high, mut y] = [[0.0; LANES]; 6];
    // Beyond the last lane in use nothing is searched for.
    let mut is_over = [1u32; LANES];
    is_over[..count].fill(0);
    let v = &mut [[0.0; LANES]; 3];
    for i in 0..n {
        let seen = x.surface(i, Ndf::Beckmann).stretched_direction(upwards(get(&x.wo, i)));
        let s = Search::new(seen, x.u[0][i]);
        set(v, i, seen);
        (cos[i], sin[i], target[i]) = (s.cos, s.sin, s.target);
        (low[i], high[i], y[i]) = (s.low, s.high, s.y);
    }
    for _ in 0..beckmann::STEPS {
        let mut all_over = 1;
        for i in 0..n {
            let over = is_over[i] != 0;
            let mut s = Search { cos: cos[i], sin: sin[i], target: target[i], low: low[i], high: high[i], y: y[i], is_over: false };
            s.step();
            let keep = |old: f32, new: f32| if over { old } else { new };
            (low[i], high[i], y[i]) = (keep(low[i], s.low), keep(high[i], s.high), keep(y[i], s.y));
            is_over[i] |= u32::from(s.is_over);
            all_over &= is_over[i];
        }
        if all_over != 0 {
            break;
        }
    }
    for i in 0..n {
        let s = Search { cos: cos[i], sin: sin[i], target: target[i], low: low[i], high: high[i], y: y[i], is_over: true };
        let m = x.surface(i, Ndf::Beckmann).unstretched(s.normal(get(v, i), x.u[1][i]));
        set(&mut x.m, i, m);
    }
}

/// Finds the facets between directions.
pub struct Find<'a> {
    pub facets: &'a mut Facets,
    pub count: usize,
    pub ndf: Ndf,
}

impl wide::Job for Find<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.count.next_multiple_of(wide::PAD).min(LANES);
        match self.ndf {
            Ndf::Beckmann => find(self.facets, n, Ndf::Beckmann),
            Ndf::Ggx => find(self.facets, n, Ndf::Ggx),
            Ndf::GgxCorrelated => find(self.facets, n, Ndf::GgxCorrelated),
        }
    }
}

#[inline(always)]
fn find(x: &mut Facets, n: usize, ndf: Ndf) {
    for i in 0..n {
        let (wo, wi, m) = (get(&x.wo, i), get(&x.wi, i), get(&x.m, i));
        let facet = Facet::of(&x.surface(i, ndf), x.eta[i], wo, wi, m, x.is_known[i] != 0);
        set(&mut x.m, i, facet.m);
        (x.cos_o[i], x.jacobian[i], x.f[i]) = (facet.cos_o, facet.jacobian, facet.f);
        (x.dg[i], x.pdf[i]) = (facet.dg, facet.pdf);
        (x.reflects[i], x.is_there[i]) = (u32::from(facet.reflects), u32::from(facet.is_there));
    }
}
