//! Primary sample space: the numbers that a path is a function of, as a vector that can be kept, changed a little and used again
//! [Kelemen et al. 2002].
//!
//! Whoever asks for numbers by address ([`Numbers`]) may be given those of a point set or those of a vector, and cannot tell.

use crate::{Dim, Sampler, Vec2};

/// Uniform numbers in [0, 1), by address.
pub trait Numbers {
    /// A number. Not to be drawn together with [`Numbers::u2`] of the same dimension.
    fn u1(&self, dim: Dim) -> f32;

    /// A point in [0, 1)².
    fn u2(&self, dim: Dim) -> Vec2;
}

impl Numbers for Sampler {
    #[inline]
    fn u1(&self, dim: Dim) -> f32 {
        Self::u1(self, dim)
    }

    #[inline]
    fn u2(&self, dim: Dim) -> Vec2 {
        Self::u2(self, dim)
    }
}

/// A point of primary sample space: a vector of numbers, and a point set's for all addresses that the vector has no room for.
#[derive(Clone, Copy, Debug)]
pub struct Primary<'a> {
    /// The numbers of dimension d at place d.
    pub vector: &'a [Vec2],
    /// All others.
    pub beyond: Sampler,
}

impl Numbers for Primary<'_> {
    #[inline]
    fn u1(&self, dim: Dim) -> f32 {
        self.vector.get(dim.0 as usize).map_or_else(|| self.beyond.u1(dim), |u| u.x)
    }

    #[inline]
    fn u2(&self, dim: Dim) -> Vec2 {
        self.vector.get(dim.0 as usize).copied().unwrap_or_else(|| self.beyond.u2(dim))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SequenceKind;

    /// A vector filled from a point set serves the same numbers as the set, within its length and beyond.
    #[test]
    fn a_vector_is_what_it_was_filled_with() {
        let set = Sampler::new(SequenceKind::Sobol, 3, 1, 7, 64);
        let vector: Vec<Vec2> = (0..40).map(|d| set.u2(Dim(d))).collect();
        let primary = Primary { vector: &vector, beyond: set };
        for d in (0..80).map(Dim) {
            assert_eq!((primary.u1(d), primary.u2(d)), (Numbers::u1(&set, d), Numbers::u2(&set, d)), "{d:?}");
        }
    }
}
