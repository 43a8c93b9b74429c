//! FLIP: how strongly a difference between two pictures strikes the eye that flips between them.
//!
//! LDR-FLIP [Andersson et al. 2020]: both pictures in an opponent space are blurred by what the eye cannot resolve at
//! p = 67.02 pixels a degree (a screen of 0.7 m and 3840 pixels seen from 0.7 m); ΔC is the HyAB distance of the
//! result in Hunt-adjusted L\*a\*b\*, raised to q_c = 0.7 and spread over [0, 1]; ΔF the difference of edges and points,
//! raised to q_f = 1/2; and
//!
//! ```text
//! ΔE = ΔC^(1 - ΔF)
//! ```
//!
//! HDR-FLIP [Andersson et al. 2021]: the largest LDR-FLIP over a range of exposures that shows the reference from its
//! brightest pixel to its median, each tone mapped by a fit of ACES.

mod eye;

use self::eye::Eye;
use crate::colour::luminance;
use crate::error::{ErrorKind, ImageError};
use crate::image::Image;

/// p, pixels a degree: 0.7 m away from 3840 pixels on 0.7 m.
const PIXELS_PER_DEGREE: f32 = 0.7 * 3840.0 / 0.7 * std::f32::consts::PI / 180.0;

/// LDR-FLIP of every pixel, in [0, 1]. Light outside of [0, 1] is clipped, as a display would.
pub fn ldr(picture: &Image, reference: &Image) -> Result<Vec<f32>, ImageError> {
    let (x, r) = pair(picture, reference)?;
    Ok(Eye::new().difference(&x.shown(|v| v), &r.shown(|v| v)))
}

/// HDR-FLIP of every pixel, in [0, 1].
pub fn hdr(picture: &Image, reference: &Image) -> Result<Vec<f32>, ImageError> {
    let (x, r) = pair(picture, reference)?;
    let eye = Eye::new();
    let mut worst = vec![0.0f32; r.rgb.len()];
    for exposure in exposures(&r) {
        let scale = exposure.exp2();
        let shown = |p: &Plane3| p.shown(|v| tone(v * scale));
        for (w, d) in worst.iter_mut().zip(eye.difference(&shown(&x), &shown(&r))) {
            *w = w.max(d);
        }
    }
    Ok(worst)
}

/// The mean of an error map.
pub fn mean(map: &[f32]) -> f64 {
    map.iter().map(|&v| f64::from(v)).sum::<f64>() / map.len() as f64
}

/// A picture of three numbers a pixel.
struct Plane3 {
    width: usize,
    height: usize,
    rgb: Vec<[f32; 3]>,
}

impl Plane3 {
    fn of(image: &Image) -> Self {
        let rgb = image.to_linear().to_rgb();
        let finite = |p: &[f32]| if p.iter().all(|v| v.is_finite()) { [p[0], p[1], p[2]] } else { [0.0; 3] };
        Plane3 { width: rgb.width(), height: rgb.height(), rgb: rgb.pixels().map(finite).collect() }
    }

    /// Every number through a function, clipped to [0, 1].
    fn shown(&self, f: impl Fn(f32) -> f32) -> Plane3 {
        self.map(|p| p.map(|v| f(v).clamp(0.0, 1.0)))
    }

    fn map(&self, f: impl Fn([f32; 3]) -> [f32; 3]) -> Plane3 {
        Plane3 { rgb: self.rgb.iter().map(|&p| f(p)).collect(), ..*self }
    }
}

fn pair(picture: &Image, reference: &Image) -> Result<(Plane3, Plane3), ImageError> {
    let (x, r) = (Plane3::of(picture), Plane3::of(reference));
    if (x.width, x.height) == (r.width, r.height) {
        return Ok((x, r));
    }
    Err(ErrorKind::Mismatch(format!("sizes differ: {} x {} and {} x {}", x.width, x.height, r.width, r.height)).into())
}

/// ACES as fitted by [Narkowicz 2015], with light scaled by 0.6 as in [Andersson et al. 2021, §3].
const TONE: [f32; 6] = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];

fn tone(x: f32) -> f32 {
    let [a, b, c, d, e, f] = TONE;
    // Above 10¹⁵ the squares near overflow, and all is white.
    let x = x.clamp(0.0, 1e15);
    (x * (a * x + b) + c) / (x * (d * x + e) + f)
}

