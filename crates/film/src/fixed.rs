//! Exact sums of f32: 128-bit fixed point with 64 bits after the point.
//!
//! Every f32 of magnitude in [2⁻⁴⁰, 2⁶²) is represented exactly, smaller ones to within 2⁻⁶⁴; sums are integer sums and so have no
//! order. Sums wrap only beyond 2⁶³, which `from_f32` makes unreachable by clamping each term to 2⁵⁰ (that is 8192 such terms).

use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign};

/// An exact sum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fixed(pub i128);

const FRACTION_BITS: i32 = 64;
/// The largest magnitude of a single term, 2⁵⁰.
const LARGEST_EXPONENT: i32 = 50;

impl Fixed {
    /// Nothing.
    pub const ZERO: Self = Self(0);

    /// The number x, clamped to ±2⁵⁰; zero for NaN.
    #[inline]
    pub fn from_f32(x: f32) -> Self {
        let bits = x.to_bits();
        let exponent = (bits >> 23 & 0xff) as i32;
        let shift = exponent - 150 + FRACTION_BITS;
        if (1..64).contains(&shift) {
            // Nearly all numbers, by shifts of 64 bits: those of 128 are slow.
            let mantissa = u64::from(bits & 0x007f_ffff | 0x0080_0000);
            let magnitude = i128::from(mantissa >> (64 - shift)) << 64 | i128::from(mantissa << shift);
            let sign = i128::from(bits as i32 >> 31);
            return Self((magnitude ^ sign) - sign);
        }
        if exponent == 0 || x.is_nan() {
            return Self::ZERO; // zero, or a subnormal below 2⁻¹²⁶
        }
        let magnitude = if exponent - 127 >= LARGEST_EXPONENT {
            1i128 << (FRACTION_BITS + LARGEST_EXPONENT)
        } else {
            // x = mantissa · 2^(exponent - 150)
            let mantissa = i128::from(bits & 0x007f_ffff | 0x0080_0000);
            if shift >= 0 { mantissa << shift } else { mantissa >> (-shift).min(127) }
        };
        Self(if x.is_sign_negative() { -magnitude } else { magnitude })
    }

    /// The number x, rounded to 2⁻⁶⁴ and clamped to ±2⁵⁰; zero for NaN.
    #[inline]
    pub fn from_f64(x: f64) -> Self {
        let bound = (f64::from(LARGEST_EXPONENT)).exp2();
        Self((x.clamp(-bound, bound) * 18_446_744_073_709_551_616.0) as i128)
    }

    /// The sum as f64, rounded once.
    #[inline]
    pub fn to_f64(self) -> f64 {
        self.0 as f64 / 18_446_744_073_709_551_616.0
    }
}

/// Exact sums of three channels, and one to spare: a cache line. Their halves lie apart, so that all are added to at once.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(crate) struct Channels {
    low: [u64; 4],
    high: [i64; 4],
}

impl Channels {
    /// The sums.
    pub(crate) fn get(&self) -> [Fixed; 3] {
        std::array::from_fn(|c| Fixed(i128::from(self.high[c]) << 64 | i128::from(self.low[c])))
    }

    /// Adds to the sums.
    pub(crate) fn add(&mut self, terms: &[Fixed; 3]) {
        for (c, (sum, term)) in self.get().into_iter().zip(terms).enumerate() {
            let sum = sum + *term;
            (self.low[c], self.high[c]) = (sum.0 as u64, (sum.0 >> 64) as i64);
        }
    }
}

/// A term of each channel, to be added many times with different weights: taken apart once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terms {
    mantissa: [i32; 4],
    /// How far the product is shifted into the lower half of the sum, and into the upper.
    low: [u64; 4],
    high: [u64; 4],
    /// How far before that, to the right: what is very small.
    shrink: [u64; 4],
}

impl Terms {
    /// Bits of a weight after the point.
    pub(crate) const WEIGHT_BITS: i32 = 24;

