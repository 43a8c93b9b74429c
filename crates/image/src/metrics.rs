//! How far a picture is from a reference.
//!
//! x the picture, r the reference, both linear Rec.709; means run over all pixels and channels, in f64:
//!
//! ```text
//! MSE    = mean((x - r)²)
//! relMSE = mean((x - r)² / (r² + e))          e = 0.01 · (mean of r)²
//! PSNR   = 10 log10(1 / MSE of the sRGB code values clipped to [0, 1])           dB
//! bias   = (mean of x - mean of r) / mean of r    per channel, and of the luminance
//! ```
//!
//! and FLIP in its two forms, see [`flip`]. Pixels that hold a number that is not finite, in the picture
//! or in the reference, are counted and left out of the means; FLIP sees them as black.

use crate::colour::{LUMINANCE, linear_to_srgb};
use crate::error::{ErrorKind, ImageError};
use crate::flip;
use crate::image::Image;

/// The distances of a picture from a reference. Bias and relMSE of a black reference are NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Mean square error, in squared radiance.
    pub mse: f64,
    /// Relative mean square error.
    pub rel_mse: f64,
    /// Peak signal to noise ratio of what a display shows, in dB; infinite for equal pictures.
    pub psnr: f64,
    /// (mean x - mean r) / mean r of R, G, B.
    pub bias: [f64; 3],
    /// The same of the luminance.
    pub bias_luminance: f64,
    /// Mean of LDR-FLIP of the clipped sRGB pictures, in [0, 1].
    pub flip: f64,
    /// Mean of HDR-FLIP, in [0, 1].
    pub hdr_flip: f64,
    /// Means of R, G, B of the picture.
    pub mean: [f64; 3],
    /// Means of R, G, B of the reference.
    pub mean_reference: [f64; 3],
    /// Pixels of the picture that hold a number that is not finite.
    pub nonfinite: u64,
    /// The same of the reference.
    pub nonfinite_reference: u64,
}

/// Compares a picture with a reference of the same size; both are brought to linear Rec.709 first.
pub fn compare(picture: &Image, reference: &Image) -> Result<Comparison, ImageError> {
    let size = |i: &Image| (i.width(), i.height());
    if size(picture) != size(reference) {
        let ((a, b), (c, d)) = (size(picture), size(reference));
        return Err(ErrorKind::Mismatch(format!("sizes differ: the picture is {a} x {b}, the reference {c} x {d}")).into());
    }
    let (x, r) = (picture.to_linear().to_rgb(), reference.to_linear().to_rgb());
    let finite = |p: &[f32]| p.iter().all(|v| v.is_finite());
    let nonfinite = |i: &Image| i.pixels().filter(|p| !finite(p)).count() as u64;

    // Sums of the first kind: means.
    let pairs = || x.pixels().zip(r.pixels()).filter(|(x, r)| finite(x) && finite(r));
    let mut n = 0u64;
    let (mut sum_x, mut sum_r) = ([0.0f64; 3], [0.0f64; 3]);
    for (x, r) in pairs() {
        n += 1;
        for c in 0..3 {
            sum_x[c] += f64::from(x[c]);
            sum_r[c] += f64::from(r[c]);
        }
    }
    let (mean, mean_reference) = (sum_x.map(|s| s / n as f64), sum_r.map(|s| s / n as f64));

    // Sums of the second kind: squares, which need the reference's mean.
    let e = 0.01 * (mean_reference.iter().sum::<f64>() / 3.0).powi(2);
    let code = |v: f32| f64::from(linear_to_srgb(v).clamp(0.0, 1.0));
    let (mut square, mut relative, mut shown) = (0.0, 0.0, 0.0);
    for (x, r) in pairs() {
        for (&x, &r) in x.iter().zip(r) {
            let d2 = (f64::from(x) - f64::from(r)).powi(2);
            square += d2;
            relative += d2 / (f64::from(r).powi(2) + e);
            shown += (code(x) - code(r)).powi(2);
        }
    }
    let samples = 3.0 * n as f64;
    let y = |m: [f64; 3]| LUMINANCE.iter().zip(m).map(|(w, m)| f64::from(*w) * m).sum::<f64>();
    Ok(Comparison {
        mse: square / samples,
        rel_mse: relative / samples,
        psnr: -10.0 * (shown / samples).log10(),
        bias: [0, 1, 2].map(|c| (mean[c] - mean_reference[c]) / mean_reference[c]),
        bias_luminance: (y(mean) - y(mean_reference)) / y(mean_reference),
        flip: flip::mean(&flip::ldr(&x, &r)?),
        hdr_flip: flip::mean(&flip::hdr(&x, &r)?),
        mean,
        mean_reference,
        nonfinite: nonfinite(&x),
        nonfinite_reference: nonfinite(&r),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn constant(v: f32) -> Image {
        Image::rgb(16, 16, vec![v; 768]).unwrap()
    }

    #[test]
    fn closed_forms_of_constants() {
        let c = compare(&constant(0.75), &constant(0.5)).unwrap();
        assert!((c.mse - 0.0625).abs() < 1e-12);
        assert!((c.rel_mse - 0.0625 / (0.25 + 0.0025)).abs() < 1e-12);
        assert!(c.bias.iter().chain([&c.bias_luminance]).all(|b| (b - 0.5).abs() < 1e-9));
        let d = f64::from(linear_to_srgb(0.75) - linear_to_srgb(0.5));
        assert!((c.psnr + 20.0 * d.log10()).abs() < 1e-4);
        assert_eq!((c.nonfinite, c.nonfinite_reference), (0, 0));
    }

    #[test]
    fn relative_error_takes_the_mean_of_the_whole_reference() {
        // Two pixels: r = 0 and r = 2, so e = 0.01; x misses both by 1.
        let r = Image::rgb(2, 1, vec![0.0, 0.0, 0.0, 2.0, 2.0, 2.0]).unwrap();
        let x = Image::rgb(2, 1, vec![1.0, 1.0, 1.0, 3.0, 3.0, 3.0]).unwrap();
        let c = compare(&x, &r).unwrap();
        assert!((c.rel_mse - 0.5 * (1.0 / 0.01 + 1.0 / 4.01)).abs() < 1e-9);
    }

    #[test]
    fn equal_pictures_and_broken_pixels() {
        let c = compare(&constant(0.5), &constant(0.5)).unwrap();
        assert_eq!((c.mse, c.rel_mse, c.flip, c.hdr_flip), (0.0, 0.0, 0.0, 0.0));
        assert_eq!(c.psnr, f64::INFINITY);
        let mut x = constant(0.5);
        x.data_mut()[4] = f32::NAN;
        x.data_mut()[9] = f32::INFINITY;
        let c = compare(&x, &constant(0.5)).unwrap();
        assert_eq!((c.mse, c.nonfinite), (0.0, 2));
        assert!(c.flip > 0.0 && c.flip.is_finite());
        assert!(compare(&constant(1.0), &Image::rgb(1, 1, vec![0.0; 3]).unwrap()).is_err());
    }
}
