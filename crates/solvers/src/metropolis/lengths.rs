//! Into which classes paths are put by their length: a chain keeps to one.
//!
//! ```text
//! n edges, n ≤ 10                                        a class each
//! 11 + j edges, P(j) = (1 - q) q^j, q = 0.9              one class, by the number ξ: j = ⌊ln(1 - ξ) / ln q⌋
//! ```
//!
//! Walks of a chosen length need no roulette. Edges here are those between vertices; null and mask surfaces that a path passes come on top, and the
//! rules count them where they must.

use crate::transport::PathRules;
use etendue_numerics::math::{exp, ln};
use etendue_scene::Scene;

/// Paths of more edges are one class.
const LONGEST: u32 = 10;
/// q: how often a path of that class is given one more edge.
const ONE_MORE: f32 = 0.9;
/// Edges of that class for which a chain keeps numbers; those of longer paths change with large steps only.
const KEPT: u32 = 32;

/// A class of paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Length {
    /// Edges; of the open class, the fewest.
    pub edges: u32,
    /// Whether there may be more.
    pub open: bool,
}

/// The classes of all paths that may count.
pub fn lengths(rules: &PathRules, scene: &Scene) -> Vec<Length> {
    // What passes null surfaces may have few other edges.
    let fewest = if rules.null_counts && scene.has_transparent { 1 } else { rules.min_edges };
    let closed = fewest..=rules.max_edges.min(LONGEST);
    let mut all: Vec<Length> = closed.map(|edges| Length { edges, open: false }).collect();
    if rules.max_edges > LONGEST {
        all.push(Length { edges: fewest.max(LONGEST + 1), open: true });
    }
    all
}

impl Length {
    /// The number of edges that ξ chooses, and the probability of that.
    #[inline]
    pub fn choose(&self, xi: f32) -> (u32, f32) {
        if !self.open {
            return (self.edges, 1.0);
        }
        let more = (ln(1.0 - xi) / ln(ONE_MORE)).floor().max(0.0);
        (self.edges + more as u32, (1.0 - ONE_MORE) * exp(more * ln(ONE_MORE)))
    }

    /// Vertices for which a chain keeps numbers, the one at the end included.
    pub fn vertices(&self, scene: &Scene) -> u32 {
        let edges = if self.open { self.edges.max(KEPT) } else { self.edges };
        // Passing a null surface takes numbers, too.
        edges + if scene.has_transparent { 4 } else { 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each length is chosen as often as it says.
    #[test]
    fn probabilities_are_those_of_the_choice() {
        let open = Length { edges: 11, open: true };
        let n = 1 << 20;
        let mut found = [0u32; 60];
        for i in 0..n {
            let (edges, _) = open.choose((i as f32 + 0.5) / n as f32);
            if let Some(count) = found.get_mut(edges as usize - 11) {
                *count += 1;
            }
        }
        for (j, count) in found.iter().enumerate() {
            let p = 0.1 * 0.9f64.powi(j as i32);
            assert!((f64::from(*count) / f64::from(n) - p).abs() < 4.0 / f64::from(n) + 1e-6 * p, "{j}: {count}");
        }
        for xi in [0.0, 0.05, 0.3, 0.9, 1.0f32.next_down()] {
            let (edges, p) = open.choose(xi);
            let want = 0.1 * 0.9f64.powi(edges as i32 - 11);
            assert!((f64::from(p) / want - 1.0).abs() < 1e-4, "{xi}: {edges} {p}");
        }
        assert_eq!(Length { edges: 4, open: false }.choose(0.7), (4, 1.0));
    }
}
