//! The standard observer, and spectra as linear Rec.709.
//!
//! ```text
//! X = (1/N) ∫ S(λ) x̄(λ) dλ  (Y, Z alike),   N = ∫ ȳ(λ) dλ,   λ from 360 nm to 830 nm;   (R, G, B) = M (X, Y, Z)
//! ```
//!
//! A spectrum of one everywhere thus has Y = 1: radiometric and photometric scale agree but for the 683 lm/W of the watt. How a spectrum
//! becomes three numbers depends on what it is, in the rules of Mitsuba 3.9's RGB mode, to which these functions agree to 1e-5:
//!
//! | what | rule | function |
//! | --- | --- | --- |
//! | reflectance, transmittance, any factor | seen under D65, so that white stays (1, 1, 1); clamped to \[0, 1\] | [`reflectance_to_rgb`] |
//! | other factors and numbers without an upper bound, such as a medium's coefficients, or η and k written as spectra | under D65; clamped below at 0 | [`unbounded_to_rgb`] |
//! | emission | itself, so that equal energy is reddish under the D65 white of Rec.709; clamped below at 0 | [`emission_to_rgb`] |
//! | η and k of a named material | as emission (equal energy) | [`emission_to_rgb`] |
//! | one number within an emitter | that much of equal energy, exactly | [`constant_emission_to_rgb`] |
//! | one number elsewhere | itself in every channel | |
//! | the illuminant `d65` | its scale in every channel, within an emitter or not | |
//! | a black body | (Mitsuba: refused in RGB mode) emission, W/(m² sr nm) | [`blackbody_to_rgb`] |
//!
//! The integrals are sums at 1000 equidistant wavelengths, both ends included, each weighing 470 nm / 1000 (and not / 999: the sums lack 0.1 %).
//! Between its entries a spectrum is linear; beyond its ends it is zero. Observer: CIE 1931, 2°, in steps of 5 nm.

use super::SampledSpectrum;

/// The shortest wavelength considered, nm.
pub const LAMBDA_MIN: f64 = 360.0;
/// The longest wavelength considered, nm.
pub const LAMBDA_MAX: f64 = 830.0;
/// N = ∫ ȳ dλ in nm, over the tabulated observer.
pub const Y_INTEGRAL: f64 = 106.750_259_399_414_06;
/// ∫ S ȳ dλ / N for the tabulated illuminant D65: what it is divided by to have Y = 1.
pub const D65_LUMINANCE: f64 = 98.997_417_518_762_55;

/// x̄, ȳ, z̄ and D65 at 360 nm, 365 nm, …, 830 nm.
static TABLE: [[f64; 4]; 95] = include!("data/cie_1931_d65_5nm.in");

/// Wavelengths at which integrals are taken.
const STEPS: usize = 1000;

/// Entries of the table at `nm`, linear in between; zero outside it.
fn table(nm: f64) -> [f64; 4] {
    if !(LAMBDA_MIN..=LAMBDA_MAX).contains(&nm) {
        return [0.0; 4];
    }
    let at = (nm - LAMBDA_MIN) / 5.0;
    let i = (at as usize).min(TABLE.len() - 2);
    let t = at - i as f64;
    std::array::from_fn(|c| TABLE[i][c] + t * (TABLE[i + 1][c] - TABLE[i][c]))
}

/// x̄, ȳ, z̄ at the wavelength `nm`, not normalised: ȳ is about 1 at 555 nm.
pub fn observer(nm: f64) -> [f64; 3] {
    let [x, y, z, _] = table(nm);
    [x, y, z]
}

/// The illuminant D65 at the wavelength `nm`, scaled to Y = 1.
pub fn d65(nm: f64) -> f64 {
    table(nm)[3] / D65_LUMINANCE
}

/// Linear Rec.709 of (X, Y, Z), white point D65 [ITU-R BT.709]; not clamped.
pub fn xyz_to_rgb([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.240_479 * x - 1.537_150 * y - 0.498_535 * z,
        -0.969_256 * x + 1.875_991 * y + 0.041_556 * z,
        0.055_648 * x - 0.204_043 * y + 1.057_311 * z,
    ]
}

