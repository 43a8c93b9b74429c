//! Measurements: what solvers add to, and what a picture is developed from.
//!
//! ```text
//! pixel = Σ k(p - s) L(s) / Σ k(p - s)  +  Σ splats / particles started
//! ```
//!
//! Sums are exact fixed-point numbers ([`Fixed`]), so they do not depend on order: threads, tiles, passes, shards and resumed
//! renders merge to the same bits. Samples of pixels go through a [`Tile`], splats of light paths through [`Film::add_splats`].

mod allocation;
mod film;
mod fixed;
mod replicates;
mod splat;
mod sums;
mod tile;
mod variance;

pub use allocation::Allocation;
pub use film::{Film, FilmShape};
pub use fixed::Fixed;
pub use replicates::{NoiseEstimate, Replicates};
pub use splat::Splat;
pub use sums::{NonFinite, Sums};
pub use tile::Tile;
