//! Smooth spectra for red, green and blue [Jakob, Hanika 2019].
//!
//! ```text
//! S(λ) = σ(c₀ + c₁ x + c₂ x²),   σ(t) = 1/2 + t / (2 √(1 + t²)),   x = (λ - 595 nm) / 235 nm
//! ∫ S(λ) D65(λ) s̄(λ) dλ = (r, g, b)                                    s̄: what the film sees, scaled so that ∫ D65 s̄ = (1, 1, 1)
//! ```
//!
//! Three numbers for three: [`Smooth::fit`] finds c by Newton's method, damped [Marquardt 1963]. S is a reflectance, within (0, 1) at every wavelength,
//! so that energy is conserved whatever the colour. Greys are the same at every wavelength, exactly, and white is 1 within 4e-5. Other quantities are made of it:
//!
//! | what stands in red, green and blue | its spectrum |
//! | --- | --- |
//! | a reflectance | S of (r, g, b) |
//! | without bounds (η, k, a factor above 1) | 2m S of (r, g, b)/2m,  m = max(r, g, b) |
//! | emission | the same times D65: (1, 1, 1) is the white of Rec.709 |
//!
//! Textures look c up in a table ([`Smooth::near`]), for a fit takes tens of microseconds. It is cut by which channel is the largest, and spans
//! z = max(r, g, b) and the square roots of the others over z, 24 nodes each. Since σ(-t) = 1 - σ(t), colours lighter than 1/2 are looked up as the
//! negatives of their complements; what is interpolated is c √a, a the mean of the channels, which tends to a limit for dark colours as S/z does.
//! Colours come back from it with an error of 0.0007 on average and 0.004 for one in a hundred, the most saturated dark ones 0.04.
//!
//! The table is `data/smooth.bin`, which `cargo run --release -p etendue-numerics --example smooth_table` makes.

use super::cie::{LAMBDA_MAX, LAMBDA_MIN, d65, observer, xyz_to_rgb};
use glam::Vec4;
use std::sync::LazyLock;

/// A smooth reflectance spectrum: c₀, c₁, c₂.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Smooth(pub [f32; 3]);

/// How far from 0 and 1 reflectances stay.
const MARGIN: f64 = 4e-5;

impl Smooth {
    /// The spectrum whose colour is (r, g, b), each clamped to [0, 1].
    pub fn fit(rgb: [f32; 3]) -> Self {
        let rgb = rgb.map(|x| f64::from(x).clamp(MARGIN, 1.0 - MARGIN));
        let c = grey(rgb).map_or_else(|| FINE.solve(rgb, None), |x| [unsigmoid(x), 0.0, 0.0]);
        Self(c.map(|x| x as f32))
    }

    /// S at four wavelengths, nm.
    #[inline(always)]
    pub fn at(&self, nm: Vec4) -> Vec4 {
        let x = (nm - 595.0) * (1.0 / 235.0);
        let [c0, c1, c2] = self.0;
        let t = (x * c2 + c1) * x + c0;
        let square = t * t + 1.0;
        // Not by the instruction for approximate reciprocals: the same bits on every machine.
        let root = Vec4::new(square.x.sqrt(), square.y.sqrt(), square.z.sqrt(), square.w.sqrt());
        t * 0.5 / root + 0.5
    }
}

fn grey([r, g, b]: [f64; 3]) -> Option<f64> {
    (r == g && g == b).then_some(r)
}

/// The t at which σ(t) = s.
fn unsigmoid(s: f64) -> f64 {
    (s - 0.5) / (s * (1.0 - s)).sqrt()
}

/// D65 s̄ at equidistant wavelengths, to integrate with.
struct Quadrature {
    x: Vec<f64>,
    weights: [Vec<f64>; 3],
}

static FINE: LazyLock<Quadrature> = LazyLock::new(|| Quadrature::new(470));

impl Quadrature {
    fn new(steps: usize) -> Self {
        let width = (LAMBDA_MAX - LAMBDA_MIN) / steps as f64;
        let nm: Vec<f64> = (0..steps).map(|i| LAMBDA_MIN + (i as f64 + 0.5) * width).collect();
        let seen: Vec<[f64; 3]> = nm.iter().map(|nm| xyz_to_rgb(observer(*nm)).map(|s| s * d65(*nm))).collect();
        let weights = [0, 1, 2].map(|c| {
            let sum: f64 = seen.iter().map(|s| s[c]).sum();
            seen.iter().map(|s| s[c] / sum).collect()
        });
        Self { x: nm.iter().map(|nm| (nm - 595.0) / 235.0).collect(), weights }
    }

