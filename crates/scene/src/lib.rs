//! The scene, compiled: every noun of the rendering equation as flat, immutable, typed data.
//!
//! ```text
//! L(x, wo) = Le(x, wo) + ∫ f(wi, x, wo) · L(RT(x, wi), -wi) · cosθ dwi        I = <We, L>
//!            emitter       material       accel: RT(x, w), V(x, y)           sensor
//! ```
//!
//! [`compile()`] turns an inert [`etendue_description::Description`] into a [`Scene`]; after that no text, no name and no span is
//! looked at again. A scene knows nothing of films and of how it will be solved.

pub mod compile;
mod diagnose;
pub mod emitter;
pub mod ids;
pub mod interaction;
pub mod material;
pub mod scene;
pub mod sensor;
pub mod settings;
pub mod shape;
pub mod texture;

pub use compile::{CompileOptions, compile};
pub use emitter::{Emitter, Escape, LightQuery, LightReference, LightSample, Lights, Lone, Seen};
pub use ids::{EmitterId, MaterialId, NO_INSTANCE, SurfaceId, TextureId};
pub use interaction::Interaction;
pub use material::Material;
pub use scene::Scene;
pub use sensor::{CameraRay, Sensor};
pub use settings::{FilmSettings, Integrator, SamplerSettings, View};
pub use shape::{Geometry, Shape, Surface, SurfaceFrame, Triangle};
pub use texture::{ColorSlot, ScalarSlot, Texture, TextureContext};
