//! The principled model for thin sheets [Burley 2015, §4], as Mitsuba 3 defines it: one surface stands for both, symmetric in its sides.
//!
//! With s = spec_trans, d = diff_trans/2 and all directions mirrored so that `wo` lies above:
//!
//! reflection:   f = s F_p D G / (4 cosθ_o cosθ_i) + (1 - s)(1 - d) (base/π · (diffuse + retro, flattened) + sheen (1 - cosθ_d)⁵ · colour)
//! transmission: f = s base (1 - F) D' G' / (4 cosθ_o cosθ_i) + (1 - s) d base/π
//!
//! F_p = (1 - spec_tint) F + spec_tint Schlick(tint R₀). The transmitted lobe is the reflected one turned through the sheet, of
//! roughness (0.65 η - 0.35) · roughness [Burley 2015, fig. 15]; D', G' are taken at the half vector of `wo` and `wi` mirrored. Light is not bent.
//!
//! The transmitted lobe asks that `wi` (not its mirror image) lie behind the facet, which `wi` may do and `wo` in its place may not:
//! at grazing angles the lobe is not reciprocal.

use super::principled_terms::{alphas, diffuse, r0, schlick, tint, unit};
use crate::{
    BsdfSample, Event, Microfacets, Ndf, Scatter,
    fresnel::{self, reflect, schlick_weight},
    local::{clean, clean_eta, clean_f32, cosine_pdf, cosine_sample, smooth},
};
use etendue_numerics::{Spectrum, Vec2, Vec3, math::FRAC_1_PI};

/// What a [`PrincipledThin`] sheet is made of; all but `eta`, `diff_trans` and the rates lie in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipledThinParams {
    /// The colour; default 0.5.
    pub base_color: Spectrum,
    /// Luminance of the base colour where its lanes are not red, green and blue.
    pub luminance: Option<f32>,
    /// Of the specular lobes; α = roughness²; default 0.5.
    pub roughness: f32,
    /// Stretches highlights along local x; default 0.
    pub anisotropic: f32,
    /// Share of the specular lobes against the diffuse ones; default 0.
    pub spec_trans: f32,
    /// Index of the sheet over that of its surroundings; default 1.5.
    pub eta: f32,
    /// Tint of the specular reflection towards the base colour; default 0.
    pub spec_tint: f32,
    /// Grazing sheen; default 0.
    pub sheen: f32,
    /// Its tint towards the base colour; default 0.
    pub sheen_tint: f32,
    /// Blend from diffuse to fake subsurface; default 0.
    pub flatness: f32,
    /// How much of the diffuse light goes through, in [0, 2]: 0 none, 2 all; default 0.
    pub diff_trans: f32,
    /// How often diffuse reflection is sampled, ≥ 0; default 1.
    pub diffuse_reflectance_sampling_rate: f32,
    /// How often specular reflection is sampled, ≥ 0; default 1.
    pub specular_reflectance_sampling_rate: f32,
    /// How often specular transmission is sampled, ≥ 0; default 1.
    pub specular_transmittance_sampling_rate: f32,
    /// How often diffuse transmission is sampled, ≥ 0; default 1.
    pub diffuse_transmittance_sampling_rate: f32,
}

impl Default for PrincipledThinParams {
    fn default() -> Self {
        Self {
            base_color: Spectrum::splat(0.5),
            luminance: None,
            roughness: 0.5,
            anisotropic: 0.0,
            spec_trans: 0.0,
            eta: 1.5,
            spec_tint: 0.0,
            sheen: 0.0,
            sheen_tint: 0.0,
            flatness: 0.0,
            diff_trans: 0.0,
            diffuse_reflectance_sampling_rate: 1.0,
            specular_reflectance_sampling_rate: 1.0,
            specular_transmittance_sampling_rate: 1.0,
            diffuse_transmittance_sampling_rate: 1.0,
        }
    }
}

/// Paper, leaves, curtains, frosted panes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipledThin {
    base: Spectrum,
    /// The base colour over its luminance: hue and saturation alone.
    tint: Spectrum,
    reflecting: Microfacets,
    transmitting: Microfacets,
    roughness: f32,
    spec_trans: f32,
    sheet: f32,
    spec_tint: f32,
    sheen: f32,
    sheen_tint: f32,
    flatness: f32,
    diff_trans: f32,
    /// Probabilities of specular reflection, specular transmission, diffuse reflection, diffuse transmission; they sum to 1, or all are 0.
    p: [f32; 4],
}

impl PrincipledThin {
    /// The lobe of these parameters.
    pub fn new(p: PrincipledThinParams) -> Self {
        let (roughness, sheet, anisotropic) = (unit(p.roughness), clean_eta(p.eta), unit(p.anisotropic));
        let facets = |roughness: f32| {
            let alpha = alphas(roughness, anisotropic);
            Microfacets::new(Ndf::Ggx, alpha.x, alpha.y, true)
        };
        let (s, d) = (unit(p.spec_trans), 0.5 * clean_f32(p.diff_trans, 0.0, 2.0, 0.0));
        let rate = |x: f32| clean_f32(x, 0.0, 1e6, 1.0);
        let shares = [
            0.5 * s * rate(p.specular_reflectance_sampling_rate),
            0.5 * s * rate(p.specular_transmittance_sampling_rate),
            (1.0 - s) * (1.0 - d) * rate(p.diffuse_reflectance_sampling_rate),
            (1.0 - s) * d * rate(p.diffuse_transmittance_sampling_rate),
        ];
        let sum: f32 = shares.iter().sum();
        Self {
            base: clean(p.base_color),
            tint: tint(clean(p.base_color), p.luminance),
            reflecting: facets(roughness),
            transmitting: facets((0.65 * sheet - 0.35) * roughness),
            roughness,
            spec_trans: s,
            sheet,
            spec_tint: unit(p.spec_tint),
            sheen: unit(p.sheen),
            sheen_tint: unit(p.sheen_tint),
            flatness: unit(p.flatness),
            diff_trans: d,
            p: shares.map(|x| if sum > 0.0 { x / sum } else { 0.0 }),
        }
    }
}

