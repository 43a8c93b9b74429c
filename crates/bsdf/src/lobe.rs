//! The closed set of scattering models, listed once.

use crate::{BsdfSample, Event, Scatter, lobes::*};
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
