//! Many at once give the bits of each alone, in any company.

use crate::{directions, models};
use etendue_bsdf::{Bsdf, Draw, Lobe, Microfacets, Ndf, Pair, Perturbation, Scatter, Together, lobes::*};
use etendue_check::rng;
use etendue_numerics::{Vec3, warp::square_to_sphere};

/// All models: as they are, upside down, and on bent normals.
fn surfaces() -> Vec<Bsdf<'static>> {
    let bent = Perturbation::from_normal(Vec3::new(0.3, -0.2, 1.0), true);
    let mut list: Vec<Bsdf> =
        models::rows().iter().flat_map(|row| [row.bsdf, row.bsdf.flipped().scaled(0.7), row.bsdf.perturbed(&bent)]).collect();
    for alpha_u in [Microfacets::MIN_ALPHA, 0.02, 0.3, 1.0] {
        for ndf in Ndf::ALL {
            list.push(Lobe::from(RoughConductor::new(RoughConductorParams { ndf, alpha_u, ..Default::default() })).into());
            list.push(Lobe::from(RoughDielectric::new(RoughDielectricParams { ndf, alpha_u, ..Default::default() })).into());
        }
    }
    list
}

#[test]
fn many_at_once_are_each_alone() {
    let surfaces = surfaces();
    let (mut pairs, mut draws, mut numbers) = (Vec::new(), Vec::new(), rng(11));
    for k in 0..40_000 {
        let bsdf = &surfaces[numbers.below(surfaces.len())];
        let wo = if k % 3 == 0 { directions()[k % 6] } else { square_to_sphere(numbers.u2()) };
        let wi = square_to_sphere(numbers.u2());
        pairs.push(Pair { bsdf, wo, wi });
        draws.push(Draw { bsdf, wo, u1: numbers.u1(), u2: numbers.u2() });
    }
    let (mut together, mut evaluated, mut sampled) = (Together::default(), Vec::new(), Vec::new());
    for some in [1, 17, 64, 1000] {
        for (pairs, draws) in pairs.chunks(some).zip(draws.chunks(some)).step_by(64 / some.min(64)) {
            together.eval_pdf(pairs, &mut evaluated);
            for (q, found) in pairs.iter().zip(&evaluated) {
                assert_eq!(*found, q.bsdf.eval_pdf(q.wo, q.wi), "{q:?}");
            }
            together.sample(draws, &mut sampled);
            for (q, found) in draws.iter().zip(&sampled) {
                assert_eq!(*found, q.bsdf.sample(q.wo, q.u1, q.u2), "{q:?}");
            }
        }
    }
}
