//! The nearest hits of rays that stay together.

use super::super::avx2::Avx2;
use super::super::packet::{Meeting, RAYS};
use super::super::stack::Stack;
use super::super::{Kernel, Nearest, STACK, Start, closest_other, fetch};
use super::{FEW, Hull, Rays, Waiting, places};
use crate::instance::Other;
use crate::layout::{Child, ROWS, Tree, WIDTH};
use crate::{Accel, CustomShapes};
use etendue_numerics::Ray;
use std::arch::x86_64::*;

/// The nearest hit of each ray of a packet so far.
#[repr(C, align(64))]
pub(in super::super) struct Found {
    t: [f32; RAYS],
    u: [f32; RAYS],
    v: [f32; RAYS],
    item: [u32; RAYS],
    instance: [u32; RAYS],
    primitive: [u32; RAYS],
    hit: u16,
    /// Rays that must be cast singly.
    again: u16,
}

impl Found {
    /// What a ray hit, if anything; `None` where it has to be cast singly.
    pub fn of(&self, lane: usize) -> Option<Option<Nearest>> {
        (self.again >> lane & 1 == 0).then(|| (self.hit >> lane & 1 != 0).then(|| self.nearest(lane)))
    }

    #[inline]
    fn nearest(&self, i: usize) -> Nearest {
        let (t, u, v) = (self.t[i], self.u[i], self.v[i]);
        let is_hit = self.hit >> i & 1 != 0;
        Nearest { t, u, v, instance: self.instance[i], item: self.item[i], primitive: self.primitive[i], is_hit }
    }

    /// Lets a ray look for something nearer by itself.
    #[inline]
    fn update(&mut self, i: usize, look: impl FnOnce(&mut Nearest)) {
        let mut nearest = self.nearest(i);
        look(&mut nearest);
        let Nearest { t, u, v, instance, item, primitive, is_hit } = nearest;
        (self.t[i], self.u[i], self.v[i]) = (t, u, v);
        (self.item[i], self.instance[i], self.primitive[i]) = (item, instance, primitive);
        self.hit |= u16::from(is_hit) << i;
    }

    #[inline]
    #[target_feature(enable = "avx512f")]
    fn best(&self) -> __m512 {
        // SAFETY: sixteen floats stand there, at a multiple of 64 bytes.
        unsafe { _mm512_load_ps(self.t.as_ptr()) }
    }

    /// The farthest end of `lanes`.
    #[inline]
    #[target_feature(enable = "avx512f")]
    fn farthest(&self, lanes: __mmask16) -> f32 {
        _mm512_mask_reduce_max_ps(lanes, self.best())
    }

    /// Puts a leaf's triangles before `lanes` of the rays.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    fn meet(&mut self, tree: &Tree, leaf: Child, rays: &Rays<'_>, lanes: __mmask16, instance: u32) {
        let (start, count) = leaf.run();
        let corners = &tree.corners[start * ROWS..];
        for k in 0..count {
            if let Some(meeting) = rays.packet.meeting(corners, k, count, self.best(), lanes) {
                self.take(&meeting, tree.items[start + k], instance);
            }
        }
    }

    /// Takes over the hits on triangle `item` that come before.
    #[inline]
    #[target_feature(enable = "avx512f")]
    fn take(&mut self, meeting: &Meeting, item: u32, instance: u32) {
        let Meeting { t, u, v, lanes, again } = *meeting;
        self.again |= again;
        // SAFETY: sixteen numbers stand in each, at a multiple of 64 bytes.
        unsafe {
            let (best, items) = (self.best(), _mm512_load_si512(self.item.as_ptr().cast()));
            let instances = _mm512_load_si512(self.instance.as_ptr().cast());
            let (this, here) = (_mm512_set1_epi32(item as i32), _mm512_set1_epi32(instance as i32));
            let equal = _mm512_mask_cmp_ps_mask::<_CMP_EQ_OQ>(lanes & self.hit, t, best);
            let before = _mm512_mask_cmplt_epu32_mask(equal, here, instances)
                | _mm512_mask_cmplt_epu32_mask(_mm512_mask_cmpeq_epu32_mask(equal, here, instances), this, items);
            let nearer = _mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(lanes, t, best) | before;
            _mm512_mask_storeu_ps(self.t.as_mut_ptr(), nearer, t);
            _mm512_mask_storeu_ps(self.u.as_mut_ptr(), nearer, u);
            _mm512_mask_storeu_ps(self.v.as_mut_ptr(), nearer, v);
            _mm512_mask_storeu_epi32(self.item.as_mut_ptr().cast(), nearer, this);
            _mm512_mask_storeu_epi32(self.instance.as_mut_ptr().cast(), nearer, here);
            self.hit |= nearer;
        }
    }
}

