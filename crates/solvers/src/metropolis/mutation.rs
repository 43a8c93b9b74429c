//! Steps in primary sample space.
//!
//! ```text
//! small:  u' = u ± l e^(-ξ ln(l/s))  mod 1        l = `largest`, s = `smallest`: distances with a density ∝ 1/distance     [Kelemen et al. 2002, §3.1]
//! large:  u' = ξ
//! ```
//!
//! Both are as likely one way as the other. All numbers that a path of the class may ask for move at every step: which ones it does ask for depends on
//! the path, and a step that moved only these could not be taken back.

use crate::transport::{light_slot, slot};
use etendue_numerics::math::{exp, ln};
use etendue_numerics::{Dim, Sampler, Vec2};

/// How chains move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mutation {
    /// Probability of a large step.
    pub large_step: f32,
    /// s.
    pub smallest: f32,
    /// l.
    pub largest: f32,
}

impl Default for Mutation {
    fn default() -> Self {
        Self { large_step: 0.3, smallest: 1.0 / 1024.0, largest: 1.0 / 16.0 }
    }
}

/// The random decisions at vertex 0 of both walks.
const FIRST: [u32; 9] = [
    slot::PIXEL,
    slot::LENS,
    slot::TIME,
    slot::STRATEGY,
    slot::WAVELENGTHS,
    light_slot::LIGHT,
    light_slot::POSITION,
    light_slot::DIRECTION,
    light_slot::LENS,
];
/// The random decisions at all others.
const LATER: [u32; 7] =
    [slot::BSDF, slot::LOBE, slot::LIGHT, slot::LIGHT_POINT, light_slot::BSDF, light_slot::LOBE, light_slot::LENS];

/// The addresses of all numbers that paths of so many vertices may ask for.
#[inline]
pub fn addresses(vertices: u32) -> impl Iterator<Item = Dim> {
    let at = |vertex: u32, slots: &'static [u32]| slots.iter().map(move |s| Dim::at(vertex, *s));
    at(0, &FIRST).chain((1..vertices).flat_map(move |v| at(v, &LATER)))
}

/// Length of a vector with room for all of them.
pub fn room(vertices: u32) -> usize {
    (vertices * Dim::SLOTS) as usize
}

/// A large step: all numbers are those of `u`.
pub fn fill(vector: &mut [Vec2], vertices: u32, u: &Sampler) {
    for d in addresses(vertices) {
        vector[d.0 as usize] = u.u2(d);
    }
}

impl Mutation {
    /// A small step from `x`, by the numbers of `u`.
    #[inline]
    pub fn small(&self, x: &[Vec2], y: &mut [Vec2], vertices: u32, u: &Sampler) {
        let (low, high) = (self.smallest.min(self.largest), self.smallest.max(self.largest));
        let range = ln(high / low);
        let moved = |x: f32, xi: f32| {
            let (sign, xi) = if xi < 0.5 { (1.0, 2.0 * xi) } else { (-1.0, 2.0 * xi - 1.0) };
            around(x + sign * high * exp(-range * xi))
        };
        for d in addresses(vertices) {
            let (i, xi) = (d.0 as usize, u.u2(d));
            y[i] = Vec2::new(moved(x[i].x, xi.x), moved(x[i].y, xi.y));
        }
    }
}

/// u mod 1, for u a little below 0 or above 1.
#[inline]
fn around(u: f32) -> f32 {
    // What is next to nothing below 0 rounds to 1.
    if u < 0.0 { (u + 1.0).min(1.0f32.next_down()) } else { u - f32::from(u8::from(u >= 1.0)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_numerics::SequenceKind;

    /// Small steps stay in [0, 1), move by what they say and are as likely one way as the other, and leave a uniform number uniform.
    #[test]
    fn small_steps_are_symmetric_and_keep_the_measure() {
        let m = Mutation::default();
        let (vertices, n) = (2, 20_000u32);
        let mut y = vec![Vec2::ZERO; room(vertices)];
        let (mut bins, mut up, mut logs) = ([0u32; 16], 0, Vec::new());
        for i in 0..n {
            let u = Sampler::new(SequenceKind::Independent, 1, 0, i, n);
            let x = vec![Vec2::splat(u.u1(Dim(15))); room(vertices)];
            m.small(&x, &mut y, vertices, &u);
            let (a, b) = (x[0].x, y[0].x);
            assert!((0.0..1.0).contains(&b) && addresses(vertices).all(|d| y[d.0 as usize].max_element() < 1.0));
            bins[(b * 16.0) as usize] += 1;
            let d = b - a - (b - a).round();
            up += u32::from(d > 0.0);
            assert!((m.smallest * 0.99..m.largest * 1.01).contains(&d.abs()), "{a} to {b}");
            logs.push(f64::from(d.abs()).ln());
        }
        // Five standard errors.
        let expected = f64::from(n) / 16.0;
        assert!(bins.iter().all(|b| (f64::from(*b) - expected).abs() < 5.0 * expected.sqrt()), "{bins:?}");
        assert!((f64::from(up) / f64::from(n) - 0.5).abs() < 5.0 * 0.5 / f64::from(n).sqrt(), "{up}");
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        let (low, high) = (f64::from(m.smallest).ln(), f64::from(m.largest).ln());
        assert!((mean - 0.5 * (low + high)).abs() < 5.0 * (high - low) / (12.0 * f64::from(n)).sqrt(), "{mean}");
    }

    #[test]
    fn the_ends_of_the_interval_are_one_place() {
        for (u, want) in [(-1e-12, 1.0f32.next_down()), (1.0, 0.0), (1.25, 0.25), (-0.25, 0.75), (0.5, 0.5)] {
            assert_eq!(around(u), want);
        }
    }
}
