//! What is known without sampling.

use crate::energy::albedo;
use etendue_bsdf::{Bsdf, Lobe, Microfacets, Ndf, Perturbation, Scatter, fresnel, lobes::*};
use etendue_check::{integrate_hemisphere, rng};
use etendue_numerics::{Spectrum, Vec2, Vec3, Wavelengths, math::FRAC_1_PI};

const OBLIQUE: Vec3 = Vec3::new(0.36, -0.48, 0.8);

fn near(what: &str, a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{what}: {a} is not {b}");
}

#[test]
fn every_normal_counts_once() {
    for ndf in [Ndf::Beckmann, Ndf::Ggx] {
        for (a, b) in [(0.2, 0.2), (0.7, 0.3)] {
            let m = Microfacets::new(ndf, a, b, true);
            near("∫ D cosθ_m", integrate_hemisphere(|h| f64::from(m.d(h) * h.z)), 1.0, 2e-4);
            // What is seen of the facets from wo is the projected area of the surface [Heitz 2014, eq. 2]; Beckmann's G1 is a fit.
            let seen = integrate_hemisphere(|h| f64::from(m.d(h) * m.g1(OBLIQUE, h) * OBLIQUE.dot(h).max(0.0)));
            near("∫ G1 D (wo·m)", seen, f64::from(OBLIQUE.z), 4e-3);
            near("∫ p(m)", integrate_hemisphere(|h| f64::from(m.pdf(OBLIQUE, h))), 1.0, 2e-4);
        }
    }
}

#[test]
fn masking_at_known_angles() {
    // GGX of roughness 1 at 45°: tanθ = 1, G1 = 2/(1 + √2).
    let v = Vec3::new(0.5f32.sqrt(), 0.0, 0.5f32.sqrt());
    near("GGX", Microfacets::new(Ndf::Ggx, 1.0, 1.0, true).g1(v, Vec3::Z).into(), 2.0 / (1.0 + 2f64.sqrt()), 1e-6);
    // Beckmann at a = 1/tanθ = 1: exact 2/(1 + erf 1 + e⁻¹/√π) = 0.97549, and its fit within 0.35 %.
    near("Beckmann", Microfacets::new(Ndf::Beckmann, 1.0, 1.0, true).g1(v, Vec3::Z).into(), 0.975_49, 0.0035);
}

#[test]
fn albedos_that_have_a_formula() {
    let d: Bsdf = Diffuse::new(DiffuseParams { reflectance: Spectrum::splat(0.3) }).into();
    near("diffuse", albedo(&d, OBLIQUE, 10).mean, 0.3, 1e-6);
    // At normal incidence the whole Phong lobe is above: k_d + k_s.
    let p: Bsdf = Phong::new(PhongParams { exponent: 5.0, ..Default::default() }).into();
    near("phong", albedo(&p, Vec3::Z, 40_000).mean, 0.7, 0.01);
    // Normal reflectance of gold's red, ((η-1)² + k²)/((η+1)² + k²).
    let gold = ConductorParams { eta: Spectrum::splat(0.143), k: Spectrum::splat(3.983), ..Default::default() };
    let expected = (0.857f64.powi(2) + 3.983f64.powi(2)) / (1.143f64.powi(2) + 3.983f64.powi(2));
    near("gold", albedo(&Conductor::new(gold), Vec3::Z, 2).mean, expected, 1e-5);
    let rough = RoughConductorParams { conductor: gold, alpha_u: 0.002, alpha_v: 0.002, ..Default::default() };
    near("nearly smooth gold", albedo(&RoughConductor::new(rough), Vec3::Z, 1_000).mean, expected, 1e-3);
    // A principled metal mirrors its base colour at normal incidence.
    let metal = PrincipledParams { base_color: Spectrum::splat(0.6), metallic: 1.0, roughness: 0.1, ..Default::default() };
    near("metal", albedo(&Principled::new(metal), Vec3::Z, 4_000).mean, 0.6, 0.02);
}

