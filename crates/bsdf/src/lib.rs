//! Scattering: f(wi, x, wo) as numbers only.
//!
//! L(x, wo) = Le(x, wo) + ∫ **f(wi, x, wo)** L(RT(x, wi), -wi) |cosθ_i| dwi
//!
//! A material (textures, ids) is evaluated once per hit into a [`Bsdf`]: a Copy value of up to [`Bsdf::MAX_LOBES`] weighted
//! [`Lobe`]s that hold resolved numbers and know nothing of textures, scenes or films. Everything here is a pure function of such a
//! value, two directions and uniform numbers.
//!
//! | symbol | identifier | unit |
//! | --- | --- | --- |
//! | direction given / generated | `wo` / `wi` | unit vectors, local frame with n = +z, both leave the surface |
//! | f(wi, x, wo) | `eval(wo, wi)` | 1/sr, **without** the cosine |
//! | p(wi given wo) | `pdf(wo, wi)` | 1/sr; `pdf(wi, wo)` is the reverse density |
//! | f cosθ_i / p | `BsdfSample::weight` | 1; reflectance over probability for a Dirac choice |
//! | η = η_t/η_i | `eta` | relative index from the side of `wo` to the side of `wi` |
//!
//! **Importance form.** Lobes obey f(wo, wi)/η_i² = f(wi, wo)/η_o², η_i and η_o the indices on the sides of `wi` and `wo`: nothing is
//! lost or gained by solid angle compression, so that energy tests read "at most 1". Who carries radiance multiplies
//! transmission by 1/η² [Veach 1997, §5.2]; this happens in one place, outside this crate.
//!
//! `eval` and `pdf` see only the smooth part. Dirac parts (mirrors, smooth glass, null) appear in `sample` alone.
//!
//! Adding a model is one file in `lobes/`, one line in `lobe.rs`, one row in `tests/battery.rs`.

mod bsdf;
mod event;
pub mod fresnel;
mod lobe;
pub mod lobes;
mod local;
pub mod microfacet;
mod perturbation;
mod slot;
mod together;

pub use bsdf::Bsdf;
pub use event::Event;
pub use lobe::Lobe;
pub use microfacet::{Microfacets, Ndf};
pub use perturbation::Perturbation;
pub use together::{Draw, Pair, Together};

use etendue_numerics::{Pdf, Spectrum, Vec2, Vec3};

/// A direction drawn from a scattering function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// The generated direction, a unit vector that leaves the surface.
    pub wi: Vec3,
    /// f |cosθ_i| / p, or reflectance over probability for a Dirac choice; finite and not negative.
    pub weight: Spectrum,
    /// The density per steradian of the whole smooth part at `wi`, or the probability of a Dirac choice.
    pub pdf: Pdf,
    /// η_t/η_i along the sampled direction where it crosses an interface, else 1.
    pub eta: f32,
    /// What happened.
    pub event: Event,
}

/// The contract of a scattering model: three functions that agree with each other, in this order everywhere.
///
/// For every `wo` and every test function g: E[weight · g(wi)] = ∫ f(wo, wi) g(wi) |cosθ_i| dwi plus the Dirac parts, the
/// smooth samples are distributed by `pdf`, and ∫ pdf dwi is the probability that `sample` returns a smooth sample.
pub trait Scatter {
    /// f(wo, wi) in 1/sr without the cosine, importance form; zero for Dirac parts.
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum;
    /// The density per steradian with which [`Scatter::sample`] generates `wi`, given `wo`; zero for Dirac parts.
    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32;
    /// A direction for the uniform numbers `u1` (which part) and `u2` (where), all in [0, 1); `None` where the light is absorbed.
    fn sample(&self, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample>;

    /// Hands over each Dirac direction with all that it carries as its weight, as if it were the only choice (probability 1): what
    /// [`Scatter::sample`] draws by chance, a tree of rays follows in full. Directions that carry nothing are left out.
    fn diracs(&self, _wo: Vec3, _found: &mut dyn FnMut(BsdfSample)) {}

    /// Both [`Scatter::eval`] and [`Scatter::pdf`], for less than the price of two: next event estimation asks for both.
    #[inline]
    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        (self.eval(wo, wi), self.pdf(wo, wi))
    }

    /// Every event that [`Scatter::sample`] may return.
    fn events(&self) -> Event;
    /// About how much of the light from `wo` is scattered, in [0, 1]: a feature for denoisers and guides, not a physical claim.
    fn albedo(&self, wo: Vec3) -> Spectrum;
    /// The diffuse part of it: π f at normal incidence of the diffuse part, or the base colour where a model has one.
    fn diffuse_reflectance(&self) -> Spectrum {
        Spectrum::ZERO
    }
    /// About how wide the narrowest part is: 0 for Dirac parts, microfacet alpha, 1 for diffuse.
    fn roughness(&self) -> f32;
    /// Interior over exterior index of refraction; 1 where directions cross unbent.
    fn eta(&self) -> f32 {
        1.0
    }
    /// How much of the light passes straight through without an event that matters: the null part, Dirac.
    fn transparency(&self, _wo: Vec3) -> Spectrum {
        Spectrum::ZERO
    }
    /// How often this lobe should be chosen among others, independent of direction: an upper guess of its reflectance.
    fn importance(&self) -> f32;
}
