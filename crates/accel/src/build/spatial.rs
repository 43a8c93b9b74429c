//! Spatial splits: references cut by a plane, each side keeping a box around its own part [Stich, Friedrich, Dietrich 2009].
//!
//! They pay where long triangles would make sibling boxes overlap. A split duplicates the references that straddle the plane, so it
//! is taken only while the node's share of the budget lasts.
//!
//! The search bins boxes, not triangles, and of many only some: it chooses as well and costs a fraction. Only the chosen plane cuts the triangles themselves.

use crate::build::reference::{Box4, Items, Plane, Reference, cut};
use crate::build::split::{Extent, ROUND};
use etendue_numerics::wide::{self, Job};
use glam::{BVec4A, Vec4};
use rayon::prelude::*;
use std::ops::Range;

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

/// What lies in the bins along the three axes: boxes, and how many references begin and end there.
#[derive(Debug)]
pub(super) struct Bins {
    boxes: [[Box4; BINS]; 3],
    enter: [[u32; BINS]; 3],
    leave: [[u32; BINS]; 3],
}

/// The planes between the bins, along all three axes.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    lo: Vec4,
    /// 0 along an axis that cannot be cut.
    step: Vec4,
    /// 1 / step, or 0.
    scale: Vec4,
}

impl Grid {
    pub(super) fn new(bounds: &Box4) -> Self {
        let (mut step, mut scale) = (Vec4::ZERO, Vec4::ZERO);
        for a in 0..3 {
            let s = (bounds.hi[a] - bounds.lo[a]) / BINS as f32;
            // a step lost in rounding would give planes that part nothing
            if s < 1e30 && s > 1e-30 && bounds.lo[a] + s > bounds.lo[a] && bounds.hi[a] - s < bounds.hi[a] {
                (step[a], scale[a]) = (s, 1.0 / s);
            }
        }
        Self { lo: bounds.lo, step, scale }
    }

    #[inline(always)]
    fn bins(&self, p: Vec4) -> [usize; 3] {
        let x = ((p - self.lo) * self.scale - Vec4::splat(0.5)).clamp(Vec4::splat(-0.5), Vec4::splat(BINS as f32 - 1.0));
        let x = x + Vec4::splat(ROUND);
        [x.x, x.y, x.z].map(|x| x.to_bits() as usize & (BINS - 1))
    }

    /// The plane below bin i.
    #[inline(always)]
    fn plane(&self, axis: usize, i: usize) -> Plane {
        Plane::new(axis, self.lo[axis] + self.step[axis] * i as f32)
    }
}

pub(super) struct Fill<'a> {
    pub references: &'a [Reference],
    pub items: &'a Items<'a>,
    pub grid: &'a Grid,
}

impl Job for Fill<'_> {
    type Output = Bins;

    #[inline(always)]
    fn run(self) -> Bins {
        let Self { references, items, grid } = self;
        let mut bins = Bins { boxes: [[Box4::EMPTY; BINS]; 3], enter: [[0; BINS]; 3], leave: [[0; BINS]; 3] };
        let triangles = items.triangles();
        for r in references {
            // what cannot be cut lies where its centre is
            let center = 0.5 * r.centroid2();
            let is_triangle = r.item() < triangles;
            let (first, last) =
                if is_triangle { (grid.bins(r.lo), grid.bins(r.hi)) } else { (grid.bins(center), grid.bins(center)) };
            for axis in 0..3 {
                let (first, last, boxes) = (first[axis], last[axis], &mut bins.boxes[axis]);
                let mut rest = r.bounds();
                for (i, bounds) in boxes[..last].iter_mut().enumerate().skip(first) {
                    let plane = grid.plane(axis, i + 1);
                    *bounds = bounds.union(Box4 { lo: rest.lo, hi: rest.hi.min(plane.below) });
                    rest.lo = rest.lo.max(plane.above);
                }
                boxes[last] = boxes[last].union(rest);
                bins.enter[axis][first] += 1;
                bins.leave[axis][last] += 1;
            }
        }
        bins
    }
}

