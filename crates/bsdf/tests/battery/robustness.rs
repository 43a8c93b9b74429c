//! Whatever comes in, what comes out is finite and not negative.

use crate::{directions, models};
use etendue_bsdf::{Bsdf, Lobe, Microfacets, Ndf, Perturbation, Scatter, lobes::*, microfacet::transmittance::RoughTransmittance};
use etendue_numerics::{Spectrum, Vec2, Vec3, math::ONE_MINUS_EPSILON};
use proptest::prelude::*;
use std::sync::LazyLock;

fn sane(s: Spectrum) -> bool {
    s.is_finite() && s.0.min_element() >= 0.0
}

/// Everything that a model answers for one pair of directions and one set of uniform numbers.
fn check(f: &Bsdf, wo: Vec3, wi: Vec3, u: [f32; 3]) -> Result<(), String> {
    let fail = |what: &str| Err(format!("{what}: wo {wo:?}, wi {wi:?}, u {u:?}, {f:?}"));
    if !sane(f.eval(wo, wi)) {
        return fail("eval");
    }
    if !(f.pdf(wo, wi) >= 0.0 && f.pdf(wo, wi).is_finite()) {
        return fail("pdf");
    }
    let a = f.relative_eta(wo, wi);
    if !(a > 0.0
        && a.is_finite()
        && sane(f.albedo(wo))
        && sane(f.diffuse_reflectance())
        && sane(f.transparency(wo))
        && f.roughness() >= 0.0)
    {
        return fail("hints");
    }
    if let Some(s) = f.sample(wo, u[0], Vec2::new(u[1], u[2])) {
        let p = s.pdf.value();
        let good = sane(s.weight) && p > 0.0 && p.is_finite() && s.eta > 0.0 && (s.wi.length() - 1.0).abs() < 1e-3;
        if !good {
            return fail(&format!("sample {s:?}"));
        }
    }
    Ok(())
}

fn extremes() -> Vec<Vec3> {
    let mut list = directions().to_vec();
    list.extend([
        Vec3::X,
        Vec3::NEG_Y,
        Vec3::NEG_Z,
        Vec3::new(1.0, 0.0, 1e-7),
        Vec3::new(0.6, 0.8, -1e-7),
        Vec3::new(0.0, 1.0, 1e-30),
        Vec3::new(-0.8, 0.6, -0.0),
        Vec3::new(1e-4, 0.0, 1.0),
    ]);
    list
}

#[test]
fn the_ends_of_the_unit_interval_are_numbers_too() {
    let ends = [0.0, 0.5, ONE_MINUS_EPSILON];
    for row in models::rows() {
        for wo in extremes() {
            for wi in extremes() {
                check(&row.bsdf, wo, wi, [0.3, 0.6, 0.1]).unwrap_or_else(|e| panic!("{}: {e}", row.name));
            }
            for k in 0..27 {
                let u = [ends[k % 3], ends[k / 3 % 3], ends[k / 9]];
                check(&row.bsdf, wo, -wo, u).unwrap_or_else(|e| panic!("{}: {e}", row.name));
            }
        }
    }
}

#[test]
fn nothing_scatters_nothing() {
    let f = Bsdf::new();
    assert!(
        f.eval(Vec3::Z, Vec3::Z).is_zero() && f.pdf(Vec3::Z, Vec3::Z) == 0.0 && f.sample(Vec3::Z, 0.5, Vec2::splat(0.5)).is_none()
    );
    let mut full = Bsdf::new();
    for k in 0..=Bsdf::MAX_LOBES {
        assert_eq!(full.push(0.1, Diffuse::new(Default::default())), k < Bsdf::MAX_LOBES);
    }
    assert_eq!(full.len(), Bsdf::MAX_LOBES);
    assert!(!full.append(1.0, &Bsdf::from(Null)));
    // Weights that say nothing add nothing.
    let mut none = Bsdf::new();
    for w in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        none.push(w, Null);
    }
    assert!(none.is_empty());
}

/// Numbers as they come from broken files.
fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        6 => 0f32..1.0,
        1 => Just(0.0),
        1 => Just(1.0),
        1 => Just(-1.0),
        1 => Just(f32::NAN),
        1 => Just(f32::INFINITY),
        1 => Just(f32::MAX),
        1 => Just(1e-30),
        1 => 1f32..5.0,
    ]
}

fn spectrum() -> impl Strategy<Value = Spectrum> {
    [number(), number(), number()].prop_map(|[r, g, b]| Spectrum::rgb(r, g, b))
}

fn direction() -> impl Strategy<Value = Vec3> {
    let part = || prop_oneof![8 => -1f32..1.0, 1 => Just(0.0), 1 => Just(1e-12), 1 => Just(-1e-6)];
    (part(), part(), part()).prop_map(|(x, y, z)| Vec3::new(x, y, z).try_normalize().unwrap_or(Vec3::Z))
}

