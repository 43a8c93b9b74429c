//! The principled model for solids [Burley 2012; Burley 2015], as Mitsuba 3 defines it.
//!
//! With b = (1 - metallic)(1 - spec_trans) and t = (1 - metallic) spec_trans:
//!
//! f = F_p D G / (4 cosθ_o cosθ_i)  (GGX, reflection on both sides)
//!   + t √base (1 - F) D G · Jacobian terms of rough refraction
//!   + ¼ clearcoat F_c D_gtr1 G_c
//!   + b base/π · (diffuse + retro, flattened towards fake subsurface)
//!   + (1 - metallic) sheen (1 - cosθ_d)⁵ · (sheen colour), where b > 0.
//!
//! Outside, F_p = (1 - metallic)(1 - spec_tint) F + metallic Schlick(base) + (1 - metallic) spec_tint Schlick(tint R₀); inside, F_p = t F.
//! F is the exact dielectric Fresnel term; where it vanishes (η = 1) so does F_p. The diffuse, sheen and clearcoat terms
//! live on the outside alone. Not lossless and not strictly bounded by 1: the terms are added as artists expect them.
//!
//! Sampling: one part is drawn by the sampling rates; the density is that of the mixture.

use super::{
    faceted::{self, Faceted, Turn},
    principled_terms::{Gtr1, alphas, clearcoat_g1, diffuse, r0, schlick, tint, unit},
};
use crate::{
    BsdfSample, Event, Microfacets, Ndf, Scatter,
    fresnel::{self, reflect, refract, schlick_weight},
    local::{clean, clean_eta, clean_f32, cosine_pdf, cosine_sample, same_side, stretch},
    microfacet::facet::Facet,
};
use etendue_numerics::{Spectrum, Vec2, Vec3, math::FRAC_1_PI};

/// What a [`Principled`] surface is made of; all but `eta` and the rates lie in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipledParams {
    /// The colour; default 0.5.
    pub base_color: Spectrum,
    /// Luminance of the base colour where its lanes are not red, green and blue.
    pub luminance: Option<f32>,
    /// Of the specular lobes; α = roughness²; default 0.5.
    pub roughness: f32,
    /// Stretches highlights along local x; default 0.
    pub anisotropic: f32,
    /// 0 dielectric, 1 metal; default 0.
    pub metallic: f32,
    /// Share of the dielectric that refracts instead of scattering diffusely; default 0.
    pub spec_trans: f32,
    /// Interior/exterior index of refraction; default 1.4888…, which is `specular` 0.5 by [`eta_from_specular`].
    pub eta: f32,
    /// Tint of the dielectric reflection towards the base colour; default 0.
    pub spec_tint: f32,
    /// Grazing sheen of cloth; default 0.
    pub sheen: f32,
    /// Its tint towards the base colour; default 0.
    pub sheen_tint: f32,
    /// Blend from diffuse to fake subsurface; default 0.
    pub flatness: f32,
    /// A second, colourless glossy coat; default 0.
    pub clearcoat: f32,
    /// Its gloss; default 0.
    pub clearcoat_gloss: f32,
    /// How often the diffuse part is sampled, ≥ 0; default 1.
    pub diffuse_reflectance_sampling_rate: f32,
    /// How often the main specular part is sampled, ≥ 0; default 1.
    pub main_specular_sampling_rate: f32,
    /// How often the clearcoat is sampled, ≥ 0; default 1.
    pub clearcoat_sampling_rate: f32,
}

impl Default for PrincipledParams {
    fn default() -> Self {
        Self {
            base_color: Spectrum::splat(0.5),
            luminance: None,
            roughness: 0.5,
            anisotropic: 0.0,
            metallic: 0.0,
            spec_trans: 0.0,
            eta: eta_from_specular(0.5, 0.0),
            spec_tint: 0.0,
            sheen: 0.0,
            sheen_tint: 0.0,
            flatness: 0.0,
            clearcoat: 0.0,
            clearcoat_gloss: 0.0,
            diffuse_reflectance_sampling_rate: 1.0,
            main_specular_sampling_rate: 1.0,
            clearcoat_sampling_rate: 1.0,
        }
    }
}

/// η = 2/(1 - √(0.08 specular)) - 1: `specular` in [0, 1] spans a normal reflectance of 0 to 8 % [Burley 2012, §5.5].
///
/// Where `spec_trans` > 0 a `specular` of 0 is taken as 0.001: an interface without contrast cannot refract.
pub fn eta_from_specular(specular: f32, spec_trans: f32) -> f32 {
    let specular = if specular == 0.0 && spec_trans > 0.0 { 1e-3 } else { unit(specular) };
    2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0
}

