//! Scattering: f(wi, x, wo) as numbers only.
