//! Building: triangles, custom shapes and instances in, a tree out.
//!
//! ```text
//! references → binary tree (object and spatial splits) → the cheapest 8-wide tree → nodes and leaves in memory
//!  reference      binary, split, sweep, spatial           collapse                    emit
//! ```

pub(crate) mod binary;
mod collapse;
mod emit;
pub(crate) mod reference;
mod spatial;
mod split;
mod sweep;
#[cfg(test)]
mod tests;

use crate::instance::{self, Instance, Other};
use crate::layout::{Child, Tree};
use crate::traverse::{MOST_NODES_OF_PACKETS, Path};
use crate::{Accel, Stats};
use binary::{BinaryNode, Context};
use collapse::Prices;
use etendue_numerics::{Bounds3, Transform};
use glam::Vec3;
use rayon::prelude::*;
use reference::{Items, Owners, Reference, triangle_reference};
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::time::Instant;

/// Triangles that share one number. The tree copies the corners; nothing is borrowed after the build.
#[derive(Clone, Copy, Debug)]
pub struct TriangleMesh<'a> {
    /// The corners.
    pub positions: &'a [Vec3],
    /// Three places in `positions` a triangle. A triangle that points nowhere, has no area or a corner that is not finite is never hit.
    pub indices: &'a [[u32; 3]],
    /// What hits tell as their geometry.
    pub geometry: u32,
}

/// Up to this many triangles are put into a second tree, which many rays go through in packets.
const SMALL: usize = 128;

/// How to build.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildOptions {
    /// How many duplicates spatial splits may make, as a part of the references; 0 switches them off.
    pub duplicates: f32,
    /// How rays are cast, by default the fastest way this machine has. One that it lacks is replaced by that.
    pub path: Option<Path>,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { duplicates: 0.25, path: None }
    }
}

/// Why there is no tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuildError {
    /// More triangles (or duplicates) than a tree's numbers have room for.
    TooManyReferences {
        /// How many there were.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
    /// An instance of a tree that holds instances itself: one level is all there is.
    NestedInstance,
    /// An instance of a tree that was not added.
    UnknownTree,
}

impl std::fmt::Display for BuildError {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::TooManyReferences { count, limit } => write!(f, "{count} triangles in one tree; the limit is {limit}"),
            Self::NestedInstance => write!(f, "an instance of something that contains instances"),
            Self::UnknownTree => write!(f, "an instance of a tree that was never added"),
        }
    }
}

impl std::error::Error for BuildError {}

/// A tree that was added for instancing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TreeId(u32);

/// Gathers what a tree shall hold.
#[derive(Default)]
pub struct Builder<'a> {
    meshes: Vec<TriangleMesh<'a>>,
    others: Vec<Other>,
    bounds: Vec<Bounds3>,
    children: Vec<Arc<Accel>>,
    error: Option<BuildError>,
}

/// A tree of `references[..count]`, with room for duplicates in the rest, its bounds and its cost.
fn tree(
    mut references: Vec<Reference>,
    count: usize,
    items: &Items,
    prices: Prices,
    progress: &(dyn Fn(f32) + Sync),
) -> (Tree, Bounds3, f32) {
    if count == 0 {
        return (Tree::EMPTY, Bounds3::EMPTY, 0.0);
    }
    // zeros straight from the system: what stays unused is never touched
    let mut nodes: Vec<BinaryNode> = bytemuck::zeroed_vec(2 * references.len() - 1);
    let mut held: Vec<u32> = bytemuck::zeroed_vec(references.len());
    let extent = split::Extent::of(&references[..count]);
    let context = Context {
        items,
        root_area: extent.bounds.half_area(),
        spatial: references.len() > count,
        prices,
        done: AtomicUsize::new(0),
        total: count,
        progress,
    };
    let costs = binary::build(&mut references, count, &mut nodes, &mut held, extent, 0, &context);
    drop(references);
    let bounds = instance::bounds((nodes[0].lo, nodes[0].hi));
    let cost = if nodes[0].half_area() > 0.0 { costs.cost[0] / nodes[0].half_area() } else { 0.0 };
    (emit::emit(&nodes, &held, items), bounds, cost)
}

impl<'a> Builder<'a> {
    /// An empty one.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the triangles of a mesh. All meshes of a builder share one tree.
    pub fn add_mesh(&mut self, mesh: TriangleMesh<'a>) -> &mut Self {
        self.meshes.push(mesh);
        self
    }

    /// Adds a shape that the caller intersects ([`crate::CustomShapes`]), within `bounds`. A box that is empty or not finite is never met.
    pub fn add_custom(&mut self, geometry: u32, bounds: Bounds3) -> &mut Self {
        self.others.push(Other::Custom { geometry });
        self.bounds.push(bounds);
        self
    }

    /// Adds a tree that instances may show; by itself it is not seen.
    pub fn add_tree(&mut self, tree: Arc<Accel>) -> TreeId {
        self.children.push(tree);
        TreeId(self.children.len() as u32 - 1)
    }

