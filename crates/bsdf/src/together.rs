//! Lobes of facets for many pairs of directions at once: the bits of [`Scatter::eval_pdf`] and [`Scatter::sample`] of each.
//!
//! What has numbers alone goes on lanes ([`etendue_numerics::wide`]), facets of one distribution side by side: normals drawn, D, G, F,
//! Jacobians. What has colours or chooses goes lobe by lobe ([`crate::lobes`], `Faceted`), and so does all that is no single such lobe.

use crate::lobes::faceted::{Turn, upwards};
use crate::microfacet::facet::Facet;
use crate::slot::Slot;
use crate::{Bsdf, BsdfSample, Microfacets, Ndf, Scatter};
use etendue_numerics::{Spectrum, Vec2, Vec3, wide};

/// Pairs that are worked on together.
const LANES: usize = 64;

type Lane = [f32; LANES];
type Lane3 = [Lane; 3];

/// What [`Scatter::eval_pdf`] is asked.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'q, 'a> {
    /// f.
    pub bsdf: &'q Bsdf<'a>,
    /// The direction given, local.
    pub wo: Vec3,
    /// The other one.
    pub wi: Vec3,
}

/// What [`Scatter::sample`] is asked.
#[derive(Clone, Copy, Debug)]
pub struct Draw<'q, 'a> {
    /// f.
    pub bsdf: &'q Bsdf<'a>,
    /// The direction given, local.
    pub wo: Vec3,
    /// Chooses the part.
    pub u1: f32,
    /// Chooses where.
    pub u2: Vec2,
}

/// Memory for the lanes, used again and again.
#[derive(Debug)]
pub struct Together {
    count: usize,
    /// Which question each lane belongs to.
    asked: [usize; LANES],
    towards: Lane,
    facets: Box<Facets>,
    turns: [Option<Turn>; LANES],
}

/// Facets side by side.
#[derive(Debug)]
struct Facets {
    alpha: [Lane; 2],
    eta: Lane,
    wo: Lane3,
    wi: Lane3,
    u: [Lane; 2],
    /// Normals drawn, or found; and which are known.
    m: Lane3,
    is_known: [u32; LANES],
    cos_o: Lane,
    jacobian: Lane,
    f: Lane,
    dg: Lane,
    pdf: Lane,
    reflects: [u32; LANES],
    is_there: [u32; LANES],
}

impl Default for Together {
    fn default() -> Self {
        let (one, three, flags) = ([0.0; LANES], [[0.0; LANES]; 3], [0; LANES]);
        let facets = Facets {
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
        };
        Self { count: 0, asked: [0; LANES], towards: one, facets: Box::new(facets), turns: [None; LANES] }
    }
}

impl Together {
    /// [`Scatter::eval_pdf`] of each pair, in their order.
    pub fn eval_pdf(&mut self, pairs: &[Pair<'_, '_>], found: &mut Vec<(Spectrum, f32)>) {
        found.clear();
        found.resize(pairs.len(), (Spectrum::ZERO, 0.0));
        for ndf in Ndf::ALL {
            for (k, q) in pairs.iter().enumerate() {
                let Some((slot, facets, eta)) = faceted(q.bsdf) else {
                    if ndf == Ndf::Ggx {
                        found[k] = q.bsdf.eval_pdf(q.wo, q.wi);
                    }
                    continue;
                };
                if facets.ndf() == ndf
                    && let Some((wo, wi)) = slot.local(q.wo).zip(slot.local(q.wi))
                {
                    let i = self.push(k, facets, eta, wo);
                    set(&mut self.facets.wi, i, wi);
                    self.facets.is_known[i] = 0;
                    if self.count == LANES {
                        self.evaluate(ndf, pairs, found);
                    }
                }
            }
            self.evaluate(ndf, pairs, found);
        }
    }

    fn evaluate(&mut self, ndf: Ndf, pairs: &[Pair<'_, '_>], found: &mut [(Spectrum, f32)]) {
        wide::widest(Find { facets: &mut self.facets, count: self.count, ndf });
        for i in 0..self.count {
            let (k, x) = (self.asked[i], self.facets.facet(i));
            let q = &pairs[k];
            let (wo, wi) = (get(&self.facets.wo, i), get(&self.facets.wi, i));
            if let Some(slot) = q.bsdf.only() {
                found[k] = slot.dimmed(slot.lobe.at(wo, slot.lobe.towards(wo), wi, x.as_ref()), q.wi, wi);
            }
        }
        self.count = 0;
    }

