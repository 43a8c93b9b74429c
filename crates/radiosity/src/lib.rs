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
//! | B_i, by several methods; light that comes from elsewhere | [`solve`] |
//! | F by links between clusters, without a matrix | [`hierarchy`] |
//! | all of it for a scene | [`solved`] |
//! | parts of patches that something stands on | [`cover`] |
//! | patches cut finer where the light changes | [`refine`] |
//! | values between the middles of patches | [`field`] |
//!
//! This room sees compiled scenes only; it knows no films and no descriptions, and prints nothing. What should be said about a scene comes out
//! as values that name surfaces and facets.

mod choices;
pub mod cover;
pub mod field;
pub mod form_factor;
pub mod hierarchy;
pub mod patch;
mod quadrature;
pub mod refine;
pub mod solve;
pub mod solved;

pub use field::Field;
pub use hierarchy::{Hierarchical, Hierarchy};
pub use patch::{Cutting, PatchSize, Patches, Side, Sides};
pub use solve::{Bounces, Energy, Equation, Exchange, Solution, Until};
pub use solved::{Settings, Solved};
