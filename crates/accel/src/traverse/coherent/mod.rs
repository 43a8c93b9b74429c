//! Sixteen rays that stay together, through any tree, in AVX-512: rays of the eye, rays towards a small lamp.
//!
//! A node's eight boxes first meet the hull of the rays, all at once, by interval arithmetic: the least that (plane - o) / d can be among them
//! for the entry, the most for the exit. What the hull meets waits, in order of its entry, and meets the rays themselves when its turn comes, with
//! the hits known by then. Where few of them are left they go on singly.
//!
//! Rounding is monotone, so the hull's entry is not after that of any of its rays, nor its exit before: the same hits as one by one, bit for bit.

mod closest;
mod occluded;

pub(super) use closest::closest;
pub(super) use occluded::occluded;

use super::packet::{Packet, RAYS, at};
use super::setup;
use crate::Accel;
use crate::instance::Instance;
use crate::layout::{Node, WIDTH};
use etendue_numerics::Ray;
use glam::{DAffine3, DVec3, Vec3};
use std::arch::x86_64::*;

/// Rays that go on singly.
const FEW: u32 = 2;

/// Up to so many rays are not worth a packet.
const LEAST: usize = 5;

/// Whether rays of one kind are likely to go through a tree together: the first, the middle one and the last leave nearly the same place in
/// nearly the same direction.
#[inline]
pub(super) fn stay_together(accel: &Accel, rays: &[Ray], these: &[u32]) -> bool {
    /// The square of the cosine between two of them, and of their distance over the tree's diagonal.
    const COS2: f32 = 0.97;
    const APART2: f32 = 0.003;
    if these.len() < LEAST {
        return false;
    }
    let ray = |i: usize| &rays[these[i] as usize];
    let (first, size) = (ray(0), accel.bounds.size().length_squared());
    [these.len() / 2, these.len() - 1].iter().all(|i| {
        let other = ray(*i);
        let dot = first.d.dot(other.d);
        let is_along = dot * dot >= COS2 * first.d.length_squared() * other.d.length_squared();
        is_along && (first.o - other.o).length_squared() <= APART2 * size
    })
}

/// What all rays of a packet lie within, for each axis: origins, and reciprocals of directions.
struct Hull {
    /// The origin that makes the entry the earliest, the one that makes the exit the latest.
    first: [__m256; 3],
    last: [__m256; 3],
    /// The least and the greatest factor.
    near: [[__m256; 2]; 3],
    far: [[__m256; 2]; 3],
}

impl Hull {
    /// That of `lanes`; `None` where one of them runs across an axis.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    fn of(packet: &Packet, lanes: __mmask16) -> Option<Self> {
        let least = |x: __m512| _mm512_mask_reduce_min_ps(lanes, x);
        let most = |x: __m512| _mm512_mask_reduce_max_ps(lanes, x);
        let zero = _mm256_setzero_ps();
        let mut hull = Self { first: [zero; 3], last: [zero; 3], near: [[zero; 2]; 3], far: [[zero; 2]; 3] };
        for a in 0..3 {
            let (low, high) = (least(packet.o[a]), most(packet.o[a]));
            let (near, far) = ([least(packet.near[a]), most(packet.near[a])], [least(packet.far[a]), most(packet.far[a])]);
            if !(far[0].is_finite() && far[1].is_finite()) {
                return None;
            }
            let backwards = packet.rows[a] & 1 != 0;
            let (first, last) = if backwards { (low, high) } else { (high, low) };
            (hull.first[a], hull.last[a]) = (_mm256_set1_ps(first), _mm256_set1_ps(last));
            hull.near[a] = [_mm256_set1_ps(near[0]), _mm256_set1_ps(near[1])];
            hull.far[a] = [_mm256_set1_ps(far[0]), _mm256_set1_ps(far[1])];
        }
        Some(hull)
    }

    /// Which of a node's boxes any ray within the hull may meet up to `best`, and where it enters them at the earliest.
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn meet(&self, rows: [usize; 3], node: &Node, best: f32, enter: &mut [f32; WIDTH]) -> u32 {
        // SAFETY: nodes are aligned to 32 bytes.
        let row = |r: usize| unsafe { _mm256_load_ps(node.rows[r].as_ptr()) };
        let near = |a: usize| {
            let to = _mm256_sub_ps(row(rows[a]), self.first[a]);
            _mm256_min_ps(_mm256_mul_ps(to, self.near[a][0]), _mm256_mul_ps(to, self.near[a][1]))
        };
        let far = |a: usize| {
            let to = _mm256_sub_ps(row(rows[a] ^ 1), self.last[a]);
            _mm256_max_ps(_mm256_mul_ps(to, self.far[a][0]), _mm256_mul_ps(to, self.far[a][1]))
        };
        let enters = _mm256_max_ps(_mm256_max_ps(near(0), near(1)), _mm256_max_ps(near(2), _mm256_setzero_ps()));
        let exits = _mm256_min_ps(_mm256_min_ps(far(0), far(1)), _mm256_min_ps(far(2), _mm256_set1_ps(best)));
        // SAFETY: eight floats have room there.
        unsafe { _mm256_storeu_ps(enter.as_mut_ptr(), enters) };
        _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(enters, exits)) as u32
    }
}