    /// The colour of S, and its derivatives by c₀, c₁, c₂.
    fn colour(&self, [c0, c1, c2]: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
        let (mut rgb, mut slopes) = ([0.0; 3], [[0.0; 3]; 3]);
        let [r, g, b] = &self.weights;
        for (((x, r), g), b) in self.x.iter().zip(r).zip(g).zip(b) {
            let t = (c2 * x + c1) * x + c0;
            let inverse = 1.0 / (1.0 + t * t).sqrt();
            let (s, slope) = (0.5 + 0.5 * t * inverse, 0.5 * inverse * inverse * inverse);
            for (c, w) in [r, g, b].into_iter().enumerate() {
                rgb[c] += w * s;
                let d = w * slope;
                slopes[c][0] += d;
                slopes[c][1] += d * x;
                slopes[c][2] += d * x * x;
            }
        }
        (rgb, slopes)
    }

    /// c of a colour within (0, 1), by steps from `near`.
    fn solve(&self, target: [f64; 3], near: Option<[f64; 3]>) -> [f64; 3] {
        let mean = target.iter().sum::<f64>() / 3.0;
        let mut c = near.unwrap_or([unsigmoid(mean), 0.0, 0.0]);
        let misses = |rgb: [f64; 3]| [0, 1, 2].map(|i| rgb[i] - target[i]);
        let size = |r: [f64; 3]| r.iter().map(|x| x * x).sum::<f64>();
        let (rgb, mut slopes) = self.colour(c);
        let (mut miss, mut damping) = (misses(rgb), 1e-3);
        for _ in 0..STEPS {
            if size(miss) < 1e-16 {
                break;
            }
            // (JᵀJ + μ diag JᵀJ) Δ = -Jᵀ miss.
            let j = slopes;
            let mut m = [[0.0; 3]; 3];
            let mut v = [0.0; 3];
            for a in 0..3 {
                for b in 0..3 {
                    m[a][b] = (0..3).map(|i| j[i][a] * j[i][b]).sum();
                }
                v[a] = -(0..3).map(|i| j[i][a] * miss[i]).sum::<f64>();
                m[a][a] *= 1.0 + damping;
            }
            let Some(step) = solved(m, v) else { break };
            let there = [0, 1, 2].map(|i| c[i] + step[i]);
            let (rgb, slopes_there) = self.colour(there);
            let miss_there = misses(rgb);
            if size(miss_there) < size(miss) && there.iter().all(|c| c.abs() < LARGEST) {
                (c, slopes, miss) = (there, slopes_there, miss_there);
                damping = (damping * 0.1).max(1e-12);
            } else {
                damping *= 10.0;
            }
        }
        c
    }
}

/// Steps at most: colours at the border of what can be reached come nearer and nearer for ever.
const STEPS: usize = 40;
/// No c is larger: single precision would not do.
const LARGEST: f64 = 3e3;

/// m Δ = v by Cramer's rule.
fn solved(m: [[f64; 3]; 3], v: [f64; 3]) -> Option<[f64; 3]> {
    let det = |a: [[f64; 3]; 3]| {
        a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) - a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0])
            + a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0])
    };
    let d = det(m);
    let solution = [0, 1, 2].map(|i| {
        let mut a = m;
        (0..3).for_each(|row| a[row][i] = v[row]);
        det(a) / d
    });
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}

/// Nodes along each axis.
const NODES: usize = 24;

/// c √a at all nodes: of each a little-endian f32.
static TABLE: LazyLock<Vec<[f32; 3]>> = LazyLock::new(|| {
    let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    include_bytes!("data/smooth.bin").chunks_exact(12).map(|b| [number(b), number(&b[4..]), number(&b[8..])]).collect()
});

/// The colour at a node: `largest` is the channel that is z, the next two are x and y of it.
fn node(largest: usize, [i, j, k]: [usize; 3]) -> [f64; 3] {
    let at = |k: usize| k as f64 / (NODES - 1) as f64;
    let z = at(k).clamp(2e-3, 1.0 - MARGIN);
    let mut rgb = [0.0; 3];
    (rgb[largest], rgb[(largest + 1) % 3], rgb[(largest + 2) % 3]) = (z, z * at(i).powi(2), z * at(j).powi(2));
    rgb
}

/// The bytes of the table, a fraction of a second.
pub fn table() -> Vec<u8> {
    let coarse = Quadrature::new(94);
    let mut bytes = Vec::with_capacity(3 * NODES * NODES * NODES * 12);
    for (largest, j, i) in (0..3).flat_map(|l| (0..NODES).flat_map(move |j| (0..NODES).map(move |i| (l, j, i)))) {
        let mut near = None;
        for k in 0..NODES {
            let rgb = node(largest, [i, j, k]);
            let c = coarse.solve(rgb, near);
            near = Some(c);
            let a = rgb.iter().sum::<f64>() / 3.0;
            c.iter().for_each(|c| bytes.extend(((c * a.sqrt()) as f32).to_le_bytes()));
        }
    }
    bytes
}

