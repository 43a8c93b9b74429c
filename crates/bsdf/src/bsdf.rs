//! A sum of weighted lobes, each perhaps in a frame of its own: everything that a surface does at one hit.
//!
//! f = Σ_k w_k f_k and, with the selection probabilities q_k ∝ w_k · (reflectance of lobe k), p = Σ_k q_k p_k. A smooth sample has the
//! weight f |cosθ_i| / p whichever lobe drew it (one-sample multiple importance sampling, balance heuristic [Veach 1997,
//! §9.2.4]); a Dirac sample of lobe k has w_k/q_k times the lobe's weight.
//!
//! Blends are sums with weights; a mask of opacity o is the surface with weight o and [`crate::lobes::Null`] with weight 1 - o.
//!
//! One lobe in the shading frame, the common case, costs one branch more than the lobe itself. A `Bsdf` with room for
//! [`Bsdf::MAX_LOBES`] is about a kilobyte of which only the lobes in use are ever touched: build it in place, pass it by reference.

use crate::slot::Slot;
use crate::{BsdfSample, Event, Lobe, Perturbation, Scatter, local::stretch};
use etendue_numerics::{Pdf, Spectrum, Vec2, Vec3};

const MAX_LOBES: usize = 8;

/// What a surface does at one hit, as numbers only, and the tables of measured lobes.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf<'a> {
    /// The first `len` are taken. An empty slot is a tag and nothing else, so that a new surface is eight small stores.
    slots: [Option<Slot<'a>>; MAX_LOBES],
    len: usize,
    events: Event,
    /// Σ select.
    total: f32,
}

impl Default for Bsdf<'_> {
    fn default() -> Self {
        Self::new()
    }
}

impl<'a, L: Into<Lobe<'a>>> From<L> for Bsdf<'a> {
    #[inline]
    fn from(lobe: L) -> Self {
        let mut bsdf = Self::new();
        bsdf.push(1.0, lobe.into());
        bsdf
    }
}

impl<'a> Bsdf<'a> {
    /// How many lobes one surface may have.
    pub const MAX_LOBES: usize = MAX_LOBES;

    /// A surface that absorbs all light.
    #[inline]
    pub const fn new() -> Self {
        Self { slots: [None; MAX_LOBES], len: 0, events: Event::NONE, total: 0.0 }
    }

    /// How many lobes it has: a mark for the `_since` methods.
    #[inline]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether it has none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Whether any lobe has a frame of its own, or belongs to the side that it is seen from: only then may the surface be another one, looked at
    /// from another side.
    #[inline]
    pub fn is_bent(&self) -> bool {
        self.lobes().any(|slot| slot.frame.is_some() || slot.lobe.is_one_way())
    }

    /// Adds `weight` times a lobe; weights that are not positive numbers add nothing. `false` where there is no room: the
    /// number of lobes is known when a scene is compiled, and should be checked there.
    #[inline]
    pub fn push(&mut self, weight: f32, lobe: impl Into<Lobe<'a>>) -> bool {
        let lobe = lobe.into();
        self.insert(weight, lobe, None)
    }

    #[inline]
    fn insert(&mut self, weight: f32, lobe: Lobe<'a>, frame: Option<Perturbation>) -> bool {
        if !(weight > 0.0 && weight.is_finite()) {
            return true;
        }
        let Some(slot) = self.slots.get_mut(self.len) else { return false };
        let weight = weight.min(1e6);
        let select = weight * lobe.importance();
        self.events |= lobe.events();
        self.total += select;
        *slot = Some(Slot { lobe, frame, weight, select });
        self.len += 1;
        true
    }

    /// Adds `weight` times another surface, frames and all; `false` where there is no room for all of it.
    pub fn append(&mut self, weight: f32, other: &Self) -> bool {
        other.lobes().all(|s| self.insert(weight * s.weight, s.lobe, s.frame))
    }

