//! Object splits by the surface area heuristic, over bins of centroids [Wald 2007].
//!
//! The cost of a split is A_l n_l + A_r n_r, A half the surface of a side's box, n its number of references. Bins are filled along
//! all three axes in one pass.

use crate::build::reference::{Box4, Reference};
use glam::Vec4;
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

/// From doubled centroids to bin numbers, the same for filling and for parting; the number of bins is a power of two.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Binning {
    origin: Vec4,
    scale: Vec4,
    last: usize,
}

/// 1.5 · 2²³: adding it rounds a small float to an integer, found in the low bits of the sum.
const ROUND: f32 = 12_582_912.0;

impl Binning {
    fn new(centroids: &Box4, bins: usize) -> Self {
        let size = centroids.hi - centroids.lo;
        let scale = |s: f32| if s > 1e-30 && s < 1e30 { bins as f32 * 0.9999 / s } else { 0.0 };
        Self { origin: centroids.lo, scale: Vec4::new(scale(size.x), scale(size.y), scale(size.z), 0.0), last: bins - 1 }
    }

    #[inline]
    fn bins(&self, r: &Reference) -> [usize; 3] {
        let x = (r.centroid2() - self.origin) * self.scale - Vec4::splat(0.5) + Vec4::splat(ROUND);
        [x.x, x.y, x.z].map(|x| x.to_bits() as usize & self.last)
    }

    #[inline]
    pub fn bin(&self, r: &Reference, axis: usize) -> usize {
        let x = (r.centroid2()[axis] - self.origin[axis]) * self.scale[axis] - 0.5 + ROUND;
        x.to_bits() as usize & self.last
    }
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Box4,
    count: u32,
}

const NO_BIN: Bin = Bin { bounds: Box4::EMPTY, count: 0 };

fn fill<const N: usize>(references: &[Reference], binning: &Binning) -> [[Bin; 3]; N] {
    let mut bins = [[NO_BIN; 3]; N];
    for r in references {
        for (axis, i) in binning.bins(r).into_iter().enumerate() {
            let bin = &mut bins[i][axis];
            bin.bounds = bin.bounds.union(r.bounds());
            bin.count += 1;
        }
    }
    bins
}

/// References whose bin along `axis` is below `bin` go left.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObjectSplit {
    pub cost: f32,
    pub axis: usize,
    pub bin: usize,
    pub binning: Binning,
    /// Half the surface of what both sides' boxes share.
    pub overlap: f32,
}

/// The cheapest split between bins; `None` where no plane parts the centroids.
pub(crate) fn object_split(references: &[Reference], extent: &Extent) -> Option<ObjectSplit> {
    if references.len() < FEW { binned::<FEW_BINS>(references, extent) } else { binned::<BINS>(references, extent) }
}

fn binned<const N: usize>(references: &[Reference], extent: &Extent) -> Option<ObjectSplit> {
    let binning = Binning::new(&extent.centroids, N);
    let bins = if references.len() < PARALLEL {
        fill(references, &binning)
    } else {
        // The parts are merged in their order: the bits do not depend on the number of threads.
        let parts: Vec<[[Bin; 3]; N]> = references.par_chunks(CHUNK).map(|c| fill(c, &binning)).collect();
        let mut sum = [[NO_BIN; 3]; N];
        for (to, from) in parts.iter().flat_map(|p| (0..N).map(move |i| (i, &p[i]))) {
            for axis in 0..3 {
                sum[to][axis].bounds = sum[to][axis].bounds.union(from[axis].bounds);
                sum[to][axis].count += from[axis].count;
            }
        }
        sum
    };

    let mut best: Option<ObjectSplit> = None;
    let along = |axis: usize, i: usize| &bins[i][axis];
    for axis in 0..3 {
        if binning.scale[axis] == 0.0 {
            continue;
        }
        // right[i]: everything from bin i on
        let mut right = [(Box4::EMPTY, 0.0_f32); N];
        let (mut bounds, mut count) = (Box4::EMPTY, 0);
        for i in (1..N).rev() {
            bounds = bounds.union(along(axis, i).bounds);
            count += along(axis, i).count;
            right[i] = (bounds, if count == 0 { f32::INFINITY } else { bounds.half_area() * count as f32 });
        }
        (bounds, count) = (Box4::EMPTY, 0);
        for (i, right) in right.iter().enumerate().skip(1) {
            bounds = bounds.union(along(axis, i - 1).bounds);
            count += along(axis, i - 1).count;
            if count == 0 {
                continue;
            }
            let cost = bounds.half_area() * count as f32 + right.1;
            if cost < best.map_or(f32::INFINITY, |b| b.cost) {
                let overlap = bounds.intersection(right.0).half_area_if_not_empty();
                best = Some(ObjectSplit { cost, axis, bin: i, binning, overlap });
            }
        }
    }
    best
}

