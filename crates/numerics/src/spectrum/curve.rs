//! Spectra that are ready to be evaluated.
//!
//! ```text
//! C(λ) = scale · shape(λ) · (D65(λ) where it is lit by it),    shape: 1, a smooth one of a colour, or a table of 1 nm
//! ```

use super::upsample::Smooth;
use super::{Hero, Spectrum, cie};
use glam::Vec4;
use std::sync::Arc;

/// A spectrum.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    scale: f32,
    shape: Shape,
    /// Whether the illuminant D65 is a factor.
    lit: bool,
}

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    Flat,
    Smooth(Smooth),
    Measured(Arc<[f32; ENTRIES]>),
}

/// Entries of a table, 1 nm apart.
const ENTRIES: usize = (cie::LAMBDA_MAX - cie::LAMBDA_MIN) as usize + 1;

impl Curve {
    /// The same value everywhere.
    pub const fn flat(value: f32) -> Self {
        Self { scale: value, shape: Shape::Flat, lit: false }
    }

    /// The smooth spectrum of a reflectance, linear Rec.709; one that exceeds 1 is taken as one without bounds.
    pub fn reflectance(rgb: [f32; 3]) -> Self {
        let largest = largest(rgb);
        if largest > 1.0 { Self::unbounded(rgb) } else { Self::smooth(rgb, 1.0) }
    }

    /// The smooth spectrum of a quantity without bounds; none of the channels counts as negative.
    pub fn unbounded(rgb: [f32; 3]) -> Self {
        Self::smooth(rgb, 2.0 * largest(rgb))
    }

    /// The smooth spectrum of emission: the same times D65, so that white is that of Rec.709.
    pub fn emission(rgb: [f32; 3]) -> Self {
        Self { lit: true, ..Self::unbounded(rgb) }
    }

    fn smooth(rgb: [f32; 3], scale: f32) -> Self {
        let [r, g, b] = rgb;
        if r == g && g == b {
            return Self::flat(r);
        }
        Self { scale, shape: Shape::Smooth(Smooth::fit(rgb.map(|x| x / scale))), lit: false }
    }

    /// What `value` says of each wavelength in nm.
    pub fn measured(value: impl Fn(f64) -> f64) -> Self {
        let table = std::array::from_fn(|i| value(cie::LAMBDA_MIN + i as f64) as f32);
        Self { scale: 1.0, shape: Shape::Measured(Arc::new(table)), lit: false }
    }

    /// The values at four wavelengths.
    #[inline]
    pub fn at(&self, hero: &Hero) -> Spectrum {
        let shape = match &self.shape {
            Shape::Flat => Vec4::ONE,
            Shape::Smooth(smooth) => smooth.at(hero.nm()),
            Shape::Measured(table) => look_up(table, hero.nm()),
        };
        let value = Spectrum(shape * self.scale);
        if self.lit { value * hero.illuminant() } else { value }
    }
}

fn largest([r, g, b]: [f32; 3]) -> f32 {
    r.max(g).max(b).max(0.0)
}

/// Linear between the entries. Without closures, which are not always inlined.
#[inline(always)]
fn look_up(table: &[f32; ENTRIES], nm: Vec4) -> Vec4 {
    let x = nm - cie::LAMBDA_MIN as f32;
    let mut i = [0; 4];
    for k in 0..4 {
        i[k] = (x[k] as usize).min(ENTRIES - 2);
    }
    let [a, b, c, d] = i;
    let low = Vec4::new(table[a], table[b], table[c], table[d]);
    let high = Vec4::new(table[a + 1], table[b + 1], table[c + 1], table[d + 1]);
    let whole = Vec4::new(a as f32, b as f32, c as f32, d as f32);
    low + (x - whole) * (high - low)
}

/// A reflectance that was looked up in a texture, at four wavelengths; see [`Curve::reflectance`].
#[inline]
pub fn reflectance(rgb: [f32; 3], hero: &Hero) -> Spectrum {
    let largest = largest(rgb);
    if largest > 1.0 { unbounded(rgb, hero) } else { smooth(rgb, 1.0, hero) }
}

/// The same of a quantity without bounds.
#[inline]
pub fn unbounded(rgb: [f32; 3], hero: &Hero) -> Spectrum {
    smooth(rgb, 2.0 * largest(rgb), hero)
}

/// The same of emission.
#[inline]
pub fn emission(rgb: [f32; 3], hero: &Hero) -> Spectrum {
    unbounded(rgb, hero) * hero.illuminant()
}

#[inline]
fn smooth(rgb: [f32; 3], scale: f32, hero: &Hero) -> Spectrum {
    let [r, g, b] = rgb;
    if r == g && g == b {
        return Spectrum::splat(r);
    }
    Spectrum(Smooth::near(rgb.map(|x| x / scale)).at(hero.nm()) * scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Wavelengths;

    /// What the film sees of it, by many walks' wavelengths.
    fn seen(value: impl Fn(&Hero) -> Spectrum) -> [f64; 3] {
        let n = 1 << 13;
        (0..n).fold([0.0; 3], |sum, i| {
            let wl = Wavelengths::hero((i as f32 + 0.5) / n as f32);
            let Wavelengths::Hero(hero) = &wl else { return sum };
            let rgb = wl.to_rgb(value(hero)).to_rgb();
            std::array::from_fn(|c| sum[c] + f64::from(rgb[c]) / f64::from(n))
        })
    }

    #[test]
    fn the_film_sees_the_colours_that_were_asked_for() {
        for rgb in
            [[0.63, 0.065, 0.05], [0.14, 0.45, 0.091], [0.725; 3], [1.0; 3], [0.2, 0.25, 0.7], [18.4, 15.6, 8.0], [0.0, 3.0, 0.1]]
        {
            let (held, looked_up) = (Curve::emission(rgb), seen(|hero| emission(rgb, hero)));
            let held = seen(|hero| held.at(hero));
            let largest = f64::from(largest(rgb));
            for c in 0..3 {
                let want = f64::from(rgb[c]);
                assert!((held[c] - want).abs() < 1e-3 * largest, "{rgb:?}: {held:?}");
                assert!((looked_up[c] - want).abs() < 2e-2 * largest, "{rgb:?}: {looked_up:?}");
            }
            if largest <= 1.0 {
                let reflectance = Curve::reflectance(rgb);
                let lit = seen(|hero| reflectance.at(hero) * hero.illuminant());
                (0..3).for_each(|c| assert!((lit[c] - f64::from(rgb[c])).abs() < 1e-3, "{rgb:?}: {lit:?}"));
            }
        }
    }

    #[test]
    fn tables_are_straight_between_their_entries() {
        let curve = Curve::measured(|nm| 2.0 * nm - 3.0);
        let Wavelengths::Hero(hero) = Wavelengths::hero(0.77) else { unreachable!("wavelengths") };
        let (got, nm) = (curve.at(&hero), hero.nm());
        (0..4).for_each(|k| assert!((got[k] - (2.0 * nm[k] - 3.0)).abs() < 1e-3));
    }
}