    /// Multiplies the lobes from number `mark` on by `weight`, which must not be negative.
    pub fn scale_since(&mut self, mark: usize, weight: f32) {
        let w = if weight.is_finite() { weight.max(0.0) } else { 0.0 };
        for slot in self.slots.iter_mut().skip(mark).flatten() {
            slot.weight *= w;
            slot.select *= w;
        }
        self.total = self.lobes().map(|s| s.select).sum();
    }

    /// Puts the lobes from number `mark` on into a frame, outside of those they have already.
    pub fn perturb_since(&mut self, mark: usize, frame: &Perturbation) {
        for slot in self.slots.iter_mut().skip(mark).flatten() {
            slot.frame = Some(slot.frame.map_or(*frame, |inner| frame.then(&inner)));
        }
    }

    /// Turns the lobes from number `mark` on upside down: what a two-sided surface shows on its back.
    pub fn flip_since(&mut self, mark: usize) {
        self.perturb_since(mark, &Perturbation::BACK);
    }

    /// All of it times `weight`.
    #[must_use]
    pub fn scaled(mut self, weight: f32) -> Self {
        self.scale_since(0, weight);
        self
    }

    /// All of it in a frame.
    #[must_use]
    pub fn perturbed(mut self, frame: &Perturbation) -> Self {
        self.perturb_since(0, frame);
        self
    }

    /// All of it upside down.
    #[must_use]
    pub fn flipped(mut self) -> Self {
        self.flip_since(0);
        self
    }

    /// η_t/η_i for light that goes from `wo` to `wi`: 1 on the same side. Where transmitting lobes of several indices overlap it is
    /// the mean that gives the sum of f_k/η_k² in the largest lane.
    pub fn relative_eta(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z * wi.z >= 0.0 {
            return 1.0;
        }
        if let Some(slot) = self.only() {
            return slot.path_eta(wo);
        }
        let (mut f, mut scaled) = (0.0, 0.0);
        for slot in self.lobes().filter(|s| s.lobe.events().transmits()) {
            let x = slot.eval(wo, wi).max_lane();
            let eta = slot.path_eta(wo);
            f += x;
            scaled += x / (eta * eta);
        }
        if scaled > 0.0 { (f / scaled).sqrt() } else { 1.0 }
    }

    /// Whether [`Scatter::sample`] looks at its number `u1`, which chooses among lobes or within one.
    #[inline]
    pub fn has_choice(&self) -> bool {
        self.only().is_none_or(|slot| slot.lobe.has_choice())
    }

    #[inline]
    fn lobes(&self) -> impl Iterator<Item = &Slot<'a>> {
        self.slots.iter().map_while(Option::as_ref)
    }

    /// The lobe, where there is just one.
    #[inline]
    pub(crate) fn only(&self) -> Option<&Slot<'a>> {
        if self.len == 1 { self.slots[0].as_ref() } else { None }
    }

    /// The lobe whose share of [0, total) holds u1, and u1 stretched over that share.
    fn choose(&self, u1: f32) -> Option<(usize, &Slot<'a>, f32)> {
        let mut at = u1 * self.total;
        let mut chosen = None;
        for (k, slot) in self.lobes().enumerate().filter(|(_, slot)| slot.select > 0.0) {
            if let Some((_, before, _)) = chosen {
                let before: &Slot<'_> = before;
                at -= before.select;
            }
            // Rounding may carry u1 beyond the last share: then the last lobe has it.
            chosen = Some((k, slot, stretch(at, 0.0, slot.select)));
            if at < slot.select {
                break;
            }
        }
        chosen
    }

    fn sample_sum(&self, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample> {
        let (chosen, slot, u1) = self.choose(u1)?;
        let mut s = slot.sample(wo, u1, u2)?;
        match s.pdf {
            Pdf::SolidAngle(_) => self.mixed(chosen, wo, s),
            Pdf::Delta(p) => {
                let q = slot.select / self.total;
                s.weight *= slot.weight / q;
                s.pdf = Pdf::Delta(p * q);
                Some(s)
            }
        }
    }

    /// The mixture's weight and density at the smooth sample `s` of the lobe `chosen`.
    fn mixed(&self, chosen: usize, wo: Vec3, mut s: BsdfSample) -> Option<BsdfSample> {
        let (mut f_cos, mut pdf) = (Spectrum::ZERO, 0.0);
        for (k, slot) in self.lobes().enumerate() {
            let q = slot.select / self.total;
            let (f_k, p_k) = if k == chosen {
                let p = s.pdf.value();
                (s.weight * p, p)
            } else {
                let (f, p) = slot.eval_pdf(wo, s.wi);
                (f * s.wi.z.abs(), p)
            };
            f_cos += if k == chosen { f_k * slot.weight } else { f_k };
            pdf += q * p_k;
        }
        if s.event.transmits() {
            s.eta = self.relative_eta(wo, s.wi);
        }
        s.weight = f_cos / pdf;
        s.pdf = Pdf::SolidAngle(pdf);
        (pdf > 0.0 && pdf.is_finite() && s.weight.is_finite()).then_some(s)
    }
}

