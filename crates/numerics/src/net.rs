//! Points in four dimensions: the first four coordinates of Sobol's sequence [Sobol 1967], each with a nested uniform scrambling of its own
//! [Owen 1995].
//!
//! The padded pairs of [`crate::Sampler`] are uniform in each pair only. Where an integrand lives in all four dimensions at once (two for a point of a
//! surface, two for a direction), these are: for the indicator of a set with a smooth boundary the variance falls about like N^(-1 - 1/4) instead of
//! 1/N [He, Wang 2015]. The first two coordinates are the (0, 2)-sequence of `Sampler`.
//!
//! Points come in Gray code order, a few operations each [Antonov, Saleev 1979]; the first 2^m of them are the first 2^m of the sequence.

use crate::sequence::{mix, scramble, unit};

/// Direction numbers, bits mirrored: polynomials 1, x + 1, x² + x + 1, x³ + x + 1 with m = 1; 1, 3; 1, 3, 1 [Joe, Kuo 2008].
const DIRECTIONS: [[u32; 32]; 4] =
    [directions(0, 0, [1, 1, 1]), directions(1, 0, [1, 0, 0]), directions(2, 1, [1, 3, 0]), directions(3, 1, [1, 3, 1])];

/// v_k = m_k 2^(32 - k), m_k = 2 a_1 m_(k-1) ⊕ … ⊕ 2^(s-1) a_(s-1) m_(k-s+1) ⊕ 2^s m_(k-s) ⊕ m_(k-s); degree 0 stands for m_k = 1.
const fn directions(degree: usize, coefficients: u32, first: [u32; 3]) -> [u32; 32] {
    let mut m = [1u32; 32];
    let mut k = 0;
    while k < 32 && degree > 0 {
        if k < degree {
            m[k] = first[k];
        } else {
            m[k] = m[k - degree] ^ (m[k - degree] << degree);
            let mut i = 1;
            while i < degree {
                m[k] ^= (coefficients >> (degree - 1 - i) & 1) * (m[k - i] << i);
                i += 1;
            }
        }
        k += 1;
    }
    let mut mirrored = [0; 32];
    k = 0;
    while k < 32 {
        mirrored[k] = (m[k] << (31 - k)).reverse_bits();
        k += 1;
    }
    mirrored
}

/// The points of one scrambling, one after the other.
#[derive(Clone, Debug)]
pub struct Net4 {
    keys: [u32; 4],
    index: u32,
    /// The coordinates before scrambling, bits mirrored.
    at: [u32; 4],
}

impl Net4 {
    /// The scrambling of a seed; `stream` tells independent ones apart.
    pub fn new(seed: u64, stream: u64) -> Self {
        let a = mix(seed ^ mix(stream.wrapping_add(0x9e37_79b9_7f4a_7c15)));
        let b = mix(a ^ 0xd6e8_feb8_6659_fd93);
        Self { keys: [a as u32, (a >> 32) as u32, b as u32, (b >> 32) as u32], index: 0, at: [0; 4] }
    }
}

impl Iterator for Net4 {
    type Item = [f32; 4];

    #[inline]
    fn next(&mut self) -> Option<[f32; 4]> {
        let point = std::array::from_fn(|d| unit(scramble(self.at[d], self.keys[d]).reverse_bits()));
        let bit = self.index.trailing_ones() as usize & 31;
        self.at.iter_mut().zip(&DIRECTIONS).for_each(|(at, directions)| *at ^= directions[bit]);
        self.index = self.index.wrapping_add(1);
        Some(point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every elementary interval of each coordinate, and of the first pair, holds one point; of all four together at most 2^t, t = 3.
    #[test]
    fn points_are_even() {
        for seed in 0..8 {
            let m = 10u32;
            let n = 1usize << m;
            let points: Vec<[f32; 4]> = Net4::new(seed, 5).take(n).collect();
            for d in 0..4 {
                let mut cells: Vec<usize> = points.iter().map(|p| (p[d] * n as f32) as usize).collect();
                cells.sort_unstable();
                assert!(cells.iter().enumerate().all(|(i, c)| i == *c), "coordinate {d}");
            }
            let most = |bits: [u32; 4]| {
                let mut counts = std::collections::BTreeMap::new();
                for p in &points {
                    let cell: [u32; 4] = std::array::from_fn(|d| (p[d] * (1u32 << bits[d]) as f32) as u32);
                    *counts.entry(cell).or_insert(0) += 1;
                }
                counts.into_values().max().unwrap_or(0)
            };
            for a in 0..=m {
                assert_eq!(most([a, m - a, 0, 0]), 1);
                for b in 0..=m - a {
                    for c in 0..=m - a - b {
                        assert!(most([a, b, c, m - a - b - c]) <= 8);
                    }
                }
            }
        }
    }

    #[test]
    fn scramblings_are_unbiased_and_differ() {
        let mean: f64 = (0..4096).map(|s| f64::from(Net4::new(s, 0).next().expect("a point")[2])).sum::<f64>() / 4096.0;
        assert!((mean - 0.5).abs() < 4.0 / (12.0f64 * 4096.0).sqrt());
        assert_ne!(Net4::new(1, 0).next(), Net4::new(0, 1).next());
    }
}
