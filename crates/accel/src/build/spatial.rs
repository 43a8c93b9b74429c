//! Spatial splits: references cut by a plane, each side keeping a box around its own part [Stich, Friedrich, Dietrich 2009].
//!
//! They pay where long triangles would make sibling boxes overlap. A split duplicates the references that straddle the plane, so it
//! is taken only while the node's share of the budget lasts.
//!
//! The search bins boxes, not triangles, and of many only some: it chooses as well and costs a fraction. Only the chosen plane cuts the triangles themselves.

use crate::build::reference::{Box4, Items, Plane, Reference, cut};
use crate::build::split::Extent;
use glam::Vec4;
use rayon::prelude::*;

const BINS: usize = 16;
/// About so many references, taken evenly, choose the plane; what it costs is then counted of all.
const SAMPLE: usize = 1 << 8;
const PARALLEL: usize = 1 << 14;
const CHUNK: usize = 1 << 12;

/// A cut at a plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpatialSplit {
    pub cost: f32,
    plane: Plane,
    left: (Box4, u32),
    right: (Box4, u32),
}

impl SpatialSplit {
    /// The number of references on both sides together.
    pub fn references(&self) -> usize {
        (self.left.1 + self.right.1) as usize
    }
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Box4,
    enter: u32,
    leave: u32,
}

type Bins = [[Bin; BINS]; 3];
const NO_BINS: Bins = [[Bin { bounds: Box4::EMPTY, enter: 0, leave: 0 }; BINS]; 3];

/// The planes between the bins, along all three axes.
struct Grid {
    lo: Vec4,
    /// 0 along an axis that cannot be cut.
    step: Vec4,
    /// 1 / step, or 0.
    scale: Vec4,
    planes: [[Plane; BINS]; 3],
}

impl Grid {
    fn new(bounds: &Box4) -> Self {
        let (mut step, mut scale) = (Vec4::ZERO, Vec4::ZERO);
        for a in 0..3 {
            let s = (bounds.hi[a] - bounds.lo[a]) / BINS as f32;
            // a step lost in rounding would give planes that part nothing
            if s < 1e30 && s > 1e-30 && bounds.lo[a] + s > bounds.lo[a] && bounds.hi[a] - s < bounds.hi[a] {
                (step[a], scale[a]) = (s, 1.0 / s);
            }
        }
        let plane = |axis: usize, i: usize| Plane::new(axis, bounds.lo[axis] + step[axis] * i as f32);
        let planes = std::array::from_fn(|axis| std::array::from_fn(|i| plane(axis, i)));
        Self { lo: bounds.lo, step, scale, planes }
    }

    #[inline]
    fn bins(&self, p: Vec4) -> [usize; 3] {
        let x = ((p - self.lo) * self.scale).to_array();
        [0, 1, 2].map(|a| (x[a] as i32).clamp(0, BINS as i32 - 1) as usize)
    }
}

fn fill(references: &[Reference], items: &Items, grid: &Grid) -> Bins {
    let mut bins = NO_BINS;
    for r in references {
        // what cannot be cut lies where its centre is
        let is_triangle = r.item() < items.triangles();
        let (first, last) = if is_triangle { (grid.bins(r.lo), grid.bins(r.hi)) } else { ([0; 3], grid.bins(0.5 * r.centroid2())) };
        let first = if is_triangle { first } else { last };
        for (axis, bins) in bins.iter_mut().enumerate() {
            let (first, last) = (first[axis], last[axis]);
            let mut rest = r.bounds();
            for (bin, plane) in bins[first..last].iter_mut().zip(&grid.planes[axis][first + 1..]) {
                bin.bounds = bin.bounds.union(Box4 { lo: rest.lo, hi: rest.hi.min(plane.below) });
                rest.lo = rest.lo.max(plane.above);
            }
            bins[last].bounds = bins[last].bounds.union(rest);
            bins[first].enter += 1;
            bins[last].leave += 1;
        }
    }
    bins
}

/// The cheapest cut at a plane between bins; `None` where no plane leaves something on both sides.
pub(crate) fn spatial_split(references: &[Reference], items: &Items, bounds: &Box4) -> Option<SpatialSplit> {
    let step = references.len() / SAMPLE;
    if step < 2 {
        return search(references, items, bounds);
    }
    let sample: Vec<Reference> = references.iter().step_by(step).copied().collect();
    search(&sample, items, bounds).map(|found| SpatialSplit::at(found.plane, references, items))
}

