//! The zero set of signed distances on a grid [Hansson-Söderlund, Evans, Akenine-Möller 2022].
//!
//! ```text
//! f(p) = Σ s_ijk (trilinear weights of p in its voxel) = 0,    object coordinates [0, 1]³ span the grid's outermost samples
//! ```
//!
//! Along a ray f is a cubic within each voxel. Rays walk from voxel to voxel; the value at which they leave one is the value at which
//! they enter the next, so a change of sign is seen by exactly one voxel and no ray slips through a face.
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
    /// Voxels, one less than samples along each axis, in which f changes sign.
    crossed: Vec<bool>,
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
        let mut grid = Self { samples, size, to_world, to_grid, bounds: Bounds3::EMPTY, crossed: Vec::new(), smooth };
        let [nx, ny, nz] = size.map(|n| n as i32 - 1);
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    let corners = grid.corners(IVec3::new(i, j, k));
                    let crossed = corners.iter().any(|s| *s <= 0.0) && corners.iter().any(|s| *s >= 0.0);
                    grid.crossed.push(crossed);
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

    /// The eight samples of a voxel, x fastest.
    fn corners(&self, voxel: IVec3) -> [f64; 8] {
        std::array::from_fn(|c| self.sample(voxel + IVec3::new(c as i32 & 1, c as i32 >> 1 & 1, c as i32 >> 2)))
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
        let last = IVec3::from_array(self.size.map(|n| n as i32 - 2));

        // The part of the ray within the grid. An axis along which the ray does not move asks only whether it is inside.
        let (mut t, mut end) = (0.0f64, f64::from(ray.t_max));
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
        if t > end {
            return None;
        }

        // From voxel to voxel. The value at the exit of one is the value at the entry of the next.
        let mut voxel = (o + d * t).floor().as_ivec3().clamp(IVec3::ZERO, last);
        let mut entry: Option<f64> = None;
        loop {
            // Where the ray leaves: the nearest of the three planes ahead.
            let (mut exit, mut axis) = (end, 3);
            for i in 0..3 {
                let plane = f64::from(voxel[i] + i32::from(d[i] > 0.0));
                let at = (plane - o[i]) / d[i];
                if d[i] != 0.0 && at < exit {
                    (exit, axis) = (at, i);
                }
            }
            let exit = exit.max(t);
            let index = self.voxel_index(voxel);
            let low = voxel.as_dvec3();
            if self.crossed[index] {
                let field = Trilinear(self.corners(voxel));
                let value = |t: f64| field.at((o + d * t - low).clamp(DVec3::ZERO, DVec3::ONE));
                let (f0, f1) = (entry.unwrap_or_else(|| value(t)), value(exit));
                if let Some(root) = field.root(o - low, d, (t, f0), (exit, f1)) {
                    let hit = root as f32;
                    if hit > 0.0 && hit < ray.t_max {
                        return Some(CustomHit { t: hit, u: 0.0, v: 0.0, primitive: index as u32 });
                    }
                }
                entry = Some(f1);
            } else {
                // One sign throughout: any sample has it.
                entry = Some(self.sample(voxel));
            }
            if axis == 3 {
                return None;
            }
            voxel[axis] += if d[axis] > 0.0 { 1 } else { -1 };
            if voxel[axis] < 0 || voxel[axis] > last[axis] {
                return None;
            }
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
