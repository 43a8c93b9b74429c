//! The ruler is tested on samplers with closed-form densities: the right ones must pass at the stated rate, the slightly wrong ones must all fail.

use etendue_check::{ChiSquareTest, Disk, Hemisphere, Interval, Rng, Sphere, Square, Triangle};
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// The significance of each single test below. There are fewer than thirty right samplers: all pass but with probability 3e-5.
const ALPHA: f64 = 1e-6;

fn polar(z: f32, r: f32, v: f32) -> Vec3 {
    let (sin, cos) = (TAU * v).sin_cos();
    Vec3::new(r * cos, r * sin, z)
}

fn uniform_hemisphere([u, v, _]: [f32; 3]) -> Option<Vec3> {
    Some(polar(u, (1.0 - u * u).max(0.0).sqrt(), v))
}

fn cosine_hemisphere([u, v, _]: [f32; 3]) -> Option<Vec3> {
    Some(polar((1.0 - u).sqrt(), u.sqrt(), v))
}

fn cosine_pdf(w: Vec3) -> f32 {
    w.z.max(0.0) / PI
}

/// A Gaussian-like lobe e^(κ(cosθ - 1)) around an axis (von Mises-Fisher), for κ so large that e^(-2κ) vanishes.
struct Lobe {
    axis: Vec3,
    kappa: f32,
}

impl Lobe {
    fn new(theta: f32, phi: f32, kappa: f32) -> Self {
        Self { axis: polar(theta.cos(), theta.sin(), phi / TAU), kappa }
    }

    fn sample(&self, [u, v, _]: [f32; 3]) -> Option<Vec3> {
        let x = -(1.0 - u).ln() / self.kappa;
        let (s, t) = self.axis.any_orthonormal_pair();
        let local = polar(1.0 - x, (x * (2.0 - x)).max(0.0).sqrt(), v);
        Some((s * local.x + t * local.y + self.axis * local.z).normalize())
    }

    fn pdf(&self, w: Vec3) -> f32 {
        // 1 - cosθ = |w - axis|²/2 without cancellation.
        self.kappa / TAU * (-0.5 * self.kappa * (w - self.axis).length_squared()).exp()
    }
}

#[test]
fn right_samplers_pass() {
    let check = |name: &str, report: etendue_check::ChiSquare| assert!(report.passes(ALPHA), "{name}: {report}");
    check("uniform hemisphere", ChiSquareTest::new(Hemisphere).run(uniform_hemisphere, |_| 1.0 / TAU));
    check("cosine", ChiSquareTest::new(Hemisphere).run(cosine_hemisphere, cosine_pdf));
    check("cosine on the sphere", ChiSquareTest::new(Sphere).run(cosine_hemisphere, cosine_pdf));
    check("square", ChiSquareTest::new(Square).run(|[u, v, _]| Some(Vec2::new(u.sqrt(), v)), |p| 2.0 * p.x));
    check("disk", ChiSquareTest::new(Disk).run(|u| cosine_hemisphere(u).map(|w| w.truncate()), |_| 1.0 / PI));
    let triangle = |[u, v, _]: [f32; 3]| Some(Vec2::new(1.0 - u.sqrt(), v * u.sqrt()));
    check("triangle", ChiSquareTest::new(Triangle).run(triangle, |_| 2.0));
    check(
        "interval",
        ChiSquareTest::new(Interval(-1.0, 3.0)).run(|[u, ..]| Some(4.0 * u.cbrt() - 1.0), |x| 3.0 / 64.0 * (x + 1.0) * (x + 1.0)),
    );
    // Lobes wide and narrow, at the pole, off it, near the equator and the seam φ = 0.
    for kappa in [20.0, 1e3, 1e5, 1e6] {
        for (theta, phi) in [(0.0, 0.0), (0.6, 2.0), (1.5, 0.001), (PI, 0.0)] {
            let lobe = Lobe::new(theta, phi, kappa);
            check(&format!("lobe {kappa} at {theta}"), ChiSquareTest::new(Sphere).run(|u| lobe.sample(u), |w| lobe.pdf(w)));
        }
    }
}

#[test]
fn samplers_that_absorb_pass_with_a_density_that_lacks_as_much() {
    let sample = |u: [f32; 3]| cosine_hemisphere(u).filter(|w| w.x < 0.5);
    let report = ChiSquareTest::new(Hemisphere).run(sample, |w| if w.x < 0.5 { cosine_pdf(w) } else { 0.0 });
    assert!(report.passes(ALPHA), "{report}");
    // A coin that absorbs a tenth, forgotten in the density.
    let report = ChiSquareTest::new(Hemisphere).run(|u| cosine_hemisphere(u).filter(|_| u[2] > 0.1), cosine_pdf);
    assert!(!report.passes(ALPHA), "{report}");
}

