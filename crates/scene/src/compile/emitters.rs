//! Emitter nodes → [`crate::Emitter`].

use super::Compiler;
use crate::ids::SurfaceId;
use etendue_description::NodeId;

impl Compiler<'_> {
    /// Compiles an emitter: of a surface where one is given, or one that stands alone.
    pub(crate) fn emitter(&mut self, _id: NodeId, _surface: Option<SurfaceId>) {}
}
