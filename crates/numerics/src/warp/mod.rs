//! Warps: area-preserving maps from the unit square to the sets that directions and points are drawn from.
//!
//! Each set has three functions beside each other: the map `square_to_x(u)`, its inverse `x_to_square`, and the density `x_pdf` of the
//! warped points in the set's own measure. Maps are continuous (but for the seam of a polar angle), so that a stratified u stays stratified.
//!
//! | set | map | density |
//! | --- | --- | --- |
//! | unit disk | concentric [Shirley, Chiu 1997] | 1/π per area |
//! | hemisphere, sphere | concentric disk lifted to height 1 - r²; Archimedes | 1/2π, 1/4π per sr |
//! | sphere, as a picture | unfolded octahedron [Clarberg 2008] | 1/4π per sr |
//! | cosine hemisphere | concentric disk lifted to the hemisphere [Malley 1988] | cosθ/π per sr |
//! | cone | as the hemisphere, flattened | 1/(2π(1 - cosθ_max)) per sr |
//! | triangle | fold of the square [Heitz 2019] | 1/area |
//! | spherical triangle | [`SphericalTriangle`] after [Arvo 1995] | 1/Ω per sr |
//! | spherical rectangle | [`SphericalRectangle`] after [Ureña, Fajardo, King 2013] | 1/Ω per sr |
//! | [-1, 1] with a tent | [`sample_tent`] | 1 - \|x\| per length |
//!
//! Densities at points outside the set are for the caller to zero, but for those with a cosine, which is clamped.

mod disk;
mod equal_area;
mod rectangle;
mod sphere;
mod tent;
mod triangle;

pub use disk::{disk_pdf, disk_to_square, square_to_disk};
pub use equal_area::{equal_area_sphere_to_square, square_to_equal_area_sphere};
pub use rectangle::SphericalRectangle;
pub use sphere::{
    cone_pdf, cone_to_square, cosine_hemisphere_pdf, cosine_hemisphere_to_square, disk_to_cosine_hemisphere, hemisphere_pdf,
    hemisphere_to_square, sphere_pdf, sphere_to_square, square_to_cone, square_to_cosine_hemisphere, square_to_hemisphere,
    square_to_sphere,
};
pub use tent::{invert_tent, sample_tent, tent_pdf};
pub use triangle::{SphericalTriangle, square_to_triangle, triangle_to_square};

use crate::math;

/// Keeps what an inverse returns within [0, 1).
#[inline]
fn unit(x: f32) -> f32 {
    x.clamp(0.0, math::ONE_MINUS_EPSILON)
}
