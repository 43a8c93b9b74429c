//! The binary tree: cut in two again and again down to a few references, each time by the cheaper of an object and a spatial split.
//!
//! On the way back up each subtree learns what it would cost as part of an 8-wide node ([`crate::build::collapse`]). A large subtree
//! works on slices of its own (references with their spare places, nodes, items), so nothing is shared between threads and the tree
//! is the same at any number of them. A small one is grown by one thread, back side first: what the back side is done with is room for
//! the duplicates of the front, so nothing has to move, and its nodes stand next to each other.

use crate::build::collapse::{self, Costs, Prices};
use crate::build::reference::{Box4, Items, Reference};
use crate::build::spatial::spatial_split;
use crate::build::split::{Extent, object_split};
use crate::build::sweep::{SWEEP, sweep_split};
use bytemuck::Zeroable;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// No path from the root is longer, whatever the scene: the traversal's stack counts on it.
pub(crate) const MAX_DEPTH: usize = 64;
/// Where depth + log2(references) reaches this, halving by count takes over; the last eight references may take seven more steps.
const HALVING_DEPTH: u32 = 56;
/// Subtrees of more references than this have slices of their own, and may go to another thread.
const FORK: usize = 1 << 12;
/// Spatial splits are tried where siblings share more than this part of the root's surface [Stich et al. 2009, §4.5: α].
const OVERLAP: f32 = 1e-5;
/// … and where the shared part of the node's own surface is above this over √n: of n triangles of a surface about √n straddle a plane, and
/// their duplicates must be won back.
const STRADDLE: f32 = 6.0;
/// Below this many references a cut wins nothing that is worth looking for.
const FEWEST: usize = 32;

/// A node of the binary tree, 32 bytes. The back child follows its parent.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C)]
pub(crate) struct BinaryNode {
    pub lo: [f32; 3],
    pub hi: [f32; 3],
    /// An inner node's front child, or [`LEAF`] with the place of the first item.
    pub link: u32,
    /// How the subtree is best cut into wide nodes; of a leaf, how many items it has.
    pub decisions: u32,
}

pub(crate) const LEAF: u32 = 1 << 31;

impl BinaryNode {
    /// The items' places, where the node is a leaf.
    #[inline]
    pub fn items(&self) -> Option<Range<usize>> {
        let first = (self.link & !LEAF) as usize;
        (self.link & LEAF != 0).then(|| first..first + self.decisions as usize)
    }

    fn around(extent: &Extent, link: u32) -> Self {
        let Box4 { lo, hi } = extent.bounds;
        Self { lo: lo.truncate().into(), hi: hi.truncate().into(), link, decisions: 0 }
    }

    pub fn half_area(&self) -> f32 {
        let d = [0, 1, 2].map(|a| self.hi[a] - self.lo[a]);
        d[0] * (d[1] + d[2]) + d[1] * d[2]
    }
}

/// What the whole build shares.
pub(crate) struct Context<'a> {
    pub items: &'a Items<'a>,
    pub root_area: f32,
    pub spatial: bool,
    pub prices: Prices,
    pub done: AtomicUsize,
    pub total: usize,
    pub progress: &'a (dyn Fn(f32) + Sync),
}

/// A subtree's slices and where they begin in the whole.
struct Part<'a> {
    /// `count` references, then spare places for duplicates.
    references: &'a mut [Reference],
    count: usize,
    /// At least 2 · places - 1.
    nodes: &'a mut [BinaryNode],
    first_node: usize,
    /// As many as places.
    items: &'a mut [u32],
    first_item: usize,
}

/// Builds the tree of `references[..count]` into `nodes`, root first, and what its leaves hold into `items`; the rest of `references` is room
/// for duplicates. `depth` is how far down the root itself stands, 0 but in tests.
pub(crate) fn build(
    references: &mut [Reference],
    count: usize,
    nodes: &mut [BinaryNode],
    items: &mut [u32],
    extent: Extent,
    depth: u32,
    context: &Context,
) -> Costs {
    subtree(Part { references, count, nodes, first_node: 0, items, first_item: 0 }, extent, depth, context)
}

fn subtree(part: Part, extent: Extent, depth: u32, context: &Context) -> Costs {
    let Part { references, count, nodes, first_node, items, first_item } = part;
    let room = references.len();
    if count <= FORK {
        return Small { context, nodes, used: 0, first_node, items, filled: 0, first_item }
            .grow(references, count, room, &extent, depth);
    }
    let parted = part_in_two(references, count, room, &extent, depth, context);
    let (total, room) = (parted.fronts + parted.backs, parted.room);
    references.copy_within(parted.fronts..total, room);
    let (front_references, back_references) = references.split_at_mut(room);
    let (front_items, back_items) = items.split_at_mut(room);
    let (node, rest) = nodes.split_at_mut(1);
    let back_room = back_references.len();
    let (back_nodes, front_nodes) = rest.split_at_mut(2 * back_room - 1);
    let link = first_node + 2 * back_room;
    let back = Part {
        references: back_references,
        count: parted.backs,
        nodes: back_nodes,
        first_node: first_node + 1,
        items: back_items,
        first_item: first_item + room,
    };
    let front = Part {
        references: front_references,
        count: parted.fronts,
        nodes: front_nodes,
        first_node: link,
        items: front_items,
        first_item,
    };

    let report = |part: usize| {
        if part <= FORK {
            let done = context.done.fetch_add(part, Ordering::Relaxed) + part;
            (context.progress)((done as f32 / context.total as f32).min(1.0));
        }
    };
    let side = |part: Part, extent: Extent| {
        let size = part.count;
        let costs = subtree(part, extent, depth + 1, context);
        report(size);
        costs
    };
    let (a, b) = rayon::join(|| side(back, parted.back), || side(front, parted.front));
    node[0] = BinaryNode::around(&extent, link as u32);
    let (costs, decisions) = collapse::inner(node[0].half_area(), &a, &b, context.prices);
    node[0].decisions = decisions;
    costs
}

