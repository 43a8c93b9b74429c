//! Sixteen rays at a time through small trees, in AVX-512.
//!
//! In a small tree most rays meet most nodes, and one ray alone spends its time on what is left: preparing it, sorting, guessing branches
//! wrongly. Rays are therefore put in order of direction (eight octants times the axis of the largest component), so that sixteen of them agree on
//! which planes of a box are near and along which axis triangles are met, and each box and each triangle meets all sixteen at once. In
//! large trees such rays part soon, and one at a time is faster.
//!
//! The operations are those of [`super::plain`], in its order: the same hits, bit for bit. A triangle that asks for a closer look (a sum of
//! nearly zero) sends its rays the single way.

use super::MOST_NODES_OF_PACKETS;
use super::plain::TINY;
use super::setup::SLACK;
use super::stack::Stack;
use crate::layout::{Child, Node, ROWS, Tree, WIDTH};
use etendue_numerics::Ray;
use std::arch::x86_64::*;

/// Rays of a packet.
pub(super) const RAYS: usize = 16;

/// Entries that may wait: each of the few nodes leaves at most all its children.
const STACK: usize = MOST_NODES_OF_PACKETS * WIDTH;

/// What each ray of a packet met.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub t: [f32; RAYS],
    pub u: [f32; RAYS],
    pub v: [f32; RAYS],
    pub item: [u32; RAYS],
    /// Rays that hit something.
    pub hit: u16,
    /// Rays that must be cast singly.
    pub again: u16,
}

/// Sixteen rays of one kind, prepared.
pub(super) struct Packet {
    pub o: [__m512; 3],
    pub d: [__m512; 3],
    pub near: [__m512; 3],
    pub far: [__m512; 3],
    pub t_max: __m512,
    pub rows: [usize; 3],
    axes: [usize; 3],
    shear: [__m512; 3],
    pub lanes: __mmask16,
}

/// Where lanes meet a triangle.
pub(super) struct Meeting {
    pub t: __m512,
    pub u: __m512,
    pub v: __m512,
    /// Those that meet it ahead, up to their ends, which count.
    pub lanes: __mmask16,
    /// Those that must be cast singly to know.
    pub again: __mmask16,
}

/// Corners of a triangle as the rays see it, and how they pass it.
struct Candidates {
    u: __m512,
    v: __m512,
    w: __m512,
    depth: [__m512; 3],
    lanes: __mmask16,
}