impl Smooth {
    /// What [`Smooth::fit`] gives, nearly, from the table.
    #[inline]
    pub fn near(rgb: [f32; 3]) -> Self {
        let rgb = rgb.map(|x| x.clamp(MARGIN as f32, 1.0 - MARGIN as f32));
        let [r, g, b] = rgb;
        if r == g && g == b {
            return Self([(r - 0.5) / (r * (1.0 - r)).sqrt(), 0.0, 0.0]);
        }
        let mean = (r + g + b) * (1.0 / 3.0);
        let ([r, g, b], mean, sign) = if mean > 0.5 { (rgb.map(|x| 1.0 - x), 1.0 - mean, -1.0) } else { (rgb, mean, 1.0) };
        let (largest, z, x, y) = if r >= g && r >= b {
            (0, r, g, b)
        } else if g >= b {
            (1, g, b, r)
        } else {
            (2, b, r, g)
        };
        let place = |q: f32| {
            let q = q * (NODES - 1) as f32;
            let i = (q as usize).min(NODES - 2);
            (i, q - i as f32)
        };
        let ((i, u), (j, v), (k, w)) = (place((x / z).sqrt()), place((y / z).sqrt()), place(z));
        let (table, mut c) = (&*TABLE, Vec4::ZERO);
        for (dj, p) in [1.0 - v, v].into_iter().enumerate() {
            for (di, q) in [1.0 - u, u].into_iter().enumerate() {
                let at = ((largest * NODES + j + dj) * NODES + i + di) * NODES + k;
                let [low, high] = [table[at], table[at + 1]].map(|[a, b, c]| Vec4::new(a, b, c, 0.0));
                c += (low + (high - low) * w) * (p * q);
            }
        }
        c *= sign / mean.sqrt();
        Self([c.x, c.y, c.z])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::{mix, unit};

    fn error(s: Smooth, rgb: [f32; 3]) -> f64 {
        let (got, _) = FINE.colour(s.0.map(f64::from));
        (0..3).map(|c| (got[c] - f64::from(rgb[c])).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn colours_come_back_from_their_spectra() {
        let grid = |i: u32| [i % 6, i / 6 % 6, i / 36].map(|k| k as f32 / 5.0);
        for rgb in (0..216).map(grid) {
            let s = Smooth::fit(rgb);
            assert!(error(s, rgb) < 1e-3, "{rgb:?} {s:?}: {}", error(s, rgb));
            for i in 0..118 {
                let s = s.at(Vec4::new(0.0, 1.0, 2.0, 3.0) + 360.0 + 4.0 * i as f32);
                assert!(s.cmpge(Vec4::ZERO).all() && s.cmple(Vec4::ONE).all(), "{rgb:?} creates light: {s}");
            }
        }
    }

    #[test]
    fn white_is_white_and_greys_are_flat() {
        for s in [Smooth::fit([1.0; 3]), Smooth::near([1.0; 3])] {
            assert!((0..471).all(|i| (s.at(Vec4::splat(360.0 + i as f32)) - 1.0).abs().max_element() < 1e-4));
        }
        for x in [0.0, 0.18, 0.5, 0.725, 0.999] {
            for s in [Smooth::fit([x; 3]), Smooth::near([x; 3])] {
                assert!((0..471).all(|i| (s.at(Vec4::splat(360.0 + i as f32)) - x).abs().max_element() < 1e-4), "{x}");
            }
        }
    }

    #[test]
    fn the_table_holds_what_fits_give() {
        assert_eq!(TABLE.len(), 3 * NODES * NODES * NODES);
        let digit = |i: u64| unit(mix(i) as u32);
        let n = 2000;
        let mut errors: Vec<f64> = (0..n)
            .map(|i| {
                let rgb = [digit(3 * i), digit(3 * i + 1), digit(3 * i + 2)];
                error(Smooth::near(rgb), rgb)
            })
            .collect();
        errors.sort_by(f64::total_cmp);
        let mean = errors.iter().sum::<f64>() / n as f64;
        assert!(mean < 1e-3 && errors[n as usize * 99 / 100] < 5e-3, "{mean} {:?}", &errors[n as usize * 99 / 100..]);
        // Some nodes, fitted again.
        for place in [[3, 5, 7], [20, 2, 12], [11, 11, 4], [0, 9, 23]] {
            for largest in 0..3 {
                let rgb = node(largest, place);
                let [i, j, k] = place;
                let a = (rgb[0] + rgb[1] + rgb[2]) / 3.0;
                let held = TABLE[((largest * NODES + j) * NODES + i) * NODES + k].map(|c| c / a.sqrt() as f32);
                assert!(error(Smooth(held), rgb.map(|x| x as f32)) < 2e-3, "{rgb:?}");
            }
        }
    }
}
