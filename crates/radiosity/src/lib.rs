//! Radiosity: patches, form factors, and what is made of them.
//!
//! ```text
//! B_i = Be_i + ρ_i Σ_j F_ij B_j        F_ij = 1/A_i ∫_i ∫_j V(x, y) cosθx cosθy / (π r²) dA dA
//! ```
//!
//! | symbol | where |
//! | --- | --- |
//! | patches i, A_i, ρ_i, Be_i | [`patch`] |
//! | F_ij | [`form_factor`] |
//!
//! This room sees compiled scenes only; it knows no films and no descriptions, and prints nothing. What should be said about a scene comes out
//! as values that name surfaces and facets.

pub mod form_factor;
pub mod patch;
mod quadrature;

pub use patch::{Cutting, PatchSize, Patches, Side, Sides};
