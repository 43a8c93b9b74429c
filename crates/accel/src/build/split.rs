//! Object splits by the surface area heuristic, over bins of centroids [Wald 2007].
//!
//! The cost of a split is A_f n_f + A_b n_b, A half the surface of a side's box, n its number of references; the front has the smaller
//! centroids. Bins are filled along all three axes in one pass. The loops are compiled for wide vectors ([`wide`]), with the same bits.

use crate::build::reference::{Box4, Reference, half_areas, least};
use etendue_numerics::wide::{self, Job};
use glam::{BVec4A, Vec4};
use rayon::prelude::*;

/// Bins along each axis, and where there are few references: it is the bins that cost then.
const BINS: usize = 16;
const FEW_BINS: usize = 8;
const FEW: usize = 64;
/// From this many references on, bins are filled in parallel, chunk by chunk.
const PARALLEL: usize = 1 << 16;
const CHUNK: usize = 1 << 13;

/// What is known of a set of references: the box around them and around their (doubled) centroids.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub bounds: Box4,
    pub centroids: Box4,
}

impl Extent {
    pub const EMPTY: Self = Self { bounds: Box4::EMPTY, centroids: Box4::EMPTY };

    #[inline]
    pub fn including(self, r: &Reference) -> Self {
        Self { bounds: self.bounds.union(r.bounds()), centroids: self.centroids.including(r.centroid2()) }
    }

    pub fn of(references: &[Reference]) -> Self {
        if references.len() < PARALLEL {
            return references.iter().fold(Self::EMPTY, Self::including);
        }
        let parts: Vec<Self> = references.par_chunks(CHUNK).map(|c| c.iter().fold(Self::EMPTY, Self::including)).collect();
        parts
            .into_iter()
            .fold(Self::EMPTY, |a, b| Self { bounds: a.bounds.union(b.bounds), centroids: a.centroids.union(b.centroids) })
    }
}

/// From doubled centroids to bin numbers, the same for filling as for parting; the number of bins is a power of two.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Binning {
    origin: Vec4,
    scale: Vec4,
}

/// 1.5 · 2²³: adding it rounds a small float to an integer, found in the low bits of the sum.
pub(crate) const ROUND: f32 = 12_582_912.0;

impl Binning {
    pub(super) fn new(centroids: &Box4, bins: usize) -> Self {
        let size = centroids.hi - centroids.lo;
        let scale = |s: f32| if s > 1e-30 && s < 1e30 { bins as f32 * 0.9999 / s } else { 0.0 };
        Self { origin: centroids.lo, scale: Vec4::new(scale(size.x), scale(size.y), scale(size.z), 0.0) }
    }

    #[inline(always)]
    fn bins(&self, r: &Reference) -> [usize; 3] {
        let x = (r.centroid2() - self.origin) * self.scale - Vec4::splat(0.5) + Vec4::splat(ROUND);
        [x.x, x.y, x.z].map(|x| x.to_bits() as usize)
    }

    /// Whether a reference's bin along an axis is below a number.
    #[inline(always)]
    fn is_below(&self, r: &Reference, axis: usize, bin: usize) -> bool {
        (r.lo[axis] + r.hi[axis] - self.origin[axis]) * self.scale[axis] - 0.5 + ROUND < ROUND + bin as f32
    }
}

/// What lies in the bins: boxes and numbers along the three axes.
#[derive(Clone, Copy)]
pub(super) struct Bins<const N: usize> {
    boxes: [[Box4; 3]; N],
    counts: [[i32; 4]; N],
}

impl<const N: usize> Bins<N> {
    const NONE: Self = Self { boxes: [[Box4::EMPTY; 3]; N], counts: [[0; 4]; N] };

    fn add(&mut self, other: &Self) {
        for i in 0..N {
            for axis in 0..3 {
                self.boxes[i][axis] = self.boxes[i][axis].union(other.boxes[i][axis]);
                self.counts[i][axis] += other.counts[i][axis];
            }
        }
    }
}

pub(super) struct Fill<'a, const N: usize> {
    pub references: &'a [Reference],
    pub binning: &'a Binning,
}

impl<const N: usize> Job for Fill<'_, N> {
    type Output = Bins<N>;

    #[inline(always)]
    fn run(self) -> Bins<N> {
        let mut bins = Bins::NONE;
        for r in self.references {
            let whole = r.bounds();
            for (axis, i) in self.binning.bins(r).into_iter().enumerate() {
                let i = i & (N - 1);
                bins.boxes[i][axis] = bins.boxes[i][axis].union(whole);
                bins.counts[i][axis] += 1;
            }
        }
        bins
    }
}

/// References whose bin along `axis` is below `bin` go to the front.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObjectSplit {
    pub cost: f32,
    axis: usize,
    bin: usize,
    binning: Binning,
    front: Box4,
    back: Box4,
    /// Half the surface of what both sides' boxes share.
    pub overlap: f32,
}

/// The cheapest split between bins; `None` where no plane parts the centroids.
pub(crate) fn object_split(references: &[Reference], extent: &Extent) -> Option<ObjectSplit> {
    if references.len() < FEW { binned::<FEW_BINS>(references, extent) } else { binned::<BINS>(references, extent) }
}

