//! Patches: what the radiosity equation counts.
//!
//! ```text
//! B_i = Be_i + ρ_i Σ_j F_ij B_j        a patch i is one side of one cell of a surface
//! ```
//!
//! | symbol | identifier | unit |
//! | --- | --- | --- |
//! | A_i | [`Patch::area`] | m², exact |
//! | n_i | [`Patch::n`] | unit normal in its middle, on its side |
//! | ρ_i | [`Patch::rho`] | hemispherical reflectance, mean over the patch |
//! | Be_i | [`Patch::be`] | emitted radiosity π Le, W/m², mean over the patch |
//!
//! The winding of a mesh, or the normal of a shape, is its front. A side is a patch if it is a front, if it reflects or emits, or if the caller
//! wants both sides ([`Sides`]); a back that is no patch absorbs what arrives. So does a side that no light reaches (`dark.rs`).
//!
//! From surfaces to patches:
//!
//! 1. Each surface, once for each instance that shows it, is an [`Object`] of [`Chart`]s: triangles, pairs of triangles that make a flat
//!    convex quadrilateral, or a round shape, exact ([`chart`]).
//! 2. Each chart is cut into cells near a target size ([`grid`]). A cell may be cut into four again ([`Patches::subdivided`]).
//! 3. Each cell has a patch on one side or on two. Patches are numbered in the order of objects, charts, cells, sides.
//!
//! A hit finds its patch by the way back ([`Patches::locate`]).

pub mod chart;
mod contacts;
mod cut;
mod dark;
mod faults;
pub mod grid;
mod locate;
mod optics;
mod pieces;
mod points;
pub mod round;
pub mod span;
mod vertices;

pub use chart::Chart;
pub use cut::{Cutting, PatchSize, Sides, TooMany};
pub use faults::{Facet, Fault};
pub use locate::Place;
pub use optics::NotDiffuse;
pub use points::PatchPoint;
pub use span::Span;
pub use vertices::{Hanging, Vertices};

use etendue_numerics::Spectrum;
use etendue_scene::SurfaceId;
use glam::DVec3;
use grid::Grid;
use std::collections::BTreeMap;
use std::ops::Range;

/// Stands for "no patch" and "no child".
pub(crate) const NONE: u32 = u32::MAX;

/// Which side of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Where the normal points.
    Front,
    /// The other.
    Back,
}

impl Side {
    /// +1 in front, -1 behind.
    #[inline]
    pub fn sign(self) -> f64 {
        if self == Self::Front { 1.0 } else { -1.0 }
    }

    /// The other one.
    #[inline]
    #[must_use]
    pub fn opposite(self) -> Self {
        if self == Self::Front { Self::Back } else { Self::Front }
    }
}

/// One side of one cell.
#[derive(Clone, Debug)]
pub struct Patch {
    /// The cell, an index of [`Patches::cells`].
    pub cell: u32,
    /// Its side.
    pub side: Side,
    /// The object, an index of [`Patches::objects`].
    pub object: u32,
    /// A_i, m².
    pub area: f64,
    /// A point in its midst: of flat ones the centroid.
    pub p: DVec3,
    /// Unit normal there, on the patch's side.
    pub n: DVec3,
    /// Hemispherical reflectance ρ, mean over the patch.
    pub rho: Spectrum,
    /// Emitted radiosity Be = π Le, W/m², mean over the patch.
    pub be: Spectrum,
    /// How far from its points a ray must start to be clear of the surface, m.
    pub clearance: f32,
}

/// A surface in its place.
#[derive(Clone, Debug)]
pub struct Object {
    /// The surface.
    pub surface: SurfaceId,
    /// The instance that shows it, or [`NO_INSTANCE`](etendue_scene::NO_INSTANCE).
    pub instance: u32,
    /// Its charts, indices of [`Patches::charts`].
    pub charts: Range<u32>,
    /// Its patches.
    pub patches: Range<u32>,
    /// Of a mesh, the place of its first triangle in the list of facets.
    facets: Option<u32>,
    /// Rays pass as if it were not there.
    pub is_clear: bool,
}

/// A chart with what leads to and from it.
#[derive(Clone, Debug)]
pub struct ChartEntry {
    /// The geometry.
    pub chart: Chart,
    /// Whether parameters are in step with area.
    pub even: bool,
    /// Its object.
    pub object: u32,
    /// The triangles of the mesh that it is made of: one twice, or two.
    pub triangles: [u32; 2],
    /// How it is cut.
    pub grid: Grid,
    /// The first of its cells.
    pub first_cell: u32,
}

/// A part of a chart; a leaf unless it has been cut into four.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// The chart.
    pub chart: u32,
    /// Which part.
    pub span: Span,
    /// The first of four cells that it was cut into.
    children: u32,
    /// Patches on the front and on the back.
    patches: [u32; 2],
}

impl Cell {
    /// Whether it has not been cut.
    #[inline]
    pub fn is_leaf(&self) -> bool {
        self.children == NONE
    }

    /// How many of its sides are patches.
    pub fn sides(&self) -> usize {
        self.patches.iter().filter(|p| **p != NONE).count()
    }

    /// The patch on a side.
    #[inline]
    pub fn patch(&self, side: Side) -> Option<u32> {
        let patch = self.patches[usize::from(side == Side::Back)];
        (patch != NONE).then_some(patch)
    }
}

/// A triangle of a mesh: its chart, and which corners of the chart its own are.
#[derive(Clone, Copy, Debug)]
struct Corners {
    chart: u32,
    corners: [u8; 3],
}

/// The patches of a scene.
#[derive(Clone, Debug)]
pub struct Patches {
    /// Surfaces in their places.
    pub objects: Vec<Object>,
    /// Geometry.
    pub charts: Vec<ChartEntry>,
    /// Parts of charts.
    pub cells: Vec<Cell>,
    /// One side of each leaf, or both.
    pub patches: Vec<Patch>,
    /// Surfaces that are not diffuse, and what was made of them.
    pub not_diffuse: Vec<NotDiffuse>,
    /// Surfaces that cannot be cut: they are black obstacles.
    pub obstacles: Vec<SurfaceId>,
    /// What is wrong with the surfaces.
    pub faults: Vec<Fault>,
    /// For patches that others cover face to face: which, and where.
    contacts: BTreeMap<u32, Vec<contacts::Contact>>,
    /// Of each object the volume that it encloses, m³, negative where fronts are inside; zero where it encloses none.
    volumes: Vec<f64>,
    facets: Vec<Corners>,
    /// For each instance the number of its first object.
    instance_objects: Vec<u32>,
    /// For each surface its object, or of an instanced one its place within the group.
    surface_objects: Vec<u32>,
    /// Sides that are patches, by surface.
    sides: Vec<[bool; 2]>,
}

impl Patches {
    /// How many.
    pub fn len(&self) -> usize {
        self.patches.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.patches.is_empty()
    }

    /// Patch i.
    #[inline]
    pub fn get(&self, i: u32) -> &Patch {
        &self.patches[i as usize]
    }

    /// The cell and the chart of patch i.
    #[inline]
    pub fn geometry(&self, i: u32) -> (&Span, &Chart) {
        let cell = &self.cells[self.get(i).cell as usize];
        (&cell.span, &self.charts[cell.chart as usize].chart)
    }

    /// The triangles of its mesh that patch i lies on: one twice, or two; 0 of what is no mesh.
    pub fn triangles_of(&self, i: u32) -> [u32; 2] {
        self.charts[self.cells[self.get(i).cell as usize].chart as usize].triangles
    }
}
