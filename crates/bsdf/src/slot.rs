//! One lobe of a sum: its share, and the frame that it may have of its own.
//!
//! Directions come and go in shading coordinates; what the lobe sees is turned into its frame, and the cosine with it.

use crate::{BsdfSample, Lobe, Perturbation, Scatter};
use etendue_numerics::{Spectrum, Vec2, Vec3};

/// A lobe with its weight and frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slot<'a> {
    pub lobe: Lobe<'a>,
    pub frame: Option<Perturbation>,
    pub weight: f32,
    /// w_k · reflectance: q_k before normalisation.
    pub select: f32,
}

impl Slot<'_> {
    /// w_k f_k, in shading coordinates.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        let Some(frame) = &self.frame else { return self.lobe.eval(wo, wi) * self.weight };
        let (Some(o), Some(i)) = (frame.to_local(wo), frame.to_local(wi)) else { return Spectrum::ZERO };
        self.lobe.eval(o, i) * (self.weight * frame.shadow(wi) * i.z.abs() / wi.z.abs().max(1e-8))
    }

    /// p_k.
    #[inline]
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let Some(frame) = &self.frame else { return self.lobe.pdf(wo, wi) };
        let (Some(o), Some(i)) = (frame.to_local(wo), frame.to_local(wi)) else { return 0.0 };
        self.lobe.pdf(o, i)
    }

    /// w_k f_k and p_k.
    #[inline]
    pub fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        let Some(frame) = &self.frame else {
            let (f, pdf) = self.lobe.eval_pdf(wo, wi);
            return (f * self.weight, pdf);
        };
        let (Some(o), Some(i)) = (frame.to_local(wo), frame.to_local(wi)) else { return (Spectrum::ZERO, 0.0) };
        self.dimmed(self.lobe.eval_pdf(o, i), wi, i)
    }

    /// f and p of the lobe, times w_k and what its frame makes of `wi`, there `local`.
    #[inline]
    pub fn dimmed(&self, (f, pdf): (Spectrum, f32), wi: Vec3, local: Vec3) -> (Spectrum, f32) {
        let factor = |frame: &Perturbation| self.weight * frame.shadow(wi) * local.z.abs() / wi.z.abs().max(1e-8);
        (f * self.frame.as_ref().map_or(self.weight, factor), pdf)
    }

    /// A sample in the lobe's frame as one of the surface, with w_k.
    #[inline]
    pub fn outwards(&self, wo: Vec3, s: BsdfSample) -> Option<BsdfSample> {
        let s = match &self.frame {
            Some(frame) => Self::outer(frame, wo, s)?,
            None => s,
        };
        Some(BsdfSample { weight: s.weight * self.weight, ..s })
    }

    /// A sample of the lobe alone, without w_k.
    #[inline]
    pub fn sample(&self, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample> {
        let Some(frame) = &self.frame else { return self.lobe.sample(wo, u1, u2) };
        let s = self.lobe.sample(frame.to_local(wo)?, u1, u2)?;
        Self::outer(frame, wo, s)
    }

    /// The Dirac directions of the lobe, with w_k.
    pub fn diracs(&self, wo: Vec3, found: &mut dyn FnMut(BsdfSample)) {
        let Some(local) = self.local(wo) else { return };
        self.lobe.diracs(local, &mut |s| {
            let s = match &self.frame {
                Some(frame) => Self::outer(frame, wo, s),
                None => Some(s),
            };
            if let Some(s) = s {
                found(BsdfSample { weight: s.weight * self.weight, ..s });
            }
        });
    }

    /// A sample in the lobe's frame as one in the shading frame, where `wo` is.
    #[inline]
    fn outer(frame: &Perturbation, wo: Vec3, mut s: BsdfSample) -> Option<BsdfSample> {
        if s.event.has_null() {
            s.wi = -wo;
        } else {
            s.wi = frame.to_outer(s.wi)?;
            s.weight *= frame.shadow(s.wi);
        }
        Some(s)
    }

    /// η_t/η_i of the lobe for light from `wo` through the surface.
    #[inline]
    pub fn path_eta(&self, wo: Vec3) -> f32 {
        match self.local(wo) {
            Some(o) if o.z > 0.0 => self.lobe.eta(),
            Some(_) => 1.0 / self.lobe.eta(),
            None => 1.0,
        }
    }

    /// `wo` in the lobe's frame.
    #[inline]
    pub fn local(&self, wo: Vec3) -> Option<Vec3> {
        self.frame.map_or(Some(wo), |f| f.to_local(wo))
    }
}
