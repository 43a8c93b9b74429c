//! Microfacet distributions: D, the Smith masking G1, and their sampling.
//!
//! | | D(m) | G1(v) |
//! | --- | --- | --- |
//! | GGX | 1 / (π α_x α_y (m_x²/α_x² + m_y²/α_y² + m_z²)²) | 2 / (1 + √(1 + tan²θ_α)) |
//! | Beckmann | exp(-(m_x²/α_x² + m_y²/α_y²)/m_z²) / (π α_x α_y m_z⁴) | a rational fit in a = 1/tanθ_α |
//!
//! tan²θ_α = ((α_x v_x)² + (α_y v_y)²)/v_z² [Walter et al. 2007, eqs. 25, 27, 33, 34; anisotropic form: Heitz 2014, §5.3]. D is per
//! steradian of normals, ∫ D(m) m_z dm = 1. Shadowing and masking are taken as separable, G = G1(wo) G1(wi), but for
//! [`Ndf::GgxCorrelated`], where 1/G = 1/G1(wo) + 1/G1(wi) - 1: facets that are high are seen from both sides [Heitz 2014, eq. 99].
//!
//! G1 is kept as G1(v)/v_z, which stays finite at grazing angles and is what f and the densities need: with it
//! f = F D G1(wo)/cosθ_o G1(wi)/cosθ_i / 4 has no division by a cosine left.
//!
//! Beckmann's rational fit (below 0.35 % from the exact G1) defines the *value* of f, as other renderers have it; the *density* of
//! visible normals uses the exact G1, since that is what the sampling routine follows. So `pdf` describes `sample` exactly.

mod beckmann;
pub mod coat;
mod erf;
pub(crate) mod facet;
pub(crate) mod lanes;
pub mod transmittance;

use etendue_numerics::{
    Vec2, Vec3,
    math::{PI, TAU, exp, ln, safe_sqrt, sin_cos, sin_cos_near, sqr},
};

/// Which distribution of normals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ndf {
    /// Gaussian slopes.
    #[default]
    Beckmann,
    /// Long tails; also named after Trowbridge and Reitz.
    Ggx,
    /// The same, with masking and shadowing that know of each other's height.
    GgxCorrelated,
}

/// A rough surface: its distribution of normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microfacets {
    ndf: Ndf,
    visible: bool,
    alpha: Vec2,
}

impl Ndf {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Beckmann, Self::Ggx, Self::GgxCorrelated];
}

impl Microfacets {
    /// The least roughness; what is smoother should be a Dirac lobe.
    pub const MIN_ALPHA: f32 = 1e-4;

    /// Roughness `alpha_u`, `alpha_v` along local x and y (clamped to [1e-4, 100]; NaN gives 1e-4); `visible`: draw only normals seen from wo.
    pub fn new(ndf: Ndf, alpha_u: f32, alpha_v: f32, visible: bool) -> Self {
        let a = |x: f32| x.clamp(Self::MIN_ALPHA, 100.0).max(Self::MIN_ALPHA);
        Self { ndf, visible, alpha: Vec2::new(a(alpha_u), a(alpha_v)) }
    }

    /// The same of roughness that is clean.
    #[inline(always)]
    pub(crate) fn of_visible(ndf: Ndf, alpha: Vec2) -> Self {
        Self { ndf, visible: true, alpha }
    }

    /// Its distribution.
    #[inline]
    pub fn ndf(&self) -> Ndf {
        self.ndf
    }

    /// Roughness along local x and y.
    #[inline]
    pub fn alpha(&self) -> Vec2 {
        self.alpha
    }

    /// The smaller roughness.
    pub fn min_alpha(&self) -> f32 {
        self.alpha.min_element()
    }

    /// Whether only visible normals are drawn.
    pub fn samples_visible(&self) -> bool {
        self.visible
    }

    /// The distribution widened by 1.2 - 0.2 √|cosθ_o|, which bounds the weights where all normals are drawn
    /// [Walter et al. 2007, §5.3]; unchanged where only visible ones are.
    #[inline]
    pub fn widened(self, cos_o: f32) -> Self {
        if self.visible { self } else { Self { alpha: self.alpha * (1.2 - 0.2 * safe_sqrt(cos_o.abs())), ..self } }
    }

