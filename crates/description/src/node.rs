//! Nodes, parameters, values.

use crate::asset::Assets;
use crate::source::{Sources, Span, Spanned};
use etendue_numerics::Transform;
use glam::DVec3;
use std::path::PathBuf;

/// What a file describes, in the order in which it describes it.
#[derive(Clone, Debug, Default)]
pub struct Description {
    /// All nodes; a [`NodeId`] is an index here.
    pub nodes: Vec<Node>,
    /// The scene's own children, in file order: integrator, sensors, shapes, emitters, and shared materials and textures.
    pub top: Vec<NodeId>,
    /// Meshes and grids that the nodes name.
    pub assets: Assets,
    /// The texts, for messages.
    pub sources: Sources,
    /// Whose rules hold where formats differ.
    pub dialect: Dialect,
}

/// The format that a description came from, where its rules matter to what is rendered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dialect {
    /// Mitsuba 3: passing a null or mask surface counts as an edge of the path in `path`.
    #[default]
    Mitsuba,
    /// pbrt-v4: passing an interface does not count.
    Pbrt,
}

/// A node of the description.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub u32);

/// What sort of thing a node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// The way to solve the rendering equation.
    Integrator,
    /// A camera.
    Sensor,
    /// A camera's film.
    Film,
    /// A reconstruction filter.
    Filter,
    /// A point set.
    Sampler,
    /// A surface.
    Shape,
    /// A surface's scattering.
    Bsdf,
    /// A light.
    Emitter,
    /// A texture or spectrum that varies.
    Texture,
    /// A participating medium.
    Medium,
    /// A phase function.
    Phase,
    /// A volume of data.
    Volume,
}

impl Kind {
    /// The word that formats use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Integrator => "integrator",
            Self::Sensor => "sensor",
            Self::Film => "film",
            Self::Filter => "rfilter",
            Self::Sampler => "sampler",
            Self::Shape => "shape",
            Self::Bsdf => "bsdf",
            Self::Emitter => "emitter",
            Self::Texture => "texture",
            Self::Medium => "medium",
            Self::Phase => "phase",
            Self::Volume => "volume",
        }
    }
}

/// A thing with a model and parameters.
#[derive(Clone, Debug)]
pub struct Node {
    /// What sort of thing.
    pub kind: Kind,
    /// Which model: `roughconductor`, `sphere`, `path`.
    pub model: Spanned<String>,
    /// The name it was given in the file, if any.
    pub id: Option<Spanned<String>>,
    /// Parameters and children, in file order; a child without a name has the empty name.
    pub params: Vec<Param>,
    /// The whole node.
    pub span: Span,
}

/// A named value.
#[derive(Clone, Debug)]
pub struct Param {
    /// The name; empty for a child that was given none.
    pub name: Spanned<String>,
    /// The value, with its own place.
    pub value: Spanned<Value>,
}

/// A value of any type that files know.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A truth value.
    Bool(bool),
    /// A whole number.
    Integer(i64),
    /// A real number.
    Float(f64),
    /// A text.
    String(String),
    /// A file, resolved against the file that names it and the search paths; it existed when it was read.
    Path(PathBuf),
    /// A point or a vector.
    Vector(DVec3),
    /// Linear Rec.709.
    Rgb([f64; 3]),
    /// A spectrum.
    Spectrum(SpectrumValue),
    /// A map of space.
    Transform(Box<Transform>),
    /// Another node: nested, or named by a reference.
    Node(NodeId),
    /// A mesh among the assets.
    Mesh(u32),
    /// A grid among the assets.
    Grid(u32),
    /// A measured material among the assets.
    Measured(u32),
}

/// A spectrum as files write it.
#[derive(Clone, Debug, PartialEq)]
pub enum SpectrumValue {
    /// The same value at every wavelength.
    Constant(f64),
    /// (nm, value) pairs with rising wavelengths, linear between them, zero outside.
    Samples(Vec<(f64, f64)>),
    /// Planck's law at a temperature in kelvin, times a scale.
    Blackbody {
        /// Temperature in K.
        kelvin: f64,
        /// Unitless factor.
        scale: f64,
    },
}

impl Value {
    /// The type's name, for messages.
    pub fn type_name(&self) -> &'static str {
        match self {
            Self::Bool(_) => "boolean",
            Self::Integer(_) => "integer",
            Self::Float(_) => "float",
            Self::String(_) => "string",
            Self::Path(_) => "file",
            Self::Vector(_) => "vector",
            Self::Rgb(_) => "rgb",
            Self::Spectrum(_) => "spectrum",
            Self::Transform(_) => "transform",
            Self::Node(_) => "object",
            Self::Mesh(_) => "mesh",
            Self::Grid(_) => "grid",
            Self::Measured(_) => "measured material",
        }
    }
}

impl Description {
    /// The node of an id.
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.0 as usize]
    }

    /// Adds a node.
    pub fn add(&mut self, node: Node) -> NodeId {
        self.nodes.push(node);
        NodeId(self.nodes.len() as u32 - 1)
    }
}
