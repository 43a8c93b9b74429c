//! The graphics state: what directives change and attribute blocks restore.

use super::spectra::ColourSpace;
use super::values::{Entry, List};
use etendue_description::{NodeId, Span};
use glam::DMat4;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The transforms at the start and at the end of the shutter's time.
pub(super) type Pair = [DMat4; 2];

/// Named coordinate systems.
pub(super) type CoordinateSystems = BTreeMap<String, Pair>;

/// What `Attribute` may set defaults for.
pub(super) const TARGETS: [&str; 5] = ["shape", "light", "material", "medium", "texture"];

/// The graphics state.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// From the current coordinates into the world (before `WorldBegin`: into the camera's).
    pub ctm: Pair,
    /// Which of both transforms change.
    pub active: [bool; 2],
    pub reverse_orientation: bool,
    pub space: ColourSpace,
    /// The current material, and whether it is `interface`.
    pub material: Option<NodeId>,
    /// The light that shapes carry.
    pub area_light: Option<Arc<List>>,
    /// The names of the media inside and outside of shapes, and where they were given.
    pub media: Option<Arc<([String; 2], Span)>>,
    /// Defaults of parameters, in the order of [`TARGETS`].
    pub defaults: [Arc<Vec<Entry>>; 5],
}

impl Default for State {
    fn default() -> Self {
        Self {
            ctm: [DMat4::IDENTITY; 2],
            active: [true; 2],
            reverse_orientation: false,
            space: ColourSpace::default(),
            material: None,
            area_light: None,
            media: None,
            defaults: std::array::from_fn(|_| Arc::new(Vec::new())),
        }
    }
}

impl State {
    /// Multiplies the active transforms from the right.
    pub fn apply(&mut self, m: DMat4) {
        for i in 0..2 {
            if self.active[i] {
                self.ctm[i] *= m;
            }
        }
    }

    /// Whether things move.
    pub fn moves(&self) -> bool {
        self.ctm[0] != self.ctm[1]
    }
}

/// What a block restores when it ends.
#[derive(Clone, Debug)]
pub(super) struct Scope {
    pub kind: ScopeKind,
    pub state: State,
    pub span: Span,
}

/// The kinds of blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ScopeKind {
    Attribute,
    Transform,
    Object,
}

impl ScopeKind {
    pub fn begin(self) -> &'static str {
        match self {
            Self::Attribute => "AttributeBegin",
            Self::Transform => "TransformBegin",
            Self::Object => "ObjectBegin",
        }
    }

    pub fn end(self) -> &'static str {
        match self {
            Self::Attribute => "AttributeEnd",
            Self::Transform => "TransformEnd",
            Self::Object => "ObjectEnd",
        }
    }
}