    /// D(m), per steradian of normals; zero below the horizon and where it would underflow.
    #[inline(always)]
    pub fn d(&self, m: Vec3) -> f32 {
        // All squares times (α_x α_y)², which leaves one division.
        let a = self.alpha.x * self.alpha.y;
        let slope2 = sqr(m.x * self.alpha.y) + sqr(m.y * self.alpha.x);
        let d = match self.ndf {
            Ndf::Ggx | Ndf::GgxCorrelated => a * a * a / (PI * sqr(slope2 + sqr(m.z * a))),
            Ndf::Beckmann => exp(-slope2 / sqr(m.z * a)) / (PI * a * sqr(sqr(m.z))),
        };
        if d * m.z > 1e-20 { d } else { 0.0 }
    }

    /// G1(v, m)/|v_z|; zero where m is seen from behind.
    #[inline(always)]
    pub fn g1_over_cos(&self, v: Vec3, m: Vec3) -> f32 {
        let (c, s) = (v.z.abs(), self.projected_alpha(v));
        let g1 = match self.ndf {
            Ndf::Ggx | Ndf::GgxCorrelated => 2.0 / (c + (c * c + s * s).sqrt()),
            Ndf::Beckmann => {
                let a = c / s;
                let fit = (3.535 + 2.181 * a) / (s * (1.0 + a * (2.276 + 2.577 * a)));
                if c >= 1.6 * s { 1.0 / c } else { fit }
            }
        };
        if v.dot(m) * v.z > 0.0 { g1 } else { 0.0 }
    }

    /// G1(v, m), the share of m not masked towards v, in [0, 1].
    #[inline]
    pub fn g1(&self, v: Vec3, m: Vec3) -> f32 {
        self.g1_over_cos(v, m) * v.z.abs()
    }

    /// D(m) G/(cosθ_o cosθ_i): what the reflection and transmission lobes share.
    #[inline]
    pub fn dg(&self, wo: Vec3, wi: Vec3, m: Vec3) -> f32 {
        self.d(m) * self.shadowing(wo, wi, self.g1_over_cos(wo, m), self.g1_over_cos(wi, m))
    }

    /// G/(cosθ_o cosθ_i), from G1/cos of both.
    #[inline(always)]
    fn shadowing(&self, wo: Vec3, wi: Vec3, o: f32, i: f32) -> f32 {
        let g = if self.ndf == Ndf::GgxCorrelated { correlated(wo, wi, o, i) } else { o * i };
        if o * i > 0.0 { g } else { 0.0 }
    }

    /// [`Microfacets::dg`], and [`Microfacets::pdf`] over |wo·m|, which share D and the masking of `wo`; `wo` on either side.
    #[inline(always)]
    pub fn dg_pdf(&self, wo: Vec3, wi: Vec3, m: Vec3) -> (f32, f32) {
        let (d, o) = (self.d(m), self.g1_over_cos(wo, m));
        let masking = match self.ndf {
            _ if !self.visible => m.z.max(0.0) / wo.dot(m).abs(),
            Ndf::Ggx | Ndf::GgxCorrelated => o,
            Ndf::Beckmann => beckmann::g1_over_cos(wo.z.abs(), self.projected_alpha(wo)),
        };
        let pdf = if o > 0.0 { d * masking } else { 0.0 };
        (d * self.shadowing(wo, wi, o, self.g1_over_cos(wi, m)), pdf)
    }

    /// G(wo, wi, m)/G1(wo, m): what is left of light that met the visible facet m.
    #[inline]
    pub fn unshadowed(&self, wo: Vec3, wi: Vec3, m: Vec3) -> f32 {
        let (o, i) = (self.g1_over_cos(wo, m), self.g1_over_cos(wi, m));
        if o * i <= 0.0 {
            return 0.0;
        }
        wi.z.abs() * if self.ndf == Ndf::GgxCorrelated { correlated(wo, wi, o, i) / o } else { i }
    }

