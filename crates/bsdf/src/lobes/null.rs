//! Nothing there: wi = -wo with weight 1. Masks are made of it.

use crate::{BsdfSample, Event, Scatter, local::dirac};
use etendue_numerics::{Spectrum, Vec2, Vec3};

/// Light passes as if there were no surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Null;

impl Scatter for Null {
    fn eval(&self, _wo: Vec3, _wi: Vec3) -> Spectrum {
        Spectrum::ZERO
    }

    fn pdf(&self, _wo: Vec3, _wi: Vec3) -> f32 {
        0.0
    }

    fn sample(&self, wo: Vec3, _u1: f32, _u2: Vec2) -> Option<BsdfSample> {
        dirac(-wo, Spectrum::ONE, 1.0, 1.0, Event::NULL)
    }

    fn diracs(&self, wo: Vec3, found: &mut dyn FnMut(BsdfSample)) {
        dirac(-wo, Spectrum::ONE, 1.0, 1.0, Event::NULL).into_iter().for_each(found);
    }

    fn events(&self) -> Event {
        Event::NULL | Event::DELTA
    }

    fn albedo(&self, _wo: Vec3) -> Spectrum {
        Spectrum::ONE
    }

    fn roughness(&self) -> f32 {
        0.0
    }

    fn transparency(&self, _wo: Vec3) -> Spectrum {
        Spectrum::ONE
    }

    fn importance(&self) -> f32 {
        1.0
    }
}
