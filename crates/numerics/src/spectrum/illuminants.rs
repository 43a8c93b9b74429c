//! Standard illuminants: spectra of lamps and of daylight that have names.
//!
//! ```text
//! A     Planck's law at 2855.54 K
//! Dnn   S(λ) = S0(λ) + M1 S1(λ) + M2 S2(λ)                       daylight of a colour temperature T                [CIE 15:2004, §3.1]
//!       x = -4.6070e9/T³ + 2.9678e6/T² + 99.11/T + 0.244063,  y = -3 x² + 2.87 x - 0.275       4000 K ≤ T ≤ 7000 K
//!       M1 = (-1.3515 - 1.7703 x + 5.9114 y)/M,  M2 = (0.03 - 31.4424 x + 30.0717 y)/M,  M = 0.0241 + 0.2562 x - 0.7341 y
//! F1 … F12    fluorescent lamps, tabulated                                                      [CIE 15:2004, table T.6.1]
//! ```
//!
//! Values are relative. D50 and D60 stand for 1.4388/1.438 times their names' temperatures, since c₂ of Planck's law has changed since they were named.

use super::{SampledSpectrum, cie};

/// Every name.
pub const ILLUMINANTS: [&str; 16] =
    ["A", "D50", "D60", "D65", "F1", "F2", "F3", "F4", "F5", "F6", "F7", "F8", "F9", "F10", "F11", "F12"];

/// What was measured: see the head of the file.
static TABLES: &str = include_str!("data/illuminants.txt");

/// The numbers of the table `name`.
fn table(name: &str) -> Vec<f64> {
    let mut lines = TABLES.lines();
    let found = lines.find(|line| line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) == Some(name));
    let numbers = found.and(lines.next()).unwrap_or_default();
    numbers.split_ascii_whitespace().filter_map(|word| word.parse().ok()).collect()
}

/// Daylight of the colour temperature `kelvin`.
pub fn daylight(kelvin: f64) -> Option<SampledSpectrum> {
    let t = 1.0 / kelvin;
    let x = ((-4.6070e9 * t + 2.9678e6) * t + 99.11) * t + 0.244063;
    let y = (2.87 - 3.0 * x) * x - 0.275;
    let m = 0.0241 + 0.2562 * x - 0.7341 * y;
    let [m1, m2] = [(-1.3515 - 1.7703 * x + 5.9114 * y) / m, (0.03 - 31.4424 * x + 30.0717 * y) / m];
    let [s0, s1, s2] = ["S0", "S1", "S2"].map(table);
    let values: Vec<f64> = (0..s0.len()).map(|i| s0[i] + m1 * s1[i] + m2 * s2[i]).collect();
    SampledSpectrum::regular(cie::LAMBDA_MIN, cie::LAMBDA_MAX, &values)
}

/// The illuminant `name`.
pub fn illuminant(name: &str) -> Option<SampledSpectrum> {
    let visible = |s: &dyn Fn(f64) -> f64| {
        let values: Vec<f64> = (0..95).map(|i| s(cie::LAMBDA_MIN + 5.0 * f64::from(i))).collect();
        SampledSpectrum::regular(cie::LAMBDA_MIN, cie::LAMBDA_MAX, &values)
    };
    const RENAMED: f64 = 1.4388 / 1.438;
    match name {
        "A" => visible(&|nm| cie::blackbody(nm, 2855.54)),
        "D50" => daylight(5000.0 * RENAMED),
        "D60" => daylight(6000.0 * RENAMED),
        "D65" => visible(&cie::d65),
        _ if ILLUMINANTS.contains(&name) => SampledSpectrum::regular(380.0, 780.0, &table(name)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chromaticities as the CIE publishes them [CIE 15:2004, tables T.3 and T.6.1]; of D60 the white of ACES [SMPTE ST 2065-1].
    #[test]
    fn illuminants_have_their_colours() {
        let rows = [
            ("A", 0.44757, 0.40745),
            ("D50", 0.34567, 0.35850),
            ("D60", 0.32168, 0.33767),
            ("D65", 0.31272, 0.32903),
            ("F1", 0.3131, 0.3371),
            ("F2", 0.3721, 0.3751),
            ("F3", 0.4091, 0.3941),
            ("F4", 0.4402, 0.4031),
            ("F5", 0.3138, 0.3452),
            ("F6", 0.3779, 0.3882),
            ("F7", 0.3129, 0.3292),
            ("F8", 0.3458, 0.3586),
            ("F9", 0.3741, 0.3727),
            ("F10", 0.3458, 0.3588),
            ("F11", 0.3805, 0.3769),
            ("F12", 0.4370, 0.4042),
        ];
        assert_eq!(rows.map(|r| r.0), ILLUMINANTS);
        // The tables step by 5 nm; what lies between is interpolated, and moves those with lines by some 1e-4.
        for (name, x, y) in rows {
            let s = illuminant(name).unwrap();
            let [a, b, c] = cie::spectrum_to_xyz(|nm| s.eval(nm));
            let found = [a / (a + b + c), b / (a + b + c)];
            assert!((found[0] - x).abs() < 5e-4 && (found[1] - y).abs() < 5e-4, "{name}: {found:?}");
        }
        assert!(illuminant("F13").is_none() && illuminant("S0").is_none());
    }

    /// Daylight's formula gives the table of D65.
    #[test]
    fn d65_is_daylight() {
        let [formula, table] = [daylight(6503.6).unwrap(), illuminant("D65").unwrap()];
        let scale = table.eval(560.0) / formula.eval(560.0);
        for nm in (380..=780).step_by(10).map(f64::from) {
            assert!((formula.eval(nm) * scale / table.eval(nm) - 1.0).abs() < 5e-3, "{nm}");
        }
    }
}
