//! The kernel in AVX2: eight lanes, one instruction for each operation of [`super::plain`], in its order.
//!
//! The functions here are inlined into [`Kernel::closest`] and [`Kernel::occluded`], which are compiled for AVX2 and only called where
//! [`super::Path::best`] found it on this machine.

use super::plain::{Plain, TINY};
use super::setup::Setup;
use super::{Kernel, LaneHit, Nearest, Start};
use crate::CustomShapes;
use crate::layout::{Child, Node, WIDTH};
use etendue_numerics::Ray;
use std::arch::x86_64::*;

pub(super) struct Avx2 {
    setup: Setup,
    o: [__m256; 3],
    near: [__m256; 3],
    far: [__m256; 3],
}

/// What eight triangles answer before the division.
struct Candidates {
    u: __m256,
    v: __m256,
    w: __m256,
    depth: [__m256; 3],
    /// Lanes that the ray pierces, before or behind the origin.
    lanes: u32,
}

impl Avx2 {
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn prepare(ray: &Ray) -> Self {
        let setup = Setup::new(ray);
        let splat = |x: [f32; 3]| [_mm256_set1_ps(x[0]), _mm256_set1_ps(x[1]), _mm256_set1_ps(x[2])];
        Self { o: splat(setup.o), near: splat(setup.near), far: splat(setup.far), setup }
    }

    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn meet(&self, node: &Node, best: f32, enter: &mut [f32; WIDTH]) -> u32 {
        let rows = self.setup.rows;
        // SAFETY: row numbers are below 6, and nodes are aligned to 32 bytes.
        let row = |r: usize| unsafe { _mm256_load_ps(node.rows.get_unchecked(r).as_ptr()) };
        let near = |a: usize| _mm256_mul_ps(_mm256_sub_ps(row(rows[a]), self.o[a]), self.near[a]);
        let far = |a: usize| _mm256_mul_ps(_mm256_sub_ps(row(rows[a] ^ 1), self.o[a]), self.far[a]);
        let enters = _mm256_max_ps(_mm256_max_ps(near(0), near(1)), _mm256_max_ps(near(2), _mm256_setzero_ps()));
        let exits = _mm256_min_ps(_mm256_min_ps(far(0), far(1)), _mm256_min_ps(far(2), _mm256_set1_ps(best)));
        // SAFETY: eight floats have room there.
        unsafe { _mm256_storeu_ps(enter.as_mut_ptr(), enters) };
        _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(enters, exits)) as u32
    }

    /// Which triangles the ray's line pierces.
    ///
    /// # Safety
    /// As for [`Kernel::nearest`].
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    unsafe fn pierced(&self, corners: *const f32, count: usize) -> Candidates {
        let Setup { o, axes: [x, y, z], shear, .. } = self.setup;
        let origin = [_mm256_set1_ps(o[x]), _mm256_set1_ps(o[y]), _mm256_set1_ps(o[z])];
        let shear = [_mm256_set1_ps(shear[0]), _mm256_set1_ps(shear[1])];
        // SAFETY: lane 7 of the last row is at most WIDTH - 1 floats past the leaf's end.
        let row = |v: usize, axis: usize| unsafe { _mm256_loadu_ps(corners.add((3 * v + axis) * count)) };
        let corner = |v: usize| {
            let depth = _mm256_sub_ps(row(v, z), origin[2]);
            let across = _mm256_sub_ps(_mm256_sub_ps(row(v, x), origin[0]), _mm256_mul_ps(shear[0], depth));
            let up = _mm256_sub_ps(_mm256_sub_ps(row(v, y), origin[1]), _mm256_mul_ps(shear[1], depth));
            (across, up, depth)
        };
        let (a, b, c) = (corner(0), corner(1), corner(2));
        let cross = |p: (__m256, __m256, __m256), q: (__m256, __m256, __m256)| {
            _mm256_sub_ps(_mm256_mul_ps(p.0, q.1), _mm256_mul_ps(p.1, q.0))
        };
        let (u, v, w) = (cross(c, b), cross(a, c), cross(b, a));
        let least = _mm256_min_ps(_mm256_min_ps(u, v), w);
        let most = _mm256_max_ps(_mm256_max_ps(u, v), w);
        let zero = _mm256_setzero_ps();
        let inside = _mm256_or_ps(_mm256_cmp_ps::<_CMP_GE_OQ>(least, zero), _mm256_cmp_ps::<_CMP_LE_OQ>(most, zero));
        let lanes = _mm256_movemask_ps(inside) as u32 & ((1 << count) - 1);
        Candidates { u, v, w, depth: [a.2, b.2, c.2], lanes }
    }

    /// t, u, v of all lanes; `None` where a lane needs a closer look.
    ///
    /// # Safety
    /// As for [`Kernel::nearest`].
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    unsafe fn divide(&self, corners: *const f32, count: usize, c: &Candidates) -> Option<[__m256; 3]> {
        let sum = _mm256_add_ps(_mm256_add_ps(c.u, c.v), c.w);
        let size = _mm256_andnot_ps(_mm256_set1_ps(-0.0), sum);
        let tiny = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(size, _mm256_set1_ps(TINY))) as u32;
        if tiny & c.lanes != 0 {
            return None;
        }
        let Setup { o, axes: [x, y, z], shear, .. } = self.setup;
        // SAFETY: as in `pierced`.
        let row = |v: usize, axis: usize| unsafe { _mm256_loadu_ps(corners.add((3 * v + axis) * count)) };
        let a = [row(0, x), row(0, y), row(0, z)];
        let edge = |v: usize| [_mm256_sub_ps(row(v, x), a[0]), _mm256_sub_ps(row(v, y), a[1]), _mm256_sub_ps(row(v, z), a[2])];
        let (e, f) = (edge(1), edge(2));
        let scale = _mm256_div_ps(_mm256_set1_ps(1.0), sum);
        let minor = |i: usize, j: usize| {
            let cd = _mm256_mul_ps(e[j], f[i]);
            let lost = _mm256_fnmadd_ps(e[j], f[i], cd);
            _mm256_mul_ps(_mm256_add_ps(_mm256_fmsub_ps(e[i], f[j], cd), lost), scale)
        };
        let n = [minor(1, 2), minor(2, 0), minor(0, 1)];
        let dot = |p: __m256, q: __m256, r: __m256| _mm256_fmadd_ps(n[0], p, _mm256_fmadd_ps(n[1], q, _mm256_mul_ps(n[2], r)));
        let to_plane = dot(_mm256_sub_ps(a[0], _mm256_set1_ps(o[x])), _mm256_sub_ps(a[1], _mm256_set1_ps(o[y])), c.depth[0]);
        let along = dot(_mm256_set1_ps(shear[0]), _mm256_set1_ps(shear[1]), _mm256_set1_ps(1.0));
        let first = _mm256_min_ps(_mm256_min_ps(c.depth[0], c.depth[1]), c.depth[2]);
        let last = _mm256_max_ps(_mm256_max_ps(c.depth[0], c.depth[1]), c.depth[2]);
        let depth = _mm256_min_ps(_mm256_max_ps(_mm256_div_ps(to_plane, along), first), last);
        Some([_mm256_mul_ps(depth, _mm256_set1_ps(shear[2])), _mm256_mul_ps(c.v, scale), _mm256_mul_ps(c.w, scale)])
    }

    /// # Safety
    /// As for [`Kernel::nearest`].
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    unsafe fn nearest_of(&self, corners: *const f32, count: usize, best: f32) -> Option<LaneHit> {
        // SAFETY: passed on.
        let candidates = unsafe { self.pierced(corners, count) };
        if candidates.lanes == 0 {
            return None;
        }
        // SAFETY: passed on.
        let Some([t, u, v]) = (unsafe { self.divide(corners, count, &candidates) }) else {
            // SAFETY: passed on.
            return unsafe { Plain(self.setup).nearest(corners, count, best) };
        };
        let ahead = _mm256_cmp_ps::<_CMP_GT_OQ>(t, _mm256_setzero_ps());
        let before = _mm256_cmp_ps::<_CMP_LE_OQ>(t, _mm256_set1_ps(best));
        let mut lanes = _mm256_movemask_ps(_mm256_and_ps(ahead, before)) as u32 & candidates.lanes;
        if lanes == 0 {
            return None;
        }
        let [mut ts, mut us, mut vs] = [[0.0_f32; WIDTH]; 3];
        // SAFETY: eight floats have room in each.
        unsafe {
            _mm256_storeu_ps(ts.as_mut_ptr(), t);
            _mm256_storeu_ps(us.as_mut_ptr(), u);
            _mm256_storeu_ps(vs.as_mut_ptr(), v);
        }
        let mut lane = lanes.trailing_zeros() as usize & 7;
        lanes &= lanes - 1;
        while lanes != 0 {
            let other = lanes.trailing_zeros() as usize & 7;
            lanes &= lanes - 1;
            if ts[other] < ts[lane] {
                lane = other;
            }
        }
        Some(LaneHit { t: ts[lane], u: us[lane], v: vs[lane], lane })
    }

    /// # Safety
    /// As for [`Kernel::nearest`].
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    unsafe fn any_of(&self, corners: *const f32, count: usize, t_max: f32) -> bool {
        // SAFETY: passed on.
        let candidates = unsafe { self.pierced(corners, count) };
        if candidates.lanes == 0 {
            return false;
        }
        // SAFETY: passed on.
        let Some([t, ..]) = (unsafe { self.divide(corners, count, &candidates) }) else {
            // SAFETY: passed on.
            return unsafe { Plain(self.setup).any(corners, count, t_max) };
        };
        let ahead = _mm256_cmp_ps::<_CMP_GT_OQ>(t, _mm256_setzero_ps());
        let before = _mm256_cmp_ps::<_CMP_LT_OQ>(t, _mm256_set1_ps(t_max));
        _mm256_movemask_ps(_mm256_and_ps(ahead, before)) as u32 & candidates.lanes != 0
    }
}

