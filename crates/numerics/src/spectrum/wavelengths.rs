//! What the lanes of a [`Spectrum`] stand for: linear Rec.709, or four hero wavelengths and what film and lamps need to know of them.
//!
//! ```text
//! λ_k = Q(frac(u + k/4)), k = 0 … 3        one number, four wavelengths [Wilkie et al. 2014]
//! p(λ) = 0.8 |s̄(λ)| / ∫ |s̄| + 0.2 / 470 nm,        s̄ = M (x̄, ȳ, z̄)   what the red, green and blue of the film see
//! (R, G, B) = ¼ Σ_k L(λ_k) s̄(λ_k) / p(λ_k)
//! ```
//!
//! Q, the inverse of the distribution of p, is a table of 512 cells of equal probability, straight in between: p is constant in each and integrates to
//! one. Observer and illuminant stand beside it, looked up once a walk. s̄ is scaled (by 0.1 %) so that D65 of unit luminance is (1, 1, 1) exactly.
//!
//! Against the usual p ∝ 1/cosh²(0.0072 (λ - 538 nm)) [Radziszewski et al. 2009] the variance between the colours of single walks under D65 falls from
//! 0.119 to 0.017 of the squared luminance for grey, from 0.73 to 0.15 for red, from 9.1 to 0.86 for blue; that of the luminance rises for grey
//! (0.001 to 0.004) and blue (0.01 to 0.18) and falls for red (0.055 to 0.014).
//!
//! The first wavelength is the hero. Where a surface sends every wavelength another way (dispersion), the walk goes on with the hero alone:
//! its lane counts four times, the others are dark from there on; what they have collected before stays. [`Wavelengths::is_alone`] tells that this has
//! happened, for it happens once.

use super::Spectrum;
use super::cie::{LAMBDA_MAX, LAMBDA_MIN, d65, observer, xyz_to_rgb};
use glam::Vec4;
use std::sync::LazyLock;

/// What the lanes of a [`Spectrum`] stand for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Wavelengths {
    /// Linear Rec.709 red, green, blue, and an unused zero.
    #[default]
    Rgb,
    /// Values at four wavelengths.
    Hero(Hero),
}

/// Four wavelengths, the hero first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hero {
    nm: Vec4,
    illuminant: Vec4,
    u: f32,
    alone: bool,
}

impl Wavelengths {
    /// The wavelengths of the number `u` in [0, 1).
    #[inline]
    pub fn hero(u: f32) -> Self {
        let ([a, b, c, d], t) = TABLE.rows(u);
        let nm = [Vec4::new(a[0].nm, b[0].nm, c[0].nm, d[0].nm), Vec4::new(a[1].nm, b[1].nm, c[1].nm, d[1].nm)];
        let illuminant = [
            Vec4::new(a[0].illuminant, b[0].illuminant, c[0].illuminant, d[0].illuminant),
            Vec4::new(a[1].illuminant, b[1].illuminant, c[1].illuminant, d[1].illuminant),
        ];
        let between = |[low, high]: [Vec4; 2]| low + t * (high - low);
        Self::Hero(Hero { nm: between(nm), illuminant: between(illuminant), u, alone: false })
    }

    /// Whether lanes are red, green and blue.
    #[inline(always)]
    pub fn is_rgb(&self) -> bool {
        matches!(self, Self::Rgb)
    }

    /// The same value in every lane that is in use.
    #[inline]
    pub fn grey(&self, x: f32) -> Spectrum {
        match self {
            Self::Rgb => Spectrum::rgb(x, x, x),
            Self::Hero(_) => Spectrum::splat(x),
        }
    }

    /// What the film makes of radiance: linear Rec.709. A single walk's may be negative where their mean is not.
    #[inline]
    pub fn to_rgb(&self, l: Spectrum) -> Spectrum {
        match self {
            Self::Rgb => l,
            Self::Hero(hero) => hero.to_rgb(l),
        }
    }

    /// Whether the walk goes on with the hero alone.
    #[inline]
    pub fn is_alone(&self) -> bool {
        matches!(self, Self::Hero(hero) if hero.alone)
    }

