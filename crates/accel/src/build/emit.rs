//! Writing the wide tree: the decisions of [`crate::build::collapse`] carried out, nodes in depth-first order, then the leaves filled.

use crate::build::binary::BinaryNode;
use crate::build::collapse::decision;
use crate::build::reference::Items;
use crate::layout::{Child, Node, ROWS, Tree, WIDTH};
use rayon::prelude::*;

/// Up to eight subtrees, a fixed-size list.
#[derive(Default)]
struct Children {
    list: [u32; WIDTH],
    count: usize,
}

struct Emitter<'a> {
    binary: &'a [BinaryNode],
    /// What the binary tree's leaves hold.
    held: &'a [u32],
    triangles: u32,
    nodes: Vec<Node>,
    items: Vec<u32>,
    /// Where each leaf begins in `items`.
    leaves: Vec<u32>,
}

/// The tree of a binary tree that is not empty.
pub(crate) fn emit(binary: &[BinaryNode], held: &[u32], items: &Items) -> Tree {
    let mut emitter = Emitter {
        binary,
        held,
        triangles: items.triangles(),
        nodes: Vec::with_capacity(held.len() / 12 + 1),
        items: Vec::with_capacity(held.len()),
        leaves: Vec::with_capacity(held.len() / 4 + 1),
    };
    let root = emitter.child(0);
    emitter.leaves.push(emitter.items.len() as u32);
    emitter.nodes.shrink_to_fit();
    emitter.items.shrink_to_fit();
    let corners = corners(&emitter.items, &emitter.leaves, items);
    Tree { root: Some(root), nodes: emitter.nodes, corners, items: emitter.items }
}

impl Emitter<'_> {
    /// Writes subtree `n` as one child.
    fn child(&mut self, n: u32) -> Child {
        let node = &self.binary[n as usize];
        if let Some(places) = node.items() {
            let item = self.held[places.start];
            return if item < self.triangles { self.leaf(n) } else { Child::other((item - self.triangles) as usize) };
        }
        if decision(node.decisions, 1) == 0 {
            return self.leaf(n);
        }

        // the children, largest first: any-hit rays try them in this order
        let k = decision(node.decisions, 1);
        let mut children = Children::default();
        self.gather(n + 1, k, &mut children);
        self.gather(node.link, WIDTH - k, &mut children);
        let list = &mut children.list[..children.count];
        let area = |n: u32| self.binary[n as usize].half_area();
        list.sort_by(|&a, &b| area(b).total_cmp(&area(a)).then(a.cmp(&b)));

        let index = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        for (i, &n) in list.iter().enumerate() {
            let child = self.child(n);
            let node = &self.binary[n as usize];
            self.nodes[index].set(i, node.lo, node.hi, child);
        }
        Child::node(index)
    }

    /// The subtrees that stand for `n` where it has `slots` places.
    fn gather(&self, n: u32, slots: usize, children: &mut Children) {
        let node = &self.binary[n as usize];
        if slots == 1 || node.items().is_some() {
            children.list[children.count] = n;
            children.count += 1;
            return;
        }
        match decision(node.decisions, slots) {
            0 => self.gather(n, slots - 1, children),
            k => {
                self.gather(n + 1, k, children);
                self.gather(node.link, slots - k, children);
            }
        }
    }

    /// Writes subtree `n` as a leaf, each triangle once, by number: of equal hits the first lane is the lowest number.
    fn leaf(&mut self, n: u32) -> Child {
        let first = self.items.len();
        self.collect(n);
        self.items[first..].sort_unstable();
        let mut last = first;
        for i in first + 1..self.items.len() {
            if self.items[i] != self.items[last] {
                last += 1;
                self.items[last] = self.items[i];
            }
        }
        self.items.truncate(last + 1);
        self.leaves.push(first as u32);
        Child::triangles(first, last + 1 - first)
    }

    fn collect(&mut self, n: u32) {
        let node = self.binary[n as usize];
        match node.items() {
            Some(places) => self.items.extend_from_slice(&self.held[places]),
            None => {
                self.collect(n + 1);
                self.collect(node.link);
            }
        }
    }
}

/// The corners of all leaves, rows of each leaf's own length.
fn corners(items: &[u32], leaves: &[u32], source: &Items) -> Vec<f32> {
    const LEAVES: usize = 1 << 10;
    // so far ahead memory is asked for
    const FAR: usize = 48;
    const NEAR: usize = 24;
    let mut corners = vec![0.0_f32; items.len() * ROWS + if items.is_empty() { 0 } else { WIDTH }];
    // cut the array at leaf boundaries, a task for each piece
    let mut tasks = Vec::with_capacity(leaves.len() / LEAVES + 1);
    let mut rest = &mut corners[..];
    for begin in (0..leaves.len() - 1).step_by(LEAVES) {
        let bounds = &leaves[begin..leaves.len().min(begin + LEAVES + 1)];
        let floats = (bounds[bounds.len() - 1] - bounds[0]) as usize * ROWS;
        let (piece, tail) = std::mem::take(&mut rest).split_at_mut(floats);
        rest = tail;
        tasks.push((bounds, piece));
    }
    tasks.into_par_iter().for_each(|(bounds, mut piece)| {
        for pair in bounds.windows(2) {
            let run = &items[pair[0] as usize..pair[1] as usize];
            let (rows, tail) = std::mem::take(&mut piece).split_at_mut(run.len() * ROWS);
            piece = tail;
            let ahead = |n: usize| (pair[0] as usize + n..pair[1] as usize + n).filter_map(|i| items.get(i));
            ahead(FAR).for_each(|&item| source.fetch_indices(item));
            ahead(NEAR).for_each(|&item| source.fetch_corners(item));
            for (lane, &item) in run.iter().enumerate() {
                // references were only made of triangles that have corners
                for (v, p) in source.corners(item).into_iter().flatten().enumerate() {
                    for axis in 0..3 {
                        rows[(3 * v + axis) * run.len() + lane] = p[axis];
                    }
                }
            }
        }
    });
    corners
}
