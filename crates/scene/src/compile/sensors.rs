//! Sensor nodes with their films, filters and samplers → [`crate::View`].

use super::Compiler;
use etendue_description::NodeId;

impl Compiler<'_> {
    /// Compiles a sensor.
    pub(crate) fn sensor(&mut self, _id: NodeId) {}
}