fn binned<const N: usize>(references: &[Reference], extent: &Extent) -> Option<ObjectSplit> {
    let binning = Binning::new(&extent.centroids, N);
    let binning = &binning;
    if references.len() < PARALLEL {
        return wide::widest(FillAndSearch::<N>(Fill { references, binning }));
    }
    // The parts are merged in their order: the bits do not depend on the number of threads.
    let parts: Vec<Bins<N>> = references.par_chunks(CHUNK).map(|references| wide::widest(Fill { references, binning })).collect();
    let mut sum = Bins::NONE;
    parts.iter().for_each(|part| sum.add(part));
    wide::widest(Search { bins: &sum, binning })
}

pub(super) struct FillAndSearch<'a, const N: usize>(pub Fill<'a, N>);

impl<const N: usize> Job for FillAndSearch<'_, N> {
    type Output = Option<ObjectSplit>;

    #[inline(always)]
    fn run(self) -> Option<ObjectSplit> {
        let binning = self.0.binning;
        Search { bins: &self.0.run(), binning }.run()
    }
}

struct Search<'a, const N: usize> {
    bins: &'a Bins<N>,
    binning: &'a Binning,
}

impl<const N: usize> Job for Search<'_, N> {
    type Output = Option<ObjectSplit>;

    /// All three axes at once. A side without references costs infinity times nothing, which is no number and never the least.
    #[inline(always)]
    fn run(self) -> Option<ObjectSplit> {
        let Bins { boxes, counts } = self.bins;
        let counts: [Vec4; N] = counts.map(|counts| Vec4::from_array(counts.map(|n| n as f32)));
        // the cost of everything from bin i on
        let mut backs = [Vec4::ZERO; N];
        let (mut side, mut count) = ([Box4::EMPTY; 3], Vec4::ZERO);
        for i in (1..N).rev() {
            for axis in 0..3 {
                side[axis] = side[axis].union(boxes[i][axis]);
            }
            count += counts[i];
            backs[i] = half_areas(&side) * count;
        }
        let (mut best, mut best_at) = (Vec4::INFINITY, Vec4::ZERO);
        (side, count) = ([Box4::EMPTY; 3], Vec4::ZERO);
        for i in 1..N {
            for axis in 0..3 {
                side[axis] = side[axis].union(boxes[i - 1][axis]);
            }
            count += counts[i - 1];
            let cost = half_areas(&side) * count + backs[i];
            let is_less = cost.cmplt(best);
            best = Vec4::select(is_less, cost, best);
            best_at = Vec4::select(is_less, Vec4::splat(i as f32), best_at);
        }
        let axis = least(best);
        let (cost, bin) = (best[axis], best_at[axis] as usize);
        if cost == f32::INFINITY {
            return None;
        }
        let all = |boxes: &[[Box4; 3]]| boxes.iter().fold(Box4::EMPTY, |all, b| all.union(b[axis]));
        let (front, back) = boxes.split_at(bin);
        let (front, back) = (all(front), all(back));
        let overlap = front.intersection(back).half_area_if_not_empty();
        Some(ObjectSplit { cost, axis, bin, binning: *self.binning, front, back, overlap })
    }
}

impl ObjectSplit {
    /// Parts the references; returns how many are in front, and the extents of both sides.
    pub fn part(&self, references: &mut [Reference]) -> (usize, Extent, Extent) {
        let (fronts, front, back) = match self.axis {
            0 => wide::widest(Partition::<0> { references, split: self }),
            1 => wide::widest(Partition::<1> { references, split: self }),
            _ => wide::widest(Partition::<2> { references, split: self }),
        };
        (fronts, Extent { bounds: self.front, centroids: front }, Extent { bounds: self.back, centroids: back })
    }
}

/// Moves what is in front to the front; tells how many, and the boxes of the doubled centroids of the front and of the back. No branch depends on a
/// reference: half of all guesses would be wrong.
pub(super) struct Partition<'a, const AXIS: usize> {
    pub references: &'a mut [Reference],
    pub split: &'a ObjectSplit,
}

impl<const AXIS: usize> Job for Partition<'_, AXIS> {
    type Output = (usize, Box4, Box4);

    #[inline(always)]
    fn run(self) -> (usize, Box4, Box4) {
        let Self { references, split } = self;
        let (mut front, mut back, mut fronts) = (Box4::EMPTY, Box4::EMPTY, 0);
        for i in 0..references.len() {
            let r = references[i];
            let is_front = split.binning.is_below(&r, AXIS, split.bin);
            let (c, lane) = (r.centroid2(), BVec4A::splat(is_front));
            front.lo = front.lo.min(Vec4::select(lane, c, Vec4::INFINITY));
            front.hi = front.hi.max(Vec4::select(lane, c, Vec4::NEG_INFINITY));
            back.lo = back.lo.min(Vec4::select(lane, Vec4::INFINITY, c));
            back.hi = back.hi.max(Vec4::select(lane, Vec4::NEG_INFINITY, c));
            references.swap(i, fronts);
            fronts += usize::from(is_front);
        }
        (fronts, front, back)
    }
}
