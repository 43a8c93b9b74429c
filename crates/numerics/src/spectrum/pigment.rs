//! What pigments of hair absorb, per radius of a fibre.

use super::Spectrum;
use crate::math::{ln, sqr};

/// σ per unit of concentration of eumelanin, which is brown: red, green, blue [d'Eon et al. 2011].
pub const EUMELANIN: Spectrum = Spectrum::rgb(0.419, 0.697, 1.37);
/// The same of pheomelanin, which is red.
pub const PHEOMELANIN: Spectrum = Spectrum::rgb(0.187, 0.4, 1.05);

/// σ of a fibre that many of its kind would give the colour `c`, by its azimuthal roughness β [Chiang et al. 2016, eq. 9]:
/// (ln c / (5.969 - 0.215 β + 2.532 β² - 10.73 β³ + 5.574 β⁴ + 0.245 β⁵))².
pub fn absorption_of(c: Spectrum, beta: f32) -> Spectrum {
    let scale = [5.969, -0.215, 2.532, -10.73, 5.574, 0.245].iter().rev().fold(0.0, |sum, k| sum * beta + k);
    let lane = |c: f32| sqr(ln(c.clamp(1e-4, 1.0)) / scale);
    Spectrum([lane(c[0]), lane(c[1]), lane(c[2]), lane(c[3])].into())
}
