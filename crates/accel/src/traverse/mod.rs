//! Rays through the tree: the nearest hit, or whether there is one.
//!
//! One loop for each question, written once over a [`Kernel`]: eight box tests at a time, eight triangle tests at a time. The kernels
//! (plain Rust, AVX2, and a careful one in f64 for numbers beyond the ordinary) do the same operations in the same order, so the first
//! two give the same bits.
//!
//! This module alone may use `unsafe`, for three things: vector instructions whose presence was asked for at run time, array
//! accesses whose bounds the build guarantees, and a stack that need not be cleared for each ray.
#![allow(unsafe_code)]

#[cfg(target_arch = "x86_64")]
mod avx2;
mod careful;
#[cfg(target_arch = "x86_64")]
mod coherent;
mod order;
#[cfg(target_arch = "x86_64")]
mod packet;
mod plain;
mod setup;
mod stack;

use crate::build::binary::MAX_DEPTH;
use crate::instance::Other;
use crate::layout::{Child, Node, ROWS, Tree, WIDTH};
use crate::{Accel, CustomShapes};
use etendue_numerics::Ray;
use stack::Stack;

pub(crate) use setup::ORDINARY;

/// Trees for packets of rays have no more nodes: their stack counts on it.
pub(crate) const MOST_NODES_OF_PACKETS: usize = 32;

/// More entries than this never wait: each level of the tree leaves at most seven siblings behind.
const STACK: usize = (WIDTH - 1) * MAX_DEPTH + 1;

/// The nearest hit so far; before the first, the end of the ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    pub t: f32,
    pub u: f32,
    pub v: f32,
    /// Number of the instance in the outer tree, `u32::MAX` outside of instances.
    pub instance: u32,
    /// Flat item number within its tree.
    pub item: u32,
    /// The primitive that a custom shape tells.
    pub primitive: u32,
    pub is_hit: bool,
}

impl Nearest {
    fn none(t_max: f32) -> Self {
        Self { t: t_max, u: 0.0, v: 0.0, instance: 0, item: 0, primitive: 0, is_hit: false }
    }

    /// Whether a hit at `t` comes before. Of equal hits the lower number wins, so that the answer does not depend on the tree.
    #[inline(always)]
    fn is_beaten_by(&self, t: f32, instance: u32, item: u32) -> bool {
        t < self.t || (t == self.t && (instance, item) < (self.instance, self.item))
    }
}

impl Nearest {
    /// Takes over a hit on a triangle if it comes before.
    #[inline(always)]
    fn hear(&mut self, t: f32, u: f32, v: f32, instance: u32, item: u32) {
        if self.is_beaten_by(t, instance, item) {
            *self = Self { t, u, v, instance, item, primitive: 0, is_hit: true };
        }
    }
}

/// A hit among the triangles of one leaf: the nearest, of equals the one in the lowest lane.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LaneHit {
    t: f32,
    u: f32,
    v: f32,
    lane: usize,
}

/// Where a ray begins: a subtree.
#[derive(Clone, Copy)]
struct Start<'a> {
    accel: &'a Accel,
    child: Child,
}

impl<'a> Start<'a> {
    /// All of a tree; `None` where it is empty.
    #[inline(always)]
    fn all(accel: &'a Accel) -> Option<Self> {
        Some(Self { accel, child: accel.tree.root? })
    }
}

/// Eight boxes, or up to eight triangles, against one ray that has been prepared.
trait Kernel: Sized {
    /// Prepares a ray.
    fn new(ray: &Ray) -> Self;

    /// Which of a node's boxes the ray meets within [0, `best`], a bit each, and where it enters them.
    fn boxes(&self, node: &Node, best: f32, enter: &mut [f32; WIDTH]) -> u32;

    /// The nearest of a leaf's triangles that the ray hits within (0, `best`].
    ///
    /// # Safety
    /// `corners` points to `count` ≤ 8 triangles in rows of `count` floats, and to [`WIDTH`] readable floats after them.
    unsafe fn nearest(&self, corners: *const f32, count: usize, best: f32) -> Option<LaneHit>;

