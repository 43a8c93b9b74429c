//! What the eye sees first, as numbers instead of light: albedo, normals, depth, position, texture coordinates.

use crate::drivers::PixelSolver;
use crate::transport::{Context, PathState, Vertex};
use etendue_bsdf::Scatter;
use etendue_numerics::{Sampler, Spectrum, Vec3};

/// A quantity of the first surface along a camera ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Hemispherical reflectance, [0, 1].
    Albedo,
    /// Unit shading normal, world.
    Normal,
    /// Unit geometric normal, world.
    GeometricNormal,
    /// Distance from the eye, scene units.
    Depth,
    /// The point, world.
    Position,
    /// Texture coordinates.
    Uv,
}

impl Quantity {
    /// All quantities with their names on the command line, their names in Mitsuba's `aov`, and their numbers of channels.
    pub const ALL: [(Self, &'static str, &'static str, usize); 6] = [
        (Self::Albedo, "albedo", "albedo", 3),
        (Self::Normal, "normal", "sh_normal", 3),
        (Self::GeometricNormal, "geometric-normal", "geo_normal", 3),
        (Self::Depth, "depth", "depth", 1),
        (Self::Position, "position", "position", 3),
        (Self::Uv, "uv", "uv", 2),
    ];

    /// The quantity of a name of either kind.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, ours, theirs, _)| name == *ours || name == *theirs).map(|(q, ..)| *q)
    }

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(q, ..)| *q == self).map_or("", |(_, name, ..)| name)
    }

    /// Numbers per pixel.
    pub fn channels(self) -> usize {
        Self::ALL.iter().find(|(q, ..)| *q == self).map_or(3, |(.., n)| *n)
    }
}

/// Shows one quantity; zero where the ray meets nothing.
#[derive(Clone, Copy, Debug)]
pub struct Aov(pub Quantity);

impl PixelSolver for Aov {
    fn radiance(&self, c: &Context<'_>, eye: PathState, _: &Sampler, rays: &mut u64) -> Spectrum {
        *rays += 1;
        let Some(hit) = c.scene.intersect(&eye.ray) else { return Spectrum::ZERO };
        let x = c.scene.interaction(&eye.ray, &hit);
        let vector = |v: Vec3| Spectrum::rgb(v.x, v.y, v.z);
        match self.0 {
            Quantity::Albedo => {
                let vertex = Vertex::new(c.scene, x, &eye.wl);
                vertex.bsdf.albedo(vertex.wo)
            }
            Quantity::Normal => vector(x.shading.n),
            Quantity::GeometricNormal => vector(x.n),
            Quantity::Depth => Spectrum::splat(hit.t),
            Quantity::Position => vector(x.p),
            Quantity::Uv => Spectrum::rgb(x.uv.x, x.uv.y, 0.0),
        }
    }
}