/// (X, Y, Z) of linear Rec.709.
pub fn rgb_to_xyz([r, g, b]: [f64; 3]) -> [f64; 3] {
    [
        0.412_453 * r + 0.357_580 * g + 0.180_423 * b,
        0.212_671 * r + 0.715_160 * g + 0.072_169 * b,
        0.019_334 * r + 0.119_193 * g + 0.950_227 * b,
    ]
}

/// (X, Y, Z) of S(λ), `nm` running over the visible range; a spectrum of one has Y = 1 (0.999, see above).
pub fn spectrum_to_xyz(s: impl Fn(f64) -> f64) -> [f64; 3] {
    let mut xyz = [0.0; 3];
    for i in 0..STEPS {
        let nm = LAMBDA_MIN + i as f64 / (STEPS - 1) as f64 * (LAMBDA_MAX - LAMBDA_MIN);
        let (value, bars) = (s(nm), observer(nm));
        (0..3).for_each(|c| xyz[c] += value * bars[c]);
    }
    xyz.map(|sum| sum * (LAMBDA_MAX - LAMBDA_MIN) / STEPS as f64 / Y_INTEGRAL)
}

fn clamped(rgb: [f64; 3], high: f64) -> [f32; 3] {
    rgb.map(|x| x.clamp(0.0, high) as f32)
}

/// A reflectance (or any factor in [0, 1]) as linear Rec.709.
pub fn reflectance_to_rgb(s: &SampledSpectrum) -> [f32; 3] {
    clamped(xyz_to_rgb(spectrum_to_xyz(|nm| s.eval(nm) * d65(nm))), 1.0)
}

/// A quantity without an upper bound that is not emission, as linear Rec.709.
pub fn unbounded_to_rgb(s: &SampledSpectrum) -> [f32; 3] {
    clamped(xyz_to_rgb(spectrum_to_xyz(|nm| s.eval(nm) * d65(nm))), f64::INFINITY)
}

/// An emitted quantity, per nm, as linear Rec.709 in the same unit.
pub fn emission_to_rgb(s: &SampledSpectrum) -> [f32; 3] {
    clamped(xyz_to_rgb(spectrum_to_xyz(|nm| s.eval(nm))), f64::INFINITY)
}

/// An emitted quantity that is the same at every wavelength.
pub fn constant_emission_to_rgb(value: f64) -> [f32; 3] {
    clamped(xyz_to_rgb([value; 3]), f64::INFINITY)
}

/// Planck's law: the radiance of a black body of `kelvin` at the wavelength `nm`, in W/(m² sr nm).
///
/// ```text
/// B(λ, T) = (2 h c² / λ⁵) / (exp(h c / (λ k T)) - 1)                                         [Planck 1900]
/// ```
pub fn blackbody(nm: f64, kelvin: f64) -> f64 {
    const C: f64 = 299_792_458.0;
    const H: f64 = 6.626_070_15e-34;
    const K: f64 = 1.380_649e-23;
    if kelvin.is_nan() || kelvin <= 0.0 {
        return 0.0;
    }
    let lambda = nm * 1e-9;
    1e-9 * 2.0 * H * C * C / (lambda.powi(5) * (H * C / (lambda * K * kelvin)).exp_m1())
}

