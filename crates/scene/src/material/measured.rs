//! `measured`: a material as a photometer saw it [Dupuy, Jakob 2018]. Parameter `filename`: its file.
//!
//! Tables of wavelengths become red, green and blue under D65 for walks that carry these; tables of colours become smooth spectra, every 10 nm, for walks that
//! carry wavelengths.

use super::{Single, Site};
use etendue_bsdf::{
    Event, Lobe,
    lobes::{self, Grid, MeasuredError, MeasuredParams, MeasuredTable},
};
use etendue_description::{MeasuredData, TableData};
use etendue_numerics::spectrum::{cie, upsample::Smooth};
use glam::Vec4;
use std::sync::Arc;

/// A measured material.
#[derive(Clone, Debug)]
pub struct Measured {
    table: Arc<MeasuredTable>,
}

impl Measured {
    /// The material of a file, for walks that carry wavelengths or not.
    ///
    /// # Errors
    /// Names the table that is none.
    pub fn new(data: &MeasuredData, spectral: bool) -> Result<Self, MeasuredError> {
        let (channels, spectra) = match (spectral, data.wavelengths.is_empty()) {
            (true, false) => (data.wavelengths.clone(), data.spectra.values.clone()),
            (false, true) => (RGB.to_vec(), data.spectra.values.clone()),
            (false, false) => (RGB.to_vec(), in_channels(data, data.wavelengths.len(), &seen(&data.wavelengths))),
            (true, true) => {
                let nm: Vec<f32> = (36..=83).map(|i| 10.0 * i as f32).collect();
                let values = smooth(data, &nm);
                (nm, values)
            }
        };
        let grid = |t: &TableData| Grid { size: t.size, values: t.values.clone() };
        let table = MeasuredTable::new(MeasuredParams {
            phi: data.phi.clone(),
            theta: data.theta.clone(),
            channels,
            ndf: grid(&data.ndf),
            sigma: grid(&data.sigma),
            vndf: grid(&data.vndf),
            luminance: grid(&data.luminance),
            spectra: Grid { size: data.spectra.size, values: spectra },
            jacobian: data.jacobian,
        })?;
        Ok(Self { table: Arc::new(table) })
    }
}

const RGB: [f32; 3] = [0.0, 1.0, 2.0];

/// How much red, green and blue see of each wavelength: ∫ D65 s̄ over the hat function around it, 1 for all together.
fn seen(nm: &[f32]) -> Vec<[f32; 3]> {
    let mut sums = vec![[0.0f64; 3]; nm.len()];
    for wave in 360..=830 {
        let at = f64::from(wave);
        let response = cie::xyz_to_rgb(cie::observer(at)).map(|s| s * cie::d65(at));
        let i = nm.partition_point(|x| f64::from(*x) <= at).clamp(1, nm.len().max(2) - 1) - 1;
        let t = nm.get(i + 1).map_or(0.0, |next| ((at - f64::from(nm[i])) / f64::from(next - nm[i])).clamp(0.0, 1.0));
        for (j, share) in [(i, 1.0 - t), (i + 1, t)] {
            if share > 0.0 {
                (0..3).for_each(|c| sums[j][c] += share * response[c]);
            }
        }
    }
    let whole = [0, 1, 2].map(|c| sums.iter().map(|s| s[c]).sum::<f64>());
    sums.iter().map(|s| [0, 1, 2].map(|c| (s[c] / whole[c]) as f32)).collect()
}

/// The tables of `count` channels as tables of red, green and blue, of which each channel makes `weights`.
fn in_channels(data: &MeasuredData, count: usize, weights: &[[f32; 3]]) -> Vec<f32> {
    let size = data.spectra.size[0] * data.spectra.size[1];
    let colours = |tables: &[f32]| -> Vec<f32> {
        let at = |c: usize, i: usize| (0..count).map(|k| weights[k][c] * tables[k * size + i]).sum::<f32>().max(0.0);
        (0..3).flat_map(|c| (0..size).map(move |i| (c, i))).map(|(c, i)| at(c, i)).collect()
    };
    data.spectra.values.chunks_exact(size * count).flat_map(colours).collect()
}

/// The tables of red, green and blue as tables of wavelengths.
fn smooth(data: &MeasuredData, nm: &[f32]) -> Vec<f32> {
    let size = data.spectra.size[0] * data.spectra.size[1];
    let mut values = Vec::with_capacity(data.spectra.values.len() / 3 * nm.len());
    for tables in data.spectra.values.chunks_exact(3 * size) {
        let colour = |i: usize| [tables[i], tables[size + i], tables[2 * size + i]].map(|x| x.max(0.0));
        let fits: Vec<(f32, Smooth)> = (0..size)
            .map(|i| {
                let largest = colour(i).into_iter().fold(0.0, f32::max);
                let scale = 2.0 * largest.max(f32::MIN_POSITIVE);
                (2.0 * largest, Smooth::near(colour(i).map(|x| x / scale)))
            })
            .collect();
        for nm in nm {
            values.extend(fits.iter().map(|(scale, smooth)| scale * smooth.at(Vec4::splat(*nm)).x));
        }
    }
    values
}

impl Single for Measured {
    fn events(&self) -> Event {
        Event::REFLECT.with(Event::GLOSSY)
    }

    fn lobe(&self, at: &Site) -> Lobe<'_> {
        lobes::Measured::new(&self.table, at.wl).into()
    }
}
