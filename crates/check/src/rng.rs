//! A small generator of uniform numbers for tests: splitmix64 [Steele, Lea, Flood 2014].
//!
//! It shares no code with the sequences of the renderer, so that their tests do not lean on themselves.

use glam::Vec2;

/// An endless, seeded stream of uniform numbers in [0, 1).
#[derive(Clone, Debug)]
pub struct Rng(u64);

/// The stream that belongs to `seed`.
pub fn rng(seed: u64) -> Rng {
    Rng::new(seed)
}

impl Rng {
    /// The stream that belongs to `seed`.
    pub fn new(seed: u64) -> Self {
        // Neighbouring seeds must not give shifted copies of one stream, so the seed is scattered first.
        let mut scattered = Self(seed.wrapping_mul(0xd134_2543_de82_ef95) ^ 0x5851_f42d_4c95_7f2d);
        Self(scattered.bits())
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A uniform f64 of 53 bits in [0, 1).
    pub fn u1_f64(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (0.5f64).powi(53)
    }

    /// A uniform f32 of 24 bits in [0, 1).
    pub fn u1(&mut self) -> f32 {
        (self.bits() >> 40) as f32 * (0.5f32).powi(24)
    }

    /// A uniform point in [0, 1)².
    pub fn u2(&mut self) -> Vec2 {
        let x = self.u1();
        Vec2::new(x, self.u1())
    }

    /// A uniform point in [0, 1)³.
    pub fn u3(&mut self) -> [f32; 3] {
        std::array::from_fn(|_| self.u1())
    }

    /// A uniform integer below `n`; 0 for `n` = 0.
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.bits()) * n as u128) >> 64) as usize
    }
}

impl Iterator for Rng {
    type Item = f32;

    fn next(&mut self) -> Option<f32> {
        Some(self.u1())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_uniform_and_streams_differ() {
        let mut r = rng(3);
        let (mut sum, mut squares, n) = (0.0, 0.0, 100_000);
        for _ in 0..n {
            let x = f64::from(r.u1());
            assert!((0.0..1.0).contains(&x));
            sum += x;
            squares += x * x;
        }
        // Standard errors are 0.0009 and 0.0009: five of them, a false alarm in a million.
        assert!((sum / f64::from(n) - 0.5).abs() < 5.0 * 0.0009, "{sum}");
        assert!((squares / f64::from(n) - 1.0 / 3.0).abs() < 5.0 * 0.0009, "{squares}");
        let (a, b): (Vec<_>, Vec<_>) = (rng(1).take(50).collect(), rng(2).take(50).collect());
        assert!(a.iter().all(|x| !b.contains(x)));
    }
}