#[test]
fn rough_glass_splits_light_as_smooth_glass_in_the_limit() {
    let rough = RoughDielectric::new(RoughDielectricParams { alpha_u: 0.005, alpha_v: 0.005, ..Default::default() });
    for wo in [OBLIQUE, -OBLIQUE] {
        let reflected = (0..1_000).filter(|k| {
            let u = Vec2::new(*k as f32 / 1_000.0, (*k as f32 * 0.618_034).fract());
            rough.sample(wo, (*k as f32 * 0.754_878).fract(), u).is_some_and(|s| s.wi.z * wo.z > 0.0)
        });
        near("share reflected", reflected.count() as f64 / 1_000.0, fresnel::dielectric(wo.z, rough.eta()).f.into(), 0.01);
    }
}

#[test]
fn refraction_obeys_snell() {
    let s =
        Dielectric::new(DielectricParams { eta: 1.5, ..Default::default() }).sample(OBLIQUE, 0.999, Vec2::ZERO).expect("refracts");
    near("sinθ_t", s.wi.truncate().length().into(), 0.6 / 1.5, 1e-6);
    near("plane of incidence", s.wi.truncate().perp_dot(OBLIQUE.truncate()).into(), 0.0, 1e-6);
    assert!((s.eta, s.wi.z < 0.0) == (1.5, true));
}

#[test]
fn a_bent_normal_brings_its_own_cosine() {
    let n = Vec3::new(0.3, -0.1, 0.9).normalize();
    let lobe: Lobe = Diffuse::new(DiffuseParams { reflectance: Spectrum::ONE }).into();
    let hard = Bsdf::from(lobe).perturbed(&Perturbation::from_normal(n, false));
    let soft = Bsdf::from(lobe).perturbed(&Perturbation::from_normal(n, true));
    let wi = Vec3::new(-0.6, 0.2, 0.5).normalize();
    near("f cosθ", (hard.eval(OBLIQUE, wi)[0] * wi.z).into(), (FRAC_1_PI * n.dot(wi)).into(), 1e-6);
    // α² = tan²θ_n/8, the light dimmed by 2/(1 + √(1 + α² tan²θ_i)) [Conty Estevez et al. 2019].
    let tan2 = |w: Vec3| (1.0 - w.z * w.z) / (w.z * w.z);
    let shadow = 2.0 / (1.0 + (1.0 + tan2(n) / 8.0 * tan2(wi)).sqrt());
    near("softened", (soft.eval(OBLIQUE, wi)[0] / hard.eval(OBLIQUE, wi)[0]).into(), shadow.into(), 1e-5);
    // Above the surface but behind the bent normal, and the other way round: nothing.
    let behind = Vec3::new(-0.99, 0.1, 0.1).normalize();
    assert!(n.dot(behind) < 0.0 && hard.eval(OBLIQUE, behind).is_zero() && hard.eval(behind, OBLIQUE).is_zero());
    assert_eq!(hard.pdf(OBLIQUE, behind), 0.0);
}

#[test]
fn the_back_mirrors_the_front() {
    let lobe: Lobe = RoughConductor::new(RoughConductorParams { alpha_u: 0.3, ..Default::default() }).into();
    let (front, back) = (Bsdf::from(lobe), Bsdf::from(lobe).flipped());
    let (wo, wi) = (OBLIQUE, Vec3::new(-0.3, 0.5, 0.6).normalize());
    let down = |w: Vec3| Vec3::new(w.x, w.y, -w.z);
    assert_eq!(front.eval(wo, wi), back.eval(down(wo), down(wi)));
    assert_eq!(front.pdf(wo, wi), back.pdf(down(wo), down(wi)));
    assert!(back.eval(wo, wi).is_zero());
    // Twice turned over is as before.
    let again = back.flipped();
    assert_eq!(front.eval(wo, wi), again.eval(wo, wi));
}

#[test]
fn weights_add_up() {
    let half = Bsdf::from(Diffuse::new(Default::default())).scaled(0.5);
    let mut both = half;
    assert!(both.append(0.5, &half));
    near("½ + ¼", both.eval(Vec3::Z, Vec3::Z)[0].into(), f64::from(FRAC_1_PI) * 0.5 * 0.75, 1e-6);
    both.scale_since(1, 0.0);
    near("½", both.eval(Vec3::Z, Vec3::Z)[0].into(), f64::from(FRAC_1_PI) * 0.5 * 0.5, 1e-6);
    near("albedo", both.diffuse_reflectance()[0].into(), 0.25, 1e-6);
}

