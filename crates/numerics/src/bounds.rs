//! Axis-aligned boxes.

use crate::Vec3;

/// A closed axis-aligned box; empty where `min > max` in any axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds3 {
    /// The smallest corner.
    pub min: Vec3,
    /// The largest corner.
    pub max: Vec3,
}

impl Default for Bounds3 {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Bounds3 {
    /// The box that holds nothing: the neutral element of [`Bounds3::union`].
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The box of two opposite corners, in any order.
    pub fn new(a: Vec3, b: Vec3) -> Self {
        Self { min: a.min(b), max: a.max(b) }
    }

    /// The smallest box around all `points`.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::including)
    }

    /// The smallest box that also holds `p`.
    pub fn including(self, p: Vec3) -> Self {
        Self { min: self.min.min(p), max: self.max.max(p) }
    }

    /// The smallest box that holds both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// What both hold; possibly empty.
    pub fn intersection(self, other: Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// Whether nothing lies inside.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// Whether `p` lies inside or on the border.
    pub fn contains(&self, p: Vec3) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }

    /// The edge lengths; zero for an empty box.
    pub fn size(&self) -> Vec3 {
        (self.max - self.min).max(Vec3::ZERO)
    }

    /// The middle.
    pub fn center(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }

    /// Half the surface area, xy + yz + zx: what the surface area heuristic compares.
    pub fn half_area(&self) -> f32 {
        let d = self.size();
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// The eight corners.
    pub fn corners(&self) -> [Vec3; 8] {
        let pick = |high: usize, axis: usize| if high >> axis & 1 == 1 { self.max[axis] } else { self.min[axis] };
        std::array::from_fn(|i| Vec3::new(pick(i, 0), pick(i, 1), pick(i, 2)))
    }

    /// Centre and radius of the sphere around the box; radius 0 for an empty box.
    pub fn bounding_sphere(&self) -> (Vec3, f32) {
        if self.is_empty() { (Vec3::ZERO, 0.0) } else { (self.center(), 0.5 * self.size().length()) }
    }
}