/// From metal and glass to cloth, by artist's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled {
    base: Spectrum,
    /// The base colour over its luminance: hue and saturation alone.
    tint: Spectrum,
    facets: Microfacets,
    coat: Gtr1,
    roughness: f32,
    metallic: f32,
    spec_trans: f32,
    eta: f32,
    spec_tint: f32,
    sheen: f32,
    sheen_tint: f32,
    flatness: f32,
    clearcoat: f32,
    diffuse_rate: f32,
    specular_rate: f32,
    clearcoat_rate: f32,
}

/// How often each part is drawn; they sum to 1, or all are 0 where nothing is.
struct Choice {
    diffuse: f32,
    clearcoat: f32,
    specular: f32,
}

impl Principled {
    /// The lobe of these parameters; an index of exactly 1 cannot refract and is taken as 1.001 where `spec_trans` > 0.
    pub fn new(p: PrincipledParams) -> Self {
        let (roughness, spec_trans, eta) = (unit(p.roughness), unit(p.spec_trans), clean_eta(p.eta));
        let alpha = alphas(roughness, unit(p.anisotropic));
        let rate = |x: f32| clean_f32(x, 0.0, 1e6, 1.0);
        Self {
            base: clean(p.base_color),
            tint: tint(clean(p.base_color), p.luminance),
            facets: Microfacets::new(Ndf::Ggx, alpha.x, alpha.y, true),
            coat: Gtr1::of_gloss(unit(p.clearcoat_gloss)),
            roughness,
            metallic: unit(p.metallic),
            spec_trans,
            eta: if spec_trans > 0.0 && (eta - 1.0).abs() < 1e-3 { 1.001 } else { eta },
            spec_tint: unit(p.spec_tint),
            sheen: unit(p.sheen),
            sheen_tint: unit(p.sheen_tint),
            flatness: unit(p.flatness),
            clearcoat: unit(p.clearcoat),
            diffuse_rate: rate(p.diffuse_reflectance_sampling_rate),
            specular_rate: rate(p.main_specular_sampling_rate),
            clearcoat_rate: rate(p.clearcoat_sampling_rate),
        }
    }

    /// b, the weight of the opaque dielectric.
    #[inline]
    fn opaque(&self) -> f32 {
        (1.0 - self.metallic) * (1.0 - self.spec_trans)
    }

    /// t, the weight of the refracting dielectric.
    #[inline]
    fn clear(&self) -> f32 {
        (1.0 - self.metallic) * self.spec_trans
    }

    /// F_p.
    #[inline]
    fn specular_fresnel(&self, f: f32, cos: f32, front: bool) -> Spectrum {
        if !front {
            return Spectrum::splat(self.clear() * f);
        }
        let mut sum = Spectrum::splat((1.0 - self.metallic) * (1.0 - self.spec_tint) * f);
        let s = schlick(cos, self.eta);
        if self.metallic > 0.0 {
            sum += self.metallic * Spectrum::lerp(s, self.base, Spectrum::ONE);
        }
        if self.spec_tint > 0.0 {
            let r0 = self.tint * r0(if cos >= 0.0 { self.eta } else { 1.0 / self.eta });
            sum += (1.0 - self.metallic) * self.spec_tint * Spectrum::lerp(s, r0, Spectrum::ONE);
        }
        sum
    }

    #[inline]
    fn choice(&self, front: bool) -> Choice {
        if !front {
            return Choice { diffuse: 0.0, clearcoat: 0.0, specular: if self.clear() > 0.0 { 1.0 } else { 0.0 } };
        }
        let (d, c, s) = (self.opaque() * self.diffuse_rate, 0.25 * self.clearcoat * self.clearcoat_rate, self.specular_rate);
        let sum = d + c + s;
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        Choice { diffuse: d * scale, clearcoat: c * scale, specular: s * scale }
    }

    /// How often a specular sample is reflected, not refracted, at a facet of dielectric reflectance `f`.
    #[inline]
    fn reflects(&self, f: f32, front: bool) -> f32 {
        if front { 1.0 - self.clear() * (1.0 - f) } else { f }
    }
}

impl Faceted for Principled {
    #[inline]
    fn facets(&self) -> (&Microfacets, f32) {
        (&self.facets, self.eta)
    }

