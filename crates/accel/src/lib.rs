//! Ray casting: a wide bounding volume hierarchy over triangles, custom shapes and instances.
//!
//! ```text
//! y = RT(x, w)     the nearest point that the ray x + t w meets           [`Accel::closest`]
//! V(x, y)          whether anything stands between                        [`Accel::occluded`]
//! ```
//!
//! This room knows of no scene: it takes plain arrays and gives back numbers — how far, where on the triangle (barycentric u, v with
//! p = (1 - u - v) p0 + u p1 + v p2), and which one. t counts in units of the ray's direction, of any length.
//!
//! What it promises:
//!
//! - **Watertight.** A ray cannot slip between two triangles that share an edge or a corner (`traverse::plain` tells why).
//! - **Both sides.** A triangle is hit from either side; without area it is never hit.
//! - **The same bits.** The vector path and the plain path give the same hits, and the tree is the same at any number of threads.
//!   Of several hits at the same t the one with the lowest numbers wins (instance, then item; what is in no instance comes last).
//! - **Anything goes.** Numbers that are not finite, rays that go nowhere, a hundred thousand triangles in one place: no panic, no endless loop.
//!
//! ```
//! use etendue_accel::{BuildOptions, Builder, NoShapes, TriangleMesh};
//! use etendue_numerics::{Ray, Vec3};
//!
//! let positions = [Vec3::ZERO, Vec3::X, Vec3::Y];
//! let mut builder = Builder::new();
//! builder.add_mesh(TriangleMesh { positions: &positions, indices: &[[0, 1, 2]], geometry: 7 });
//! let accel = builder.build(&BuildOptions::default())?;
//!
//! let hit = accel.closest(&Ray::new(Vec3::new(0.25, 0.25, 1.0), -Vec3::Z), &NoShapes).ok_or("no hit")?;
//! assert_eq!((hit.t, hit.u, hit.v, hit.geometry), (1.0, 0.25, 0.25, 7));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod build;
mod instance;
mod layout;
mod traverse;

pub use build::{BuildError, BuildOptions, Builder, TreeId, TriangleMesh};
pub use traverse::Path;

use build::reference::Owners;
use etendue_numerics::{Bounds3, Ray};
use instance::Other;
use layout::Tree;
use std::sync::Arc;
use traverse::Nearest;

/// Where a ray meets something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in units of the ray's direction, > 0.
    pub t: f32,
    /// The weight of corner p1, or a custom shape's own parameter.
    pub u: f32,
    /// The weight of corner p2, or a custom shape's own parameter.
    pub v: f32,
    /// The number of the mesh or custom shape.
    pub geometry: u32,
    /// The triangle's place in its mesh, or what the custom shape tells.
    pub primitive: u32,
    /// The number of the instance, [`Hit::NO_INSTANCE`] outside of instances.
    pub instance: u32,
}

impl Hit {
    /// The `instance` of what is not instanced.
    pub const NO_INSTANCE: u32 = u32::MAX;
}

/// Where a ray meets a custom shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CustomHit {
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// A parameter of the shape's own.
    pub u: f32,
    /// A parameter of the shape's own.
    pub v: f32,
    /// A number of the shape's own.
    pub primitive: u32,
}

/// Shapes that the caller intersects.
pub trait CustomShapes: Sync {
    /// The nearest t in (0, `ray.t_max`) at which the ray meets shape `geometry`, in the space the shape was added in.
    fn intersect(&self, geometry: u32, ray: &Ray) -> Option<CustomHit>;

    /// Whether there is such a t.
    fn occludes(&self, geometry: u32, ray: &Ray) -> bool {
        self.intersect(geometry, ray).is_some_and(|hit| hit.t > 0.0 && hit.t < ray.t_max)
    }
}

/// No custom shapes.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoShapes;

impl CustomShapes for NoShapes {
    fn intersect(&self, _geometry: u32, _ray: &Ray) -> Option<CustomHit> {
        None
    }
}