    /// Whether the ray hits one of a leaf's triangles within (0, `t_max`).
    ///
    /// # Safety
    /// As for [`Kernel::nearest`].
    unsafe fn any(&self, corners: *const f32, count: usize, t_max: f32) -> bool;

    /// [`closest_in`], compiled for this kernel's instructions.
    fn closest<S: CustomShapes>(start: Start<'_>, ray: &Ray, shapes: &S, instance: u32, nearest: &mut Nearest);

    /// [`occluded_in`], compiled for this kernel's instructions.
    fn occluded<S: CustomShapes>(start: Start<'_>, ray: &Ray, shapes: &S, last: &mut Option<Child>) -> bool;
}

/// How rays are cast. All give the same hits; the choice is there for tests and measurements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Path {
    /// Plain Rust: runs everywhere.
    Plain,
    /// AVX2: eight lanes on x86-64 processors since 2013.
    Avx2,
    /// AVX-512: as AVX2, but for many rays through a small tree, which go in packets of sixteen.
    Avx512,
}

impl Path {
    /// The fastest that this machine can run.
    pub fn best() -> Self {
        [Self::Avx512, Self::Avx2].into_iter().find(|path| path.is_available()).unwrap_or(Self::Plain)
    }

    /// Whether many rays through a small tree go in packets.
    pub(crate) fn has_packets(self) -> bool {
        self == Self::Avx512
    }