#[test]
fn normals_that_face_away_are_turned() {
    let (n, wo) = (Vec3::new(-0.9, 0.0, 0.3), Vec3::new(0.9, 0.0, 0.2));
    assert_eq!(Perturbation::facing(n, wo), Vec3::new(0.9, 0.0, 0.3));
    assert_eq!(Perturbation::facing(Vec3::Z, wo), Vec3::Z);
}

/// Walks through a clear layer over Lambert's ground agree in the mean with the sum that is known: a million walks a direction, by a z-test at a level
/// that gives one false alarm in a thousand runs.
#[test]
fn walks_through_a_clear_layer_find_its_closed_form() {
    use etendue_bsdf::lobes::{CoatedDiffuse, CoatedDiffuseParams, Layered, LayeredParams};
    use etendue_check::{Moments, family_wise, z_test};
    let pairs = [
        (Vec3::new(0.3, -0.2, 0.9), Vec3::new(-0.5, 0.1, 0.8)),
        (Vec3::new(0.9, 0.0, 0.3), Vec3::new(0.2, 0.7, 0.5)),
        (Vec3::Z, Vec3::new(0.95, 0.1, 0.2)),
    ];
    for alpha in [None, Some(0.3)] {
        let coated = CoatedDiffuseParams { reflectance: Spectrum::splat(0.8), alpha, thickness: 0.05, ..Default::default() };
        let closed = CoatedDiffuse::new(coated, &coated.coat());
        let walks = Layered::new(LayeredParams {
            ground: Ground::Diffuse(Spectrum::splat(0.8)),
            alpha: alpha.map(|a| [a; 2]),
            thickness: 0.05,
            samples: 100,
            ..Default::default()
        });
        for (wo, wi) in pairs.map(|(o, i)| (o.normalize(), i.normalize())) {
            let expected = f64::from(closed.eval(wo, wi)[0]);
            // Directions that differ in their last bits seed other walks.
            let mut moments = Moments::default();
            for k in 0..10_000 {
                let nudge = Vec3::new(k as f32 * 1e-8, 0.0, 0.0);
                moments.add(f64::from(walks.eval((wo + nudge * 10.0).normalize(), wi)[0]));
            }
            let p = z_test(&moments, expected).p_value;
            // The fit of T is good to a thousandth.
            let near = (moments.mean / expected - 1.0).abs() < 4e-3;
            assert!(
                near || p > family_wise(1e-3, 6),
                "{alpha:?} {wo} {wi}: {} ± {}, {expected}",
                moments.mean,
                moments.standard_error()
            );
        }
    }
}

/// A metal that was tabulated is that metal, as far as the tables are fine: in the mean over directions within 1 %, in single ones within 20 %.
#[test]
fn a_tabulated_metal_is_the_metal() {
    use crate::tabulated::{Resolution, table, truth};
    let fine = Resolution { normals: 64, square: 32, theta: 16, phi: 17, part: 1.0 };
    for (alpha, fine) in [([0.4, 0.4], &fine), ([0.6, 0.3], &Resolution { part: 0.5, normals: 48, square: 24, ..fine })] {
        let (table, truth) = (table(alpha, fine), truth(alpha));
        let lobe = Measured::new(&table, &Wavelengths::Rgb);
        let mut numbers = rng(8);
        let (mut sums, mut worst) = ([0.0f64; 2], 0.0f32);
        for _ in 0..4_000 {
            let wo = Vec3::from_array([numbers.u1() - 0.5, numbers.u1() - 0.5, 0.3 + 0.7 * numbers.u1()]).normalize();
            let Some(s) = truth.sample(wo, 0.5, numbers.u2()).filter(|s| s.wi.z > 0.2) else { continue };
            let (a, b) = (lobe.eval(wo, s.wi), truth.eval(wo, s.wi));
            sums[0] += f64::from(a[0] * s.wi.z / s.pdf.value());
            sums[1] += f64::from(s.weight[0]);
            worst = (0..3).map(|c| (a[c] / b[c] - 1.0).abs()).fold(worst, f32::max);
        }
        let off = sums[0] / sums[1] - 1.0;
        assert!(off.abs() < 0.01 && worst < 0.2, "{alpha:?}: {off}, {worst}");
    }
}
