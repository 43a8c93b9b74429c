//! The kernel for numbers beyond the ordinary, in f64: coordinates past 10¹⁸, directions whose length is near the ends of f32.
//!
//! It is slow and rarely asked. Its hits are those of the plain kernel up to rounding.

use super::{Kernel, LaneHit, Nearest, Start};
use crate::CustomShapes;
use crate::layout::{Child, Node, WIDTH};
use etendue_numerics::Ray;

pub(super) struct Careful {
    o: [f64; 3],
    inverse: [f64; 3],
    axes: [usize; 3],
    shear: [f64; 3],
}

/// The relative error forgiven: that of f32 entry points.
const SLACK: f64 = 4.0 * f32::EPSILON as f64;

impl Careful {
    unsafe fn triangle(&self, corners: *const f32, count: usize, lane: usize) -> Option<[f32; 3]> {
        let [x, y, z] = self.axes;
        // SAFETY: nine rows of `count` floats lie there.
        let at = |v: usize, axis: usize| f64::from(unsafe { *corners.add((3 * v + axis) * count + lane) }) - self.o[axis];
        let corner = |v: usize| {
            let depth = at(v, z);
            [at(v, x) - self.shear[0] * depth, at(v, y) - self.shear[1] * depth, depth]
        };
        let (a, b, c) = (corner(0), corner(1), corner(2));
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let sum = u + v + w;
        if !((u >= 0.0 && v >= 0.0 && w >= 0.0 || u <= 0.0 && v <= 0.0 && w <= 0.0) && sum != 0.0) {
            return None;
        }
        let (u, v, w) = (u / sum, v / sum, w / sum);
        Some([((u * a[2] + v * b[2] + w * c[2]) * self.shear[2]) as f32, v as f32, w as f32])
    }
}

impl Kernel for Careful {
    fn new(ray: &Ray) -> Self {
        let (o, d) = (ray.o.to_array().map(f64::from), ray.d.to_array().map(f64::from));
        // ±∞ where d is 0; the minima and maxima below pass over 0 · ∞
        let inverse = d.map(|d| 1.0 / d);
        let z = (0..3).fold(0, |z, a| if d[a].abs() > d[z].abs() { a } else { z });
        let (x, y) = ([1, 2, 0][z], [2, 0, 1][z]);
        Self { o, inverse, axes: [x, y, z], shear: [d[x] * inverse[z], d[y] * inverse[z], inverse[z]] }
    }

    fn boxes(&self, node: &Node, best: f32, enter: &mut [f32; WIDTH]) -> u32 {
        let mut met = 0;
        for (i, enter) in enter.iter_mut().enumerate() {
            let (mut near, mut far) = (0.0_f64, f64::from(best));
            for a in 0..3 {
                let t = [2 * a, 2 * a + 1].map(|r| (f64::from(node.rows[r][i]) - self.o[a]) * self.inverse[a]);
                let (n, f) = if self.inverse[a] < 0.0 { (t[1], t[0]) } else { (t[0], t[1]) };
                near = near.max(n * (1.0 - SLACK));
                far = far.min(f * (1.0 + SLACK));
            }
            *enter = (near * (1.0 - SLACK)) as f32;
            met |= u32::from(near <= far) << i;
        }
        met
    }

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

    unsafe fn any(&self, corners: *const f32, count: usize, t_max: f32) -> bool {
        // SAFETY: passed on.
        (0..count).any(|lane| unsafe { self.triangle(corners, count, lane) }.is_some_and(|[t, ..]| t > 0.0 && t < t_max))
    }

    #[cold]
    fn closest<S: CustomShapes>(start: Start<'_>, ray: &Ray, shapes: &S, instance: u32, nearest: &mut Nearest) {
        super::closest_in::<Self, S>(start, ray, shapes, instance, nearest);
    }

    #[cold]
    fn occluded<S: CustomShapes>(start: Start<'_>, ray: &Ray, shapes: &S, last: &mut Option<Child>) -> bool {
        super::occluded_in::<Self, S>(start, ray, shapes, last)
    }
}
