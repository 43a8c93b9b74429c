//! Lobes of facets for many pairs of directions at once: the bits of [`Scatter::eval_pdf`] and [`Scatter::sample`] of each.
//!
//! What has numbers alone goes on lanes ([`etendue_numerics::wide`]), facets of one distribution side by side: normals drawn, D, G, F,
//! Jacobians. What has colours or chooses goes lobe by lobe ([`crate::lobes`], `Faceted`), and so does all that is no single such lobe.

use crate::lobes::faceted::Turn;
use crate::microfacet::lanes::{Facets, Find, LANES, Normals, get, set};
use crate::slot::Slot;
use crate::{Bsdf, BsdfSample, Microfacets, Ndf, Scatter};
use etendue_numerics::{Spectrum, Vec2, Vec3, wide};

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
    towards: [f32; LANES],
    facets: Box<Facets>,
    turns: [Option<Turn>; LANES],
}

impl Default for Together {
    fn default() -> Self {
        Self { count: 0, asked: [0; LANES], towards: [0.0; LANES], facets: Box::default(), turns: [None; LANES] }
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
