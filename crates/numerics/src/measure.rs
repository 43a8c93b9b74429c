//! Densities and the measures they are taken against.

use crate::Vec3;

/// The density of a sampled direction: per steradian, or a probability where only discrete directions are possible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pdf {
    /// A density with respect to solid angle, 1/sr.
    SolidAngle(f32),
    /// The probability of a discrete (Dirac) choice, unitless.
    Delta(f32),
}

impl Pdf {
    /// The number without its measure: a density or a probability.
    #[inline]
    pub fn value(self) -> f32 {
        match self {
            Self::SolidAngle(p) | Self::Delta(p) => p,
        }
    }

    /// Whether the direction was a discrete choice.
    #[inline]
    pub fn is_delta(self) -> bool {
        matches!(self, Self::Delta(_))
    }

    /// The density per steradian; zero for a discrete choice, which no other technique can have made.
    #[inline]
    pub fn solid_angle(self) -> f32 {
        match self {
            Self::SolidAngle(p) => p,
            Self::Delta(_) => 0.0,
        }
    }
}

/// From 1/m² on a surface at `y` with unit normal `n` to 1/sr as seen from `x`: p_w = p_A r² / |cosθ_y|; zero where cosθ_y = 0.
#[inline]
pub fn area_to_solid_angle(pdf_a: f32, x: Vec3, y: Vec3, n: Vec3) -> f32 {
    let d = y - x;
    let r2 = d.length_squared();
    let cos = n.dot(d).abs() / r2.sqrt();
    if cos > 0.0 { pdf_a * r2 / cos } else { 0.0 }
}

/// From 1/sr as seen from `x` to 1/m² on a surface at `y` with unit normal `n`: p_A = p_w |cosθ_y| / r²; zero where r = 0.
#[inline]
pub fn solid_angle_to_area(pdf_w: f32, x: Vec3, y: Vec3, n: Vec3) -> f32 {
    let d = y - x;
    let r2 = d.length_squared();
    if r2 > 0.0 { pdf_w * n.dot(d).abs() / (r2 * r2.sqrt()) } else { 0.0 }
}
