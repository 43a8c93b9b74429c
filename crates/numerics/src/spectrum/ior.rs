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
        assert_eq!(names.len(), 71);
        for name in names {
            let (eta, k) = Conductor::named(name).unwrap().to_rgb();
            assert!(eta.iter().chain(&k).all(|x| x.is_finite()) && eta.iter().any(|&x| x > 0.0), "{name}");
        }
        assert!(Conductor::named("au").is_none() && Conductor::named("").is_none() && Conductor::named("]").is_none());
        assert_eq!(dielectric("Water"), Some(1.333));
        assert_eq!(dielectric("milk"), None);
        assert!(DIELECTRICS.iter().all(|(name, eta)| *eta >= 1.0 && dielectric(name) == Some(*eta)));
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
