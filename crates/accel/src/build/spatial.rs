//! Spatial splits: references cut by a plane, each side keeping a box around its own part [Stich, Friedrich, Dietrich 2009].
//!
//! They pay where long triangles would make sibling boxes overlap. A split duplicates the references that straddle the plane, so it
//! is taken only while the node's share of the budget lasts.

use crate::build::reference::{Box4, Items, Reference, cut};
use crate::build::split::Extent;
use rayon::prelude::*;

const BINS: usize = 16;
const PARALLEL: usize = 1 << 14;
const CHUNK: usize = 1 << 11;

/// A cut at x[axis] = at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpatialSplit {
    pub cost: f32,
    axis: usize,
    at: f32,
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

/// The planes between the bins of one axis.
#[derive(Clone, Copy)]
struct Grid {
    lo: f32,
    step: f32,
}

impl Grid {
    fn plane(&self, i: usize) -> f32 {
        self.lo + self.step * i as f32
    }

    fn bin(&self, x: f32) -> usize {
        (((x - self.lo) / self.step) as usize).min(BINS - 1)
    }
}

fn fill(references: &[Reference], items: &Items, grids: &[Grid; 3]) -> Bins {
    let mut bins = NO_BINS;
    for r in references {
        let corners = items.corners(r.item());
        for (axis, grid) in grids.iter().enumerate() {
            if grid.step <= 0.0 {
                continue;
            }
            let bins = &mut bins[axis];
            let Some(corners) = &corners else {
                // what cannot be cut lies where its centre is
                let bin = &mut bins[grid.bin(0.5 * r.centroid2()[axis])];
                (bin.bounds, bin.enter, bin.leave) = (bin.bounds.union(r.bounds()), bin.enter + 1, bin.leave + 1);
                continue;
            };
            let (first, last) = (grid.bin(r.lo[axis]), grid.bin(r.hi[axis]));
            let mut rest = *r;
            for i in first..last {
                let (left, right) = cut(&rest, corners, axis, grid.plane(i + 1));
                bins[i].bounds = bins[i].bounds.union(left);
                rest = rest.within(right);
            }
            bins[last].bounds = bins[last].bounds.union(rest.bounds());
            bins[first].enter += 1;
            bins[last].leave += 1;
        }
    }
    bins
}

/// The cheapest cut at a plane between bins; `None` where no plane leaves something on both sides.
pub(crate) fn spatial_split(references: &[Reference], items: &Items, bounds: &Box4) -> Option<SpatialSplit> {
    let size = bounds.hi - bounds.lo;
    let grids = [0, 1, 2].map(|a| {
        let step = size[a] / BINS as f32;
        // a step lost in rounding would give planes that part nothing
        let sound = step.is_finite() && bounds.lo[a] + step > bounds.lo[a] && bounds.hi[a] - step < bounds.hi[a];
        Grid { lo: bounds.lo[a], step: if sound { step } else { 0.0 } }
    });
    let bins = if references.len() < PARALLEL {
        fill(references, items, &grids)
    } else {
        let parts: Vec<Bins> = references.par_chunks(CHUNK).map(|c| fill(c, items, &grids)).collect();
        let mut sum = NO_BINS;
        for part in &parts {
            for (to, from) in sum.iter_mut().flatten().zip(part.iter().flatten()) {
                *to = Bin { bounds: to.bounds.union(from.bounds), enter: to.enter + from.enter, leave: to.leave + from.leave };
            }
        }
        sum
    };

    let mut best: Option<SpatialSplit> = None;
    for axis in 0..3 {
        if grids[axis].step <= 0.0 {
            continue;
        }
        let mut right = [(Box4::EMPTY, 0_u32); BINS];
        let mut side = (Box4::EMPTY, 0);
        for i in (1..BINS).rev() {
            side = (side.0.union(bins[axis][i].bounds), side.1 + bins[axis][i].leave);
            right[i] = side;
        }
        side = (Box4::EMPTY, 0);
        for i in 1..BINS {
            side = (side.0.union(bins[axis][i - 1].bounds), side.1 + bins[axis][i - 1].enter);
            let (left, right) = (side, right[i]);
            if left.1 == 0 || right.1 == 0 {
                continue;
            }
            let cost = left.0.half_area() * left.1 as f32 + right.0.half_area() * right.1 as f32;
            if cost < best.map_or(f32::INFINITY, |b| b.cost) {
                best = Some(SpatialSplit { cost, axis, at: grids[axis].plane(i), left, right });
            }
        }
    }
    best
}

impl SpatialSplit {
    /// Parts the references: those on the left stay in `references`, their number is returned with those on the right.
    ///
    /// A straddling reference goes whole to one side where growing that side's box costs less than the duplicate.
    pub fn part(&self, references: &mut [Reference], items: &Items) -> (usize, Extent, Vec<Reference>, Extent) {
        let (axis, at) = (self.axis, self.at);
        let (mut kept, mut rights) = (0, Vec::with_capacity(self.right.1 as usize));
        let (mut l, mut r) = (Extent::EMPTY, Extent::EMPTY);
        let (area_l, area_r) = (self.left.0.half_area(), self.right.0.half_area());
        let (count_l, count_r) = (self.left.1 as f32, self.right.1 as f32);
        let both = area_l * count_l + area_r * count_r;
        for i in 0..references.len() {
            let whole = references[i];
            let corners = items.corners(whole.item());
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
                        let (left, right) = cut(&whole, corners, axis, at);
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