/// What a tree is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stats {
    /// Triangles that can be hit.
    pub triangles: usize,
    /// Custom shapes and instances.
    pub others: usize,
    /// Nodes of eight children.
    pub nodes: usize,
    /// Leaves of triangles.
    pub leaves: usize,
    /// Triangles in leaves, those that spatial splits put into several counted as often.
    pub references: usize,
    /// Bytes of this tree, without those of the trees it shows.
    pub bytes: usize,
    /// Expected work of a ray that meets the tree's box, in nodes visited [the surface area heuristic].
    pub sah_cost: f32,
    /// How long the build took, in seconds.
    pub build_seconds: f64,
}

/// A finished tree. Immutable; rays may be cast from many threads at once.
#[derive(Clone, Debug)]
pub struct Accel {
    tree: Tree,
    /// The same for packets of rays, where they pay.
    small: Option<Tree>,
    owners: Owners,
    geometries: Vec<u32>,
    others: Vec<Other>,
    children: Vec<Arc<Accel>>,
    /// A tighter hull than `bounds`: boxes that together hold everything.
    outline: Vec<Bounds3>,
    bounds: Bounds3,
    /// Whether all coordinates are small enough for f32 products.
    ordinary: bool,
    stats: Stats,
    path: Path,
}

impl Accel {
    /// The nearest hit with t in (0, `ray.t_max`). `shapes` answers for the custom shapes of this tree and of those it shows.
    #[inline]
    pub fn closest<S: CustomShapes>(&self, ray: &Ray, shapes: &S) -> Option<Hit> {
        Some(self.hit(&traverse::closest(self, ray, shapes)?))
    }

    /// [`Accel::closest`] of many rays, in their order: the same hits, found sooner where rays can go together.
    pub fn closest_each<S: CustomShapes>(&self, rays: &[Ray], shapes: &S, hits: &mut Vec<Option<Hit>>) {
        hits.clear();
        hits.resize(rays.len(), None);
        traverse::closest_each(self, rays, shapes, |i, nearest| hits[i] = nearest.map(|nearest| self.hit(&nearest)));
    }

    /// What is hit, by name.
    #[inline(always)]
    fn hit(&self, nearest: &Nearest) -> Hit {
        let (owner, instance) = match self.others.get(nearest.instance as usize) {
            Some(Other::Instance(i)) => (&*self.children[i.tree as usize], i.id),
            _ => (self, Hit::NO_INSTANCE),
        };
        let (geometry, primitive) = owner.name(nearest.item, nearest.primitive);
        Hit { t: nearest.t, u: nearest.u, v: nearest.v, geometry, primitive, instance }
    }

    /// Whether anything is hit with t in (0, `ray.t_max`): the same as `closest(…).is_some()`, found sooner.
    #[inline]
    pub fn occluded<S: CustomShapes>(&self, ray: &Ray, shapes: &S) -> bool {
        traverse::occluded(self, ray, shapes)
    }

    /// [`Accel::occluded`] of many rays, in their order.
    pub fn occluded_each<S: CustomShapes>(&self, rays: &[Ray], shapes: &S, occluded: &mut Vec<bool>) {
        occluded.clear();
        occluded.resize(rays.len(), false);
        traverse::occluded_each(self, rays, shapes, |i| occluded[i] = true);
    }

    /// The box around everything; empty for a tree of nothing.
    pub fn bounds(&self) -> Bounds3 {
        self.bounds
    }

    /// What the tree is made of.
    pub fn stats(&self) -> Stats {
        self.stats
    }

    /// How rays are cast.
    pub fn path(&self) -> Path {
        self.path
    }

    /// The same tree, its rays cast another way; `None` where this machine cannot. Hits do not change.
    pub fn with_path(mut self, path: Path) -> Option<Self> {
        self.path = path;
        path.is_available().then_some(self)
    }

    /// Geometry and primitive of a flat item number.
    #[inline(always)]
    fn name(&self, item: u32, primitive: u32) -> (u32, u32) {
        match self.owners.locate(item) {
            Some((mesh, primitive)) => (self.geometries[mesh as usize], primitive),
            None => match self.others.get((item - self.owners.total()) as usize) {
                Some(Other::Custom { geometry }) => (*geometry, primitive),
                _ => (u32::MAX, primitive),
            },
        }
    }
}
