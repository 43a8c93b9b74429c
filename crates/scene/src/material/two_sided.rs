//! `twosided`: one material on the front, and the same or a second one on the back. None of them may transmit.

use super::{Material, Model, Site};
use crate::ids::MaterialId;
use etendue_bsdf::{Bsdf, Event};
use etendue_numerics::Vec3;

/// A surface with two fronts.
#[derive(Clone, Debug)]
pub struct TwoSided {
    nested: [MaterialId; 2],
    events: Event,
    lobes: usize,
}

impl TwoSided {
    /// `materials` on the front and on the back, stored at `nested`.
    pub fn new(nested: [MaterialId; 2], materials: [&Material; 2]) -> Self {
        let events = materials[0].events() | materials[1].events();
        Self { nested, events, lobes: materials[0].lobes().max(materials[1].lobes()) }
    }
}

impl TwoSided {
    /// The material, where front and back share it.
    #[inline]
    pub(super) fn same_on_both_sides(&self) -> Option<MaterialId> {
        let [front, back] = self.nested;
        (front == back).then_some(front)
    }
}

impl Model for TwoSided {
    fn events(&self) -> Event {
        self.events
    }

    fn lobes(&self) -> usize {
        self.lobes
    }

    fn add<'s>(&'s self, at: &Site<'s, '_>, weight: f32, to: &mut Bsdf<'s>) {
        if at.wo.z >= 0.0 {
            return at.add(self.nested[0], weight, to);
        }
        let mark = to.len();
        let wo = Vec3::new(at.wo.x, at.wo.y, -at.wo.z);
        Site { wo, ..*at }.add(self.nested[1], weight, to);
        to.flip_since(mark);
    }
}