/// The radiance of a black body of `kelvin` as linear Rec.709, W/(m² sr nm); out-of-gamut channels are zero.
pub fn blackbody_to_rgb(kelvin: f64) -> [f32; 3] {
    clamped(xyz_to_rgb(spectrum_to_xyz(|nm| blackbody(nm, kelvin))), f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: [f32; 3], b: [f64; 3]) {
        for (a, b) in a.iter().zip(b) {
            assert!((f64::from(*a) - b).abs() <= 1e-5 * b.abs().max(0.1), "{a} is not {b}");
        }
    }

    #[test]
    fn the_table_is_the_observer() {
        assert!((observer(555.0)[1] - 1.0).abs() < 1e-12 && (observer(602.5)[0] - 0.5 * (1.0622 + 1.0456)).abs() < 1e-12);
        assert_eq!(observer(359.9), [0.0; 3]);
        assert!((d65(560.0) * D65_LUMINANCE - 100.0).abs() < 1e-12);
        // The published constants belong to the table: trapezoids of 5 nm.
        let y: f64 = TABLE.iter().map(|row| 5.0 * row[1]).sum();
        assert!((y / Y_INTEGRAL - 1.0).abs() < 2e-3, "{y}");
        let [x, y, z] = spectrum_to_xyz(d65);
        // Chromaticity of D65 [CIE 15:2004], and luminance one.
        assert!((x / (x + y + z) - 0.312_72).abs() < 2e-4 && (y / (x + y + z) - 0.329_03).abs() < 2e-4 && (y - 1.0).abs() < 2e-3);
    }

    #[test]
    fn colours_return() {
        let there_and_back = xyz_to_rgb(rgb_to_xyz([0.2, 0.5, 0.9]));
        assert!(
            (there_and_back[0] - 0.2).abs() < 1e-5
                && (there_and_back[1] - 0.5).abs() < 1e-5
                && (there_and_back[2] - 0.9).abs() < 1e-5
        );
    }

    /// Figures that Mitsuba 3.9.1 gives for the same spectra in RGB mode: reflectance, unbounded, emission.
    #[test]
    fn spectra_become_the_colours_that_mitsuba_makes_of_them() {
        let check = |pairs: &[(f64, f64)], reflectance, unbounded, emission| {
            let s = SampledSpectrum::new(pairs).unwrap();
            close(reflectance_to_rgb(&s), reflectance);
            close(unbounded_to_rgb(&s), unbounded);
            close(emission_to_rgb(&s), emission);
        };
        let green = [0.390572, 0.644741, 0.401535];
        check(&[(400.0, 0.1), (500.0, 0.7), (700.0, 0.3)], green, green, [0.490862, 0.612933, 0.354299]);
        let white = [0.998983, 0.998872, 0.998802];
        check(&[(360.0, 1.0), (830.0, 1.0)], white, white, [1.20488, 0.948229, 0.909267]);
        let cyan = [0.0, 0.567595, 0.470146];
        check(&[(400.0, 0.2), (500.0, 0.7), (600.0, 0.3)], cyan, cyan, [0.0, 0.539728, 0.421077]);
        let narrow = [0.0, 0.193768, 0.0145861];
        check(&[(500.0, 1.0), (520.0, 1.0)], narrow, narrow, [0.0, 0.179048, 0.0132494]);
        check(&[(450.0, 4.0), (900.0, 2.0)], [1.0, 1.0, 1.0], [2.88776, 3.83067, 2.00565], [3.56965, 3.64813, 1.66101]);
        close(constant_emission_to_rgb(0.4), [0.481918, 0.379316, 0.363566]);
    }

    #[test]
    fn black_bodies_radiate() {
        // Mitsuba 3.9.1, spectral mode, 5000 K (its constants are of 2014, so the last digits differ).
        for (nm, b) in [(400.0, 8743.57), (500.0, 12107.2), (600.0, 12762.4), (700.0, 11812.0)] {
            assert!((blackbody(nm, 5000.0) / b - 1.0).abs() < 1e-5);
        }
        // Stefan and Boltzmann: ∫ B dλ = σ T⁴/π.
        let total: f64 = (1..200_000).map(|i| blackbody(f64::from(i) + 0.5, 5000.0)).sum();
        assert!((total / (5.670_374_419e-8 * 5000f64.powi(4) / std::f64::consts::PI) - 1.0).abs() < 1e-4);
        let [r, g, b] = blackbody_to_rgb(6500.0);
        assert!((r / g - 1.0).abs() < 0.08 && (b / g - 1.0).abs() < 0.08, "near white, a little pink: {r} {g} {b}");
        assert_eq!(blackbody_to_rgb(0.0), [0.0; 3]);
        assert_eq!(blackbody_to_rgb(f64::NAN), [0.0; 3]);
        assert!(blackbody_to_rgb(1e-3).iter().all(|x| x.is_finite()) && blackbody_to_rgb(1e9).iter().all(|x| x.is_finite()));
    }
}
