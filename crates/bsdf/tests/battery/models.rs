//! The rows of the battery: a row per parameterisation.

use crate::tabulated::{Resolution, table};
use etendue_bsdf::{Bsdf, Lobe, Ndf, Perturbation, lobes::*};
use etendue_numerics::{Spectrum, Vec3, Wavelengths};
use std::sync::LazyLock;

/// What becomes of the light.
#[derive(Clone, Copy, PartialEq)]
pub enum Energy {
    /// All of it leaves again.
    Kept,
    /// At least this share leaves and not more than all: single scattering, absorption.
    AtLeast(f64),
    /// An artist's sum of terms; at most this multiple.
    AtMost(f64),
}

/// One parameterisation.
pub struct Row {
    pub name: String,
    pub bsdf: Bsdf<'static>,
    pub energy: Energy,
    /// Whether f(wo, wi) = η² f(wi, wo) holds everywhere; where not, it must hold where both are seen, or `bent`.
    pub reciprocal: bool,
    /// Whether f is not reciprocal at all: bent normals, or lobes that see less one way than the other.
    pub bent: bool,
}

impl Row {
    fn new(name: impl Into<String>, bsdf: impl Into<Bsdf<'static>>, energy: Energy) -> Self {
        Self { name: name.into(), bsdf: bsdf.into(), energy, reciprocal: true, bent: false }
    }

    fn bent(self) -> Self {
        Self { bent: true, ..self }
    }

    fn one_way(self) -> Self {
        Self { reciprocal: false, ..self }
    }
}

const GOLD: (Spectrum, Spectrum) = (Spectrum::rgb(0.143, 0.375, 1.442), Spectrum::rgb(3.983, 2.386, 1.603));

fn smooth() -> Vec<Row> {
    let rgb = Spectrum::rgb;
    let gold = ConductorParams { eta: GOLD.0, k: GOLD.1, ..Default::default() };
    let white = PlasticParams { diffuse_reflectance: Spectrum::ONE, ..Default::default() };
    vec![
        Row::new("diffuse", Diffuse::new(DiffuseParams { reflectance: rgb(0.2, 0.5, 0.9) }), Energy::AtLeast(0.0)),
        Row::new("white diffuse", Diffuse::new(DiffuseParams { reflectance: Spectrum::ONE }), Energy::Kept),
        Row::new("dielectric", Dielectric::new(Default::default()), Energy::Kept),
        Row::new(
            "dielectric, air in glass",
            Dielectric::new(DielectricParams { eta: 1.0 / 1.5, ..Default::default() }),
            Energy::Kept,
        ),
        Row::new("dielectric without contrast", Dielectric::new(DielectricParams { eta: 1.0, ..Default::default() }), Energy::Kept),
        Row::new("thin dielectric", ThinDielectric::new(Default::default()), Energy::Kept),
        Row::new("mirror", Conductor::new(Default::default()), Energy::Kept),
        Row::new("gold", Conductor::new(gold), Energy::AtLeast(0.3)),
        Row::new("null", Null, Energy::Kept),
        Row::new("plastic", Plastic::new(Default::default()), Energy::AtLeast(0.4)),
        Row::new("white plastic", Plastic::new(white), Energy::AtLeast(0.98)),
        Row::new("white plastic, nonlinear", Plastic::new(PlasticParams { nonlinear: true, ..white }), Energy::AtLeast(0.98)),
        Row::new(
            "dense plastic",
            Plastic::new(PlasticParams { eta: 2.4, nonlinear: true, ..Default::default() }),
            Energy::AtLeast(0.2),
        ),
        Row::new("phong", Phong::new(Default::default()), Energy::AtLeast(0.0)),
        Row::new("phong, sharp", Phong::new(PhongParams { exponent: 2000.0, ..Default::default() }), Energy::AtLeast(0.0)),
        Row::new(
            "phong, flat, too bright",
            Phong::new(PhongParams { exponent: 0.0, diffuse_reflectance: Spectrum::ONE, specular_reflectance: Spectrum::ONE }),
            Energy::AtLeast(0.0),
        ),
    ]
}

