//! Directions: hemispheres around +z, the sphere, cones around +z. Densities per steradian.

use super::{disk_to_square, square_to_disk, unit};
use crate::math::{FRAC_1_PI, TAU, atan2, safe_sqrt, sin_cos};
use crate::{Vec2, Vec3};

/// The density of [`square_to_hemisphere`], 1/2π.
#[inline]
pub fn hemisphere_pdf() -> f32 {
    0.5 * FRAC_1_PI
}

/// A uniform direction with z ≥ 0: height is uniform, z = 1 - r² over the concentric disk.
#[inline]
pub fn square_to_hemisphere(u: Vec2) -> Vec3 {
    square_to_cone(u, 1.0)
}

/// The u that [`square_to_hemisphere`] takes to `w`.
#[inline]
pub fn hemisphere_to_square(w: Vec3) -> Vec2 {
    cone_to_square(w, 1.0)
}

/// The density of [`square_to_cosine_hemisphere`], cosθ/π; zero below the horizon.
#[inline]
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    FRAC_1_PI * cos_theta.max(0.0)
}

/// A direction with z ≥ 0 and density cosθ/π: the concentric disk lifted straight up.
#[inline]
pub fn square_to_cosine_hemisphere(u: Vec2) -> Vec3 {
    disk_to_cosine_hemisphere(square_to_disk(u))
}

/// A point of the unit disk, lifted straight up.
#[inline(always)]
pub fn disk_to_cosine_hemisphere(p: Vec2) -> Vec3 {
    // Rounding must not leave z = 0, where the density is zero: the smallest step of r below 1 gives about z = 2e-4.
    let z = safe_sqrt(1.0 - p.length_squared()).max(1e-4);
    Vec3::new(p.x, p.y, z)
}

/// The u that [`square_to_cosine_hemisphere`] takes to `w`.
#[inline]
pub fn cosine_hemisphere_to_square(w: Vec3) -> Vec2 {
    disk_to_square(w.truncate())
}

/// The density of [`square_to_sphere`], 1/4π.
#[inline]
pub fn sphere_pdf() -> f32 {
    0.25 * FRAC_1_PI
}

/// A uniform direction: z = 1 - 2 u₀, φ = 2π u₁ (Archimedes: heights are uniform).
#[inline]
pub fn square_to_sphere(u: Vec2) -> Vec3 {
    let (sin, cos) = sin_cos(TAU * u.y);
    // sin²θ = (1 - z)(1 + z) = 4 u₀ (1 - u₀), without cancellation at the poles.
    let r = 2.0 * safe_sqrt(u.x * (1.0 - u.x));
    Vec3::new(r * cos, r * sin, 1.0 - 2.0 * u.x)
}

/// The u that [`square_to_sphere`] takes to `w`.
#[inline]
pub fn sphere_to_square(w: Vec3) -> Vec2 {
    let phi = atan2(w.y, w.x) / TAU;
    Vec2::new(unit(0.5 * (1.0 - w.z)), unit(if phi < 0.0 { phi + 1.0 } else { phi }))
}

/// The density of [`square_to_cone`], 1/(2π h).
#[inline]
pub fn cone_pdf(one_minus_cos_max: f32) -> f32 {
    1.0 / (TAU * one_minus_cos_max)
}

/// A uniform direction with cosθ ≥ cosθ_max, given h = 1 - cosθ_max in (0, 2].
///
/// h and not the cosine, which cannot tell cones below 1e-3 rad apart: h = 2 sin²(θ_max/2), or sin²θ_max/(1 + cosθ_max).
#[inline]
pub fn square_to_cone(u: Vec2, one_minus_cos_max: f32) -> Vec3 {
    let p = square_to_disk(u);
    // 1 - cosθ = h r², sin²θ = h r² (2 - h r²).
    let h = one_minus_cos_max * p.length_squared();
    let lift = safe_sqrt(one_minus_cos_max * (2.0 - h));
    Vec3::new(p.x * lift, p.y * lift, 1.0 - h)
}

/// The u that [`square_to_cone`] takes to `w`.
#[inline]
pub fn cone_to_square(w: Vec3, one_minus_cos_max: f32) -> Vec2 {
    let lift = safe_sqrt(one_minus_cos_max * (1.0 + w.z));
    // At the pole of the full sphere every point of the border is as good.
    disk_to_square(if lift > 0.0 { w.truncate() / lift } else { Vec2::X })
}