impl Packet {
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,fma")]
    pub fn new<'r>(kind: usize, rays: impl ExactSizeIterator<Item = &'r Ray>) -> Self {
        let lanes = ((1u32 << rays.len()) - 1) as __mmask16;
        let mut columns = [[0.0f32; RAYS]; 7];
        for (i, ray) in rays.enumerate().take(RAYS) {
            (columns[0][i], columns[1][i], columns[2][i]) = (ray.o.x, ray.o.y, ray.o.z);
            (columns[3][i], columns[4][i], columns[5][i]) = (ray.d.x, ray.d.y, ray.d.z);
            columns[6][i] = ray.t_max;
        }
        // SAFETY: sixteen floats stand there.
        let column = |c: usize| unsafe { _mm512_loadu_ps(columns[c].as_ptr()) };
        let (o, d) = ([column(0), column(1), column(2)], [column(3), column(4), column(5)]);
        Self::of(kind, o, d, column(6), lanes)
    }

    /// The rays that leave `o` towards `d`, `lanes` of them of one kind.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,fma")]
    pub fn of(kind: usize, o: [__m512; 3], d: [__m512; 3], t_max: __m512, lanes: __mmask16) -> Self {
        let over = |a: usize| _mm512_div_ps(_mm512_set1_ps(1.0), d[a]);
        let inverse = [over(0), over(1), over(2)];
        let z = kind % 3;
        let (x, y) = ([1, 2, 0][z], [2, 0, 1][z]);
        let scaled = |by: f32| {
            let by = _mm512_set1_ps(by);
            [_mm512_mul_ps(inverse[0], by), _mm512_mul_ps(inverse[1], by), _mm512_mul_ps(inverse[2], by)]
        };
        let row = |a: usize| 2 * a + (((kind / 3) >> a) & 1);
        Self {
            o,
            d,
            near: scaled(1.0 - SLACK),
            far: scaled(1.0 + SLACK),
            t_max,
            rows: [row(0), row(1), row(2)],
            axes: [x, y, z],
            shear: [_mm512_mul_ps(d[x], inverse[z]), _mm512_mul_ps(d[y], inverse[z]), inverse[z]],
            lanes,
        }
    }

    /// Where the rays enter the box of child `i`, and which of `lanes` do within [0, `best`].
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,fma")]
    pub fn meet(&self, node: &Node, i: usize, best: __m512, lanes: __mmask16) -> (__m512, __mmask16) {
        let plane = |row: usize, a: usize| _mm512_sub_ps(_mm512_set1_ps(node.rows[row][i]), self.o[a]);
        let near = |a: usize| _mm512_mul_ps(plane(self.rows[a], a), self.near[a]);
        let far = |a: usize| _mm512_mul_ps(plane(self.rows[a] ^ 1, a), self.far[a]);
        let enters = _mm512_max_ps(_mm512_max_ps(near(0), near(1)), _mm512_max_ps(near(2), _mm512_setzero_ps()));
        let exits = _mm512_min_ps(_mm512_min_ps(far(0), far(1)), _mm512_min_ps(far(2), best));
        (enters, _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(lanes, enters, exits))
    }

    /// Which of `lanes` pierce a triangle; its corners stand `stride` floats apart, from `corners` on.
    ///
    /// # Safety
    /// Nine floats can be read there.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,fma")]
    unsafe fn pierced(&self, corners: *const f32, stride: usize, lanes: __mmask16) -> Candidates {
        let [x, y, z] = self.axes;
        // SAFETY: see above.
        let at = |v: usize, axis: usize| unsafe { _mm512_set1_ps(*corners.add((3 * v + axis) * stride)) };
        let corner = |v: usize| {
            let depth = _mm512_sub_ps(at(v, z), self.o[z]);
            let across = _mm512_sub_ps(_mm512_sub_ps(at(v, x), self.o[x]), _mm512_mul_ps(self.shear[0], depth));
            let up = _mm512_sub_ps(_mm512_sub_ps(at(v, y), self.o[y]), _mm512_mul_ps(self.shear[1], depth));
            (across, up, depth)
        };
        let (a, b, c) = (corner(0), corner(1), corner(2));
        let cross = |p: (__m512, __m512, __m512), q: (__m512, __m512, __m512)| {
            _mm512_sub_ps(_mm512_mul_ps(p.0, q.1), _mm512_mul_ps(p.1, q.0))
        };
        let (u, v, w) = (cross(c, b), cross(a, c), cross(b, a));
        let least = _mm512_min_ps(_mm512_min_ps(u, v), w);
        let most = _mm512_max_ps(_mm512_max_ps(u, v), w);
        let zero = _mm512_setzero_ps();
        let inside = _mm512_cmp_ps_mask::<_CMP_GE_OQ>(least, zero) | _mm512_cmp_ps_mask::<_CMP_LE_OQ>(most, zero);
        Candidates { u, v, w, depth: [a.2, b.2, c.2], lanes: lanes & inside }
    }

    /// Which of the lanes that pierce a triangle do so after the origin and not after `best`, as far as the corners' depths tell: t is within them.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,fma")]
    fn in_reach(&self, c: &Candidates, best: __m512) -> __mmask16 {
        let scaled = |i: usize| _mm512_mul_ps(c.depth[i], self.shear[2]);
        let (a, b, c_) = (scaled(0), scaled(1), scaled(2));
        let (first, last) = (_mm512_min_ps(_mm512_min_ps(a, b), c_), _mm512_max_ps(_mm512_max_ps(a, b), c_));
        let ahead = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(c.lanes, last, _mm512_setzero_ps());
        _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(ahead, first, best)
    }

    /// t, u, v of a triangle, and the lanes that need a closer look instead.
    ///
    /// # Safety
    /// As for [`Packet::pierced`].
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,fma")]
    unsafe fn divide(&self, corners: *const f32, stride: usize, c: &Candidates) -> ([__m512; 3], __mmask16) {
        let sum = _mm512_add_ps(_mm512_add_ps(c.u, c.v), c.w);
        let tiny = _mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(c.lanes, _mm512_abs_ps(sum), _mm512_set1_ps(TINY));
        let [x, y, z] = self.axes;
        // SAFETY: see above.
        let at = |v: usize, axis: usize| unsafe { *corners.add((3 * v + axis) * stride) };
        // The plane is the same for all rays: its minors are those of one lane.
        let a = [at(0, x), at(0, y), at(0, z)];
        let edge = |v: usize| [at(v, x) - a[0], at(v, y) - a[1], at(v, z) - a[2]];
        let (e, f) = (edge(1), edge(2));
        let scale = _mm512_div_ps(_mm512_set1_ps(1.0), sum);
        let minor = |i: usize, j: usize| {
            let cd = e[j] * f[i];
            let lost = (-e[j]).mul_add(f[i], cd);
            _mm512_mul_ps(_mm512_set1_ps(e[i].mul_add(f[j], -cd) + lost), scale)
        };
        let n = [minor(1, 2), minor(2, 0), minor(0, 1)];
        let dot = |p: __m512, q: __m512, r: __m512| _mm512_fmadd_ps(n[0], p, _mm512_fmadd_ps(n[1], q, _mm512_mul_ps(n[2], r)));
        let from = |i: usize, axis: usize| _mm512_sub_ps(_mm512_set1_ps(a[i]), self.o[axis]);
        let to_plane = dot(from(0, x), from(1, y), c.depth[0]);
        let along = dot(self.shear[0], self.shear[1], _mm512_set1_ps(1.0));
        let first = _mm512_min_ps(_mm512_min_ps(c.depth[0], c.depth[1]), c.depth[2]);
        let last = _mm512_max_ps(_mm512_max_ps(c.depth[0], c.depth[1]), c.depth[2]);
        let depth = _mm512_min_ps(_mm512_max_ps(_mm512_div_ps(to_plane, along), first), last);
        ([_mm512_mul_ps(depth, self.shear[2]), _mm512_mul_ps(c.v, scale), _mm512_mul_ps(c.w, scale)], tiny)
    }
}