/// Both directions mirrored so that the first lies above.
#[inline]
fn turned_up(wo: Vec3, wi: Vec3) -> (Vec3, Vec3) {
    if wo.z < 0.0 { (-wo, -wi) } else { (wo, wi) }
}

/// The half vector of `wo` and `wi` mirrored to its side, where `wo` sees it and `wi` leaves it as reflection or transmission should.
#[inline]
fn half_vector(wo: Vec3, wi: Vec3) -> Option<Vec3> {
    let m = (wo + Vec3::new(wi.x, wi.y, wi.z.abs())).try_normalize()?;
    (wo.dot(m) > 0.0 && wi.dot(m) * wi.z > 0.0).then_some(m)
}

impl Scatter for PrincipledThin {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        if wo.z == 0.0 || wi.z == 0.0 {
            return Spectrum::ZERO;
        }
        let (wo, wi) = turned_up(wo, wi);
        let reflects = wi.z > 0.0;
        let mut f = Spectrum::ZERO;

        if self.spec_trans > 0.0
            && let Some(m) = half_vector(wo, wi)
        {
            let cos = wo.dot(m);
            let fresnel = fresnel::dielectric(cos, self.sheet).f;
            if reflects {
                let tinted = if self.spec_tint > 0.0 {
                    Spectrum::lerp(schlick(cos, self.sheet), self.tint * r0(self.sheet), Spectrum::ONE)
                } else {
                    Spectrum::ZERO
                };
                let fresnel = Spectrum::lerp(self.spec_tint, Spectrum::splat(fresnel), tinted);
                f += fresnel * (0.25 * self.spec_trans * self.reflecting.dg(wo, wi, m));
            } else {
                f += self.base * (0.25 * self.spec_trans * (1.0 - fresnel) * self.transmitting.dg(wo, wi, m));
            }
        }

        let opaque = 1.0 - self.spec_trans;
        if reflects && opaque > 0.0 && self.diff_trans < 1.0 {
            let cos_d = (wo + wi).try_normalize().map_or(0.0, |m| m.dot(wi));
            let kept = opaque * (1.0 - self.diff_trans);
            f += self.base * (kept * FRAC_1_PI * diffuse(self.roughness, self.flatness, wo.z, wi.z, cos_d));
            if self.sheen > 0.0 {
                let colour = Spectrum::lerp(self.sheen_tint, Spectrum::ONE, self.tint);
                f += colour * (kept * self.sheen * schlick_weight(cos_d.abs()));
            }
        } else if !reflects {
            f += self.base * (opaque * self.diff_trans * FRAC_1_PI);
        }
        f
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z == 0.0 || wi.z == 0.0 {
            return 0.0;
        }
        let (wo, wi) = turned_up(wo, wi);
        let [rs, ts, rd, td] = self.p;
        let (glossy, facets, broad) = if wi.z > 0.0 { (rs, &self.reflecting, rd) } else { (ts, &self.transmitting, td) };
        let mut pdf = broad * cosine_pdf(Vec3::new(wi.x, wi.y, wi.z.abs()));
        if glossy > 0.0
            && let Some(m) = half_vector(wo, wi)
        {
            // The mirrored direction makes the same angle with m as wo.
            pdf += glossy * facets.pdf(wo, m) / (4.0 * wo.dot(m));
        }
        pdf
    }

    fn sample(&self, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 || self.p == [0.0; 4] {
            return None;
        }
        let (up, _) = turned_up(wo, wo);
        let [rs, ts, rd, _] = self.p;
        let through = |w: Vec3| Vec3::new(w.x, w.y, -w.z);
        let (wi, event) = if u1 < rs {
            (reflect(up, self.reflecting.sample(up, u2)), Event::REFLECT | Event::GLOSSY)
        } else if u1 < rs + ts {
            (through(reflect(up, self.transmitting.sample(up, u2))), Event::TRANSMIT | Event::GLOSSY)
        } else if u1 < rs + ts + rd {
            (cosine_sample(u2)?, Event::REFLECT | Event::DIFFUSE)
        } else {
            (through(cosine_sample(u2)?), Event::TRANSMIT | Event::DIFFUSE)
        };
        if (wi.z < 0.0) != event.transmits() || (!event.intersects(Event::DIFFUSE) && half_vector(up, wi).is_none()) {
            return None;
        }
        let wi = if wo.z < 0.0 { -wi } else { wi };
        smooth(wi, self.eval(wo, wi), self.pdf(wo, wi), 1.0, event)
    }

    fn events(&self) -> Event {
        let mut events = Event::REFLECT;
        if self.spec_trans > 0.0 {
            events |= Event::TRANSMIT | Event::GLOSSY;
        }
        if self.spec_trans < 1.0 {
            events |= Event::DIFFUSE;
            if self.diff_trans > 0.0 {
                events |= Event::TRANSMIT;
            }
        }
        events
    }

    fn albedo(&self, _wo: Vec3) -> Spectrum {
        self.base
    }

    fn diffuse_reflectance(&self) -> Spectrum {
        self.base
    }

    fn roughness(&self) -> f32 {
        if self.spec_trans > 0.0 { self.reflecting.min_alpha().min(self.transmitting.min_alpha()) } else { 1.0 }
    }

    fn importance(&self) -> f32 {
        self.base.max_lane().max(0.1)
    }
}
