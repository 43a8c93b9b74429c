//! Numbers as colours: a diverging map for signed differences, a sequential one for errors, each with its legend.

use etendue_image::{Encoding, Image};

/// The relative difference that the diverging map ends at.
pub const DIFFERENCE: f64 = 0.25;
/// The relative standard errors between which the sequential map runs, by their logarithm.
pub const ERROR: [f64; 2] = [0.001, 1.0];

/// Blue (darker than the reference) over grey to red (brighter): sRGB of about equal lightness steps.
const DIVERGING: [[f64; 3]; 5] =
    [[0.09, 0.30, 0.75], [0.45, 0.64, 0.88], [0.90, 0.90, 0.89], [0.93, 0.56, 0.43], [0.72, 0.11, 0.16]];
/// Dark violet over teal to yellow: lightness rises all along, also for the colour-blind.
const SEQUENTIAL: [[f64; 3]; 5] =
    [[0.15, 0.06, 0.31], [0.21, 0.28, 0.55], [0.15, 0.51, 0.56], [0.37, 0.75, 0.41], [0.98, 0.89, 0.27]];

fn ramp(stops: &[[f64; 3]; 5], x: f64) -> [f64; 3] {
    let x = if x.is_finite() { x.clamp(0.0, 1.0) } else { 1.0 } * 4.0;
    let i = (x as usize).min(3);
    let t = x - i as f64;
    std::array::from_fn(|c| stops[i][c] * (1.0 - t) + stops[i + 1][c] * t)
}

/// The colour of a relative difference.
pub fn diverging(relative: f64) -> [f64; 3] {
    ramp(&DIVERGING, 0.5 + 0.5 * relative / DIFFERENCE)
}

/// The colour of a relative standard error.
pub fn sequential(relative: f64) -> [f64; 3] {
    let [low, high] = ERROR.map(f64::ln);
    ramp(&SEQUENTIAL, (relative.max(1e-12).ln() - low) / (high - low))
}

/// The colour of a number from 0 to 1.
pub fn linear(x: f64) -> [f64; 3] {
    ramp(&SEQUENTIAL, x)
}

/// `#rrggbb`.
pub fn hex(colour: [f64; 3]) -> String {
    let [r, g, b] = colour.map(|c| (c * 255.0).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// A gradient of `colour` over `from`..`to`, as CSS.
pub fn css_gradient(colour: impl Fn(f64) -> [f64; 3], at: impl Fn(f64) -> f64) -> String {
    let stops: Vec<String> = (0..=16).map(|i| hex(colour(at(f64::from(i) / 16.0)))).collect();
    format!("linear-gradient(to right, {})", stops.join(", "))
}

fn luminance(p: &[f32]) -> f64 {
    0.2126 * f64::from(p[0]) + 0.7152 * f64::from(p[1]) + 0.0722 * f64::from(p[2])
}

/// What a value is relative to: the reference's luminance, or a tenth of its mean where it is darker.
fn scales(reference: &Image) -> Vec<f64> {
    let y: Vec<f64> = reference.pixels().map(luminance).collect();
    let mean = y.iter().sum::<f64>() / y.len().max(1) as f64;
    y.into_iter().map(|y| y.max(0.1 * mean).max(1e-30)).collect()
}

/// A map of one layer, relative to the reference.
pub fn map(layer: &Image, reference: &Image, colour: impl Fn(f64) -> [f64; 3]) -> Option<Image> {
    let data =
        layer.pixels().zip(scales(reference)).flat_map(|(p, scale)| colour(luminance(p) / scale).map(|c| c as f32)).collect();
    Image::rgb(layer.width(), layer.height(), data).ok().map(|i| i.with_encoding(Encoding::SRGB))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_middles() {
        assert_eq!(diverging(0.0), DIVERGING[2]);
        assert_eq!((diverging(1.0), diverging(-1.0)), (DIVERGING[4], DIVERGING[0]));
        assert_eq!((sequential(0.0), sequential(1.0), sequential(f64::NAN)), (SEQUENTIAL[0], SEQUENTIAL[4], SEQUENTIAL[0]));
        assert_eq!(hex([1.0, 0.0, 0.5]), "#ff0080");
    }
}
