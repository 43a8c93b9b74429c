//! The adjoint side of a vertex: how importance flows, or what a particle does that came from a light.
//!
//! ```text
//! f*(wo → wi) |cosθ| = f(wi, x, wo) |wo·ns| |wi·n| / |wo·n|            [Veach 1997, eq. 5.19]
//! ```
//!
//! `wo` points back to where the particle came from, towards the light; `wi` is where it goes, towards the eye. The f on the right is the path
//! tracer's own, of radiance that arrives from `wo` and leaves along `wi`: it is asked from the eye's side ([`Vertex::eval`]), where refraction's
//! 1/η² and the way that bent normals face are decided. A path tracer measures |wo·ns| where particles arrive in proportion to |wo·n|, and takes
//! what leaves for what an area would that particles see as |wi·n|: hence the factor, which is 1 where ns = n.
//!
//! For Dirac directions with the normal m of the interface that makes them: f cosθ/p of the light's side, times |wo·m| |wi·n| / (|wo·n| |wi·m|).

use super::{Vertex, VertexSample};
use etendue_bsdf::{BsdfSample, Scatter};
use etendue_numerics::{Spectrum, Vec2, Vec3, Wavelengths};
use etendue_scene::{Interaction, Scene};

/// How far, squared, a Dirac direction may be from the way back: rounding.
const SAME: f32 = 1e-6;

impl Vertex<'_> {
    /// f*(wo → wi) · |cosθ| for a particle that leaves towards the world direction `wi`, and the density, 1/sr, with which
    /// [`Vertex::sample_adjoint`] takes it.
    #[inline]
    pub fn eval_adjoint(&self, scene: &Scene, wi: Vec3, wl: &Wavelengths) -> (Spectrum, f32) {
        let f_cos = if self.bsdf.is_bent() { self.asked_by_eye(scene, wi, wl) } else { self.unbent(wi) };
        let from = self.x.n.dot(self.x.wo).abs();
        if f_cos.is_zero() || from == 0.0 {
            return (Spectrum::ZERO, 0.0);
        }
        (f_cos * (self.x.n.dot(wi).abs() / from), self.bsdf.pdf(self.wo, self.x.shading.to_local(wi)))
    }

    /// A direction for the particle to leave in; its weight is f* |cosθ| / p.
    #[inline]
    pub fn sample_adjoint(&self, scene: &Scene, u_lobe: f32, u: Vec2, wl: &Wavelengths) -> Option<VertexSample> {
        let s = self.bsdf.sample(self.wo, u_lobe, u)?;
        let wi = self.x.shading.to_world(s.wi);
        let is_null = s.event.has_null();
        let weight = if is_null {
            s.weight
        } else if s.pdf.is_delta() {
            s.weight * self.adjoint_of_dirac(scene, &s, wi, wl)
        } else {
            self.eval_adjoint(scene, wi, wl).0 / s.pdf.value()
        };
        weight.is_finite().then_some(VertexSample { wi, weight, pdf: s.pdf, eta_scale: 1.0, is_null, event: s.event })
    }

    /// f |cosθ| for the eye in the direction `wi`, by whom radiance from `wo` is asked for.
    #[inline(never)]
    fn asked_by_eye(&self, scene: &Scene, wi: Vec3, wl: &Wavelengths) -> Spectrum {
        let mut eye = Self::at(Interaction { wo: wi, ..self.x });
        eye.evaluate(scene, wl);
        eye.eval(self.x.wo).0
    }

    /// The same where no lobe has a frame of its own: the surface is one and the same from all sides.
    #[inline]
    fn unbent(&self, wi: Vec3) -> Spectrum {
        let (eye, light) = (self.x.shading.to_local(wi), self.wo);
        let f = if eye.z * light.z >= 0.0 { self.bsdf.eval(eye, light) } else { self.bsdf.eval(light, eye) };
        f * light.z.abs()
    }

    /// What the weight of a Dirac direction of the light's side must be multiplied by.
    fn adjoint_of_dirac(&self, scene: &Scene, s: &BsdfSample, wi: Vec3, wl: &Wavelengths) -> Spectrum {
        let n = self.x.n;
        let along_n = n.dot(wi).abs() / n.dot(self.x.wo).abs();
        // The interface's normal halves the angle of a reflection, and is wo + η wi of a refraction.
        let m = (self.x.wo + wi * s.eta).try_normalize();
        let along_m = m.map_or(1.0, |m| self.x.wo.dot(m).abs() / wi.dot(m).abs());
        if !self.bsdf.is_bent() {
            return Spectrum::splat(along_m * along_n);
        }

        // Shadow terminators and bent normals need not treat both ways alike: what either side says, one over the other.
        let carried = |vertex: &Vertex<'_>, towards: Vec3| {
            let mut sum = Spectrum::ZERO;
            vertex.bsdf.diracs(vertex.wo, &mut |d| {
                if d.wi.distance_squared(towards) < SAME && !d.event.has_null() {
                    sum += d.weight;
                }
            });
            sum
        };
        let mut eye = Self::at(Interaction { wo: wi, ..self.x });
        eye.evaluate(scene, wl);
        let (theirs, ours) = (carried(&eye, self.wo), carried(self, s.wi));
        let ratio = |lane: usize| if ours[lane] > 0.0 { theirs[lane] / ours[lane] } else { 0.0 };
        Spectrum([ratio(0), ratio(1), ratio(2), ratio(3)].into()) * (along_m * along_n)
    }
}
