//! What a finished tree looks like in memory.
//!
//! A node holds the boxes of eight children as six rows of eight floats, so that one ray meets eight boxes in a few vector
//! instructions. A leaf holds up to eight triangles as nine rows (x, y, z of the corners p0, p1, p2) of exactly as many floats as
//! there are triangles: nothing is padded, 36 bytes a triangle. Which triangle is which stands in a list beside it, needed only for hits.

use crate::instance;
use etendue_numerics::Bounds3;

/// Children of a node, and the most triangles of a leaf.
pub(crate) const WIDTH: usize = 8;

/// Eight children: 224 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Node {
    /// Rows lo x, hi x, lo y, hi y, lo z, hi z. A place without a child has lo = +∞, hi = -∞, which no ray meets.
    pub rows: [[f32; WIDTH]; 6],
    pub children: [Child; WIDTH],
}

impl Node {
    pub const EMPTY: Self = Self {
        rows: [
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
        ],
        children: [Child(0); WIDTH],
    };

    pub fn set(&mut self, i: usize, lo: [f32; 3], hi: [f32; 3], child: Child) {
        for axis in 0..3 {
            self.rows[2 * axis][i] = lo[axis];
            self.rows[2 * axis + 1][i] = hi[axis];
        }
        self.children[i] = child;
    }

    /// The box of child `i`; `None` for an empty place.
    pub fn bounds(&self, i: usize) -> Option<([f32; 3], [f32; 3])> {
        let row = |r: usize| self.rows[r][i];
        (row(0) <= row(1)).then(|| ([row(0), row(2), row(4)], [row(1), row(3), row(5)]))
    }
}

/// Where a child is: a node, some triangles, or another thing, in 32 bits.
///
/// ```text
/// 0 nnnnnnnnnnnnnnnnnnnnnnnnnnnnnnn   node n
/// 10 ccc rrrrrrrrrrrrrrrrrrrrrrrrrrr  c + 1 triangles from reference r on
/// 11 iiiiiiiiiiiiiiiiiiiiiiiiiiiiii   other thing i: custom shape or instance
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub(crate) struct Child(pub u32);

impl Child {
    /// The most references and other things that the numbers have room for.
    pub const MAX_REFERENCES: usize = 1 << 27;
    const LEAF: u32 = 1 << 31;
    const OTHER: u32 = 1 << 30;

    pub fn node(n: usize) -> Self {
        Self(n as u32)
    }

    pub fn triangles(first: usize, count: usize) -> Self {
        Self(Self::LEAF | (count as u32 - 1) << 27 | first as u32)
    }

    pub fn other(i: usize) -> Self {
        Self(Self::LEAF | Self::OTHER | i as u32)
    }

    #[inline(always)]
    pub fn is_node(self) -> bool {
        self.0 & Self::LEAF == 0
    }

    /// For a leaf: whether it holds triangles.
    #[inline(always)]
    pub fn is_triangles(self) -> bool {
        self.0 & Self::OTHER == 0
    }

    /// First reference and number of a leaf of triangles.
    #[inline(always)]
    pub fn run(self) -> (usize, usize) {
        ((self.0 & (Self::MAX_REFERENCES as u32 - 1)) as usize, (self.0 >> 27 & 7) as usize + 1)
    }

    /// The number of another thing.
    #[inline(always)]
    pub fn index(self) -> usize {
        (self.0 & (Self::OTHER - 1)) as usize
    }
}

/// The arrays of one tree.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tree {
    /// Where rays begin; `None` for a tree of nothing.
    pub root: Option<Child>,
    pub nodes: Vec<Node>,
    /// Nine rows a leaf, leaf after leaf, then [`WIDTH`] floats more: vector loads may look past the last row.
    pub corners: Vec<f32>,
    /// Flat triangle numbers by reference, ascending within a leaf.
    pub items: Vec<u32>,
}

/// Floats of a triangle in [`Tree::corners`].
pub(crate) const ROWS: usize = 9;

impl Tree {
    pub const EMPTY: Self = Self { root: None, nodes: Vec::new(), corners: Vec::new(), items: Vec::new() };

    /// The boxes of the root's children and of theirs: a tighter hull than the one box around all.
    pub fn outline(&self, bounds: Bounds3) -> Vec<Bounds3> {
        let Some(root) = self.root.filter(|r| r.is_node()) else { return vec![bounds] };
        let node = |child: Child| &self.nodes[child.0 as usize];
        let boxes = |n: &Node| (0..WIDTH).filter_map(|i| Some((n.bounds(i)?, n.children[i]))).collect::<Vec<_>>();
        let grandchildren = boxes(node(root))
            .into_iter()
            .flat_map(|(b, child)| if child.is_node() { boxes(node(child)) } else { vec![(b, child)] });
        grandchildren.map(|(b, _)| instance::bounds(b)).collect()
    }

    /// How many leaves of triangles there are.
    pub fn leaves(&self) -> usize {
        let is_leaf = |c: &Child| !c.is_node() && c.is_triangles();
        let below = |n: &Node| (0..WIDTH).filter(|&i| n.bounds(i).is_some() && is_leaf(&n.children[i])).count();
        self.root.iter().filter(|r| is_leaf(r)).count() + self.nodes.iter().map(below).sum::<usize>()
    }

    /// The size of the arrays.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.corners[..]) + size_of_val(&self.items[..])
    }
}
