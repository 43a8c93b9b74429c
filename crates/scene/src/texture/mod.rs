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
mod mesh_attribute;
mod slot;
mod texels;
mod uv;

pub use bitmap::{Bitmap, FilterMode, WrapMode};
pub use checkerboard::Checkerboard;
pub use mesh_attribute::MeshAttribute;
pub use slot::{Color, ColorSlot, Role, ScalarSlot};
pub use texels::Texels;
pub use uv::UvMap;

use crate::ids::SurfaceId;
use crate::scene::Scene;
use etendue_numerics::{Spectrum, Vec2, Wavelengths};

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
}
