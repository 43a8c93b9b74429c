//! What may happen at a surface, as a set of bits.

use std::ops::{BitOr, BitOrAssign};

/// A set of kinds of scattering: one event for a sample, the union of all for a [`crate::Bsdf`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Event(u8);

impl Event {
    /// Nothing.
    pub const NONE: Self = Self(0);
    /// `wi` on the side of `wo`.
    pub const REFLECT: Self = Self(1);
    /// `wi` on the other side.
    pub const TRANSMIT: Self = Self(2);
    /// Straight through, as if the surface were not there.
    pub const NULL: Self = Self(4);
    /// A Dirac distribution: finitely many directions.
    pub const DELTA: Self = Self(8);
    /// Smooth, around a peak.
    pub const GLOSSY: Self = Self(16);
    /// Smooth, broad.
    pub const DIFFUSE: Self = Self(32);

    /// The directions depend on the wavelength, and are those of the hero.
    pub const DISPERSES: Self = Self(64);

    /// Both sets together, usable in constants.
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether the two sets share a kind.
    #[inline]
    pub const fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// Whether walks must go on with one wavelength.
    #[inline]
    pub const fn disperses(self) -> bool {
        self.intersects(Self::DISPERSES)
    }

    /// Whether a density per steradian exists: next event estimation and multiple importance sampling make sense.
    #[inline]
    pub const fn has_smooth(self) -> bool {
        self.intersects(Self::GLOSSY.with(Self::DIFFUSE))
    }

    /// Whether a Dirac part exists.
    #[inline]
    pub const fn has_delta(self) -> bool {
        self.intersects(Self::DELTA)
    }

    /// Whether light may reach the other side, bent or not.
    #[inline]
    pub const fn transmits(self) -> bool {
        self.intersects(Self::TRANSMIT.with(Self::NULL))
    }

    /// Whether light may pass straight through.
    #[inline]
    pub const fn has_null(self) -> bool {
        self.intersects(Self::NULL)
    }
}

impl BitOr for Event {
    type Output = Self;
    #[inline]
    fn bitor(self, other: Self) -> Self {
        self.with(other)
    }
}

impl BitOrAssign for Event {
    #[inline]
    fn bitor_assign(&mut self, other: Self) {
        *self = self.with(other);
    }
}