    /// The density of [`Microfacets::sample`] per steradian of normals; `wo` and `m` in the upper hemisphere.
    ///
    /// Visible: D(m) G1(wo) (wo·m)/cosθ_o [Heitz 2014, eq. 2]; else D(m) m_z.
    #[inline]
    pub fn pdf(&self, wo: Vec3, m: Vec3) -> f32 {
        if !self.visible {
            return self.d(m) * m.z.max(0.0);
        }
        let cos = wo.dot(m);
        if cos <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let masking = match self.ndf {
            Ndf::Ggx | Ndf::GgxCorrelated => self.g1_over_cos(wo, m),
            Ndf::Beckmann => beckmann::g1_over_cos(wo.z, self.projected_alpha(wo)),
        };
        self.d(m) * masking * cos
    }

    /// A normal for `wo` in the upper hemisphere.
    #[inline]
    pub fn sample(&self, wo: Vec3, u: Vec2) -> Vec3 {
        if !self.visible {
            return self.sample_all(u);
        }
        match self.ndf {
            Ndf::Ggx | Ndf::GgxCorrelated => self.sample_ggx(wo, u),
            Ndf::Beckmann => self.stretched(wo, |v| beckmann::visible_normal(v, u)),
        }
    }

    /// A visible normal of GGX.
    #[inline(always)]
    pub(crate) fn sample_ggx(&self, wo: Vec3, u: Vec2) -> Vec3 {
        self.stretched(wo, |v| spherical_cap(v, u))
    }

    /// A visible normal, drawn by `draw` for the surface of roughness 1: that of the stretched surface, seen from the stretched direction
    /// [Heitz 2018, §3].
    #[inline(always)]
    fn stretched(&self, wo: Vec3, draw: impl Fn(Vec3) -> Vec3) -> Vec3 {
        self.unstretched(draw(self.stretched_direction(wo)))
    }

    /// `wo` as the surface of roughness 1 is seen.
    #[inline(always)]
    pub(crate) fn stretched_direction(&self, wo: Vec3) -> Vec3 {
        Vec3::new(self.alpha.x * wo.x, self.alpha.y * wo.y, wo.z).normalize()
    }

    /// The normal that is `h`, of any length, on the surface of roughness 1.
    #[inline(always)]
    pub(crate) fn unstretched(&self, h: Vec3) -> Vec3 {
        let m = Vec3::new(self.alpha.x * h.x, self.alpha.y * h.y, h.z.max(0.0));
        let scale = m.length_recip();
        if scale.is_finite() & (scale > 0.0) { m * scale } else { Vec3::Z }
    }

    /// A normal with density D(m) m_z [Walter et al. 2007, eqs. 28, 35]: slopes of the surface of roughness 1, stretched.
    fn sample_all(&self, u: Vec2) -> Vec3 {
        let (sin, cos) = sin_cos(TAU * u.y);
        let tan = match self.ndf {
            Ndf::Ggx | Ndf::GgxCorrelated => (u.x / (1.0 - u.x)).sqrt(),
            Ndf::Beckmann => safe_sqrt(-ln(1.0 - u.x)),
        };
        Vec3::new(self.alpha.x * tan * cos, self.alpha.y * tan * sin, 1.0).normalize()
    }

    /// √((α_x v_x)² + (α_y v_y)²): the roughness that `v` sees, times sinθ.
    #[inline(always)]
    fn projected_alpha(&self, v: Vec3) -> f32 {
        (sqr(self.alpha.x * v.x) + sqr(self.alpha.y * v.y)).sqrt()
    }
}

/// G/(cosθ_o cosθ_i) of correlated facets, from G1/cos of both.
#[inline(always)]
fn correlated(wo: Vec3, wi: Vec3, o: f32, i: f32) -> f32 {
    let (co, ci) = (wo.z.abs(), wi.z.abs());
    1.0 / (ci / o + co / i - co * ci)
}

/// A visible normal of the GGX surface of roughness 1 seen from `v`: `v` plus a point on the spherical cap z > -v_z, not
/// normalised [Dupuy and Benyoub 2023, Listing 3].
#[inline(always)]
fn spherical_cap(v: Vec3, u: Vec2) -> Vec3 {
    let z = (1.0 - u.y) * (1.0 + v.z) - v.z;
    let (sin, cos) = sin_cos_near(TAU * u.x);
    let r = safe_sqrt(1.0 - z * z);
    v + Vec3::new(r * cos, r * sin, z)
}
