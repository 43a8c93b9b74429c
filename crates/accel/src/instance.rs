//! What a tree holds beside triangles: custom shapes, and other trees seen through an affine map.

use etendue_numerics::{Bounds3, Ray, Transform};
use glam::{DAffine3, DVec3, Vec3};

/// An item that is not a triangle.
#[derive(Clone, Debug)]
pub(crate) enum Other {
    /// A shape that the caller intersects.
    Custom { geometry: u32 },
    /// Another tree.
    Instance(Instance),
}

/// A tree, moved by an affine map.
#[derive(Clone, Debug)]
pub(crate) struct Instance {
    /// Place in the list of inner trees.
    pub tree: u32,
    /// The caller's number.
    pub id: u32,
    /// From the outer space to the tree's own.
    pub inverse: DAffine3,
}

impl Instance {
    pub fn new(tree: u32, id: u32, to_outer: &Transform) -> Self {
        Self { tree, id, inverse: DAffine3::from_mat4(to_outer.matrix()).inverse() }
    }

    /// The ray in the tree's own space. The direction keeps the length it gets there, so t means the same on both sides.
    ///
    /// Computed in f64 and rounded once: far from the origin f32 would lose the small differences that the inner tree is made of.
    #[inline]
    pub fn ray(&self, ray: &Ray) -> Ray {
        let o = self.inverse.transform_point3(ray.o.as_dvec3()).as_vec3();
        let d = self.inverse.transform_vector3(ray.d.as_dvec3()).as_vec3();
        Ray { o, d, ..*ray }
    }
}

/// The box around a moved tree: around each of its outline's boxes when moved, which is tighter than moving the box around them all.
///
/// Grown by a few roundings, since rays are rounded when they go to the inner space.
pub(crate) fn moved_bounds(outline: &[Bounds3], to_outer: &Transform) -> Bounds3 {
    const GROWTH: f64 = 8.0 * f32::EPSILON as f64;
    let m = DAffine3::from_mat4(to_outer.matrix());
    let columns = m.matrix3.to_cols_array_2d().map(|c| DVec3::from_array(c).abs());
    let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for b in outline.iter().filter(|b| !b.is_empty()) {
        let (min, max) = (b.min.as_dvec3(), b.max.as_dvec3());
        let center = m.transform_point3(0.5 * (min + max));
        let half = 0.5 * (max - min);
        let half = columns[0] * half.x + columns[1] * half.y + columns[2] * half.z;
        (lo, hi) = (lo.min(center - half), hi.max(center + half));
    }
    if !(lo.is_finite() && hi.is_finite()) {
        return Bounds3::EMPTY;
    }
    let growth = DVec3::splat(GROWTH * lo.abs().max(hi.abs()).max_element());
    Bounds3 { min: (lo - growth).as_vec3(), max: (hi + growth).as_vec3() }
}

/// Whether every coordinate is finite: what is not, is never hit.
pub(crate) fn is_finite(b: &Bounds3) -> bool {
    !b.is_empty() && b.min.is_finite() && b.max.is_finite()
}

/// The largest coordinate's size.
pub(crate) fn extent(b: &Bounds3) -> f32 {
    if b.is_empty() { 0.0 } else { b.min.abs().max(b.max.abs()).max_element().max(0.0) }
}

/// A box of plain arrays.
pub(crate) fn bounds((lo, hi): ([f32; 3], [f32; 3])) -> Bounds3 {
    Bounds3 { min: Vec3::from(lo), max: Vec3::from(hi) }
}
