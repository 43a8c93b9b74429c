//! From the light of a scene to the code values of a display.
//!
//! ```text
//! L' = 2^E · L          E the exposure in EV
//! D  = curve(L')        display light, linear Rec.709 in [0, 1]
//! V  = sRGB(D)          code values
//! ```
//!
//! | name | D | source |
//! | --- | --- | --- |
//! | `srgb` | min(L', 1) | none: what a display can show is shown as it is |
//! | `reinhard` | L' / (1 + Y), Y the luminance of L' | [Reinhard et al. 2002, eq. 3] |
//! | `aces` | fit of the ACES reference and output transforms | [Hill 2016] |
//! | `agx` | inset, sigmoid over 16.5 stops, outset | [Sobotka 2022; fit by Wrensch 2023] |

use std::fmt;
use std::str::FromStr;

use etendue_numerics::math;

use crate::colour::{Encoding, Matrix, apply, linear_to_srgb, luminance};
use crate::image::Image;

/// A tone curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curve {
    /// Clipping.
    #[default]
    Srgb,
    /// L / (1 + Y): never clips a grey.
    Reinhard,
    /// The film-like curve of ACES; strong contrast.
    Aces,
    /// AgX: bright colours fade to white without turning their hue.
    Agx,
}

impl Curve {
    /// All of them.
    pub const ALL: [Curve; 4] = [Curve::Srgb, Curve::Reinhard, Curve::Aces, Curve::Agx];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Curve::Srgb => "srgb",
            Curve::Reinhard => "reinhard",
            Curve::Aces => "aces",
            Curve::Agx => "agx",
        }
    }

    /// Display light of scene light, both linear Rec.709; the result lies in [0, 1]. Negative light and what is no
    /// number count as black, infinite light as the brightest there is.
    pub fn apply(self, rgb: [f32; 3]) -> [f32; 3] {
        // 10⁹ is white under every curve and overflows in none.
        let l = rgb.map(|x| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1e9) });
        let d = match self {
            Curve::Srgb => l,
            Curve::Reinhard => l.map(|x| x / (1.0 + luminance(l))),
            Curve::Aces => aces(l),
            Curve::Agx => agx(l),
        };
        d.map(|x| x.clamp(0.0, 1.0))
    }
}

impl fmt::Display for Curve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is no tone curve's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownCurve(String);

impl fmt::Display for UnknownCurve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} is no tone curve; there are {}", self.0, Curve::ALL.map(Curve::name).join(", "))
    }
}

impl std::error::Error for UnknownCurve {}

impl FromStr for Curve {
    type Err = UnknownCurve;

    fn from_str(name: &str) -> Result<Self, UnknownCurve> {
        let lower = name.to_ascii_lowercase();
        Curve::ALL.into_iter().find(|c| c.name() == lower).ok_or_else(|| UnknownCurve(name.to_owned()))
    }
}

/// Exposure and curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToneMap {
    /// E in EV: one more doubles the light.
    pub exposure: f32,
    /// The curve.
    pub curve: Curve,
}

impl ToneMap {
    /// sRGB code values in [0, 1] of linear Rec.709 light.
    pub fn apply(&self, rgb: [f32; 3]) -> [f32; 3] {
        let scale = self.exposure.exp2();
        // Where an extreme exposure makes 0 · ∞, the curve takes it for black.
        self.curve.apply(rgb.map(|x| x * scale)).map(linear_to_srgb)
    }

    /// A picture for the display: R, G, B (and A as it is) in sRGB, ready for PNG or JPEG.
    #[must_use]
    pub fn image(&self, image: &Image) -> Image {
        let linear = image.to_linear();
        let mut shown = linear.to_rgb();
        if let Some(alpha) = linear.channel("A") {
            let data = shown.pixels().zip(linear.pixels()).flat_map(|(p, q)| [p[0], p[1], p[2], q[alpha]]).collect();
            shown = linear.with_channels(&["R", "G", "B", "A"], data);
        }
        let n = shown.channel_count();
        for p in shown.data_mut().chunks_exact_mut(n) {
            let v = self.apply([p[0], p[1], p[2]]);
            p[..3].copy_from_slice(&v);
        }
        shown.with_encoding(Encoding::SRGB)
    }
}

/// M v in f32.
fn transform(m: &Matrix, v: [f32; 3]) -> [f32; 3] {
    apply(m, v.map(f64::from)).map(|x| x as f32)
}

