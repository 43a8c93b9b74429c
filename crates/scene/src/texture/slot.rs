//! Parameters that are either constant or textured, and the constant colour.

use crate::ids::TextureId;
use crate::scene::Scene;
use crate::texture::TextureContext;
use etendue_numerics::spectrum::curve::{self, Curve};
use etendue_numerics::{Spectrum, Vec2, Wavelengths};

/// What a colour stands for: it decides which spectrum is taken for red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// A fraction of light, in [0, 1].
    Reflectance,
    /// A light's radiance, intensity, irradiance.
    Emission,
    /// A number without bounds.
    Unbounded,
}

impl Role {
    /// A colour that was looked up, as the lanes of a walk have it.
    #[inline(always)]
    pub fn spectrum(self, rgb: Spectrum, wl: &Wavelengths) -> Spectrum {
        match wl {
            Wavelengths::Rgb => rgb,
            Wavelengths::Hero(hero) => match self {
                Self::Reflectance => curve::reflectance(rgb.to_rgb(), hero),
                Self::Emission => curve::emission(rgb.to_rgb(), hero),
                Self::Unbounded => curve::unbounded(rgb.to_rgb(), hero),
            },
        }
    }

    /// The spectrum of a colour.
    pub fn curve(self, rgb: [f32; 3]) -> Curve {
        match self {
            Self::Reflectance => Curve::reflectance(rgb),
            Self::Emission => Curve::emission(rgb),
            Self::Unbounded => Curve::unbounded(rgb),
        }
    }
}

/// A colour that does not vary: linear Rec.709 for walks that carry it, and a spectrum for those that carry wavelengths.
#[derive(Clone, Debug, PartialEq)]
pub struct Color {
    rgb: Spectrum,
    curve: Curve,
}

impl Color {
    /// Nothing.
    pub const BLACK: Self = Self::grey(0.0);

    /// Linear Rec.709, and its spectrum.
    #[inline]
    pub const fn new([r, g, b]: [f32; 3], curve: Curve) -> Self {
        Self { rgb: Spectrum::rgb(r, g, b), curve }
    }

    /// Linear Rec.709, with a smooth spectrum for what it stands for.
    pub fn rgb(rgb: [f32; 3], role: Role) -> Self {
        Self::new(rgb, role.curve(rgb))
    }

    /// The same value in each channel, and at each wavelength.
    #[inline]
    pub const fn grey(x: f32) -> Self {
        Self::new([x; 3], Curve::flat(x))
    }

    /// The value at the wavelengths of `wl`.
    #[inline]
    pub fn at(&self, wl: &Wavelengths) -> Spectrum {
        match wl {
            Wavelengths::Rgb => self.rgb,
            Wavelengths::Hero(hero) => self.curve.at(hero),
        }
    }

    /// The linear Rec.709 channels.
    #[inline]
    pub fn to_rgb(&self) -> [f32; 3] {
        self.rgb.to_rgb()
    }

    /// The mean of the three channels: a colour where one number is asked for.
    #[inline]
    pub fn average(&self) -> f32 {
        let [r, g, b] = self.to_rgb();
        // Of a grey exactly the grey.
        if r == g && g == b { r } else { (r + g + b) / 3.0 }
    }

    /// The colour everywhere.
    #[inline]
    pub fn eval(&self, _x: &TextureContext, wl: &Wavelengths) -> Spectrum {
        self.at(wl)
    }

    /// Its average.
    #[inline]
    pub fn eval_scalar(&self, _x: &TextureContext) -> f32 {
        self.average()
    }

    /// Zero.
    #[inline]
    pub fn eval_gradient(&self, _x: &TextureContext) -> Vec2 {
        Vec2::ZERO
    }

    /// The colour.
    pub fn mean(&self, _scene: &Scene) -> Spectrum {
        self.rgb
    }
}

/// A colour-valued parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum ColorSlot {
    /// The same everywhere.
    Constant(Color),
    /// By a texture.
    Texture(TextureId),
}

/// A reflectance.
impl From<[f32; 3]> for ColorSlot {
    fn from(rgb: [f32; 3]) -> Self {
        Self::Constant(Color::rgb(rgb, Role::Reflectance))
    }
}

impl ColorSlot {
    /// The value at x.
    #[inline]
    pub fn eval(&self, x: &TextureContext, wl: &Wavelengths) -> Spectrum {
        match self {
            Self::Constant(c) => c.at(wl),
            Self::Texture(id) => x.scene.textures[id.index()].eval(x, wl),
        }
    }

    /// The value at x as one number.
    #[inline]
    pub fn eval_scalar(&self, x: &TextureContext) -> f32 {
        match self {
            Self::Constant(c) => c.average(),
            Self::Texture(id) => x.scene.textures[id.index()].eval_scalar(x),
        }
    }

    /// The mean over the texture's domain, linear Rec.709.
    pub fn mean(&self, scene: &Scene) -> Spectrum {
        match self {
            Self::Constant(c) => c.mean(scene),
            Self::Texture(id) => scene.textures[id.index()].mean(scene),
        }
    }
}

/// A number-valued parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScalarSlot {
    /// The same everywhere.
    Constant(f32),
    /// By a texture.
    Texture(TextureId),
}

impl ScalarSlot {
    /// The value at x.
    #[inline]
    pub fn eval(&self, x: &TextureContext) -> f32 {
        match self {
            Self::Constant(v) => *v,
            Self::Texture(id) => x.scene.textures[id.index()].eval_scalar(x),
        }
    }

    /// The mean over the texture's domain.
    pub fn mean(&self, scene: &Scene) -> f32 {
        match self {
            Self::Constant(v) => *v,
            Self::Texture(id) => scene.textures[id.index()].mean(scene).luminance(),
        }
    }
}
