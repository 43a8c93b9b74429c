//! Surfaces: what the rays of the world meet.
//!
//! A [`Shape`] is one of a closed list of geometries, all of which answer the questions of [`Geometry`]. Triangle meshes are intersected by
//! the accelerator itself; every other shape answers for itself. Rectangles and cubes are meshes.
//!
//! A shape is made of *primitives*, the parts that a light sampler may choose among: the triangles of a mesh, or the whole shape where
//! it is one piece (sphere, disk, cylinder, rectangle).

mod cylinder;
mod disk;
pub(crate) mod load;
mod mesh;
mod patch;
mod quadratic;
pub mod sample;
mod sdf_grid;
mod sphere;
mod triangle;
mod trilinear;

pub use cylinder::Cylinder;
pub use disk::Disk;
pub use mesh::Mesh;
pub(crate) use patch::FarRectangle;
pub use sample::SurfacePoint;
pub use sdf_grid::SdfGrid;
pub use sphere::Sphere;
pub use triangle::{SurfaceFrame, Triangle};

use crate::ids::{EmitterId, MaterialId, SurfaceId};
use crate::interaction::Interaction;
use etendue_accel::{CustomHit, CustomShapes, Hit};
use etendue_description::NodeId;
use etendue_numerics::{Bounds3, Ray, Transform, Vec2, Vec3};

/// A shape with its material and emission.
#[derive(Debug)]
pub struct Surface {
    /// The geometry.
    pub shape: Shape,
    /// How it scatters.
    pub material: MaterialId,
    /// What it emits.
    pub emitter: Option<EmitterId>,
    /// The node of the description that it came from.
    pub node: NodeId,
    /// Whether rays in the world meet it: not what stands there through instances only, nor a lamp that shines unseen.
    pub in_world: bool,
}

/// All surfaces; a hit's `geometry` is an index here.
#[derive(Debug, Default)]
pub struct Surfaces(Vec<Surface>);

impl Surfaces {
    /// The surface of an id.
    #[inline]
    pub fn get(&self, id: SurfaceId) -> &Surface {
        &self.0[id.index()]
    }

    /// The surface of an id, to be changed.
    pub fn get_mut(&mut self, id: SurfaceId) -> &mut Surface {
        &mut self.0[id.index()]
    }

    /// Adds a surface.
    pub fn push(&mut self, surface: Surface) -> SurfaceId {
        self.0.push(surface);
        SurfaceId(self.0.len() as u32 - 1)
    }