/// The fit of the ACES RRT and sRGB ODT of [Hill 2016]: to AP1 with the RRT's desaturation, a rational curve, and back.
fn aces(rgb: [f32; 3]) -> [f32; 3] {
    const IN: Matrix = [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
    const OUT: Matrix = [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
    let fit = |v: f32| (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081);
    transform(&OUT, transform(&IN, rgb).map(fit))
}

/// AgX by the fit of [Wrensch 2023]: inset of the primaries, 16.5 stops of log2 light onto [0, 1], a polynomial for the
/// sigmoid, outset; the result is code values of a display of gamma 2.2.
fn agx(rgb: [f32; 3]) -> [f32; 3] {
    const IN: Matrix = [
        [0.842_479_062_253_094, 0.078_433_599_999_999_2, 0.079_223_745_147_764_3],
        [0.042_328_242_261_012_3, 0.878_468_636_469_772, 0.079_166_127_460_543_4],
        [0.042_375_654_905_705_1, 0.078_433_6, 0.879_142_973_793_104],
    ];
    const OUT: Matrix = [
        [1.196_879_005_120_17, -0.098_020_881_140_136_8, -0.099_029_744_079_720_5],
        [-0.052_896_851_757_456_2, 1.151_903_129_904_17, -0.098_961_176_844_843_3],
        [-0.052_971_635_514_443_8, -0.098_043_450_117_124_1, 1.151_073_672_641_16],
    ];
    const DARKEST: f32 = -12.473_93;
    const BRIGHTEST: f32 = 4.026_069;
    let sigmoid = |x: f32| {
        let coefficients = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232];
        coefficients.iter().fold(0.0, |sum, c| sum * x + c)
    };
    let stops =
        |v: f32| ((math::ln(v.max(1e-10)) * std::f32::consts::LOG2_E).clamp(DARKEST, BRIGHTEST) - DARKEST) / (BRIGHTEST - DARKEST);
    let code = transform(&OUT, transform(&IN, rgb).map(|v| sigmoid(stops(v))));
    code.map(|v| math::powf(v.max(0.0), 2.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_told() {
        for c in Curve::ALL {
            assert_eq!(c.name().parse::<Curve>(), Ok(c));
        }
        let e = "filmic".parse::<Curve>().unwrap_err().to_string();
        assert!(e.contains("filmic") && e.contains("srgb, reinhard, aces, agx"), "{e}");
    }

    #[test]
    fn curves_rise_from_black_to_white() {
        for curve in Curve::ALL {
            assert!(curve.apply([0.0; 3])[0] < 2e-3, "{curve} of black");
            assert!(curve.apply([1e6; 3])[1] > 0.97, "{curve} of a light: {:?}", curve.apply([1e6; 3]));
            let mut last = 0.0;
            for i in 0..400 {
                let [r, g, b] = curve.apply([(i as f32 / 20.0 - 15.0).exp2(); 3]);
                assert!(g >= last - 2e-4, "{curve} falls at step {i}");
                assert!((r - g).abs() < 0.01 && (b - g).abs() < 0.01, "{curve} colours a grey: {r} {g} {b}");
                last = g;
            }
            for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1.0, 1e-45] {
                assert!(curve.apply([x, 0.5, x]).iter().all(|v| (0.0..=1.0).contains(v)), "{curve} of {x}");
            }
        }
    }

    #[test]
    fn published_values() {
        assert_eq!(Curve::Reinhard.apply([1.0; 3])[0], 0.5);
        // The rational curve of a grey: the matrices' rows sum to 1 within their digits.
        let x = 0.18f32;
        let fit = (x * (x + 0.024_578_6) - 0.000_090_537) / (x * (0.983_729 * x + 0.432_951) + 0.238_081);
        assert!((Curve::Aces.apply([x; 3])[1] - fit).abs() < 1e-4);
        // AgX's sigmoid turns about middle grey, which it sends to half of the code values [Sobotka 2022].
        let code = Curve::Agx.apply([0.18; 3])[1].powf(1.0 / 2.2);
        assert!((code - 0.5).abs() < 0.01, "{code}");
    }

    #[test]
    fn exposure_doubles() {
        let half = ToneMap { exposure: -1.0, curve: Curve::Srgb };
        assert_eq!(half.apply([0.5; 3]), [linear_to_srgb(0.25); 3]);
        let extreme = ToneMap { exposure: 1e9, curve: Curve::Aces };
        assert!(extreme.apply([0.0; 3]).iter().all(|v| *v < 0.01));
    }
}