/// The nearest hits of up to sixteen rays of one kind.
#[target_feature(enable = "avx512f,avx512dq,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(in super::super) fn closest<S: CustomShapes>(accel: &Accel, kind: usize, rays: &[Ray], these: &[u32], shapes: &S) -> Found {
    let rays = Rays::new(kind, rays, these);
    let zero = [0; RAYS];
    let mut found =
        Found { t: [0.0; RAYS], u: [0.0; RAYS], v: [0.0; RAYS], item: zero, instance: zero, primitive: zero, hit: 0, again: 0 };
    // SAFETY: sixteen floats have room there.
    unsafe { _mm512_store_ps(found.t.as_mut_ptr(), rays.packet.t_max) };
    closest_in(accel, &rays, shapes, u32::MAX, &mut found);
    found
}

/// Walks one tree, keeping the nearest hits.
#[target_feature(enable = "avx512f,avx512dq,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn closest_in<S: CustomShapes>(accel: &Accel, rays: &Rays<'_>, shapes: &S, instance: u32, found: &mut Found) {
    let (Some(mut current), packet) = (accel.tree.root, &rays.packet) else { return };
    let (tree, all) = (&accel.tree, packet.lanes);
    let singly = |found: &mut Found, child: Child, lanes: __mmask16| {
        for i in places(lanes) {
            found.update(i, |nearest| Avx2::closest(Start { accel, child }, &rays.ray(i), shapes, instance, nearest));
        }
    };
    let Some(hull) = Hull::of(packet, all) else { return singly(found, current, all) };
    let (mut lanes, mut farthest) = (all, found.farthest(all));
    let mut stack = Stack::<Waiting, STACK>::new();
    loop {
        if current.is_node() && lanes.count_ones() > FEW {
            let node = &tree.nodes[current.0 as usize];
            let mut enter = [0.0; WIDTH];
            let mut met = hull.meet(packet.rows, node, farthest, &mut enter);
            let bottom = stack.len();
            while met != 0 {
                let slot = met.trailing_zeros() as usize & 7;
                met &= met - 1;
                fetch(tree, node.children[slot]);
                // What is entered last waits below all others.
                let (enter, slot) = (enter[slot], slot as u16);
                stack.push_above(bottom, Waiting { node: current.0, enter, lanes, slot }, |w| w.enter >= enter);
            }
        } else {
            let is_few = |child: Child| 4 * lanes.count_ones() as usize <= child.run().1;
            if current.is_node() || current.is_triangles() && is_few(current) {
                singly(found, current, lanes);
            } else if current.is_triangles() {
                found.meet(tree, current, rays, lanes, instance);
            } else {
                closest_others(accel, current.index(), rays, lanes, shapes, instance, found);
            }
            farthest = found.farthest(all);
        }
        loop {
            let Some(next) = stack.pop() else { return };
            if next.enter <= farthest {
                let (node, slot) = (&tree.nodes[next.node as usize], usize::from(next.slot & 7));
                let (_, met) = packet.meet(node, slot, found.best(), next.lanes);
                if met != 0 {
                    (current, lanes) = (node.children[slot], met);
                    break;
                }
            }
        }
    }
}

/// Puts a custom shape or an instance before `lanes` of the rays.
#[target_feature(enable = "avx512f,avx512dq,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn closest_others<S: CustomShapes>(
    accel: &Accel,
    index: usize,
    rays: &Rays<'_>,
    lanes: __mmask16,
    shapes: &S,
    instance: u32,
    found: &mut Found,
) {
    let mut alone = lanes;
    if let Other::Instance(inner) = &accel.others[index]
        && lanes.count_ones() > FEW
        && accel.children[inner.tree as usize].ordinary
    {
        let child = &accel.children[inner.tree as usize];
        alone = rays.within(inner, lanes, |inside| closest_in(child, inside, shapes, index as u32, found));
    }
    for i in places(alone) {
        found.update(i, |nearest| closest_other::<Avx2, S>(accel, index, &rays.ray(i), shapes, instance, nearest));
    }
}