    /// Four numbers, clamped to ±2⁵⁰; zero for NaN.
    #[inline(always)]
    pub(crate) fn new(x: [f32; 4]) -> Self {
        let mut terms = Self { mantissa: [0; 4], low: [0; 4], high: [63; 4], shrink: [0; 4] };
        for (c, x) in x.into_iter().enumerate() {
            let x = x.clamp(-1_125_899_906_842_624.0, 1_125_899_906_842_624.0);
            let bits = x.to_bits();
            let exponent = (bits >> 23 & 0xff) as i32;
            let is_zero = exponent == 0 || x.is_nan();
            let shift = exponent - 150 + FRACTION_BITS - Self::WEIGHT_BITS;
            // At most 4 bits of what is very large do not fit below.
            let mantissa = ((bits & 0x007f_ffff | 0x0080_0000) as i32) << (shift - 63).clamp(0, 4);
            let mantissa = if x.is_sign_negative() { -mantissa } else { mantissa };
            let low = shift.clamp(0, 63);
            terms.mantissa[c] = if is_zero { 0 } else { mantissa };
            terms.low[c] = low as u64;
            terms.high[c] = (64 - low).min(63) as u64;
            terms.shrink[c] = (-shift).clamp(0, 63) as u64;
        }
        terms
    }

    /// Adds each x · weight · 2⁻²⁴, rounded down to 2⁻⁶⁴; |weight| at most 2³⁰.
    #[inline(always)]
    pub(crate) fn add_to(&self, sum: &mut Channels, weight: i32) {
        // At most 24 + 4 + 30 bits. Shifts of 128 bits are slow.
        for c in 0..4 {
            let product = (i64::from(self.mantissa[c]) * i64::from(weight)) >> self.shrink[c];
            let (low, high) = ((product << self.low[c]) as u64, product >> self.high[c]);
            sum.low[c] = sum.low[c].wrapping_add(low);
            let carry = i64::from(sum.low[c] < low);
            sum.high[c] = sum.high[c].wrapping_add(high).wrapping_add(carry);
        }
    }
}

impl Add for Fixed {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self(self.0.wrapping_add(other.0))
    }
}

impl AddAssign for Fixed {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_of_twice_the_precision_are_kept(x in -1e12f64..1e12) {
            prop_assert!((Fixed::from_f64(x).to_f64() - x).abs() <= (-63f64).exp2());
        }

        #[test]
        fn normal_numbers_are_exact(mantissa in -16_777_215i32..=16_777_215, exponent in -64i32..20) {
            let x = mantissa as f32 * (exponent as f32).exp2();
            prop_assume!(x == 0.0 || x.abs() >= (-40f32).exp2());
            prop_assert_eq!(Fixed::from_f32(x).to_f64(), f64::from(x));
        }

        #[test]
        fn weighted_terms_are_products(x in -1e6f32..1e6, scale in -60i32..30, weight in -(1i32 << 26)..1 << 26) {
            let x = x * (scale as f32).exp2();
            let mut sums = Channels::default();
            Terms::new([x, -x, 0.0, x]).add_to(&mut sums, weight);
            let [sum, opposite, nothing] = sums.get();
            let want = f64::from(x) * f64::from(weight) / f64::from(1 << Terms::WEIGHT_BITS);
            for (sum, want) in [(sum, want), (opposite, -want), (nothing, 0.0)] {
                let error = (sum.to_f64() - want).abs();
                prop_assert!(error <= (-62f64).exp2() + 1e-15 * want.abs(), "{error}");
            }
        }

        #[test]
        fn channels_carry(terms in prop::collection::vec((-1e4f32..1e4, -(1i32 << 24)..1 << 24), 1..64)) {
            let mut sums = Channels::default();
            let mut want = [Fixed::ZERO; 3];
            for (x, weight) in terms {
                let mut one = Channels::default();
                let terms = Terms::new([x, 1.0, 1e-9 * x, 0.0]);
                terms.add_to(&mut one, weight);
                terms.add_to(&mut sums, weight);
                want.iter_mut().zip(one.get()).for_each(|(a, b)| *a += b);
            }
            prop_assert_eq!(sums.get(), want);
            let mut twice = sums;
            twice.add(&want);
            prop_assert_eq!(twice.get(), want.map(|w| w + w));
        }

        #[test]
        fn sums_have_no_order(mut xs in prop::collection::vec(-1e12f32..1e12, 1..64)) {
            let sum = |xs: &[f32]| xs.iter().fold(Fixed::ZERO, |a, x| a + Fixed::from_f32(*x));
            let forward = sum(&xs);
            xs.reverse();
            prop_assert_eq!(sum(&xs), forward);
        }

        #[test]
        fn any_bits_are_accepted(bits: u32) {
            let x = f32::from_bits(bits);
            let y = Fixed::from_f32(x).to_f64();
            prop_assert!(y.abs() <= (50f64).exp2());
            if x.is_finite() && x.abs() < (50f32).exp2() {
                prop_assert!((y - f64::from(x)).abs() <= (-63f64).exp2());
            }
        }
    }
}
