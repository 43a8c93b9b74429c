//! The zero set of signed distances on a grid [Hansson-Söderlund, Evans, Akenine-Möller 2022].
//!
//! ```text
//! f(p) = Σ s_ijk (trilinear weights of p in its voxel) = 0,    object coordinates [0, 1]³ span the grid's outermost samples
//! ```
//!
//! Along a ray f is a cubic within each voxel. Rays walk from voxel to voxel; the value at which they leave one is the value at which
//! they enter the next, so a change of sign is seen by exactly one voxel and no ray slips through a face. Where no voxel within k - 1 of theirs
//! (in the largest coordinate) holds a change, they leave all of those at once.
//!
//! | normals | |
//! | --- | --- |
//! | analytic | ∇f of the voxel, for geometry and for shading |
//! | smooth | shading alone: the gradients, made unit, of the eight voxels around the nearest sample, blended [ibid., §5] |
//!
//! There are no texture coordinates, and it cannot emit.

use super::trilinear::Trilinear;
use super::{Geometry, SurfacePoint};
use crate::interaction::Interaction;
use etendue_accel::{CustomHit, Hit};
use etendue_numerics::math::gamma;
use etendue_numerics::{Bounds3, Frame, Ray, Transform, Vec2, Vec3};
use glam::{BVec3, DAffine3, DVec3, IVec3};

/// Samples of a signed distance function with a place in the world.
#[derive(Clone, Debug)]
pub struct SdfGrid {
    samples: Vec<f32>,
    size: [usize; 3],
    /// Grid coordinates (whole numbers at the samples) to world.
    to_world: DAffine3,
    to_grid: DAffine3,
    bounds: Bounds3,
    /// For each voxel, one less than samples along each axis, how far from it the nearest in which f changes sign is, in the largest coordinate.
    clear: Vec<u8>,
    smooth: bool,
}

impl SdfGrid {
    /// `samples` with x fastest, `size` of them along x, y, z, each at least 2. `None` where no voxel holds a surface or the map is degenerate.
    pub fn new(samples: Vec<f32>, size: [usize; 3], to_world: &Transform, smooth: bool) -> Option<Self> {
        if size.iter().any(|n| *n < 2) || size.iter().try_fold(1usize, |n, s| n.checked_mul(*s)) != Some(samples.len()) {
            return None;
        }
        let scale = DVec3::from_array(size.map(|n| 1.0 / (n - 1) as f64));
        let to_world = DAffine3::from_mat4(to_world.matrix()) * DAffine3::from_scale(scale);
        let to_grid = to_world.inverse();
        if !to_world.is_finite() || !to_grid.is_finite() {
            return None;
        }
        let mut grid = Self { samples, size, to_world, to_grid, bounds: Bounds3::EMPTY, clear: Vec::new(), smooth };
        let [nx, ny, nz] = size.map(|n| n as i32 - 1);
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    let corners = grid.corners(IVec3::new(i, j, k));
                    let crossed = corners.iter().any(|s| *s <= 0.0) && corners.iter().any(|s| *s >= 0.0);
                    grid.clear.push(if crossed { 0 } else { u8::MAX });
                    if crossed {
                        let low = DVec3::new(i.into(), j.into(), k.into());
                        let around = (0..8).map(|c| low + DVec3::new((c & 1).into(), (c >> 1 & 1).into(), (c >> 2).into()));
                        for p in around {
                            grid.bounds = grid.bounds.including(grid.to_world.transform_point3(p).as_vec3());
                        }
                    }
                }
            }
        }
        spread(&mut grid.clear, size.map(|n| n - 1));
        let margin = grid.bounds.min.abs().max(grid.bounds.max.abs()) * gamma(4);
        grid.bounds = Bounds3 { min: grid.bounds.min - margin, max: grid.bounds.max + margin };
        (!grid.bounds.is_empty() && grid.bounds.min.is_finite() && grid.bounds.max.is_finite()).then_some(grid)
    }

    /// The sample nearest to an index that may lie outside.
    fn sample(&self, i: IVec3) -> f64 {
        let [nx, ny, nz] = self.size;
        let at = |i: i32, n: usize| i.clamp(0, n as i32 - 1) as usize;
        self.samples[(at(i.z, nz) * ny + at(i.y, ny)) * nx + at(i.x, nx)].into()
    }

    /// The last voxel.
    #[inline]
    fn last(&self) -> [i32; 3] {
        let [nx, ny, nz] = self.size;
        [nx as i32 - 2, ny as i32 - 2, nz as i32 - 2]
    }

    /// The eight samples of a voxel, x fastest; above the grid's last they repeat.
    #[inline]
    fn corners(&self, voxel: IVec3) -> [f64; 8] {
        let [nx, ny, _] = self.size;
        if voxel.cmplt(IVec3::ZERO).any() || voxel.cmpgt(self.last().into()).any() {
            return std::array::from_fn(|c| self.sample(voxel + IVec3::new(c as i32 & 1, c as i32 >> 1 & 1, c as i32 >> 2)));
        }
        let (x, y, z) = (voxel.x as usize, voxel.y as usize, voxel.z as usize);
        let row = |j: usize, k: usize| {
            let row = &self.samples[((z + k) * ny + y + j) * nx + x..][..2];
            (f64::from(row[0]), f64::from(row[1]))
        };
        let (a, b, c, d) = (row(0, 0), row(1, 0), row(0, 1), row(1, 1));
        [a.0, a.1, b.0, b.1, c.0, c.1, d.0, d.1]
    }

    fn voxel_index(&self, v: IVec3) -> usize {
        (v.z as usize * (self.size[1] - 1) + v.y as usize) * (self.size[0] - 1) + v.x as usize
    }

    fn voxel_of_index(&self, i: u32) -> IVec3 {
        let (nx, ny) = (self.size[0] as u32 - 1, self.size[1] as u32 - 1);
        IVec3::new((i % nx) as i32, (i / nx % ny) as i32, (i / nx / ny) as i32)
    }

    /// The blend of unit gradients, in object coordinates, at grid coordinates `p` within `voxel`.
    ///
    /// The gradient of each of the eight voxels around the sample nearest to p is made of differences across that voxel along one axis, at
    /// p's own place along the other two. A voxel below the grid's first does not take part; above its last the samples repeat.
    fn smooth_gradient(&self, p: DVec3, voxel: IVec3) -> DVec3 {
        let scale = DVec3::from_array(self.size.map(|n| (n - 1) as f64));
        let low = p.round().as_ivec3() - 1;
        let exists = low.cmpge(IVec3::ZERO);
        let weight = DVec3::select(exists, p - low.as_dvec3() - 0.5, DVec3::ONE);

        // Differences across the lower and the upper voxel along each axis.
        let difference = |axis: usize, index: i32| {
            let mut v = voxel;
            v[axis] = index;
            Trilinear(self.corners(v)).gradient(p - voxel.as_dvec3())[axis] * scale[axis]
        };
        let d = [0, 1].map(|step| DVec3::from_array(std::array::from_fn(|axis| difference(axis, low[axis] + step))));

        let mut sum = DVec3::ZERO;
        for c in 0..8u32 {
            let high = BVec3::new(c & 1 == 1, c >> 1 & 1 == 1, c >> 2 == 1);
            if (high | exists).all() {
                let w = DVec3::select(high, weight, 1.0 - weight);
                sum += DVec3::select(high, d[1], d[0]).normalize_or_zero() * w.element_product();
            }
        }
        sum
    }
}