    /// Goes on with the hero alone. Returns the factor for the lanes: 4 for the hero's and 0 for the others, or 1 if they are given up already.
    #[inline]
    pub fn single_out(&mut self) -> Spectrum {
        match self {
            Self::Hero(hero) if !hero.alone => {
                hero.alone = true;
                Spectrum(Vec4::new(4.0, 0.0, 0.0, 0.0))
            }
            _ => Spectrum::ONE,
        }
    }
}

impl Hero {
    /// The wavelengths, nm.
    #[inline(always)]
    pub fn nm(&self) -> Vec4 {
        self.nm
    }

    /// The illuminant D65 at the wavelengths, scaled to unit luminance.
    #[inline(always)]
    pub fn illuminant(&self) -> Spectrum {
        Spectrum(self.illuminant)
    }

    /// Their densities, 1/nm.
    pub fn pdf(&self) -> [f32; 4] {
        TABLE.rows(self.u).0.map(|[row, _]| 1.0 / row.per_pdf)
    }

    #[inline]
    fn to_rgb(self, l: Spectrum) -> Spectrum {
        let ([a, b, c, d], t) = TABLE.rows(self.u);
        let l = l * 0.25;
        Spectrum(Row::seen(a, t) * l[0] + Row::seen(b, t) * l[1] + Row::seen(c, t) * l[2] + Row::seen(d, t) * l[3])
    }
}

/// Cells of equal probability.
const CELLS: usize = 512;

/// A border of cells.
#[derive(Clone, Copy, Debug)]
struct Row {
    /// s̄, 1/nm; the fourth is zero.
    response: Vec4,
    nm: f32,
    illuminant: f32,
    /// 1/p in the cell that begins here.
    per_pdf: f32,
}

impl Row {
    /// s̄/p at a place between two borders.
    #[inline(always)]
    fn seen([low, high]: [&Self; 2], t: f32) -> Vec4 {
        (low.response + t * (high.response - low.response)) * low.per_pdf
    }
}

struct Table([Row; CELLS + 1]);

static TABLE: LazyLock<Table> = LazyLock::new(Table::new);

impl Table {
    /// The borders around the four places, and how far these are from the first to the second, for all of them alike.
    #[inline(always)]
    fn rows(&self, u: f32) -> ([[&Row; 2]; 4], f32) {
        let x = u * CELLS as f32;
        let cell = (x as usize).min(CELLS - 1);
        let [a, b, c, d] = [cell, (cell + CELLS / 4) % CELLS, (cell + CELLS / 2) % CELLS, (cell + 3 * (CELLS / 4)) % CELLS];
        let rows = &self.0;
        ([[&rows[a], &rows[a + 1]], [&rows[b], &rows[b + 1]], [&rows[c], &rows[c + 1]], [&rows[d], &rows[d + 1]]], x - cell as f32)
    }

