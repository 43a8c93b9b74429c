//! The tables of a measured sample, made once per material.

use super::Measured;
use crate::Scatter;
use etendue_numerics::math::{FRAC_1_PI, PI};
use etendue_numerics::table::{Sheets, Warp};
use etendue_numerics::{Vec2, Vec3};

/// Numbers on a grid, row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    /// Columns and rows.
    pub size: [usize; 2],
    /// The numbers, of one grid behind the other where there are several.
    pub values: Vec<f32>,
}

/// What a [`MeasuredTable`] is made of; several grids stand in the order of azimuth, elevation, channel, the last one fastest. Columns are elevations of normals,
/// rows are azimuths.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasuredParams {
    /// Azimuths of `wo` that were measured, rising, in [-π, π]; one or two of them for an isotropic sample.
    pub phi: Vec<f32>,
    /// Elevations of `wo`, rising from 0.
    pub theta: Vec<f32>,
    /// Channels of `spectra`: wavelengths in nm, rising, or 0, 1, 2 for red, green and blue.
    pub channels: Vec<f32>,
    /// D.
    pub ndf: Grid,
    /// σ.
    pub sigma: Grid,
    /// v.
    pub vndf: Grid,
    /// l.
    pub luminance: Grid,
    /// M, over a grid of the size of l.
    pub spectra: Grid,
    /// Whether D/(4 σ) is still to be multiplied with; default false.
    pub jacobian: bool,
}

/// What of a sample is not a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeasuredError(pub &'static str);

/// A measured sample.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredTable {
    pub(super) ndf: Sheets<0>,
    pub(super) sigma: Sheets<0>,
    pub(super) vndf: Warp<2>,
    pub(super) luminance: Warp<2>,
    pub(super) spectra: Sheets<3>,
    pub(super) isotropic: bool,
    pub(super) jacobian: bool,
    /// How often the measured azimuths go round the circle: 1, 2 or 4.
    pub(super) reduction: u32,
    /// α of a GGX surface of the same D at its pole.
    pub(super) roughness: f32,
    /// What of the light from 45 degrees is reflected, by channel.
    albedo: Vec<f32>,
}

impl MeasuredTable {
    /// The tables of these numbers.
    ///
    /// # Errors
    /// Names the table whose numbers are too few or too many, or whose axis does not rise.
    pub fn new(p: MeasuredParams) -> Result<Self, MeasuredError> {
        let MeasuredParams { phi, theta, channels, .. } = p;
        let isotropic = phi.len() <= 2;
        let reduction = match (phi.first(), phi.last()) {
            (Some(first), Some(last)) if !isotropic && last > first => (2.0 * PI / (last - first)).round() as u32,
            _ => 1,
        };
        if ![1, 2, 4].contains(&reduction) {
            return Err(MeasuredError("phi"));
        }
        let ndf = Sheets::new(p.ndf.size, [], p.ndf.values).ok_or(MeasuredError("ndf"))?;
        let sheets =
            |grid: Grid, name| Sheets::new(grid.size, [phi.clone(), theta.clone()], grid.values).ok_or(MeasuredError(name));
        let pole = ndf.eval(Vec2::new(0.0, 0.5), &ndf.around([]));
        let count = channels.len();
        let mut table = Self {
            sigma: Sheets::new(p.sigma.size, [], p.sigma.values).ok_or(MeasuredError("sigma"))?,
            vndf: Warp::new(sheets(p.vndf, "vndf")?),
            luminance: Warp::new(sheets(p.luminance, "luminance")?),
            spectra: Sheets::new(p.spectra.size, [phi.clone(), theta.clone(), channels], p.spectra.values)
                .ok_or(MeasuredError("spectra"))?,
            roughness: if pole > 0.0 { (FRAC_1_PI / pole).sqrt().clamp(1e-3, 1.0) } else { 1.0 },
            ndf,
            isotropic,
            jacobian: p.jacobian,
            reduction,
            albedo: Vec::new(),
        };
        table.albedo = (0..count).map(|c| table.reflected(table.spectra.axis(2)[c])).collect();
        Ok(table)
    }

    /// The mean weight of samples from 45 degrees, in one channel.
    fn reflected(&self, channel: f32) -> f32 {
        const SIDE: u32 = 12;
        let lobe = Measured { table: self, lanes: [channel; 4] };
        let wo = Vec3::new(0.5, 0.5, std::f32::consts::FRAC_1_SQRT_2);
        let numbers = (0..SIDE * SIDE).map(|i| Vec2::new((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5) / SIDE as f32);
        let sum: f32 = numbers.filter_map(|u| lobe.sample(wo, 0.5, u)).map(|s| s.weight[0]).sum();
        (sum / (SIDE * SIDE) as f32).clamp(0.0, 1.0)
    }

    /// What of the light from 45 degrees is reflected, in some lanes.
    pub(super) fn albedo(&self, lanes: [f32; 4]) -> etendue_numerics::Spectrum {
        let axis = self.spectra.axis(2);
        let at = |lane: f32| {
            let i = axis.partition_point(|c| *c < lane).min(axis.len() - 1);
            if lane == super::DARK { 0.0 } else { self.albedo[i] }
        };
        etendue_numerics::Spectrum(lanes.map(at).into())
    }
}
