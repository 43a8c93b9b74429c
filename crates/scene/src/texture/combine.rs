//! Textures of textures.
//!
//! ```text
//! product        a b
//! mix            (1 - t) a + t b                      t by `amount`
//! directionmix   c a + (1 - c) b                      c = |n · d|, n the shading normal, d `direction`
//! adjusted       max(0, s t), or max(0, 1 - s t) with `invert`
//! mapped         t at the coordinates of a mapping
//! bilerp         the bilinear mean of four corners, by (u', v')
//! ```

use crate::ids::TextureId;
use crate::scene::Scene;
use crate::texture::{ColorSlot, Mapping, ScalarSlot, TextureContext};
use etendue_numerics::{Spectrum, Vec2, Vec3, Wavelengths};

/// The gradient of textures over space, or of others, is taken by differences: see [`super::Texture::slope`].
macro_rules! no_gradient {
    () => {
        /// Zero: see [`super::Texture::slope`].
        #[inline]
        pub fn eval_gradient(&self, _x: &TextureContext) -> Vec2 {
            Vec2::ZERO
        }
    };
}
pub(super) use no_gradient;

/// a b.
#[derive(Clone, Debug)]
pub struct Product {
    /// The texture.
    pub a: ColorSlot,
    /// The factor.
    pub b: ScalarSlot,
}

impl Product {
    /// The value at x.
    pub fn eval(&self, x: &TextureContext, wl: &Wavelengths) -> Spectrum {
        self.a.eval(x, wl) * self.b.eval(x)
    }

    /// The value at x as one number.
    pub fn eval_scalar(&self, x: &TextureContext) -> f32 {
        self.a.eval_scalar(x) * self.b.eval(x)
    }

    no_gradient!();

    /// The product of both means.
    pub fn mean(&self, scene: &Scene) -> Spectrum {
        self.a.mean(scene) * self.b.mean(scene)
    }
}

/// Between two textures.
#[derive(Clone, Debug)]
pub struct Mix {
    /// At amount 0, and at amount 1.
    pub parts: [ColorSlot; 2],
    /// How much of the second.
    pub amount: ScalarSlot,
}

impl Mix {
    /// The value at x.
    pub fn eval(&self, x: &TextureContext, wl: &Wavelengths) -> Spectrum {
        Spectrum::lerp(self.amount.eval(x), self.parts[0].eval(x, wl), self.parts[1].eval(x, wl))
    }

    /// The value at x as one number.
    pub fn eval_scalar(&self, x: &TextureContext) -> f32 {
        let t = self.amount.eval(x);
        (1.0 - t) * self.parts[0].eval_scalar(x) + t * self.parts[1].eval_scalar(x)
    }

    no_gradient!();

    /// By the mean amount.
    pub fn mean(&self, scene: &Scene) -> Spectrum {
        Spectrum::lerp(self.amount.mean(scene), self.parts[0].mean(scene), self.parts[1].mean(scene))
    }
}

/// Between two textures by the normal.
#[derive(Clone, Debug)]
pub struct DirectionMix {
    /// Where the normal is along the direction, and where it is across.
    pub parts: [ColorSlot; 2],
    /// A unit vector of the world.
    pub direction: Vec3,
}

impl DirectionMix {
    fn amount(&self, x: &TextureContext) -> f32 {
        x.n.dot(self.direction).abs().min(1.0)
    }

    /// The value at x.
    pub fn eval(&self, x: &TextureContext, wl: &Wavelengths) -> Spectrum {
        Spectrum::lerp(self.amount(x), self.parts[1].eval(x, wl), self.parts[0].eval(x, wl))
    }

    /// The value at x as one number.
    pub fn eval_scalar(&self, x: &TextureContext) -> f32 {
        let t = self.amount(x);
        t * self.parts[0].eval_scalar(x) + (1.0 - t) * self.parts[1].eval_scalar(x)
    }

    no_gradient!();

    /// Over all normals, |cos| being 1/2 in the mean.
    pub fn mean(&self, scene: &Scene) -> Spectrum {
        (self.parts[0].mean(scene) + self.parts[1].mean(scene)) * 0.5
    }
}

/// A texture brighter, darker or turned into its negative.
#[derive(Clone, Copy, Debug)]
pub struct Adjusted {
    /// The texture.
    pub texture: TextureId,
    /// s.
    pub scale: f32,
    /// 1 - s t.
    pub invert: bool,
}

impl Adjusted {
    fn adjust(&self, t: f32) -> f32 {
        let scaled = self.scale * t;
        (if self.invert { 1.0 - scaled } else { scaled }).max(0.0)
    }

    /// The value at x.
    pub fn eval(&self, x: &TextureContext, wl: &Wavelengths) -> Spectrum {
        x.scene.textures[self.texture.index()].eval(x, wl).map(|t| self.adjust(t))
    }

    /// The value at x as one number.
    pub fn eval_scalar(&self, x: &TextureContext) -> f32 {
        self.adjust(x.scene.textures[self.texture.index()].eval_scalar(x))
    }

    no_gradient!();

    /// The adjusted mean.
    pub fn mean(&self, scene: &Scene) -> Spectrum {
        scene.textures[self.texture.index()].mean(scene).map(|t| self.adjust(t))
    }
}

/// A texture laid on in another way.
#[derive(Clone, Copy, Debug)]
pub struct Mapped {
    /// The texture.
    pub texture: TextureId,
    /// How.
    pub mapping: Mapping,
}

impl Mapped {
    /// The value at x.
    pub fn eval(&self, x: &TextureContext, wl: &Wavelengths) -> Spectrum {
        x.scene.textures[self.texture.index()].eval(&TextureContext { uv: self.mapping.uv(x), ..*x }, wl)
    }

    /// The value at x as one number.
    pub fn eval_scalar(&self, x: &TextureContext) -> f32 {
        x.scene.textures[self.texture.index()].eval_scalar(&TextureContext { uv: self.mapping.uv(x), ..*x })
    }

    no_gradient!();

    /// The texture's own.
    pub fn mean(&self, scene: &Scene) -> Spectrum {
        scene.textures[self.texture.index()].mean(scene)
    }
}

/// Four values at the corners of the unit square.
#[derive(Clone, Debug)]
pub struct Bilerp {
    /// At (u', v') = (0, 0), (0, 1), (1, 0), (1, 1).
    pub corners: [ColorSlot; 4],
    /// Where it is looked up.
    pub mapping: Mapping,
}

impl Bilerp {
    fn weights(&self, x: &TextureContext) -> [f32; 4] {
        let Vec2 { x: u, y: v } = self.mapping.uv(x);
        [(1.0 - u) * (1.0 - v), (1.0 - u) * v, u * (1.0 - v), u * v]
    }

    /// The value at x.
    pub fn eval(&self, x: &TextureContext, wl: &Wavelengths) -> Spectrum {
        self.corners.iter().zip(self.weights(x)).map(|(c, w)| c.eval(x, wl) * w).sum()
    }

    /// The value at x as one number.
    pub fn eval_scalar(&self, x: &TextureContext) -> f32 {
        self.corners.iter().zip(self.weights(x)).map(|(c, w)| c.eval_scalar(x) * w).sum()
    }

    no_gradient!();

    /// The mean of the corners.
    pub fn mean(&self, scene: &Scene) -> Spectrum {
        self.corners.iter().map(|c| c.mean(scene)).sum::<Spectrum>() * 0.25
    }
}
