//! What the eye sees first, as numbers instead of light: albedo, normals, depth, position, texture
//! coordinates, tangents, and the numbers of surface and primitive.

use crate::drivers::PixelSolver;
use crate::transport::{Context, Crowd, PathState, Vertex};
use etendue_bsdf::Scatter;
use etendue_numerics::{Sampler, Spectrum, Vec3, Wavelengths};

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
    /// ∂p/∂u, world.
    DpDu,
    /// ∂p/∂v, world.
    DpDv,
    /// Number of the surface, in file order.
    ShapeIndex,
    /// Number of the primitive in its surface.
    PrimitiveIndex,
    /// Samples taken: as many in every pixel, but where a noise target spreads them.
    Samples,
}

/// A quantity, its name on the command line, its name in Mitsuba's `aov`, and its channels as Mitsuba names them.
type Entry = (Quantity, &'static str, &'static str, &'static [&'static str]);

impl Quantity {
    /// All quantities. A depth is measured along the ray, so its channel is the ray's parameter `T`, not the camera's `Z`.
    pub const ALL: [Entry; 11] = [
        (Self::Albedo, "albedo", "albedo", &["R", "G", "B"]),
        (Self::Normal, "normal", "sh_normal", &["X", "Y", "Z"]),
        (Self::GeometricNormal, "geometric-normal", "geo_normal", &["X", "Y", "Z"]),
        (Self::Depth, "depth", "depth", &["T"]),
        (Self::Position, "position", "position", &["X", "Y", "Z"]),
        (Self::Uv, "uv", "uv", &["U", "V"]),
        (Self::DpDu, "dp-du", "dp_du", &["X", "Y", "Z"]),
        (Self::DpDv, "dp-dv", "dp_dv", &["X", "Y", "Z"]),
        (Self::ShapeIndex, "shape-index", "shape_index", &["I"]),
        (Self::PrimitiveIndex, "primitive-index", "prim_index", &["I"]),
        (Self::Samples, "samples", "samples", &["N"]),
    ];

    /// The quantity of a name of either kind.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, ours, theirs, _)| name == *ours || name == *theirs).map(|(q, ..)| *q)
    }

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(q, ..)| *q == self).map_or("", |(_, name, ..)| name)
    }

    /// The names of its numbers.
    pub fn channels(self) -> &'static [&'static str] {
        Self::ALL.iter().find(|(q, ..)| *q == self).map_or(&[], |(.., names)| names)
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
            Quantity::DpDu => vector(x.dp_du),
            Quantity::DpDv => vector(x.dp_dv),
            Quantity::ShapeIndex => Spectrum::splat(x.surface.0 as f32),
            Quantity::PrimitiveIndex => Spectrum::splat(x.primitive as f32),
            Quantity::Samples => Spectrum::ONE,
        }
    }

    /// Numbers, or a surface's red, green and blue, also where light is made of wavelengths.
    fn radiances<'a>(&self, c: &Context<'a>, crowd: &mut Crowd<'a>, rays: &mut u64) {
        for (walk, u) in crowd.walks.iter_mut().zip(&crowd.samplers) {
            walk.wl = Wavelengths::Rgb;
            walk.l = self.radiance(c, *walk, u, rays);
        }
    }
}
