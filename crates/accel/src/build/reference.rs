//! References: a box and the number of what lies in it, the currency of the build.
//!
//! A triangle starts as one reference; a spatial split may cut it into several, each with a box around its own part. Items are
//! numbered flat: the triangles of all meshes first, in the order they were added, then the other things (custom shapes, instances).

use crate::build::TriangleMesh;
use bytemuck::Zeroable;
use etendue_numerics::wide::fetch;
use glam::{BVec4A, DVec3, Mat4, Vec3, Vec4};

/// A box and an item number, 32 bytes. The number rides in the unused fourth lane of `lo`.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C)]
pub(crate) struct Reference {
    pub lo: Vec4,
    pub hi: Vec4,
}

/// Added to item numbers so that their bits are those of a normal float: vector code that touches the fourth lane then meets no
/// subnormal, which some processors are slow at.
const NORMAL: u32 = 0x4000_0000;

impl Reference {
    pub const NONE: Self = Self { lo: Vec4::ZERO, hi: Vec4::ZERO };

    pub fn new(lo: Vec3, hi: Vec3, item: u32) -> Self {
        Self { lo: lo.extend(f32::from_bits(item + NORMAL)), hi: hi.extend(0.0) }
    }

    /// The flat number of the thing referred to.
    #[inline]
    pub fn item(&self) -> u32 {
        self.lo.w.to_bits() - NORMAL
    }

    /// Twice the box's centre.
    #[inline(always)]
    pub fn centroid2(&self) -> Vec4 {
        self.lo + self.hi
    }

    /// The same item within another box.
    #[inline]
    pub fn within(&self, b: Box4) -> Self {
        Self { lo: b.lo.with_w(self.lo.w), hi: b.hi.with_w(0.0) }
    }

    #[inline(always)]
    pub fn bounds(&self) -> Box4 {
        Box4 { lo: self.lo, hi: self.hi }
    }
}

/// A box in two four-lane vectors of which the last lane means nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Box4 {
    pub lo: Vec4,
    pub hi: Vec4,
}

impl Box4 {
    pub const EMPTY: Self = Self { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    #[inline(always)]
    pub fn union(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    #[inline]
    pub fn including(self, p: Vec4) -> Self {
        Self { lo: self.lo.min(p), hi: self.hi.max(p) }
    }

    #[inline]
    pub fn intersection(self, other: Self) -> Self {
        Self { lo: self.lo.max(other.lo), hi: self.hi.min(other.hi) }
    }

    /// Whether the box holds a point.
    pub fn is_sound(&self) -> bool {
        let d = self.hi - self.lo;
        d.x >= 0.0 && d.y >= 0.0 && d.z >= 0.0
    }

    /// Half the surface, 0 where the box is empty along any axis.
    pub fn half_area_if_not_empty(&self) -> f32 {
        if self.is_sound() { self.half_area() } else { 0.0 }
    }

    /// xy + yz + zx, half the surface; 0 for an empty box.
    #[inline]
    pub fn half_area(&self) -> f32 {
        let d = (self.hi - self.lo).max(Vec4::ZERO);
        d.x * (d.y + d.z) + d.y * d.z
    }
}

/// Three boxes' half surfaces; infinite where a box is empty.
#[inline(always)]
pub(crate) fn half_areas(boxes: &[Box4; 3]) -> Vec4 {
    let (a, b, c) = (boxes[0].hi - boxes[0].lo, boxes[1].hi - boxes[1].lo, boxes[2].hi - boxes[2].lo);
    let Mat4 { x_axis: x, y_axis: y, z_axis: z, .. } = Mat4::from_cols(a, b, c, Vec4::ZERO).transpose();
    x * (y + z) + y * z
}

/// Which of three axes has the least, the first of equals. No branch: which one it is cannot be guessed.
#[inline(always)]
pub(crate) fn least(x: Vec4) -> usize {
    let is_less = |a: f32, b: f32| usize::from(a < b);
    let second = is_less(x.y, x.x);
    let third = is_less(x.z, if x.y < x.x { x.y } else { x.x });
    second * (1 - third) + 2 * third
}

/// All items of one tree, by flat number.
pub(crate) struct Items<'a> {
    pub meshes: &'a [TriangleMesh<'a>],
    pub owners: Owners,
}