/// A child that waits: place `slot` of a node, the rays that met the node, and where they enter at the earliest.
#[derive(Clone, Copy)]
struct Waiting {
    node: u32,
    enter: f32,
    lanes: __mmask16,
    slot: u16,
}

/// The rays of a packet.
struct Rays<'r> {
    packet: Packet,
    /// What is not in the packet: those of the outer space, and which of them these are.
    all: &'r [Ray],
    these: &'r [u32],
}

impl<'r> Rays<'r> {
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,fma")]
    fn new(kind: usize, all: &'r [Ray], these: &'r [u32]) -> Self {
        Self { packet: Packet::new(kind, these.iter().map(|i| &all[*i as usize])), all, these }
    }

    /// One of them.
    #[inline]
    fn ray(&self, lane: usize) -> Ray {
        let of = |x: &[__m512; 3]| Vec3::new(at(&x[0], lane), at(&x[1], lane), at(&x[2], lane));
        Ray { o: of(&self.packet.o), d: of(&self.packet.d), ..self.all[self.these[lane] as usize] }
    }

    /// Hands over `lanes` of the rays as [`Instance::ray`] has them, kind by kind; returns those that are too few of a kind, or not ordinary there.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,fma")]
    fn within(&self, inner: &Instance, lanes: __mmask16, mut cast: impl FnMut(&Self)) -> __mmask16 {
        let Packet { o, d, t_max, .. } = self.packet;
        let (o, d) = (moved(&inner.inverse, o, 1.0), moved(&inner.inverse, d, 0.0));
        // Sizes as integers compare like the numbers, and what is no number is larger than all.
        let size = |x: __m512| _mm512_and_si512(_mm512_castps_si512(x), _mm512_set1_epi32(i32::MAX));
        let largest = |v: [__m512; 3]| _mm512_max_epu32(_mm512_max_epu32(size(v[0]), size(v[1])), size(v[2]));
        let bound = |x: f32| _mm512_set1_epi32(x.to_bits() as i32);
        let is_small = _mm512_cmple_epu32_mask(_mm512_max_epu32(largest(o), largest(d)), bound(setup::ORDINARY));
        let is_large = _mm512_cmpge_epu32_mask(largest(d), bound(1.0 / setup::ORDINARY));
        // Octant and largest axis, as `order::kind` has them.
        let sign = |a: usize| _mm512_movepi32_mask(_mm512_castps_si512(d[a]));
        let exceeds = |a: usize, b: usize| _mm512_cmpgt_epu32_mask(size(d[a]), size(d[b]));
        let axes = [exceeds(0, 1) & exceeds(0, 2), !exceeds(0, 1) & exceeds(1, 2)];
        let signs = [sign(0), sign(1), sign(2)];

        let (mut left, mut alone) = (lanes & is_small & is_large, lanes & !(is_small & is_large));
        while left != 0 {
            let first = left.trailing_zeros();
            let has = |mask: __mmask16| usize::from(mask >> first & 1);
            let like = |mask: __mmask16| if has(mask) != 0 { mask } else { !mask };
            let same = [signs[0], signs[1], signs[2], axes[0], axes[1]].iter().fold(left, |same, mask| same & like(*mask));
            left &= !same;
            if same.count_ones() <= FEW {
                alone |= same;
                continue;
            }
            let axis = if has(axes[0]) != 0 { 0 } else { 2 - has(axes[1]) };
            let kind = 3 * (has(signs[0]) | has(signs[1]) << 1 | has(signs[2]) << 2) + axis;
            cast(&Self { packet: Packet::of(kind, o, d, t_max, same), ..*self });
        }
        alone
    }
}

/// Points (w = 1) or directions (w = 0) under an affine map, in f64: the operations of `DAffine3`.
#[inline]
#[target_feature(enable = "avx512f,avx512dq")]
fn moved(map: &DAffine3, v: [__m512; 3], w: f64) -> [__m512; 3] {
    let half = |v: [__m512d; 3], a: usize| {
        let times = |column: DVec3, x: __m512d| _mm512_mul_pd(_mm512_set1_pd(column[a]), x);
        let m = &map.matrix3;
        let sum = _mm512_add_pd(_mm512_add_pd(times(m.x_axis, v[0]), times(m.y_axis, v[1])), times(m.z_axis, v[2]));
        _mm512_cvtpd_ps(if w == 0.0 { sum } else { _mm512_add_pd(sum, _mm512_set1_pd(map.translation[a])) })
    };
    let low = |x: __m512| _mm512_cvtps_pd(_mm512_castps512_ps256(x));
    let high = |x: __m512| _mm512_cvtps_pd(_mm512_extractf32x8_ps::<1>(x));
    let (lows, highs) = ([low(v[0]), low(v[1]), low(v[2])], [high(v[0]), high(v[1]), high(v[2])]);
    let both = |a: usize| _mm512_insertf32x8::<1>(_mm512_castps256_ps512(half(lows, a)), half(highs, a));
    [both(0), both(1), both(2)]
}

/// The places of the bits that are set.
#[inline(always)]
fn places(mut lanes: __mmask16) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let i = (lanes != 0).then(|| lanes.trailing_zeros() as usize & (RAYS - 1));
        lanes &= lanes.wrapping_sub(1);
        i
    })
}
