//! What lies under the layer.

use super::super::rough_conductor::{half_vector, reflected_pdf};
use super::Ground;
use crate::fresnel::{self, reflect, reflect_z};
use crate::local::{clean, cosine_pdf, cosine_sample};
use crate::{Microfacets, Ndf};
use etendue_numerics::math::FRAC_1_PI;
use etendue_numerics::{Spectrum, Vec2, Vec3};

/// The ground as walks meet it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Base {
    Diffuse(Spectrum),
    Mirror(Spectrum, Spectrum),
    Metal(Spectrum, Spectrum, Microfacets),
}

/// GGX facets of this roughness along x and y.
pub(super) fn rough([u, v]: [f32; 2]) -> Microfacets {
    Microfacets::new(Ndf::GgxCorrelated, u, v, true)
}

impl Base {
    pub(super) fn of(ground: Ground) -> Self {
        match ground {
            Ground::Diffuse(rho) => Self::Diffuse(clean(rho).clamp(0.0, 1.0)),
            Ground::Metal(n, k, None) => Self::Mirror(clean(n), clean(k)),
            Ground::Metal(n, k, Some(alpha)) => Self::Metal(clean(n), clean(k), rough(alpha)),
        }
    }

    /// f of the ground without the cosine, and the density with which [`Base::bounce`] finds the direction; both directions leave it.
    pub(super) fn f(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        match *self {
            Self::Diffuse(rho) if wo.z > 0.0 && wi.z > 0.0 => (rho * FRAC_1_PI, cosine_pdf(wi)),
            Self::Metal(n, k, facets) => half_vector(wo, wi).map_or((Spectrum::ZERO, 0.0), |m| {
                let f = fresnel::conductor(wo.dot(m).clamp(0.0, 1.0), n, k) * (0.25 * facets.dg(wo, wi, m));
                (f, reflected_pdf(&facets, wo, m))
            }),
            _ => (Spectrum::ZERO, 0.0),
        }
    }

    /// A direction off the ground, f cosθ / p, and p; none of a mirror.
    pub(super) fn bounce(&self, wo: Vec3, u: Vec2) -> Option<(Vec3, Spectrum, Option<f32>)> {
        match *self {
            Self::Diffuse(rho) => cosine_sample(u).map(|wi| (wi, rho, Some(cosine_pdf(wi)))),
            Self::Mirror(n, k) => Some((reflect_z(wo), fresnel::conductor(wo.z, n, k), None)),
            Self::Metal(n, k, facets) => {
                let m = facets.sample(wo, u);
                let wi = reflect(wo, m);
                if wi.z <= 0.0 {
                    return None;
                }
                let weight = fresnel::conductor(wo.dot(m).clamp(0.0, 1.0), n, k) * facets.unshadowed(wo, wi, m);
                Some((wi, weight, Some(reflected_pdf(&facets, wo, m)))).filter(|s| s.2.is_some_and(|p| p > 0.0))
            }
        }
    }

    /// Reflectance at normal incidence.
    pub(super) fn reflectance(&self) -> Spectrum {
        match *self {
            Self::Diffuse(rho) => rho,
            Self::Mirror(n, k) | Self::Metal(n, k, _) => fresnel::conductor(1.0, n, k),
        }
    }
}
