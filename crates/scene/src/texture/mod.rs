//! Textures: values over a surface, in linear Rec.709, at the wavelengths of a walk, or as plain numbers.
//!
//! ```text
//! t : (surface, u, v) → colour (reflectance, or radiance in W/(m² sr)) or a plain number
//! ```
//!
//! | here | what | unit |
//! | --- | --- | --- |
//! | [`Texture::eval`] | t as a spectrum | that of the parameter it stands for |
//! | [`Texture::eval_scalar`] | t as one number; of a coloured texture its luminance | same |
//! | [`Texture::eval_gradient`] | (∂t/∂u, ∂t/∂v) of the scalar | same, per unit of u and v |
//! | [`Texture::mean`] | the mean over the texture's own domain | same |
//!
//! A parameter that may be textured is a [`ColorSlot`] or a [`ScalarSlot`]: a constant costs no look-up and no branch beyond one.

mod bitmap;
mod checkerboard;
mod combine;
mod mapping;
mod mesh_attribute;
mod noise;
mod slot;
mod texels;
mod uv;

pub use bitmap::{Bitmap, FilterMode, WrapMode};
pub use checkerboard::Checkerboard;
pub use combine::{Adjusted, Bilerp, DirectionMix, Mapped, Mix, Product};
pub use mapping::{Chart, Mapping, Space};
pub use mesh_attribute::MeshAttribute;
pub use noise::{Dots, Marble, Noise, Turbulence, noise};
pub use slot::{Color, ColorSlot, Role, ScalarSlot};
pub(crate) use texels::TexelLanes;
pub use texels::Texels;
pub use uv::UvMap;

use crate::ids::SurfaceId;
use crate::scene::Scene;
use etendue_numerics::{Spectrum, Vec2, Vec3, Wavelengths};

/// Where a texture is looked up. A footprint may join it later: build it with [`Scene::texture_context`] where there is an interaction.
#[derive(Clone, Copy, Debug)]
pub struct TextureContext<'a> {
    /// The scene, for textures within textures and for attributes of meshes.
    pub scene: &'a Scene,
    /// Texture coordinates.
    pub uv: Vec2,
    /// The surface.
    pub surface: SurfaceId,
    /// The triangle or face.
    pub primitive: u32,
    /// Barycentrics (b1, b2) within it.
    pub bary: Vec2,
    /// The point in the world, m.
    pub p: Vec3,
    /// The shading normal, or zero where there is no surface.
    pub n: Vec3,
}

macro_rules! textures {
    ($($(#[$doc:meta])* $model:ident),* $(,)?) => {
        /// A texture of any model.
        #[derive(Clone, Debug)]
        pub enum Texture {
            $($(#[$doc])* $model($model),)*
        }

        impl Texture {
            /// The model's name.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$model(_) => stringify!($model),)* }
            }

            /// The value at x.
            #[inline]
            pub fn eval(&self, x: &TextureContext, wl: &Wavelengths) -> Spectrum {
                match self { $(Self::$model(t) => t.eval(x, wl),)* }
            }

            /// The value at x as one number: the luminance of a coloured texture.
            #[inline]
            pub fn eval_scalar(&self, x: &TextureContext) -> f32 {
                match self { $(Self::$model(t) => t.eval_scalar(x),)* }
            }

            /// (∂/∂u, ∂/∂v) of [`Texture::eval_scalar`] at x.
            #[inline]
            pub fn eval_gradient(&self, x: &TextureContext) -> Vec2 {
                match self { $(Self::$model(t) => t.eval_gradient(x),)* }
            }

            /// The mean over the texture's domain.
            pub fn mean(&self, scene: &Scene) -> Spectrum {
                match self { $(Self::$model(t) => t.mean(scene),)* }
            }
        }
    };
}

textures! {
    /// The same everywhere.
    Color,
    /// A picture.
    Bitmap,
    /// Two values in alternating squares.
    Checkerboard,
    /// Data on the vertices or faces of a mesh.
    MeshAttribute,
    /// A texture times another.
    Product,
    /// Between two textures.
    Mix,
    /// Between two textures by the normal.
    DirectionMix,
    /// A texture brighter, darker or negative.
    Adjusted,
    /// A texture laid on in another way.
    Mapped,
    /// Four corners.
    Bilerp,
    /// Sums of noise.
    Noise,
    /// Veined stone.
    Marble,
    /// Disks.
    Dots,
}

impl Texture {
    /// (∂/∂u, ∂/∂v) of [`Texture::eval_scalar`] at x on a surface with ∂p/∂u and ∂p/∂v: exact for pictures, by differences for what is made of
    /// other textures or lies in space.
    pub fn slope(&self, x: &TextureContext, [dp_du, dp_dv]: [Vec3; 2]) -> Vec2 {
        const H: f32 = 5e-4;
        if matches!(self, Self::Color(_) | Self::Bitmap(_) | Self::Checkerboard(_) | Self::MeshAttribute(_)) {
            return self.eval_gradient(x);
        }
        let at = |du: f32, dv: f32| {
            self.eval_scalar(&TextureContext { uv: x.uv + Vec2::new(du, dv), p: x.p + dp_du * du + dp_dv * dv, ..*x })
        };
        Vec2::new(at(H, 0.0) - at(-H, 0.0), at(0.0, H) - at(0.0, -H)) / (2.0 * H)
    }
}