impl Packet {
    /// Where `lanes` meet triangle `k` of a leaf's `count`, up to `best`; `None` where none does.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,fma")]
    pub fn meeting(&self, corners: &[f32], k: usize, count: usize, best: __m512, lanes: __mmask16) -> Option<Meeting> {
        debug_assert!(k < count && corners.len() >= count * ROWS);
        // SAFETY: nine rows of `count` floats stand there, and k < count.
        let (mut candidates, at) = unsafe {
            let at = corners.as_ptr().add(k);
            (self.pierced(at, count, lanes), at)
        };
        if candidates.lanes == 0 {
            return None;
        }
        candidates.lanes = self.in_reach(&candidates, best);
        if candidates.lanes == 0 {
            return None;
        }
        // SAFETY: as above.
        let ([t, u, v], again) = unsafe { self.divide(at, count, &candidates) };
        let ahead = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(candidates.lanes & !again, t, _mm512_setzero_ps());
        Some(Meeting { t, u, v, lanes: ahead, again })
    }

    /// Which of `lanes` a leaf's triangles do not stop; notes those that must be cast singly to know.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,fma")]
    pub fn past(&self, tree: &Tree, leaf: Child, mut lanes: __mmask16, again: &mut __mmask16) -> __mmask16 {
        let (start, count) = leaf.run();
        let corners = &tree.corners[start * ROWS..][..count * ROWS];
        for k in 0..count {
            if let Some(meeting) = self.meeting(corners, k, count, self.t_max, lanes) {
                *again |= meeting.again;
                lanes &= !_mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(meeting.lanes, meeting.t, self.t_max);
                if lanes == 0 {
                    break;
                }
            }
        }
        lanes
    }
}

/// A child that waits, and where the rays enter it.
#[derive(Clone, Copy)]
struct Waiting {
    enters: __m512,
    /// Where the first of the rays does.
    first: f32,
    child: Child,
    lanes: __mmask16,
}