impl Box4 {
    /// Whether the box holds a point.
    pub fn is_sound(&self) -> bool {
        let d = self.hi - self.lo;
        d.x >= 0.0 && d.y >= 0.0 && d.z >= 0.0
    }

    /// Half the surface, 0 where the box is empty along any axis.
    pub fn half_area_if_not_empty(&self) -> f32 {
        if self.is_sound() { self.half_area() } else { 0.0 }
    }
}

/// Moves what `left` says to the front; returns how many, and the extents of both parts. No branch depends on a reference: half of all
/// guesses would be wrong.
pub(crate) fn partition(references: &mut [Reference], left: impl Fn(&Reference) -> bool) -> (usize, Extent, Extent) {
    let (mut sides, mut lefts) = ([Extent::EMPTY; 2], 0);
    for i in 0..references.len() {
        let r = references[i];
        let is_left = usize::from(left(&r));
        sides[is_left] = sides[is_left].including(&r);
        references[i] = references[lefts];
        references[lefts] = r;
        lefts += is_left;
    }
    let [r, l] = sides;
    (lefts, l, r)
}

/// The most references that [`sweep_split`] takes.
pub(crate) const SWEEP: usize = 8;

/// The cheapest split of a few references over all orders of centroids; leaves them in that order and returns how many go left.
pub(crate) fn sweep_split(references: &mut [Reference]) -> usize {
    let n = references.len();
    if n <= 2 {
        return 1;
    }
    let (mut best, mut best_order, mut best_at) = (f32::INFINITY, [0_u8; SWEEP], n / 2);
    for axis in 0..3 {
        // insertion sort, stable, so that equal centroids keep their order
        let mut order = [0_u8; SWEEP];
        let mut keys = [0.0_f32; SWEEP];
        for (i, reference) in references.iter().enumerate() {
            let key = reference.centroid2()[axis];
            let mut j = i;
            while j > 0 && keys[j - 1] > key {
                (keys[j], order[j]) = (keys[j - 1], order[j - 1]);
                j -= 1;
            }
            (keys[j], order[j]) = (key, i as u8);
        }
        let mut right = [0.0_f32; SWEEP];
        let mut bounds = Box4::EMPTY;
        for i in (1..n).rev() {
            bounds = bounds.union(references[order[i] as usize].bounds());
            right[i] = bounds.half_area() * (n - i) as f32;
        }
        bounds = Box4::EMPTY;
        for i in 1..n {
            bounds = bounds.union(references[order[i - 1] as usize].bounds());
            let cost = bounds.half_area() * i as f32 + right[i];
            if cost < best {
                (best, best_order, best_at) = (cost, order, i);
            }
        }
    }
    if best < f32::INFINITY {
        let mut sorted = [Reference::NONE; SWEEP];
        for i in 0..n {
            sorted[i] = references[best_order[i] as usize];
        }
        references.copy_from_slice(&sorted[..n]);
    }
    best_at
}