/// The cheapest cut at a plane between bins; `None` where it would cost more than `limit` or leave nothing on one side.
pub(crate) fn spatial_split(references: &[Reference], items: &Items, bounds: &Box4, limit: f32) -> Option<SpatialSplit> {
    let step = references.len() / SAMPLE;
    let is_cheap = |cut: &SpatialSplit| cut.cost < limit;
    if step < 2 {
        return search(references, items, bounds).filter(is_cheap);
    }
    let mut sample = [Reference::NONE; 2 * SAMPLE];
    let mut count = 0;
    for r in references.iter().step_by(step) {
        sample[count] = *r;
        count += 1;
    }
    // boxes around a sample are too small rather than too large
    let scale = references.len() as f32 / count as f32;
    search(&sample[..count], items, bounds)
        .filter(|cut| cut.cost * scale < limit)
        .map(|cut| SpatialSplit::at(cut.plane, references, items))
        .filter(is_cheap)
}

fn search(references: &[Reference], items: &Items, bounds: &Box4) -> Option<SpatialSplit> {
    let grid = Grid::new(bounds);
    let Bins { boxes, enter, leave } = wide::widest(Fill { references, items, grid: &grid });
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| grid.step[axis] > 0.0) {
        let mut backs = [f32::INFINITY; BINS];
        let mut side = (Box4::EMPTY, 0);
        for i in (1..BINS).rev() {
            side = (side.0.union(boxes[axis][i]), side.1 + leave[axis][i]);
            if side.1 > 0 {
                backs[i] = side.0.half_area() * side.1 as f32;
            }
        }
        side = (Box4::EMPTY, 0);
        for (i, back) in backs.into_iter().enumerate().skip(1) {
            side = (side.0.union(boxes[axis][i - 1]), side.1 + enter[axis][i - 1]);
            let cost = side.0.half_area() * side.1 as f32 + back;
            if side.1 > 0 && cost < best.map_or(f32::INFINITY, |b| b.0) {
                best = Some((cost, axis, i));
            }
        }
    }
    let (cost, axis, i) = best?;
    let side = |range: Range<usize>, counts: &[u32; BINS]| {
        let bounds = boxes[axis][range.clone()].iter().fold(Box4::EMPTY, |all, &b| all.union(b));
        (bounds, counts[range].iter().sum())
    };
    let (left, right) = (side(0..i, &enter[axis]), side(i..BINS, &leave[axis]));
    Some(SpatialSplit { cost, plane: grid.plane(axis, i), left, right })
}

/// What lies on the two sides of a plane: a box and a number each.
type Sides = [(Box4, u32); 2];

/// Counts what lies on both sides of a plane.
pub(super) struct Count<'a> {
    pub references: &'a [Reference],
    pub triangles: u32,
    pub plane: &'a Plane,
}

impl Job for Count<'_> {
    type Output = Sides;

    #[inline(always)]
    fn run(self) -> Sides {
        let Self { references, triangles, plane } = self;
        let part = |side: &mut (Box4, u32), is: bool, piece: Box4| {
            let lane = BVec4A::splat(is);
            side.0.lo = side.0.lo.min(Vec4::select(lane, piece.lo, Vec4::INFINITY));
            side.0.hi = side.0.hi.max(Vec4::select(lane, piece.hi, Vec4::NEG_INFINITY));
            side.1 += u32::from(is);
        };
        let [mut left, mut right] = [(Box4::EMPTY, 0); 2];
        for r in references {
            if r.item() < triangles {
                let (lo, hi) = (r.lo[plane.axis], r.hi[plane.axis]);
                part(&mut left, (lo < plane.at) | (hi <= plane.at), Box4 { lo: r.lo, hi: r.hi.min(plane.below) });
                part(&mut right, hi > plane.at, Box4 { lo: r.lo.max(plane.above), hi: r.hi });
            } else {
                let below = 0.5 * r.centroid2()[plane.axis] < plane.at;
                part(&mut left, below, r.bounds());
                part(&mut right, !below, r.bounds());
            }
        }
        [left, right]
    }
}

