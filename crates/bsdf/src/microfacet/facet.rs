//! A facet that carries light from one direction to another, and all that its surface makes of it [Walter et al. 2007].
//!
//! Its normal m is the half vector: along wo + wi where light is reflected (eq. 13), along wo + η wi where it is refracted (eq. 16),
//! η = η_t/η_i from the side of `wo` to that of `wi`; turned to the side of the macroscopic normal. |dm/dwi| is 1/(4 wi·m) (eq. 14) or
//! η² (wi·m)/(wo·m + η wi·m)² (eq. 17).

use super::Microfacets;
use crate::fresnel;
use etendue_numerics::{Vec3, math::sqr};

/// A facet between `wo` and `wi`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Facet {
    /// Its normal, in the upper hemisphere.
    pub m: Vec3,
    /// |wo·m|.
    pub cos_o: f32,
    /// |dm/dwi|.
    pub jacobian: f32,
    /// F(wo·m) of a dielectric.
    pub f: f32,
    /// D(m) G/(cosθ_o cosθ_i).
    pub dg: f32,
    /// p(m)/|wo·m|.
    pub pdf: f32,
    /// Whether `wi` lies on the side of `wo`.
    pub reflects: bool,
    /// Whether both see it from its right sides; if not, all numbers mean nothing.
    pub is_there: bool,
}

impl Facet {
    /// The facet between two directions, of an interface of index `eta` = interior/exterior; `None` where none is seen from its right
    /// sides by both.
    #[inline]
    pub fn between(facets: &Microfacets, eta: f32, wo: Vec3, wi: Vec3) -> Option<Self> {
        let x = Self::of(facets, eta, wo, wi, Vec3::Z, false);
        x.is_there.then_some(x)
    }

    /// The facet of normal `m`, which sends light from `wo` to `wi`.
    #[inline]
    pub fn known(facets: &Microfacets, eta: f32, wo: Vec3, wi: Vec3, m: Vec3) -> Option<Self> {
        let x = Self::of(facets, eta, wo, wi, m, true);
        x.is_there.then_some(x)
    }

    /// Either, of normal `m` where that `is_known`; without branches.
    #[inline(always)]
    pub fn of(facets: &Microfacets, eta: f32, wo: Vec3, wi: Vec3, m: Vec3, is_known: bool) -> Self {
        let reflects = wo.z * wi.z > 0.0;
        let path = if wo.z > 0.0 { eta } else { 1.0 / eta };
        let half = wo + wi * if reflects { 1.0 } else { path };
        let half = half * half.length_recip();
        let half = half * if half.z < 0.0 { -1.0 } else { 1.0 };
        let pick = |a, b| if is_known { a } else { b };
        let m = Vec3::new(pick(m.x, half.x), pick(m.y, half.y), pick(m.z, half.z));

        let (o, i) = (wo.dot(m), wi.dot(m));
        let refracting = sqr(path) * i.abs() / sqr(o + path * i).max(f32::MIN_POSITIVE);
        let jacobian = if reflects { 0.25 / i.abs() } else { refracting };
        let (dg, pdf) = facets.dg_pdf(wo, wi, m);
        let is_there = (o * wo.z > 0.0) & (i * wi.z > 0.0);
        Self { m, cos_o: o.abs(), jacobian, f: fresnel::dielectric(o, eta).f, dg, pdf, reflects, is_there }
    }
}