// SAFETY of all calls below: this kernel is only used where `Path::best` found its features.
impl Kernel for Avx2 {
    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        // SAFETY: see above.
        unsafe { Self::prepare(ray) }
    }

    #[inline(always)]
    fn boxes(&self, node: &Node, best: f32, enter: &mut [f32; WIDTH]) -> u32 {
        // SAFETY: see above.
        unsafe { self.meet(node, best, enter) }
    }

    #[inline(always)]
    unsafe fn nearest(&self, corners: *const f32, count: usize, best: f32) -> Option<LaneHit> {
        // SAFETY: passed on, and see above.
        unsafe { self.nearest_of(corners, count, best) }
    }

    #[inline(always)]
    unsafe fn any(&self, corners: *const f32, count: usize, t_max: f32) -> bool {
        // SAFETY: passed on, and see above.
        unsafe { self.any_of(corners, count, t_max) }
    }

    fn closest<S: CustomShapes>(start: Start<'_>, ray: &Ray, shapes: &S, instance: u32, nearest: &mut Nearest) {
        #[target_feature(enable = "avx2,fma,bmi1,bmi2")]
        fn compiled<S: CustomShapes>(start: Start<'_>, ray: &Ray, shapes: &S, instance: u32, nearest: &mut Nearest) {
            super::closest_in::<Avx2, S>(start, ray, shapes, instance, nearest);
        }
        // SAFETY: see above.
        unsafe { compiled(start, ray, shapes, instance, nearest) }
    }

    fn occluded<S: CustomShapes>(start: Start<'_>, ray: &Ray, shapes: &S, last: &mut Option<Child>) -> bool {
        #[target_feature(enable = "avx2,fma,bmi1,bmi2")]
        fn compiled<S: CustomShapes>(start: Start<'_>, ray: &Ray, shapes: &S, last: &mut Option<Child>) -> bool {
            super::occluded_in::<Avx2, S>(start, ray, shapes, last)
        }
        // SAFETY: see above.
        unsafe { compiled(start, ray, shapes, last) }
    }
}