    /// [`Scatter::sample`] of each, in their order.
    pub fn sample(&mut self, draws: &[Draw<'_, '_>], found: &mut Vec<Option<BsdfSample>>) {
        found.clear();
        found.resize(draws.len(), None);
        for ndf in Ndf::ALL {
            for (k, q) in draws.iter().enumerate() {
                let Some((slot, facets, eta)) = faceted(q.bsdf) else {
                    if ndf == Ndf::Ggx {
                        found[k] = q.bsdf.sample(q.wo, q.u1, q.u2);
                    }
                    continue;
                };
                if facets.ndf() == ndf
                    && let Some(wo) = slot.local(q.wo)
                {
                    let i = self.push(k, facets, eta, wo);
                    (self.facets.u[0][i], self.facets.u[1][i]) = q.u2.into();
                    if self.count == LANES {
                        self.turn(ndf, draws, found);
                    }
                }
            }
            self.turn(ndf, draws, found);
        }
    }

    fn turn(&mut self, ndf: Ndf, draws: &[Draw<'_, '_>], found: &mut [Option<BsdfSample>]) {
        let facets = &mut *self.facets;
        wide::widest(Normals { facets, count: self.count, ndf });
        for i in 0..self.count {
            let q = &draws[self.asked[i]];
            let (wo, m) = (get(&facets.wo, i), get(&facets.m, i));
            let Some(slot) = q.bsdf.only() else { continue };
            self.towards[i] = slot.lobe.towards(wo);
            self.turns[i] = slot.lobe.turn(wo, self.towards[i], q.u1, q.u2, m);
            if let Some(turn) = &self.turns[i] {
                set(&mut facets.wi, i, turn.wi);
                facets.is_known[i] = u32::from(turn.m.is_some());
            }
        }
        wide::widest(Find { facets, count: self.count, ndf });
        for i in 0..self.count {
            let (k, wo) = (self.asked[i], get(&facets.wo, i));
            let q = &draws[k];
            if let (Some(turn), Some(slot)) = (&self.turns[i], q.bsdf.only()) {
                let sample = slot.lobe.weigh(wo, self.towards[i], turn, facets.facet(i).as_ref());
                found[k] = sample.and_then(|s| slot.outwards(q.wo, s));
            }
        }
        self.count = 0;
    }

    /// Adds a lane.
    #[inline(always)]
    fn push(&mut self, asked: usize, facets: &Microfacets, eta: f32, wo: Vec3) -> usize {
        let (i, x) = (self.count, &mut self.facets);
        self.count += 1;
        self.asked[i] = asked;
        (x.alpha[0][i], x.alpha[1][i]) = facets.alpha().into();
        x.eta[i] = eta;
        set(&mut x.wo, i, wo);
        i
    }
}

/// The lobe, its facets and their index, where it is the only one and all normals drawn are seen.
#[inline(always)]
fn faceted<'q, 'a>(bsdf: &'q Bsdf<'a>) -> Option<(&'q Slot<'a>, &'q Microfacets, f32)> {
    let slot = bsdf.only()?;
    let (facets, eta) = slot.lobe.facets()?;
    facets.samples_visible().then_some((slot, facets, eta))
}

#[inline(always)]
fn get(v: &Lane3, i: usize) -> Vec3 {
    Vec3::new(v[0][i], v[1][i], v[2][i])
}

#[inline(always)]
fn set(v: &mut Lane3, i: usize, x: Vec3) {
    (v[0][i], v[1][i], v[2][i]) = (x.x, x.y, x.z);
}

impl Facets {
    #[inline(always)]
    fn surface(&self, i: usize, ndf: Ndf) -> Microfacets {
        Microfacets::of_visible(ndf, Vec2::new(self.alpha[0][i], self.alpha[1][i]))
    }

    #[inline(always)]
    fn facet(&self, i: usize) -> Option<Facet> {
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
struct Normals<'a> {
    facets: &'a mut Facets,
    count: usize,
    ndf: Ndf,
}

impl wide::Job for Normals<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (x, n) = (self.facets, self.count.next_multiple_of(wide::PAD).min(LANES));
        if self.ndf == Ndf::Beckmann {
            // Searched for one by one.
            for i in 0..self.count {
                let m = x.surface(i, Ndf::Beckmann).sample(upwards(get(&x.wo, i)), Vec2::new(x.u[0][i], x.u[1][i]));
                set(&mut x.m, i, m);
            }
            return;
        }
        for i in 0..n {
            let m = x.surface(i, Ndf::Ggx).sample_ggx(upwards(get(&x.wo, i)), Vec2::new(x.u[0][i], x.u[1][i]));
            set(&mut x.m, i, m);
        }
    }
}

/// Finds the facets between directions.
struct Find<'a> {
    facets: &'a mut Facets,
    count: usize,
    ndf: Ndf,
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