    /// All surfaces with their ids.
    pub fn iter(&self) -> impl Iterator<Item = (SurfaceId, &Surface)> {
        self.0.iter().enumerate().map(|(i, s)| (SurfaceId(i as u32), s))
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl CustomShapes for Surfaces {
    #[inline]
    fn intersect(&self, geometry: u32, ray: &Ray) -> Option<CustomHit> {
        self.get(SurfaceId(geometry)).shape.intersect(ray)
    }
}

/// What every geometry answers. Lengths in metres, in the shape's world (or in its group's coordinates where it is instanced).
pub trait Geometry {
    /// The box around it.
    fn bounds(&self) -> Bounds3;

    /// How many primitives.
    fn primitive_count(&self) -> u32 {
        1
    }

    /// Area of a primitive, m².
    fn area_of(&self, primitive: u32) -> f32;

    /// The nearest meeting with `ray` in (0, `t_max`); meshes leave this to the accelerator.
    fn intersect(&self, ray: &Ray) -> Option<CustomHit>;

    /// The surface at a hit of `ray`; `surface` and `instance` are taken over from the hit.
    fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction;

    /// A point of the primitive, uniform over its area: `pdf_a` is 1 / area, 1/m².
    fn sample_area(&self, primitive: u32, u: Vec2) -> SurfacePoint;

    /// The density, 1/sr at `from`, of [`Geometry::sample_direction`] at the point `at` of the primitive; zero where it cannot be drawn.
    fn pdf_direction(&self, primitive: u32, from: Vec3, at: &Interaction) -> f32 {
        sample::pdf_direction_by_area(self.area_of(primitive), from, at)
    }

    /// A point of the primitive as seen from `from`, with its density in 1/sr; `None` where nothing of it can be seen.
    fn sample_direction(&self, primitive: u32, from: Vec3, u: Vec2) -> Option<(SurfacePoint, f32)> {
        sample::sample_direction_by_area(self.sample_area(primitive, u), from)
    }
}

/// Lists the variants of [`Shape`] once: the enum, and each question passed on.
macro_rules! shapes {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {
        /// A geometry.
        #[derive(Debug)]
        pub enum Shape {
            $($(#[$doc])* $name($name),)*
        }

        $(impl From<$name> for Shape {
            fn from(shape: $name) -> Self {
                Self::$name(shape)
            }
        })*

        impl Geometry for Shape {
            fn bounds(&self) -> Bounds3 {
                match self { $(Self::$name(s) => s.bounds(),)* }
            }
            fn primitive_count(&self) -> u32 {
                match self { $(Self::$name(s) => s.primitive_count(),)* }
            }
            #[inline]
            fn area_of(&self, primitive: u32) -> f32 {
                match self { $(Self::$name(s) => s.area_of(primitive),)* }
            }
            #[inline]
            fn intersect(&self, ray: &Ray) -> Option<CustomHit> {
                match self { $(Self::$name(s) => s.intersect(ray),)* }
            }
            #[inline(always)]
            fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
                match self { $(Self::$name(s) => s.interaction(ray, hit),)* }
            }
            #[inline]
            fn sample_area(&self, primitive: u32, u: Vec2) -> SurfacePoint {
                match self { $(Self::$name(s) => s.sample_area(primitive, u),)* }
            }
            #[inline]
            fn pdf_direction(&self, primitive: u32, from: Vec3, at: &Interaction) -> f32 {
                match self { $(Self::$name(s) => s.pdf_direction(primitive, from, at),)* }
            }
            #[inline]
            fn sample_direction(&self, primitive: u32, from: Vec3, u: Vec2) -> Option<(SurfacePoint, f32)> {
                match self { $(Self::$name(s) => s.sample_direction(primitive, from, u),)* }
            }
        }
    };
}

shapes! {
    /// Triangles.
    Mesh,
    /// A full sphere.
    Sphere,
    /// A flat disk.
    Disk,
    /// An open cylinder.
    Cylinder,
    /// The zero set of a voxel grid of signed distances.
    SdfGrid,
}

impl Shape {
    /// Area of the whole, m².
    pub fn area(&self) -> f64 {
        (0..self.primitive_count()).map(|i| f64::from(self.area_of(i))).sum()
    }

    /// The mesh, where it is one.
    #[inline]
    pub fn mesh(&self) -> Option<&Mesh> {
        match self {
            Self::Mesh(mesh) => Some(mesh),
            _ => None,
        }
    }

    /// The surface at a hit that was seen through an instance.
    #[inline(always)] // as a return value it would go through memory
    pub fn interaction_through(&self, to_world: &Transform, ray: &Ray, hit: &Hit) -> Interaction {
        match self {
            // Where a triangle is met depends on the ray by its hit alone.
            Self::Mesh(mesh) => Interaction { wo: -ray.d, ..mesh.interaction(ray, hit).moved(to_world) },
            _ => self.other_through(to_world, ray, hit),
        }
    }

    #[inline(never)]
    fn other_through(&self, to_world: &Transform, ray: &Ray, hit: &Hit) -> Interaction {
        let local = Ray { o: to_world.inverse_point(ray.o), d: to_world.inverse_vector(ray.d), ..*ray };
        Interaction { wo: -ray.d, ..self.interaction(&local, hit).moved(to_world) }
    }
}