/// The exposures to look at [Andersson et al. 2021, §3.2]: from where the brightest pixel, to where the median one,
/// reaches 85 % of the display's range; about a stop apart.
fn exposures(reference: &Plane3) -> Vec<f32> {
    let [a, b, c, d, e, f] = TONE;
    let t = 0.85;
    let (p, q) = ((b - t * e) / (a - t * d), (c - t * f) / (a - t * d));
    let bright = -0.5 * p + (0.25 * p * p - q).sqrt();

    let mut y: Vec<f32> = reference.rgb.iter().map(|&p| luminance(p).max(0.0)).collect();
    y.sort_by(f32::total_cmp);
    let at = |y: f32| (bright / y.max(1e-5)).log2();
    let (start, stop) = (at(y[y.len() - 1]), at(y[y.len() / 2]));
    let n = ((stop - start).ceil() as usize).max(2);
    (0..n).map(|i| start + (stop - start) * i as f32 / (n - 1) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: usize, height: usize, f: impl Fn(usize, usize) -> [f32; 3]) -> Image {
        let data = (0..width * height).flat_map(|i| f(i % width, i / width)).collect();
        Image::rgb(width, height, data).unwrap()
    }

    #[test]
    fn identity_symmetry_and_range() {
        let a = image(24, 17, |x, y| [(x % 3) as f32 / 2.0, (y % 5) as f32 / 4.0, ((x * y) % 7) as f32 / 6.0]);
        let b = image(24, 17, |x, y| [(y % 2) as f32, (x % 4) as f32 / 3.0, 0.5]);
        assert!(ldr(&a, &a).unwrap().iter().chain(&hdr(&a, &a).unwrap()).all(|&v| v == 0.0));
        let (ab, ba) = (ldr(&a, &b).unwrap(), ldr(&b, &a).unwrap());
        assert!(ab.iter().zip(&ba).all(|(p, q)| (p - q).abs() < 1e-5), "LDR-FLIP is symmetric");
        for v in ab.iter().chain(&hdr(&a, &b).unwrap()) {
            assert!((0.0..=1.0).contains(v) && *v > 0.0, "{v}");
        }
    }

    /// The figures of the authors' own evaluator, version 1.7, for a bright square on a ramp of colours.
    #[test]
    fn agrees_with_the_authors() {
        let ramp = |x: usize, y: usize| [x as f32 / 31.0, y as f32 / 31.0, 0.5];
        let square = |x: usize, y: usize| if (8..16).contains(&x) && (8..16).contains(&y) { [1.0, 1.0, 0.0] } else { ramp(x, y) };
        let flip = mean(&ldr(&image(32, 32, square), &image(32, 32, ramp)).unwrap());
        assert!((flip - 0.168_379_5).abs() < 2e-5, "{flip}");
        let bright = |p: [f32; 3]| p.map(|v| 16.0 * v);
        let (a, b) = (image(32, 32, |x, y| bright(square(x, y))), image(32, 32, |x, y| bright(ramp(x, y))));
        let flip = mean(&hdr(&a, &b).unwrap());
        assert!((flip - 0.126_875_1).abs() < 2e-5, "{flip}");
    }

    #[test]
    fn green_against_blue_is_the_farthest_of_colours() {
        // Constant pictures have no edges: ΔE = ΔC, and green against blue defines ΔC = 1 [Andersson et al. 2020, §4.1.3].
        let (g, b) = (image(8, 8, |_, _| [0.0, 1.0, 0.0]), image(8, 8, |_, _| [0.0, 0.0, 1.0]));
        assert!(ldr(&g, &b).unwrap().iter().all(|v| (v - 1.0).abs() < 1e-4));
    }

    #[test]
    fn exposures_reach_over_the_range() {
        // A ramp over 12 stops, the median in its middle: six stops from the brightest pixel to the median.
        let ramp = image(241, 1, |x, _| [(x as f32 / 20.0 - 6.0).exp2(); 3]);
        let e = exposures(&Plane3::of(&ramp));
        assert_eq!(e.len(), 6);
        assert!((e[5] - e[0] - 6.0).abs() < 0.01);
        assert!((tone(64.0 * e[0].exp2()) - 0.85).abs() < 1e-4);
    }

    #[test]
    fn extreme_light_stays_in_range() {
        let a = image(9, 9, |x, _| [[0.0, f32::MAX, f32::NAN][x % 3]; 3]);
        let b = image(9, 9, |_, y| [[f32::INFINITY, 1e-40, -5.0][y % 3]; 3]);
        for v in hdr(&a, &b).unwrap().iter().chain(&hdr(&b, &a).unwrap()) {
            assert!((0.0..=1.0).contains(v), "{v}");
        }
        let black = image(9, 9, |_, _| [0.0; 3]);
        assert!(hdr(&black, &black).unwrap().iter().all(|&v| v == 0.0));
    }
}
