//! `bumpmap`, `normalmap`: the nested material in a bent frame.
//!
//! ```text
//! bump:    p_u' = p_u + n (s ∂h/∂u - n·p_u),  p_v' likewise,  n' ∝ ± p_u' × p_v', on the side of the geometric normal
//! normal:  n' ∝ 2 t(u, v) - 1                                                     in the shading frame
//! ```
//!
//! h is the height in the surface's units, s is `scale` (default 1), n the shading normal. The bent frame's x leans towards the shading
//! frame's x.
//!
//! Both: `flip_invalid_normals` (default true) mirrors a bent normal that faces away from the viewer [Schüßler et al. 2017];
//! `use_shadowing_function` (default true) softens the terminator [Conty Estevez, Lecocq, Stein 2019].

use super::{Material, Model, Site};
use crate::ids::{MaterialId, TextureId};
use crate::texture::ColorSlot;
use etendue_bsdf::{Bsdf, Event, Perturbation};
use etendue_numerics::{Frame, Spectrum, Vec3, Wavelengths};

/// How bent normals are treated, and what lies under them.
#[derive(Clone, Copy, Debug)]
pub struct NormalOptions {
    nested: MaterialId,
    events: Event,
    lobes: usize,
    /// Mirror normals that face away from the viewer.
    pub flip_invalid_normals: bool,
    /// Soften the terminator.
    pub use_shadowing_function: bool,
}

impl NormalOptions {
    /// `material`, stored at `nested`, under bent normals.
    pub fn new(nested: MaterialId, material: &Material, flip_invalid_normals: bool, use_shadowing_function: bool) -> Self {
        let (events, lobes) = (material.events(), material.lobes());
        Self { nested, events, lobes, flip_invalid_normals, use_shadowing_function }
    }

    /// Adds the nested material around the normal `n` of the current frame, of any length.
    fn add<'s>(&self, n: Vec3, at: &Site<'s, '_>, weight: f32, to: &mut Bsdf<'s>) {
        let n = if self.flip_invalid_normals { Perturbation::facing(n, at.wo) } else { n };
        let n = n.try_normalize().unwrap_or(Vec3::Z);
        let bent = Frame::from_normal_and_tangent(n, Vec3::X);
        let world = |v| at.frame.to_world(v);
        let frame = Frame { s: world(bent.s), t: world(bent.t), n: world(bent.n) };
        let mark = to.len();
        Site { frame, wo: bent.to_local(at.wo), ..*at }.add(self.nested, weight, to);
        to.perturb_since(mark, &Perturbation::new(bent.n, bent.s, self.use_shadowing_function));
    }
}

/// Normals bent by the gradient of a height.
#[derive(Clone, Debug)]
pub struct BumpMap {
    /// The height, in the surface's units.
    pub height: TextureId,
    /// A factor on the height.
    pub scale: f32,
    /// The rest.
    pub options: NormalOptions,
}

impl BumpMap {
    /// The bent normal in the site's frame.
    fn normal(&self, at: &Site) -> Vec3 {
        let height = &at.textures.scene.textures[self.height.index()];
        let g = self.scale * height.slope(&at.textures, [at.x.dp_du, at.x.dp_dv]);
        let n = at.frame.n;
        let bent = |dp: Vec3, slope: f32| dp + n * (slope - n.dot(dp));
        let m = bent(at.x.dp_du, g.x).cross(bent(at.x.dp_dv, g.y));
        at.frame.to_local(if m.dot(at.x.n) < 0.0 { -m } else { m })
    }
}

impl Model for BumpMap {
    fn events(&self) -> Event {
        self.options.events
    }

    fn lobes(&self) -> usize {
        self.options.lobes
    }

    fn add<'s>(&'s self, at: &Site<'s, '_>, weight: f32, to: &mut Bsdf<'s>) {
        self.options.add(self.normal(at), at, weight, to);
    }
}

/// Normals from a texture.
#[derive(Clone, Debug)]
pub struct NormalMap {
    /// (n + 1)/2 in the shading frame.
    pub normals: ColorSlot,
    /// The rest.
    pub options: NormalOptions,
}

impl Model for NormalMap {
    fn events(&self) -> Event {
        self.options.events
    }

    fn lobes(&self) -> usize {
        self.options.lobes
    }

    fn add<'s>(&'s self, at: &Site<'s, '_>, weight: f32, to: &mut Bsdf<'s>) {
        let n = self.normals.eval(&at.textures, &Wavelengths::Rgb) * 2.0 - Spectrum::ONE;
        self.options.add(Vec3::from(n.to_rgb()), at, weight, to);
    }
}