    /// Shows a tree through an affine map from its own space to the outer one. Hits tell `id` as their instance.
    pub fn add_instance(&mut self, tree: TreeId, to_outer: &Transform, id: u32) -> &mut Self {
        let Some(child) = self.children.get(tree.0 as usize) else {
            self.error.get_or_insert(BuildError::UnknownTree);
            return self;
        };
        if child.others.iter().any(|o| matches!(o, Other::Instance(_))) {
            self.error.get_or_insert(BuildError::NestedInstance);
        }
        self.bounds.push(instance::moved_bounds(&child.outline, to_outer));
        self.others.push(Other::Instance(Instance::new(tree.0, id, to_outer)));
        self
    }

    /// Builds the tree in the current thread pool. The result does not depend on the number of threads.
    pub fn build(&self, options: &BuildOptions) -> Result<Accel, BuildError> {
        self.build_with_progress(options, &|_| {})
    }

    /// Builds the tree; `progress` hears now and then how much is done, from 0 to 1, from any thread.
    pub fn build_with_progress(&self, options: &BuildOptions, progress: &(dyn Fn(f32) + Sync)) -> Result<Accel, BuildError> {
        let start = Instant::now();
        if let Some(error) = self.error {
            return Err(error);
        }
        let total: usize = self.meshes.iter().map(|m| m.indices.len()).sum::<usize>() + self.others.len();
        let limit = Child::MAX_REFERENCES;
        if total > limit {
            return Err(BuildError::TooManyReferences { count: total, limit });
        }
        let owners = Owners::new(self.meshes.iter().map(|m| m.indices.len() as u32));
        let items = Items { meshes: &self.meshes, owners };

        let spare = (total as f64 * f64::from(options.duplicates.clamp(0.0, 4.0))) as usize;
        let spare = if items.triangles() == 0 { 0 } else { spare.min(limit - total) };
        let (references, count) = self.references(&items, spare);
        let triangles = count - self.others.len().min(count);
        let path = options.path.filter(|p| p.is_available()).unwrap_or_else(Path::best);
        let small = (path.has_packets() && self.others.is_empty() && (1..=SMALL).contains(&count))
            .then(|| tree(references[..count].to_vec(), count, &items, Prices::PACKET, &|_| {}).0)
            .filter(|tree| tree.nodes.len() <= MOST_NODES_OF_PACKETS);
        let (tree, bounds, cost) = tree(references, count, &items, Prices::SINGLE, progress);
        progress(1.0);

        let stats = Stats {
            triangles,
            others: self.others.len(),
            nodes: tree.nodes.len(),
            leaves: tree.leaves(),
            references: tree.items.len(),
            bytes: tree.bytes()
                + small.as_ref().map_or(0, Tree::bytes)
                + items.owners.bytes()
                + self.others.len() * size_of::<Other>(),
            sah_cost: cost,
            build_seconds: start.elapsed().as_secs_f64(),
        };
        Ok(Accel {
            ordinary: instance::extent(&bounds) <= crate::traverse::ORDINARY,
            outline: tree.outline(bounds),
            tree,
            small,
            owners: items.owners,
            geometries: self.meshes.iter().map(|m| m.geometry).collect(),
            others: self.others.clone(),
            children: self.children.clone(),
            bounds,
            stats,
            path,
        })
    }

    /// References for everything that can be hit, and how many they are; behind them room for `spare` more.
    fn references(&self, items: &Items, spare: usize) -> (Vec<Reference>, usize) {
        const CHUNK: usize = 1 << 14;
        let triangles = items.triangles() as usize;
        let mut references: Vec<Reference> = bytemuck::zeroed_vec(triangles + self.others.len() + spare);
        let mut sizes: Vec<usize> = references[..triangles]
            .par_chunks_mut(CHUNK)
            .enumerate()
            .map(|(c, places)| {
                let mut count = 0;
                for item in (c * CHUNK) as u32..(c * CHUNK + places.len()) as u32 {
                    if let Some(reference) = items.corners(item).and_then(|corners| triangle_reference(corners, item)) {
                        places[count] = reference;
                        count += 1;
                    }
                }
                count
            })
            .collect();
        // what is missing in the first chunks is taken from the last
        let (mut c, mut last) = (0, sizes.len().saturating_sub(1));
        while c < last {
            let taken = (CHUNK - sizes[c]).min(sizes[last]);
            sizes[last] -= taken;
            let from = last * CHUNK + sizes[last];
            references.copy_within(from..from + taken, c * CHUNK + sizes[c]);
            sizes[c] += taken;
            if sizes[c] == CHUNK { c += 1 } else { last -= 1 }
        }
        let mut count = c * CHUNK + sizes.get(c).copied().unwrap_or(0);
        for (i, b) in self.bounds.iter().enumerate().filter(|(_, b)| instance::is_finite(b)) {
            references[count] = Reference::new(b.min, b.max, (triangles + i) as u32);
            count += 1;
        }
        // room for `spare`, and no more: the places of what is never hit are not for duplicates
        references.truncate(count + spare);
        (references, count)
    }
}