impl SpatialSplit {
    /// The cut of all references at a plane.
    fn at(plane: Plane, references: &[Reference], items: &Items) -> Self {
        let sides = |references| wide::widest(Count { references, triangles: items.triangles(), plane: &plane });
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

    /// Parts `references[..count]`: returns how many are on the left, their extent, and the same of those on the right, which follow them.
    /// What lies behind `count` is room for duplicates.
    ///
    /// A straddling reference goes whole to one side where growing that side's box costs less than the duplicate.
    pub fn part(&self, references: &mut [Reference], count: usize, items: &Items) -> (usize, Extent, usize, Extent) {
        const BLOCK: usize = 256;
        let Plane { axis, at, .. } = self.plane;
        // first those on the left, then those on the right, then those not looked at; duplicates for the right from `count` on
        let (mut lefts, mut total) = (0, count);
        for begin in (0..count).step_by(BLOCK) {
            let end = count.min(begin + BLOCK);
            // who straddles is a matter of luck, so what is to be done with them is listed first, and then done
            let (mut is_left, mut straddlers, mut straddling) = ([false; BLOCK], [0_u8; BLOCK], 0);
            for (i, r) in references[begin..end].iter().enumerate() {
                let (lo, hi) = (r.lo[axis], r.hi[axis]);
                is_left[i] = (hi <= at) | ((lo < at) & (0.5 * (lo + hi) < at));
                straddlers[straddling & (BLOCK - 1)] = i as u8;
                straddling += usize::from((lo < at) & (hi > at) & (r.item() < items.triangles()));
            }
            let mut cuts = 0;
            for k in 0..straddling {
                let i = straddlers[k];
                let whole = &references[begin + i as usize];
                match self.better_whole(whole.bounds()) {
                    Some(left) => is_left[i as usize] = left,
                    None => {
                        items.fetch_indices(whole.item());
                        straddlers[cuts] = i;
                        cuts += 1;
                    }
                }
            }
            let straddlers = &straddlers[..cuts];
            straddlers.iter().for_each(|&i| items.fetch_corners(references[begin + i as usize].item()));
            for &i in straddlers {
                let i = i as usize;
                let whole = references[begin + i];
                let Some(corners) = items.corners4(whole.item()).filter(|_| total < references.len()) else { continue };
                let (left, right) = cut(whole.bounds(), &corners, &self.plane);
                // where rounding lost the triangle all of it is kept
                if left.is_sound() && right.is_sound() {
                    references[total] = whole.within(right);
                    total += 1;
                }
                if left.is_sound() {
                    (references[begin + i], is_left[i]) = (whole.within(left), true);
                } else if right.is_sound() {
                    (references[begin + i], is_left[i]) = (whole.within(right), false);
                }
            }
            for i in begin..end {
                references.swap(i, lefts);
                lefts += usize::from(is_left[i - begin]);
            }
        }
        (lefts, Extent::of(&references[..lefts]), total - lefts, Extent::of(&references[lefts..total]))
    }

    /// Whether a reference that straddles the plane goes whole to the left, or to the right; `None` where it is better cut.
    fn better_whole(&self, whole: Box4) -> Option<bool> {
        let (area_l, area_r) = (self.left.0.half_area(), self.right.0.half_area());
        let (count_l, count_r) = (self.left.1 as f32, self.right.1 as f32);
        let both = area_l * count_l + area_r * count_r;
        let only_l = self.left.0.union(whole).half_area() * count_l + area_r * (count_r - 1.0);
        let only_r = area_l * (count_l - 1.0) + self.right.0.union(whole).half_area() * count_r;
        if only_l < both && only_l <= only_r { Some(true) } else { (only_r < both).then_some(false) }
    }
}
