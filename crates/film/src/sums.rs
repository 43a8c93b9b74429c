//! What a film's sums are made of, and all of them together.

use crate::fixed::Fixed;
use etendue_numerics::Vec4;
use serde::{Deserialize, Serialize};

/// The sums of a pixel: Σ k L over three channels, Σ k, and three channels of splats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Pixel {
    light: [Fixed; 3],
    weight: Fixed,
}

impl Pixel {
    #[inline]
    pub(crate) fn add(&mut self, sum: Vec4) {
        for (channel, v) in self.light.iter_mut().zip([sum.x, sum.y, sum.z]) {
            *channel += Fixed::from_f32(v);
        }
        self.weight += Fixed::from_f32(sum.w);
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        for (a, b) in self.light.iter_mut().zip(other.light) {
            *a += b;
        }
        self.weight += other.weight;
    }

    pub(crate) fn value(&self) -> [f32; 3] {
        let weight = self.weight.to_f64();
        if weight > 0.0 { self.light.map(|c| (c.to_f64() / weight) as f32) } else { [0.0; 3] }
    }
}

/// A sample that was dropped because it was not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct NonFinite {
    /// Its pixel.
    pub pixel: [u32; 2],
    /// Its number.
    pub sample: u32,
}

impl NonFinite {
    /// How many are remembered; all are counted.
    pub const KEPT: usize = 8;
}

/// Everything that a film has measured, for checkpoints and merging.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sums {
    pub(crate) size: [u32; 2],
    pub(crate) pixels: Vec<Pixel>,
    pub(crate) splats: Vec<[Fixed; 3]>,
    pub(crate) started: u64,
    pub(crate) dropped_count: u64,
    pub(crate) dropped: Vec<NonFinite>,
}

impl Sums {
    /// Pixels of the picture.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }
}
