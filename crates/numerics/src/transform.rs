//! Affine and projective maps with their inverses, composed in f64.

use crate::{Bounds3, Vec3};
use glam::{DMat4, DVec3, Mat3, Mat4};

/// A map of space and its inverse. Composed in f64, applied in f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    matrix: DMat4,
    m: Mat4,
    inverse: Mat4,
    normal: Mat3,
}

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Transform {
    /// The map that changes nothing.
    pub const IDENTITY: Self = Self { matrix: DMat4::IDENTITY, m: Mat4::IDENTITY, inverse: Mat4::IDENTITY, normal: Mat3::IDENTITY };

    /// The map of an f64 matrix (columns as glam stores them); `None` where it is singular or not finite.
    pub fn new(matrix: DMat4) -> Option<Self> {
        let inverse = matrix.inverse();
        if !matrix.is_finite() || matrix.determinant() == 0.0 || !inverse.is_finite() {
            return None;
        }
        let normal = glam::DMat3::from_mat4(inverse).transpose();
        Some(Self { matrix, m: matrix.as_mat4(), inverse: inverse.as_mat4(), normal: normal.as_mat3() })
    }

    /// The f64 matrix.
    pub fn matrix(&self) -> DMat4 {
        self.matrix
    }

    /// The inverse map.
    pub fn inverse(&self) -> Self {
        // A matrix that was accepted has an inverse, and so has its inverse.
        Self::new(self.matrix.inverse()).unwrap_or(Self::IDENTITY)
    }

    /// First `self`, then `outer`.
    pub fn then(&self, outer: &Self) -> Self {
        Self::new(outer.matrix * self.matrix).unwrap_or(Self::IDENTITY)
    }

    /// Whether handedness changes (negative determinant).
    pub fn flips(&self) -> bool {
        glam::DMat3::from_mat4(self.matrix).determinant() < 0.0
    }

    /// Whether the last row is (0, 0, 0, 1).
    pub fn is_affine(&self) -> bool {
        self.matrix.row(3).abs_diff_eq(glam::DVec4::W, 1e-12)
    }

    /// Where the point goes (affine).
    #[inline]
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.m.transform_point3(p)
    }

    /// Where the point goes, in f64 (affine).
    #[inline]
    pub fn point_f64(&self, p: DVec3) -> DVec3 {
        self.matrix.transform_point3(p)
    }

    /// Where the direction goes; not normalised.
    #[inline]
    pub fn vector(&self, v: Vec3) -> Vec3 {
        self.m.transform_vector3(v)
    }

    /// Where the normal goes (inverse transpose); not normalised.
    #[inline]
    pub fn normal(&self, n: Vec3) -> Vec3 {
        self.normal * n
    }

    /// Where the point comes from (affine).
    #[inline]
    pub fn inverse_point(&self, p: Vec3) -> Vec3 {
        self.inverse.transform_point3(p)
    }

    /// Where the direction comes from; not normalised.
    #[inline]
    pub fn inverse_vector(&self, v: Vec3) -> Vec3 {
        self.inverse.transform_vector3(v)
    }

    /// |M| e: the bound on the image of a vector that `e` bounds in each coordinate.
    #[inline]
    pub fn spread(&self, e: Vec3) -> Vec3 {
        Mat3::from_mat4(self.m).abs() * e
    }

    /// The box around the moved box (affine).
    pub fn bounds(&self, b: &Bounds3) -> Bounds3 {
        if b.is_empty() { *b } else { Bounds3::of(b.corners().map(|c| self.point(c))) }
    }
}