/// From 0 at some voxels, and the most elsewhere, to how far the nearest of those is in the largest coordinate: once up, once down.
fn spread(clear: &mut [u8], [nx, ny, nz]: [usize; 3]) {
    let index = |[i, j, k]: [usize; 3]| (k * ny + j) * nx + i;
    // The thirteen of its neighbours that come before a voxel.
    let before: Vec<[isize; 3]> = (0..13).map(|c| [c % 3 - 1, c / 3 % 3 - 1, c / 9 - 1]).collect();
    for sign in [1, -1] {
        let mut look = |at: [usize; 3]| {
            for step in &before {
                let [i, j, k] = [0, 1, 2].map(|a| at[a].wrapping_add_signed(sign * step[a]));
                if i < nx && j < ny && k < nz {
                    clear[index(at)] = clear[index(at)].min(clear[index([i, j, k])].saturating_add(1));
                }
            }
        };
        for n in 0..nx * ny * nz {
            let n = if sign > 0 { n } else { nx * ny * nz - 1 - n };
            look([n % nx, n / nx % ny, n / nx / ny]);
        }
    }
}

/// What is known of f where a ray enters a voxel.
enum Entry {
    Unknown,
    Value(f64),
    /// It has the sign of any sample of this voxel, the one before.
    Same([i32; 3]),
}

impl Geometry for SdfGrid {
    fn bounds(&self) -> Bounds3 {
        self.bounds
    }

    /// Not known: it cannot emit.
    fn area_of(&self, _: u32) -> f32 {
        0.0
    }

