//! Data on the vertices or faces of a mesh.
//!
//! ```text
//! t = s · Σ b_i a_i   over the vertices of the triangle (`vertex_…`)          t = s · a of the face (`face_…`)
//! ```
//!
//! s is `scale`, default 1. A surface without an attribute of the name gives 0.

use crate::scene::Scene;
use crate::texture::{Role, TextureContext};
use etendue_numerics::{Spectrum, Vec2, Wavelengths};

/// An attribute by name.
#[derive(Clone, Debug)]
pub struct MeshAttribute {
    name: Box<str>,
    scale: f32,
    /// What its colours stand for.
    pub role: Role,
}

impl MeshAttribute {
    /// The attribute `name`, with its `vertex_` or `face_` prefix, times `scale`, and what it stands for.
    pub fn new(name: &str, scale: f32, role: Role) -> Self {
        Self { name: name.into(), scale, role }
    }

    /// The name.
    pub fn name(&self) -> &str {
        &self.name
    }

    fn channels(&self, x: &TextureContext) -> [f32; 3] {
        let mesh = x.scene.surface(x.surface).shape.mesh();
        let found = mesh.and_then(|m| Some((m, m.attribute_index(&self.name)?)));
        found.map_or([0.0; 3], |(m, i)| m.attribute(i, x.primitive, x.bary).map(|v| self.scale * v))
    }

    /// The value at x; a one-channel attribute gives equal channels.
    #[inline]
    pub fn eval(&self, x: &TextureContext, wl: &Wavelengths) -> Spectrum {
        let [r, g, b] = self.channels(x);
        self.role.spectrum(Spectrum::rgb(r, g, b), wl)
    }

    /// The luminance at x.
    #[inline]
    pub fn eval_scalar(&self, x: &TextureContext) -> f32 {
        let [r, g, b] = self.channels(x);
        if r == g && g == b { r } else { Spectrum::rgb(r, g, b).luminance() }
    }

    /// Zero: attributes bear no bumps.
    #[inline]
    pub fn eval_gradient(&self, _x: &TextureContext) -> Vec2 {
        Vec2::ZERO
    }

    /// The scale: the mean depends on the surface, and a guess in its place serves for choosing among lights alone.
    pub fn mean(&self, _scene: &Scene) -> Spectrum {
        Spectrum::rgb(self.scale, self.scale, self.scale)
    }
}
