//! Lobes whose f and p follow from one facet: what they have in common, one at a time. Many at once are [`crate::Together`].
//!
//! ```text
//! f, p = at(facet between wo and wi),    wi ~ turn(normal drawn)
//! ```

use crate::local::smooth;
use crate::microfacet::facet::Facet;
use crate::{BsdfSample, Event, Microfacets};
use etendue_numerics::{Spectrum, Vec2, Vec3};

/// A direction that was chosen, before its weight and density are known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    pub wi: Vec3,
    /// The facet's normal, where a facet was chosen.
    pub m: Option<Vec3>,
    /// η_t/η_i along `wi`.
    pub eta: f32,
    pub event: Event,
}

/// A lobe of facets.
pub(crate) trait Faceted {
    /// Its facets, and their index interior/exterior.
    fn facets(&self) -> (&Microfacets, f32);

    /// The facets that normals are drawn from.
    #[inline]
    fn drawn(&self, _wo: Vec3) -> Microfacets {
        *self.facets().0
    }

    /// A number that depends on `wo` alone, which `at` and `turn` share.
    #[inline]
    fn towards(&self, _wo: Vec3) -> f32 {
        0.0
    }

    /// f and p.
    fn at(&self, wo: Vec3, towards: f32, wi: Vec3, facet: Option<&Facet>) -> (Spectrum, f32);

    /// A direction, `m` a normal drawn for `wo` and `u2`.
    fn turn(&self, wo: Vec3, towards: f32, u1: f32, u2: Vec2, m: impl FnOnce() -> Vec3) -> Option<Turn>;
}

/// f and p of one pair of directions.
#[inline(always)]
pub(crate) fn eval_pdf(lobe: &impl Faceted, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
    let (facets, eta) = lobe.facets();
    lobe.at(wo, lobe.towards(wo), wi, Facet::between(facets, eta, wo, wi).as_ref())
}

/// One direction.
#[inline(always)]
pub(crate) fn sample(lobe: &impl Faceted, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample> {
    let towards = lobe.towards(wo);
    let t = lobe.turn(wo, towards, u1, u2, || lobe.drawn(wo).sample(upwards(wo), u2))?;
    let (facets, eta) = lobe.facets();
    let facet = match t.m {
        Some(m) => Facet::known(facets, eta, wo, t.wi, m),
        None => Facet::between(facets, eta, wo, t.wi),
    };
    weigh(lobe, wo, towards, &t, facet.as_ref())
}

/// The sample that a turn is.
#[inline(always)]
pub(crate) fn weigh(lobe: &impl Faceted, wo: Vec3, towards: f32, t: &Turn, facet: Option<&Facet>) -> Option<BsdfSample> {
    let (f, pdf) = lobe.at(wo, towards, t.wi, facet);
    smooth(t.wi, f, pdf, t.eta, t.event)
}

/// `w` or what is opposite to it, in the upper hemisphere.
#[inline(always)]
pub(crate) fn upwards(w: Vec3) -> Vec3 {
    if w.z < 0.0 { -w } else { w }
}
