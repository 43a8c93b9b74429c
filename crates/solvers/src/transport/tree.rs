//! Trees of samples: branches as plain walks, kept on a list instead of a stack of calls, and addressed so that each has random numbers of its own.

use super::PathRules;
use etendue_numerics::Dim;
use etendue_numerics::sequence::mix;

/// The place of a vertex in a tree of samples: the address of its random decisions. It depends on the way there and on nothing else, so
/// that a branch keeps its numbers whatever happens to its siblings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Branch(u32);

impl Branch {
    /// What the eye sees.
    pub const ROOT: Self = Self(1);

    /// The `i`-th branch from here.
    #[inline]
    pub fn child(self, i: u32) -> Self {
        // 28 bits leave room for the slots of a vertex.
        Self((mix(u64::from(self.0) << 32 | u64::from(i)) >> 36) as u32)
    }

    /// The address as a vertex number.
    #[inline]
    pub fn vertex(self) -> u32 {
        self.0
    }

    /// The address of a decision here.
    #[inline]
    pub fn dim(self, slot: u32) -> Dim {
        Dim::at(self.0, slot)
    }
}

/// Vertices after which Russian roulette prunes a tree, whatever the scene file says: glass doubles the branches at each.
const MOST_LEVELS: u32 = 8;

impl PathRules {
    /// The same rules for a tree. From vertex `rr_depth` (or 8) on, a branch survives with the share of the picture that it carries: as those
    /// of one vertex sum to one at most, a tree then grows no more, and its mean stays.
    pub fn of_tree(self) -> Self {
        Self { rr_depth: Some(self.rr_depth().min(MOST_LEVELS)), ..self }
    }
}
