//! What the finished tree must be like, whatever went in.

use super::*;
use crate::layout::{Node, ROWS, WIDTH};
use etendue_numerics::wide::Width;
use reference::Plane;
use std::fmt::Write;

/// Long thin triangles and small ones, 2³¹-periodic numbers.
fn mesh(n: u32, seed: u64) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 24) as f32
    };
    let mut positions = Vec::new();
    for _ in 0..n {
        let (center, size) = (Vec3::new(next(), next(), next()), 0.01 + next().powi(6));
        positions.extend((0..3).map(|_| center + size * (Vec3::new(next(), next(), next()) - 0.5)));
    }
    (positions, (0..n).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect())
}

fn built(positions: &[Vec3], indices: &[[u32; 3]], threads: usize, duplicates: f32) -> Accel {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    let mut builder = Builder::new();
    builder.add_mesh(TriangleMesh { positions, indices, geometry: 0 });
    pool.install(|| builder.build(&BuildOptions { duplicates, ..BuildOptions::default() })).expect("builds")
}

/// The same tree, bit for bit, at one thread and at four, above the sizes at which work is shared.
#[test]
fn tree_does_not_depend_on_threads() {
    let (positions, indices) = mesh(150_000, 1);
    for duplicates in [0.0, 0.3] {
        let (one, four) = (built(&positions, &indices, 1, duplicates), built(&positions, &indices, 4, duplicates));
        assert!(one.tree == four.tree);
    }
}

/// Every node's box holds what lies below it; every triangle is in some leaf; together the boxes of its leaves hold its corners.
#[test]
fn boxes_hold_their_triangles() {
    for (n, duplicates) in [(1, 0.0), (2, 1.0), (7, 0.0), (8, 0.0), (9, 0.5), (100, 1.0), (5000, 0.0), (5000, 0.5)] {
        let (positions, indices) = mesh(n, 7);
        let accel = built(&positions, &indices, 2, duplicates);
        let mut seen = vec![Bounds3::EMPTY; n as usize];
        let tree = &accel.tree;
        let mut waiting = vec![(tree.root.expect("a root"), accel.bounds, 0)];
        while let Some((child, bounds, depth)) = waiting.pop() {
            assert!(depth <= binary::MAX_DEPTH);
            if child.is_node() {
                let node: &Node = &tree.nodes[child.0 as usize];
                for i in 0..WIDTH {
                    if let Some(b) = node.bounds(i) {
                        let b = instance::bounds(b);
                        assert!(bounds.contains(b.min) && bounds.contains(b.max));
                        waiting.push((node.children[i], b, depth + 1));
                    }
                }
                continue;
            }
            let (first, count) = child.run();
            for lane in 0..count {
                let item = tree.items[first + lane] as usize;
                let row = |r: usize| tree.corners[first * ROWS + r * count + lane];
                for v in 0..3 {
                    let p = Vec3::new(row(3 * v), row(3 * v + 1), row(3 * v + 2));
                    assert_eq!(p, positions[indices[item][v] as usize]);
                    if bounds.contains(p) {
                        seen[item] = seen[item].including(p);
                    }
                }
                assert!(lane == 0 || tree.items[first + lane - 1] < tree.items[first + lane]);
            }
        }
        for (item, seen) in seen.iter().enumerate() {
            let whole = Bounds3::of(indices[item].map(|i| positions[i as usize]));
            assert_eq!(*seen, whole, "triangle {item} of {n}");
        }
        assert!(accel.stats().references <= n as usize + (n as f32 * duplicates) as usize);
    }
}

/// Progress only grows to 1, and ends there.
#[test]
fn progress_ends_at_one() {
    let (positions, indices) = mesh(50_000, 3);
    let mut builder = Builder::new();
    builder.add_mesh(TriangleMesh { positions: &positions, indices: &indices, geometry: 0 });
    let heard = std::sync::Mutex::new(Vec::new());
    let progress = |x: f32| heard.lock().expect("no panic elsewhere").push(x);
    builder.build_with_progress(&BuildOptions::default(), &progress).expect("builds");
    let heard = heard.into_inner().expect("no panic elsewhere");
    assert!(heard.len() > 2 && heard.last() == Some(&1.0) && heard.iter().all(|x| (0.0..=1.0).contains(x)));
}