fn rough() -> Vec<Row> {
    let mut rows = Vec::new();
    let gold = ConductorParams { eta: GOLD.0, k: GOLD.1, ..Default::default() };
    for ndf in [Ndf::Beckmann, Ndf::Ggx, Ndf::GgxCorrelated] {
        for sample_visible in [true, false] {
            for (alpha_u, alpha_v) in [(0.1, 0.1), (0.5, 0.5), (0.05, 0.3)] {
                let tag = format!("{ndf:?} {alpha_u} x {alpha_v}{}", if sample_visible { "" } else { ", all normals" });
                let metal =
                    |conductor| RoughConductor::new(RoughConductorParams { conductor, ndf, alpha_u, alpha_v, sample_visible });
                let glass = |eta| {
                    let dielectric = DielectricParams { eta, ..Default::default() };
                    RoughDielectric::new(RoughDielectricParams { dielectric, ndf, alpha_u, alpha_v, sample_visible })
                };
                rows.push(Row::new(format!("rough gold, {tag}"), metal(gold), Energy::AtLeast(0.1)));
                rows.push(Row::new(format!("rough mirror, {tag}"), metal(Default::default()), Energy::AtLeast(0.4)));
                rows.push(Row::new(format!("rough glass, {tag}"), glass(1.5), Energy::AtLeast(0.4)));
                if sample_visible {
                    rows.push(Row::new(format!("rough bubble, {tag}"), glass(1.0 / 1.8), Energy::AtLeast(0.4)));
                }
                if alpha_u == alpha_v {
                    let p = RoughPlasticParams { plastic: PlasticParams::default(), ndf, alpha: alpha_u, sample_visible };
                    rows.push(Row::new(
                        format!("rough plastic, {tag}"),
                        RoughPlastic::new(p, &p.transmittance()),
                        Energy::AtLeast(0.25),
                    ));
                }
            }
        }
    }
    let white = PlasticParams { diffuse_reflectance: Spectrum::ONE, nonlinear: true, ..Default::default() };
    let p = RoughPlasticParams { plastic: white, ..Default::default() };
    rows.push(Row::new("rough white plastic", RoughPlastic::new(p, &p.transmittance()), Energy::AtLeast(0.93)));
    let smooth = RoughConductorParams { alpha_u: 0.003, alpha_v: 0.003, ndf: Ndf::Ggx, ..Default::default() };
    rows.push(Row::new("nearly smooth mirror", RoughConductor::new(smooth), Energy::AtLeast(0.9)));
    rows
}

fn principled() -> Vec<Row> {
    let d = PrincipledParams { base_color: Spectrum::rgb(0.9, 0.5, 0.2), ..Default::default() };
    let solid = |name: &str, p| Row::new(format!("principled, {name}"), Principled::new(p), Energy::AtMost(2.0));
    let t = PrincipledThinParams { base_color: d.base_color, ..Default::default() };
    let thin = |name: &str, p| Row::new(format!("thin, {name}"), PrincipledThin::new(p), Energy::AtMost(2.0));
    vec![
        solid("default", d),
        solid("metal", PrincipledParams { metallic: 1.0, roughness: 0.3, anisotropic: 0.8, ..d }),
        solid("glass", PrincipledParams { spec_trans: 1.0, roughness: 0.4, eta: 1.5, ..d }),
        solid("bubble", PrincipledParams { spec_trans: 1.0, roughness: 0.5, eta: 0.7, ..d }),
        solid("cloth", PrincipledParams { sheen: 1.0, sheen_tint: 0.5, flatness: 0.7, roughness: 0.9, ..d }),
        solid("car paint", PrincipledParams { clearcoat: 1.0, clearcoat_gloss: 0.3, spec_tint: 0.7, ..d }),
        solid(
            "everything",
            PrincipledParams {
                roughness: 0.45,
                anisotropic: 0.4,
                metallic: 0.3,
                spec_trans: 0.5,
                eta: 1.4,
                spec_tint: 0.4,
                sheen: 0.6,
                sheen_tint: 0.3,
                flatness: 0.5,
                clearcoat: 0.8,
                clearcoat_gloss: 0.1,
                diffuse_reflectance_sampling_rate: 0.5,
                main_specular_sampling_rate: 1.5,
                clearcoat_sampling_rate: 2.0,
                ..d
            },
        ),
        thin("default", t),
        thin("paper", PrincipledThinParams { diff_trans: 1.0, flatness: 0.4, sheen: 0.5, sheen_tint: 1.0, ..t }),
        thin("pane", PrincipledThinParams { spec_trans: 1.0, roughness: 0.4, ..t }).one_way(),
        thin(
            "leaf",
            PrincipledThinParams {
                spec_trans: 0.4,
                diff_trans: 1.4,
                roughness: 0.6,
                anisotropic: 0.7,
                spec_tint: 0.6,
                eta: 1.3,
                ..t
            },
        )
        .bent(),
    ]
}

