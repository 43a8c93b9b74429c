//! Materials: f over a surface, with textures.
//!
//! ```text
//! f(·, x, ·) = material(x): textures are looked up once a hit, and what comes out is a Bsdf of numbers only
//! ```
//!
//! Blends, masks, two-sided surfaces, bump and normal maps are resolved here: a [`Bsdf`] is a sum of weighted lobes, each in a frame of
//! its own. A model is one file (or shares one with its sibling), one line in the list below and one in `compile/materials.rs`.
//!
//! | question | answer |
//! | --- | --- |
//! | [`Material::evaluate`] | f at an interaction |
//! | [`Material::events`] | everything that the material may do anywhere, known without a hit |
//! | [`Material::lobes`] | the most lobes that it makes, at most [`Bsdf::MAX_LOBES`] |

mod blend;
mod coated;
mod conductor;
mod dielectric;
mod diffuse;
mod diffuse_transmission;
mod hair;
mod mask;
mod measured;
mod null;
mod perturbed;
mod phong;
mod plastic;
mod principled;
mod roughness;
mod two_sided;

pub use blend::Blend;
pub use coated::{CoatedDiffuse, LayerGround, LayerRoughness, Layered};
pub use conductor::{Conductor, RoughConductor};
pub use dielectric::{Dielectric, RoughDielectric, ThinDielectric};
pub use diffuse::Diffuse;
pub use diffuse_transmission::DiffuseTransmission;
pub use hair::{Hair, Pigment};
pub use mask::Mask;
pub use measured::Measured;
pub use null::Null;
pub use perturbed::{BumpMap, NormalMap, NormalOptions};
pub use phong::Phong;
pub use plastic::{Plastic, RoughPlastic};
pub use principled::{Principled, PrincipledCommon, PrincipledThin};
pub use roughness::Roughness;
pub use two_sided::TwoSided;

use crate::ids::MaterialId;
use crate::interaction::Interaction;
use crate::scene::Scene;
use crate::texture::{ColorSlot, ScalarSlot, TextureContext};
use etendue_bsdf::{Bsdf, Event, Lobe};
use etendue_numerics::{Frame, Spectrum, Vec3, Wavelengths};

/// Where a material is evaluated, as it seems to a model that others may enclose.
#[derive(Clone, Copy, Debug)]
pub struct Site<'s, 'x> {
    /// The point.
    pub x: &'x Interaction,
    /// The same for textures.
    pub textures: TextureContext<'s>,
    /// What the lanes of spectra stand for.
    pub wl: &'x Wavelengths,
    /// The shading frame, turned by enclosing bump and normal maps.
    pub frame: Frame,
    /// The given direction in that frame, seen from above on the back of a two-sided surface.
    pub wo: Vec3,
}

impl<'s> Site<'s, '_> {
    #[inline]
    fn color(&self, slot: &ColorSlot) -> Spectrum {
        slot.eval(&self.textures, self.wl)
    }

    #[inline]
    fn scalar(&self, slot: &ScalarSlot) -> f32 {
        slot.eval(&self.textures)
    }

    /// Adds `weight` times a material of the scene.
    fn add(&self, material: MaterialId, weight: f32, to: &mut Bsdf<'s>) {
        self.textures.scene.material(material).add(self, weight, to);
    }
}

/// A material that is one lobe.
pub(crate) trait Single {
    /// Everything that the lobe may do.
    fn events(&self) -> Event;
    /// The lobe at a site.
    fn lobe(&self, at: &Site) -> Lobe<'_>;
}

/// What every material answers.
pub(crate) trait Model {
    /// Everything that the material may do anywhere.
    fn events(&self) -> Event;
    /// The most lobes that it adds.
    fn lobes(&self) -> usize;
    /// Adds `weight` times the material at a site.
    fn add<'s>(&'s self, at: &Site<'s, '_>, weight: f32, to: &mut Bsdf<'s>);
    /// The material at a site, alone.
    #[inline]
    fn bsdf<'s>(&'s self, at: &Site<'s, '_>) -> Bsdf<'s> {
        let mut bsdf = Bsdf::new();
        self.add(at, 1.0, &mut bsdf);
        bsdf
    }
}

impl<S: Single> Model for S {
    #[inline]
    fn events(&self) -> Event {
        Single::events(self)
    }

    #[inline]
    fn lobes(&self) -> usize {
        1
    }

    #[inline]
    fn add<'s>(&'s self, at: &Site<'s, '_>, weight: f32, to: &mut Bsdf<'s>) {
        // Room was counted when the material was compiled.
        to.push(weight, self.lobe(at));
    }

    #[inline]
    fn bsdf<'s>(&'s self, at: &Site<'s, '_>) -> Bsdf<'s> {
        Bsdf::from(self.lobe(at))
    }
}

