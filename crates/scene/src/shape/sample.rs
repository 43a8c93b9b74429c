//! Points of surfaces, drawn by area or by the direction in which they are seen.
//!
//! ```text
//! p_w(x → y) = p_A(y) |x - y|² / |cosθ_y|
//! ```

use crate::interaction::Interaction;
use etendue_numerics::{Vec2, Vec3};

/// A point drawn on a surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// The point.
    pub p: Vec3,
    /// Bound on the rounding error of `p` in each coordinate.
    pub p_error: Vec3,
    /// Unit geometric normal, on the side of the shading normal: the front.
    pub n: Vec3,
    /// Unit shading normal.
    pub ns: Vec3,
    /// Texture coordinates.
    pub uv: Vec2,
    /// The primitive.
    pub primitive: u32,
    /// Barycentrics (b1, b2) within a triangle, parameters of other shapes.
    pub bary: Vec2,
    /// Density by area, 1/m²: one over the primitive's area.
    pub pdf_a: f32,
}

impl From<&Interaction> for SurfacePoint {
    /// The point that a ray met, without its density by area.
    fn from(x: &Interaction) -> Self {
        Self { p: x.p, p_error: x.p_error, n: x.n, ns: x.shading.n, uv: x.uv, primitive: x.primitive, bary: x.bary, pdf_a: 0.0 }
    }
}

/// p_w for a point drawn uniformly from `area` m².
#[inline]
pub(crate) fn pdf_direction_by_area(area: f32, from: Vec3, at: &Interaction) -> f32 {
    to_solid_angle(1.0 / area, from, at.p, at.n)
}

/// A point drawn by area, with its p_w.
#[inline(always)]
pub(crate) fn sample_direction_by_area(point: SurfacePoint, from: Vec3) -> Option<(SurfacePoint, f32)> {
    let pdf_w = to_solid_angle(point.pdf_a, from, point.p, point.n);
    (pdf_w > 0.0).then_some((point, pdf_w))
}

/// p_A → p_w; zero where the surface is seen edge-on or the density is not finite.
#[inline(always)]
pub(crate) fn to_solid_angle(pdf_a: f32, x: Vec3, y: Vec3, n: Vec3) -> f32 {
    let pdf_w = etendue_numerics::measure::area_to_solid_angle(pdf_a, x, y, n);
    if pdf_w.is_finite() { pdf_w } else { 0.0 }
}