/// The nearest hits of up to sixteen rays of one kind.
#[target_feature(enable = "avx512f,avx512dq,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn closest<'r>(tree: &Tree, kind: usize, rays: impl ExactSizeIterator<Item = &'r Ray>) -> Found {
    let packet = Packet::new(kind, rays);
    let mut best = packet.t_max;
    let (mut u, mut v, mut item) = (_mm512_setzero_ps(), _mm512_setzero_ps(), _mm512_setzero_si512());
    let (mut hit, mut again): (__mmask16, __mmask16) = (0, 0);

    let mut stack = Stack::<Waiting, STACK>::new();
    if let Some(child) = tree.root {
        stack.push(Waiting { enters: _mm512_setzero_ps(), first: 0.0, child, lanes: packet.lanes });
    }
    while let Some(Waiting { enters, child, lanes, .. }) = stack.pop() {
        let lanes = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(lanes, enters, best);
        if lanes == 0 {
            continue;
        }
        if child.is_node() {
            // What the first ray enters last waits below all others.
            let node = &tree.nodes[child.0 as usize];
            let (bottom, first) = (stack.len(), lanes.trailing_zeros());
            for i in 0..children(node) {
                let (enters, lanes) = packet.meet(node, i, best, lanes);
                if lanes != 0 {
                    let first = lane(enters, first);
                    stack.push_above(bottom, Waiting { enters, first, child: node.children[i], lanes }, |w| w.first >= first);
                }
            }
            continue;
        }
        let (start, count) = child.run();
        let corners = &tree.corners[start * ROWS..][..count * ROWS];
        for k in 0..count {
            let Some(Meeting { t, u: tu, v: tv, lanes: ahead, again: unsure }) = packet.meeting(corners, k, count, best, lanes)
            else {
                continue;
            };
            again |= unsure;
            let number = _mm512_set1_epi32(tree.items[start + k] as i32);
            let nearer = _mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(ahead, t, best);
            let equal = _mm512_mask_cmp_ps_mask::<_CMP_EQ_OQ>(ahead & hit, t, best);
            let nearer = nearer | _mm512_mask_cmplt_epu32_mask(equal, number, item);
            best = _mm512_mask_mov_ps(best, nearer, t);
            u = _mm512_mask_mov_ps(u, nearer, tu);
            v = _mm512_mask_mov_ps(v, nearer, tv);
            item = _mm512_mask_mov_epi32(item, nearer, number);
            hit |= nearer;
        }
    }

    let mut found = Found { t: [0.0; RAYS], u: [0.0; RAYS], v: [0.0; RAYS], item: [0; RAYS], hit, again };
    // SAFETY: sixteen numbers have room in each.
    unsafe {
        _mm512_storeu_ps(found.t.as_mut_ptr(), best);
        _mm512_storeu_ps(found.u.as_mut_ptr(), u);
        _mm512_storeu_ps(found.v.as_mut_ptr(), v);
        _mm512_storeu_si512(found.item.as_mut_ptr().cast(), item);
    }
    found
}

/// Which of up to sixteen rays of one kind hit anything, and which must be cast singly to know.
#[target_feature(enable = "avx512f,avx512dq,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn occluded<'r>(tree: &Tree, kind: usize, rays: impl ExactSizeIterator<Item = &'r Ray>) -> (u16, u16) {
    let packet = Packet::new(kind, rays);
    let (mut open, mut again) = (packet.lanes, 0);
    let mut stack = Stack::<_, STACK>::new();
    if let Some(child) = tree.root {
        stack.push((child, packet.lanes));
    }
    while let Some((child, lanes)) = stack.pop() {
        let lanes = lanes & open;
        if lanes == 0 {
            continue;
        }
        if child.is_node() {
            // Children lie in order of size: the largest is the likeliest to stop rays.
            let node = &tree.nodes[child.0 as usize];
            for i in (0..children(node)).rev() {
                let (_, lanes) = packet.meet(node, i, packet.t_max, lanes);
                if lanes != 0 {
                    stack.push((node.children[i], lanes));
                }
            }
            continue;
        }
        open &= !lanes | packet.past(tree, child, lanes, &mut again);
    }
    let stopped = packet.lanes & !open;
    (stopped, again & !stopped)
}

/// How many children a node has; they come first.
#[inline(always)]
fn children(node: &Node) -> usize {
    (0..WIDTH).position(|i| node.rows[0][i] > node.rows[1][i]).unwrap_or(WIDTH)
}

/// One number of a vector.
#[inline]
#[target_feature(enable = "avx512f")]
fn lane(x: __m512, i: u32) -> f32 {
    _mm512_cvtss_f32(_mm512_maskz_compress_ps(1 << i, x))
}

/// The same where the vector stands in memory.
#[inline(always)]
pub(super) fn at(x: &__m512, i: usize) -> f32 {
    // SAFETY: a vector is sixteen floats.
    let x: &[f32; RAYS] = unsafe { &*std::ptr::from_ref(x).cast() };
    x[i & (RAYS - 1)]
}
