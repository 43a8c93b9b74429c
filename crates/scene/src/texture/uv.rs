//! The map that a texture applies to the surface's coordinates before it is looked up.
//!
//! ```text
//! (u', v')ᵀ = A (u, v)ᵀ + b          ∇t(u, v) = Aᵀ ∇t(u', v')
//! ```
//!
//! A and b are the rows and columns x, y and the translation of the file's `to_uv`; its z is not looked at. v' = 0 is the picture's
//! top row: nothing is flipped here.

use etendue_numerics::{Transform, Vec2};
use glam::{Mat2, Vec3Swizzles};

/// An affine map of texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvMap {
    a: Mat2,
    b: Vec2,
}

impl Default for UvMap {
    fn default() -> Self {
        Self { a: Mat2::IDENTITY, b: Vec2::ZERO }
    }
}

impl From<&Transform> for UvMap {
    fn from(to_uv: &Transform) -> Self {
        let column = |i: usize| to_uv.matrix().col(i).as_vec4().truncate().xy();
        Self { a: Mat2::from_cols(column(0), column(1)), b: column(3) }
    }
}

impl UvMap {
    /// Where (u, v) goes.
    #[inline]
    pub fn apply(&self, uv: Vec2) -> Vec2 {
        self.a * uv + self.b
    }

    /// From the gradient by (u', v') to that by (u, v).
    #[inline]
    pub fn pull_back(&self, gradient: Vec2) -> Vec2 {
        self.a.transpose() * gradient
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat4, DVec3};

    #[test]
    fn gradients_follow_the_chain_rule() {
        let m = DMat4::from_translation(DVec3::new(0.3, 0.1, 9.0))
            * DMat4::from_rotation_z(0.7)
            * DMat4::from_scale(DVec3::new(2.0, 3.0, 5.0));
        let map = UvMap::from(&Transform::new(m).unwrap());
        let g = Vec2::new(0.4, -1.2);
        let f = |uv: Vec2| g.dot(map.apply(uv));
        let (at, h) = (Vec2::new(0.2, 0.6), 1e-2);
        let numeric = Vec2::new(
            (f(at + Vec2::X * h) - f(at - Vec2::X * h)) / (2.0 * h),
            (f(at + Vec2::Y * h) - f(at - Vec2::Y * h)) / (2.0 * h),
        );
        assert!((map.pull_back(g) - numeric).length() < 1e-4);
        assert!((map.apply(Vec2::ZERO) - Vec2::new(0.3, 0.1)).length() < 1e-6);
    }
}
