//! Refractive indices that have names: dielectrics by a number, conductors by measured n and k.

use super::{SampledSpectrum, cie};

/// Indices of refraction of transparent materials against vacuum, at about 589 nm and 0 °C to 20 °C [Hecht 2002, table 4.1].
pub const DIELECTRICS: [(&str, f32); 23] = [
    ("vacuum", 1.0),
    ("helium", 1.000036),
    ("hydrogen", 1.000132),
    ("air", 1.000277),
    ("carbon dioxide", 1.00045),
    ("water", 1.3330),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.52045),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.470),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.5750),
    ("diamond", 2.419),
];

/// The index of the dielectric `name`, letter case aside.
pub fn dielectric(name: &str) -> Option<f32> {
    DIELECTRICS.iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|&(_, eta)| eta)
}

/// Glass whose index follows from its resonances [Sellmeier 1872]:
///
/// ```text
/// n² = 1 + Σ_i B_i λ² / (λ² - C_i)        λ in µm against vacuum
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glass {
    b: [f64; 3],
    c: [f64; 3],
}

const fn glass_of(b: [f64; 3], c: [f64; 3]) -> Glass {
    Glass { b, c }
}

/// Optical glasses by their makers' coefficients (SCHOTT, Optical Glass Data Sheets), and fused silica [Malitson 1965]. `f5`, `f10` and `f11` are
/// pbrt's names for the dense flints SF5, SF10 and SF11.
pub const GLASSES: [(&str, Glass); 11] = [
    ("glass-bk7", glass_of([1.03961212, 0.231792344, 1.01046945], [0.00600069867, 0.0200179144, 103.560653])),
    ("glass-baf10", glass_of([1.5851495, 0.143559385, 1.08521269], [0.00926681282, 0.0424489805, 105.613573])),
    ("glass-fk51a", glass_of([0.971247817, 0.216901417, 0.904651666], [0.00472301995, 0.0153575612, 168.68133])),
    ("glass-lasf9", glass_of([2.00029547, 0.298926886, 1.80691843], [0.0121426017, 0.0538736236, 156.530829])),
    ("glass-sf5", SF5),
    ("glass-f5", SF5),
    ("glass-sf10", SF10),
    ("glass-f10", SF10),
    ("glass-sf11", SF11),
    ("glass-f11", SF11),
    ("glass-silica", glass_of([0.6961663, 0.4079426, 0.8974794], [0.004679148, 0.01351206, 97.934003])),
];
const SF5: Glass = glass_of([1.46141885, 0.247713019, 0.949995832], [0.0111826126, 0.0508594669, 112.041888]);
const SF10: Glass = glass_of([1.61625977, 0.259229334, 1.07762317], [0.0127534559, 0.0581983954, 116.60768]);
const SF11: Glass = glass_of([1.73848403, 0.311168974, 1.17490871], [0.0136068604, 0.0615960463, 121.922711]);

/// The glass `name`, letter case aside.
pub fn glass(name: &str) -> Option<Glass> {
    GLASSES.iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|&(_, glass)| glass)
}

impl Glass {
    /// n at a visible wavelength, nm.
    pub fn index(&self, nm: f64) -> f64 {
        let square = (nm * 1e-3).powi(2);
        (1.0 + self.b.iter().zip(self.c).map(|(b, c)| b * square / (square - c)).sum::<f64>()).sqrt()
    }
}

/// The measurements: see the head of the file.
static CONDUCTORS: &str = include_str!("data/conductors.txt");

/// A complex refractive index η + i k over the visible range.
#[derive(Clone, Debug, PartialEq)]
pub struct Conductor {
    /// The real part.
    pub eta: SampledSpectrum,
    /// The imaginary part: extinction.
    pub k: SampledSpectrum,
}

/// The names of all conductors, as chemical formulas; some have two. `none`, the perfect mirror, is not among them.
pub fn conductor_names() -> impl Iterator<Item = &'static str> {
    CONDUCTORS.lines().filter_map(head).flat_map(str::split_whitespace)
}

/// The names in a line that opens a material.
fn head(line: &str) -> Option<&str> {
    line.strip_prefix('[')?.strip_suffix(']')
}

