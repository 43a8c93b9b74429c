//! Tabulated spectra: inert data, as a file gives them.

use serde::{Deserialize, Serialize};

/// Values at rising wavelengths, linear in between, zero beyond the ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<(f64, f64)>", into = "Vec<(f64, f64)>")]
pub struct SampledSpectrum {
    nm: Vec<f64>,
    values: Vec<f64>,
}

impl SampledSpectrum {
    /// The spectrum of (wavelength in nm, value) pairs; `None` unless there are two or more, finite, with strictly rising wavelengths.
    pub fn new(pairs: &[(f64, f64)]) -> Option<Self> {
        let finite = pairs.iter().all(|(nm, value)| nm.is_finite() && value.is_finite());
        let rising = pairs.windows(2).all(|w| w[0].0 < w[1].0);
        (pairs.len() >= 2 && finite && rising)
            .then(|| Self { nm: pairs.iter().map(|p| p.0).collect(), values: pairs.iter().map(|p| p.1).collect() })
    }

    /// Values at equal steps from `min` to `max` nm, both included; `None` as for [`SampledSpectrum::new`].
    pub fn regular(min: f64, max: f64, values: &[f64]) -> Option<Self> {
        let step = (max - min) / (values.len().max(2) - 1) as f64;
        let pairs: Vec<_> = values.iter().enumerate().map(|(i, &v)| (min + step * i as f64, v)).collect();
        Self::new(&pairs)
    }

    /// The value at the wavelength `nm`.
    pub fn eval(&self, nm: f64) -> f64 {
        let n = self.nm.len();
        if !(self.nm[0]..=self.nm[n - 1]).contains(&nm) {
            return 0.0;
        }
        let i = self.nm[1..n - 1].partition_point(|&w| w <= nm);
        let t = (nm - self.nm[i]) / (self.nm[i + 1] - self.nm[i]);
        self.values[i] + t * (self.values[i + 1] - self.values[i])
    }

    /// The value at the wavelength `nm`; beyond the ends as at the ends.
    pub fn eval_clamped(&self, nm: f64) -> f64 {
        self.eval(nm.clamp(self.nm[0], self.nm[self.nm.len() - 1]))
    }

    /// The pairs.
    pub fn pairs(&self) -> impl Iterator<Item = (f64, f64)> {
        self.nm.iter().copied().zip(self.values.iter().copied())
    }

    /// The same spectrum with each value through `f`; values that are not finite become zero.
    pub fn map(&self, f: impl Fn(f64) -> f64) -> Self {
        let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
        Self { nm: self.nm.clone(), values: self.values.iter().map(|&v| finite(f(v))).collect() }
    }
}

impl TryFrom<Vec<(f64, f64)>> for SampledSpectrum {
    type Error = &'static str;

    fn try_from(pairs: Vec<(f64, f64)>) -> Result<Self, Self::Error> {
        Self::new(&pairs).ok_or("a spectrum needs two or more finite values at rising wavelengths")
    }
}

impl From<SampledSpectrum> for Vec<(f64, f64)> {
    fn from(s: SampledSpectrum) -> Self {
        s.pairs().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_interpolated() {
        let s = SampledSpectrum::new(&[(400.0, 1.0), (500.0, 3.0), (700.0, 2.0)]).unwrap();
        for (nm, v) in
            [(400.0, 1.0), (450.0, 2.0), (500.0, 3.0), (600.0, 2.5), (700.0, 2.0), (399.0, 0.0), (701.0, 0.0), (f64::NAN, 0.0)]
        {
            assert_eq!(s.eval(nm), v);
        }
        assert_eq!(SampledSpectrum::regular(400.0, 600.0, &[1.0, 3.0, 2.0]).unwrap().eval(550.0), 2.5);
        assert_eq!(s.map(|v| 2.0 * v).eval(450.0), 4.0);
        for bad in [&[][..], &[(1.0, 1.0)], &[(2.0, 1.0), (1.0, 1.0)], &[(1.0, 1.0), (1.0, 2.0)], &[(1.0, f64::NAN), (2.0, 0.0)]] {
            assert!(SampledSpectrum::new(bad).is_none());
        }
        assert!(SampledSpectrum::regular(400.0, 600.0, &[1.0]).is_none());
        assert!(SampledSpectrum::regular(600.0, 400.0, &[1.0, 2.0]).is_none());
    }
}