macro_rules! materials {
    ($($(#[$doc:meta])* $model:ident),* $(,)?) => {
        /// A material of any model.
        #[derive(Clone, Debug)]
        pub enum Material {
            $($(#[$doc])* $model($model),)*
        }

        $(impl From<$model> for Material {
            fn from(model: $model) -> Self {
                Self::$model(model)
            }
        })*

        impl Material {
            /// Everything that the material may do anywhere: `has_smooth`, `has_delta`, `transmits`, `has_null` tell what a solver needs.
            pub fn events(&self) -> Event {
                match self { $(Self::$model(m) => Model::events(m),)* }
            }

            /// The model's name.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$model(_) => stringify!($model),)* }
            }

            /// The most lobes that it makes.
            pub fn lobes(&self) -> usize {
                match self { $(Self::$model(m) => Model::lobes(m),)* }
            }

            #[inline]
            fn add<'s>(&'s self, at: &Site<'s, '_>, weight: f32, to: &mut Bsdf<'s>) {
                match self { $(Self::$model(m) => m.add(at, weight, to),)* }
            }

            #[inline]
            fn bsdf<'s>(&'s self, at: &Site<'s, '_>) -> Bsdf<'s> {
                match self { $(Self::$model(m) => m.bsdf(at),)* }
            }
        }
    };
}

materials! {
    /// Lambert.
    Diffuse,
    /// Smooth interface between two dielectrics.
    Dielectric,
    /// A pane of glass without thickness.
    ThinDielectric,
    /// Rough interface between two dielectrics.
    RoughDielectric,
    /// Polished metal.
    Conductor,
    /// Rough metal.
    RoughConductor,
    /// Smooth varnish over a diffuse base.
    Plastic,
    /// Rough varnish over a diffuse base.
    RoughPlastic,
    /// Artist's parameters, for solids.
    Principled,
    /// Artist's parameters, for sheets.
    PrincipledThin,
    /// Diffuse and a cosine power around the mirror direction.
    Phong,
    /// A diffuse ground under a layer.
    CoatedDiffuse,
    /// Any ground under any layer.
    Layered,
    /// Diffuse to both sides.
    DiffuseTransmission,
    /// Fibres.
    Hair,
    /// As it was measured.
    Measured,
    /// Nothing there.
    Null,
    /// Opaque in parts.
    Mask,
    /// Between two materials.
    Blend,
    /// The same, or another, on the back.
    TwoSided,
    /// Normals bent by the gradient of a height.
    BumpMap,
    /// Normals from a texture.
    NormalMap,
}

impl Material {
    /// f(·, x, ·): the material at x, seen from `x.wo`, with its textures looked up.
    #[inline]
    pub fn evaluate<'s>(&'s self, scene: &'s Scene, x: &Interaction, wl: &Wavelengths) -> Bsdf<'s> {
        let frame = x.shading;
        let at = Site { x, textures: scene.texture_context(x), wl, frame, wo: frame.to_local(x.wo) };
        self.bsdf(&at)
    }

    /// [`Material::evaluate`] into an empty `Bsdf`, where it stays: moving one costs as much as filling it.
    #[inline]
    pub fn evaluate_into<'s>(&'s self, scene: &'s Scene, x: &Interaction, wl: &Wavelengths, to: &mut Bsdf<'s>) {
        let frame = x.shading;
        self.add(&Site { x, textures: scene.texture_context(x), wl, frame, wo: frame.to_local(x.wo) }, 1.0, to);
    }

    /// ρ of a surface that is Lambert's, and whether its back is a front as well; `None` for all others. What drivers of many walks treat on lanes.
    #[inline]
    pub fn lambert<'a>(&'a self, scene: &'a Scene) -> Option<(&'a ColorSlot, bool)> {
        match self {
            Self::Diffuse(diffuse) => Some((&diffuse.reflectance, false)),
            Self::TwoSided(t) => match scene.material(t.same_on_both_sides()?) {
                Self::Diffuse(diffuse) => Some((&diffuse.reflectance, true)),
                _ => None,
            },
            _ => None,
        }
    }

    /// Whether light may pass straight through, as if nothing were there.
    #[inline]
    pub fn may_be_transparent(&self) -> bool {
        self.events().has_null()
    }

    /// Whether all that it does is Dirac: next event estimation finds nothing here.
    pub fn is_delta(&self) -> bool {
        self.events().has_delta() && !self.events().has_smooth()
    }
}