fn sums() -> Vec<Row> {
    let diffuse: Lobe = Diffuse::new(Default::default()).into();
    let metal: Lobe = RoughConductor::new(RoughConductorParams { alpha_u: 0.2, alpha_v: 0.1, ..Default::default() }).into();
    let glass: Lobe =
        RoughDielectric::new(RoughDielectricParams { ndf: Ndf::Ggx, alpha_u: 0.3, alpha_v: 0.3, ..Default::default() }).into();
    let plastic: Lobe = Plastic::new(Default::default()).into();
    let sum = |parts: &[(f32, Lobe<'static>)]| {
        let mut bsdf = Bsdf::new();
        for &(weight, lobe) in parts {
            assert!(bsdf.push(weight, lobe));
        }
        bsdf
    };
    let bump = Perturbation::from_normal(Vec3::new(0.4, -0.2, 0.9), true);
    let mut two_sided = sum(&[(0.5, diffuse), (0.5, metal)]);
    two_sided.append(1.0, &two_sided.flipped());
    vec![
        Row::new("blend", sum(&[(0.3, diffuse), (0.7, metal)]), Energy::AtLeast(0.2)),
        Row::new("blend of glass and diffuse", sum(&[(0.5, diffuse), (0.5, glass)]), Energy::AtLeast(0.2)),
        Row::new("mask", sum(&[(0.4, plastic), (0.6, Null.into())]), Energy::AtLeast(0.5)),
        Row::new(
            "blend of Dirac lobes",
            sum(&[(0.2, Dielectric::new(Default::default()).into()), (0.8, plastic)]),
            Energy::AtLeast(0.2),
        ),
        Row::new("scaled", sum(&[(1.0, metal)]).scaled(0.5), Energy::AtLeast(0.2)),
        Row::new("bumpy diffuse", sum(&[(1.0, diffuse)]).perturbed(&bump), Energy::AtMost(1.5)).bent(),
        Row::new("bumpy glass", sum(&[(1.0, glass)]).perturbed(&bump), Energy::AtMost(1.5)).bent(),
        Row::new("bumpy back", sum(&[(1.0, metal)]).perturbed(&bump).flipped(), Energy::AtMost(1.5)).bent(),
        Row::new("flipped and bumpy", sum(&[(1.0, metal)]).flipped().perturbed(&bump), Energy::AtMost(1.5)).bent(),
        Row::new("bumpy mask", sum(&[(0.5, diffuse), (0.2, metal), (0.3, Null.into())]).perturbed(&bump), Energy::AtMost(1.5))
            .bent(),
        Row::new("two sides", two_sided, Energy::AtLeast(0.2)),
    ]
}

fn coated() -> Vec<Row> {
    let coated = |name: &str, p: CoatedDiffuseParams, energy| Row::new(name, CoatedDiffuse::new(p, &p.coat()), energy);
    let d = CoatedDiffuseParams::default();
    let white = CoatedDiffuseParams { reflectance: Spectrum::ONE, thickness: 0.0, bounces: 1000, ..d };
    // Estimates are symmetric in the mean only: `bent`.
    let layered = |name: &str, p: LayeredParams, least| Row::new(name, Layered::new(p), Energy::AtLeast(least)).bent();
    let l = LayeredParams::default();
    let gold = |alpha: Option<[f32; 2]>| Ground::Metal(GOLD.0, GOLD.1, alpha);
    let sheet = |reflectance, transmittance| DiffuseTransmission::new(DiffuseTransmissionParams { reflectance, transmittance });
    vec![
        coated("coated diffuse", d, Energy::AtLeast(0.3)),
        coated("coated diffuse, thick", CoatedDiffuseParams { thickness: 0.5, eta: 1.8, ..d }, Energy::AtLeast(0.05)),
        coated("coated white", white, Energy::AtLeast(0.995)),
        coated("coated white, rough", CoatedDiffuseParams { alpha: Some(0.1), ..white }, Energy::AtLeast(0.9)),
        coated("coated diffuse, rough", CoatedDiffuseParams { alpha: Some(0.3), ..d }, Energy::AtLeast(0.2)),
        coated(
            "coated black, sharp",
            CoatedDiffuseParams { reflectance: Spectrum::ZERO, alpha: Some(0.01), ..d },
            Energy::AtLeast(0.01),
        ),
        layered("layered diffuse", l, 0.3),
        layered("layered diffuse, rough", LayeredParams { alpha: Some([0.1, 0.3]), ..l }, 0.2),
        layered("layered diffuse, hazy", LayeredParams { albedo: Spectrum::splat(0.8), thickness: 0.5, g: 0.4, ..l }, 0.2),
        layered("layered gold", LayeredParams { ground: gold(Some([0.2, 0.2])), ..l }, 0.2),
        layered("layered gold, both rough", LayeredParams { ground: gold(Some([0.3, 0.1])), alpha: Some([0.2, 0.2]), ..l }, 0.15),
        layered("layered gold, rough over a mirror", LayeredParams { ground: gold(None), alpha: Some([0.2, 0.2]), ..l }, 0.15),
        layered("layered mirror", LayeredParams { ground: gold(None), ..l }, 0.2),
        Row::new("diffuse transmission", sheet(Spectrum::rgb(0.3, 0.2, 0.1), Spectrum::rgb(0.2, 0.5, 0.3)), Energy::AtLeast(0.3)),
        Row::new("diffuse transmission, white", sheet(Spectrum::splat(0.25), Spectrum::splat(0.75)), Energy::Kept),
        Row::new("diffuse transmission, one way", sheet(Spectrum::ZERO, Spectrum::splat(0.5)), Energy::AtLeast(0.49)),
    ]
}

/// Fibres: what a wall sends out depends on who looks, so light and eye cannot change places.
fn hair() -> Vec<Row> {
    let row = |name: &str, p: HairParams, energy| Row::new(format!("hair, {name}"), Hair::new(p), energy).bent();
    let white = HairParams::default();
    let brown = HairParams { sigma_a: Spectrum::rgb(0.5, 0.9, 1.8), ..white };
    vec![
        row("white", white, Energy::Kept),
        row("white, rough", HairParams { beta_m: 0.9, beta_n: 0.8, alpha: 0.0, ..white }, Energy::Kept),
        row("white, smooth", HairParams { beta_m: 0.12, beta_n: 0.15, ..white }, Energy::Kept),
        row("brown", brown, Energy::AtLeast(0.05)),
        row("brown, uneven", HairParams { beta_m: 0.2, beta_n: 0.6, alpha: 5.0, eta: 1.3, ..brown }, Energy::AtLeast(0.05)),
    ]
}

/// Metals as a photometer would have seen them, coarsely: reciprocal as far as their tables are.
fn measured() -> Vec<Row> {
    const FEW: Resolution = Resolution { normals: 24, square: 12, theta: 6, phi: 7, part: 1.0 };
    static TABLES: LazyLock<[(&str, MeasuredTable); 4]> = LazyLock::new(|| {
        [
            ("isotropic", table([0.4, 0.4], &FEW)),
            ("brushed", table([0.6, 0.3], &FEW)),
            ("brushed, half the circle", table([0.6, 0.3], &Resolution { part: 0.5, ..FEW })),
            ("brushed, a quarter", table([0.6, 0.3], &Resolution { part: 0.25, phi: 4, ..FEW })),
        ]
    });
    let row = |(name, table): &'static (&str, MeasuredTable)| {
        Row::new(format!("measured, {name}"), Measured::new(table, &Wavelengths::Rgb), Energy::AtLeast(0.2)).bent()
    };
    TABLES.iter().map(row).collect()
}

/// All of them.
pub fn rows() -> Vec<Row> {
    [smooth(), rough(), principled(), coated(), hair(), measured(), sums()].into_iter().flatten().collect()
}
