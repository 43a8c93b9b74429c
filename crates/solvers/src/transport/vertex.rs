//! A surface point of a path with its scattering: the one place that knows which way radiance flows.
//!
//! Lobes are written in importance form. Radiance is compressed on its way into a denser medium: along a path traced from the eye,
//! f_radiance(wo, wi) = f_importance(wi, wo), and a sampled refraction's weight is divided by η² [Veach 1997, §5.2]. Reflection is
//! the same in both.

use etendue_bsdf::{Bsdf, BsdfSample, Event, Pair, Scatter, Together};
use etendue_numerics::{Pdf, Spectrum, Vec2, Vec3, Wavelengths};
use etendue_scene::{Interaction, LightReference, Scene};

/// A surface vertex, looked at from the eye's side.
#[derive(Clone, Copy, Debug)]
pub struct Vertex<'a> {
    /// The point.
    pub x: Interaction,
    /// f(·, x, ·).
    pub bsdf: Bsdf<'a>,
    /// Direction towards the previous vertex, local.
    pub wo: Vec3,
    /// Whether the walk that goes on from here counts the light that it meets beside light samples; not unless the solver says so.
    pub shares_light: bool,
}

/// A direction sampled at a vertex.
#[derive(Clone, Copy, Debug)]
pub struct VertexSample {
    /// Unit direction in the world.
    pub wi: Vec3,
    /// f · |cosθ| / pdf for radiance.
    pub weight: Spectrum,
    /// Density or probability of `wi`.
    pub pdf: Pdf,
    /// η² of a refraction (1 otherwise): what roulette multiplies back in.
    pub eta_scale: f32,
    /// The ray went straight through a null or mask surface.
    pub is_null: bool,
    /// What happened.
    pub event: Event,
}

impl<'a> Vertex<'a> {
    /// The vertex at x.
    #[inline]
    pub fn new(scene: &'a Scene, x: Interaction, wl: &Wavelengths) -> Self {
        let mut vertex = Self::at(x);
        vertex.evaluate(scene, wl);
        vertex
    }

    /// The vertex at x, before its material is evaluated: it absorbs all light. A vertex is large: made in these two steps it never moves.
    #[inline(always)]
    pub fn at(x: Interaction) -> Self {
        Self { wo: x.wo_local(), x, bsdf: Bsdf::new(), shares_light: false }
    }

    /// Evaluates the material, once.
    #[inline]
    pub fn evaluate(&mut self, scene: &'a Scene, wl: &Wavelengths) {
        scene.bsdf_into(&self.x, wl, &mut self.bsdf);
    }

    /// f(wi, x, wo) · |cosθ_i| for radiance arriving along the world direction `wi`, and the density (1/sr) with which [`Vertex::sample`] takes it.
    #[inline]
    pub fn eval(&self, wi: Vec3) -> (Spectrum, f32) {
        let wi = self.x.shading.to_local(wi);
        if self.wo.z * wi.z >= 0.0 {
            let (f, pdf) = self.bsdf.eval_pdf(self.wo, wi);
            return (f * wi.z.abs(), pdf);
        }
        self.eval_through(wi)
    }

    /// [`Vertex::eval`] for the local direction `wi` on the other side.
    #[inline]
    fn eval_through(&self, wi: Vec3) -> (Spectrum, f32) {
        if !self.bsdf.events().transmits() {
            return (Spectrum::ZERO, 0.0);
        }
        let pdf = self.bsdf.pdf(self.wo, wi);
        if self.bsdf.is_bent() {
            // Bent normals are not reciprocal: their cosine and their terminator belong to `wi`, as in `sample`.
            let eta = self.bsdf.relative_eta(self.wo, wi);
            return (self.bsdf.eval(self.wo, wi) * (wi.z.abs() / (eta * eta)), pdf);
        }
        (self.bsdf.eval(wi, self.wo) * wi.z.abs(), pdf)
    }

    /// [`Vertex::eval`] of many, each a vertex and a direction.
    pub(crate) fn eval_each(asked: &[(&Self, Vec3)], together: &mut Together, found: &mut Vec<(Spectrum, f32)>) {
        let local = |(y, wi): &(&Self, Vec3)| y.x.shading.to_local(*wi);
        let pairs: Vec<Pair<'_, '_>> = asked.iter().map(|q| Pair { bsdf: &q.0.bsdf, wo: q.0.wo, wi: local(q) }).collect();
        together.eval_pdf(&pairs, found);
        for ((y, _), (pair, f)) in asked.iter().zip(pairs.iter().zip(found)) {
            let wi = pair.wi;
            *f = if y.wo.z * wi.z >= 0.0 { (f.0 * wi.z.abs(), f.1) } else { y.eval_through(wi) };
        }
    }

    /// A direction for radiance to arrive from.
    #[inline(always)]
    pub fn sample(&self, u_lobe: f32, u: Vec2) -> Option<VertexSample> {
        self.bsdf.sample(self.wo, u_lobe, u).as_ref().map(|s| self.for_radiance(s))
    }

    /// Hands over every discrete direction with all that it carries, as if it were the only choice.
    pub fn diracs(&self, mut found: impl FnMut(VertexSample)) {
        self.bsdf.diracs(self.wo, &mut |s| found(self.for_radiance(&s)));
    }

    #[inline(always)]
    pub(crate) fn for_radiance(&self, s: &BsdfSample) -> VertexSample {
        let eta_scale = s.eta * s.eta;
        let weight = if s.wi.z * self.wo.z < 0.0 { s.weight / eta_scale } else { s.weight };
        let (wi, is_null) = (self.x.shading.to_world(s.wi), s.event.has_null());
        VertexSample { wi, weight, pdf: s.pdf, eta_scale, is_null, event: s.event }
    }

    /// What light sampling may know of this vertex: where nothing is transmitted, lights behind it need not be asked.
    #[inline]
    pub fn light_reference(&self) -> LightReference {
        let transmits = self.bsdf.events().transmits();
        let from = if transmits { LightReference::from(&self.x) } else { LightReference::reflecting(&self.x) };
        LightReference { shared: self.shares_light, ..from }
    }

    /// Whether any direction but a discrete few scatters: whether next event estimation can find anything.
    #[inline]
    pub fn is_smooth(&self) -> bool {
        self.bsdf.events().has_smooth()
    }
}
