//! A "measured" sample whose truth is known: a GGX metal, tabulated in the coordinates of [Dupuy, Jakob 2018].
#![allow(dead_code)] // shared by tests that use parts of it

use etendue_bsdf::{
    Microfacets, Ndf, Scatter,
    lobes::{ConductorParams, Grid, MeasuredParams, MeasuredTable, RoughConductor, RoughConductorParams},
};
use etendue_numerics::{Spectrum, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Nodes along each side of the grids, and elevations of `wo`.
pub struct Resolution {
    pub normals: usize,
    pub square: usize,
    pub theta: usize,
    pub phi: usize,
    /// The part of the circle that is measured: a half, say, of what is the same turned around.
    pub part: f32,
}

/// The truth: gold of roughness `alpha` along x and y.
pub fn truth(alpha: [f32; 2]) -> RoughConductor {
    let conductor =
        ConductorParams { eta: Spectrum::rgb(0.143, 0.375, 1.442), k: Spectrum::rgb(3.983, 2.386, 1.603), ..Default::default() };
    RoughConductor::new(RoughConductorParams {
        conductor,
        ndf: Ndf::GgxCorrelated,
        alpha_u: alpha[0],
        alpha_v: alpha[1],
        sample_visible: true,
    })
}

fn direction(theta: f32, phi: f32) -> Vec3 {
    Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// Elevation and azimuth at u.
fn angles(u: Vec2) -> (f32, f32) {
    (FRAC_PI_2 * u.x * u.x, TAU * u.y - PI)
}

fn grid([w, h]: [usize; 2], f: impl Fn(Vec2) -> f32) -> Vec<f32> {
    let at = |i: usize| Vec2::new((i % w) as f32 / (w - 1) as f32, (i / w) as f32 / (h - 1) as f32);
    (0..w * h).map(|i| f(at(i))).collect()
}

/// [`truth`] as a table; three channels in `channels`, each as red, green and blue of it.
pub fn params(alpha: [f32; 2], r: &Resolution, channels: [f32; 3]) -> MeasuredParams {
    let facets = Microfacets::new(Ndf::GgxCorrelated, alpha[0], alpha[1], true);
    let isotropic = alpha[0] == alpha[1];
    let lobe = truth(alpha);
    let phi: Vec<f32> =
        if isotropic { vec![0.0] } else { (0..r.phi).map(|i| r.part * TAU * i as f32 / (r.phi - 1) as f32 - PI).collect() };
    let theta: Vec<f32> = (0..r.theta).map(|i| 1.5 * i as f32 / (r.theta - 1) as f32).collect();
    let normals = [r.normals; 2];
    let square = [r.square; 2];

    // σ = cosθ/G1, by the normals that are seen: v = D <wo·m>/σ.
    let area = |wo: Vec3| {
        let m = Vec3::Z;
        let seen = facets.pdf(wo, m);
        if seen > 0.0 { facets.d(m) * wo.dot(m) / seen } else { 0.0 }
    };
    let mut p = MeasuredParams {
        phi: phi.clone(),
        theta: theta.clone(),
        channels: channels.to_vec(),
        ndf: Grid { size: normals, values: grid(normals, |u| facets.d(direction(angles(u).0, angles(u).1))) },
        sigma: Grid { size: normals, values: grid(normals, |u| area(direction(angles(u).0.min(1.55), angles(u).1))) },
        vndf: Grid { size: normals, ..Grid::default() },
        luminance: Grid { size: square, ..Grid::default() },
        spectra: Grid { size: square, ..Grid::default() },
        jacobian: true,
    };
    // The map V of the table itself, so that M is what the table asks for.
    let wos: Vec<(f32, Vec3)> = phi.iter().flat_map(|phi| theta.iter().map(|t| (*phi, direction(*t, *phi)))).collect();
    for (_, wo) in &wos {
        let wo = *wo;
        p.vndf.values.extend(grid(normals, |u| {
            let (theta, phi) = angles(u);
            let m = direction(theta, phi);
            facets.d(m) * wo.dot(m).max(0.0) / area(wo) * 2.0 * PI * PI * u.x * theta.sin()
        }));
    }
    let sheets = etendue_numerics::table::Sheets::new(normals, [phi, theta], p.vndf.values.clone()).expect("a table");
    let warp = etendue_numerics::table::Warp::new(sheets);
    for (phi, wo) in &wos {
        let wo = *wo;
        let around = warp.around([*phi, wo.z.clamp(-1.0, 1.0).acos()]);
        let m_of = |s: Vec2| {
            let (u, _) = warp.sample(s.min(Vec2::splat(0.999_999)), &around);
            let (theta, phi) = angles(u);
            direction(theta, phi)
        };
        let reflected = |s: Vec2| {
            let m = m_of(s);
            let wi = 2.0 * wo.dot(m) * m - wo;
            if wi.z <= 0.0 {
                return Spectrum::ZERO;
            }
            lobe.eval(wo, wi) * (wi.z * 4.0 * area(wo) / facets.d(m))
        };
        p.luminance.values.extend(grid(square, |s| reflected(s).luminance() + 1e-3));
        for c in 0..3 {
            p.spectra.values.extend(grid(square, |s| reflected(s)[c]));
        }
    }
    p
}

/// The table of red, green and blue.
pub fn table(alpha: [f32; 2], r: &Resolution) -> MeasuredTable {
    MeasuredTable::new(params(alpha, r, [0.0, 1.0, 2.0])).expect("a table")
}