/// Triangles that grow by a constant factor tempt the heuristic to split off one after the other: the depth stays bounded.
#[test]
fn depth_is_bounded() {
    let size = |k: u32| 1.15_f32.powi(k as i32 - 500);
    let positions: Vec<Vec3> = (0..1000).flat_map(|k| [Vec3::X, Vec3::Y, Vec3::Z].map(|p| size(k) * (p + 1.0))).collect();
    let indices: Vec<[u32; 3]> = (0..1000).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    let owners = Owners::new(std::iter::once(1000));
    let meshes = [TriangleMesh { positions: &positions, indices: &indices, geometry: 0 }];
    let items = Items { meshes: &meshes, owners };
    let deepest = |start: u32| {
        let mut references: Vec<Reference> = (0..1000).filter_map(|i| triangle_reference(items.corners(i)?, i)).collect();
        let count = references.len();
        let mut nodes = vec![bytemuck::Zeroable::zeroed(); 2 * count];
        let mut held = vec![0; count];
        let extent = split::Extent::of(&references);
        let context = Context {
            items: &items,
            root_area: extent.bounds.half_area(),
            spatial: false,
            prices: Prices::SINGLE,
            done: AtomicUsize::new(0),
            total: count,
            progress: &|_| {},
        };
        binary::build(&mut references, count, &mut nodes, &mut held, extent, start, &context);
        let (mut waiting, mut deepest) = (vec![(0_usize, start as usize)], 0);
        while let Some((n, depth)) = waiting.pop() {
            deepest = deepest.max(depth);
            if nodes[n].items().is_none() {
                waiting.extend([(n + 1, depth + 1), (nodes[n].link as usize, depth + 1)]);
            }
        }
        deepest
    };
    // left alone it goes down far; where it starts far down, as a part of a larger tree, it has to make do with what is left
    assert!(deepest(0) > 20, "{}", deepest(0));
    assert!(deepest(46) <= binary::MAX_DEPTH, "{}", deepest(46));
}

/// Triangles that are never hit, anywhere among others, leave references of all others and of nothing else.
#[test]
fn holes_are_closed() {
    let n = 100_000;
    let (positions, mut indices) = mesh(n, 5);
    for (what, is_hole) in [
        ("none", (|_| false) as fn(u32) -> bool),
        ("all", |_| true),
        ("the last", |i| i == 99_999),
        ("the first chunk", |i| i < 20_000),
        ("the last chunks", |i| i > 40_000),
        ("every third", |i| i % 3 == 0),
        ("all but one", |i| i != 70_000),
    ] {
        for i in 0..n {
            indices[i as usize][1] = if is_hole(i) { 3 * i } else { 3 * i + 1 };
        }
        let mut builder = Builder::new();
        builder.add_mesh(TriangleMesh { positions: &positions, indices: &indices, geometry: 0 });
        let items = Items { meshes: &builder.meshes, owners: Owners::new(std::iter::once(n)) };
        let (references, count) = builder.references(&items, 10);
        let mut held = numbers(&references[..count]);
        held.sort_unstable();
        assert!(held.into_iter().eq((0..n).filter(|&i| !is_hole(i))), "{what}");
        assert_eq!(references.len(), count + 10);
    }
}

/// References of a few triangles of [`mesh`].
fn references(positions: &[Vec3], indices: &[[u32; 3]]) -> Vec<Reference> {
    let corners = |c: &[u32; 3]| c.map(|i| positions[i as usize]);
    indices.iter().enumerate().filter_map(|(i, c)| triangle_reference(corners(c), i as u32)).collect()
}

fn cost(front: &[Reference], back: &[Reference]) -> f32 {
    let side = |r: &[Reference]| split::Extent::of(r).bounds.half_area() * r.len() as f32;
    side(front) + side(back)
}

fn numbers(references: &[Reference]) -> Vec<u32> {
    references.iter().map(Reference::item).collect()
}

/// Of two to eight references the parted sides are as cheap as the cheapest that the textbook's sorting finds, and hold them all.
#[test]
fn sweep_finds_the_cheapest_order() {
    for (n, seed) in (2..=8).flat_map(|n| (0..50).map(move |seed| (n, seed))) {
        let (positions, indices) = mesh(n, 100 + seed);
        let before = references(&positions, &indices);
        let mut after = before.clone();
        let (fronts, front, back) = sweep::sweep_split(&mut after);
        let least = (0..3)
            .flat_map(|axis| {
                let mut sorted = before.clone();
                sorted.sort_by(|a, b| a.centroid2()[axis].total_cmp(&b.centroid2()[axis]));
                (1..sorted.len()).map(move |i| cost(&sorted[..i], &sorted[i..])).collect::<Vec<_>>()
            })
            .fold(f32::INFINITY, f32::min);
        assert_eq!(cost(&after[..fronts], &after[fronts..]), least, "{n}, {seed}");
        for (extent, side) in [(front, &after[..fronts]), (back, &after[fronts..])] {
            let bounds = split::Extent::of(side).bounds;
            assert!(extent.bounds.lo.truncate() == bounds.lo.truncate() && extent.bounds.hi.truncate() == bounds.hi.truncate());
        }
        let mut held = numbers(&after);
        held.sort_unstable();
        assert_eq!(held, numbers(&before));
    }
}