/// A few boundaries, since each takes milliseconds to make.
static BOUNDARIES: LazyLock<Vec<RoughTransmittance>> = LazyLock::new(|| {
    [(0.0, 1.0), (0.1, 1.5), (1.0, f32::NAN), (f32::INFINITY, 0.0)]
        .map(|(a, e)| RoughTransmittance::new(Ndf::Beckmann, a, e))
        .to_vec()
});

fn lobe() -> impl Strategy<Value = Lobe<'static>> {
    (0..12usize, prop::array::uniform16(number()), prop::array::uniform3(spectrum()), any::<[bool; 3]>()).prop_map(
        |(kind, x, s, b)| {
            let ndf = if b[0] { Ndf::Ggx } else { Ndf::Beckmann };
            let dielectric =
                DielectricParams { eta: x[0], disperses: false, specular_reflectance: s[0], specular_transmittance: s[1] };
            let conductor = ConductorParams { eta: s[0], k: s[1], specular_reflectance: s[2] };
            let plastic = PlasticParams { diffuse_reflectance: s[0], specular_reflectance: s[1], eta: x[0], nonlinear: b[1] };
            let (alpha_u, alpha_v, sample_visible) = (x[1], x[2], b[2]);
            match kind {
                0 => Diffuse::new(DiffuseParams { reflectance: s[0] }).into(),
                1 => Dielectric::new(dielectric).into(),
                2 => ThinDielectric::new(dielectric).into(),
                3 => RoughDielectric::new(RoughDielectricParams { dielectric, ndf, alpha_u, alpha_v, sample_visible }).into(),
                4 => Conductor::new(conductor).into(),
                5 => RoughConductor::new(RoughConductorParams { conductor, ndf, alpha_u, alpha_v, sample_visible }).into(),
                6 => Plastic::new(plastic).into(),
                7 => RoughPlastic::new(
                    RoughPlasticParams { plastic, ndf, alpha: x[1], sample_visible },
                    &BOUNDARIES[(x[3].abs() * 4.0) as usize % 4],
                )
                .into(),
                8 => Phong::new(PhongParams {
                    diffuse_reflectance: s[0],
                    specular_reflectance: s[1],
                    exponent: x[0] * if b[0] { 1.0 } else { 1e3 },
                })
                .into(),
                9 => Principled::new(PrincipledParams {
                    base_color: s[0],
                    luminance: None,
                    roughness: x[0],
                    anisotropic: x[1],
                    metallic: x[2],
                    spec_trans: x[3],
                    eta: x[4],
                    spec_tint: x[5],
                    sheen: x[6],
                    sheen_tint: x[7],
                    flatness: x[8],
                    clearcoat: x[9],
                    clearcoat_gloss: x[10],
                    diffuse_reflectance_sampling_rate: x[11],
                    main_specular_sampling_rate: x[12],
                    clearcoat_sampling_rate: x[13],
                })
                .into(),
                10 => PrincipledThin::new(PrincipledThinParams {
                    base_color: s[0],
                    luminance: None,
                    roughness: x[0],
                    anisotropic: x[1],
                    spec_trans: x[2],
                    eta: x[3],
                    spec_tint: x[4],
                    sheen: x[5],
                    sheen_tint: x[6],
                    flatness: x[7],
                    diff_trans: x[8],
                    diffuse_reflectance_sampling_rate: x[9],
                    specular_reflectance_sampling_rate: x[10],
                    specular_transmittance_sampling_rate: x[11],
                    diffuse_transmittance_sampling_rate: x[12],
                })
                .into(),
                _ => Null.into(),
            }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, rng_seed: prop::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn any_lobe_answers_with_numbers(l in lobe(), wo in direction(), wi in direction(), u in [0f32..1.0, 0f32..1.0, 0f32..1.0]) {
        let f = Bsdf::from(l);
        if let Err(e) = check(&f, wo, wi, u) {
            prop_assert!(false, "{e}");
        }
    }

    #[test]
    fn any_sum_answers_with_numbers(
        ls in prop::collection::vec((number(), lobe(), any::<bool>()), 1..4),
        n in direction(), wo in direction(), wi in direction(), u in [0f32..1.0, 0f32..1.0, 0f32..1.0],
    ) {
        let mut f = Bsdf::new();
        for (w, l, bump) in ls {
            let mark = f.len();
            f.push(w, l);
            if bump {
                f.perturb_since(mark, &Perturbation::new(n, wi, true));
            }
        }
        if u[0] < 0.5 {
            f.flip_since(0);
        }
        if let Err(e) = check(&f, wo, wi, u) {
            prop_assert!(false, "{e}");
        }
    }

    #[test]
    fn normals_lie_above(a in number(), b in number(), ggx in any::<bool>(), visible in any::<bool>(), wo in direction(), u in [0f32..1.0, 0f32..1.0]) {
        let m = Microfacets::new(if ggx { Ndf::Ggx } else { Ndf::Beckmann }, a, b, visible);
        let n = m.sample(Vec3::new(wo.x, wo.y, wo.z.abs()), Vec2::from(u));
        prop_assert!(n.z >= 0.0 && (n.length() - 1.0).abs() < 1e-3, "{n:?}");
    }
}
