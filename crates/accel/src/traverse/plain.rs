//! The kernel in plain Rust: the same operations as the vector kernels, lane by lane.
//!
//! Triangles are met in the plane across the ray [Woop, Benthin, Wald 2013]. With the origin at 0 and z the axis of the largest component of d, a
//! corner a goes to (a_x - S_x a_z, a_y - S_y a_z), S = d_{x,y} / d_z: a map of the corner and the ray alone, so triangles that share a corner
//! agree on where it is. The ray pierces the triangle a, b, c where 0 is inside, told by the signs of
//!
//! ```text
//! U = c_x b_y - c_y b_x      V = a_x c_y - a_y c_x      W = b_x a_y - b_y a_x
//! ```
//!
//! Rounding is monotone, so the difference of two rounded products has the right sign or is 0, and 0 counts as inside. A ray that meets the
//! sheared mesh therefore meets the rounded one: nothing slips through a shared edge or corner. That needs products and differences
//! rounded one by one: no fused multiply-add here.
//!
//! The distance comes from the plane through the triangle, t = n·a / n·d with n = (b - a) × (c - a) / (U + V + W): near a large wall that is
//! far more accurate than weighing the corners' distances. It is clamped to those, which keeps it sound where the triangle is seen
//! edge-on. Fused multiply-adds are welcome here, and called by name.

use super::setup::Setup;
use super::{Kernel, LaneHit, Nearest, Start};
use crate::CustomShapes;
use crate::layout::{Child, Node, WIDTH};
use etendue_numerics::Ray;

/// Below this, a sum U + V + W may have lost digits to underflow: the triangle is looked at again in f64.
pub(super) const TINY: f32 = 1e-30;

pub(super) struct Plain(pub Setup);

/// The instruction set's minimum and maximum: the second operand unless the first is truly smaller (larger).
#[inline(always)]
fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// a b - c d within 1.5 ulp [Jeannerod, Louvet, Muller 2013, Kahan's algorithm].
#[inline(always)]
fn difference(a: f32, b: f32, c: f32, d: f32) -> f32 {
    let cd = c * d;
    let lost = (-c).mul_add(d, cd);
    a.mul_add(b, -cd) + lost
}

impl Plain {
    /// t, u, v of the triangle in `lane`, whatever the sign of t; `None` where the ray passes it by.
    ///
    /// # Safety
    /// As for [`Kernel::nearest`], with `lane` < `count`.
    #[inline(always)]
    pub unsafe fn triangle(&self, corners: *const f32, count: usize, lane: usize) -> Option<[f32; 3]> {
        let Setup { o, axes: [x, y, z], shear, .. } = self.0;
        // SAFETY: nine rows of `count` floats lie there.
        let at = |v: usize, axis: usize| unsafe { *corners.add((3 * v + axis) * count + lane) } - o[axis];
        let corner = |v: usize| {
            let depth = at(v, z);
            (at(v, x) - shear[0] * depth, at(v, y) - shear[1] * depth, depth)
        };
        let (a, b, c) = (corner(0), corner(1), corner(2));
        let u = c.0 * b.1 - c.1 * b.0;
        let v = a.0 * c.1 - a.1 * c.0;
        let w = b.0 * a.1 - b.1 * a.0;
        if !(min(min(u, v), w) >= 0.0 || max(max(u, v), w) <= 0.0) {
            return None;
        }
        let sum = (u + v) + w;
        if sum.abs() < TINY {
            return tiny(a, b, c, shear[2]);
        }
        // SAFETY: as above.
        let raw = |v: usize| [x, y, z].map(|axis| unsafe { *corners.add((3 * v + axis) * count + lane) });
        let edge = |v: usize| [0, 1, 2].map(|i| raw(v)[i] - raw(0)[i]);
        let (e, f) = (edge(1), edge(2));
        let scale = 1.0 / sum;
        let minor = |i: usize, j: usize| difference(e[i], f[j], e[j], f[i]) * scale;
        let n = [minor(1, 2), minor(2, 0), minor(0, 1)];
        let dot = |p: f32, q: f32, r: f32| n[0].mul_add(p, n[1].mul_add(q, n[2] * r));
        let to_plane = dot(at(0, x), at(0, y), a.2);
        let along = dot(shear[0], shear[1], 1.0);
        let depth = min(max(to_plane / along, min(min(a.2, b.2), c.2)), max(max(a.2, b.2), c.2));
        Some([depth * shear[2], v * scale, w * scale])
    }
}

/// The same test in f64, where the products are exact.
#[cold]
fn tiny(a: (f32, f32, f32), b: (f32, f32, f32), c: (f32, f32, f32), scale_z: f32) -> Option<[f32; 3]> {
    let wide = |p: (f32, f32, f32)| (f64::from(p.0), f64::from(p.1), f64::from(p.2));
    let (a, b, c) = (wide(a), wide(b), wide(c));
    let u = c.0 * b.1 - c.1 * b.0;
    let v = a.0 * c.1 - a.1 * c.0;
    let w = b.0 * a.1 - b.1 * a.0;
    let sum = u + v + w;
    // written so that a NaN is no hit
    if !((u >= 0.0 && v >= 0.0 && w >= 0.0 || u <= 0.0 && v <= 0.0 && w <= 0.0) && sum != 0.0) {
        return None;
    }
    let (u, v, w) = (u / sum, v / sum, w / sum);
    Some([((u * a.2 + v * b.2 + w * c.2) * f64::from(scale_z)) as f32, v as f32, w as f32])
}

impl Kernel for Plain {
    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        Self(Setup::new(ray))
    }

    #[inline(always)]
    fn boxes(&self, node: &Node, best: f32, enter: &mut [f32; WIDTH]) -> u32 {
        let Setup { o, near, far, rows, .. } = self.0;
        let mut met = 0;
        for (i, enter) in enter.iter_mut().enumerate() {
            let n = [0, 1, 2].map(|a| (node.rows[rows[a]][i] - o[a]) * near[a]);
            let f = [0, 1, 2].map(|a| (node.rows[rows[a] ^ 1][i] - o[a]) * far[a]);
            *enter = max(max(n[0], n[1]), max(n[2], 0.0));
            let exit = min(min(f[0], f[1]), min(f[2], best));
            met |= u32::from(*enter <= exit) << i;
        }
        met
    }

    #[inline(always)]
    unsafe fn nearest(&self, corners: *const f32, count: usize, best: f32) -> Option<LaneHit> {
        let mut nearest: Option<LaneHit> = None;
        for lane in 0..count {
            // SAFETY: passed on.
            if let Some([t, u, v]) = unsafe { self.triangle(corners, count, lane) }
                && t > 0.0
                && t <= best
                && nearest.is_none_or(|n| t < n.t)
            {
                nearest = Some(LaneHit { t, u, v, lane });
            }
        }
        nearest
    }

    #[inline(always)]
    unsafe fn any(&self, corners: *const f32, count: usize, t_max: f32) -> bool {
        // SAFETY: passed on.
        (0..count).any(|lane| unsafe { self.triangle(corners, count, lane) }.is_some_and(|[t, ..]| t > 0.0 && t < t_max))
    }

    fn closest<S: CustomShapes>(start: Start<'_>, ray: &Ray, shapes: &S, instance: u32, nearest: &mut Nearest) {
        super::closest_in::<Self, S>(start, ray, shapes, instance, nearest);
    }

    fn occluded<S: CustomShapes>(start: Start<'_>, ray: &Ray, shapes: &S, last: &mut Option<Child>) -> bool {
        super::occluded_in::<Self, S>(start, ray, shapes, last)
    }
}
