//! Whether anything stands in the way of rays that stay together.

use super::super::avx2::Avx2;
use super::super::stack::Stack;
use super::super::{Kernel, STACK, Start, fetch, occluded_other};
use super::{FEW, Hull, Rays, Waiting, places};
use crate::instance::Other;
use crate::layout::{Child, WIDTH};
use crate::{Accel, CustomShapes};
use etendue_numerics::Ray;
use std::arch::x86_64::*;

/// Which of up to sixteen rays of one kind hit anything, and which must be cast singly to know.
#[target_feature(enable = "avx512f,avx512dq,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(in super::super) fn occluded<S: CustomShapes>(
    accel: &Accel,
    kind: usize,
    rays: &[Ray],
    these: &[u32],
    shapes: &S,
    last: &mut Option<Child>,
) -> (u16, u16) {
    let (rays, mut again) = (Rays::new(kind, rays, these), 0);
    let open = occluded_in(accel, &rays, shapes, last, &mut again);
    (rays.packet.lanes & !open, again & open)
}

/// Which of the rays hit nothing. `last` is the leaf of triangles that stopped some before: it is looked at first.
#[target_feature(enable = "avx512f,avx512dq,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn occluded_in<S: CustomShapes>(
    accel: &Accel,
    rays: &Rays<'_>,
    shapes: &S,
    last: &mut Option<Child>,
    again: &mut __mmask16,
) -> __mmask16 {
    let packet = &rays.packet;
    let (tree, mut open) = (&accel.tree, packet.lanes);
    let Some(mut current) = tree.root else { return open };
    let singly = |child: Child, lanes: __mmask16| {
        let stops = |i: &usize| Avx2::occluded(Start { accel, child }, &rays.ray(*i), shapes, &mut None);
        places(lanes).filter(stops).fold(0, |stopped, i| stopped | 1 << i)
    };
    if let Some(leaf) = *last {
        open = packet.past(tree, leaf, open, again);
        if open == 0 {
            return 0;
        }
    }
    let Some(hull) = Hull::of(packet, open) else { return open & !singly(current, open) };
    let (mut lanes, farthest) = (open, _mm512_mask_reduce_max_ps(open, packet.t_max));
    let mut stack = Stack::<Waiting, STACK>::new();
    loop {
        if current.is_node() && lanes.count_ones() > FEW {
            // Children lie in order of size: the largest is the likeliest to stop rays.
            let node = &tree.nodes[current.0 as usize];
            let mut enter = [0.0; WIDTH];
            let mut met = hull.meet(packet.rows, node, farthest, &mut enter);
            while met != 0 {
                let slot = (31 - met.leading_zeros()) as usize & 7;
                met ^= 1 << slot;
                fetch(tree, node.children[slot]);
                stack.push(Waiting { node: current.0, enter: 0.0, lanes, slot: slot as u16 });
            }
        } else if current.is_node() {
            open &= !singly(current, lanes);
        } else if current.is_triangles() {
            let stopped = lanes & !packet.past(tree, current, lanes, again);
            if stopped != 0 {
                (*last, open) = (Some(current), open & !stopped);
            }
        } else {
            open &= !occluded_others(accel, current.index(), rays, lanes, shapes, again);
        }
        loop {
            let (Some(next), true) = (stack.pop(), open != 0) else { return open };
            let (node, slot) = (&tree.nodes[next.node as usize], usize::from(next.slot & 7));
            let (_, met) = packet.meet(node, slot, packet.t_max, next.lanes & open);
            if met != 0 {
                (current, lanes) = (node.children[slot], met);
                break;
            }
        }
    }
}

/// Which of `lanes` another thing stops.
#[target_feature(enable = "avx512f,avx512dq,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn occluded_others<S: CustomShapes>(
    accel: &Accel,
    index: usize,
    rays: &Rays<'_>,
    lanes: __mmask16,
    shapes: &S,
    again: &mut __mmask16,
) -> __mmask16 {
    let (mut alone, mut stopped) = (lanes, 0);
    if let Other::Instance(inner) = &accel.others[index]
        && lanes.count_ones() > FEW
        && accel.children[inner.tree as usize].ordinary
    {
        let child = &accel.children[inner.tree as usize];
        alone = rays.within(inner, lanes, |inside| {
            stopped |= inside.packet.lanes & !occluded_in(child, inside, shapes, &mut None, again);
        });
    }
    let stops = |i: &usize| occluded_other::<Avx2, S>(accel, index, &rays.ray(*i), shapes);
    places(alone).filter(stops).fold(stopped, |stopped, i| stopped | 1 << i)
}
