//! Wrong on purpose: each fault must be seen by the test that is there for it.

use crate::{chi_square, energy, moments, reciprocity};
use etendue_bsdf::{Bsdf, BsdfSample, Event, Scatter, lobes::*};
use etendue_numerics::{Pdf, Spectrum, Vec2, Vec3};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    /// weight = f/p.
    LostCosine,
    /// pdf() and the sample's density are half of what they should be; the weight is right.
    HalvedDensity,
    /// p(m) is passed off as p(wi).
    NoJacobian,
    /// f 5 % too bright in eval alone.
    BrighterEval,
    /// weight 5 % too bright.
    BrighterWeight,
    /// η² forgotten in one direction of transmission.
    NoEtaSquared,
    /// Directions turned by 3° about z after they were drawn.
    Turned,
}

struct Saboteur {
    inner: Bsdf<'static>,
    fault: Fault,
}

impl Scatter for Saboteur {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        let f = self.inner.eval(wo, wi);
        match self.fault {
            Fault::BrighterEval => f * 1.05,
            Fault::NoEtaSquared if wo.z < 0.0 && wi.z > 0.0 => f * self.inner.relative_eta(wo, wi).powi(2),
            _ => f,
        }
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let p = self.inner.pdf(wo, wi);
        match self.fault {
            Fault::HalvedDensity => 0.5 * p,
            Fault::NoJacobian => p * 4.0 * wi.dot((wo + wi).normalize()),
            _ => p,
        }
    }

    fn sample(&self, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample> {
        let mut s = self.inner.sample(wo, u1, u2)?;
        match self.fault {
            Fault::LostCosine => s.weight /= s.wi.z.abs(),
            Fault::BrighterWeight => s.weight *= 1.05,
            Fault::Turned => s.wi = Vec3::new(0.9986 * s.wi.x - 0.0523 * s.wi.y, 0.0523 * s.wi.x + 0.9986 * s.wi.y, s.wi.z),
            Fault::HalvedDensity | Fault::NoJacobian => s.pdf = Pdf::SolidAngle(self.pdf(wo, s.wi)),
            _ => {}
        }
        Some(s)
    }

    fn events(&self) -> Event {
        self.inner.events()
    }

    fn albedo(&self, wo: Vec3) -> Spectrum {
        self.inner.albedo(wo)
    }

    fn roughness(&self) -> f32 {
        self.inner.roughness()
    }

    fn importance(&self) -> f32 {
        self.inner.importance()
    }
}

const WO: Vec3 = Vec3::new(0.36, -0.48, 0.8);

fn metal() -> Bsdf<'static> {
    RoughConductor::new(RoughConductorParams { alpha_u: 0.3, alpha_v: 0.3, ..Default::default() }).into()
}

fn glass() -> Bsdf<'static> {
    RoughDielectric::new(RoughDielectricParams { alpha_u: 0.3, alpha_v: 0.3, ..Default::default() }).into()
}

fn chi_square_sees(inner: Bsdf<'static>, fault: Fault) -> bool {
    !chi_square::report(&Saboteur { inner, fault }, WO, 1).passes(1e-7)
}

fn moments_see(inner: Bsdf<'static>, fault: Fault) -> bool {
    moments::differences(&Saboteur { inner, fault }, WO, 1).iter().any(|(p, _)| *p < 1e-7)
}

#[test]
fn a_false_density_is_seen() {
    for fault in [Fault::HalvedDensity, Fault::NoJacobian, Fault::Turned] {
        assert!(chi_square_sees(metal(), fault), "{fault:?}");
    }
    assert!(!chi_square_sees(metal(), Fault::LostCosine), "a right density must pass");
}

#[test]
fn a_false_weight_is_seen() {
    for fault in [Fault::LostCosine, Fault::BrighterEval, Fault::BrighterWeight] {
        assert!(moments_see(metal(), fault), "{fault:?}");
    }
    assert!(!moments_see(metal(), Fault::HalvedDensity), "right weights must pass");
}

#[test]
fn a_one_way_street_is_seen() {
    let (inner, fault) = (glass(), Fault::NoEtaSquared);
    assert!(reciprocity::worst(&inner, &Saboteur { inner, fault }, true, 3) > 2e-2);
}

#[test]
fn light_from_nowhere_is_seen() {
    let inner: Bsdf = Diffuse::new(DiffuseParams { reflectance: Spectrum::ONE }).into();
    assert!(energy::albedo(&Saboteur { inner, fault: Fault::BrighterWeight }, WO, 1000).mean > 1.04);
}