    fn new() -> Self {
        let response = |nm: f64| xyz_to_rgb(observer(nm));
        let norm = |nm: f64| response(nm).iter().map(|x| x * x).sum::<f64>().sqrt();
        // p on steps of 1/8 nm, and its sums.
        const STEPS: usize = 470 * 8;
        let width = (LAMBDA_MAX - LAMBDA_MIN) / STEPS as f64;
        let middle = |i: usize| LAMBDA_MIN + (i as f64 + 0.5) * width;
        let total: f64 = (0..STEPS).map(|i| norm(middle(i)) * width).sum();
        let mut sums = vec![0.0];
        for i in 0..STEPS {
            let p = 0.8 * norm(middle(i)) / total + 0.2 / (LAMBDA_MAX - LAMBDA_MIN);
            sums.push(sums[i] + p * width);
        }
        let whole = sums[STEPS];
        let quantile = |q: f64| {
            let i = sums[1..STEPS].partition_point(|s| *s <= q * whole);
            LAMBDA_MIN + (i as f64 + (q * whole - sums[i]) / (sums[i + 1] - sums[i])) * width
        };
        let nm: Vec<f64> = (0..=CELLS).map(|i| quantile(i as f64 / CELLS as f64)).collect();

        // D65 is white: the integral of two straight lines' product over each cell.
        let mut white = [0.0; 3];
        for cell in nm.windows(2) {
            let [(a, x), (b, y)] = [cell[0], cell[1]].map(|nm| (d65(nm), response(nm)));
            for (c, white) in white.iter_mut().enumerate() {
                *white += (cell[1] - cell[0]) * (a * (2.0 * x[c] + y[c]) + b * (x[c] + 2.0 * y[c])) / 6.0;
            }
        }
        Self(std::array::from_fn(|i| {
            let next = nm.get(i + 1).map_or(0.0, |next| next - nm[i]);
            let s = response(nm[i]);
            let [r, g, b] = [0, 1, 2].map(|c| (s[c] / white[c]) as f32);
            Row {
                response: Vec4::new(r, g, b, 0.0),
                nm: nm[i] as f32,
                illuminant: d65(nm[i]) as f32,
                per_pdf: (next * CELLS as f64) as f32,
            }
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heroes(n: u32) -> impl Iterator<Item = Hero> {
        (0..n).filter_map(move |i| match Wavelengths::hero((i as f32 + 0.5) / n as f32) {
            Wavelengths::Hero(hero) => Some(hero),
            Wavelengths::Rgb => None,
        })
    }

    #[test]
    fn densities_integrate_to_one_and_are_those_of_the_wavelengths() {
        // ∫ p dλ over the cells, and E[1/p] = 470 nm, the integral of 1.
        let integral: f64 = TABLE.0.windows(2).map(|w| f64::from(w[1].nm - w[0].nm) / f64::from(w[0].per_pdf)).sum();
        assert!((integral - 1.0).abs() < 1e-5, "{integral}");
        assert_eq!((TABLE.0[0].nm, TABLE.0[CELLS].nm), (360.0, 830.0));
        let (n, mut length, mut below) = (1 << 14, 0.0, [0u32; 4]);
        for hero in heroes(n) {
            length += hero.pdf().iter().map(|p| 0.25 / f64::from(*p)).sum::<f64>() / f64::from(n);
            (0..4).for_each(|k| below[k] += u32::from(hero.nm()[k] < 550.0));
        }
        assert!((length - 470.0).abs() < 1e-2, "{length}");
        // Each of the four alone has the same distribution.
        let p_below = TABLE.0.partition_point(|row| row.nm < 550.0) as f64 / CELLS as f64;
        below.iter().for_each(|b| assert!((f64::from(*b) / f64::from(n) - p_below).abs() < 2.0 / CELLS as f64, "{below:?}"));
    }

    #[test]
    fn the_film_sees_what_the_observer_sees() {
        let mean = |light: &dyn Fn(&Hero) -> Spectrum| {
            let n = 1 << 14;
            heroes(n).fold([0f64; 3], |sum, hero| {
                let rgb = hero.to_rgb(light(&hero)).to_rgb();
                std::array::from_fn(|c| sum[c] + f64::from(rgb[c]) / f64::from(n))
            })
        };
        let white = mean(&|hero| hero.illuminant());
        assert!(white.iter().all(|x| (x - 1.0).abs() < 1e-5), "{white:?}");
        // A line that falls, against integrals over the table of the observer.
        let falls = |nm: f64| (900.0 - nm) / 400.0;
        let want = xyz_to_rgb(super::super::cie::spectrum_to_xyz(falls));
        let got = mean(&|hero| Spectrum(hero.nm()).map(|nm| falls(f64::from(nm)) as f32));
        (0..3).for_each(|c| assert!((got[c] / want[c] - 1.0).abs() < 2e-3, "{got:?} {want:?}"));
    }

    #[test]
    fn the_hero_goes_on_alone_once() {
        let mut wl = Wavelengths::hero(0.3);
        assert_eq!(wl.single_out().0, Vec4::new(4.0, 0.0, 0.0, 0.0));
        assert_eq!(wl.single_out(), Spectrum::ONE);
        assert_eq!(Wavelengths::Rgb.single_out(), Spectrum::ONE);
        // The mean over u of four times the first lane is the mean of all four.
        let n = 1 << 14;
        let (mut alone, mut all) = ([0f64; 3], [0f64; 3]);
        for hero in heroes(n) {
            let [a, b] =
                [Vec4::new(4.0, 0.0, 0.0, 0.0), Vec4::ONE].map(|lanes| hero.to_rgb(hero.illuminant() * Spectrum(lanes)).to_rgb());
            (0..3).for_each(|c| {
                alone[c] += f64::from(a[c]) / f64::from(n);
                all[c] += f64::from(b[c]) / f64::from(n);
            });
        }
        (0..3).for_each(|c| assert!((alone[c] - all[c]).abs() < 1e-4, "{alone:?} {all:?}"));
    }
}
