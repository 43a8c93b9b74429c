//! Numbers, and not one rendering word: vectors, frames, rays, bounds, transforms, measures, warps, tables, sequences, spectra.
//!
//! Everything above stands on this crate, so nothing here may know what a light or a camera is. What a routine
//! needs of chance comes in as uniform numbers in [0, 1); nothing here owns a generator.

pub mod bounds;
pub mod elementary;
pub mod frame;
pub mod kernel;
pub mod math;
pub mod measure;
pub mod net;
pub mod primary;
pub mod ray;
pub mod sequence;
pub mod spectrum;
pub mod table;
pub mod transform;
pub mod warp;
pub mod wide;

pub use bounds::Bounds3;
pub use frame::Frame;
pub use glam::{DAffine3, DMat4, DVec2, DVec3, Vec2, Vec3, Vec4};
pub use measure::Pdf;
pub use net::Net4;
pub use primary::{Numbers, Primary};
pub use ray::Ray;
pub use sequence::{Dim, Sampler, SequenceKind};
pub use spectrum::{Hero, SampledSpectrum, Spectrum, Wavelengths};
pub use transform::Transform;
