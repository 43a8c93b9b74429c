//! The binary tree: cut in two again and again down to a few references, each time by the cheaper of an object and a spatial split.
//!
//! On the way back up each subtree learns what it would cost as part of an 8-wide node ([`crate::build::collapse`]). Every subtree
//! works on slices of its own (references with their spare places, nodes), so nothing is shared between threads and the tree
//! is the same at any number of them.

use crate::build::collapse::{self, Costs, Prices};
use crate::build::reference::{Items, Reference};
use crate::build::spatial::spatial_split;
use crate::build::split::{Extent, SWEEP, object_split, partition, sweep_split};
use bytemuck::Zeroable;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// No path from the root is longer, whatever the scene: the traversal's stack counts on it.
pub(crate) const MAX_DEPTH: usize = 64;
/// Where depth + log2(references) reaches this, halving by count takes over; the last eight references may take seven more steps.
const HALVING_DEPTH: u32 = 56;
/// Subtrees of more references than this may go to another thread.
const FORK: usize = 1 << 12;
/// Spatial splits are tried where siblings share more than this part of the root's surface [Stich et al. 2009, §4.5: α].
const OVERLAP: f32 = 1e-5;
/// … and where the shared part of the node's own surface is above this over √n: of n triangles of a surface about √n straddle a plane, and
/// their duplicates must be won back.
const STRADDLE: f32 = 4.0;
/// Below this many references a cut wins nothing that is worth looking for.
const FEWEST: usize = 32;

/// A node of the binary tree, 32 bytes. The left child follows its parent.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C)]
pub(crate) struct BinaryNode {
    pub lo: [f32; 3],
    pub hi: [f32; 3],
    /// An inner node's right child, or [`LEAF`] with the place of the first reference.
    pub link: u32,
    /// How the subtree is best cut into wide nodes; of a leaf, how many references it has.
    pub decisions: u32,
}

pub(crate) const LEAF: u32 = 1 << 31;

impl BinaryNode {
    /// The references' places, where the node is a leaf.
    #[inline]
    pub fn references(&self) -> Option<Range<usize>> {
        let first = (self.link & !LEAF) as usize;
        (self.link & LEAF != 0).then(|| first..first + self.decisions as usize)
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
    first_reference: usize,
    first_node: usize,
}

/// Builds the tree of `references[..count]` into `nodes`, root first; the rest of `references` is room for duplicates.
/// `depth` is how far down the root itself stands, 0 but in tests.
pub(crate) fn build(
    references: &mut [Reference],
    count: usize,
    nodes: &mut [BinaryNode],
    extent: Extent,
    depth: u32,
    context: &Context,
) -> Costs {
    subtree(Part { references, count, nodes, first_reference: 0, first_node: 0 }, extent, depth, context)
}

fn subtree(part: Part, extent: Extent, depth: u32, context: &Context) -> Costs {
    let Part { references, count, nodes, first_reference, first_node } = part;
    let bounds = extent.bounds;
    nodes[0] = BinaryNode { lo: bounds.lo.truncate().into(), hi: bounds.hi.truncate().into(), link: 0, decisions: 0 };
    let only_triangles = || references[..count].iter().all(|r| r.item() < context.items.triangles());
    if count == 1 || (count <= context.prices.whole as usize && only_triangles()) {
        (nodes[0].link, nodes[0].decisions) = (LEAF | first_reference as u32, count as u32);
        return collapse::leaf(nodes[0].half_area(), count as u32, only_triangles(), context.prices);
    }

    let Parted { lefts, room, rights, l, r } = part_in_two(references, count, &extent, depth, context);
    let (left_references, right_references) = references.split_at_mut(room);
    let (node, rest) = nodes.split_at_mut(1);
    let (left_nodes, right_nodes) = rest.split_at_mut(2 * room - 1);
    node[0].link = (first_node + 2 * room) as u32;
    let left = Part { references: left_references, count: lefts, nodes: left_nodes, first_reference, first_node: first_node + 1 };
    let right = Part {
        references: right_references,
        count: rights,
        nodes: right_nodes,
        first_reference: first_reference + room,
        first_node: first_node + 2 * room,
    };

    let (a, b) = if count > FORK {
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
        rayon::join(|| side(left, l), || side(right, r))
    } else {
        (subtree(left, l, depth + 1, context), subtree(right, r, depth + 1, context))
    };
    let (costs, decisions) = collapse::inner(node[0].half_area(), &a, &b, context.prices);
    node[0].decisions = decisions;
    costs
}

/// References in two parts: `lefts` at the front of `room` places, then `rights` at the front of what remains.
struct Parted {
    lefts: usize,
    room: usize,
    rights: usize,
    l: Extent,
    r: Extent,
}

/// Parts the references in place, by the cheapest means at hand.
fn part_in_two(references: &mut [Reference], count: usize, extent: &Extent, depth: u32, context: &Context) -> Parted {
    if count <= SWEEP {
        let lefts = sweep_split(&mut references[..count]);
        return spread(references, count, lefts, None);
    }
    if depth + (usize::BITS - count.leading_zeros()) >= HALVING_DEPTH {
        return spread(references, count, count / 2, None);
    }
    let object = object_split(&references[..count], extent);

    // siblings that overlap: would a cut be cheaper?
    if context.spatial
        && references.len() > count
        && count >= FEWEST
        && object.as_ref().is_none_or(|o| {
            o.overlap > OVERLAP * context.root_area && o.overlap > STRADDLE / (count as f32).sqrt() * extent.bounds.half_area()
        })
        && let Some(cut) = spatial_split(&references[..count], context.items, &extent.bounds)
        && object.as_ref().is_none_or(|o| cut.cost < o.cost)
        && cut.references() <= references.len()
    {
        let (lefts, l, rights, r) = cut.part(&mut references[..count], context.items);
        let total = lefts + rights.len();
        if lefts == 0 || rights.is_empty() {
            // every reference went whole to one side
            references[lefts..total].copy_from_slice(&rights);
            return spread(references, total, total / 2, None);
        }
        let room = lefts + (references.len() - total) * lefts / total;
        references[room..room + rights.len()].copy_from_slice(&rights);
        return Parted { lefts, room, rights: rights.len(), l, r };
    }

    let Some(split) = object else { return spread(references, count, count / 2, None) };
    let (lefts, l, r) = partition(&mut references[..count], |x| split.binning.bin(x, split.axis) < split.bin);
    if lefts == 0 || lefts == count {
        return spread(references, count, count / 2, None);
    }
    spread(references, count, lefts, Some((l, r)))
}

/// Gives each side its share of the spare places, and moves the right side there.
fn spread(references: &mut [Reference], count: usize, lefts: usize, extents: Option<(Extent, Extent)>) -> Parted {
    let (l, r) = extents.unwrap_or_else(|| (Extent::of(&references[..lefts]), Extent::of(&references[lefts..count])));
    let room = lefts + (references.len() - count) * lefts / count;
    references.copy_within(lefts..count, room);
    Parted { lefts, room, rights: count - lefts, l, r }
}
