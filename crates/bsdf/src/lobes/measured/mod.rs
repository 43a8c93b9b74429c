//! Measured reflection, in the coordinates of its own microfacets [Dupuy, Jakob 2018].
//!
//! ```text
//! f(wi, wo) cosθi = M(s; wo, λ) D(m)/(4 σ(wo)),          m = (wo + wi)/|wo + wi|,   u(m) = V(s; wo)
//! p(wi) = l(s; wo) v(u; wo)/(2π² u_θ sinθm · 4 wo·m)
//! u = (√(2θ/π), (φ + π)/2π)                              elevation and azimuth on the unit square; the azimuth counts from that of wo where a sample is isotropic
//! ```
//!
//! | symbol | identifier | |
//! | --- | --- | --- |
//! | D, σ | `ndf`, `sigma` | density of normals, and the area that they show to `wo` |
//! | v, V | `vndf` | density of the normals that `wo` sees, over u, and the map by which the square is drawn from it |
//! | l | `luminance` | density over s of what they reflect |
//! | M | `spectra` | what is left to be told: smooth, so that some tens of nodes hold it |
//!
//! All are bilinear tables. v, l and M are held for some azimuths and elevations of `wo` and are linear between them, M also for some
//! wavelengths. M, D and σ come from a photometer, and f is reciprocal only as far as it and the tables are.

mod table;

pub use table::{Grid, MeasuredError, MeasuredParams, MeasuredTable};

use crate::local::weighted;
use crate::{BsdfSample, Event, Scatter, fresnel::reflect};
use etendue_numerics::math::{PI, TAU, atan2, safe_asin, sin_cos, sqr};
use etendue_numerics::table::Around;
use etendue_numerics::{Spectrum, Vec2, Vec3, Wavelengths};

/// Whatever was measured.
#[derive(Clone, Copy, Debug)]
pub struct Measured<'a> {
    table: &'a MeasuredTable,
    /// Where in the table each lane is: a wavelength in nm, or the number of a channel; [`DARK`] for one that is not used.
    lanes: [f32; 4],
}

/// A lane without a channel.
const DARK: f32 = -1.0;

impl PartialEq for Measured<'_> {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.table, other.table) && self.lanes == other.lanes
    }
}

/// The sheets for `wo`.
struct Given {
    phi: f32,
    theta: f32,
    around: Around,
    /// What turns `wo` into the part of all azimuths that was measured.
    fold: Vec3,
}

/// θ of a unit vector, from z.
fn elevation(w: Vec3) -> f32 {
    2.0 * safe_asin(0.5 * (w - Vec3::Z).length())
}

/// u of an elevation and an azimuth.
fn square(theta: f32, phi: f32) -> Vec2 {
    let y = (phi + PI) / TAU;
    Vec2::new((theta * (2.0 / PI)).max(0.0).sqrt(), y - y.floor())
}

/// Solid angle of normals over area of u: 2π² u_θ sinθ, kept from zero at the pole.
fn stretch(u: Vec2, sin_theta: f32) -> f32 {
    (2.0 * sqr(PI) * u.x * sin_theta).max(1e-6)
}

impl<'a> Measured<'a> {
    const EVENT: Event = Event::REFLECT.with(Event::GLOSSY);

    /// The lobe of a table.
    #[inline]
    pub fn new(table: &'a MeasuredTable, wl: &Wavelengths) -> Self {
        let lanes = match wl {
            Wavelengths::Rgb => [0.0, 1.0, 2.0, DARK],
            Wavelengths::Hero(hero) => hero.nm().to_array(),
        };
        Self { table, lanes }
    }

    /// The sheets for `wo`; none from below.
    #[inline]
    fn given(&self, wo: Vec3) -> Option<Given> {
        if wo.z <= 0.0 {
            return None;
        }
        let towards = |x: f32| if x >= 0.0 { -1.0 } else { 1.0 };
        let fold = match self.table.reduction {
            2 => Vec3::new(towards(wo.y), towards(wo.y), 1.0),
            4 => Vec3::new(towards(wo.x), towards(wo.y), 1.0),
            _ => Vec3::ONE,
        };
        let wo = wo * fold;
        let (theta, phi) = (elevation(wo), atan2(wo.y, wo.x));
        Some(Given { phi, theta, around: self.table.vndf.around([phi, theta]), fold })
    }

    /// f cosθi where the normal is at u and at s.
    fn value(&self, given: &Given, s: Vec2, u: Vec2) -> Spectrum {
        let table = self.table;
        let mut scale = 1.0;
        if table.jacobian {
            let none = table.ndf.around([]);
            let sigma = table.sigma.eval(square(given.theta, given.phi), &none);
            scale = if sigma > 0.0 { table.ndf.eval(u, &none) / (4.0 * sigma) } else { 0.0 };
        }
        let m = self.lanes.map(|lane| match lane {
            DARK => 0.0,
            lane => table.spectra.eval(s, &table.spectra.around([given.phi, given.theta, lane])).max(0.0),
        });
        Spectrum(m.into()) * scale
    }

    /// f cosθi and the density of `wi`.
    fn both(&self, wo: Vec3, wi: Vec3) -> Option<(Spectrum, f32)> {
        let given = self.given(wo).filter(|_| wi.z > 0.0)?;
        let m = (wo + wi).try_normalize()? * given.fold;
        let turned = if self.table.isotropic { given.phi } else { 0.0 };
        let u = square(elevation(m), atan2(m.y, m.x) - turned);
        let (s, seen) = self.table.vndf.invert(u, &given.around);
        let density = seen * self.table.luminance.pdf(s, &given.around);
        let cos = (wo * given.fold).dot(m);
        let pdf = if cos > 0.0 { density / (stretch(u, m.x.hypot(m.y)) * 4.0 * cos) } else { 0.0 };
        Some((self.value(&given, s, u), pdf))
    }
}

impl Scatter for Measured<'_> {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        self.eval_pdf(wo, wi).0
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.eval_pdf(wo, wi).1
    }

    fn sample(&self, wo: Vec3, _u1: f32, u2: Vec2) -> Option<BsdfSample> {
        let given = self.given(wo)?;
        let (s, lit) = self.table.luminance.sample(u2, &given.around);
        let (u, seen) = self.table.vndf.sample(s, &given.around);

        let turned = if self.table.isotropic { given.phi } else { 0.0 };
        let ((sin_theta, cos_theta), (sin_phi, cos_phi)) = (sin_cos(0.5 * PI * sqr(u.x)), sin_cos(TAU * u.y - PI + turned));
        let m = Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta) * given.fold;
        let (wi, cos) = (reflect(wo, m), wo.dot(m));
        if wi.z <= 0.0 || cos <= 0.0 {
            return None;
        }
        let pdf = lit * seen / (stretch(u, sin_theta) * 4.0 * cos);
        weighted(wi, self.value(&given, s, u) / pdf, pdf, 1.0, Self::EVENT)
    }

    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        self.both(wo, wi).map_or((Spectrum::ZERO, 0.0), |(f_cos, pdf)| (f_cos / wi.z.max(1e-8), pdf))
    }

    fn events(&self) -> Event {
        Self::EVENT
    }

    fn albedo(&self, _wo: Vec3) -> Spectrum {
        self.table.albedo(self.lanes)
    }

    fn roughness(&self) -> f32 {
        self.table.roughness
    }

    fn importance(&self) -> f32 {
        self.albedo(Vec3::Z).max_lane().clamp(0.05, 1.0)
    }
}
