//! `mask`: opaque in parts, f = o f' + (1 - o) δ(straight through). Parameter `opacity` o in [0, 1], default 0.5; one nested material.

use super::{Model, Site};
use crate::ids::MaterialId;
use crate::texture::ScalarSlot;
use etendue_bsdf::{Bsdf, Event, lobes};

/// A cut-out.
#[derive(Clone, Debug)]
pub struct Mask {
    opacity: ScalarSlot,
    nested: MaterialId,
    events: Event,
    lobes: usize,
}

impl Mask {
    /// Shows `material`, stored at `nested`, with the given opacity.
    pub fn new(opacity: ScalarSlot, nested: MaterialId, material: &super::Material) -> Self {
        let opaque = matches!(opacity, ScalarSlot::Constant(o) if o >= 1.0);
        let events = if opaque { material.events() } else { material.events() | Event::NULL | Event::DELTA };
        Self { opacity, nested, events, lobes: material.lobes() + usize::from(!opaque) }
    }

    /// o.
    pub fn opacity(&self) -> &ScalarSlot {
        &self.opacity
    }
}

impl Model for Mask {
    fn events(&self) -> Event {
        self.events
    }

    fn lobes(&self) -> usize {
        self.lobes
    }

    fn add<'s>(&'s self, at: &Site<'s, '_>, weight: f32, to: &mut Bsdf<'s>) {
        let opacity = at.scalar(&self.opacity).clamp(0.0, 1.0);
        if opacity > 0.0 {
            at.add(self.nested, weight * opacity, to);
        }
        if opacity < 1.0 {
            to.push(weight * (1.0 - opacity), lobes::Null);
        }
    }
}