/// A subtree that one thread grows: nodes and items are taken from the front of its slices, one after the other.
struct Small<'a, 'c> {
    context: &'a Context<'c>,
    nodes: &'a mut [BinaryNode],
    used: usize,
    first_node: usize,
    items: &'a mut [u32],
    filled: usize,
    first_item: usize,
}

impl Small<'_, '_> {
    /// Grows the subtree of `references[..count]`, which may become `room` by duplicates; what lies behind them is free.
    fn grow(&mut self, references: &mut [Reference], count: usize, room: usize, extent: &Extent, depth: u32) -> Costs {
        let Context { prices, items, .. } = *self.context;
        let n = self.used;
        self.used += 1;
        let only_triangles = || references[..count].iter().all(|r| r.item() < items.triangles());
        if count == 1 || (count <= prices.whole as usize && only_triangles()) {
            let only_triangles = only_triangles();
            let first = self.filled;
            self.filled += count;
            for (to, r) in self.items[first..self.filled].iter_mut().zip(&*references) {
                *to = r.item();
            }
            self.nodes[n] = BinaryNode::around(extent, LEAF | (self.first_item + first) as u32);
            self.nodes[n].decisions = count as u32;
            return collapse::leaf(self.nodes[n].half_area(), count as u32, only_triangles, prices);
        }
        let parted = part_in_two(references, count, room, extent, depth, self.context);
        let a = self.grow(&mut references[parted.fronts..], parted.backs, parted.back_room(), &parted.back, depth + 1);
        let mut node = BinaryNode::around(extent, (self.first_node + self.used) as u32);
        let b = self.grow(references, parted.fronts, parted.room, &parted.front, depth + 1);
        let (costs, decisions) = collapse::inner(node.half_area(), &a, &b, prices);
        node.decisions = decisions;
        self.nodes[n] = node;
        costs
    }
}

/// References in two parts, one behind the other, and how much room each may take.
struct Parted {
    fronts: usize,
    backs: usize,
    /// Of the front, its share of the spare places with it.
    room: usize,
    /// Of both.
    whole: usize,
    front: Extent,
    back: Extent,
}

impl Parted {
    fn new(fronts: usize, backs: usize, whole: usize, front: Extent, back: Extent) -> Self {
        let total = fronts + backs;
        Self { fronts, backs, room: fronts + (whole - total) * fronts / total, whole, front, back }
    }

    fn back_room(&self) -> usize {
        self.whole - self.room
    }
}

/// Parts the references in place, by the cheapest means at hand; there may be `room` of them afterwards.
fn part_in_two(references: &mut [Reference], count: usize, room: usize, extent: &Extent, depth: u32, context: &Context) -> Parted {
    if count <= SWEEP {
        let (fronts, front, back) = sweep_split(&mut references[..count]);
        return Parted::new(fronts, count - fronts, room, front, back);
    }
    let halve = |references: &[Reference], count: usize| {
        let fronts = count / 2;
        Parted::new(fronts, count - fronts, room, Extent::of(&references[..fronts]), Extent::of(&references[fronts..count]))
    };
    if depth + (usize::BITS - count.leading_zeros()) >= HALVING_DEPTH {
        return halve(references, count);
    }
    let object = object_split(&references[..count], extent);

    // siblings that overlap: would a cut be cheaper?
    if context.spatial
        && room > count
        && count >= FEWEST
        && object.as_ref().is_none_or(|o| {
            o.overlap > OVERLAP * context.root_area && o.overlap > STRADDLE / (count as f32).sqrt() * extent.bounds.half_area()
        })
        && let Some(cut) =
            spatial_split(&references[..count], context.items, &extent.bounds, object.as_ref().map_or(f32::INFINITY, |o| o.cost))
        && cut.references() <= room
    {
        let (fronts, front, backs, back) = cut.part(&mut references[..room], count, context.items);
        // where every reference went whole to one side they are halved
        return if fronts == 0 || backs == 0 {
            halve(references, fronts + backs)
        } else {
            Parted::new(fronts, backs, room, front, back)
        };
    }

    let Some(split) = object else { return halve(references, count) };
    let (fronts, front, back) = split.part(&mut references[..count]);
    if fronts == 0 || fronts == count {
        return halve(references, count);
    }
    Parted::new(fronts, count - fronts, room, front, back)
}