impl Scatter for Bsdf<'_> {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        match self.only() {
            Some(slot) => slot.eval(wo, wi),
            None => self.lobes().map(|s| s.eval(wo, wi)).sum(),
        }
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        match self.only() {
            Some(slot) => slot.pdf(wo, wi),
            None if self.total <= 0.0 => 0.0,
            None => self.lobes().map(|s| s.select * s.pdf(wo, wi)).sum::<f32>() / self.total,
        }
    }

    #[inline]
    fn sample(&self, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample> {
        match self.only() {
            Some(slot) => {
                let mut s = slot.sample(wo, u1, u2)?;
                s.weight *= slot.weight;
                Some(s)
            }
            None => self.sample_sum(wo, u1, u2),
        }
    }

    fn diracs(&self, wo: Vec3, found: &mut dyn FnMut(BsdfSample)) {
        if self.events.has_delta() {
            self.lobes().for_each(|slot| slot.diracs(wo, found));
        }
    }

    #[inline]
    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        if let Some(slot) = self.only() {
            return slot.eval_pdf(wo, wi);
        }
        let (mut f, mut pdf) = (Spectrum::ZERO, 0.0);
        for slot in self.lobes() {
            let (f_k, p_k) = slot.eval_pdf(wo, wi);
            f += f_k;
            pdf += slot.select * p_k;
        }
        (f, if self.total > 0.0 { pdf / self.total } else { 0.0 })
    }

    #[inline]
    fn events(&self) -> Event {
        self.events
    }

    fn albedo(&self, wo: Vec3) -> Spectrum {
        self.lobes().filter_map(|s| Some(s.lobe.albedo(s.local(wo)?) * s.weight)).sum()
    }

    fn diffuse_reflectance(&self) -> Spectrum {
        self.lobes().map(|s| s.lobe.diffuse_reflectance() * s.weight).sum()
    }

    /// The narrowest of its lobes; 1 where there is none.
    fn roughness(&self) -> f32 {
        self.lobes().map(|s| s.lobe.roughness()).fold(1.0, f32::min)
    }

    /// The index of its first lobe that bends light; 1 where none does.
    fn eta(&self) -> f32 {
        self.lobes().map(|s| s.lobe.eta()).find(|eta| *eta != 1.0).unwrap_or(1.0)
    }

    fn transparency(&self, wo: Vec3) -> Spectrum {
        if !self.events.has_null() {
            return Spectrum::ZERO;
        }
        self.lobes().filter_map(|s| Some(s.lobe.transparency(s.local(wo)?) * s.weight)).sum()
    }

    fn importance(&self) -> f32 {
        self.total
    }
}