#[test]
fn wrong_samplers_fail() {
    let check = |name: &str, report: etendue_check::ChiSquare| assert!(!report.passes(ALPHA), "{name}: {report}");
    let test = ChiSquareTest::new(Hemisphere);
    check("a lost cosine", test.run(uniform_hemisphere, cosine_pdf));
    check("a cosine too many", test.run(cosine_hemisphere, |_| 1.0 / TAU));
    check("a density 5 % too large", test.run(cosine_hemisphere, |w| 1.05 * cosine_pdf(w)));
    check("a density 1 % too small", test.run(cosine_hemisphere, |w| 0.99 * cosine_pdf(w)));
    check("a density that ripples by 6 %", test.run(cosine_hemisphere, |w| cosine_pdf(w) * (1.0 + 0.06 * (7.0 * w.x).sin())));
    check("the wrong half", test.run(|u| cosine_hemisphere(u).map(|w| -w), cosine_pdf));
    check("lost numbers", test.run(|u| cosine_hemisphere(u).map(|w| if u[2] < 1e-3 { w * f32::NAN } else { w }), cosine_pdf));
    check("an exponent off by 5 %", test.run(|[u, v, w]| cosine_hemisphere([u.powf(1.05), v, w]), cosine_pdf));
    check("a wrong quadrant of φ", test.run(|[u, v, w]| cosine_hemisphere([u, v.powf(1.05), w]), cosine_pdf));
    check("numbers that depend on each other", test.run(|[u, v, w]| cosine_hemisphere([u, 0.95 * v + 0.05 * u, w]), cosine_pdf));
    let hole = |w: Vec3| if w.x > 0.0 && w.y > 0.0 && w.z > 0.95 { 0.0 } else { cosine_pdf(w) };
    check("a hole in the density", test.run(cosine_hemisphere, hole));
    for kappa in [20.0f32, 1e3, 1e5] {
        let lobe = Lobe::new(0.6, 2.0, kappa);
        let width = kappa.sqrt().recip();
        let shifted = Lobe::new(0.6 + 0.05 * width, 2.0, kappa);
        check("a lobe shifted by a twentieth of its width", ChiSquareTest::new(Sphere).run(|u| lobe.sample(u), |w| shifted.pdf(w)));
        let wider = Lobe::new(0.6, 2.0, 0.95 * kappa);
        check("a lobe 2.5 % too wide", ChiSquareTest::new(Sphere).run(|u| lobe.sample(u), |w| wider.pdf(w)));
        let forked = |u: [f32; 3]| lobe.sample(u).filter(|w| w.y > lobe.axis.y);
        check("half a lobe", ChiSquareTest::new(Sphere).run(forked, |w| lobe.pdf(w)));
    }
    // A density with a second narrow lobe that is never drawn.
    let (a, b) = (Lobe::new(0.6, 2.0, 1e3), Lobe::new(1.2, 5.0, 1e3));
    check("a lobe never drawn", ChiSquareTest::new(Sphere).run(|u| a.sample(u), |w| 0.5 * (a.pdf(w) + b.pdf(w))));
}

#[test]
fn alarms_come_at_the_stated_rate() {
    // 1000 seeds at α = 1 %: alarms are binomial, mean 10, deviation 3.15. More than 30 or a p-value histogram that is not flat has probability below 1e-6.
    let lobe = Lobe::new(0.6, 2.0, 1e3);
    let sample = |u: [f32; 3]| lobe.sample(u).filter(|_| u[2] > 0.2);
    let pdf = |w: Vec3| 0.8 * lobe.pdf(w);
    let cells = ChiSquareTest::new(Sphere).samples(10_000).cells(sample, pdf);
    let (mut alarms, mut tenths) = (0, [0usize; 10]);
    for seed in 0..1000 {
        let report = cells.test(Rng::new(seed).bits(), sample, pdf);
        alarms += usize::from(!report.passes(0.01));
        tenths[((report.p_value * 10.0) as usize).min(9)] += 1;
    }
    assert!(alarms <= 30, "{alarms} alarms");
    let x2: f64 = tenths.iter().map(|&o| (o as f64 - 100.0).powi(2) / 100.0).sum();
    assert!(etendue_check::chi_square_p(x2, 9.0) > 1e-6, "{tenths:?}");
}
