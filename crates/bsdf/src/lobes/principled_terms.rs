//! The terms that both principled models are sums of [Burley 2012; Burley 2015].
//!
//! | term | value |
//! | --- | --- |
//! | Schlick | R₀ + (1 - R₀)(1 - cosθ)⁵, with the refracted angle where light comes from the denser side |
//! | diffuse | (1 - ½F_o)(1 - ½F_i), F = (1 - cosθ)⁵ |
//! | retro | R_r (F_o + F_i + F_o F_i (R_r - 1)), R_r = 2 roughness cos²θ_d |
//! | fake subsurface | 5/4 (F_ss (1/(cosθ_o + cosθ_i) - ½) + ½) |
//! | clearcoat D | (α² - 1) / (π ln α² (1 + (α² - 1) cos²θ)), "GTR1" |

use crate::fresnel::schlick_weight;
use crate::local::clean_f32;
use etendue_numerics::{
    Spectrum, Vec2, Vec3,
    math::{PI, TAU, lerp, ln, powf, safe_sqrt, sin_cos, sqr},
};

/// A parameter in [0, 1]; NaN gives 0.
pub fn unit(x: f32) -> f32 {
    clean_f32(x, 0.0, 1.0, 0.0)
}

/// α along x and y: roughness² stretched by the aspect √(1 - 0.9 anisotropic), at least 0.001.
pub fn alphas(roughness: f32, anisotropic: f32) -> Vec2 {
    let aspect = (1.0 - 0.9 * anisotropic).sqrt();
    Vec2::new(sqr(roughness) / aspect, sqr(roughness) * aspect).max(Vec2::splat(0.001))
}

/// (1 - cosθ)⁵ of the angle on the less dense side: `cos_i` to the facet, negative from inside; `eta` = interior/exterior.
#[inline]
pub fn schlick(cos_i: f32, eta: f32) -> f32 {
    let (eta_it, eta_ti) = if cos_i >= 0.0 { (eta, 1.0 / eta) } else { (1.0 / eta, eta) };
    if eta_it > 1.0 { schlick_weight(cos_i.abs()) } else { schlick_weight(safe_sqrt(1.0 - (1.0 - sqr(cos_i)) * sqr(eta_ti))) }
}

/// R₀ = ((η - 1)/(η + 1))².
#[inline]
pub fn r0(eta: f32) -> f32 {
    sqr((eta - 1.0) / (eta + 1.0))
}

/// `base` divided by its luminance: hue and saturation alone; 1 for black.
pub fn tint(base: Spectrum, luminance: Option<f32>) -> Spectrum {
    let luminance = luminance.unwrap_or(base.luminance());
    if luminance > 0.0 { base / luminance } else { Spectrum::ONE }
}

/// Diffuse, retro-reflection and fake subsurface, without base colour and 1/π.
#[inline]
pub fn diffuse(roughness: f32, flatness: f32, cos_o: f32, cos_i: f32, cos_d: f32) -> f32 {
    let (fo, fi) = (schlick_weight(cos_o), schlick_weight(cos_i));
    let rr = 2.0 * roughness * sqr(cos_d);
    let straight = (1.0 - 0.5 * fi) * (1.0 - 0.5 * fo) + rr * (fo + fi + fo * fi * (rr - 1.0));
    if flatness == 0.0 {
        return straight;
    }
    let fss = lerp(fo, 1.0, 0.5 * rr) * lerp(fi, 1.0, 0.5 * rr);
    lerp(flatness, straight, 1.25 * (fss * (1.0 / (cos_o + cos_i) - 0.5) + 0.5))
}

/// The clearcoat's distribution of normals, of roughness `alpha` < 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gtr1 {
    alpha: f32,
}

impl Gtr1 {
    /// The roughness of a gloss in [0, 1]: from 0.1 (dull) to 0.001.
    pub fn of_gloss(gloss: f32) -> Self {
        Self { alpha: lerp(gloss, 0.1, 0.001) }
    }

    /// D(m). The denominator is written sin²θ + α² cos²θ, which keeps its digits near the normal.
    #[inline]
    pub fn d(&self, m: Vec3) -> f32 {
        let a2 = sqr(self.alpha);
        let d = (a2 - 1.0) / (PI * ln(a2) * (sqr(m.x) + sqr(m.y) + a2 * sqr(m.z)));
        if d * m.z > 1e-20 { d } else { 0.0 }
    }

    /// A normal, of density D(m) m_z: sin²θ = (α^(2(1 - u)) - α²)/(1 - α²).
    #[inline]
    pub fn sample(&self, u: Vec2) -> Vec3 {
        let a2 = sqr(self.alpha);
        let sin2 = (powf(a2, 1.0 - u.y) - a2) / (1.0 - a2);
        let (sin_phi, cos_phi) = sin_cos(TAU * u.x);
        let sin = safe_sqrt(sin2);
        Vec3::new(sin * cos_phi, sin * sin_phi, safe_sqrt(1.0 - sin2))
    }
}

/// Smith's masking of the clearcoat, GGX of roughness 0.25 whatever its gloss; zero where `m` is seen from behind.
#[inline]
pub fn clearcoat_g1(v: Vec3, m: Vec3) -> f32 {
    if v.dot(m) * v.z <= 0.0 {
        return 0.0;
    }
    let c2 = sqr(v.z);
    2.0 * v.z.abs() / (v.z.abs() + (c2 + sqr(0.25) * (1.0 - c2).max(0.0)).sqrt())
}