    /// Whether this machine can run it.
    pub fn is_available(self) -> bool {
        match self {
            Self::Plain => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => {
                is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("fma")
                    && is_x86_feature_detected!("bmi1")
                    && is_x86_feature_detected!("bmi2")
            }
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                Self::Avx2.is_available()
                    && is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("lzcnt")
                    && is_x86_feature_detected!("popcnt")
            }
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }
}

/// The nearest hit within (0, `ray.t_max`).
#[inline]
pub(crate) fn closest<S: CustomShapes>(accel: &Accel, ray: &Ray, shapes: &S) -> Option<Nearest> {
    let mut nearest = Nearest::none(ray.t_max);
    enter_closest(accel, ray, shapes, u32::MAX, &mut nearest, accel.path);
    nearest.is_hit.then_some(nearest)
}

/// Whether there is a hit within (0, `ray.t_max`).
#[inline]
pub(crate) fn occluded<S: CustomShapes>(accel: &Accel, ray: &Ray, shapes: &S) -> bool {
    enter_occluded(accel, ray, shapes, accel.path, &mut None)
}

/// The nearest hit of each ray that hits anything; `found` hears of them in any order, by the ray's place.
pub(crate) fn closest_each<S: CustomShapes>(
    accel: &Accel,
    rays: &[Ray],
    shapes: &S,
    mut found: impl FnMut(usize, Option<Nearest>),
) {
    #[cfg(target_arch = "x86_64")]
    if let Some(tree) = for_packets(accel) {
        order::by_kind(rays, packet::RAYS, |kind, these| {
            let Some(kind) = kind else {
                these.iter().for_each(|i| found(*i as usize, closest(accel, &rays[*i as usize], shapes)));
                return;
            };
            // SAFETY: the path tells that the instructions are there.
            let packet = unsafe { packet::closest(tree, kind, these.iter().map(|i| &rays[*i as usize])) };
            for (lane, i) in these.iter().enumerate() {
                let i = *i as usize;
                if packet.again >> lane & 1 != 0 {
                    found(i, closest(accel, &rays[i], shapes));
                } else if packet.hit >> lane & 1 != 0 {
                    let (t, u, v, item) = (packet.t[lane], packet.u[lane], packet.v[lane], packet.item[lane]);
                    found(i, Some(Nearest { t, u, v, instance: u32::MAX, item, primitive: 0, is_hit: true }));
                }
            }
        });
        return;
    }
    #[cfg(target_arch = "x86_64")]
    if accel.path.has_packets() && accel.ordinary {
        order::by_kind(rays, packet::RAYS, |kind, these| match kind {
            Some(kind) if coherent::stay_together(accel, rays, these) => {
                // SAFETY: the path tells that the instructions are there.
                let packet = unsafe { coherent::closest(accel, kind, rays, these, shapes) };
                for (lane, i) in these.iter().enumerate() {
                    match packet.of(lane) {
                        Some(nearest) => found(*i as usize, nearest),
                        None => found(*i as usize, closest(accel, &rays[*i as usize], shapes)),
                    }
                }
            }
            _ => these.iter().for_each(|i| found(*i as usize, closest(accel, &rays[*i as usize], shapes))),
        });
        return;
    }
    order::by_kind(rays, rays.len().max(1), |_, these| {
        these.iter().for_each(|i| found(*i as usize, closest(accel, &rays[*i as usize], shapes)));
    });
}

/// Whether each ray hits anything; `found` hears of those that do, in any order, by the ray's place.
pub(crate) fn occluded_each<S: CustomShapes>(accel: &Accel, rays: &[Ray], shapes: &S, mut found: impl FnMut(usize)) {
    #[cfg(target_arch = "x86_64")]
    if let Some(tree) = for_packets(accel) {
        order::by_kind(rays, packet::RAYS, |kind, these| {
            let Some(kind) = kind else {
                these.iter().map(|i| *i as usize).filter(|i| occluded(accel, &rays[*i], shapes)).for_each(&mut found);
                return;
            };
            // SAFETY: the path tells that the instructions are there.
            let (hit, again) = unsafe { packet::occluded(tree, kind, these.iter().map(|i| &rays[*i as usize])) };
            for (lane, i) in these.iter().enumerate() {
                let i = *i as usize;
                if hit >> lane & 1 != 0 || again >> lane & 1 != 0 && occluded(accel, &rays[i], shapes) {
                    found(i);
                }
            }
        });
        return;
    }
    // What stopped one ray may well stop the next.
    let mut last = None;
    #[cfg(target_arch = "x86_64")]
    if accel.path.has_packets() && accel.ordinary {
        order::by_kind(rays, packet::RAYS, |kind, these| match kind {
            Some(kind) if coherent::stay_together(accel, rays, these) => {
                // SAFETY: the path tells that the instructions are there.
                let (hit, again) = unsafe { coherent::occluded(accel, kind, rays, these, shapes, &mut last) };
                for (lane, i) in these.iter().enumerate() {
                    let i = *i as usize;
                    if hit >> lane & 1 != 0 || again >> lane & 1 != 0 && occluded(accel, &rays[i], shapes) {
                        found(i);
                    }
                }
            }
            _ => {
                let is_stopped = |i: &usize| enter_occluded(accel, &rays[*i], shapes, accel.path, &mut last);
                these.iter().map(|i| *i as usize).filter(is_stopped).for_each(&mut found);
            }
        });
        return;
    }
    order::by_kind(rays, rays.len().max(1), |_, these| {
        let is_stopped = |i: &usize| enter_occluded(accel, &rays[*i], shapes, accel.path, &mut last);
        these.iter().map(|i| *i as usize).filter(is_stopped).for_each(&mut found);
    });
}

/// The tree that many rays are cast through in packets.
#[cfg(target_arch = "x86_64")]
fn for_packets(accel: &Accel) -> Option<&Tree> {
    accel.small.as_ref().filter(|_| accel.path.has_packets() && accel.ordinary)
}

#[inline(always)]
fn enter_closest<S: CustomShapes>(accel: &Accel, ray: &Ray, shapes: &S, instance: u32, nearest: &mut Nearest, path: Path) {
    let Some(all) = Start::all(accel) else { return };
    if !(accel.ordinary && setup::is_ordinary(ray)) {
        if setup::is_sound(ray) {
            careful::Careful::closest(all, ray, shapes, instance, nearest);
        }
        return;
    }
    match path {
        #[cfg(target_arch = "x86_64")]
        Path::Avx2 | Path::Avx512 => avx2::Avx2::closest(all, ray, shapes, instance, nearest),
        _ => plain::Plain::closest(all, ray, shapes, instance, nearest),
    }
}

#[inline(always)]
fn enter_occluded<S: CustomShapes>(accel: &Accel, ray: &Ray, shapes: &S, path: Path, last: &mut Option<Child>) -> bool {
    let Some(all) = Start::all(accel) else { return false };
    if !(accel.ordinary && setup::is_ordinary(ray)) {
        return setup::is_sound(ray) && careful::Careful::occluded(all, ray, shapes, last);
    }
    match path {
        #[cfg(target_arch = "x86_64")]
        Path::Avx2 | Path::Avx512 => avx2::Avx2::occluded(all, ray, shapes, last),
        _ => plain::Plain::occluded(all, ray, shapes, last),
    }
}

/// Walks one tree front to back, keeping the nearest hit.
#[inline(always)]
fn closest_in<K: Kernel, S: CustomShapes>(start: Start<'_>, ray: &Ray, shapes: &S, instance: u32, nearest: &mut Nearest) {
    let Start { accel, child: mut current } = start;
    let tree = &accel.tree;
    let kernel = K::new(ray);
    let mut stack = Stack::<u64, STACK>::new();
    loop {
        if current.is_node() {
            // SAFETY: the build numbers nodes below nodes.len().
            let node = unsafe { tree.nodes.get_unchecked(current.0 as usize) };
            let mut enter = [0.0; WIDTH];
            let mut met = kernel.boxes(node, nearest.t, &mut enter);
            if met != 0 {
                let (first, rest) = take(met, node, &enter);
                met = rest;
                if met == 0 {
                    current = child(first);
                    continue;
                }
                let (second, rest) = take(met, node, &enter);
                met = rest;
                if met == 0 {
                    fetch(tree, child(first.max(second)));
                    stack.push(first.max(second));
                    current = child(first.min(second));
                    continue;
                }
                fetch(tree, child(first.max(second)));
                current = child(stack.push_sorted(first, second, met, |i| {
                    let entry = entry(node, &enter, i);
                    fetch(tree, child(entry));
                    entry
                }));
                continue;
            }
        } else if current.is_triangles() {
            let (first, count) = current.run();
            // SAFETY: the build makes leaves of `count` triangles from reference `first` on, and pads the end.
            let hit = unsafe { kernel.nearest(tree.corners.as_ptr().add(first * ROWS), count, nearest.t) };
            if let Some(hit) = hit {
                nearest.hear(hit.t, hit.u, hit.v, instance, tree.items[first + hit.lane]);
            }
        } else {
            closest_other::<K, S>(accel, current.index(), ray, shapes, instance, nearest);
        }
        loop {
            let Some(entry) = stack.pop() else { return };
            if (entry >> 32) as u32 <= nearest.t.to_bits() {
                current = child(entry);
                break;
            }
        }
    }
}

/// Walks one tree until something is hit. `last` is the leaf of triangles that stopped the last ray: it is looked at first.
#[inline(always)]
fn occluded_in<K: Kernel, S: CustomShapes>(start: Start<'_>, ray: &Ray, shapes: &S, last: &mut Option<Child>) -> bool {
    let Start { accel, child: mut current } = start;
    let tree = &accel.tree;
    let kernel = K::new(ray);
    if last.is_some_and(|leaf| stops(&kernel, tree, leaf, ray.t_max)) {
        return true;
    }
    let mut stack = Stack::<u64, STACK>::new();
    loop {
        if current.is_node() {
            // SAFETY: the build numbers nodes below nodes.len().
            let node = unsafe { tree.nodes.get_unchecked(current.0 as usize) };
            let mut enter = [0.0; WIDTH];
            let mut met = kernel.boxes(node, ray.t_max, &mut enter);
            if met != 0 {
                // children lie in order of size: the largest is the likeliest to stop the ray
                current = node.children[met.trailing_zeros() as usize & 7];
                met &= met - 1;
                while met != 0 {
                    let last = 31 - met.leading_zeros();
                    let later = node.children[last as usize & 7];
                    fetch(tree, later);
                    stack.push(u64::from(later.0));
                    met ^= 1 << last;
                }
                continue;
            }
        } else if current.is_triangles() {
            if stops(&kernel, tree, current, ray.t_max) {
                *last = Some(current);
                return true;
            }
        } else if occluded_other::<K, S>(accel, current.index(), ray, shapes) {
            return true;
        }
        let Some(entry) = stack.pop() else { return false };
        current = child(entry);
    }
}

/// Whether one of a leaf's triangles stops the ray.
#[inline(always)]
fn stops<K: Kernel>(kernel: &K, tree: &Tree, leaf: Child, t_max: f32) -> bool {
    let (first, count) = leaf.run();
    // SAFETY: the build makes leaves of `count` triangles from reference `first` on, and pads the end.
    unsafe { kernel.any(tree.corners.as_ptr().add(first * ROWS), count, t_max) }
}

/// Asks for the memory of a child that will be looked at later, so that it is near by then.
#[inline(always)]
fn fetch(tree: &Tree, child: Child) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        const LINE: usize = 64;
        let at: *const i8 = if child.is_node() {
            tree.nodes.as_ptr().wrapping_add(child.0 as usize).cast()
        } else {
            tree.corners.as_ptr().wrapping_add(child.run().0 * ROWS).cast()
        };
        for line in 0..size_of::<Node>().div_ceil(LINE) {
            // SAFETY: a prefetch reads nothing; any address will do.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(at.wrapping_add(line * LINE)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (tree, child);
}

/// A stack entry: where the ray enters, then the child. Entry points are not negative, so entries compare as integers.
#[inline(always)]
fn entry(node: &Node, enter: &[f32; WIDTH], i: u32) -> u64 {
    u64::from(enter[i as usize & 7].to_bits()) << 32 | u64::from(node.children[i as usize & 7].0)
}

#[inline(always)]
fn child(entry: u64) -> Child {
    Child(entry as u32)
}

/// The entry of the lowest bit, and the other bits.
#[inline(always)]
fn take(met: u32, node: &Node, enter: &[f32; WIDTH]) -> (u64, u32) {
    (entry(node, enter, met.trailing_zeros()), met & (met - 1))
}

#[inline(never)]
fn closest_other<K: Kernel, S: CustomShapes>(
    accel: &Accel,
    index: usize,
    ray: &Ray,
    shapes: &S,
    instance: u32,
    nearest: &mut Nearest,
) {
    match &accel.others[index] {
        Other::Custom { geometry } => {
            // What is as far as the nearest is heard as well, for its number may be the lower one.
            let end = if nearest.is_hit { nearest.t.next_up() } else { nearest.t };
            let Some(hit) = shapes.intersect(*geometry, &ray.until(end)) else { return };
            let item = accel.owners.total() + index as u32;
            if hit.t > 0.0 && nearest.is_beaten_by(hit.t, instance, item) {
                *nearest = Nearest { t: hit.t, u: hit.u, v: hit.v, instance, item, primitive: hit.primitive, is_hit: true };
            }
        }
        Other::Instance(inner) => {
            let child = &accel.children[inner.tree as usize];
            let (Some(all), local) = (Start::all(child), inner.ray(ray)) else { return };
            if child.ordinary && setup::is_ordinary(&local) {
                K::closest(all, &local, shapes, index as u32, nearest);
            } else if setup::is_sound(&local) {
                careful::Careful::closest(all, &local, shapes, index as u32, nearest);
            }
        }
    }
}

#[inline(never)]
fn occluded_other<K: Kernel, S: CustomShapes>(accel: &Accel, index: usize, ray: &Ray, shapes: &S) -> bool {
    match &accel.others[index] {
        Other::Custom { geometry } => shapes.occludes(*geometry, ray),
        Other::Instance(inner) => {
            let child = &accel.children[inner.tree as usize];
            let (Some(all), local) = (Start::all(child), inner.ray(ray)) else { return false };
            if child.ordinary && setup::is_ordinary(&local) {
                K::occluded(all, &local, shapes, &mut None)
            } else {
                setup::is_sound(&local) && careful::Careful::occluded(all, &local, shapes, &mut None)
            }
        }
    }
}
