//! A density over the square, finer where there is more of it: the directional half of the guide [Müller, Gross, Novák 2017, §4.2].
//!
//! ```text
//! p(s) = Π 4 f(quadrant that holds s)          over the nodes from the root down; f its share of the node's weight
//! ```
//!
//! It is made of weighted points: a quadrant that holds more than 16 of them is divided.

use etendue_numerics::Vec2;
use etendue_numerics::math::ONE_MINUS_EPSILON;
use serde::{Deserialize, Serialize};

/// Points that a quadrant may hold undivided.
const FEW: usize = 16;
/// Levels at most: quadrants of 4⁻¹⁰, of a ten thousandth of a steradian.
const DEEPEST: u32 = 10;

/// A node's quadrants: 0 is at the origin, 1 beyond it along x, 2 along y, 3 along both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Node {
    /// f: they sum to 1.
    share: [f32; 4],
    /// The node that a quadrant is divided into; 0 where it is not.
    child: [u32; 4],
}

/// The density.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quadtree(Vec<Node>);

/// A point of the square and its weight.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Where.
    pub s: Vec2,
    /// How much.
    pub weight: f32,
}

/// The quadrant that holds `s`, which becomes its place there.
#[inline]
fn quadrant(s: &mut Vec2) -> usize {
    *s *= 2.0;
    let (right, up) = (s.x >= 1.0, s.y >= 1.0);
    *s -= Vec2::new(f32::from(u8::from(right)), f32::from(u8::from(up)));
    usize::from(right) | usize::from(up) << 1
}

/// Whether the second of two parts with the shares a and b is taken; `u` becomes uniform within the part.
#[inline]
fn choose(u: &mut f32, a: f32, b: f32) -> bool {
    let split = a / (a + b);
    let second = (*u >= split || a <= 0.0) && b > 0.0;
    *u = if second { (*u - split) / (1.0 - split) } else { *u / split };
    *u = u.clamp(0.0, ONE_MINUS_EPSILON);
    second
}

impl Quadtree {
    /// The density of `points`, whose weights are above zero; uniform without any. Their order is changed, and their places become those in their quadrants.
    pub fn new(points: &mut [Point]) -> Self {
        let mut tree = Self(Vec::new());
        tree.grow(points, 1);
        tree
    }

    /// Adds the node of `points` and all below it; its number.
    fn grow(&mut self, points: &mut [Point], depth: u32) -> u32 {
        let id = self.0.len();
        self.0.push(Node { share: [if points.is_empty() { 0.25 } else { 0.0 }; 4], child: [0; 4] });
        points.sort_by_key(|p| quadrant(&mut { p.s }));
        let total: f64 = points.iter().map(|p| f64::from(p.weight)).sum();
        for part in points.chunk_by_mut(|a, b| quadrant(&mut { a.s }) == quadrant(&mut { b.s })) {
            let q = quadrant(&mut { part[0].s });
            let weight: f64 = part.iter().map(|p| f64::from(p.weight)).sum();
            part.iter_mut().for_each(|p| {
                quadrant(&mut p.s);
            });
            let child = if part.len() > FEW && depth < DEEPEST { self.grow(part, depth + 1) } else { 0 };
            let node = &mut self.0[id];
            (node.share[q], node.child[q]) = ((weight / total) as f32, child);
        }
        id as u32
    }

    /// The density at s.
    #[inline]
    pub fn pdf(&self, mut s: Vec2) -> f32 {
        let (mut pdf, mut node) = (1.0, 0);
        loop {
            let n = &self.0[node];
            let q = quadrant(&mut s);
            pdf *= 4.0 * n.share[q];
            node = n.child[q] as usize;
            if node == 0 {
                return pdf;
            }
        }
    }

    /// A point of the square, and the density there. Nearby numbers give nearby points, but for the borders of quadrants.
    #[inline]
    pub fn sample(&self, mut u: Vec2) -> (Vec2, f32) {
        let (mut corner, mut size, mut pdf, mut node) = (Vec2::ZERO, 1.0, 1.0, 0);
        loop {
            let n = &self.0[node];
            let [a, b, c, d] = n.share;
            let right = choose(&mut u.x, a + c, b + d);
            let up = if right { choose(&mut u.y, b, d) } else { choose(&mut u.y, a, c) };
            let q = usize::from(right) | usize::from(up) << 1;
            size *= 0.5;
            corner += size * Vec2::new(f32::from(u8::from(right)), f32::from(u8::from(up)));
            pdf *= 4.0 * n.share[q];
            node = n.child[q] as usize;
            if node == 0 {
                return (corner + size * u, pdf);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_check::{ChiSquareTest, Square};
    use etendue_numerics::{Dim, Sampler, SequenceKind};

    /// Trees of no points, of one, of points in a corner, on a line, all at one place, of very different weights.
    fn trees() -> Vec<(&'static str, Quadtree)> {
        let u = |i: u32| Sampler::new(SequenceKind::Independent, 7, 0, i, 1000).u2(Dim(0));
        let tree = |count: u32, of: &dyn Fn(Vec2) -> (Vec2, f32)| {
            let point = |i| {
                let (s, weight) = of(u(i));
                Point { s, weight }
            };
            Quadtree::new(&mut (0..count).map(point).collect::<Vec<_>>())
        };
        vec![
            ("none", tree(0, &|s| (s, 1.0))),
            ("one", tree(1, &|s| (s, 3.0))),
            ("corner", tree(500, &|s| (1.0 - 0.1 * s * s, 1.0))),
            ("line", tree(500, &|s| (Vec2::new(s.x, 0.7), 1.0))),
            ("place", tree(50, &|_| (Vec2::new(0.3, 0.6), 1.0))),
            ("weights", tree(1000, &|s| (s, 1e-4 + 100.0 * s.x.powi(8)))),
            ("ends", tree(100, &|s| (Vec2::new(s.x.round(), s.y.round()), 1.0))),
        ]
    }

    /// 1 % of false alarms over all trees.
    #[test]
    fn samples_follow_the_density() {
        for (name, tree) in trees() {
            let found = ChiSquareTest::new(Square).run(|[x, y, _]| Some(tree.sample(Vec2::new(x, y)).0), |s: Vec2| tree.pdf(s));
            assert!(found.p_value > 0.01 / 7.0 && (found.mass - 1.0).abs() < 2e-3, "{name}: {found:?}");
        }
    }

    /// What a sample says of its density is the density, and quadrants keep the weight that fell there.
    #[test]
    fn densities_are_those_of_the_samples() {
        for (name, tree) in trees() {
            for i in 0..256 {
                let u = Vec2::new((i % 16) as f32 + 0.5, (i / 16) as f32 + 0.5) / 16.0;
                let (s, pdf) = tree.sample(u);
                assert!((pdf / tree.pdf(s) - 1.0).abs() < 1e-4, "{name} at {s}");
            }
            assert!(tree.0.iter().all(|n| (n.share.iter().sum::<f32>() - 1.0).abs() < 1e-5), "{name}");
        }
        let mut points: Vec<Point> =
            (0..100).map(|i| Point { s: Vec2::new(0.1, 0.01 * i as f32), weight: 1.0 + i as f32 }).collect();
        let upper: f32 = points.iter().filter(|p| p.s.y >= 0.5).map(|p| p.weight).sum();
        assert!((Quadtree::new(&mut points).0[0].share[2] - upper / 5050.0).abs() < 1e-6);
    }
}
