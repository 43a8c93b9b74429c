//! The layer's boundary: a dielectric, smooth or of facets [Walter et al. 2007].

use crate::Microfacets;
use crate::fresnel::{self, reflect, refract};
use crate::microfacet::facet::Facet;
use etendue_numerics::{Vec2, Vec3};

/// A boundary of index η over the outside's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Boundary {
    pub(super) facets: Option<Microfacets>,
    pub(super) eta: f32,
}

/// Light from outside behind the boundary.
pub(super) struct Entry {
    /// The direction of travel, downwards.
    pub(super) d: Vec3,
    /// How much of it there is.
    pub(super) weight: f32,
    /// The density of `d`, 1/sr; none behind a smooth boundary.
    pub(super) pdf: Option<f32>,
}

impl Boundary {
    /// Light along `w`, outside, enters.
    pub(super) fn enter(&self, w: Vec3, u: Vec2) -> Option<Entry> {
        let m = self.facets.map_or(Vec3::Z, |facets| facets.sample(w, u));
        let x = fresnel::dielectric(w.dot(m), self.eta);
        let d = refract(w, m, &x);
        if d.z >= 0.0 || x.f >= 1.0 {
            return None;
        }
        let Some(facets) = self.facets else { return Some(Entry { d, weight: 1.0 - x.f, pdf: None }) };
        let facet = Facet::known(&facets, self.eta, w, d, m)?;
        let pdf = facet.pdf * facet.cos_o * facet.jacobian;
        let weight = (1.0 - x.f) * facets.unshadowed(w, d, m);
        (pdf > 0.0).then_some(Entry { d, weight, pdf: Some(pdf) })
    }

    /// f of a rough boundary for light that enters along `w` and goes on along `d`, without the cosine, and the density with which
    /// [`Boundary::enter`] finds it.
    pub(super) fn entering(&self, w: Vec3, d: Vec3) -> (f32, f32) {
        let Some(x) = self.facets.and_then(|facets| Facet::between(&facets, self.eta, w, d)) else { return (0.0, 0.0) };
        let through = x.cos_o * x.jacobian;
        ((1.0 - x.f) * x.dg * through, x.pdf * through)
    }

    /// Light that travels up along `d` is sent back: its direction, and how much of it there is.
    pub(super) fn send_back(&self, d: Vec3, u: Vec2) -> Option<(Vec3, f32)> {
        // Seen from within: z turned round, the index upside down.
        let up = Vec3::new(-d.x, -d.y, d.z);
        let m = self.facets.map_or(Vec3::Z, |facets| facets.sample(up, u));
        let f = fresnel::dielectric(up.dot(m), 1.0 / self.eta).f;
        let r = reflect(up, m);
        let left = self.facets.map_or(1.0, |facets| facets.unshadowed(up, r, m));
        (r.z > 0.0).then_some((Vec3::new(r.x, r.y, -r.z), f * left))
    }
}
