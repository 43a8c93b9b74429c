//! Two values in alternating squares.
//!
//! ```text
//! t(u, v) = color0   where frac u' > 1/2 agrees with frac v' > 1/2
//!           color1   elsewhere                                            (u', v') = to_uv(u, v)
//! ```
//!
//! Read as one number instead of a colour (a roughness, a weight), Mitsuba 3 takes the two values the other way round, and its scenes are
//! made with that: `scalar_swaps`.
//!
//! A period of 1 in u' and v' holds two squares each way. A `solid` mapping alternates in z as well. Defaults: `color0` 0.4, `color1` 0.2.

use crate::scene::Scene;
use crate::texture::{ColorSlot, Mapping, TextureContext};
use etendue_numerics::{Spectrum, Vec2, Wavelengths};

/// The parameters of a checkerboard.
#[derive(Clone, Debug)]
pub struct Checkerboard {
    /// Values of the squares; the first holds (u', v') = (0, 0).
    pub color: [ColorSlot; 2],
    /// Where it is looked up: (u', v').
    pub mapping: Mapping,
    /// Whether the values change places where one number is asked for.
    pub scalar_swaps: bool,
}

impl Checkerboard {
    /// Which of the two values lies at `uv`.
    #[inline]
    fn square(&self, x: &TextureContext) -> usize {
        if self.mapping.is_solid() {
            let p = self.mapping.point(x);
            return alternate(&p.to_array());
        }
        alternate(&self.mapping.uv(x).to_array())
    }

    /// The value at x.
    #[inline]
    pub fn eval(&self, x: &TextureContext, wl: &Wavelengths) -> Spectrum {
        self.color[self.square(x)].eval(x, wl)
    }

    /// The value at x as one number.
    #[inline]
    pub fn eval_scalar(&self, x: &TextureContext) -> f32 {
        self.color[self.square(x) ^ usize::from(self.scalar_swaps)].eval_scalar(x)
    }

    /// Zero: the squares are flat, and the steps between them have no gradient.
    #[inline]
    pub fn eval_gradient(&self, _x: &TextureContext) -> Vec2 {
        Vec2::ZERO
    }

    /// The mean of the two values.
    pub fn mean(&self, scene: &Scene) -> Spectrum {
        (self.color[0].mean(scene) + self.color[1].mean(scene)) * 0.5
    }
}

/// 0 in the first cell, 1 in those beside it.
#[inline]
fn alternate(p: &[f32]) -> usize {
    p.iter().filter(|x| **x - x.floor() > 0.5).count() % 2
}

#[cfg(test)]
mod tests {
    use super::alternate;

    #[test]
    fn squares_alternate_and_repeat() {
        for (u, v, first) in [
            (0.1, 0.1, true),
            (0.6, 0.1, false),
            (0.1, 0.6, false),
            (0.6, 0.6, true),
            (1.1, 0.1, true),
            (-0.1, 0.1, false),
            (0.5, 0.1, true),
        ] {
            assert_eq!(alternate(&[u, v]), usize::from(!first), "({u}, {v})");
        }
        assert_eq!(alternate(&[0.6, 0.6, 0.6]), 1);
    }
}
