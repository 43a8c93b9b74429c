//! The scene as inert data: what a file says, with the place where it says it.
//!
//! A [`Description`] is a forest of [`Node`]s (shapes, materials, emitters, sensors, textures, integrators, …), each with a
//! model name and parameters in étendue's vocabulary, which is Mitsuba 3's with extensions. Readers make descriptions, the
//! scene compiler consumes them through [`Params`], which reports every mistake at its place and goes on, so that all errors of a
//! file are told in one go. Nothing here renders, and nothing that renders keeps any of this.

pub mod asset;
pub mod diagnostic;
pub mod node;
pub mod params;
mod render;
pub mod source;

pub use asset::{Assets, Attribute, AttributeKind, GridData, Group, MeasuredData, MeshData, TableData};
pub use diagnostic::{Diagnostic, Diagnostics, Severity, nearest};
pub use node::{Description, Dialect, Kind, Node, NodeId, Param, SpectrumValue, Value};
pub use params::Params;
pub use source::{SourceId, Sources, Span, Spanned};