    #[inline]
    fn at(&self, wo: Vec3, _: f32, wi: Vec3, facet: Option<&Facet>) -> (Spectrum, f32) {
        let front = wo.z > 0.0;
        let choice = self.choice(front);
        let (mut f, mut pdf) = (Spectrum::ZERO, choice.diffuse * cosine_pdf(wi));

        // Main specular lobe, both ways, and the coat on top of it.
        if let Some(x) = facet {
            let r = self.reflects(x.f, front);
            pdf += choice.specular * if x.reflects { r } else { 1.0 - r } * x.pdf * x.cos_o * x.jacobian;
            if x.reflects {
                if x.f > 0.0 {
                    f += self.specular_fresnel(x.f, wo.dot(x.m), front) * (0.25 * x.dg);
                }
                if front && self.clearcoat > 0.0 {
                    let (d, fresnel) = (self.coat.d(x.m), 0.04 + 0.96 * schlick(x.cos_o, self.eta));
                    f += Spectrum::splat(0.25 * self.clearcoat * fresnel * d * clearcoat_g1(wo, x.m) * clearcoat_g1(wi, x.m));
                    pdf += choice.clearcoat * d * x.m.z * x.jacobian;
                }
            } else if self.clear() > 0.0 {
                f += self.base.sqrt() * (self.clear() * (1.0 - x.f) * x.dg * x.cos_o * x.jacobian);
            }
        }

        // The opaque base, seen from outside only.
        let opaque = self.opaque();
        if front && wi.z > 0.0 && opaque > 0.0 {
            let cos_d = facet.map_or(0.0, |x| x.m.dot(wi));
            f += self.base * (opaque * FRAC_1_PI * diffuse(self.roughness, self.flatness, wo.z, wi.z, cos_d));
            if self.sheen > 0.0 {
                let colour = Spectrum::lerp(self.sheen_tint, Spectrum::ONE, self.tint);
                f += colour * ((1.0 - self.metallic) * self.sheen * schlick_weight(cos_d.abs()));
            }
        }
        (f, pdf)
    }

    #[inline]
    fn turn(&self, wo: Vec3, _: f32, u1: f32, u2: Vec2, m: impl FnOnce() -> Vec3) -> Option<Turn> {
        if wo.z == 0.0 {
            return None;
        }
        let front = wo.z > 0.0;
        let choice = self.choice(front);
        let (wi, m, event) = if u1 < choice.diffuse {
            (cosine_sample(u2)?, None, Event::REFLECT | Event::DIFFUSE)
        } else if u1 < choice.diffuse + choice.clearcoat {
            (reflect(wo, self.coat.sample(u2)), None, Event::REFLECT | Event::GLOSSY)
        } else {
            let m = m();
            let x = fresnel::dielectric(wo.dot(m), self.eta);
            let u = stretch(u1, choice.diffuse + choice.clearcoat, choice.specular);
            let reflects = u < self.reflects(x.f, front);
            let (wi, way) = if reflects { (reflect(wo, m), Event::REFLECT) } else { (refract(wo, m, &x), Event::TRANSMIT) };
            (wi, Some(m), way | Event::GLOSSY)
        };
        let transmits = event.transmits();
        let path = if front { self.eta } else { 1.0 / self.eta };
        (same_side(wo, wi) != transmits).then_some(Turn { wi, m, eta: if transmits { path } else { 1.0 }, event })
    }
}

impl Scatter for Principled {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        self.eval_pdf(wo, wi).0
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.eval_pdf(wo, wi).1
    }

    fn sample(&self, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample> {
        faceted::sample(self, wo, u1, u2)
    }

    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        faceted::eval_pdf(self, wo, wi)
    }

    fn events(&self) -> Event {
        let base = Event::REFLECT | Event::GLOSSY;
        let base = if self.opaque() > 0.0 { base | Event::DIFFUSE } else { base };
        if self.clear() > 0.0 { base | Event::TRANSMIT } else { base }
    }

    fn albedo(&self, _wo: Vec3) -> Spectrum {
        self.base
    }

    fn diffuse_reflectance(&self) -> Spectrum {
        self.base
    }

    fn roughness(&self) -> f32 {
        self.facets.min_alpha()
    }

    fn eta(&self) -> f32 {
        if self.clear() > 0.0 { self.eta } else { 1.0 }
    }

    fn importance(&self) -> f32 {
        self.base.max_lane().max(0.1)
    }
}