impl Items<'_> {
    pub fn triangles(&self) -> u32 {
        self.owners.total()
    }

    /// [`Items::corners`] with a fourth lane of 0.
    #[inline]
    pub fn corners4(&self, item: u32) -> Option<[Vec4; 3]> {
        self.corners(item).map(|c| c.map(|p| p.extend(0.0)))
    }

    /// Asks for the memory that [`Items::fetch_corners`] looks at.
    #[inline]
    pub fn fetch_indices(&self, item: u32) {
        if let Some((mesh, primitive)) = self.owners.locate(item)
            && let Some(index) = self.meshes[mesh as usize].indices.get(primitive as usize)
        {
            fetch(index);
        }
    }

    /// Asks for the memory that [`Items::corners`] looks at.
    #[inline]
    pub fn fetch_corners(&self, item: u32) {
        if let Some((mesh, primitive)) = self.owners.locate(item) {
            let mesh = &self.meshes[mesh as usize];
            for &i in mesh.indices.get(primitive as usize).into_iter().flatten() {
                if let Some(p) = mesh.positions.get(i as usize) {
                    fetch(p);
                }
            }
        }
    }

    /// The corners of triangle `item`; `None` for other items and where an index points nowhere.
    pub fn corners(&self, item: u32) -> Option<[Vec3; 3]> {
        let (mesh, primitive) = self.owners.locate(item)?;
        let mesh = &self.meshes[mesh as usize];
        let index = mesh.indices.get(primitive as usize)?;
        let corner = |k: usize| mesh.positions.get(index[k] as usize).copied();
        Some([corner(0)?, corner(1)?, corner(2)?])
    }
}

/// From flat triangle numbers to (mesh, number within the mesh).
///
/// A table tells the mesh of every 256th triangle; from there it is at most a few steps.
#[derive(Clone, Debug, Default)]
pub(crate) struct Owners {
    /// Flat number of each mesh's first triangle, and the total.
    starts: Vec<u32>,
    /// The mesh of triangles 0, 256, 512, …
    hints: Vec<u32>,
}

impl Owners {
    pub fn new(counts: impl Iterator<Item = u32>) -> Self {
        let mut starts = vec![0];
        let mut hints = Vec::new();
        for (mesh, count) in counts.enumerate() {
            let end = starts[mesh] + count;
            starts.push(end);
            while (hints.len() as u32) << 8 < end {
                hints.push(mesh as u32);
            }
        }
        Self { starts, hints }
    }

    pub fn total(&self) -> u32 {
        self.starts.last().copied().unwrap_or(0)
    }

    /// (mesh, primitive) of a flat number; `None` beyond the last triangle.
    #[inline]
    pub fn locate(&self, item: u32) -> Option<(u32, u32)> {
        if item >= self.total() {
            return None;
        }
        let mut mesh = self.hints[(item >> 8) as usize] as usize;
        while self.starts[mesh + 1] <= item {
            mesh += 1;
        }
        Some((mesh as u32, item - self.starts[mesh]))
    }

    pub fn bytes(&self) -> usize {
        4 * (self.starts.len() + self.hints.len())
    }
}

/// The reference of a triangle; `None` where it has no area or a corner is not finite, so that such a triangle is never hit.
///
/// The area is judged in f64, where differences and products of f32 numbers are exact or nearly so.
pub(crate) fn triangle_reference(corners: [Vec3; 3], item: u32) -> Option<Reference> {
    let [a, b, c] = corners;
    if !(a.is_finite() && b.is_finite() && c.is_finite()) {
        return None;
    }
    let (ad, bd, cd) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    if (bd - ad).cross(cd - ad) == DVec3::ZERO {
        return None;
    }
    Some(Reference::new(a.min(b).min(c), a.max(b).max(c), item))
}

/// A plane x[axis] = at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    pub axis: usize,
    pub at: f32,
    /// `at` in the axis' lane, infinities elsewhere: the largest corner of what lies below, the smallest of what lies above.
    pub below: Vec4,
    pub above: Vec4,
}

impl Plane {
    #[inline]
    pub fn new(axis: usize, at: f32) -> Self {
        let lane = BVec4A::new(axis == 0, axis == 1, axis == 2, false);
        let at4 = Vec4::splat(at);
        Self { axis, at, below: Vec4::select(lane, at4, Vec4::INFINITY), above: Vec4::select(lane, at4, Vec4::NEG_INFINITY) }
    }
}

/// The two parts of a reference on either side of a plane, as boxes around what the plane leaves of the triangle.
///
/// Cuts are rounded outward by more than their error: a box never loses a point of its triangle.
#[inline]
pub(crate) fn cut(whole: Box4, corners: &[Vec4; 3], plane: &Plane) -> (Box4, Box4) {
    let (mut left, mut right) = (Box4::EMPTY, Box4::EMPTY);
    let at = plane.at;
    let x = [corners[0][plane.axis], corners[1][plane.axis], corners[2][plane.axis]];
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let (p, q) = (corners[i], corners[j]);
        if x[i] <= at {
            left = left.including(p);
        }
        if x[i] >= at {
            right = right.including(p);
        }
        if (x[i] < at && x[j] > at) || (x[i] > at && x[j] < at) {
            let cut = p + (q - p) * ((at - x[i]) / (x[j] - x[i]));
            let error = p.abs().max(q.abs()) * (4.0 * f32::EPSILON);
            let piece = Box4 { lo: cut - error, hi: cut + error };
            left = left.union(piece);
            right = right.union(piece);
        }
    }
    left.hi = left.hi.min(plane.below);
    right.lo = right.lo.max(plane.above);
    (left.intersection(whole), right.intersection(whole))
}
