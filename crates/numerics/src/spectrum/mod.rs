//! Radiometric quantities: four lanes of f32.
//!
//! In RGB mode lanes 0 to 2 hold linear Rec.709 and lane 3 is zero; in spectral mode each lane holds the value at one hero
//! wavelength. Code above works on lanes alike and never asks which mode it is in.
//!
//! Beside it: what lanes stand for ([`Wavelengths`]), spectra of colours ([`upsample`], [`curve`]), the observer and what turns spectra into linear Rec.709 ([`cie`]), tabulated spectra as inert data ([`sampled`]), the refractive
//! indices that have names ([`ior`]), and so the [`illuminants`]; what darkens hair ([`pigment`]).

pub mod cie;
pub mod curve;
pub mod illuminants;
pub mod ior;
pub mod pigment;
pub mod sampled;
pub mod upsample;
mod wavelengths;

pub use curve::Curve;
pub use sampled::SampledSpectrum;
pub use wavelengths::{Hero, Wavelengths};

use glam::Vec4;
use std::ops::{Add, AddAssign, Div, DivAssign, Index, Mul, MulAssign, Sub};

/// A radiance, a reflectance or a throughput, lane by lane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(transparent)]
pub struct Spectrum(pub Vec4);

impl Spectrum {
    /// No light.
    pub const ZERO: Self = Self(Vec4::ZERO);
    /// One in every lane that RGB mode uses, and in the fourth: the neutral factor.
    pub const ONE: Self = Self(Vec4::ONE);

    /// The same value in every lane.
    #[inline]
    pub const fn splat(x: f32) -> Self {
        Self(Vec4::splat(x))
    }

    /// Linear Rec.709, RGB mode; the fourth lane is zero.
    #[inline]
    pub const fn rgb(r: f32, g: f32, b: f32) -> Self {
        Self(Vec4::new(r, g, b, 0.0))
    }

    /// The first three lanes.
    #[inline]
    pub fn to_rgb(self) -> [f32; 3] {
        [self.0.x, self.0.y, self.0.z]
    }

    /// Whether every lane is exactly zero.
    #[inline]
    pub fn is_zero(self) -> bool {
        self.0 == Vec4::ZERO
    }

    /// Whether every lane is finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.0.is_finite()
    }

    /// The largest lane.
    #[inline]
    pub fn max_lane(self) -> f32 {
        self.0.max_element()
    }

    /// Luminance of an RGB-mode value, 0.2126 R + 0.7152 G + 0.0722 B.
    #[inline]
    pub fn luminance(self) -> f32 {
        self.0.dot(Vec4::new(0.2126, 0.7152, 0.0722, 0.0))
    }

    /// Lane-wise e^x.
    #[inline]
    pub fn exp(self) -> Self {
        self.map(crate::math::exp)
    }

    /// Lane-wise square root; lanes below zero give zero.
    #[inline]
    pub fn sqrt(self) -> Self {
        self.map(crate::math::safe_sqrt)
    }

    /// `f` of every lane.
    #[inline]
    pub fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self(Vec4::new(f(self.0.x), f(self.0.y), f(self.0.z), f(self.0.w)))
    }

    /// Lane-wise maximum with a number.
    #[inline]
    pub fn max(self, x: f32) -> Self {
        Self(self.0.max(Vec4::splat(x)))
    }

    /// Lane-wise clamp.
    #[inline]
    pub fn clamp(self, low: f32, high: f32) -> Self {
        Self(self.0.clamp(Vec4::splat(low), Vec4::splat(high)))
    }

    /// (1 - t) a + t b.
    #[inline]
    pub fn lerp(t: f32, a: Self, b: Self) -> Self {
        a * (1.0 - t) + b * t
    }
}

macro_rules! lanewise {
    ($($op:ident $f:ident),*) => {$(
        impl $op for Spectrum {
            type Output = Self;
            #[inline]
            fn $f(self, other: Self) -> Self { Self(self.0.$f(other.0)) }
        }
    )*};
}
lanewise!(Add add, Sub sub, Mul mul, Div div);

impl Mul<f32> for Spectrum {
    type Output = Self;
    #[inline]
    fn mul(self, x: f32) -> Self {
        Self(self.0 * x)
    }
}

impl Mul<Spectrum> for f32 {
    type Output = Spectrum;
    #[inline]
    fn mul(self, s: Spectrum) -> Spectrum {
        s * self
    }
}

impl Div<f32> for Spectrum {
    type Output = Self;
    #[inline]
    fn div(self, x: f32) -> Self {
        Self(self.0 / x)
    }
}

impl AddAssign for Spectrum {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
}

impl MulAssign for Spectrum {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        self.0 *= other.0;
    }
}

impl MulAssign<f32> for Spectrum {
    #[inline]
    fn mul_assign(&mut self, x: f32) {
        self.0 *= x;
    }
}

impl DivAssign<f32> for Spectrum {
    #[inline]
    fn div_assign(&mut self, x: f32) {
        self.0 /= x;
    }
}

impl Index<usize> for Spectrum {
    type Output = f32;
    #[inline]
    fn index(&self, lane: usize) -> &f32 {
        &self.0[lane]
    }
}

impl std::iter::Sum for Spectrum {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::ZERO, Add::add)
    }
}
