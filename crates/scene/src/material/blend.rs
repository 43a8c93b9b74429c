//! `blendbsdf`: f = (1 - w) f₀ + w f₁. Parameter `weight` w in [0, 1]; two nested materials.

use super::{Material, Model, Site};
use crate::ids::MaterialId;
use crate::texture::ScalarSlot;
use etendue_bsdf::{Bsdf, Event};

/// Between two materials.
#[derive(Clone, Debug)]
pub struct Blend {
    weight: ScalarSlot,
    nested: [MaterialId; 2],
    events: Event,
    lobes: usize,
}

impl Blend {
    /// From `materials[0]` at weight 0 to `materials[1]` at weight 1, stored at `nested`.
    pub fn new(weight: ScalarSlot, nested: [MaterialId; 2], materials: [&Material; 2]) -> Self {
        let events = materials[0].events() | materials[1].events();
        Self { weight, nested, events, lobes: materials[0].lobes() + materials[1].lobes() }
    }
}

impl Model for Blend {
    fn events(&self) -> Event {
        self.events
    }

    fn lobes(&self) -> usize {
        self.lobes
    }

    fn add<'s>(&'s self, at: &Site<'s, '_>, weight: f32, to: &mut Bsdf<'s>) {
        let w = at.scalar(&self.weight).clamp(0.0, 1.0);
        for (share, material) in [1.0 - w, w].into_iter().zip(self.nested) {
            if share > 0.0 {
                at.add(material, weight * share, to);
            }
        }
    }
}
