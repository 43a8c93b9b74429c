//! The closed set of scattering models, listed once.

use crate::lobes::faceted::{self, Faceted, Turn};
use crate::microfacet::facet::Facet;
use crate::{BsdfSample, Event, Microfacets, Scatter, lobes::*};
use etendue_numerics::{Spectrum, Vec2, Vec3};

macro_rules! lobes {
    ($($name:ident $(<$a:lifetime>)?),+ $(,)?) => {
        /// One scattering model with resolved numbers; measured ones look into a table.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Lobe<'a> {
            $(
                #[doc = concat!("[`", stringify!($name), "`]")]
                $name($name $(<$a>)?),
            )+
        }

        $(
            impl<'a> From<$name $(<$a>)?> for Lobe<'a> {
                #[inline]
                fn from(lobe: $name $(<$a>)?) -> Self {
                    Self::$name(lobe)
                }
            }
        )+

        /// The way round for all but the commonest lobe, which is worth having in line where it is called.
        impl Lobe<'_> {
            #[inline(never)]
            fn sample_any(&self, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample> {
                match self { $(Self::$name(lobe) => lobe.sample(wo, u1, u2),)+ }
            }

            #[inline(never)]
            fn eval_pdf_any(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
                match self { $(Self::$name(lobe) => lobe.eval_pdf(wo, wi),)+ }
            }
        }

        impl Scatter for Lobe<'_> {
            #[inline]
            fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
                match self { $(Self::$name(lobe) => lobe.eval(wo, wi),)+ }
            }

            #[inline]
            fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
                match self { $(Self::$name(lobe) => lobe.pdf(wo, wi),)+ }
            }

            #[inline]
            fn sample(&self, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample> {
                match self {
                    Self::Diffuse(lobe) => lobe.sample(wo, u1, u2),
                    _ => self.sample_any(wo, u1, u2),
                }
            }

            #[inline]
            fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
                match self {
                    Self::Diffuse(lobe) => lobe.eval_pdf(wo, wi),
                    _ => self.eval_pdf_any(wo, wi),
                }
            }

            #[inline]
            fn events(&self) -> Event {
                match self { $(Self::$name(lobe) => lobe.events(),)+ }
            }

            fn diracs(&self, wo: Vec3, found: &mut dyn FnMut(BsdfSample)) {
                match self { $(Self::$name(lobe) => lobe.diracs(wo, found),)+ }
            }

            fn albedo(&self, wo: Vec3) -> Spectrum {
                match self { $(Self::$name(lobe) => lobe.albedo(wo),)+ }
            }

            fn diffuse_reflectance(&self) -> Spectrum {
                match self { $(Self::$name(lobe) => lobe.diffuse_reflectance(),)+ }
            }

            fn roughness(&self) -> f32 {
                match self { $(Self::$name(lobe) => lobe.roughness(),)+ }
            }

            fn eta(&self) -> f32 {
                match self { $(Self::$name(lobe) => lobe.eta(),)+ }
            }

            fn transparency(&self, wo: Vec3) -> Spectrum {
                match self { $(Self::$name(lobe) => lobe.transparency(wo),)+ }
            }

            #[inline]
            fn importance(&self) -> f32 {
                match self { $(Self::$name(lobe) => lobe.importance(),)+ }
            }
        }
    };
}

impl Lobe<'_> {
    /// Whether [`Scatter::sample`] looks at its number `u1`.
    #[inline]
    pub fn has_choice(&self) -> bool {
        !matches!(self, Self::Diffuse(_) | Self::Conductor(_) | Self::RoughConductor(_) | Self::Measured(_) | Self::Null(_))
    }

    /// Whether f(wo, wi) belongs to the side of `wo`, and is another where light and eye change places.
    #[inline]
    pub fn is_one_way(&self) -> bool {
        matches!(self, Self::Hair(_))
    }
}

/// The lobes of facets, listed once, and what the others answer.
macro_rules! faceted {
    ($lobe:expr, $l:ident => $answer:expr, $other:expr) => {
        match $lobe {
            Lobe::RoughConductor($l) => $answer,
            Lobe::RoughPlastic($l) => $answer,
            Lobe::RoughDielectric($l) => $answer,
            Lobe::Principled($l) => $answer,
            _ => $other,
        }
    };
}

/// What [`Faceted`] says, where the lobe is one.
impl Lobe<'_> {
    #[inline]
    pub(crate) fn facets(&self) -> Option<(&Microfacets, f32)> {
        faceted!(self, l => Some(l.facets()), None)
    }

    #[inline]
    pub(crate) fn towards(&self, wo: Vec3) -> f32 {
        faceted!(self, l => l.towards(wo), 0.0)
    }

    #[inline]
    pub(crate) fn at(&self, wo: Vec3, towards: f32, wi: Vec3, facet: Option<&Facet>) -> (Spectrum, f32) {
        faceted!(self, l => Faceted::at(l, wo, towards, wi, facet), (Spectrum::ZERO, 0.0))
    }

    #[inline]
    pub(crate) fn turn(&self, wo: Vec3, towards: f32, u1: f32, u2: Vec2, m: Vec3) -> Option<Turn> {
        faceted!(self, l => l.turn(wo, towards, u1, u2, || m), None)
    }

    #[inline]
    pub(crate) fn weigh(&self, wo: Vec3, towards: f32, turn: &Turn, facet: Option<&Facet>) -> Option<BsdfSample> {
        faceted!(self, l => faceted::weigh(l, wo, towards, turn, facet), None)
    }
}

lobes!(
    Diffuse,
    Dielectric,
    ThinDielectric,
    RoughDielectric,
    Conductor,
    RoughConductor,
    Plastic,
    RoughPlastic,
    Principled,
    PrincipledThin,
    Phong,
    CoatedDiffuse,
    Layered,
    DiffuseTransmission,
    Hair,
    Measured<'a>,
    Null,
);