fn search(references: &[Reference], items: &Items, bounds: &Box4) -> Option<SpatialSplit> {
    let grid = Grid::new(bounds);
    let bins = fill(references, items, &grid);
    let mut best: Option<SpatialSplit> = None;
    for (axis, bins) in bins.iter().enumerate() {
        if grid.step[axis] <= 0.0 {
            continue;
        }
        let mut right = [(Box4::EMPTY, 0_u32); BINS];
        let mut side = (Box4::EMPTY, 0);
        for i in (1..BINS).rev() {
            side = (side.0.union(bins[i].bounds), side.1 + bins[i].leave);
            right[i] = side;
        }
        side = (Box4::EMPTY, 0);
        for i in 1..BINS {
            side = (side.0.union(bins[i - 1].bounds), side.1 + bins[i - 1].enter);
            let (left, right) = (side, right[i]);
            if left.1 == 0 || right.1 == 0 {
                continue;
            }
            let cost = left.0.half_area() * left.1 as f32 + right.0.half_area() * right.1 as f32;
            if cost < best.map_or(f32::INFINITY, |b| b.cost) {
                best = Some(SpatialSplit { cost, plane: grid.planes[axis][i], left, right });
            }
        }
    }
    best
}

/// What lies on the two sides of a plane: a box and a number each.
type Sides = [(Box4, u32); 2];

impl SpatialSplit {
    /// The cut of all references at a plane.
    fn at(plane: Plane, references: &[Reference], items: &Items) -> Self {
        let sides = |references: &[Reference]| {
            references.iter().fold([(Box4::EMPTY, 0); 2], |[left, right]: Sides, r| {
                let (below, above) = if r.item() < items.triangles() {
                    (r.lo[plane.axis] < plane.at || r.hi[plane.axis] <= plane.at, r.hi[plane.axis] > plane.at)
                } else {
                    let below = 0.5 * r.centroid2()[plane.axis] < plane.at;
                    (below, !below)
                };
                let part = |side: (Box4, u32), piece: Box4, is: bool| if is { (side.0.union(piece), side.1 + 1) } else { side };
                let (lower, upper) = (r.hi.min(plane.below), r.lo.max(plane.above));
                let both = below && above;
                [
                    part(left, Box4 { lo: r.lo, hi: if both { lower } else { r.hi } }, below),
                    part(right, Box4 { lo: if both { upper } else { r.lo }, hi: r.hi }, above),
                ]
            })
        };
        let [left, right] = if references.len() < PARALLEL {
            sides(references)
        } else {
            let parts: Vec<Sides> = references.par_chunks(CHUNK).map(sides).collect();
            let sum = |a: (Box4, u32), b: (Box4, u32)| (a.0.union(b.0), a.1 + b.1);
            parts.into_iter().fold([(Box4::EMPTY, 0); 2], |[l, r], [x, y]| [sum(l, x), sum(r, y)])
        };
        let cost = left.0.half_area() * left.1 as f32 + right.0.half_area() * right.1 as f32;
        Self { cost, plane, left, right }
    }

    /// Parts the references: those on the left stay in `references`, their number is returned with those on the right.
    ///
    /// A straddling reference goes whole to one side where growing that side's box costs less than the duplicate.
    pub fn part(&self, references: &mut [Reference], items: &Items) -> (usize, Extent, Vec<Reference>, Extent) {
        let Plane { axis, at, .. } = self.plane;
        let (mut kept, mut rights) = (0, Vec::with_capacity(self.right.1 as usize));
        let (mut l, mut r) = (Extent::EMPTY, Extent::EMPTY);
        let (area_l, area_r) = (self.left.0.half_area(), self.right.0.half_area());
        let (count_l, count_r) = (self.left.1 as f32, self.right.1 as f32);
        let both = area_l * count_l + area_r * count_r;
        for i in 0..references.len() {
            let whole = references[i];
            let straddles = whole.lo[axis] < at && whole.hi[axis] > at;
            let corners = if straddles { items.corners4(whole.item()) } else { None };
            let (to_left, to_right) = match &corners {
                _ if whole.hi[axis] <= at => (Some(whole), None),
                _ if whole.lo[axis] >= at => (None, Some(whole)),
                None if 0.5 * whole.centroid2()[axis] < at => (Some(whole), None),
                None => (None, Some(whole)),
                Some(corners) => {
                    let only_l = self.left.0.union(whole.bounds()).half_area() * count_l + area_r * (count_r - 1.0);
                    let only_r = area_l * (count_l - 1.0) + self.right.0.union(whole.bounds()).half_area() * count_r;
                    if only_l < both && only_l <= only_r {
                        (Some(whole), None)
                    } else if only_r < both {
                        (None, Some(whole))
                    } else {
                        let (left, right) = cut(whole.bounds(), corners, &self.plane);
                        match (left.is_sound(), right.is_sound()) {
                            (true, false) => (Some(whole.within(left)), None),
                            (false, true) => (None, Some(whole.within(right))),
                            (true, true) => (Some(whole.within(left)), Some(whole.within(right))),
                            // rounding lost the triangle: keep all of it
                            (false, false) => (Some(whole), None),
                        }
                    }
                }
            };
            if let Some(reference) = to_left {
                l = l.including(&reference);
                references[kept] = reference;
                kept += 1;
            }
            if let Some(reference) = to_right {
                r = r.including(&reference);
                rights.push(reference);
            }
        }
        (kept, l, rights, r)
    }
}
