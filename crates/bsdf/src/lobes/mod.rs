//! The scattering models, one file each. Every model has a plain parameter struct with documented defaults and a `new` that cleans
//! what it is given: no NaN, no negative reflectance, no roughness below [`crate::Microfacets::MIN_ALPHA`].

mod coated_diffuse;
mod conductor;
mod dielectric;
mod diffuse;
mod diffuse_transmission;
pub(crate) mod faceted;
mod hair;
mod layered;
mod measured;
mod null;
mod phong;
mod plastic;
mod principled;
mod principled_terms;
mod principled_thin;
mod rough_conductor;
mod rough_dielectric;
mod rough_plastic;
mod thin_dielectric;

pub use coated_diffuse::{CoatedDiffuse, CoatedDiffuseParams};
pub use conductor::{Conductor, ConductorParams};
pub use dielectric::{Dielectric, DielectricParams};
pub use diffuse::{Diffuse, DiffuseParams};
pub use diffuse_transmission::{DiffuseTransmission, DiffuseTransmissionParams};
pub use hair::{Hair, HairParams};
pub use layered::{Ground, Layered, LayeredParams};
pub use measured::{Grid, Measured, MeasuredError, MeasuredParams, MeasuredTable};
pub use null::Null;
pub use phong::{Phong, PhongParams};
pub use plastic::{Plastic, PlasticParams};
pub use principled::{Principled, PrincipledParams, eta_from_specular};
pub use principled_thin::{PrincipledThin, PrincipledThinParams};
pub use rough_conductor::{RoughConductor, RoughConductorParams};
pub use rough_dielectric::{RoughDielectric, RoughDielectricParams};
pub use rough_plastic::{RoughPlastic, RoughPlasticParams};
pub use thin_dielectric::{ThinDielectric, ThinDielectricParams};

/// Air's index of refraction, the exterior where none is named.
pub const AIR: f32 = 1.000_277;
/// BK7 glass, the interior of dielectrics where none is named.
pub const BK7: f32 = 1.5046;
/// Polypropylene, the interior of plastics where none is named.
pub const POLYPROPYLENE: f32 = 1.49;
