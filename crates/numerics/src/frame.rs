//! Orthonormal frames: local coordinates in which the normal is +z.

use crate::Vec3;

/// A right-handed orthonormal basis (s, t, n), n = s × t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First tangent: local +x.
    pub s: Vec3,
    /// Second tangent: local +y.
    pub t: Vec3,
    /// Normal: local +z.
    pub n: Vec3,
}

impl Frame {
    /// The frame that changes nothing.
    pub const IDENTITY: Self = Self { s: Vec3::X, t: Vec3::Y, n: Vec3::Z };

    /// Any frame around the unit vector `n` [Duff et al. 2017, Listing 3].
    #[inline]
    pub fn from_normal(n: Vec3) -> Self {
        let sign = 1f32.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Self { s: Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), t: Vec3::new(b, sign + n.y * n.y * a, -n.y), n }
    }

    /// The frame around the unit vector `n` whose `s` leans towards `dp_du` (Gram-Schmidt); any frame where the two are parallel.
    #[inline]
    pub fn from_normal_and_tangent(n: Vec3, dp_du: Vec3) -> Self {
        let s = dp_du - n * n.dot(dp_du);
        match s.try_normalize() {
            Some(s) => Self { s, t: n.cross(s), n },
            None => Self::from_normal(n),
        }
    }

    /// World to local.
    #[inline]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }

    /// Local to world.
    #[inline]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.s * v.x + self.t * v.y + self.n * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        for n in [Vec3::Z, Vec3::NEG_Z, Vec3::X, Vec3::new(0.3, -0.7, 0.2).normalize(), Vec3::new(1e-4, 0.0, -1.0).normalize()] {
            for f in [Frame::from_normal(n), Frame::from_normal_and_tangent(n, Vec3::new(0.2, 1.0, 0.5))] {
                assert!(f.s.dot(f.t).abs() < 1e-6 && f.s.dot(f.n).abs() < 1e-6 && f.t.dot(f.n).abs() < 1e-6);
                assert!((f.s.cross(f.t) - f.n).length() < 1e-6, "{f:?}");
                let v = Vec3::new(0.1, 0.2, 0.3);
                assert!((f.to_world(f.to_local(v)) - v).length() < 1e-6);
            }
        }
    }
}