/// The split over bins costs what it says, and no plane at a bin's edge is cheaper; both sides' boxes are those of what went there.
#[test]
fn object_split_finds_the_cheapest_bin() {
    for (n, bins, seed) in (0..20).flat_map(|seed| [(20, 8, seed), (63, 8, seed), (64, 16, seed), (1000, 16, seed)]) {
        let (positions, indices) = mesh(n, 200 + seed);
        let before = references(&positions, &indices);
        let extent = split::Extent::of(&before);
        let found = split::object_split(&before, &extent).expect("a split");
        let mut after = before.clone();
        let (fronts, front, back) = found.part(&mut after);
        assert_eq!(found.cost, cost(&after[..fronts], &after[fronts..]));
        for (extent, side) in [(front, &after[..fronts]), (back, &after[fronts..])] {
            let whole = split::Extent::of(side);
            for (a, b) in [(extent.bounds, whole.bounds), (extent.centroids, whole.centroids)] {
                assert!(a.lo.truncate() == b.lo.truncate() && a.hi.truncate() == b.hi.truncate());
            }
        }
        let (lo, size) = (extent.centroids.lo, extent.centroids.hi - extent.centroids.lo);
        for (axis, i) in (0..3).flat_map(|axis| (1..bins).map(move |i| (axis, i))) {
            let at = lo[axis] + size[axis] / 0.9999 * i as f32 / bins as f32;
            let (f, b): (Vec<_>, Vec<_>) = before.iter().copied().partition(|r| r.centroid2()[axis] < at);
            // a centroid within rounding of a bin's edge may stand on its other side
            let is_clear = before.iter().all(|r| (r.centroid2()[axis] - at).abs() > 1e-5 * size[axis]);
            assert!(!is_clear || f.is_empty() || b.is_empty() || found.cost <= cost(&f, &b), "{n}, {seed}, {axis}, {i}");
        }
        let mut held = numbers(&after);
        held.sort_unstable();
        assert_eq!(held, numbers(&before));
    }
}

/// A spatial split leaves each triangle a box around its part on either side, makes no more duplicates than there is room for, and costs
/// about what was promised.
#[test]
fn spatial_split_loses_nothing() {
    for (n, room, seed) in [(40, 60, 1), (300, 301, 2), (300, 600, 3), (5000, 9000, 4), (20_000, 30_000, 5)] {
        let (positions, indices) = mesh(n, 300 + seed);
        let owners = Owners::new(std::iter::once(n));
        let meshes = [TriangleMesh { positions: &positions, indices: &indices, geometry: 0 }];
        let items = Items { meshes: &meshes, owners };
        let mut references = references(&positions, &indices);
        let (count, extent) = (references.len(), split::Extent::of(&references));
        let cut = spatial::spatial_split(&references, &items, &extent.bounds, f32::INFINITY).expect("a cut");
        references.resize(room, Reference::NONE);
        let (lefts, _, rights, _) = cut.part(&mut references, count, &items);
        assert!((count..=room).contains(&(lefts + rights)));
        let mut seen = vec![0; n as usize];
        let mut hulls = vec![Bounds3::EMPTY; n as usize];
        for r in &references[..lefts + rights] {
            let b = instance::bounds((r.lo.truncate().into(), r.hi.truncate().into()));
            seen[r.item() as usize] += 1;
            hulls[r.item() as usize] = hulls[r.item() as usize].union(b);
        }
        for (i, corners) in indices.iter().enumerate() {
            assert!((1..=2).contains(&seen[i]));
            assert_eq!(hulls[i], Bounds3::of(corners.map(|k| positions[k as usize])), "triangle {i} of {n}");
        }
        let total = cost(&references[..lefts], &references[lefts..lefts + rights]);
        assert!(room < cut.references() || total <= 1.05 * cut.cost, "{n}: {total} {}", cut.cost);
    }
}

/// Every loop over lanes gives the same bits at every width: the tree is the same on every machine.
#[test]
fn tree_does_not_depend_on_lanes() {
    let (positions, indices) = mesh(3000, 11);
    let owners = Owners::new(std::iter::once(3000));
    let meshes = [TriangleMesh { positions: &positions, indices: &indices, geometry: 0 }];
    let items = Items { meshes: &meshes, owners };
    let all = references(&positions, &indices);
    let told = |width: Width| {
        let mut told = String::new();
        for n in (2..=8).chain([100, 3000]) {
            let mut references = all[3000 - n..].to_vec();
            let extent = split::Extent::of(&references);
            if n <= sweep::SWEEP {
                write!(told, "{:?}", width.run(sweep::Sweep(&mut references))).expect("room");
            }
            let (few, many) = (split::Binning::new(&extent.centroids, 8), split::Binning::new(&extent.centroids, 16));
            let found = (
                width.run(split::FillAndSearch::<8>(split::Fill { references: &references, binning: &few })),
                width.run(split::FillAndSearch::<16>(split::Fill { references: &references, binning: &many })),
            );
            let grid = spatial::Grid::new(&extent.bounds);
            let cut = width.run(spatial::Fill { references: &references, items: &items, grid: &grid });
            let plane = Plane::new(n % 3, 0.5);
            let sides = width.run(spatial::Count { references: &references, triangles: 3000, plane: &plane });
            write!(told, "{found:?}{cut:?}{sides:?}").expect("room");
            if let Some(split) = &found.1 {
                let parted = width.run(split::Partition::<1> { references: &mut references, split });
                write!(told, "{parted:?}").expect("room");
            }
            write!(told, "{:?}", numbers(&references)).expect("room");
        }
        told
    };
    let plain = told(Width::Plain);
    assert!(Width::available().all(|width| told(width) == plain));
}
