//! `weight`, `pdf`, `eval`, `eta` and `event` of one sample tell the same story.

use crate::{directions, models};
use etendue_bsdf::{BsdfSample, Event, Scatter};
use etendue_check::rng;
use etendue_numerics::{Pdf, Vec2};

#[test]
fn a_sample_agrees_with_eval_and_pdf() {
    for row in models::rows() {
        let f = &row.bsdf;
        let mut numbers = rng(7);
        for wo in directions() {
            for _ in 0..200 {
                let Some(s) = f.sample(wo, numbers.u1(), numbers.u2()) else { continue };
                let what = || format!("{} from {wo}: {s:?}", row.name);
                let transmits = s.event.transmits();
                assert_eq!(s.wi.z * wo.z < 0.0, transmits, "side, {}", what());
                assert!((s.wi.length() - 1.0).abs() < 1e-4, "length, {}", what());
                assert!(s.eta > 0.0 && (transmits || s.eta == 1.0), "eta, {}", what());
                assert!(f.events().intersects(s.event), "event, {}", what());
                match s.pdf {
                    Pdf::Delta(p) => {
                        assert!(p > 0.0 && p <= 1.0 && s.event.has_delta(), "{}", what());
                        assert!(!s.event.has_null() || s.wi == -wo, "{}", what());
                    }
                    Pdf::SolidAngle(p) => {
                        assert!(!s.event.has_delta() && s.event.has_smooth(), "{}", what());
                        // Half vectors found anew from two f32 directions are off by about 1e-7/alpha.
                        let tolerance = 2e-3 + 2e-5 / f.roughness().max(1e-3);
                        let near = |a: f32, b: f32| (a - b).abs() <= tolerance * a.abs().max(b.abs()) + 1e-6;
                        assert!(near(p, f.pdf(wo, s.wi)), "pdf {}, {}", f.pdf(wo, s.wi), what());
                        assert_eq!(f.eval_pdf(wo, s.wi), (f.eval(wo, s.wi), f.pdf(wo, s.wi)), "both, {}", what());
                        let weight = f.eval(wo, s.wi) * (s.wi.z.abs() / p);
                        assert!((0..3).all(|k| near(weight[k], s.weight[k])), "weight {weight:?}, {}", what());
                        if transmits {
                            assert!((f.relative_eta(wo, s.wi) - s.eta).abs() < 1e-3, "{}", what());
                        }
                    }
                }
            }
        }
    }
}

/// What `sample` draws by chance and `diracs` hands over whole is the same light: each drawn direction is among those handed over, and with
/// u1 on a fine comb Σ weight · p over the draws of a direction is its share of the whole.
#[test]
fn all_dirac_directions_together_are_what_is_sampled() {
    const COMB: u32 = 4096;
    for row in models::rows() {
        for wo in directions() {
            let mut whole: Vec<(BsdfSample, f64)> = Vec::new();
            row.bsdf.diracs(wo, &mut |s| whole.push((s, 0.0)));
            for s in (0..COMB).filter_map(|i| row.bsdf.sample(wo, (i as f32 + 0.5) / COMB as f32, Vec2::splat(0.5))) {
                if !s.pdf.is_delta() {
                    continue;
                }
                let known = whole.iter_mut().find(|(d, _)| d.wi == s.wi && d.event == s.event && d.eta == s.eta);
                let Some((_, sum)) = known else { panic!("{} from {wo}: {s:?} is not handed over", row.name) };
                *sum += f64::from(s.weight[0]) / f64::from(COMB);
            }
            // Lobes with the same direction are told apart by nobody.
            for (s, _) in &whole {
                let same = || whole.iter().filter(|(d, _)| d.wi == s.wi && d.event == s.event);
                let (want, got): (f64, f64) = (same().map(|(d, _)| f64::from(d.weight[0])).sum(), same().map(|(_, x)| x).sum());
                assert!(
                    (want - got).abs() < 4.0 / f64::from(COMB) * want.max(1.0) + 1e-5,
                    "{} from {wo}: {want} {got} {s:?}",
                    row.name
                );
                assert!(s.pdf == Pdf::Delta(1.0) && s.event.has_delta(), "{}", row.name);
            }
        }
    }
}

#[test]
fn one_sided_models_are_black_from_behind() {
    for row in models::rows()
        .into_iter()
        .filter(|r| !r.bsdf.events().transmits() && !r.bent && r.name != "two sides" && !r.name.starts_with("thin"))
    {
        let mut numbers = rng(8);
        for wo in directions().into_iter().filter(|w| w.z < 0.0) {
            for wi in directions() {
                assert!(row.bsdf.eval(wo, wi).is_zero() && row.bsdf.pdf(wo, wi) == 0.0, "{}", row.name);
                assert!(row.bsdf.sample(wo, numbers.u1(), numbers.u2()).is_none(), "{}", row.name);
            }
        }
    }
}

#[test]
fn events_name_what_a_surface_can_do() {
    let of = |name: &str| models::rows().into_iter().find(|r| r.name == name).map(|r| r.bsdf.events());
    let e = |list: &[Event]| Some(list.iter().fold(Event::NONE, |a, b| a | *b));
    assert_eq!(of("diffuse"), e(&[Event::REFLECT, Event::DIFFUSE]));
    assert_eq!(of("dielectric"), e(&[Event::REFLECT, Event::TRANSMIT, Event::DELTA]));
    assert_eq!(of("mask"), e(&[Event::REFLECT, Event::DIFFUSE, Event::DELTA, Event::NULL]));
}

#[test]
fn masks_and_panes_are_transparent() {
    for row in models::rows() {
        let t = row.bsdf.transparency(directions()[1])[0];
        let expected = match row.name.as_str() {
            "null" => 1.0,
            "mask" => 0.6,
            "bumpy mask" => 0.3,
            // R = 0.0437 at cosθ = 0.8, T' = (1 - R)/(1 + R).
            "thin dielectric" => 0.9149,
            _ => 0.0,
        };
        assert!((t - expected).abs() < 1e-3, "{}: {t}", row.name);
    }
}