impl Conductor {
    /// The measurements of the material `name`, in the letter case of its formula.
    pub fn named(name: &str) -> Option<Self> {
        let mut lines = CONDUCTORS.lines();
        lines.find(|line| head(line).is_some_and(|names| names.split_whitespace().any(|n| n == name)))?;
        let (mut eta, mut k) = (Vec::new(), Vec::new());
        for line in lines.take_while(|line| head(line).is_none()) {
            let mut numbers = line.split_whitespace().map_while(|word| word.parse::<f64>().ok());
            let (nm, n, extinction) = (numbers.next()?, numbers.next()?, numbers.next()?);
            eta.push((nm, n));
            k.push((nm, extinction));
        }
        Some(Self { eta: SampledSpectrum::new(&eta)?, k: SampledSpectrum::new(&k)? })
    }

    /// (η, k) for the red, green and blue lanes: each the colour of the spectrum under equal energy, as Mitsuba has it.
    pub fn to_rgb(&self) -> ([f32; 3], [f32; 3]) {
        (cie::emission_to_rgb(&self.eta), cie::emission_to_rgb(&self.k))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_known() {
        let names: Vec<_> = conductor_names().collect();
        assert_eq!(names.len(), 72);
        for name in names {
            let (eta, k) = Conductor::named(name).unwrap().to_rgb();
            assert!(eta.iter().chain(&k).all(|x| x.is_finite()) && eta.iter().any(|&x| x > 0.0), "{name}");
        }
        assert!(Conductor::named("au").is_none() && Conductor::named("").is_none() && Conductor::named("]").is_none());
        assert_eq!(dielectric("Water"), Some(1.333));
        assert_eq!(dielectric("milk"), None);
        assert!(DIELECTRICS.iter().all(|(name, eta)| *eta >= 1.0 && dielectric(name) == Some(*eta)));
    }

    /// The index at the d line and the Abbe number, as catalogues have them.
    #[test]
    fn glasses_disperse_as_their_data_sheets_say() {
        for (name, n, abbe) in [
            ("glass-bk7", 1.5168, 64.17),
            ("glass-BAF10", 1.67003, 47.11),
            ("glass-fk51a", 1.48656, 84.47),
            ("glass-lasf9", 1.85025, 32.17),
            ("glass-F5", 1.67270, 32.21),
            ("glass-sf10", 1.72825, 28.41),
            ("glass-f11", 1.78472, 25.76),
            ("glass-silica", 1.45846, 67.82),
        ] {
            let glass = glass(name).unwrap();
            let [d, f, c] = [587.5618, 486.1327, 656.2725].map(|nm| glass.index(nm));
            assert!((d - n).abs() < 2e-5 && ((d - 1.0) / (f - c) - abbe).abs() < 0.05, "{name}: {d} {}", (d - 1.0) / (f - c));
        }
        assert!(glass("glass-sf12").is_none());
    }

    /// Figures that Mitsuba 3.9.1 gives in RGB mode.
    #[test]
    fn conductors_are_those_of_mitsuba() {
        let rows: [(&str, [f32; 3], [f32; 3]); 12] = [
            ("Au", [0.143036, 0.375307, 1.44205], [3.983, 2.38556, 1.60336]),
            ("Ag", [0.155276, 0.116728, 0.138388], [4.82835, 3.12222, 2.1469]),
            ("Al", [1.6575, 0.880405, 0.521244], [9.22381, 6.2695, 4.837]),
            ("Cu", [0.201005, 0.92375, 1.10222], [3.91326, 2.45305, 2.14209]),
            ("a-C", [2.94405, 2.22714, 1.96816], [0.887465, 0.799299, 0.81529]),
            ("Cr", [4.36967, 2.91651, 1.6549], [5.20655, 4.23131, 3.7547]),
            ("W", [4.37082, 3.30025, 2.99841], [3.50064, 2.60487, 2.27323]),
            ("Hg", [2.39894, 1.44003, 0.90957], [6.32759, 4.37192, 3.42176]),
            ("d-C", [2.70872, 2.31883, 2.2289], [0.0, 0.0, 0.0]),
            ("Se-e", [5.72285, 4.16574, 4.08134], [0.871136, 1.10516, 1.56532]),
            ("TiO2_palik", [3.45661, 2.80174, 2.90517], [0.000105265, 0.0, 0.000652887]),
            ("Li", [0.265791, 0.195618, 0.220949], [3.54015, 2.31112, 1.66861]),
        ];
        for (name, eta, k) in rows {
            let ours = Conductor::named(name).unwrap().to_rgb();
            let pairs = ours.0.iter().zip(eta).chain(ours.1.iter().zip(k));
            pairs.for_each(|(a, b)| assert!((a - b).abs() < 2e-5 * b.abs().max(0.1), "{name}: {a} is not {b}"));
        }
    }
}