    fn intersect(&self, ray: &Ray) -> Option<CustomHit> {
        let o = self.to_grid.transform_point3(ray.o.as_dvec3());
        let d = self.to_grid.transform_vector3(ray.d.as_dvec3());
        let last = self.last();

        // The part of the ray within the grid. An axis along which the ray does not move asks only whether it is inside. Where the ray itself
        // ends decides which hits count, and none of their bits.
        let (mut t, mut end, t_max) = (0.0f64, f64::INFINITY, f64::from(ray.t_max));
        for axis in 0..3 {
            let high = f64::from(last[axis] + 1);
            if d[axis] == 0.0 {
                if !(0.0..=high).contains(&o[axis]) {
                    return None;
                }
                continue;
            }
            let (a, b) = (-o[axis] / d[axis], (high - o[axis]) / d[axis]);
            t = t.max(a.min(b));
            end = end.min(a.max(b));
        }
        if t > end.min(t_max) {
            return None;
        }

        // From voxel to voxel. The value at the exit of one is the value at the entry of the next.
        // Arrays are spelled out: closures given to their `map` are called one by one.
        let whole = |t: f64, i: usize, low: i32, high: i32| ((o[i] + d[i] * t) as i32).clamp(low.max(0), high.min(last[i]));
        let mut voxel = [whole(t, 0, 0, last[0]), whole(t, 1, 0, last[1]), whole(t, 2, 0, last[2])];
        let mut entry = Entry::Unknown;
        loop {
            let index = self.voxel_index(voxel.into());
            let clear = i32::from(self.clear[index]);
            // Where the ray leaves it, or all that are clear: at the nearest of the three planes ahead.
            let (mut exit, mut axis, reach) = (end, 3, clear.max(1));
            for i in 0..3 {
                let plane = f64::from(voxel[i] + if d[i] > 0.0 { reach } else { 1 - reach });
                let at = (plane - o[i]) / d[i];
                if d[i] != 0.0 && at < exit {
                    (exit, axis) = (at, i);
                }
            }
            let exit = exit.max(t);
            if clear == 0 {
                let low = IVec3::from_array(voxel).as_dvec3();
                let field = Trilinear(self.corners(voxel.into()));
                let value = |t: f64| field.at((o + d * t - low).clamp(DVec3::ZERO, DVec3::ONE));
                let f0 = match entry {
                    Entry::Unknown => value(t),
                    Entry::Value(f0) => f0,
                    Entry::Same(voxel) => self.sample(voxel.into()),
                };
                let f1 = value(exit);
                if let Some(root) = field.root(o - low, d, (t, f0), (exit, f1)) {
                    let hit = root as f32;
                    if hit > 0.0 && hit < ray.t_max {
                        return Some(CustomHit { t: hit, u: 0.0, v: 0.0, primitive: index as u32 });
                    }
                }
                entry = Entry::Value(f1);
            } else {
                entry = Entry::Same(voxel);
            }
            if axis == 3 || exit > t_max {
                return None;
            }
            let beyond = voxel[axis] + if d[axis] > 0.0 { reach } else { -reach };
            if beyond < 0 || beyond > last[axis] {
                return None;
            }
            if reach > 1 {
                let within = |i: usize| whole(exit, i, voxel[i] + 1 - reach, voxel[i] + reach - 1);
                voxel = [within(0), within(1), within(2)];
            }
            voxel[axis] = beyond;
            t = exit;
        }
    }

    fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
        let voxel = self.voxel_of_index(hit.primitive);
        let field = Trilinear(self.corners(voxel));
        let low = voxel.as_dvec3();
        let mut p = self.to_grid.transform_point3(ray.o.as_dvec3() + ray.d.as_dvec3() * f64::from(hit.t)) - low;

        // The hit's t is rounded: back onto the surface, along the gradient.
        for _ in 0..3 {
            let g = field.gradient(p);
            let step = g * (field.at(p) / g.length_squared());
            if step.is_finite() && step.length_squared() < 1.0 {
                p -= step;
            }
        }

        // Normals are covectors. Where the gradient vanishes the ray itself tells a side.
        let to_normal = self.to_grid.matrix3.transpose();
        let back = -ray.d.normalize();
        let n = (to_normal * field.gradient(p)).try_normalize().map_or(back, |n| n.as_vec3());
        let object = DVec3::from_array(self.size.map(|n| (n - 1) as f64));
        let ns = match self.smooth {
            true => (to_normal * (self.smooth_gradient(p + low, voxel) / object)).try_normalize().map_or(n, |n| n.as_vec3()),
            false => n,
        };
        let world = self.to_world.transform_point3(p + low).as_vec3();
        let frame = Frame::from_normal(ns);
        let point = SurfacePoint {
            p: world,
            p_error: world.abs() * gamma(2),
            n: if n.dot(ns) < 0.0 { -n } else { n },
            ns,
            uv: Vec2::ZERO,
            primitive: hit.primitive,
            bary: Vec2::ZERO,
            pdf_a: 0.0,
        };
        Interaction::at(&point, ray, hit, frame.s, frame.t)
    }

    /// Nothing can be drawn: the density is zero.
    fn sample_area(&self, _: u32, _: Vec2) -> SurfacePoint {
        let p = self.bounds.center();
        let zero = Vec3::ZERO;
        SurfacePoint { p, p_error: zero, n: Vec3::Z, ns: Vec3::Z, uv: Vec2::ZERO, primitive: 0, bary: Vec2::ZERO, pdf_a: 0.0 }
    }
}
