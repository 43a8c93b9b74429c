//! Contributions of light paths, which may fall anywhere.

use etendue_numerics::{Spectrum, Vec2};

/// We·L/p of a light path at a position of the film. Its pixel's value is the sum of its splats over the particles started.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat {
    /// Pixels from the film's corner.
    pub position: Vec2,
    /// The contribution.
    pub value: Spectrum,
    /// Which particle, for the record of dropped ones.
    pub particle: u64,
}
